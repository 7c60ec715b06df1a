//! What the force/torque sensor adds to the contact wrench, and how it reads it: weight and inertia of the tool, then mounting,
//! cross-talk, gain, zero, filter, range, resolution and transmission; or the gain of a drive whose command is recorded instead
//! of a reading.
//!
//! The sensor reads the **load's reaction**: `reading = contact + m g − m a_com`, everything in the
//! sensor's frame S, torques about its origin.

use super::Parameter;
use softdock_control::frames::Wrench;

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
pub mod input_gain;
pub mod tool;
pub mod tool_com_error;
pub mod tool_inertia;
pub mod tool_mass_error;

/// Whether gain and cross-talk act on the zero as well.
const WITH_ZERO: Parameter =
    Parameter::choice("with_zero", &["of the load alone", "of load and zero"]);

/// The first six values as a wrench, N and N·m.
fn six(p: &[f64]) -> Wrench<f64> {
    Wrench::of(&std::array::from_fn(|axis| p[axis]))
}
