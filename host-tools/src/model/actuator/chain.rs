//! Parameters of the actuator, and its linear stages.

use super::nonlinear::Moved;

/// When a pause begins.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PauseTrigger {
    /// The executed velocity changes its sign.
    Output,
    /// The velocity that arrives at the drive changes its sign.
    Command,
}

/// A lightly damped mode.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Resonance {
    /// Natural frequency, Hz.
    pub frequency_hz: f64,
    /// Damping ratio, below 1.
    pub damping_ratio: f64,
}

/// Limits of velocity, acceleration and jerk, in units of the axis; infinite: none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Largest velocity.
    pub velocity: f64,
    /// Largest acceleration.
    pub acceleration: f64,
    /// Largest change of the acceleration per second.
    pub jerk: f64,
}

impl Limits {
    /// No limits.
    pub const NONE: Self = Self {
        velocity: f64::INFINITY,
        acceleration: f64::INFINITY,
        jerk: f64::INFINITY,
    };

    /// Whether there is one.
    pub fn any(&self) -> bool {
        self.velocity.is_finite() || self.acceleration.is_finite() || self.jerk.is_finite()
    }
}

/// The actuator of one axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Chain {
    /// Transport delay, s.
    pub delay_s: f64,
    /// Time constant of the lag, s.
    pub lag_s: f64,
    /// Time constant of a second lag, s.
    pub extra_lag_s: f64,
    /// Executed over sent velocity, at rest.
    pub gain: f64,
    /// The sent velocity is rounded to a multiple of this, in units of the axis; 0: not rounded.
    pub command_step: f64,
    /// A second-order mode.
    pub resonance: Option<Resonance>,
    /// Limits of the planner, before the lag.
    pub planner: Limits,
    /// Limits of the drive, behind it.
    pub drive: Limits,
    /// Standstill at a zero crossing, s.
    pub pause_s: f64,
    /// What begins it.
    pub pause_trigger: PauseTrigger,
    /// The axis restarts from rest; else it goes on as if it had not stood still.
    pub pause_restarts: bool,
    /// Lost motion of the axis, m or rad.
    pub backlash_m: f64,
}

impl Chain {
    /// Delay and lag, nothing else.
    pub fn nominal(delay_s: f64, lag_s: f64) -> Self {
        Self {
            delay_s,
            lag_s,
            extra_lag_s: 0.0,
            gain: 1.0,
            command_step: 0.0,
            resonance: None,
            planner: Limits::NONE,
            drive: Limits::NONE,
            pause_s: 0.0,
            pause_trigger: PauseTrigger::Output,
            pause_restarts: false,
            backlash_m: 0.0,
        }
    }

    /// The command with gain and rounding.
    pub(super) fn shaped(&self, command: f64) -> f64 {
        if self.command_step > 0.0 {
            self.gain * (command / self.command_step).round() * self.command_step
        } else {
            self.gain * command
        }
    }

    /// Equal parts of a cycle that the stages need.
    pub(super) fn parts(&self) -> usize {
        let linear = self.extra_lag_s <= 0.0 && self.resonance.is_none();
        let free = !self.drive.any();
        if linear && free && self.pause_s <= 0.0 && self.backlash_m <= 0.0 {
            1
        } else {
            8
        }
    }
}

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
const REMEMBERED: usize = 24;

impl LinearStages {
    pub(super) fn new(chain: &Chain) -> Self {
        Self {
            lags_s: [chain.lag_s, chain.extra_lag_s],
            resonance: chain.resonance,
            state: [0.0; 2],
            mode: [0.0; 2],
            known: Vec::with_capacity(REMEMBERED),
            last: 0,
        }
    }

    /// Rest: an axis that restarts.
    pub(super) fn reset(&mut self) {
        self.state = [0.0; 2];
        self.mode = [0.0; 2];
    }

    /// One part with constant input.
    pub(super) fn advance(&mut self, input: f64, duration_s: f64) -> Moved {
        let response = self.response(duration_s);
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
        let response = Response {
            duration_s,
            lags: self.lags_s.map(|lag| lag_response(lag, duration_s)),
            transition: self
                .resonance
                .map_or([[0.0; 2]; 2], |mode| mode_response(&mode, duration_s)),
        };
        if self.known.len() == REMEMBERED {
            self.known.clear();
        }
        self.last = self.known.len();
        self.known.push(response);
        response
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
