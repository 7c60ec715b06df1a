//! Forces on the moving side: of its guide, of the contact of its tip with a wall, of its docking mechanism, of the cables that
//! it drags, and of the manipulator that would hold the real spacecraft.

use super::Parameter;

/// Speed over which a dry friction changes its sign. The range covers machines in any unit of length; the values that are tried
/// follow from the speeds of the logs.
const SMOOTHING: Parameter = Parameter::new("smoothing_speed_m_s", "m/s", 0.0, 1e3)
    .form_size(&[0.0, 3e-4, 8e-4, 2e-3, 5e-3], 0.0);

/// Distance over which a dry friction builds up after a reversal.
const PRESLIDING: Parameter = Parameter::new("presliding_m", "m", 0.0, 5e-4)
    .form_size(&[0.0, 2e-6, 5e-6, 1e-5, 2e-5, 5e-5], 0.0);

/// Point of action of the force; at the sensor's origin it causes no torque reading.
pub const ACTS_AT: Parameter = Parameter::choice(
    "acts_at",
    &["at the flange M", "at the tip", "at the sensor's origin"],
);

/// Position at which a spring rests.
pub const ABOUT_START: Parameter = Parameter::choice(
    "about_start",
    &["rests at the origin of C", "rests at the first position"],
);

pub mod bearing_gravity;
pub mod bearing_inertia;
pub mod cable_stiffness;
pub mod contact_coulomb;
pub mod contact_cubic;
pub mod contact_damping;
pub mod contact_deadzone;
pub mod contact_eddy_current;
pub mod contact_hertz;
pub mod contact_preload;
pub mod contact_second_stage;
pub mod contact_stiffness;
pub mod docking_friction;
pub mod docking_latch_play;
pub mod docking_latch_slip;
pub mod docking_leg;
pub mod docking_preload;
pub mod docking_stiffness;
pub mod guide_asymmetry;
pub mod guide_coulomb;
pub mod guide_hysteresis;
pub mod guide_offset;
pub mod guide_stribeck;
pub mod guide_viscous;
pub mod hunt_crossley;
pub mod manipulator_resistance;
pub mod wall_position;

#[cfg(test)]
mod tests {
    use softdock_mechanism::{Kind, ProbeCone};

    /// A probe in a cone with a socket, changed by `change`.
    pub(super) fn probe(change: impl FnOnce(&mut Kind)) -> ProbeCone {
        let mut kind: Kind = serde_json::from_str(
            r#"{"probe_cone": {"half_angle_rad": 0.9, "mouth_radius_m": 0.25, "head_radius_m": 0.04,
                "surface": {"stiffness_n_per_m": 2e4, "friction_coefficient": 0.25},
                "socket": {"capture_depth_m": 0.006, "capture_radius_m": 0.008,
                           "latch_stiffness_n_per_m": 5e4}}}"#,
        )
        .unwrap();
        change(&mut kind);
        match kind {
            Kind::ProbeCone(probe) => probe,
            _ => panic!("another kind"),
        }
    }
}
