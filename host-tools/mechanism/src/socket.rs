//! A socket whose latches catch the head of a probe: capture.

use crate::{Mechanism, Reaction, Relative};
use nalgebra::{Translation3, Vector3};
use serde::{Deserialize, Serialize};
use softdock_control::frames::Pose;
use softdock_control::range::{SettingsError, in_range};

/// Latches that close around J when it passes the plane of capture near the axis. From then on they hold J where it was
/// caught, elastically with damping and a play. Beyond their load limit they slip. A separate spring and damper (the limiter)
/// acts on rotations away from the orientation at capture.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Socket {
    /// Distance of the plane of capture before the seat, m.
    pub capture_depth_m: f64,
    /// J is caught within this distance from the axis, m.
    pub capture_radius_m: f64,
    /// Smallest closing speed at which the latches close, m/s.
    #[serde(default)]
    pub capture_speed_m_s: f64,
    /// Number of latches.
    #[serde(default = "four")]
    pub latches: u8,
    /// Stiffness of each latch, N/m.
    pub latch_stiffness_n_per_m: f64,
    /// Damping of each latch, N·s/m.
    #[serde(default)]
    pub latch_damping_n_s_per_m: f64,
    /// Play of the head between the latches, to each side, m.
    #[serde(default)]
    pub backlash_m: f64,
    /// Force at which a latch slips, N; None if it never slips.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub latch_slips_at_n: Option<f64>,
    /// Stiffness of the angular limiter, N·m/rad.
    #[serde(default)]
    pub limiter_stiffness_nm_per_rad: f64,
    /// Damping of the angular limiter, N·m·s/rad.
    #[serde(default)]
    pub limiter_damping_nm_s_per_rad: f64,
    /// Pose in P in which the latches hold J; None before the capture.
    #[serde(skip)]
    held: Option<Pose<f64>>,
}

fn four() -> u8 {
    4
}

impl Socket {
    pub(crate) fn validate(&self) -> Result<(), SettingsError> {
        in_range("socket.capture_depth_m", self.capture_depth_m, 0.0, 1.0)?;
        in_range("socket.capture_radius_m", self.capture_radius_m, 0.0, 1.0)?;
        in_range("socket.capture_speed_m_s", self.capture_speed_m_s, 0.0, 1.0)?;
        in_range("socket.latches", self.latches.into(), 1.0, 32.0)?;
        in_range(
            "socket.latch_stiffness_n_per_m",
            self.latch_stiffness_n_per_m,
            1.0,
            1e9,
        )?;
        in_range(
            "socket.latch_damping_n_s_per_m",
            self.latch_damping_n_s_per_m,
            0.0,
            1e7,
        )?;
        in_range("socket.backlash_m", self.backlash_m, 0.0, 0.1)?;
        let slips = self.latch_slips_at_n.unwrap_or(1.0);
        in_range("socket.latch_slips_at_n", slips, 1e-3, 1e9)?;
        let limiter = self.limiter_stiffness_nm_per_rad;
        in_range("socket.limiter_stiffness_nm_per_rad", limiter, 0.0, 1e9)?;
        let limiter = self.limiter_damping_nm_s_per_rad;
        in_range("socket.limiter_damping_nm_s_per_rad", limiter, 0.0, 1e7)
    }

    /// Stiffness of all latches together, N/m.
    pub fn stiffness_n_per_m(&self) -> f64 {
        f64::from(self.latches) * self.latch_stiffness_n_per_m
    }

    /// Damping of all latches together, N·s/m.
    pub fn damping_n_s_per_m(&self) -> f64 {
        f64::from(self.latches) * self.latch_damping_n_s_per_m
    }

    /// Whether the latches close.
    fn catches(&self, at: &Relative) -> bool {
        let head = at.p_from_j.translation.vector;
        head.x > -self.capture_depth_m
            && head.y * head.y + head.z * head.z <= self.capture_radius_m * self.capture_radius_m
            && at.twist.linear.x >= self.capture_speed_m_s
    }

    /// Displacement of J from where the latches hold it, beyond the play, m.
    fn stretch(&self, held: &Pose<f64>, at: &Relative) -> Vector3<f64> {
        let away = at.p_from_j.translation.vector - held.translation.vector;
        let distance = away.norm();
        if distance <= self.backlash_m {
            return Vector3::zeros();
        }
        away * (1.0 - self.backlash_m / distance)
    }

    /// Largest displacement beyond the play before the latches slip, m.
    fn longest_m(&self) -> f64 {
        let slips_at_n = self.latch_slips_at_n.unwrap_or(f64::INFINITY);
        slips_at_n / self.latch_stiffness_n_per_m
    }

    /// Splits a displacement into the part that the latches bear and the part by which they slip.
    fn borne(&self, stretch: &Vector3<f64>) -> [Vector3<f64>; 2] {
        let (length, longest) = (stretch.norm(), self.longest_m());
        if length <= longest {
            return [*stretch, Vector3::zeros()];
        }
        let borne = stretch * (longest / length);
        [borne, stretch - borne]
    }
}

impl Mechanism for Socket {
    fn reaction(&self, at: &Relative) -> Reaction {
        let Some(held) = &self.held else {
            return Reaction::none();
        };
        let [stretch, _] = self.borne(&self.stretch(held, at));
        let damping = if stretch == Vector3::zeros() {
            0.0
        } else {
            self.damping_n_s_per_m()
        };
        let pull = stretch * self.stiffness_n_per_m() + at.twist.linear * damping;
        // The axis of a rotation has the same components before and after it, so `angle` is in axes of J.
        let turned = held.rotation.inverse() * at.p_from_j.rotation;
        let (angle, rate) = (turned.scaled_axis(), at.twist.angular);
        let mut wrench = at.push(&at.p_from_j.translation.vector, &-pull);
        wrench.torque -=
            angle * self.limiter_stiffness_nm_per_rad + rate * self.limiter_damping_nm_s_per_rad;
        Reaction {
            wrench,
            stored_j: 0.5 * self.stiffness_n_per_m() * stretch.norm_squared()
                + 0.5 * self.limiter_stiffness_nm_per_rad * angle.norm_squared(),
            loss_w: damping * at.twist.linear.norm_squared()
                + self.limiter_damping_nm_s_per_rad * rate.norm_squared(),
        }
    }

    fn advance(&mut self, at: &Relative, _step_s: f64) -> f64 {
        let Some(held) = self.held else {
            if self.catches(at) {
                self.held = Some(at.p_from_j);
            }
            return 0.0;
        };
        let [borne, slip] = self.borne(&self.stretch(&held, at));
        self.held = Some(Translation3::from(slip) * held);
        self.stiffness_n_per_m() * borne.dot(&slip)
    }

    fn captured(&self) -> bool {
        self.held.is_some()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::EnergyTracked;
    use nalgebra::UnitQuaternion;

    fn socket() -> Socket {
        Socket {
            capture_depth_m: 0.01,
            capture_radius_m: 0.005,
            capture_speed_m_s: 0.02,
            latches: 4,
            latch_stiffness_n_per_m: 5e4,
            latch_damping_n_s_per_m: 0.0,
            backlash_m: 0.0,
            latch_slips_at_n: None,
            limiter_stiffness_nm_per_rad: 0.0,
            limiter_damping_nm_s_per_rad: 0.0,
            held: None,
        }
    }

    /// A mass flies into the socket. Returns the times at which it passes the place of capture, the mechanism, and the mass's
    /// final velocity.
    fn ring_down(
        socket: Socket,
        mass_kg: f64,
        speed_m_s: f64,
    ) -> (Vec<f64>, EnergyTracked<Socket>, f64) {
        let step_s = 1e-5;
        let (mut x, mut v) = (-0.02, speed_m_s);
        let mut tracked = EnergyTracked::new(socket);
        let mut force = 0.0;
        let mut passes = Vec::new();
        for step in 0..200_000 {
            v += force / mass_kg * step_s;
            let before = x;
            x += v * step_s;
            force = tracked
                .advance(&Relative::along_x(x, v), step_s)
                .wrench
                .force
                .x;
            let held = tracked.mechanism.held.map(|held| held.translation.x);
            if held.is_some_and(|held| (before - held) * (x - held) < 0.0) {
                passes.push(f64::from(step) * step_s);
            }
        }
        (passes, tracked, v)
    }

    #[test]
    fn a_head_is_caught_by_depth_radius_and_speed() {
        let (_, caught, _) = ring_down(socket(), 500.0, 0.03);
        assert!(caught.mechanism.captured());
        let (_, slow, _) = ring_down(socket(), 500.0, 0.019);
        assert!(!slow.mechanism.captured());
        let mut beside = Relative::along_x(0.0, 0.05);
        beside.p_from_j.translation.vector.y = 0.006;
        let mut socket = socket();
        socket.advance(&beside, 1e-3);
        assert!(!socket.captured());
    }

    /// The frequency is √(k/m) of all four latches; the energy before equals that after plus the loss.
    #[test]
    fn it_rings_down_with_its_frequency() {
        let damped = Socket {
            latch_damping_n_s_per_m: 50.0,
            ..socket()
        };
        let (mass, speed) = (500.0, 0.03);
        let (passes, tracked, v) = ring_down(damped, mass, speed);
        let half_s = (passes[passes.len() - 1] - passes[0]) / (passes.len() - 1) as f64;
        let zeta = 200.0 / (2.0 * (2e5 * mass).sqrt());
        let expected = (2e5 / mass).sqrt() * (1.0 - zeta * zeta).sqrt();
        assert!(
            (std::f64::consts::PI / half_s / expected - 1.0).abs() < 1e-3,
            "{half_s} {expected}"
        );
        let (balance, energy) = (tracked.balance(), 0.5 * mass * speed * speed);
        assert!(balance.imbalance_j().abs() < 1e-3 * energy, "{balance:?}");
        let now = 0.5 * mass * v * v + balance.stored_j + balance.dissipated_j;
        assert!((now / energy - 1.0).abs() < 1e-3, "{balance:?}");
    }

    /// A latch that slips gives way at its force limit, keeps that force, and dissipates the rest.
    #[test]
    fn a_weak_latch_slips() {
        let weak = Socket {
            latch_slips_at_n: Some(20.0),
            ..socket()
        };
        let (mass, speed) = (500.0, 0.05);
        let (_, tracked, v) = ring_down(weak, mass, speed);
        let held = tracked.mechanism.held.unwrap().translation;
        assert!(held.x > -0.01 + 1e-4, "{held}");
        let (balance, energy) = (tracked.balance(), 0.5 * mass * speed * speed);
        let now = 0.5 * mass * v * v + balance.stored_j + balance.dissipated_j;
        assert!((now / energy - 1.0).abs() < 1e-3, "{balance:?}");
        assert!(balance.dissipated_j > 0.1 * energy, "{balance:?}");
    }

    /// The limiter stores no energy for the angle at capture, and acts only against a further rotation.
    #[test]
    fn an_angle_at_capture_is_no_energy() {
        let mut caught = Socket {
            limiter_stiffness_nm_per_rad: 1e4,
            ..socket()
        };
        let mut at = Relative::along_x(0.0, 0.05);
        at.p_from_j.rotation = UnitQuaternion::from_euler_angles(0.3, 0.07, 0.0);
        caught.advance(&at, 1e-3);
        assert!(caught.captured());
        let reaction = caught.reaction(&at);
        assert!(reaction.stored_j < 1e-12, "{reaction:?}");
        assert!(reaction.wrench.torque.norm() < 1e-9, "{reaction:?}");
        at.p_from_j.rotation *= UnitQuaternion::from_scaled_axis(Vector3::new(0.0, 0.0, 1e-3));
        let reaction = caught.reaction(&at);
        let expected = Vector3::new(0.0, 0.0, -10.0);
        assert!(
            (reaction.wrench.torque - expected).norm() < 1e-6,
            "{reaction:?}"
        );
        assert!((reaction.stored_j - 5e-3).abs() < 1e-9, "{reaction:?}");
    }

    #[test]
    fn the_play_lets_the_head_move_freely() {
        let mut loose = Socket {
            backlash_m: 0.002,
            ..socket()
        };
        loose.advance(&Relative::along_x(0.0, 0.05), 1e-3);
        assert_eq!(
            loose.reaction(&Relative::along_x(0.0019, 0.0)).wrench.force,
            Vector3::zeros()
        );
        let beyond = loose
            .reaction(&Relative::along_x(0.003, 0.0))
            .wrench
            .force
            .x;
        assert!((beyond + 200.0).abs() < 1e-9);
    }
}
