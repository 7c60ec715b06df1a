//! What the force/torque sensor adds to the contact wrench, and how it reads it: weight and inertia
//! of the tool, then mounting, cross-talk, gain, zero, filter, range, resolution and transmission.
//!
//! The sensor reads the **load's reaction**: `reading = contact + m g − m a_com`, everything in the
//! sensor's frame S, torques about its origin. [`tool_gravity`] and [`gauge_quantisation`] are
//! building blocks, not effects.

use super::Parameter;
use crate::frames::Wrench;
use crate::range::{SettingsError, all_within};
use crate::scalar::Scalar;

pub mod base_tilt;
pub mod ft_bias;
pub mod ft_bias_drift;
pub mod ft_crosstalk;
pub mod ft_dropout;
pub mod ft_latency;
pub mod ft_low_pass;
pub mod ft_mounting;
pub mod ft_quantisation;
pub mod ft_saturation;
pub mod ft_scale;
pub mod gauge_quantisation;
pub mod tool_com_error;
pub mod tool_gravity;
pub mod tool_inertia;
pub mod tool_mass_error;

/// The six components of an offset, N and N·m.
const OFFSET: &[Parameter] = &[
    Parameter::new("fx_n", "N", -100.0, 100.0),
    Parameter::new("fy_n", "N", -100.0, 100.0),
    Parameter::new("fz_n", "N", -100.0, 100.0),
    Parameter::new("tx_n_m", "N m", -20.0, 20.0),
    Parameter::new("ty_n_m", "N m", -20.0, 20.0),
    Parameter::new("tz_n_m", "N m", -20.0, 20.0),
];

/// An offset, checked: each component within ±1e5 N or N·m.
fn offset<S: Scalar>(components: &[f64; 6]) -> Result<Wrench<S>, SettingsError> {
    all_within("offset", components, 1e5)?;
    Ok(Wrench::of(components))
}
