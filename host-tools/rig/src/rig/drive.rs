//! The arm: from the commanded velocity of each axis to the executed one, and to the pose.

use super::checks::named;
use super::hidden;
use super::settings::RigSettings;
use super::stage::{Axis, hidden_stages};
use anyhow::Result;
use nalgebra::{ComplexField, Vector3};
use softdock_control::frames::{Pose, Twist, orientation_from_abc};
use softdock_physics::effects::actuator::AxisStage;
use softdock_physics::effects::actuator::actuation_delay::TransportDelay;
use softdock_physics::effects::{Actuator, Clock, Group, Law};

/// Commands in flight that the delay line can hold: a delay of 252 ms at 4 ms.
const COMMANDS_IN_FLIGHT: usize = 64;

/// Six axes X Y Z A B C: m and rad, or m/s and rad/s.
pub type Axes = [f64; 6];

/// Six axes behind one delay line, and where they have got to.
///
/// Times are given by the nominal clock. With a hidden error of the clock's rate, the arm moves in the true time that passes
/// meanwhile.
#[derive(Clone, Debug)]
pub struct Drive {
    /// Stages that change the commands of each axis before the delay.
    command: Vec<AxisStage>,
    line: TransportDelay<6, COMMANDS_IN_FLIGHT>,
    axes: [Axis; 6],
    /// Nominal integration step, s, and true duration of a nominal second, s.
    step_s: f64,
    second_s: f64,
    /// X Y Z A B C in C, m and rad.
    position: Axes,
    /// Mean over the last step, m/s and rad/s.
    velocity: Axes,
    twist: Twist<f64>,
}

impl Drive {
    /// At rest at `start`.
    pub fn new(settings: &RigSettings, start: Axes) -> Result<Self> {
        let second_s = second_s(settings);
        let step_s = second_s * settings.substep_s();
        let (linear, angular) = (
            Axis::new(settings, step_s, "m")?,
            Axis::new(settings, step_s, "rad")?,
        );
        let hidden = hidden::in_order(&settings.hidden, Group::Actuator);
        let late = hidden.filter_map(|(effect, values)| match effect.law {
            Law::Actuator(Actuator {
                axis: None,
                late: Some(late),
            }) => Some(late(&values).delay_s),
            _ => None,
        });
        let delay_s = settings.robot.actuator.delay_s + late.sum::<f64>();
        let line = TransportDelay::new(delay_s, second_s * settings.cycle_s());
        let stages = hidden_stages(settings, step_s)?.into_iter();
        let command = stages.filter_map(|(_, stage)| stage.is_of_the_command().then_some(stage));
        Ok(Self {
            command: command.collect(),
            line: named("rig.robot.actuator.delay_s", line)?,
            axes: std::array::from_fn(|i| {
                if i < 3 {
                    linear.clone()
                } else {
                    angular.clone()
                }
            }),
            step_s: settings.substep_s(),
            second_s,
            position: start,
            velocity: [0.0; 6],
            twist: Twist::zero(),
        })
    }

    /// Begins a cycle with this velocity.
    pub fn push(&mut self, velocity: Axes) {
        let understood = self.understood(velocity);
        self.line.push(understood);
    }

    /// Corrects the velocity of the running cycle.
    pub(super) fn replace_newest(&mut self, velocity: Axes) {
        let understood = self.understood(velocity);
        self.line.replace_newest(understood);
    }

    fn understood(&mut self, velocity: Axes) -> Axes {
        let command = self.command.iter_mut();
        command.fold(velocity, |velocity, stage| {
            velocity.map(|v| stage.advance(v))
        })
    }

    /// One integration step that begins `since_cycle_s` after the cycle did; `extra_delay_s` is
    /// this cycle's deviation from the nominal delay.
    pub fn advance(&mut self, since_cycle_s: f64, extra_delay_s: f64) {
        let step_s = self.second_s * self.step_s;
        let from = self.second_s * since_cycle_s - extra_delay_s;
        let delayed = self.line.mean_over(from, from + step_s);
        for (i, axis) in self.axes.iter_mut().enumerate() {
            self.velocity[i] = axis.advance(delayed[i]);
            self.position[i] += step_s * self.velocity[i];
        }
        self.twist = twist(&self.position, &self.velocity);
    }

    /// X Y Z A B C, `ahead_s` after the last step.
    pub fn position(&self, ahead_s: f64) -> Axes {
        let ahead_s = self.second_s * ahead_s;
        std::array::from_fn(|i| self.position[i] + ahead_s * self.velocity[i])
    }

    /// X Y Z A B C, `ahead_s` after the beginning of a cycle that begins now: what the commands in
    /// flight make of it, exact as long as `ahead_s` is not beyond the delay.
    pub(super) fn foreseen(&self, ahead_s: f64, extra_delay_s: f64) -> Axes {
        let mut later = self.clone();
        let steps = (ahead_s / self.step_s).floor().max(0.0) as u32;
        for step in 0..steps {
            later.advance(f64::from(step) * self.step_s, extra_delay_s);
        }
        later.position(ahead_s - f64::from(steps) * self.step_s)
    }

    /// Executed velocity: linear in C, angular in M.
    pub fn twist(&self) -> Twist<f64> {
        self.twist
    }
}

/// True duration of a nominal second of the rig, s.
fn second_s(settings: &RigSettings) -> f64 {
    let mut hidden = hidden::in_order(&settings.hidden, Group::Body);
    let longer = hidden.find_map(|(effect, values)| match effect.law {
        Law::Clock(Clock::Rate(law)) => Some(law(&values)),
        _ => None,
    });
    1.0 + longer.unwrap_or(0.0)
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
