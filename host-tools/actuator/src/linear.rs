//! The linear stages: lags and a mode, exact for an input that is constant over a segment.

use super::chain::{Chain, Resonance};
use nalgebra::{SMatrix, SVector};

/// Velocity over a part of a cycle.
#[derive(Clone, Copy, Debug)]
pub(super) struct PartVelocity {
    /// Mean.
    pub mean: f64,
    /// At its end.
    pub end: f64,
}

impl PartVelocity {
    /// The same throughout.
    pub(super) fn constant(velocity: f64) -> Self {
        Self {
            mean: velocity,
            end: velocity,
        }
    }
}

/// Lag, extra lag and resonance, with responses cached by duration.
#[derive(Clone)]
pub(super) struct LinearStages {
    lags_s: [f64; 2],
    resonance: Option<Resonance>,
    /// Outputs of the two lags, output of the mode, and its rate divided by the natural frequency.
    state: [f64; 4],
    /// Responses by duration.
    known: Vec<Response>,
    /// Index of the response used last, which is mostly the next one as well.
    last: usize,
    /// The last two durations of a single lag, the newer first, and the share of an offset that is left after each. Two, because
    /// the arrival of a command cuts a cycle in two.
    left: [(f64, f64); 2],
    /// Responses for binary digits of a second; empty until a duration occurs only once.
    digits: Vec<Response>,
}

/// Response of the stages over some time: the new states and the mean of the output, as linear functions of the old states and
/// the input.
#[derive(Clone, Copy)]
struct Response {
    duration_s: f64,
    rows: [[f64; 5]; 5],
}

impl Response {
    /// Moves the states on; returns the mean of the output.
    fn advance(&self, state: &mut [f64; 4], input: f64) -> f64 {
        let [a, b, c, d] = *state;
        let row =
            |row: &[f64; 5]| row[0] * a + row[1] * b + row[2] * c + row[3] * d + row[4] * input;
        let [to_a, to_b, to_c, to_d, to_mean] = &self.rows;
        *state = [row(to_a), row(to_b), row(to_c), row(to_d)];
        row(to_mean)
    }
}

/// A shorter lag counts as none, s.
const NO_LAG_S: f64 = 1e-9;
/// Number of responses that are kept: with more durations, cycles are not alike and keeping them is not worthwhile.
const REMEMBERED: usize = 8;

impl LinearStages {
    pub(super) fn new(chain: &Chain) -> Self {
        Self {
            lags_s: [chain.lag_s, chain.extra_lag_s],
            resonance: chain.resonance,
            state: [0.0; 4],
            known: Vec::with_capacity(REMEMBERED),
            last: 0,
            left: [(0.0, 1.0); 2],
            digits: Vec::new(),
        }
    }

    /// State and time constant, s, of the lag, if it is the only linear stage. None otherwise; a lag without duration has no
    /// state.
    pub(super) fn single_lag(&self) -> Option<(f64, f64)> {
        (!self.is_cascade() && self.lags_s[0] >= NO_LAG_S)
            .then_some((self.state[0], self.lags_s[0]))
    }

    /// States of the lags; None if there is a resonance behind them, which may oscillate.
    pub(super) fn lags(&self) -> Option<impl Iterator<Item = f64>> {
        let lags = self.state.into_iter().zip(self.lags_s);
        let lags = lags.filter(|(_, lag_s)| *lag_s >= NO_LAG_S).map(|l| l.0);
        self.resonance.is_none().then_some(lags)
    }

    /// Whether a stage has another one's output as its input.
    fn is_cascade(&self) -> bool {
        self.lags_s[1] >= NO_LAG_S || self.resonance.is_some()
    }

    /// Whether the stages pass their input unchanged.
    pub(super) fn is_nothing(&self) -> bool {
        !self.is_cascade() && self.lags_s[0] < NO_LAG_S
    }

    /// Sets the states to rest, for an axis that restarts.
    pub(super) fn reset(&mut self) {
        self.state = [0.0; 4];
    }

    /// Advances by a duration with a constant input. `once`: no other segment has this duration.
    pub(super) fn advance(&mut self, input: f64, duration_s: f64, once: bool) -> PartVelocity {
        if !self.is_cascade() {
            return self.lagged(input, duration_s);
        }
        if once {
            return self.in_digits(input, duration_s);
        }
        let response = self.response(duration_s);
        self.apply(input, &response)
    }

    /// Advances by a duration that does not recur, as a sum of binary digits of a second, whose responses do.
    fn in_digits(&mut self, input: f64, duration_s: f64) -> PartVelocity {
        /// First and last digit: 62.5 ms and 4 ps.
        const DIGITS: std::ops::RangeInclusive<i32> = 4..=38;
        if self.digits.is_empty() {
            let respond = |digit: i32| self.respond(0.5_f64.powi(digit));
            self.digits = DIGITS.map(respond).collect();
        }
        let (mut left_s, mut path) = (duration_s, 0.0);
        for digit in &self.digits {
            while left_s >= digit.duration_s {
                path += digit.advance(&mut self.state, input) * digit.duration_s;
                left_s -= digit.duration_s;
            }
        }
        let advanced_s = duration_s - left_s;
        if advanced_s <= 0.0 {
            return PartVelocity::constant(input);
        }
        PartVelocity {
            mean: path / advanced_s,
            end: self.output(),
        }
    }

    fn apply(&mut self, input: f64, response: &Response) -> PartVelocity {
        let mean = response.advance(&mut self.state, input);
        let end = self.output();
        PartVelocity { mean, end }
    }

    /// Output of a cascade: its last state.
    fn output(&self) -> f64 {
        match (self.resonance, self.lags_s[1] >= NO_LAG_S) {
            (Some(_), _) => self.state[2],
            (None, true) => self.state[1],
            (None, false) => self.state[0],
        }
    }

    /// A single lag, or none.
    fn lagged(&mut self, input: f64, duration_s: f64) -> PartVelocity {
        let lag_s = self.lags_s[0];
        if lag_s < NO_LAG_S {
            return PartVelocity::constant(input);
        }
        if !is_as_long(self.left[0].0, duration_s) {
            self.left.swap(0, 1);
        }
        if !is_as_long(self.left[0].0, duration_s) {
            self.left[0] = (duration_s, (-duration_s / lag_s).exp());
        }
        let left = self.left[0].1;
        let offset = self.state[0] - input;
        self.state[0] = input + offset * left;
        PartVelocity {
            mean: input + offset * lag_s / duration_s * (1.0 - left),
            end: self.state[0],
        }
    }

    fn response(&mut self, duration_s: f64) -> Response {
        let same = |r: &Response| is_as_long(r.duration_s, duration_s);
        if let Some(last) = self.known.get(self.last).filter(|r| same(r)) {
            return *last;
        }
        if let Some(place) = self.known.iter().position(same) {
            self.last = place;
            return self.known[place];
        }
        let response = self.respond(duration_s);
        if self.known.len() == REMEMBERED {
            self.known.clear();
        }
        self.last = self.known.len();
        self.known.push(response);
        response
    }

    /// Matrix exponential of `T1 a' = u − a`, `T2 b' = a − b`, `c' = w d`,
    /// `d' = w (b − c − 2 ζ d)`, with the integral of the output and the input as further states.
    /// A lag of no duration is left out.
    fn respond(&self, duration_s: f64) -> Response {
        const INTEGRAL: usize = 4;
        const INPUT: usize = 5;
        let mut rates = SMatrix::<f64, 6, 6>::zeros();
        let mut source = INPUT;
        for (place, lag_s) in self.lags_s.into_iter().enumerate() {
            if lag_s >= NO_LAG_S {
                rates[(place, source)] += 1.0 / lag_s;
                rates[(place, place)] -= 1.0 / lag_s;
                source = place;
            }
        }
        if let Some(mode) = self.resonance {
            let w = std::f64::consts::TAU * mode.frequency_hz;
            let zeta = mode.damping_ratio.clamp(0.0, 0.999);
            rates[(2, 3)] = w;
            rates[(3, 2)] = -w;
            rates[(3, 3)] = -2.0 * zeta * w;
            rates[(3, source)] += w;
            source = 2;
        }
        rates[(INTEGRAL, source)] = 1.0;
        let whole = exponential(&(rates * duration_s));
        let row = |from: usize, scale: f64| {
            let row: SVector<f64, 6> = whole.row(from).transpose() * scale;
            [row[0], row[1], row[2], row[3], row[INPUT]]
        };
        Response {
            duration_s,
            rows: [
                row(0, 1.0),
                row(1, 1.0),
                row(2, 1.0),
                row(3, 1.0),
                row(INTEGRAL, 1.0 / duration_s),
            ],
        }
    }
}

/// Whether two times are one but for rounding: parts of a cycle are differences of sums.
fn is_as_long(one_s: f64, other_s: f64) -> bool {
    (one_s - other_s).abs() < 1e-12
}

/// Exponential of a matrix by scaling and squaring (Moler and Van Loan 2003, method 3) of Taylor's
/// series, whose remainder is below rounding at a norm of 1/16.
fn exponential(matrix: &SMatrix<f64, 6, 6>) -> SMatrix<f64, 6, 6> {
    const TERMS: u32 = 9;
    let norm = matrix.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
    let halvings = (6.0 * norm * 16.0).log2().ceil().clamp(0.0, 60.0) as i32;
    let small = matrix * 0.5_f64.powi(halvings);
    let mut term = SMatrix::identity();
    let mut sum = SMatrix::identity();
    for k in 1..=TERMS {
        term = term * small / f64::from(k);
        sum += term;
    }
    (0..halvings).fold(sum, |whole, _| whole * whole)
}
