//! Hidden errors of the clocks: the true instants of telegrams and samples.

use super::drive::{Axes, Drive};
use super::hidden;
use super::settings::RigSettings;
use softdock_physics::effects::{Clock, Group, Law, Values};
use softdock_statistics::RandomStream;
use std::collections::VecDeque;

/// Range of the memory of positions, in standard deviations of the jitter.
const JITTER_REACH: f64 = 6.0;

/// Deviation of an instant, s, as a function of a standard normal number.
///
type ScatterLaw = fn(Values<'_>, f64) -> f64;

/// When the pose and the wrench of the running cycle are really taken.
///
/// Jitter shifts both: the cycle itself is early or late. An offset of the clocks shifts the pose alone: it carries the wrench's
/// time stamp but belongs to another instant.
#[derive(Clone, Debug)]
pub(super) struct Instants {
    jitter: Option<(ScatterLaw, Vec<f64>, RandomStream)>,
    /// What is added to the instant of a pose, s.
    pose_shift_s: f64,
    /// Deviation of the running cycle, s.
    jitter_s: f64,
    /// Positions at the last integration steps, the newest last.
    trail: VecDeque<Axes>,
    trail_length: usize,
    step_s: f64,
}

impl Instants {
    pub(super) fn new(settings: &RigSettings, noise: &RandomStream) -> Self {
        let step_s = settings.substep_s();
        let (mut jitter, mut pose_shift_s, mut reach_s) = (None, 0.0, 0.0);
        for (effect, values) in hidden::in_order(&settings.hidden, Group::Body) {
            match effect.law {
                Law::Clock(Clock::Scatter(law)) => {
                    reach_s += law(&values, JITTER_REACH);
                    jitter = Some((law, values, noise.clone()));
                }
                Law::ClockOffset(law) => {
                    pose_shift_s = -law(&values);
                    reach_s += (-pose_shift_s).max(0.0);
                }
                _ => {}
            }
        }
        Self {
            jitter,
            pose_shift_s,
            jitter_s: 0.0,
            trail: VecDeque::new(),
            trail_length: (reach_s / step_s).ceil() as usize,
            step_s,
        }
    }

    /// Draws the jitter of a new cycle.
    pub(super) fn draw(&mut self) {
        if let Some((law, values, noise)) = &mut self.jitter {
            self.jitter_s = law(values, noise.normal());
        }
    }

    /// Deviation of the running cycle from its nominal instant, s.
    pub(super) fn jitter_s(&self) -> f64 {
        self.jitter_s
    }

    /// Remembers the position at the beginning of an integration step.
    pub(super) fn remember(&mut self, position: Axes) {
        if self.trail_length == 0 {
            return;
        }
        if self.trail.len() == self.trail_length {
            self.trail.pop_front();
        }
        self.trail.push_back(position);
    }

    /// The position that a pose taken at the beginning of a cycle shows.
    pub(super) fn position(&self, drive: &Drive, extra_delay_s: f64) -> Axes {
        let shift_s = self.pose_shift_s + self.jitter_s;
        if shift_s > 0.0 {
            return drive.foreseen(shift_s, extra_delay_s);
        }
        let back = -shift_s / self.step_s;
        let (near, far) = (
            self.steps_ago(drive, back.floor() as usize),
            self.steps_ago(drive, back.floor() as usize + 1),
        );
        std::array::from_fn(|i| near[i] + (far[i] - near[i]) * back.fract())
    }

    /// The position so many integration steps ago; the oldest known one before that.
    fn steps_ago(&self, drive: &Drive, steps: usize) -> Axes {
        if steps == 0 || self.trail.is_empty() {
            return drive.position(0.0);
        }
        let newest = self.trail.len();
        let place = newest.saturating_sub(steps);
        self.trail
            .get(place)
            .copied()
            .unwrap_or_else(|| drive.position(0.0))
    }
}
