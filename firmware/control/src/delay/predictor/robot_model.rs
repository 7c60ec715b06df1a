//! The robot model: the positions of the six axes that follow from the commands. Each axis is a [`LinearDynamics`] followed by a
//! [`Pause`] at its reversals.

use super::V6;
use super::command_history::CommandHistory;
use super::linear_dynamics::{LinearDynamics, Segment};
use super::pause::Pause;
use crate::delay::actuator::ActuatorSettings;

/// What all axes share.
#[derive(Clone, Debug)]
pub(super) struct RobotModel {
    pub(super) linear: LinearDynamics,
    /// Length of a pause, cycles.
    pub(super) pause: f64,
    pub(super) cycle_s: f64,
}

impl RobotModel {
    /// From the settings of the robot; `latency` cycles of the reported pose are added to the dead time.
    pub(super) fn new(actuator: &ActuatorSettings, cycle_s: f64, latency: f64) -> Self {
        Self {
            linear: LinearDynamics::new(actuator, cycle_s, latency),
            pause: actuator.pause_s / cycle_s,
            cycle_s,
        }
    }

    /// Delay from a command to its execution relative to the time of the force, for a latency of the pose; cycles.
    pub(super) fn execution_delay(&self, latency: usize) -> f64 {
        (self.linear.mean_delay - latency as f64).max(0.0)
    }
}

/// State of an axis besides position and velocity.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct AxisState {
    state: [f64; 3],
    pause: Pause,
}

impl AxisState {
    /// Executes a cycle with the command of its first part and that of the rest. Returns the displacement (m) and the velocity at
    /// the end (m/s).
    #[inline]
    pub(super) fn step(&mut self, model: &RobotModel, older: f64, newer: f64) -> (f64, f64) {
        let first = model.linear.first_segment(older);
        let segment = model.linear.step(&mut self.state, older, newer);
        self.pause.ended = false;
        let before = first
            .as_ref()
            .is_none_or(|first| self.pause.goes_on(first.end));
        let (displacement, velocity) = if before && self.pause.goes_on(segment.end) {
            let displacement = first.map_or(0.0, |first| first.displacement);
            (displacement + segment.displacement, segment.end)
        } else {
            self.reverse(first.as_ref(), &segment, model.pause)
        };
        (displacement * model.cycle_s, velocity)
    }

    /// A cycle with a reversal, a pause or a start: displacement, in cycles, and velocity.
    #[inline(never)]
    fn reverse(&mut self, first: Option<&Segment>, segment: &Segment, pause: f64) -> (f64, f64) {
        let mut displacement = first.map_or(0.0, |first| self.pause.execute(first, pause));
        displacement += self.pause.execute(segment, pause);
        let stands = self.pause.left > 0.0;
        (displacement, if stands { 0.0 } else { segment.end })
    }
}

/// State of the six axes at one instant.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct RobotState {
    /// Positions, m.
    pub(super) position: V6,
    /// Velocities at the end of the last cycle, before the next command arrives, m/s.
    pub(super) velocity: V6,
    axes: [AxisState; 6],
}

impl RobotState {
    /// Whether an axis ended a pause within the last cycle: its velocity is then not that of the whole cycle.
    pub(super) fn resumed(&self) -> bool {
        self.axes.iter().any(|axis| axis.pause.ended)
    }

    /// Executes cycle number `cycle` with the commands that were sent.
    pub(super) fn step_sent(
        &mut self,
        model: &RobotModel,
        commands: &CommandHistory,
        cycle: usize,
    ) {
        let newer = commands.of(cycle, model.linear.whole);
        let older = commands.of(cycle, model.linear.whole + 1);
        self.step(model, &older, &newer);
    }

    /// Executes a cycle with the commands of its first part and those of the rest.
    #[inline]
    pub(super) fn step(&mut self, model: &RobotModel, older: &V6, newer: &V6) {
        if model.linear.is_dead_time && self.goes_on(model, older, newer) {
            self.position += model.linear.dead_time_displacement(older, newer) * model.cycle_s;
            self.velocity = *newer;
            self.axes
                .iter_mut()
                .for_each(|axis| axis.pause.ended = false);
            return;
        }
        for (i, axis) in self.axes.iter_mut().enumerate() {
            let (displacement, velocity) = axis.step(model, older[i], newer[i]);
            self.position[i] += displacement;
            self.velocity[i] = velocity;
        }
    }

    /// Whether no axis reverses, pauses or starts with these commands. That holds in nearly all cycles, in which all axes
    /// together take a fraction of the instructions.
    #[inline]
    fn goes_on(&self, model: &RobotModel, older: &V6, newer: &V6) -> bool {
        let begins = model.linear.fraction > 0.0;
        let mut axes = self.axes.iter().zip(older).zip(newer);
        axes.all(|((axis, older), newer)| {
            axis.pause.goes_on(*newer) && (!begins || axis.pause.goes_on(*older))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::delay::predictor::scene::robot;
    use crate::delay::spacecraft::CYCLE_S;
    use softdock_delay_plants::{Actuator, Dynamics, Plant, PlantSettings};

    fn believed(robot: &Actuator) -> ActuatorSettings {
        let mut settings = ActuatorSettings {
            delay_s: robot.delay_s,
            pause_s: robot.pause_s,
            ..ActuatorSettings::default()
        };
        match robot.dynamics {
            Dynamics::None => {}
            Dynamics::Lag { time_constant_s } => settings.lag_s = time_constant_s,
            Dynamics::Servo { hz, damping } => {
                (settings.servo_hz, settings.servo_damping) = (hz, damping);
            }
        }
        settings
    }

    /// Asserts that the model moves like the plant, within this distance (m), over a motion with reversals.
    fn assert_alike(actuator: Actuator, bound: f64) {
        let model = RobotModel::new(&believed(&actuator), CYCLE_S, 0.0);
        let mut plant = Plant::new(&PlantSettings {
            actuator,
            ..PlantSettings::default()
        });
        let (mut commands, mut robot) = (CommandHistory::new(), RobotState::default());
        for n in 0..400 {
            let t = f64::from(n) * CYCLE_S;
            let x = 0.005 * (9.0 * t).sin() + 0.001 * (31.0 * t).cos() + 3e-6;
            let command = [x, -x, 0.3 * x, 0.0, x, 0.0];
            let cycle = commands.next;
            commands.push(&V6::from(command));
            robot.step_sent(&model, &commands, cycle);
            plant.step(command);
            let truth = plant.log().moments[cycle].position;
            let error = robot.position - V6::from(truth);
            let near = error.iter().all(|error| error.abs() < bound);
            assert!(near, "{actuator:?} in cycle {cycle}: {error}");
        }
    }

    /// The model has the position of a plant that shares no code with it: five structures, whole and fractional delays, with and
    /// without a pause. 1 µm is 0.02 % of the motion.
    #[test]
    fn it_moves_as_the_robot_does() {
        let ideal = Actuator::ideal();
        let lag = Dynamics::Lag {
            time_constant_s: 0.016,
        };
        let servo = |hz| Dynamics::Servo { hz, damping: 0.7 };
        for (delay_s, dynamics) in [
            (0.032, Dynamics::None),
            (0.0305, Dynamics::None),
            (0.016, lag),
            (0.0, lag),
            (0.016, servo(10.0)),
            (0.003, servo(5.0)),
        ] {
            for pause_s in [0.0, 0.016, 0.010] {
                let actuator = Actuator {
                    delay_s,
                    dynamics,
                    pause_s,
                    ..ideal
                };
                assert_alike(actuator, if pause_s == 0.0 { 1e-9 } else { 1e-6 });
            }
        }
    }
    /// In every bit, for every robot, and wherever axes reverse, rest and start; from rest, and from any cycle on.
    #[test]
    fn all_axes_at_once_move_as_each_does() {
        let command = |n: usize, axis: usize| {
            let t = n as f64 * CYCLE_S;
            let command = 0.005 * (9.0 * t).sin() + 0.002 * (61.0 * t).cos();
            let rests = (n + 7 * axis) % 40 < 9;
            if rests { 0.0 } else { command }
        };
        let commands = |n| V6::from_fn(|axis, _| command(n, axis));
        let (mut went_on, mut turned) = (0, 0);
        for (delay, lag_s) in [(2.0, 0.0), (2.3, 0.0), (0.0, 0.0), (1.5, 0.016)] {
            for (pause, first) in [(0.0, 0), (0.4, 0), (4.0, 0), (0.4, 79), (4.0, 79)] {
                let model = RobotModel::new(&robot(delay, pause, lag_s, 0.0), CYCLE_S, 0.0);
                let (mut at_once, mut each) = (RobotState::default(), RobotState::default());
                for n in first..120 {
                    let (older, newer) = (commands(n), commands(n + 1));
                    let goes_on = at_once.goes_on(&model, &older, &newer);
                    *(if goes_on { &mut went_on } else { &mut turned }) += 1;
                    at_once.step(&model, &older, &newer);
                    for i in 0..6 {
                        let (displacement, velocity) =
                            each.axes[i].step(&model, older[i], newer[i]);
                        each.position[i] += displacement;
                        each.velocity[i] = velocity;
                    }
                    // The debug text shows all digits.
                    assert_eq!(format!("{at_once:?}"), format!("{each:?}"), "{n}");
                }
            }
        }
        assert!(went_on > 100 && turned > 100, "{went_on} {turned}");
    }

    /// A pure dead time whose command reverses in cycle 10: the axis goes on for a dead time, pauses, and goes back. `again`: the
    /// command reverses once more a cycle later, within the pause, and the axis goes on without another pause.
    #[test]
    fn an_axis_that_turns_stands_still_for_its_pause() {
        for (delay, pause) in [
            (2.0, 3.0),
            (2.0, 2.5),
            (1.25, 2.5),
            (1.25, 2.75),
            (1.25, 0.25),
            (2.0, 0.4),
            (2.75, 1.0),
            (1.1, 2.9),
            (1.1, 0.0),
            // Rounding that is left of a delay that was changed to and fro.
            (2.0 + 1e-14, 3.0),
        ] {
            for again in [false, true] {
                if again && pause < 1.0 {
                    continue;
                }
                let model = RobotModel::new(&robot(delay, pause, 0.0, 0.0), CYCLE_S, 0.0);
                let (mut commands, mut axes) = (CommandHistory::new(), RobotState::default());
                let turns = 10.0 + delay;
                for n in 0..30 {
                    let back = n == 10 || n > 10 && !again;
                    commands.push(&V6::repeat(if back { -1.0 } else { 1.0 }));
                    axes.step_sent(&model, &commands, n);
                    let now = n as f64 + 1.0;
                    let rest = (now - turns - pause).max(0.0) * if again { 1.0 } else { -1.0 };
                    let position = (now.min(turns) - delay).max(0.0) + rest;
                    let found = axes.position[0] / CYCLE_S;
                    let place = format!("{delay} {pause} {again} at {now}: {found}");
                    assert!((found - position).abs() < 1e-9, "{place}, not {position}");
                    let ends = turns + pause;
                    let stands = now > turns + 1e-9 && now < ends - 1e-9;
                    let velocity = match now {
                        _ if stands => 0.0,
                        _ if now < delay + 1e-9 => 0.0,
                        _ if now <= turns + 1e-9 || again => 1.0,
                        _ => -1.0,
                    };
                    assert_eq!(axes.velocity[0], velocity, "{place}");
                    let ended = pause > 0.0 && ends < now + 1e-9 && ends > now - 1.0 + 1e-9;
                    assert_eq!(axes.resumed(), ended, "{place}");
                }
            }
        }
    }

    /// With a pose that is three cycles old.
    #[test]
    fn the_delay_to_the_execution_is_that_to_the_pose_less_its_latency() {
        let model = RobotModel::new(&robot(8.0, 0.0, 0.008, 0.0), CYCLE_S, 3.0);
        assert!((model.linear.mean_delay - 13.0).abs() < 1e-9);
        assert!((model.execution_delay(3) - 10.0).abs() < 1e-9);
        assert_eq!(model.execution_delay(14), 0.0);
    }
}
