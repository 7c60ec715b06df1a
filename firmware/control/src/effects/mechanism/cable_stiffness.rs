//! Pull of a cable bundle on the moving side.

use crate::effects::{Effect, Group, Naming, Parameter};
use crate::range::{SettingsError, in_range};
use crate::scalar::Scalar;

/// Catalogue entry.
pub const EFFECT: Effect = Effect {
    id: "cable_stiffness",
    title: "Pull of the cables",
    summary: "a cable bundle pulls the moving side back in proportion to its displacement",
    group: Group::Mechanism,
    naming: Naming::Cause,
    equation: "F = -stiffness_n_per_m (p - p0), p0: position at the start",
    source: "Hooke's law; hose packages of robots",
    signature: "a force proportional to position, everywhere, not only in contact",
    typical: "10 to 200 N/m for sensor and hose bundles",
    parameters: &[Parameter::new("stiffness_n_per_m", "N/m", 0.0, 1e5)],
    confused_with: &[
        "manipulator_resistance",
        "guide_offset",
        "contact_stiffness",
        "ft_bias_drift",
    ],
    tell_apart: "slow jogs to several positions with a stop at each: the force follows position and not time; \
                 unplug or re-route the bundle and it changes",
};

/// Spring that pulls back to where the motion began.
#[derive(Clone, Copy, Debug)]
pub struct CableSpring<S: Scalar> {
    stiffness: S,
}

impl<S: Scalar> CableSpring<S> {
    /// `stiffness_n_per_m` 0 to 1e6 N/m.
    pub fn new(stiffness_n_per_m: f64) -> Result<Self, SettingsError> {
        in_range("stiffness_n_per_m", stiffness_n_per_m, 0.0, 1e6)?;
        Ok(Self {
            stiffness: S::of(stiffness_n_per_m),
        })
    }

    /// Force (N) at a displacement (m) from the start.
    pub fn force(&self, displacement: S) -> S {
        -self.stiffness * displacement
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_pulls_back() {
        let cable = CableSpring::<f64>::new(40.0).unwrap();
        assert_eq!(
            [-0.5, 0.0, 0.25].map(|d| cable.force(d)),
            [20.0, 0.0, -10.0]
        );
        assert!(CableSpring::<f64>::new(-40.0).is_err());
    }
}
