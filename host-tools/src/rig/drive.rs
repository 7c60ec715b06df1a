//! The arm: from the commanded velocity of each axis to the executed one, and to the pose.

use super::checks::{named, prefixed};
use super::settings::{ActuatorSettings, RigSettings, ServoSettings};
use anyhow::Result;
use nalgebra::{ComplexField, Vector3};
use softdock_control::effects::actuator::first_order_lag::FirstOrderLag;
use softdock_control::effects::actuator::rate_limit::RateLimit;
use softdock_control::effects::actuator::second_order_servo::SecondOrderServo;
use softdock_control::effects::actuator::transport_delay::TransportDelay;
use softdock_control::effects::actuator::velocity_saturation::VelocitySaturation;
use softdock_control::effects::actuator::zero_crossing_pause::ZeroCrossingPause;
use softdock_control::frames::{Pose, Twist, orientation_from_abc};

/// Commands in flight that the delay line can hold: a delay of 252 ms at 4 ms.
const COMMANDS_IN_FLIGHT: usize = 64;

/// Six axes X Y Z A B C: m and rad, or m/s and rad/s.
pub(super) type Axes = [f64; 6];

/// What follows the transport delay on one axis.
#[derive(Clone, Debug)]
struct Axis {
    lag: FirstOrderLag<f64>,
    servo: Option<SecondOrderServo<f64>>,
    pause: ZeroCrossingPause<f64>,
    rate_limit: Option<RateLimit<f64>>,
    saturation: Option<VelocitySaturation<f64>>,
}

impl Axis {
    fn new(a: &ActuatorSettings, step_s: f64, unit: &str) -> Result<Self> {
        let (acceleration, velocity) = match unit {
            "rad" => (a.max_acceleration_rad_s2, a.max_velocity_rad_s),
            _ => (a.max_acceleration_m_s2, a.max_velocity_m_s),
        };
        let key = |name: &str| format!("rig.robot.actuator.{name}");
        let servo = |s: &ServoSettings| {
            let built = SecondOrderServo::new(s.natural_frequency_hz, s.damping_ratio, step_s);
            prefixed(&key("servo."), built)
        };
        let rate_limit = |limit| {
            named(
                &key(&format!("max_acceleration_{unit}_s2")),
                RateLimit::new(limit, step_s),
            )
        };
        let saturation = |limit| {
            named(
                &key(&format!("max_velocity_{unit}_s")),
                VelocitySaturation::new(limit),
            )
        };
        Ok(Self {
            lag: named(&key("lag_s"), FirstOrderLag::new(a.lag_s, step_s))?,
            servo: a.servo.as_ref().map(servo).transpose()?,
            pause: named(&key("pause_s"), ZeroCrossingPause::new(a.pause_s, step_s))?,
            rate_limit: acceleration.map(rate_limit).transpose()?,
            saturation: velocity.map(saturation).transpose()?,
        })
    }

    fn advance(&mut self, delayed: f64) -> f64 {
        let lagged = self.lag.advance(delayed);
        let served = self
            .servo
            .as_mut()
            .map_or(lagged, |servo| servo.advance(lagged));
        let paused = self.pause.advance(served);
        let limited = self
            .rate_limit
            .as_mut()
            .map_or(paused, |limit| limit.advance(paused));
        self.saturation
            .as_ref()
            .map_or(limited, |saturation| saturation.apply(limited))
    }
}

/// Six axes behind one delay line, and where they have got to.
#[derive(Clone, Debug)]
pub(super) struct Drive {
    line: TransportDelay<f64, 6, COMMANDS_IN_FLIGHT>,
    axes: [Axis; 6],
    step_s: f64,
    /// X Y Z A B C in C, m and rad.
    position: Axes,
    /// Mean over the last step, m/s and rad/s.
    velocity: Axes,
    twist: Twist<f64>,
}

impl Drive {
    /// At rest at `start`.
    pub(super) fn new(settings: &RigSettings, start: Axes) -> Result<Self> {
        let (actuator, step_s) = (&settings.robot.actuator, settings.substep_s());
        let (linear, angular) = (
            Axis::new(actuator, step_s, "m")?,
            Axis::new(actuator, step_s, "rad")?,
        );
        let line = TransportDelay::new(actuator.delay_s, settings.cycle_s());
        Ok(Self {
            line: named("rig.robot.actuator.delay_s", line)?,
            axes: std::array::from_fn(|i| {
                if i < 3 {
                    linear.clone()
                } else {
                    angular.clone()
                }
            }),
            step_s,
            position: start,
            velocity: [0.0; 6],
            twist: Twist::zero(),
        })
    }

    /// Begins a cycle with this velocity.
    pub(super) fn push(&mut self, velocity: Axes) {
        self.line.push(velocity);
    }

    /// Corrects the velocity of the running cycle.
    pub(super) fn replace_newest(&mut self, velocity: Axes) {
        self.line.replace_newest(velocity);
    }

    /// One integration step that begins `since_cycle_s` after the cycle did; `extra_delay_s` is
    /// this cycle's deviation from the nominal delay.
    pub(super) fn advance(&mut self, since_cycle_s: f64, extra_delay_s: f64) {
        let from = since_cycle_s - extra_delay_s;
        let delayed = self.line.mean_over(from, from + self.step_s);
        for (i, axis) in self.axes.iter_mut().enumerate() {
            self.velocity[i] = axis.advance(delayed[i]);
            self.position[i] += self.step_s * self.velocity[i];
        }
        self.twist = twist(&self.position, &self.velocity);
    }

    /// X Y Z A B C, `ahead_s` after the last step.
    pub(super) fn position(&self, ahead_s: f64) -> Axes {
        std::array::from_fn(|i| self.position[i] + ahead_s * self.velocity[i])
    }

    /// Executed velocity: linear in C, angular in M.
    pub(super) fn twist(&self) -> Twist<f64> {
        self.twist
    }
}

/// The pose C_from_M of X Y Z A B C.
pub(super) fn pose(axes: &Axes) -> Pose<f64> {
    let [x, y, z, a, b, c] = *axes;
    Pose::from_parts(
        Vector3::new(x, y, z).into(),
        orientation_from_abc(&[a, b, c]),
    )
}

/// The twist of axis velocities: KUKA's A, B, C turn about z, then the new y, then the new x, so
/// ω = C' x + Rx(C)ᵀ (B' y + Ry(B)ᵀ A' z) in body axes.
fn twist(position: &Axes, velocity: &Axes) -> Twist<f64> {
    let [vx, vy, vz, da, db, dc] = *velocity;
    let linear = Vector3::new(vx, vy, vz);
    if da == 0.0 && db == 0.0 && dc == 0.0 {
        return Twist {
            linear,
            angular: Vector3::zeros(),
        };
    }
    let (sin_b, cos_b) = ComplexField::sin_cos(position[4]);
    let (sin_c, cos_c) = ComplexField::sin_cos(position[5]);
    let angular = Vector3::new(
        dc - da * sin_b,
        db * cos_c + da * cos_b * sin_c,
        da * cos_b * cos_c - db * sin_c,
    );
    Twist { linear, angular }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The angular velocity against the difference of two orientations.
    #[test]
    fn twist_is_the_derivative_of_the_pose() {
        let at = [0.1, 0.2, 0.3, 0.4, -0.5, 0.6];
        let rate = [0.01, 0.02, -0.03, 0.7, -0.8, 0.9];
        let h = 1e-6;
        let later: Axes = std::array::from_fn(|i| at[i] + h * rate[i]);
        let turned = pose(&at).rotation.rotation_to(&pose(&later).rotation);
        let in_body = pose(&at).rotation.inverse() * turned.scaled_axis() / h;
        assert!((twist(&at, &rate).angular - in_body).norm() < 1e-5);
    }

    /// v(t) = u(t − 32 ms), then standstill of 16 ms at the reversal: against the written equation.
    #[test]
    fn delay_and_pause_follow_their_equations() {
        let mut drive = Drive::new(&RigSettings::default(), [0.0; 6]).unwrap();
        let command = |cycle: i32| {
            if cycle < 0 {
                0.0
            } else {
                (0.13 * f64::from(cycle)).cos()
            }
        };
        let (mut expected, mut direction, mut paused_until) = (0.0, 1.0, -1.0);
        for cycle in 0..100 {
            let u = command(cycle);
            drive.push([u, 0.0, 0.0, 0.0, 0.0, 0.0]);
            for k in 0..8 {
                let t = f64::from(cycle) * 0.004 + f64::from(k) * 0.0005;
                let delayed = command(cycle - 8);
                if delayed * direction < 0.0 && t >= paused_until {
                    (direction, paused_until) = (-direction, t + 0.016 - 1e-9);
                }
                let v = if t < paused_until { 0.0 } else { delayed };
                expected += 0.0005 * v;
                drive.advance(f64::from(k) * 0.0005, 0.0);
                assert!(
                    (drive.position(0.0)[0] - expected).abs() < 1e-12,
                    "{cycle} {k}"
                );
                assert!((drive.twist().linear.x - v).abs() < 1e-12, "{cycle} {k}");
            }
        }
    }
}
