//! Response of an axis to the commanded velocities, without its pauses: dead time, first-order lag and second-order servo,
//! discretised exactly for commands that are held for a cycle.
//!
//! ```text
//! T x0' = u − x0          x1'' = ω² (x − x1) − 2 ζ ω x1'        x = x0, or u without a lag
//! ```
//!
//! Times are in cycles, velocities in units of the command.

use super::V6;
use super::tuning::*;
use crate::delay::actuator::ActuatorSettings;
use nalgebra::{Matrix5, Vector5};

/// Rows of the state vector for the matrix exponential: lag, servo, its rate, displacement, command.
const DISPLACEMENT: usize = 3;
const COMMAND: usize = 4;

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
    /// There is neither lag nor servo: the executed velocity is the delayed command itself.
    pub(super) is_dead_time: bool,
    /// Matrices that give the state (rows 0 to 2) and the displacement (row 3) after a cycle: from the state before, the older
    /// and the newer command.
    from_state: [[f64; 3]; 4],
    from_older: [f64; 4],
    from_newer: [f64; 4],
}

/// Motion of one axis, without pauses, in a part of a cycle: executed velocities at its ends, and displacement in cycles ×
/// velocity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Segment {
    /// Part of a cycle.
    pub(super) duration: f64,
    pub(super) start: f64,
    pub(super) end: f64,
    pub(super) displacement: f64,
}

impl LinearDynamics {
    /// From the settings of the robot; `latency` is that of the reported pose, in cycles.
    pub(super) fn new(settings: &ActuatorSettings, cycle_s: f64, latency: f64) -> Self {
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
            let column = rows(&through(Vector5::ith(i, 1.0), 0.0));
            for (row, value) in self.from_state.iter_mut().zip(column) {
                row[i] = value;
            }
        }
        self.from_older = rows(&through(Vector5::ith(COMMAND, 1.0), -1.0));
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

    /// Executed velocity in a state; not for a pure dead time.
    fn output(&self, state: &[f64; 3]) -> f64 {
        if self.servo.is_some() {
            state[1]
        } else {
            state[0]
        }
    }

    /// One cycle: `older` is the command of its first part (`fraction`), `newer` that of the rest. Returns the motion without
    /// pauses. For a pure dead time that is the part under `newer` alone; [`Self::first_segment`] gives the part under `older`.
    #[inline]
    pub(super) fn step(&self, state: &mut [f64; 3], older: f64, newer: f64) -> Segment {
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

    /// [`Self::step`] of a lag or a servo.
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

    /// The part of a cycle that a pure dead time executes under the older command, if any.
    #[inline]
    pub(super) fn first_segment(&self, older: f64) -> Option<Segment> {
        let duration = self.fraction;
        (self.is_dead_time && duration > 0.0).then_some(Segment {
            duration,
            start: older,
            end: older,
            displacement: older * duration,
        })
    }

    /// Displacement of all axes of a pure dead time in a cycle, both parts together, without pauses; in cycles × velocity.
    #[inline]
    pub(super) fn dead_time_displacement(&self, older: &V6, newer: &V6) -> V6 {
        older * self.fraction + newer * (1.0 - self.fraction)
    }

    /// Displacement in each cycle as the trapezoidal sum of the sampled velocities gives it, for these positions after 0, 1, 2 ...
    /// cycles without pauses; 0 for the first. A robot behind a pure dead time changes its velocity at once: where that is just after
    /// a sample, the samples lag by half a cycle, and where it is just before one, they lead by as much. The mean velocity of a cycle
    /// stands for that of its end here, which is exact in the sum as soon as the velocity is constant for two cycles.
    pub(super) fn sampled<const N: usize>(&self, positions: &[f64; N]) -> [f64; N] {
        let lag = if self.is_dead_time {
            0.5 - self.fraction
        } else {
            0.0
        };
        let mut before = 0.0;
        core::array::from_fn(|t| {
            let moved = t
                .checked_sub(1)
                .map_or(0.0, |t| positions[t + 1] - positions[t]);
            let sampled = moved + lag * (before - moved);
            before = moved;
            sampled
        })
    }

    /// Displacement after 0, 1, 2 ... cycles of a unit command that lasts for the first cycle alone; the first `advance` cycles
    /// are left out.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::delay::predictor::command_history::CommandHistory;
    use crate::delay::predictor::robot_model::{RobotModel, RobotState};
    use crate::delay::predictor::scene::robot;
    use crate::delay::spacecraft::CYCLE_S;

    /// For any time of the changes within a cycle, in the sum up to a motion that goes on.
    #[test]
    fn samples_lag_or_lead_where_the_velocity_jumps() {
        for (delay, lag_s) in [
            (3.0, 0.0),
            (3.25, 0.0),
            (3.5, 0.0),
            (3.75, 0.0),
            (3.95, 0.0),
            (3.0, 0.016),
        ] {
            let settings = robot(delay, 0.0, lag_s, 0.0);
            let model = RobotModel::new(&settings, CYCLE_S, 0.0);
            let (mut commands, mut axes) = (CommandHistory::new(), RobotState::default());
            let velocities = [0.3, 1.0, 0.7, 2.0, 2.0, 2.0];
            velocities
                .iter()
                .for_each(|v| commands.push(&V6::repeat(*v)));
            (0..30).for_each(|_| commands.push(&V6::repeat(2.0)));
            let (mut positions, mut trapezoids) = ([0.0; 31], 0.0);
            for n in 0..30 {
                let before = axes.velocity[0];
                axes.step_sent(&model, &commands, n);
                positions[n + 1] = axes.position[0] / CYCLE_S;
                trapezoids += 0.5 * (before + axes.velocity[0]);
            }
            let sum: f64 = model.linear.sampled(&positions).iter().sum();
            let apart = sum - trapezoids;
            // A lag rounds the velocity; its trapezoids are those of a curve.
            let bound = if lag_s > 0.0 { 0.05 } else { 1e-12 };
            assert!(apart.abs() < bound, "{delay} {lag_s}: {apart:e}");
        }
    }

    /// The displacement by a command of one cycle, which is in the end one cycle.
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
                        let way = axes.position[0] / CYCLE_S;
                        assert!((response[t] - way).abs() < 1e-12, "{settings:?} {t}: {way}");
                    }
                    axes.step_sent(&model, &commands, n);
                }
                assert!((response[49] - 1.0).abs() < 1e-2, "{settings:?}");
            }
        }
    }

    /// The dead time stays between zero and the longest one for which the commands of all latencies are kept.
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

    /// A decay, a rotation by 20 rad and a chain of integrators, of all sizes.
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
        // Infinity must not make the loop endless.
        assert!(!exponential(&Matrix5::repeat(f64::INFINITY))[(0, 0)].is_finite());
    }
}
