//! The robot model: where the commands that are sent bring the six axes, each a [`LinearDynamics`] with a [`Pause`] at its
//! reversals behind it.

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
    /// What is believed of the robot; `latency` cycles of the reported pose stand behind it.
    pub(super) fn new(actuator: &ActuatorSettings, cycle_s: f64, latency: f64) -> Self {
        Self {
            linear: LinearDynamics::new(actuator, cycle_s, latency),
            pause: actuator.pause_s / cycle_s,
            cycle_s,
        }
    }

    /// Delay from a command to its execution, in the time of the force, for a latency of the pose; cycles.
    pub(super) fn execution_delay(&self, latency: usize) -> f64 {
        (self.linear.mean_delay - latency as f64).max(0.0)
    }
}

/// State of one axis.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct AxisState {
    state: [f64; 3],
    pause: Pause,
    /// Position, m.
    pub(super) position: f64,
    /// Velocity at the end of the last cycle, before the next command arrives, m/s.
    pub(super) velocity: f64,
}

impl AxisState {
    /// Executes a cycle with the command of its first part and that of the rest.
    #[inline]
    pub(super) fn step(&mut self, model: &RobotModel, older: f64, newer: f64) {
        let first = model.linear.first_segment(older);
        let segment = model.linear.step(&mut self.state, older, newer);
        self.execute(model, first, segment);
    }

    #[inline]
    fn execute(&mut self, model: &RobotModel, first: Option<Segment>, segment: Segment) {
        self.pause.ended = false;
        let before = first
            .as_ref()
            .is_none_or(|first| self.pause.goes_on(first.end));
        let displacement = if before && self.pause.goes_on(segment.end) {
            self.velocity = segment.end;
            first.map_or(0.0, |first| first.displacement) + segment.displacement
        } else {
            self.reverse(first.as_ref(), &segment, model.pause)
        };
        self.position += displacement * model.cycle_s;
    }

    /// Executes the cycles that begin with one of the commands and end with the next; `path` gets the position after each.
    pub(super) fn follow(&mut self, model: &RobotModel, commands: &[f64], path: &mut [f64]) {
        if !model.linear.is_dead_time {
            let [mut older, ref later @ ..] = *commands else {
                return;
            };
            for (at, newer) in path.iter_mut().zip(later) {
                let segment = model.linear.respond(&mut self.state, older, *newer);
                self.execute(model, None, segment);
                *at = self.position;
                older = *newer;
            }
            return;
        }
        let mut done = 0;
        while let (Some(commands @ [older, newer, ..]), Some(left)) =
            (commands.get(done..), path.get_mut(done..))
        {
            let steady = self.go_on(model, commands, left);
            if let (0, Some(at)) = (steady, left.first_mut()) {
                self.step(model, *older, *newer);
                *at = self.position;
            }
            done += steady.max(1);
        }
    }

    /// The same of a pure dead time, up to the first cycle in which it turns, stands or starts; how many cycles that are.
    fn go_on(&mut self, model: &RobotModel, commands: &[f64], path: &mut [f64]) -> usize {
        let fraction = model.linear.fraction;
        let [first, later @ ..] = commands else {
            return 0;
        };
        let goes_on = |command: &f64| self.pause.goes_on(*command);
        if fraction > 0.0 && !goes_on(first) {
            return 0;
        }
        let possible = later.iter().take(path.len());
        let count = possible.take_while(|newer| goes_on(newer)).count();
        let (mut position, mut older) = (self.position, *first);
        for (at, newer) in path.iter_mut().zip(later).take(count) {
            let before = if fraction > 0.0 {
                older * fraction
            } else {
                0.0
            };
            position += (before + newer * (1.0 - fraction)) * model.cycle_s;
            *at = position;
            older = *newer;
        }
        if count > 0 {
            self.pause.ended = false;
            (self.position, self.velocity) = (position, older);
        }
        count
    }

    /// A cycle with a reversal, a pause or a start; the displacement.
    #[inline(never)]
    fn reverse(&mut self, first: Option<&Segment>, segment: &Segment, pause: f64) -> f64 {
        let mut displacement = first.map_or(0.0, |first| self.pause.execute(first, pause));
        displacement += self.pause.execute(segment, pause);
        let stands = self.pause.left > 0.0;
        self.velocity = if stands { 0.0 } else { segment.end };
        displacement
    }
}

/// State of the six axes at one instant.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct RobotState(pub(super) [AxisState; 6]);

impl RobotState {
    pub(super) fn position(&self) -> V6 {
        V6::from(self.0.map(|axis| axis.position))
    }

    pub(super) fn velocity(&self) -> V6 {
        V6::from(self.0.map(|axis| axis.velocity))
    }

    /// Whether an axis came out of a pause within the last cycle: its velocity is not that of the cycle.
    pub(super) fn resumed(&self) -> bool {
        self.0.iter().any(|axis| axis.pause.ended)
    }

    /// Executes the cycle of that number with the commands that were sent.
    pub(super) fn step_sent(
        &mut self,
        model: &RobotModel,
        commands: &CommandHistory,
        cycle: usize,
    ) {
        let newer = commands.of(cycle, model.linear.whole);
        let older = commands.of(cycle, model.linear.whole + 1);
        for (i, axis) in self.0.iter_mut().enumerate() {
            axis.step(model, older[i], newer[i]);
        }
    }

    /// Moves the positions.
    pub(super) fn shift(&mut self, by: &V6) {
        for (axis, by) in self.0.iter_mut().zip(by.iter()) {
            axis.position += by;
        }
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

    /// Moves like the plant, to this distance (m), over a motion with reversals.
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
            let error = robot.position() - V6::from(truth);
            let near = error.iter().all(|error| error.abs() < bound);
            assert!(near, "{actuator:?} in cycle {cycle}: {error}");
        }
    }

    /// The model is where a plant is that shares no code with it: five structures, whole and broken
    /// delays, with and without a pause. 1 µm is 0.02 % of the motion.
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
    /// In every bit, whatever the robot and wherever it turns, rests and starts; from rest, and from the last cycle before one.
    #[test]
    fn following_commands_is_executing_each() {
        let commands: [f64; 120] = core::array::from_fn(|n| {
            let t = n as f64 * CYCLE_S;
            let command = 0.005 * (9.0 * t).sin() + 0.002 * (61.0 * t).cos();
            if n % 40 < 9 { 0.0 } else { command }
        });
        for (delay, lag_s) in [(2.0, 0.0), (2.3, 0.0), (0.0, 0.0), (1.5, 0.016)] {
            for (pause, first) in [(0.0, 0), (0.4, 0), (4.0, 0), (0.4, 79), (4.0, 79)] {
                let model = RobotModel::new(&robot(delay, pause, lag_s, 0.0), CYCLE_S, 0.0);
                let commands = &commands[first..];
                let mut each = AxisState::default();
                let expected = commands.windows(2).map(|pair| {
                    each.step(&model, pair[0], pair[1]);
                    each.position.to_bits()
                });
                let expected: Vec<u64> = expected.collect();
                let (mut at_once, mut path) = (AxisState::default(), vec![0.0; expected.len()]);
                at_once.follow(&model, commands, &mut path);
                let found: Vec<u64> = path.into_iter().map(f64::to_bits).collect();
                assert_eq!(found, expected);
                assert_eq!(format!("{at_once:?}"), format!("{each:?}"));
            }
        }
    }

    /// A pure dead time whose command turns in cycle 10: it goes on until then and a dead time, stands for the pause, and goes
    /// back. `again`: it turns once more a cycle later, in the pause, and goes on without another one.
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
                    let found = axes.position()[0] / CYCLE_S;
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
                    assert_eq!(axes.velocity()[0], velocity, "{place}");
                    let ended = pause > 0.0 && ends < now + 1e-9 && ends > now - 1.0 + 1e-9;
                    assert_eq!(axes.resumed(), ended, "{place}");
                }
            }
        }
    }

    /// Seen by a pose that is three cycles old.
    #[test]
    fn the_delay_to_the_execution_is_that_to_the_pose_less_its_latency() {
        let model = RobotModel::new(&robot(8.0, 0.0, 0.008, 0.0), CYCLE_S, 3.0);
        assert!((model.linear.mean_delay - 13.0).abs() < 1e-9);
        assert!((model.execution_delay(3) - 10.0).abs() < 1e-9);
        assert_eq!(model.execution_delay(14), 0.0);
    }

    #[test]
    fn a_state_that_is_shifted_has_moved() {
        let mut state = RobotState::default();
        let by = V6::new(1.0, -2.0, 3.0, 0.1, 0.2, -0.3);
        state.shift(&by);
        state.shift(&by);
        assert_eq!(state.position(), by * 2.0);
    }
}
