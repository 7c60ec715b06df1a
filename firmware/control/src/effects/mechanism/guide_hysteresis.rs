//! Hysteresis of a guide: friction that builds up over a distance.

use crate::effects::{Effect, Group, Naming, Parameter, sign};
use crate::range::{SettingsError, in_range};
use crate::scalar::Scalar;

/// Catalogue entry.
pub const EFFECT: Effect = Effect {
    id: "guide_hysteresis",
    title: "Hysteresis of the guide",
    summary: "friction that builds up over a distance after each reversal",
    group: Group::Mechanism,
    naming: Naming::Shape,
    equation: "F = -force_n z, displacement_m dz/dx = 1 - |z| while z pushes against the motion, else 1 \
               (Bouc-Wen with A = 1, beta = gamma = 1/2, n = 1)",
    source: "Bouc 1967, Wen 1976 (J. Eng. Mech. 102); presliding of rolling guides",
    signature: "force against position is a loop with rounded corners; its width does not depend on speed",
    typical: "presliding over 0.01 to 0.2 mm in a rolling guide; millimetres in hoses and rubber",
    parameters: &[
        Parameter::new("force_n", "N", 0.0, 1e4),
        Parameter::new("displacement_m", "m", 1e-5, 0.01),
    ],
    confused_with: &[
        "guide_coulomb",
        "guide_stribeck",
        "cable_stiffness",
        "backlash",
    ],
    tell_apart: "small jogs of growing length: dry friction switches at once, hysteresis needs the same distance \
                 after each reversal; which mechanism lies behind the loop only a look at the rig can tell",
};

/// Hysteresis along one axis.
#[derive(Clone, Copy, Debug)]
pub struct BoucWen<S: Scalar> {
    force_n: S,
    inverse_displacement: S,
    /// Share of the full force, −1 to 1.
    share: S,
}

impl<S: Scalar> BoucWen<S> {
    /// Relaxed. `force_n` 0 to 1e5 N, `displacement_m` 1e-6 to 1 m.
    pub fn new(force_n: f64, displacement_m: f64) -> Result<Self, SettingsError> {
        in_range("force_n", force_n, 0.0, 1e5)?;
        in_range("displacement_m", displacement_m, 1e-6, 1.0)?;
        Ok(Self {
            force_n: S::of(force_n),
            inverse_displacement: S::of(1.0 / displacement_m),
            share: S::zero(),
        })
    }

    /// Moves by a displacement (m); returns the force (N) at its end.
    ///
    /// Relaxing is linear and exact. Building up is integrated by the trapezoidal rule, which is
    /// exact to the third order of the displacement over `displacement_m`.
    pub fn advance(&mut self, displacement_step: S) -> S {
        let direction = sign(displacement_step);
        let along = self.share * direction;
        let mut travel = (displacement_step * self.inverse_displacement).abs();
        let mut built = along;
        if along < S::zero() {
            built = (along + travel).min(S::zero());
            travel = (travel + along).max(S::zero());
        }
        if travel > S::zero() {
            let half = travel * S::of(0.5);
            let next = (built * (S::one() - half) + travel) / (S::one() + half);
            built = next.min(S::one());
        }
        if direction != S::zero() {
            self.share = built * direction;
        }
        -self.force_n * self.share
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scalar::Fixed;

    /// From relaxed: z = 1 − exp(−x/x0); back: linear to zero, then again the exponential.
    fn loop_of<S: Scalar>(tolerance: f64) {
        let (force, length, step) = (5.0, 0.002, 0.00002);
        let mut guide = BoucWen::<S>::new(force, length).unwrap();
        for k in 1..=300 {
            let expected = -force * (1.0 - (-step * f64::from(k) / length).exp());
            assert!((guide.advance(S::of(step)).get() - expected).abs() < tolerance);
        }
        let top = 1.0 - (-3.0_f64).exp();
        for k in 1..=300 {
            let back = step * f64::from(k) / length;
            let z = if back < top {
                top - back
            } else {
                (top - back).exp() - 1.0
            };
            assert!((guide.advance(S::of(-step)).get() + force * z).abs() < tolerance);
        }
    }

    #[test]
    fn forth_and_back() {
        loop_of::<f64>(1e-4);
        loop_of::<Fixed>(1e-3);
    }

    #[test]
    fn a_large_step_saturates_and_no_step_keeps_the_force() {
        let mut guide = BoucWen::<f64>::new(5.0, 0.001).unwrap();
        assert_eq!([1.0, 0.0].map(|d| guide.advance(d)), [-5.0, -5.0]);
    }
}
