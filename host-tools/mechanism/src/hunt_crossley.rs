//! Two rounded bodies: Hertz's contact, with the loss of Hunt and Crossley (1975).

use crate::{Mechanism, Reaction, Relative};
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};
use softdock_control::range::{SettingsError, in_range};

/// `F = K x^1.5 (1 + α dx/dt)`, never a pull. Without loss a bounce lasts `2.9432 (5 m/(4 K))^0.4 v^-0.2`. With loss the
/// speeds before (v) and after (v') obey `αv − ln(1 + αv) = −αv' − ln(1 − αv')`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HuntCrossley {
    /// K, N/m^1.5: 4/3 E* √R for spheres.
    pub stiffness_n_per_m15: f64,
    /// α, s/m.
    #[serde(default)]
    pub loss_s_per_m: f64,
}

impl HuntCrossley {
    pub(crate) fn validate(&self) -> Result<(), SettingsError> {
        in_range("stiffness_n_per_m15", self.stiffness_n_per_m15, 0.0, 1e12)?;
        in_range("loss_s_per_m", self.loss_s_per_m, 0.0, 100.0)
    }
}

impl Mechanism for HuntCrossley {
    fn reaction(&self, at: &Relative) -> Reaction {
        let position = at.p_from_j.translation.vector;
        let (depth, rate) = (position.x, at.twist.linear.x);
        if depth <= 0.0 {
            return Reaction::none();
        }
        let elastic = self.stiffness_n_per_m15 * depth * nalgebra::ComplexField::sqrt(depth);
        let push = (elastic * (1.0 + self.loss_s_per_m * rate)).max(0.0);
        Reaction {
            wrench: at.push(&position, &Vector3::new(-push, 0.0, 0.0)),
            stored_j: 0.4 * elastic * depth,
            loss_w: (push - elastic) * rate,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::bounce;

    const MASS_KG: f64 = 500.0;
    const SPEED_M_S: f64 = 0.05;

    fn contact(loss_s_per_m: f64) -> HuntCrossley {
        HuntCrossley {
            stiffness_n_per_m15: 3e6,
            loss_s_per_m,
        }
    }

    #[test]
    fn hertz_gives_everything_back_in_his_time() {
        let bounce = bounce(contact(0.0), MASS_KG, SPEED_M_S, 2e-6);
        let expected_s = 2.943_2 * (5.0 * MASS_KG / (4.0 * 3e6)).powf(0.4) * SPEED_M_S.powf(-0.2);
        assert!(
            (bounce.duration_s / expected_s - 1.0).abs() < 1e-4,
            "{bounce:?} {expected_s}"
        );
        assert!((bounce.restitution - 1.0).abs() < 1e-6, "{bounce:?}");
        bounce.assert_balanced(MASS_KG, SPEED_M_S, 1e-6);
    }

    #[test]
    fn speeds_obey_the_closed_form_of_hunt_and_crossley() {
        for loss in [0.2, 2.0, 10.0] {
            let bounce = bounce(contact(loss), MASS_KG, SPEED_M_S, 2e-6);
            let (x, y) = (loss * SPEED_M_S, loss * SPEED_M_S * bounce.restitution);
            let (into, out) = (x - x.ln_1p(), -y - (-y).ln_1p());
            assert!((into / out - 1.0).abs() < 1e-3, "{loss}: {into} {out}");
            bounce.assert_balanced(MASS_KG, SPEED_M_S, 1e-4);
        }
        // For little loss e = 1 - 2/3 α v.
        let little = bounce(contact(0.2), MASS_KG, SPEED_M_S, 2e-6);
        assert!((1.0 - little.restitution - 0.2 * SPEED_M_S * 2.0 / 3.0).abs() < 1e-4);
    }
}
