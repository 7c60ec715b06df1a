//! The pause at a reversal: when the executed velocity changes its sign, the axis stands still for a
//! while and then goes on with what the command is by then. The way is lost.

use super::chain::Piece;

/// Below this a velocity has no direction (m/s): rounding must not look like a reversal.
const NO_DIRECTION: f64 = 1e-9;

/// Times closer than this are the same, cycles.
const SAME_TIME: f64 = 1e-9;

/// State of one axis.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Pause {
    /// Direction of the last motion: −1, 0, 1.
    direction: f64,
    /// Cycles of standstill that are left.
    left: f64,
    /// A pause ended with the last piece.
    resumes: bool,
    /// A pause ended within the last cycle or with it.
    ended: bool,
}

impl Pause {
    /// Whether the axis stands still at the end of what was executed.
    pub(super) fn stands(&self) -> bool {
        self.left > 0.0
    }

    /// Whether a pause ended within the last cycle: its velocity is not that of the cycle.
    pub(super) fn ended(&self) -> bool {
        self.ended
    }

    /// A new cycle begins.
    pub(super) fn begin(&mut self) {
        self.ended = false;
    }

    /// Whether the axis goes on into a velocity in the direction in which it moves, or rests: nearly
    /// all cycles.
    #[inline]
    pub(super) fn goes_on(&self, v: f64) -> bool {
        self.left <= 0.0 && !self.resumes && (v * self.direction > 0.0 || v == 0.0)
    }

    /// Executes a piece with pauses of `length` cycles; answers the way.
    pub(super) fn execute(&mut self, piece: &Piece, length: f64) -> f64 {
        let Piece {
            duration,
            start,
            end,
            way,
        } = *piece;
        let at = |t: f64| start + (end - start) * (t / duration);
        let between = |from: f64, to: f64| 0.5 * (at(from) + at(to)) * (to - from);
        if self.left >= duration - SAME_TIME {
            self.left -= duration;
            if self.left < SAME_TIME {
                self.left = 0.0;
                self.resumes = true;
                self.ended = true;
            }
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
                way
            };
        }
        // The moment of reversal; a velocity that jumped turned at the beginning.
        let same_way = start * self.direction > 0.0;
        let turn = if same_way && start != end {
            (duration * start / (start - end)).clamp(begin, duration)
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
}

fn direction(v: f64) -> Option<f64> {
    (v.abs() > NO_DIRECTION).then(|| if v > 0.0 { 1.0 } else { -1.0 })
}
