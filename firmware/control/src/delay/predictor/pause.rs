//! The pause at a reversal: when the executed velocity of an axis changes its sign, the axis stands still for a while and then
//! follows the present command. The displacement in between is lost.

use super::linear_dynamics::Segment;
use super::tuning::*;

/// The pause of one axis.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Pause {
    /// Direction of the last motion: −1, 0, 1.
    direction: f64,
    /// Cycles of standstill that are left.
    pub(super) left: f64,
    /// A pause ended with the last segment.
    resumes: bool,
    /// A pause ended within the last cycle or with it.
    pub(super) ended: bool,
}

impl Pause {
    /// Whether the axis keeps its direction with this velocity, or rests, without a pause: nearly all cycles.
    #[inline]
    pub(super) fn goes_on(&self, v: f64) -> bool {
        let moves_on = v * self.direction > 0.0 || v.abs() <= ZERO_VELOCITY;
        self.left <= 0.0 && !self.resumes && moves_on
    }

    /// Executes a segment with pauses of `length` cycles. Returns the displacement, cycles × velocity.
    pub(super) fn execute(&mut self, segment: &Segment, length: f64) -> f64 {
        let Segment {
            duration,
            start,
            end,
            displacement,
        } = *segment;
        // A segment whose velocity changes lasts for a whole cycle.
        let at = |t: f64| start + (end - start) * t;
        let between = |from: f64, to: f64| 0.5 * (at(from) + at(to)) * (to - from);
        if self.left > 0.0 && self.left >= duration - SAME_INSTANT {
            self.stand_still(duration);
            return 0.0;
        }
        let mut begin = 0.0;
        if self.left > 0.0 || core::mem::take(&mut self.resumes) {
            begin = self.left;
            self.left = 0.0;
            self.ended |= begin > 0.0;
            // An axis whose command reversed once more within the pause goes on without another pause.
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
        // The time of reversal; a velocity that jumps reverses at the beginning.
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

    /// Executes a segment that lies within a pause.
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
