//! Hidden errors of the clocks: the instants that telegrams and samples really belong to.

use super::checks::prefixed;
use super::drive::{Axes, Drive};
use super::hidden;
use super::settings::RigSettings;
use anyhow::Result;
use softdock_control::range::in_range;
use softdock_physics::effects::body::clock_jitter::ClockJitter;
use softdock_physics::effects::body::clock_offset::ClockOffset;
use softdock_statistics::RandomStream;
use std::collections::VecDeque;

/// Standard deviations of the jitter that the memory of positions reaches back.
const JITTER_REACH: f64 = 6.0;

/// When the pose and the wrench of the running cycle are really taken.
///
/// Jitter moves both: the cycle itself is early or late. An offset of the clocks moves the pose
/// alone: it is stamped with the wrench's time and belongs to another.
#[derive(Clone, Debug)]
pub(super) struct Instants {
    jitter: Option<(ClockJitter, RandomStream)>,
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
    pub(super) fn new(settings: &RigSettings, noise: RandomStream) -> Result<Self> {
        let step_s = settings.substep_s();
        let (mut jitter, mut pose_shift_s, mut reach_s) = (None, 0.0, 0.0);
        if let Some(hidden) = hidden::find(&settings.hidden, "clock_jitter") {
            // A sum of intervals walks away from the wrench's clock: only logs of others have it.
            let built = in_range("of_intervals", hidden.value("of_intervals"), 0.0, 0.0)
                .and_then(|()| ClockJitter::new(hidden.value("jitter_s")));
            jitter = Some((prefixed("rig.hidden clock_jitter.", built)?, noise));
            reach_s += JITTER_REACH * hidden.value("jitter_s");
        }
        if let Some(hidden) = hidden::find(&settings.hidden, "clock_offset") {
            let clock = ClockOffset::new(hidden.value("offset_s"));
            pose_shift_s = -prefixed("rig.hidden clock_offset.", clock)?.pose_time(0.0);
            reach_s += (-pose_shift_s).max(0.0);
        }
        Ok(Self {
            jitter,
            pose_shift_s,
            jitter_s: 0.0,
            trail: VecDeque::new(),
            trail_length: (reach_s / step_s).ceil() as usize,
            step_s,
        })
    }

    /// Begins a cycle.
    pub(super) fn draw(&mut self) {
        if let Some((clock, noise)) = &mut self.jitter {
            self.jitter_s = clock.instant(0.0, noise.normal());
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
