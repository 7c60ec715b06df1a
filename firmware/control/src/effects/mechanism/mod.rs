//! Forces on the moving side: of the guide it runs on, of the contact of its tip with a wall, of
//! the cables that it drags, and of the manipulator that would hold the real spacecraft.
//!
//! [`plane_contact`] and [`lever`] are building blocks, not effects.

pub mod cable_stiffness;
pub mod contact_coulomb;
pub mod contact_cubic;
pub mod contact_damping;
pub mod contact_deadzone;
pub mod contact_stiffness;
pub mod guide_asymmetry;
pub mod guide_coulomb;
pub mod guide_hysteresis;
pub mod guide_offset;
pub mod guide_stribeck;
pub mod guide_viscous;
pub mod hunt_crossley;
pub mod lever;
pub mod manipulator_resistance;
pub mod plane_contact;
pub mod wall_position;
