//! The robot's twin: where the six axes are, as far as their commands and their measured positions
//! say, and where they will be.

use super::chain::{Chain, Piece};
use super::pause::Pause;
use super::{KEPT, V6};

/// The velocities commanded in the last cycles.
#[derive(Clone, Debug)]
pub(super) struct Commands {
    ring: [[f64; 6]; KEPT],
    /// Number of the next command.
    pub(super) next: usize,
}

impl Commands {
    pub(super) fn new() -> Self {
        Self {
            ring: [[0.0; 6]; KEPT],
            next: 0,
        }
    }

    pub(super) fn push(&mut self, velocity: &V6) {
        if let Some(place) = self.ring.get_mut(self.next % KEPT) {
            *place = (*velocity).into();
        }
        self.next += 1;
    }

    /// The command that is executed in a cycle after a delay; zero before the first, and the newest
    /// one in place of one that is not sent yet.
    pub(super) fn of(&self, cycle: usize, delay: usize) -> [f64; 6] {
        let cycle = cycle.checked_sub(delay);
        let place = cycle.and_then(|cycle| self.place(cycle));
        place.copied().unwrap_or_default()
    }

    /// The same of one axis, without a delay.
    pub(super) fn of_axis(&self, cycle: usize, axis: usize) -> f64 {
        let place = self.place(cycle).and_then(|place| place.get(axis));
        place.copied().unwrap_or_default()
    }

    fn place(&self, cycle: usize) -> Option<&[f64; 6]> {
        let cycle = cycle.min(self.next.saturating_sub(1));
        let kept = cycle < self.next && cycle + KEPT >= self.next;
        self.ring.get(cycle % KEPT).filter(|_| kept)
    }
}

/// One axis.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Axis {
    state: [f64; 3],
    pause: Pause,
    /// Position, m.
    pub(super) position: f64,
    /// Velocity at the end of the last cycle, before the next command arrives, m/s.
    pub(super) velocity: f64,
}

impl Axis {
    /// Executes a cycle with the command of its first part and that of the rest.
    #[inline]
    pub(super) fn step(&mut self, plan: &Plan, older: f64, newer: f64) {
        self.pause.begin();
        let first = plan.chain.first_piece(older);
        let piece = plan.chain.step(&mut self.state, older, newer);
        let before = first
            .as_ref()
            .is_none_or(|first| self.pause.goes_on(first.end));
        let way = if before && self.pause.goes_on(piece.end) {
            self.velocity = piece.end;
            first.map_or(0.0, |first| first.way) + piece.way
        } else {
            self.turn(first.as_ref(), &piece, plan.pause)
        };
        self.position += way * plan.cycle_s;
    }

    /// A cycle with a reversal, a pause or a start; the way.
    #[inline(never)]
    fn turn(&mut self, first: Option<&Piece>, piece: &Piece, pause: f64) -> f64 {
        let mut way = first.map_or(0.0, |first| self.pause.execute(first, pause));
        way += self.pause.execute(piece, pause);
        self.velocity = if self.pause.stands() { 0.0 } else { piece.end };
        way
    }

    /// Whether a pause ended within the last cycle.
    pub(super) fn resumed(&self) -> bool {
        self.pause.ended()
    }
}

/// What all axes share.
#[derive(Clone, Debug)]
pub(super) struct Plan {
    pub(super) chain: Chain,
    /// Length of a pause, cycles.
    pub(super) pause: f64,
    pub(super) cycle_s: f64,
}

/// Six axes at one instant.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Axes(pub(super) [Axis; 6]);

impl Axes {
    pub(super) fn position(&self) -> V6 {
        V6::from(self.0.map(|axis| axis.position))
    }

    pub(super) fn velocity(&self) -> V6 {
        V6::from(self.0.map(|axis| axis.velocity))
    }

    /// Executes the cycle of that number with the commands that were sent.
    pub(super) fn step_sent(&mut self, plan: &Plan, commands: &Commands, cycle: usize) {
        let newer = commands.of(cycle, plan.chain.whole);
        let older = commands.of(cycle, plan.chain.whole + 1);
        for (i, axis) in self.0.iter_mut().enumerate() {
            axis.step(plan, older[i], newer[i]);
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
    use crate::delay::actuator::ActuatorSettings;
    use softdock_delay_plants::{Actuator, Dynamics, Plant, PlantSettings};

    const CYCLE_S: f64 = 0.004;

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

    /// Largest distance from the plant over a motion with reversals, m.
    fn distance(robot: Actuator) -> f64 {
        let plan = Plan {
            chain: Chain::new(&believed(&robot), CYCLE_S, 0.0, 60),
            pause: robot.pause_s / CYCLE_S,
            cycle_s: CYCLE_S,
        };
        let mut plant = Plant::new(&PlantSettings {
            actuator: robot,
            ..PlantSettings::default()
        });
        let (mut commands, mut axes) = (Commands::new(), Axes::default());
        let mut largest = 0.0_f64;
        for n in 0..400 {
            let t = f64::from(n) * CYCLE_S;
            let x = 0.005 * (9.0 * t).sin() + 0.001 * (31.0 * t).cos() + 3e-6;
            let command = [x, -x, 0.3 * x, 0.0, x, 0.0];
            let cycle = commands.next;
            commands.push(&V6::from(command));
            axes.step_sent(&plan, &commands, cycle);
            plant.step(command);
            let truth = plant.log().moments[cycle].position;
            let error = axes.position() - V6::from(truth);
            largest = largest.max(error.amax());
        }
        largest
    }

    /// The twin is where a plant is that shares no code with it: five structures, whole and broken
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
                let error = distance(Actuator {
                    delay_s,
                    dynamics,
                    pause_s,
                    ..ideal
                });
                let bound = if pause_s == 0.0 { 1e-9 } else { 1e-6 };
                assert!(error < bound, "{delay_s} {dynamics:?} {pause_s}: {error:e}");
            }
        }
    }
}
