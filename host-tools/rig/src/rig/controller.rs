//! The robot controller's side of RSI: one telegram and one answer per cycle, corrections, their
//! limits, and what a missing answer does.
//!
//! Conventions where public sources leave a choice:
//! - a correction is added component by component to X Y Z A B C, as public RSI simulators do;
//! - the limit and the monitor of rotation act on the Euclidean norm of the A, B, C corrections;
//! - the silent clamp limits the total itself: a correction that pushes further is lost;
//! - the monitor sees the total after the clamp, when the cycle ends.

use super::checks::check;
use super::drive::Axes;
use super::settings::{CorrectionMode, RigSettings, RobotSettings, TimeoutCounting};
use anyhow::Result;

/// Why the robot stopped. Restarting needs an operator.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum RsiStopped {
    /// Too many answers were late or missing.
    #[error("KSS29002: RSITimeout, {late_answers} answers late, {allowed} allowed")]
    Timeout {
        /// Counted late answers.
        late_answers: u32,
        /// `timeout_cycles`.
        allowed: u32,
    },
    /// The total correction passed POSCORRMON.
    #[error("KSS29000: correction of {translation_m} m and {rotation_rad} rad exceeds the monitor")]
    CorrectionMonitor {
        /// Norm of the X, Y, Z correction, m.
        translation_m: f64,
        /// Norm of the A, B, C correction, rad.
        rotation_rad: f64,
    },
    /// The answer asked for it.
    #[error("stopped by the answer's Stop")]
    Requested,
}

/// POSCORR is working.
const STAT_ACTIVE: u32 = 1;
/// Bit of the rotation limit; X Y Z lower limits are bits 1 to 3, upper limits 4 to 6.
const STAT_ROTATION: u32 = 1 << 7;
/// A rotation that was scaled to its limit is recognised within this.
const ROUNDING: f64 = 1e-12;

/// State of the RSI context.
#[derive(Clone, Debug)]
pub(super) struct Controller {
    settings: RobotSettings,
    cycle_s: f64,
    /// Total correction before the running cycle.
    before: Axes,
    /// Total correction with the running cycle.
    total: Axes,
    /// Stat with the running cycle, and Stat when the last cycle ended.
    stat: u32,
    reported_stat: u32,
    last_input: Axes,
    answered: bool,
    late_answers: u32,
    late_in_a_row: u32,
    stopped: Option<RsiStopped>,
}

impl Controller {
    /// A context that has just been switched on: all inputs 0.
    pub(super) fn new(settings: &RigSettings) -> Result<Self> {
        let robot = &settings.robot;
        for axis in 0..3 {
            let limit = &robot.correction_limit;
            check(
                "rig.robot.correction_limit.lower_m",
                limit.lower_m[axis],
                -10.0,
                0.0,
            )?;
            check(
                "rig.robot.correction_limit.upper_m",
                limit.upper_m[axis],
                0.0,
                10.0,
            )?;
        }
        let (limit, monitor) = (&robot.correction_limit, &robot.correction_monitor);
        check(
            "rig.robot.correction_limit.max_rotation_rad",
            limit.max_rotation_rad,
            0.0,
            10.0,
        )?;
        check(
            "rig.robot.correction_monitor.max_translation_m",
            monitor.max_translation_m,
            0.0,
            100.0,
        )?;
        check(
            "rig.robot.correction_monitor.max_rotation_rad",
            monitor.max_rotation_rad,
            0.0,
            100.0,
        )?;
        Ok(Self {
            settings: robot.clone(),
            cycle_s: settings.cycle_s(),
            before: [0.0; 6],
            total: [0.0; 6],
            stat: STAT_ACTIVE,
            reported_stat: STAT_ACTIVE,
            last_input: [0.0; 6],
            answered: true,
            late_answers: 0,
            late_in_a_row: 0,
            stopped: None,
        })
    }

    /// Closes the running cycle and begins the next one. Returns the velocity of the new cycle if
    /// no answer comes.
    pub(super) fn begin_cycle(&mut self) -> Result<Axes, RsiStopped> {
        self.close_cycle();
        if let Some(reason) = self.stopped {
            return Err(reason);
        }
        self.before = self.total;
        self.reported_stat = self.stat;
        self.answered = false;
        let held = if self.settings.hold_on {
            self.last_input
        } else {
            [0.0; 6]
        };
        Ok(self.apply(held))
    }

    /// Takes the answer of the running cycle. Returns the velocity to use in place of the one without an answer; None if the
    /// answer is rejected: a second one, one that is not finite, or one after the stop.
    pub(super) fn answer(&mut self, correction: Axes, stop: bool) -> Option<Axes> {
        let usable = correction.iter().all(|c| c.is_finite());
        if self.answered || !usable || self.stopped.is_some() {
            return None;
        }
        self.answered = true;
        self.last_input = correction;
        if stop {
            self.stopped = Some(RsiStopped::Requested);
            self.total = self.before;
            return Some([0.0; 6]);
        }
        Some(self.apply(correction))
    }

    /// Delay D: answers that were late or rejected.
    pub(super) fn late_answers(&self) -> u32 {
        self.late_answers
    }

    /// Stat of POSCORR at the last telegram. A bit is set as long as the total is at its limit.
    pub(super) fn poscorr_stat(&self) -> u32 {
        self.reported_stat
    }

    /// Why the robot stands, if it does.
    pub(super) fn stopped(&self) -> Option<RsiStopped> {
        self.stopped
    }

    fn close_cycle(&mut self) {
        if self.stopped.is_some() {
            return;
        }
        if self.answered {
            self.late_in_a_row = 0;
        } else {
            self.late_answers = self.late_answers.saturating_add(1);
            self.late_in_a_row = self.late_in_a_row.saturating_add(1);
        }
        let counted = match self.settings.timeout_counting {
            TimeoutCounting::Total => self.late_answers,
            TimeoutCounting::Consecutive => self.late_in_a_row,
        };
        let allowed = self.settings.timeout_cycles;
        let (translation_m, rotation_rad) = (norm(&self.total[..3]), norm(&self.total[3..]));
        let monitor = &self.settings.correction_monitor;
        if counted > allowed {
            self.stopped = Some(RsiStopped::Timeout {
                late_answers: counted,
                allowed,
            });
        } else if translation_m > monitor.max_translation_m
            || rotation_rad > monitor.max_rotation_rad
        {
            self.stopped = Some(RsiStopped::CorrectionMonitor {
                translation_m,
                rotation_rad,
            });
        }
    }

    /// Takes `input` as this cycle's correction; returns the velocity that it means.
    fn apply(&mut self, input: Axes) -> Axes {
        let wanted: Axes = match self.settings.correction {
            CorrectionMode::Relative => std::array::from_fn(|i| self.before[i] + input[i]),
            CorrectionMode::Absolute => input,
        };
        (self.total, self.stat) = self.limited(wanted);
        std::array::from_fn(|i| (self.total[i] - self.before[i]) / self.cycle_s)
    }

    /// POSCORR: the clamped total and its Stat bits.
    fn limited(&self, mut total: Axes) -> (Axes, u32) {
        let limit = &self.settings.correction_limit;
        let mut stat = STAT_ACTIVE;
        for (axis, value) in total.iter_mut().take(3).enumerate() {
            if *value <= limit.lower_m[axis] {
                *value = limit.lower_m[axis];
                stat |= 1 << (1 + axis);
            } else if *value >= limit.upper_m[axis] {
                *value = limit.upper_m[axis];
                stat |= 1 << (4 + axis);
            }
        }
        let rotation = norm(&total[3..]);
        if rotation >= limit.max_rotation_rad * (1.0 - ROUNDING) {
            stat |= STAT_ROTATION;
        }
        if rotation > limit.max_rotation_rad {
            for value in &mut total[3..] {
                *value *= limit.max_rotation_rad / rotation;
            }
        }
        (total, stat)
    }
}

fn norm(values: &[f64]) -> f64 {
    values.iter().map(|v| v * v).sum::<f64>().sqrt()
}
