//! The linear part of the robot: transport delay, first-order lag, second-order servo, exactly
//! discretised for commands that are held for a cycle.
//!
//! Times are in cycles, velocities in units of the command: y is the executed velocity.
//!
//! ```text
//! T x0' = u − x0          x1'' = ω² (x − x1) − 2 ζ ω x1'        x = x0, or u without a lag
//! ```

use crate::delay::actuator::ActuatorSettings;
use nalgebra::{Matrix5, Vector5};

/// Places in the vector of the matrix exponential: lag, servo, its rate, way, command.
const WAY: usize = 3;
const COMMAND: usize = 4;

/// Terms of the exponential's series; with a norm of at most 1/2 the next one is below 1e-17.
const TERMS: u32 = 13;

/// One cycle of the robot's linear part.
#[derive(Clone, Debug)]
pub(super) struct Chain {
    /// Whole cycles of transport delay, and the part of a cycle beyond.
    pub(super) whole: usize,
    pub(super) fraction: f64,
    /// Mean delay of a slow motion, cycles.
    pub(super) mean: f64,
    /// Active states: `first..end` of lag, servo, servo rate.
    first: usize,
    end: usize,
    /// State, and way in the last row, after a cycle: from the states, the older and newer command.
    from_state: [[f64; 3]; 4],
    from_older: [f64; 4],
    from_newer: [f64; 4],
    rates: Rates,
    /// Largest transport delay that the commands kept allow, cycles.
    longest: f64,
}

/// Continuous rates, per cycle.
#[derive(Clone, Copy, Debug)]
struct Rates {
    lag: Option<f64>,
    servo: Option<(f64, f64)>,
}

/// A cycle of one axis before pauses: executed velocities and way (in cycles × velocity).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Piece {
    /// Part of a cycle.
    pub(super) duration: f64,
    pub(super) start: f64,
    pub(super) end: f64,
    pub(super) way: f64,
}

impl Chain {
    /// From what is believed; `extra` cycles of latency stand behind it.
    pub(super) fn new(
        settings: &ActuatorSettings,
        cycle_s: f64,
        extra: f64,
        longest: usize,
    ) -> Self {
        let lag = (settings.lag_s > 0.0).then(|| cycle_s / settings.lag_s);
        let omega = core::f64::consts::TAU * settings.servo_hz * cycle_s;
        let servo = settings
            .has_servo()
            .then_some((omega, settings.servo_damping));
        let mut chain = Self {
            whole: 0,
            fraction: 0.0,
            mean: settings.mean_delay_s() / cycle_s + extra,
            first: if lag.is_some() { 0 } else { 1 },
            end: if servo.is_some() { 3 } else { 1 },
            from_state: [[0.0; 3]; 4],
            from_older: [0.0; 4],
            from_newer: [0.0; 4],
            rates: Rates { lag, servo },
            longest: longest as f64,
        };
        chain.set_delay(settings.delay_s / cycle_s + extra);
        chain
    }

    /// Whether the executed velocity is the delayed command itself.
    pub(super) fn is_pure(&self) -> bool {
        self.first >= self.end
    }

    /// Transport delay, cycles.
    pub(super) fn delay(&self) -> f64 {
        self.whole as f64 + self.fraction
    }

    /// Changes the transport delay by so many cycles, within what the kept commands allow.
    pub(super) fn shift(&mut self, cycles: f64) {
        let old = self.delay();
        self.set_delay(old + cycles);
        self.mean += self.delay() - old;
    }

    fn set_delay(&mut self, cycles: f64) {
        let cycles = cycles.clamp(0.0, self.longest);
        // A delay that is whole but for rounding is whole.
        let whole = (cycles + 1e-9) as usize;
        self.whole = whole;
        self.fraction = (cycles - whole as f64).max(0.0);
        self.discretise();
    }

    fn discretise(&mut self) {
        if self.is_pure() {
            return;
        }
        let generator = self.rates.generator();
        let older = exponential(&(generator * self.fraction));
        let newer = exponential(&(generator * (1.0 - self.fraction)));
        let through = |start: Vector5<f64>, change: f64| {
            let mut middle = older * start;
            middle[COMMAND] += change;
            newer * middle
        };
        let rows = |v: &Vector5<f64>| [v[0], v[1], v[2], v[WAY]];
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

    /// Executed velocity in a state that is not of a pure delay.
    fn output(&self, state: &[f64; 3]) -> f64 {
        if self.end == 3 { state[1] } else { state[0] }
    }

    /// One cycle: the command of `fraction` of it, and the one of the rest. What is executed, were
    /// there no pause; of a pure delay from `newer` alone, for which [`Chain::first_piece`] stands
    /// beside it.
    #[inline]
    pub(super) fn step(&self, state: &mut [f64; 3], older: f64, newer: f64) -> Piece {
        if self.is_pure() {
            let duration = 1.0 - self.fraction;
            return Piece {
                duration,
                start: newer,
                end: newer,
                way: newer * duration,
            };
        }
        let start = self.output(state);
        let old = *state;
        // The states that a robot does not have stay zero.
        let row = |r: usize| {
            let [lag, servo, rate] = self.from_state[r];
            let commands = self.from_older[r] * older + self.from_newer[r] * newer;
            commands + lag * old[0] + servo * old[1] + rate * old[2]
        };
        *state = [row(0), row(1), row(2)];
        Piece {
            duration: 1.0,
            start,
            end: self.output(state),
            way: row(WAY),
        }
    }

    /// What a pure delay executes of the older command, if anything.
    #[inline]
    pub(super) fn first_piece(&self, older: f64) -> Option<Piece> {
        let duration = self.fraction;
        (self.is_pure() && duration > 0.0).then_some(Piece {
            duration,
            start: older,
            end: older,
            way: older * duration,
        })
    }

    /// Way after 0, 1, 2 ... cycles of a unit command that lasts for the first cycle alone; the
    /// `advance` cycles before it are left out.
    pub(super) fn response<const N: usize>(&self, advance: usize) -> [f64; N] {
        let (mut state, mut way) = ([0.0; 3], 0.0);
        let mut response = [0.0; N];
        let command = |cycle: i64| if cycle == 0 { 1.0 } else { 0.0 };
        let whole = self.whole as i64;
        for cycle in 0..(N + advance) as i64 {
            if let Some(place) = (cycle as usize).checked_sub(advance)
                && let Some(value) = response.get_mut(place)
            {
                *value = way;
            }
            let (older, newer) = (command(cycle - whole - 1), command(cycle - whole));
            way += self.first_piece(older).map_or(0.0, |piece| piece.way);
            way += self.step(&mut state, older, newer).way;
        }
        response
    }
}

impl Rates {
    /// x' = M x for (lag, servo, servo rate, way, command).
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
        m[(WAY, source)] = 1.0;
        m
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
    for k in 1..=TERMS {
        term = term * m / f64::from(k);
        sum += term;
    }
    for _ in 0..halvings {
        sum *= sum;
    }
    sum
}
