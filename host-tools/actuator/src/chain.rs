//! Parameters of the actuator.

/// When a pause begins.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PauseTrigger {
    /// The executed velocity changes its sign.
    Output,
    /// The velocity that arrives at the drive changes its sign.
    Command,
}

/// What the axis does at a zero crossing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PauseKind {
    /// It stands still, and then goes on as if it had not.
    Resumes,
    /// It stands still, and then starts from rest.
    RestartsFromRest,
    /// Its drive is commanded to stand still: it comes to rest as its dynamics let it.
    HoldsCommand,
}

/// A lightly damped mode.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Resonance {
    /// Natural frequency, Hz.
    pub frequency_hz: f64,
    /// Damping ratio, below 1.
    pub damping_ratio: f64,
}

/// Limits of velocity, acceleration and jerk, in units of the axis; infinity is no limit.
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
    /// Executed over sent velocity, in the steady state.
    pub gain: f64,
    /// The sent velocity is rounded to a multiple of this, in units of the axis; 0: not rounded.
    pub command_step: f64,
    /// Sent velocities within this range move nothing; others are reduced by its nearer end. In units of the axis.
    pub dead_zone: [f64; 2],
    /// Relative difference of the gain forth and back: the gains are 1 plus this and 1 minus this.
    pub asymmetry: f64,
    /// A second-order mode.
    pub resonance: Option<Resonance>,
    /// Limit of the acceleration inside of the loop that makes the lag, in units of the axis; infinity is no limit.
    pub loop_acceleration: f64,
    /// Limits of the planner, before the lag.
    pub planner: Limits,
    /// Limits of the drive, behind it.
    pub drive: Limits,
    /// Standstill at a zero crossing, s.
    pub pause_s: f64,
    /// What begins it.
    pub pause_trigger: PauseTrigger,
    /// What the axis does meanwhile.
    pub pause_kind: PauseKind,
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
            dead_zone: [0.0; 2],
            asymmetry: 0.0,
            resonance: None,
            loop_acceleration: f64::INFINITY,
            planner: Limits::NONE,
            drive: Limits::NONE,
            pause_s: 0.0,
            pause_trigger: PauseTrigger::Output,
            pause_kind: PauseKind::Resumes,
            backlash_m: 0.0,
        }
    }

    /// All parameters as bits, as a key of a cache.
    pub fn bits(&self) -> [u64; 21] {
        let Self { planner, drive, .. } = self;
        let mode = self.resonance.map(|r| (r.frequency_hz, r.damping_ratio));
        let (frequency_hz, damping_ratio) = mode.unwrap_or((0.0, 0.0));
        let values = [
            self.delay_s,
            self.lag_s,
            self.extra_lag_s,
            self.gain,
            self.command_step,
            self.dead_zone[0],
            self.dead_zone[1],
            self.asymmetry,
            frequency_hz,
            damping_ratio,
            self.loop_acceleration,
            planner.velocity,
            planner.acceleration,
            planner.jerk,
            drive.velocity,
            drive.acceleration,
            drive.jerk,
            self.pause_s,
            f64::from(self.pause_trigger as u8),
            f64::from(self.pause_kind as u8),
            self.backlash_m,
        ];
        values.map(f64::to_bits)
    }

    /// Velocities as the drive understands the sent ones: rounded, without the dead zone, with the gain by direction. None if
    /// they are unchanged.
    pub(super) fn understood(&self, sent: &[f64]) -> Option<Vec<f64>> {
        let (step, [low, high], asymmetry) = (self.command_step, self.dead_zone, self.asymmetry);
        let understood = |sent: &f64| {
            let rounded = match step > 0.0 {
                true => (sent / step).round() * step,
                false => *sent,
            };
            let beyond = rounded - rounded.max(low).min(high);
            beyond + asymmetry * beyond.abs()
        };
        let changes = step > 0.0 || [low, high, asymmetry] != [0.0; 3];
        changes.then(|| sent.iter().map(understood).collect())
    }

    /// Number of equal parts into which a cycle is cut: 8 if a stage is not linear, otherwise 1.
    pub(super) fn parts(&self) -> usize {
        let free = !self.drive.any() && self.loop_acceleration.is_infinite();
        if free && self.pause_s <= 0.0 && self.backlash_m <= 0.0 {
            1
        } else {
            8
        }
    }
}
