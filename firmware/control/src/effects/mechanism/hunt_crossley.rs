//! Contact damping that grows with penetration.

use crate::effects::{Effect, Group, Naming, Parameter};
use crate::range::{SettingsError, in_range};
use crate::scalar::Scalar;
use nalgebra::ComplexField;

/// Catalogue entry.
pub const EFFECT: Effect = Effect {
    id: "hunt_crossley",
    title: "Hunt-Crossley damping",
    summary: "the contact damps in proportion to penetration and its speed",
    group: Group::Mechanism,
    naming: Naming::Cause,
    equation: "F = max(0, nominal push + damping_n_s_per_m2 pen^exponent dpen/dt); the unit holds for exponent 1",
    source: "Hunt and Crossley 1975 (J. Appl. Mech. 42)",
    signature: "force against penetration opens to a loop that is closed at both ends: no jump at touch, no pull \
                at release",
    typical: "restitution falls by 0.1 to 0.5 per m/s; exponent 1 for flat faces, 1.5 for spheres",
    parameters: &[
        Parameter::new("damping_n_s_per_m2", "N s/m^2", 0.0, 1e9),
        Parameter::new("exponent", "-", 0.5, 2.0),
    ],
    confused_with: &["contact_damping", "contact_cubic", "guide_viscous"],
    tell_apart: "bounces at two speeds: the restitution falls with speed; linear damping keeps it and makes the \
                 force jump at touch",
};

/// How the damping grows with penetration; the usual exponents need no power function.
#[derive(Clone, Copy, Debug)]
enum Growth {
    Linear,
    Hertz,
    Power(f64),
}

/// Damper that grows with penetration.
#[derive(Clone, Copy, Debug)]
pub struct HuntCrossley<S: Scalar> {
    damping: S,
    growth: Growth,
}

impl<S: Scalar> HuntCrossley<S> {
    /// `damping` 0 to 1e12 N·s/m^(1 + exponent) (fixed point saturates above 1e9), `exponent`
    /// 0.1 to 4.
    pub fn new(damping: f64, exponent: f64) -> Result<Self, SettingsError> {
        in_range("damping_n_s_per_m2", damping, 0.0, 1e12)?;
        in_range("exponent", exponent, 0.1, 4.0)?;
        let growth = if exponent == 1.0 {
            Growth::Linear
        } else if exponent == 1.5 {
            Growth::Hertz
        } else {
            Growth::Power(exponent)
        };
        Ok(Self {
            damping: S::of(damping),
            growth,
        })
    }

    /// Push (N) in addition to that of the spring, at a penetration (m) that grows by `rate`
    /// (m/s); 0 outside.
    pub fn force(&self, penetration: S, rate: S) -> S {
        if penetration <= S::zero() {
            return S::zero();
        }
        let grown = match self.growth {
            Growth::Linear => penetration,
            Growth::Hertz => penetration * penetration.sqrt(),
            Growth::Power(n) => S::of(power(penetration.get(), n)),
        };
        self.damping * grown * rate
    }
}

/// `base` to the power `exponent`, in f64 for every scalar.
#[expect(
    clippy::disallowed_methods,
    reason = "of an f64, which has it; fixed point does not"
)]
fn power(base: f64, exponent: f64) -> f64 {
    ComplexField::powf(base, exponent)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scalar::Fixed;

    fn known_pushes<S: Scalar>() {
        for (exponent, expected) in [(1.0, 200.0), (1.5, 20.0), (2.0, 2.0)] {
            let damper = HuntCrossley::<S>::new(4e5, exponent).unwrap();
            let got = damper.force(S::of(0.01), S::of(0.05)).get();
            assert!(
                (got - expected).abs() < 1e-4 * expected,
                "{exponent}: {got}"
            );
            assert_eq!(damper.force(S::of(-0.01), S::of(0.05)).get(), 0.0);
        }
    }

    #[test]
    fn ten_millimetres_deep_at_fifty_per_second() {
        known_pushes::<f64>();
        known_pushes::<Fixed>();
    }
}
