//! Forces of the docking mechanism on the moving craft, evaluated at a tip point on it.

pub mod coulomb_friction;
pub mod lever;
pub mod plane_contact;
