//! Stages that are not linear: limits, the pause at a zero crossing, lost motion.

use super::chain::{Chain, Limits, PauseKind, PauseTrigger};
use super::linear::{LinearStages, PartVelocity};

/// Limits of acceleration and velocity, then of jerk.
#[derive(Clone)]
pub(super) struct Limiter {
    limits: Limits,
    value: f64,
    /// Velocity and acceleration behind the limit of the jerk.
    smooth: (f64, f64),
}

impl Limiter {
    pub(super) fn new(limits: &Limits) -> Self {
        Self {
            limits: *limits,
            value: 0.0,
            smooth: (0.0, 0.0),
        }
    }

    /// Follows a velocity within the limits.
    pub(super) fn follow(&mut self, moved: PartVelocity, duration_s: f64) -> PartVelocity {
        if !self.limits.any() {
            return moved;
        }
        let largest = self.limits.acceleration * duration_s;
        let before = self.value;
        let change = (moved.end - before).clamp(-largest, largest);
        let velocity = self.limits.velocity;
        self.value = (before + change).clamp(-velocity, velocity);
        if self.value == moved.end {
            return self.with_jerk(moved, duration_s);
        }
        let limited = PartVelocity {
            mean: 0.5 * (before + self.value),
            end: self.value,
        };
        self.with_jerk(limited, duration_s)
    }

    /// Approaches a velocity in the shortest time that the jerk allows, without overshoot. It follows the braking curve
    /// `a = √(2 j |missing|)`, on which whole parts with the largest change end at rest (`n (n + 1)/2 j h² = |missing|`).
    fn with_jerk(&mut self, moved: PartVelocity, duration_s: f64) -> PartVelocity {
        let jerk = self.limits.jerk;
        if jerk.is_infinite() {
            return moved;
        }
        let (before, acceleration) = self.smooth;
        let missing = moved.end - before;
        let largest = jerk * duration_s;
        let wanted = if missing.abs() <= largest * duration_s {
            missing / duration_s
        } else {
            let half = 0.5 * largest;
            ((half * half + 2.0 * jerk * missing.abs()).sqrt() - half).copysign(missing)
        };
        let acceleration = acceleration + (wanted - acceleration).clamp(-largest, largest);
        let end = before + acceleration * duration_s;
        self.smooth = (end, acceleration);
        PartVelocity {
            mean: 0.5 * (before + end),
            end,
        }
    }

    /// Whether a velocity that goes from `from` to `to` along a lag of `lag_s` passes unchanged.
    fn passes(&self, from: f64, to: f64, lag_s: f64) -> bool {
        /// Relative difference that is round-off: sums of parts differ from their end by it.
        const ROUNDING: f64 = 1e-12;
        let Limits {
            velocity,
            acceleration,
            jerk,
        } = self.limits;
        let follows = (self.value - from).abs() <= ROUNDING * (from.abs() + to.abs());
        let steepest = (to - from).abs();
        jerk.is_infinite()
            && follows
            && steepest <= acceleration * lag_s
            && from.abs().max(to.abs()) <= velocity
    }

    /// Sets the state to rest, for an axis that restarts.
    fn reset(&mut self) {
        self.value = 0.0;
        self.smooth = (0.0, 0.0);
    }
}

/// What moves the axis: the linear stages and the limits behind them.
#[derive(Clone)]
pub(super) struct Drive {
    looped: Option<LimitedLoop>,
    linear: LinearStages,
    limits: Limiter,
}

/// A lag whose loop asks for no more than some acceleration: `v' = clamp((u − v)/T, −a, a)`.
#[derive(Clone)]
struct LimitedLoop {
    lag_s: f64,
    acceleration: f64,
    velocity: f64,
}

impl LimitedLoop {
    /// Exact for a constant input: at the limit until the lag asks for less, then the lag.
    fn follow(&mut self, input: f64, duration_s: f64) -> PartVelocity {
        let before = self.velocity;
        let missing = input - before;
        let reach = self.acceleration * self.lag_s;
        let limited_s = ((missing.abs() - reach) / self.acceleration).clamp(0.0, duration_s);
        let ramp = self.acceleration.copysign(missing) * limited_s;
        let met = before + ramp;
        let rest_s = duration_s - limited_s;
        let left = if self.lag_s > 0.0 {
            (-rest_s / self.lag_s).exp()
        } else {
            0.0
        };
        self.velocity = input + (met - input) * left;
        let path = limited_s * (before + 0.5 * ramp)
            + rest_s * input
            + self.lag_s * (met - input) * (1.0 - left);
        PartVelocity {
            mean: path / duration_s,
            end: self.velocity,
        }
    }
}

impl Drive {
    pub(super) fn new(chain: &Chain) -> Self {
        let looped = chain.loop_acceleration.is_finite().then_some(LimitedLoop {
            lag_s: chain.lag_s,
            acceleration: chain.loop_acceleration,
            velocity: 0.0,
        });
        let behind = Chain {
            lag_s: if looped.is_some() { 0.0 } else { chain.lag_s },
            ..*chain
        };
        Self {
            looped,
            linear: LinearStages::new(&behind),
            limits: Limiter::new(&chain.drive),
        }
    }

    /// Follows a constant command for a time.
    pub(super) fn follow(&mut self, command: f64, duration_s: f64) -> PartVelocity {
        let moved = match &mut self.looped {
            Some(looped) => {
                let moved = looped.follow(command, duration_s);
                let behind = self.linear.advance(moved.mean, duration_s, false);
                if self.linear.is_nothing() {
                    moved
                } else {
                    behind
                }
            }
            None => self.linear.advance(command, duration_s, false),
        };
        self.limits.follow(moved, duration_s)
    }

    /// Whether no limit acts while a command is constant.
    pub(super) fn is_free(&self, command: f64) -> bool {
        if self.looped.is_some() {
            return false;
        }
        !self.limits.limits.any()
            || self
                .linear
                .single_lag()
                .is_some_and(|(from, lag_s)| self.limits.passes(from, command, lag_s))
    }

    /// Advances by a whole segment with a constant command, if [`Self::is_free`]. `once`: no other segment has this duration.
    pub(super) fn exact_step(&mut self, command: f64, duration_s: f64, once: bool) -> PartVelocity {
        let moved = self.linear.advance(command, duration_s, once);
        self.limits.value = moved.end;
        moved
    }

    /// Starts from rest, and follows a constant command for a time.
    fn restart(&mut self, command: f64, duration_s: f64) -> PartVelocity {
        self.linear.reset();
        self.limits.reset();
        if let Some(looped) = &mut self.looped {
            looped.velocity = 0.0;
        }
        if duration_s > 0.0 {
            self.follow(command, duration_s)
        } else {
            PartVelocity {
                mean: 0.0,
                end: 0.0,
            }
        }
    }
}

/// Standstill after a zero crossing. The instant of the crossing is interpolated within a part.
pub(super) struct PauseGate {
    pause_s: f64,
    trigger: PauseTrigger,
    kind: PauseKind,
    /// Sign of the last motion, or of the last command, other than zero.
    direction: f64,
    last: f64,
    remaining_s: f64,
}

impl PauseGate {
    pub(super) fn new(chain: &Chain) -> Self {
        Self {
            pause_s: chain.pause_s,
            trigger: chain.pause_trigger,
            kind: chain.pause_kind,
            direction: 0.0,
            last: 0.0,
            remaining_s: 0.0,
        }
    }

    /// Whether the axis follows a held command instead of standing still.
    pub(super) fn holds_command(&self) -> bool {
        self.pause_s > 0.0 && self.kind == PauseKind::HoldsCommand
    }

    /// Follows a command that is zero during the pause. The pause may begin and end within the part.
    pub(super) fn follow_held(
        &mut self,
        command: f64,
        duration_s: f64,
        drive: &mut Drive,
    ) -> PartVelocity {
        if self.remaining_s <= 0.0 && self.trigger == PauseTrigger::Command {
            if self.direction * command < 0.0 {
                self.remaining_s = self.pause_s;
            }
            if command != 0.0 {
                self.direction = command.signum();
            }
        }
        if self.remaining_s > 0.0 {
            return self.follow_zero_then(command, duration_s, drive);
        }
        let before = drive.clone();
        let moved = drive.follow(command, duration_s);
        let last = std::mem::replace(&mut self.last, moved.end);
        if self.trigger == PauseTrigger::Command {
            return moved;
        }
        let reverses = self.direction * moved.end < 0.0;
        if moved.end != 0.0 {
            self.direction = moved.end.signum();
        }
        if !reverses {
            return moved;
        }
        let open_s = self.crossing(last, moved.end) * duration_s;
        *drive = before;
        self.remaining_s = self.pause_s;
        let open = (open_s > 0.0).then(|| drive.follow(command, open_s));
        let rest_s = duration_s - open_s;
        let held = (rest_s > 0.0).then(|| self.follow_zero_then(command, rest_s, drive));
        joined([(open, open_s), (held, rest_s)], duration_s)
    }

    fn follow_zero_then(
        &mut self,
        command: f64,
        duration_s: f64,
        drive: &mut Drive,
    ) -> PartVelocity {
        let held_s = self.remaining_s.min(duration_s);
        let open_s = duration_s - held_s;
        self.remaining_s -= held_s;
        let held = Some(drive.follow(0.0, held_s));
        let open = (open_s > 0.0).then(|| drive.follow(command, open_s));
        let moved = joined([(held, held_s), (open, open_s)], duration_s);
        self.last = moved.end;
        moved
    }

    /// Passes a velocity, or zero during the pause. `command`: the velocity that arrives at the drive.
    pub(super) fn pass(
        &mut self,
        moved: PartVelocity,
        command: f64,
        duration_s: f64,
        drive: &mut Drive,
    ) -> PartVelocity {
        if self.pause_s <= 0.0 {
            return moved;
        }
        let watched = match self.trigger {
            PauseTrigger::Output => moved.end,
            PauseTrigger::Command => command,
        };
        let last = std::mem::replace(&mut self.last, watched);
        let reverses = self.direction * watched < 0.0;
        if watched != 0.0 {
            // A second reversal inside of a pause is not a new one.
            self.direction = watched.signum();
        }
        if self.remaining_s > 0.0 {
            self.remaining_s -= duration_s;
        } else if reverses {
            let crossing = self.crossing(last, watched);
            self.remaining_s = self.pause_s - (1.0 - crossing) * duration_s;
        } else {
            return moved;
        }
        let open = (-self.remaining_s / duration_s).clamp(0.0, 1.0);
        // The axis restarts at the instant at which the pause ends, not at the end of a part.
        let moved = if self.kind == PauseKind::RestartsFromRest {
            drive.restart(command, open * duration_s)
        } else {
            moved
        };
        PartVelocity {
            mean: moved.mean * open,
            end: if open > 0.0 { moved.end } else { 0.0 },
        }
    }

    /// Whether a constant command neither begins nor continues a pause: neither the command nor any state of the lags has the
    /// opposite sign of the motion.
    pub(super) fn stays_open(&self, command: f64, drive: &Drive) -> bool {
        let goes_on = |velocity: f64| velocity == 0.0 || self.direction * velocity > 0.0;
        self.pause_s <= 0.0
            || (self.remaining_s <= 0.0
                && goes_on(command)
                && drive.linear.lags().is_some_and(|mut l| l.all(goes_on)))
    }

    /// Records the end of a motion without a pause.
    pub(super) fn opened(&mut self, moved: PartVelocity, command: f64) {
        self.last = match self.trigger {
            PauseTrigger::Output => moved.end,
            PauseTrigger::Command => command,
        };
    }

    /// Share of the part at which the sign changes; a command changes at the part's start.
    fn crossing(&self, last: f64, watched: f64) -> f64 {
        match self.trigger {
            PauseTrigger::Output if last * watched < 0.0 => {
                (last / (last - watched)).clamp(0.0, 1.0)
            }
            _ => 0.0,
        }
    }
}

/// Joins pieces of a part in time.
fn joined(pieces: [(Option<PartVelocity>, f64); 2], duration_s: f64) -> PartVelocity {
    let there = pieces
        .into_iter()
        .filter_map(|(moved, s)| Some((moved?, s)));
    let whole = PartVelocity {
        mean: 0.0,
        end: 0.0,
    };
    there.fold(whole, |whole, (moved, piece_s)| PartVelocity {
        mean: whole.mean + moved.mean * piece_s / duration_s,
        end: moved.end,
    })
}

/// Lost motion: the output stands until the input has crossed the gap.
pub(super) struct Backlash {
    width: f64,
    /// Position in the gap, −width/2 to width/2.
    position: f64,
}

impl Backlash {
    pub(super) fn new(width: f64) -> Self {
        Self {
            width,
            position: 0.0,
        }
    }

    /// Whether there is lost motion.
    pub(super) fn acts(&self) -> bool {
        self.width > 0.0
    }

    pub(super) fn pass(&mut self, moved: PartVelocity, duration_s: f64) -> PartVelocity {
        if !self.acts() {
            return moved;
        }
        let wanted = self.position + moved.mean * duration_s;
        let half = 0.5 * self.width;
        self.position = wanted.clamp(-half, half);
        let through = wanted - self.position;
        PartVelocity {
            mean: through / duration_s,
            end: if through == 0.0 { 0.0 } else { moved.end },
        }
    }
}

/// Velocities of a planner with limits for the sent velocities, one per cycle.
pub(super) fn planned(limits: &Limits, sent: &[f64], cycle_s: f64) -> Vec<f64> {
    let mut limiter = Limiter::new(limits);
    sent.iter()
        .map(|wanted| limiter.follow(PartVelocity::constant(*wanted), cycle_s).end)
        .collect()
}
