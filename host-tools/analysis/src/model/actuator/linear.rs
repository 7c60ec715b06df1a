//! The linear stages: lags and a mode, exact for an input that is constant over a part.

use super::chain::{Chain, Resonance};
use super::cut::Segment;
use super::nonlinear::Moved;

/// Lag, extra lag and resonance, with what they need for parts of equal duration.
pub(super) struct LinearStages {
    lags_s: [f64; 2],
    resonance: Option<Resonance>,
    state: [f64; 2],
    /// Deviation and scaled rate of the mode.
    mode: [f64; 2],
    /// Responses by duration: few durations occur, over and over.
    known: Vec<Response>,
    /// The one that was used last, which is mostly the next one, too.
    last: usize,
    /// What whole segments do, by their number.
    whole: Vec<Option<Whole>>,
}

/// Several parts in one: states (two lags, deviation and rate of the mode) behind them, mean and
/// end, each from the states before and the input.
#[derive(Clone, Copy, Default)]
struct Whole {
    states: [[f64; 5]; 4],
    mean: [f64; 5],
    end: [f64; 5],
}

#[derive(Clone, Copy)]
struct Response {
    duration_s: f64,
    /// What is left of an offset, and its mean over the part, per lag.
    lags: [(f64, f64); 2],
    transition: [[f64; 2]; 2],
}

/// A lag below this is none, s.
const NO_LAG_S: f64 = 1e-9;
/// More durations than this are not worth keeping: the cycles are not alike.
const REMEMBERED: usize = 8;

impl LinearStages {
    pub(super) fn new(chain: &Chain) -> Self {
        Self {
            lags_s: [chain.lag_s, chain.extra_lag_s],
            resonance: chain.resonance,
            state: [0.0; 2],
            mode: [0.0; 2],
            known: Vec::with_capacity(REMEMBERED),
            last: 0,
            whole: Vec::new(),
        }
    }

    /// State and time constant, s, of a lag without anything behind it. One of no duration is
    /// where its input goes.
    pub(super) fn single_lag(&self) -> Option<(f64, f64)> {
        (!self.is_cascade() && self.lags_s[0] >= NO_LAG_S)
            .then_some((self.state[0], self.lags_s[0]))
    }

    /// States of the lags; none if anything behind them can swing.
    pub(super) fn lags(&self) -> Option<impl Iterator<Item = f64>> {
        let lags = self.state.into_iter().zip(self.lags_s);
        let lags = lags.filter(|(_, lag_s)| *lag_s >= NO_LAG_S).map(|l| l.0);
        self.resonance.is_none().then_some(lags)
    }

    /// Whether a stage takes another's output.
    fn is_cascade(&self) -> bool {
        self.lags_s[1] >= NO_LAG_S || self.resonance.is_some()
    }

    /// Several parts with constant input at once. `number`: that of the segment, if each cycle has
    /// the same ones.
    pub(super) fn exact_step(
        &mut self,
        input: f64,
        segment: &Segment,
        number: Option<usize>,
    ) -> Moved {
        match (number, self.is_cascade()) {
            (Some(number), true) => self.exact_step_known(input, segment, number),
            (None, true) => self.parts(input, segment),
            (Some(_), false) => self.advance(input, segment.duration_s),
            // No other segment lasts as long as this one: its response is not worth keeping.
            (None, false) => {
                let response = self.respond(segment.duration_s);
                self.pass(input, &response)
            }
        }
    }

    fn exact_step_known(&mut self, input: f64, segment: &Segment, number: usize) -> Moved {
        if self.whole.len() <= number {
            self.whole.resize(number + 1, None);
        }
        let whole = match self.whole[number] {
            Some(whole) => whole,
            None => self.composed(segment),
        };
        self.whole[number] = Some(whole);
        let from = [
            self.state[0],
            self.state[1],
            self.mode[0],
            self.mode[1],
            input,
        ];
        let row = |row: &[f64; 5]| row.iter().zip(&from).map(|(a, x)| a * x).sum::<f64>();
        let [first, second, deviation, rate] = whole.states.each_ref().map(row);
        (self.state, self.mode) = ([first, second], [deviation, rate]);
        Moved {
            mean: row(&whole.mean),
            end: row(&whole.end),
        }
    }

    /// Parts one after the other.
    fn parts(&mut self, input: f64, segment: &Segment) -> Moved {
        let (mut sum, mut end) = (0.0, input);
        for part_s in segment.parts_s() {
            let moved = self.advance(input, part_s);
            sum += moved.mean * part_s;
            end = moved.end;
        }
        Moved {
            mean: sum / segment.duration_s,
            end,
        }
    }

    /// What parts one after the other do: their answers to each state and to the input alone.
    fn composed(&mut self, segment: &Segment) -> Whole {
        let now = (self.state, self.mode);
        let mut whole = Whole::default();
        for place in 0..5 {
            let unit: [f64; 5] = std::array::from_fn(|i| f64::from(u8::from(i == place)));
            (self.state, self.mode) = ([unit[0], unit[1]], [unit[2], unit[3]]);
            let moved = self.parts(unit[4], segment);
            let states = [self.state[0], self.state[1], self.mode[0], self.mode[1]];
            for (row, state) in whole.states.iter_mut().zip(states) {
                row[place] = state;
            }
            whole.mean[place] = moved.mean;
            whole.end[place] = moved.end;
        }
        (self.state, self.mode) = now;
        whole
    }

    /// Rest: an axis that restarts.
    pub(super) fn reset(&mut self) {
        self.state = [0.0; 2];
        self.mode = [0.0; 2];
    }

    /// One part with constant input.
    pub(super) fn advance(&mut self, input: f64, duration_s: f64) -> Moved {
        let response = self.response(duration_s);
        self.pass(input, &response)
    }

    fn pass(&mut self, input: f64, response: &Response) -> Moved {
        let mut moved = Moved {
            mean: input,
            end: input,
        };
        let stages = self.state.iter_mut().zip(response.lags).zip(self.lags_s);
        // Without a lag a stage passes everything on, its end value included.
        for ((state, (left, mean_left)), _) in stages.filter(|(_, lag_s)| *lag_s >= NO_LAG_S) {
            let offset = *state - moved.mean;
            *state = moved.mean + offset * left;
            moved = Moved {
                mean: moved.mean + offset * mean_left,
                end: *state,
            };
        }
        if self.resonance.is_some() {
            let [[a, b], [c, d]] = response.transition;
            let before = self.mode[0];
            let offset = before - moved.mean;
            let rate = self.mode[1];
            self.mode = [moved.mean + a * offset + b * rate, c * offset + d * rate];
            moved = Moved {
                mean: 0.5 * (before + self.mode[0]),
                end: self.mode[0],
            };
        }
        moved
    }

    fn response(&mut self, duration_s: f64) -> Response {
        let same = |r: &Response| (r.duration_s - duration_s).abs() < 1e-12;
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

    fn respond(&self, duration_s: f64) -> Response {
        Response {
            duration_s,
            lags: self.lags_s.map(|lag| lag_response(lag, duration_s)),
            transition: self
                .resonance
                .map_or([[0.0; 2]; 2], |mode| mode_response(&mode, duration_s)),
        }
    }
}

/// exp(−h/T), and its mean over the part.
fn lag_response(lag_s: f64, duration_s: f64) -> (f64, f64) {
    if lag_s < NO_LAG_S {
        return (0.0, 0.0);
    }
    let left = (-duration_s / lag_s).exp();
    (left, lag_s / duration_s * (1.0 - left))
}

/// Transition of (deviation, rate/w) of `v'' + 2 ζ w v' + w² v = w² u` over a part.
fn mode_response(mode: &Resonance, duration_s: f64) -> [[f64; 2]; 2] {
    let zeta = mode.damping_ratio.clamp(0.0, 0.999);
    let phase = std::f64::consts::TAU * mode.frequency_hz * duration_s;
    let damped = (1.0 - zeta * zeta).sqrt();
    let (sin, cos) = (damped * phase).sin_cos();
    let decay = (-zeta * phase).exp();
    let (along, across) = (decay * cos, decay * sin / damped);
    [
        [along + zeta * across, across],
        [-across, along - zeta * across],
    ]
}
