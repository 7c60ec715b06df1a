//! Stiffness of a contact that differs from the model.

use crate::effects::{Effect, Group, Naming, Parameter};
use crate::range::{SettingsError, in_range};
use crate::scalar::Scalar;

/// Catalogue entry.
pub const EFFECT: Effect = Effect {
    id: "contact_stiffness",
    title: "Stiffness of the contact",
    summary: "the contact's spring is stiffer or softer than nominal",
    group: Group::Mechanism,
    naming: Naming::Cause,
    equation: "F = nominal push + stiffness_error_n_per_m pen",
    source: "Hooke's law",
    signature: "force against penetration is a straight line of another slope; contact takes another time",
    typical: "1 to 10 % of the nominal stiffness; more when the rig's own compliance is left out",
    parameters: &[Parameter::new("stiffness_error_n_per_m", "N/m", -1e8, 1e8)],
    confused_with: &["contact_cubic", "contact_deadzone", "ft_scale"],
    tell_apart: "bounces of two depths: a wrong slope errs in proportion to depth, stiffening with its cube; a \
                 wrong gain of the sensor also shows in the weight of the tool when it is tilted",
};

/// Deviation of a linear spring.
#[derive(Clone, Copy, Debug)]
pub struct StiffnessError<S: Scalar> {
    stiffness: S,
}

impl<S: Scalar> StiffnessError<S> {
    /// `stiffness_error_n_per_m` within ±1e8 N/m.
    pub fn new(stiffness_error_n_per_m: f64) -> Result<Self, SettingsError> {
        in_range(
            "stiffness_error_n_per_m",
            stiffness_error_n_per_m,
            -1e8,
            1e8,
        )?;
        Ok(Self {
            stiffness: S::of(stiffness_error_n_per_m),
        })
    }

    /// Push (N) in addition to the nominal one, at a penetration (m); 0 outside.
    pub fn force(&self, penetration: S) -> S {
        self.stiffness * penetration.max(S::zero())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn another_slope() {
        let softer = StiffnessError::<f64>::new(-400.0).unwrap();
        assert_eq!(
            [-1.0, 0.0, 0.25].map(|p| softer.force(p)),
            [0.0, 0.0, -100.0]
        );
    }
}
