//! An eddy-current brake: the electromechanical damper that replaced oil.

use crate::{Mechanism, Reaction, Relative};
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};
use softdock_control::range::{SettingsError, in_range};

/// `F = 2 F_m (v/v_k)/(1 + (v/v_k)²)` against the motion along x while J is beyond P: the force of an
/// induction brake, largest (F_m) at v_k and falling beyond.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EddyCurrent {
    /// F_m, N.
    pub largest_force_n: f64,
    /// v_k, m/s.
    pub critical_speed_m_s: f64,
}

impl EddyCurrent {
    pub(crate) fn validate(&self) -> Result<(), SettingsError> {
        in_range("largest_force_n", self.largest_force_n, 0.0, 1e6)?;
        in_range("critical_speed_m_s", self.critical_speed_m_s, 1e-4, 10.0)
    }
}

impl Mechanism for EddyCurrent {
    fn reaction(&self, at: &Relative) -> Reaction {
        let position = at.p_from_j.translation.vector;
        if position.x <= 0.0 {
            return Reaction::none();
        }
        let ratio = at.twist.linear.x / self.critical_speed_m_s;
        let drag = 2.0 * self.largest_force_n * ratio / (1.0 + ratio * ratio);
        Reaction {
            wrench: at.push(&position, &Vector3::new(-drag, 0.0, 0.0)),
            stored_j: 0.0,
            loss_w: drag * at.twist.linear.x,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::EnergyTracked;

    /// `m dv/dx = −2 F_m/v_k/(1 + (v/v_k)²)`, so `v + v³/(3 v_k²)` falls linearly with the distance.
    #[test]
    fn speed_falls_over_the_way_by_the_closed_form() {
        let brake = EddyCurrent {
            largest_force_n: 400.0,
            critical_speed_m_s: 0.03,
        };
        let (mass, h) = (5000.0, 1e-5);
        let first = 0.1;
        let (mut x, mut v) = (1e-9, first);
        let mut brake = EnergyTracked::new(brake);
        let mut force = brake
            .mechanism
            .reaction(&Relative::along_x(x, v))
            .wrench
            .force
            .x;
        for _ in 0..100_000 {
            v += force / mass * h;
            x += v * h;
            force = brake.advance(&Relative::along_x(x, v), h).wrench.force.x;
        }
        let balance = brake.balance();
        let charge = |v: f64| v + v.powi(3) / (3.0 * 0.03 * 0.03);
        let expected = charge(first) - 2.0 * 400.0 / (0.03 * mass) * x;
        assert!((charge(v) / expected - 1.0).abs() < 1e-3, "{v} {x}");
        assert!(
            balance.imbalance_j().abs() < 1e-5 * balance.work_j,
            "{balance:?}"
        );
        let gone = 0.5 * mass * (first * first - v * v);
        assert!((balance.dissipated_j / gone - 1.0).abs() < 1e-4);
    }

    #[test]
    fn drag_is_largest_at_the_critical_speed() {
        let brake = EddyCurrent {
            largest_force_n: 400.0,
            critical_speed_m_s: 0.03,
        };
        let drag = |v: f64| -brake.reaction(&Relative::along_x(0.01, v)).wrench.force.x;
        assert!((drag(0.03) - 400.0).abs() < 1e-9 && drag(0.02) < 400.0 && drag(0.05) < 400.0);
        assert!((drag(-0.03) + 400.0).abs() < 1e-9);
        assert_eq!(
            brake.reaction(&Relative::along_x(-0.01, 0.03)),
            Reaction::none()
        );
    }
}
