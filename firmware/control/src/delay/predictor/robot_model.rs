//! The robot model: what each axis does with the velocities that it is sent.
//!
//! Dead time, first-order lag and second-order servo, discretised exactly for commands that are held for a
//! cycle; behind them the pause at a reversal: when the executed velocity changes its sign, the axis stands
//! still for a while and then goes on with what the command is by then. The displacement in between is lost.
//! Times are in cycles, velocities in units of the command:
//!
//! ```text
//! T x0' = u − x0          x1'' = ω² (x − x1) − 2 ζ ω x1'        x = x0, or u without a lag
//! ```

use super::V6;
use super::tuning::*;
use crate::delay::actuator::ActuatorSettings;
use nalgebra::{Matrix5, Vector5};

/// Rows in the vector of the matrix exponential: lag, servo, its rate, displacement, command.
const DISPLACEMENT: usize = 3;
const COMMAND: usize = 4;

/// The velocities commanded in the last cycles.
#[derive(Clone, Debug)]
pub(super) struct CommandHistory {
    ring: [[f64; 6]; COMMAND_HISTORY],
    /// Number of the next command.
    pub(super) next: usize,
}

impl CommandHistory {
    pub(super) fn new() -> Self {
        Self {
            ring: [[0.0; 6]; COMMAND_HISTORY],
            next: 0,
        }
    }

    pub(super) fn push(&mut self, velocity: &V6) {
        if let Some(slot) = self.ring.get_mut(self.next % COMMAND_HISTORY) {
            *slot = (*velocity).into();
        }
        self.next += 1;
    }

    /// The command that is executed in a cycle after a delay; zero before the first, and the newest
    /// one in place of one that is not sent yet.
    pub(super) fn of(&self, cycle: usize, delay: usize) -> [f64; 6] {
        let cycle = cycle.checked_sub(delay);
        let slot = cycle.and_then(|cycle| self.slot(cycle));
        slot.copied().unwrap_or_default()
    }

    /// The same of one axis, without a delay.
    pub(super) fn of_axis(&self, cycle: usize, axis: usize) -> f64 {
        let slot = self.slot(cycle).and_then(|slot| slot.get(axis));
        slot.copied().unwrap_or_default()
    }

    fn slot(&self, cycle: usize) -> Option<&[f64; 6]> {
        let cycle = cycle.min(self.next.saturating_sub(1));
        let kept = cycle + COMMAND_HISTORY >= self.next;
        self.ring.get(cycle % COMMAND_HISTORY).filter(|_| kept)
    }
}

/// The linear part of the model in steps of a cycle.
#[derive(Clone, Debug)]
pub(super) struct LinearDynamics {
    /// Whole cycles of dead time, and the part of a cycle beyond.
    pub(super) whole: usize,
    pub(super) fraction: f64,
    /// Mean delay of a slow motion, cycles.
    pub(super) mean_delay: f64,
    /// Rate of the lag, and frequency and damping ratio of the servo, per cycle.
    lag: Option<f64>,
    servo: Option<(f64, f64)>,
    /// There is neither: the executed velocity is the delayed command itself.
    pub(super) is_dead_time: bool,
    /// State, and displacement in the last row, after a cycle: from the states, the older and newer command.
    from_state: [[f64; 3]; 4],
    from_older: [f64; 4],
    from_newer: [f64; 4],
}

/// A part of a cycle of one axis before pauses: executed velocities, and displacement in cycles × velocity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Segment {
    /// Part of a cycle.
    duration: f64,
    start: f64,
    end: f64,
    displacement: f64,
}

impl LinearDynamics {
    fn new(settings: &ActuatorSettings, cycle_s: f64, latency: f64) -> Self {
        let lag = (settings.lag_s > 0.0).then(|| cycle_s / settings.lag_s);
        let omega = core::f64::consts::TAU * settings.servo_hz * cycle_s;
        let servo = settings
            .has_servo()
            .then_some((omega, settings.servo_damping));
        let mut dynamics = Self {
            whole: 0,
            fraction: 0.0,
            mean_delay: settings.mean_delay_s() / cycle_s + latency,
            lag,
            servo,
            is_dead_time: lag.is_none() && servo.is_none(),
            from_state: [[0.0; 3]; 4],
            from_older: [0.0; 4],
            from_newer: [0.0; 4],
        };
        dynamics.set_dead_time(settings.delay_s / cycle_s + latency);
        dynamics
    }

    /// Changes the dead time by so many cycles, within what the kept commands allow.
    pub(super) fn shift(&mut self, cycles: f64) {
        let dead_time = |of: &Self| of.whole as f64 + of.fraction;
        let old = dead_time(self);
        self.set_dead_time(old + cycles);
        self.mean_delay += dead_time(self) - old;
    }

    fn set_dead_time(&mut self, cycles: f64) {
        let cycles = cycles.clamp(0.0, LONGEST_DEAD_TIME as f64);
        // A dead time that is whole but for rounding is whole.
        let whole = (cycles + SAME_INSTANT) as usize;
        self.whole = whole;
        self.fraction = (cycles - whole as f64).max(0.0);
        self.discretise();
    }

    fn discretise(&mut self) {
        if self.is_dead_time {
            return;
        }
        let generator = self.generator();
        let older = exponential(&(generator * self.fraction));
        let newer = exponential(&(generator * (1.0 - self.fraction)));
        let through = |start: Vector5<f64>, change: f64| {
            let mut middle = older * start;
            middle[COMMAND] += change;
            newer * middle
        };
        let rows = |v: &Vector5<f64>| [v[0], v[1], v[2], v[DISPLACEMENT]];
        for i in 0..3 {
            let mut unit = Vector5::zeros();
            unit[i] = 1.0;
            let column = rows(&through(unit, 0.0));
            for (row, value) in self.from_state.iter_mut().zip(column) {
                row[i] = value;
            }
        }
        let mut command = Vector5::zeros();
        command[COMMAND] = 1.0;
        self.from_older = rows(&through(command, -1.0));
        self.from_newer = rows(&through(Vector5::zeros(), 1.0));
    }

    /// x' = M x for (lag, servo, servo rate, displacement, command).
    fn generator(&self) -> Matrix5<f64> {
        let mut m = Matrix5::zeros();
        let mut source = COMMAND;
        if let Some(rate) = self.lag {
            m[(0, 0)] = -rate;
            m[(0, COMMAND)] = rate;
            source = 0;
        }
        if let Some((omega, damping)) = self.servo {
            m[(1, 2)] = 1.0;
            m[(2, 1)] = -omega * omega;
            m[(2, 2)] = -2.0 * damping * omega;
            m[(2, source)] = omega * omega;
            source = 1;
        }
        m[(DISPLACEMENT, source)] = 1.0;
        m
    }

    /// Executed velocity in a state that is not of a pure dead time.
    fn output(&self, state: &[f64; 3]) -> f64 {
        if self.servo.is_some() {
            state[1]
        } else {
            state[0]
        }
    }

    /// One cycle: the command of `fraction` of it, and the one of the rest. What is executed, were
    /// there no pause; of a pure dead time from `newer` alone, for which [`Self::first_segment`] stands
    /// beside it.
    #[inline]
    fn step(&self, state: &mut [f64; 3], older: f64, newer: f64) -> Segment {
        if self.is_dead_time {
            let duration = 1.0 - self.fraction;
            return Segment {
                duration,
                start: newer,
                end: newer,
                displacement: newer * duration,
            };
        }
        self.respond(state, older, newer)
    }

    /// The same of a lag or a servo.
    #[inline]
    fn respond(&self, state: &mut [f64; 3], older: f64, newer: f64) -> Segment {
        let start = self.output(state);
        let old = *state;
        let commands = |r: usize| self.from_older[r] * older + self.from_newer[r] * newer;
        // The states that a robot does not have stay zero.
        let row = |r: usize| {
            let [lag, servo, rate] = self.from_state[r];
            commands(r) + lag * old[0] + servo * old[1] + rate * old[2]
        };
        // No other state feeds the lag.
        let lag = commands(0) + self.from_state[0][0] * old[0];
        *state = [lag, row(1), row(2)];
        Segment {
            duration: 1.0,
            start,
            end: self.output(state),
            displacement: row(DISPLACEMENT),
        }
    }

    /// What a pure dead time executes of the older command, if anything.
    #[inline]
    fn first_segment(&self, older: f64) -> Option<Segment> {
        let duration = self.fraction;
        (self.is_dead_time && duration > 0.0).then_some(Segment {
            duration,
            start: older,
            end: older,
            displacement: older * duration,
        })
    }

    /// Displacement after 0, 1, 2 ... cycles of a unit command that lasts for the first cycle alone; the
    /// `advance` cycles before it are left out.
    pub(super) fn pulse_response<const N: usize>(&self, advance: usize) -> [f64; N] {
        let (mut state, mut displacement) = ([0.0; 3], 0.0);
        let mut response = [0.0; N];
        let command = |cycle: i64| if cycle == 0 { 1.0 } else { 0.0 };
        let whole = self.whole as i64;
        for cycle in 0..(N + advance) as i64 {
            if let Some(index) = (cycle as usize).checked_sub(advance)
                && let Some(value) = response.get_mut(index)
            {
                *value = displacement;
            }
            let (older, newer) = (command(cycle - whole - 1), command(cycle - whole));
            let first = self.first_segment(older);
            displacement += first.map_or(0.0, |segment| segment.displacement);
            displacement += self.step(&mut state, older, newer).displacement;
        }
        response
    }
}

/// e^M by scaling, series and squaring.
fn exponential(m: &Matrix5<f64>) -> Matrix5<f64> {
    let (mut size, mut scale, mut halvings) = (m.amax() * 5.0, 1.0, 0);
    while size > 0.5 && halvings < 30 {
        size *= 0.5;
        scale *= 0.5;
        halvings += 1;
    }
    let m = m * scale;
    let mut term = Matrix5::identity();
    let mut sum = term;
    for k in 1..=EXPONENTIAL_TERMS {
        term = term * m / f64::from(k);
        sum += term;
    }
    for _ in 0..halvings {
        sum *= sum;
    }
    sum
}

/// The pause of one axis.
#[derive(Clone, Copy, Debug, Default)]
struct Pause {
    /// Direction of the last motion: −1, 0, 1.
    direction: f64,
    /// Cycles of standstill that are left.
    left: f64,
    /// A pause ended with the last segment.
    resumes: bool,
    /// A pause ended within the last cycle or with it.
    ended: bool,
}

impl Pause {
    /// Whether the axis goes on into a velocity in the direction in which it moves, or rests: nearly
    /// all cycles.
    #[inline]
    fn goes_on(&self, v: f64) -> bool {
        self.left <= 0.0 && !self.resumes && (v * self.direction > 0.0 || v == 0.0)
    }

    /// Executes a segment with pauses of `length` cycles; answers the displacement.
    fn execute(&mut self, segment: &Segment, length: f64) -> f64 {
        let Segment {
            duration,
            start,
            end,
            displacement,
        } = *segment;
        // What does not keep its velocity lasts for a whole cycle.
        let at = |t: f64| start + (end - start) * t;
        let between = |from: f64, to: f64| 0.5 * (at(from) + at(to)) * (to - from);
        if self.left >= duration - SAME_INSTANT {
            self.stand_still(duration);
            return 0.0;
        }
        let mut begin = 0.0;
        if self.left > 0.0 || core::mem::take(&mut self.resumes) {
            begin = self.left;
            self.left = 0.0;
            self.ended |= begin > 0.0;
            // What turned once more within the pause goes on without another one.
            self.direction = direction(at(begin)).unwrap_or(self.direction);
        }
        let turns = direction(end).is_some_and(|d| d * self.direction < 0.0);
        if !turns || length <= 0.0 {
            self.direction = direction(end).unwrap_or(self.direction);
            return if begin > 0.0 {
                between(begin, duration)
            } else {
                displacement
            };
        }
        // The moment of reversal; a velocity that jumped turned at the beginning.
        let turn = if start != end {
            (start / (start - end)).clamp(begin, duration)
        } else {
            begin
        };
        self.direction = -self.direction;
        let before = between(begin, turn);
        let rest = duration - turn;
        if length >= rest {
            self.left = length - rest;
            return before;
        }
        self.ended = true;
        before + between(turn + length, duration)
    }

    /// A segment within a pause.
    fn stand_still(&mut self, duration: f64) {
        self.left -= duration;
        if self.left < SAME_INSTANT {
            self.left = 0.0;
            self.resumes = true;
            self.ended = true;
        }
    }
}

fn direction(v: f64) -> Option<f64> {
    (v.abs() > ZERO_VELOCITY).then(|| if v > 0.0 { 1.0 } else { -1.0 })
}

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

    /// Dead time and pause in cycles, lag and servo.
    fn robot(delay: f64, pause: f64, lag_s: f64, servo_hz: f64) -> ActuatorSettings {
        ActuatorSettings {
            delay_s: delay * CYCLE_S,
            pause_s: pause * CYCLE_S,
            lag_s,
            servo_hz,
            ..ActuatorSettings::default()
        }
    }

    /// In every bit, whatever the robot and wherever it turns, rests and starts.
    #[test]
    fn following_commands_is_executing_each() {
        let commands: [f64; 90] = core::array::from_fn(|n| {
            let t = n as f64 * CYCLE_S;
            let command = 0.005 * (9.0 * t).sin() + 0.002 * (61.0 * t).cos();
            if n % 40 < 9 { 0.0 } else { command }
        });
        for (delay, lag_s) in [(2.0, 0.0), (2.3, 0.0), (0.0, 0.0), (1.5, 0.016)] {
            for pause in [0.0, 0.4, 4.0] {
                let model = RobotModel::new(&robot(delay, pause, lag_s, 0.0), CYCLE_S, 0.0);
                let mut each = AxisState::default();
                let expected: [f64; 89] = core::array::from_fn(|n| {
                    each.step(&model, commands[n], commands[n + 1]);
                    each.position
                });
                let (mut at_once, mut path) = (AxisState::default(), [0.0; 89]);
                at_once.follow(&model, &commands, &mut path);
                assert_eq!(path.map(f64::to_bits), expected.map(f64::to_bits));
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

    /// Of a command that lasts for one cycle; in the end it is as long as that.
    #[test]
    fn the_pulse_response_is_the_way_of_a_robot_that_gets_one_command() {
        for (delay, lag_s, servo_hz) in [
            (0.0, 0.0, 0.0),
            (3.0, 0.0, 0.0),
            (7.3, 0.0, 0.0),
            (2.6, 0.016, 0.0),
            (1.0, 0.0, 10.0),
            (4.5, 0.008, 20.0),
        ] {
            for latency in [0, 1, 3] {
                let settings = robot(delay, 0.0, lag_s, servo_hz);
                let model = RobotModel::new(&settings, CYCLE_S, latency as f64);
                let (mut commands, mut axes) = (CommandHistory::new(), RobotState::default());
                commands.push(&V6::repeat(1.0));
                for _ in 0..60 {
                    commands.push(&V6::zeros());
                }
                let response: [f64; 50] = model.linear.pulse_response(latency);
                for n in 0..response.len() + latency {
                    if let Some(t) = n.checked_sub(latency) {
                        let way = axes.position()[0] / CYCLE_S;
                        assert!((response[t] - way).abs() < 1e-12, "{settings:?} {t}: {way}");
                    }
                    axes.step_sent(&model, &commands, n);
                }
                assert!((response[49] - 1.0).abs() < 1e-2, "{settings:?}");
            }
        }
    }

    /// Up to none, and as long as the commands of all latencies are kept.
    #[test]
    fn a_robot_that_is_later_is_one_with_a_longer_dead_time() {
        for (lag_s, servo_hz) in [(0.0, 0.0), (0.016, 0.0), (0.0, 10.0)] {
            for (later, dead_time) in [(1.3, 5.8), (-2.0, 2.5), (-9.0, 0.0), (99.0, 68.0)] {
                let dynamics = |dead_time| {
                    LinearDynamics::new(&robot(dead_time, 0.0, lag_s, servo_hz), CYCLE_S, 0.0)
                };
                let (mut moved, expected) = (dynamics(4.5), dynamics(dead_time));
                moved.shift(later);
                assert!((moved.mean_delay - expected.mean_delay).abs() < 1e-9);
                let responses: [[f64; 90]; 2] =
                    [moved.pulse_response(0), expected.pulse_response(0)];
                let pairs = responses[0].iter().zip(&responses[1]);
                for (found, expected) in pairs {
                    assert!(
                        (found - expected).abs() < 1e-9,
                        "{later}: {found} {expected}"
                    );
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

    /// The last 76; before the first nothing was commanded, and what is not sent yet is the newest.
    #[test]
    fn commands_are_remembered_for_as_long_as_the_longest_dead_time() {
        let mut commands = CommandHistory::new();
        assert_eq!(commands.of(0, 0), [0.0; 6]);
        for n in 0..200 {
            commands.push(&V6::from_fn(|axis, _| f64::from(n) + axis as f64 / 8.0));
        }
        for (cycle, delay, newest) in [
            (199, 0, Some(199)),
            (230, 2, Some(199)),
            (230, 40, Some(190)),
            (199, 75, Some(124)),
            (199, 76, None),
            (10, 20, None),
        ] {
            let expected = |axis: usize| newest.map_or(0.0, |n| f64::from(n) + axis as f64 / 8.0);
            assert_eq!(commands.of(cycle, delay), core::array::from_fn(expected));
            if cycle >= delay {
                assert_eq!(commands.of_axis(cycle - delay, 3), expected(3));
            }
        }
    }

    /// A decay, a turn of 20 rad and a chain of integrators; of all sizes.
    #[test]
    fn the_exponential_is_that_of_known_motions() {
        for rate in [1e-3, 0.3, 2.0, 30.0] {
            let mut m = Matrix5::zeros();
            (m[(0, 0)], m[(1, 2)], m[(2, 1)], m[(4, 3)]) = (-rate, rate, -rate, rate);
            let e = exponential(&m);
            let (sin, cos) = rate.sin_cos();
            for (found, expected) in [
                (e[(0, 0)] / (-rate).exp(), 1.0),
                (e[(1, 1)], cos),
                (e[(1, 2)], sin),
                (e[(2, 1)], -sin),
                (e[(4, 3)], rate),
                (e[(3, 3)], 1.0),
                (e[(0, 1)], 0.0),
            ] {
                assert!(
                    (found - expected).abs() < 1e-13 * rate.max(10.0),
                    "{rate}: {found} {expected}"
                );
            }
        }
        // A number that is none, but within the settings' range, must not keep the loop.
        assert!(!exponential(&Matrix5::repeat(f64::INFINITY))[(0, 0)].is_finite());
    }
}
