//! KUKA RSI as a [`RobotProtocol`].

use crate::record::{Correction, Output, RobotReport};
use crate::robot_protocol::{Received, RobotProtocol};
use crate::settings::{BoardSettingsError, RsiSettings};
use softdock_control::frames::{abc_from_orientation, orientation_from_abc, pose_from_components};
use softdock_control::io::{self, Motion, RobotSample, Sequence};
use softdock_control::robot::{GimbalLock, RobotInterface};
use softdock_control::settings::{CorrectionMode, RobotSettings};
use softdock_link::decimal::Decimal;
use softdock_link::rsi::{
    self, Corrections, LARGEST_B_RAD, SenTelegram, SequenceTracker, Tags, parse_rob,
    poscorr_clamps, salvage_ipoc, write_sen,
};

/// Largest angle of a measured pose that is accepted, rad: KUKA's stay within ±π.
const LARGEST_ANGLE_RAD: f64 = 10.0;

/// A KUKA robot.
#[derive(Clone, Debug)]
pub struct Rsi {
    cycle_s: f64,
    tags: Tags,
    decimals: u8,
    sequence: SequenceTracker,
    corrections: Corrections,
}

impl Rsi {
    /// From settings.
    ///
    /// # Errors
    /// A name cannot be an RSI element.
    pub fn new(robot: &RobotSettings, rsi: &RsiSettings) -> Result<Self, BoardSettingsError> {
        Ok(Self::named(robot, rsi.tags()?, rsi.new_run_after_lost))
    }

    /// With the default names of elements: for a replay, which writes none.
    pub fn unnamed(robot: &RobotSettings) -> Self {
        Self::named(robot, Tags::default(), u32::MAX)
    }

    fn named(robot: &RobotSettings, tags: Tags, new_run_after_lost: u32) -> Self {
        // IPOC counts whole milliseconds: 4 or 12 per cycle on a KUKA controller.
        let cycle_ms = (robot.cycle_s * 1e3 + 0.5) as u64;
        let absolute = robot.correction_mode == CorrectionMode::Absolute;
        Self {
            cycle_s: robot.cycle_s,
            tags,
            decimals: robot.correction_decimals,
            sequence: SequenceTracker::new(cycle_ms, new_run_after_lost),
            corrections: Corrections::new(absolute, robot.correction_decimals),
        }
    }
}

impl RobotProtocol for Rsi {
    /// B is the angle of M's x axis out of the plane perpendicular to C's z axis.
    fn interface(&self) -> RobotInterface {
        RobotInterface {
            cycle_s: self.cycle_s,
            gimbal_lock: Some(GimbalLock {
                axis_in_m: [1.0, 0.0, 0.0],
                axis_in_c: [0.0, 0.0, 1.0],
                largest_angle_rad: LARGEST_B_RAD,
            }),
        }
    }

    fn read(&self, datagram: &[u8]) -> Received {
        match parse_rob(datagram, &self.tags) {
            Ok(telegram) => Received::Telegram(RobotReport {
                counter: telegram.ipoc,
                sequence: Sequence::default(),
                pose: telegram.pose_si(),
                late_answers: telegram.late_answers.unwrap_or_default(),
                status: telegram.poscorr_stat.unwrap_or_default(),
            }),
            Err(_) => salvage_ipoc(datagram).map_or(Received::Unreadable, Received::Counter),
        }
    }

    fn forget(&mut self) {
        self.sequence.reset();
    }

    fn follow(&mut self, counter: u64) -> Option<Sequence> {
        match self.sequence.classify(counter) {
            rsi::Sequence::First | rsi::Sequence::NewRun => Some(Sequence::NewRun),
            rsi::Sequence::Next => Some(Sequence::Next),
            rsi::Sequence::Gap { lost } => Some(Sequence::Gap(lost)),
            rsi::Sequence::Duplicate | rsi::Sequence::Late => None,
        }
    }

    fn is_late(&self, counter: u64, other: u64) -> bool {
        self.sequence.is_late(counter, other)
    }

    fn sample(&self, report: &RobotReport) -> RobotSample {
        RobotSample {
            sequence: report.sequence,
            pose: report.pose.map(pose),
            gimbal_locked: report
                .pose
                .is_some_and(|pose| pose[4].abs() > LARGEST_B_RAD),
            late_answers: report.late_answers,
            clamped: poscorr_clamps(report.status),
        }
    }

    fn correct(&mut self, report: &RobotReport, wanted: &io::Output) -> Correction {
        if report.sequence == Sequence::NewRun {
            self.corrections.new_run();
        }
        if wanted.start {
            let [_, _, _, a, b, c] = report.pose.unwrap_or_default();
            self.corrections.start([a, b, c]);
        }
        match &wanted.motion {
            Motion::Rest => self.corrections.rest(),
            Motion::Move {
                displacement_m,
                orientation_wxyz: [w, x, y, z],
                ..
            } => {
                let commanded = pose_from_components::<f64>(&[0.0, 0.0, 0.0, *w, *x, *y, *z]);
                let abc = abc_from_orientation(&commanded.rotation);
                self.corrections.advance(*displacement_m, abc)
            }
        }
    }

    fn rest(&self) -> Correction {
        self.corrections.rest()
    }

    fn write(&self, counter: u64, answer: &Output, bytes: &mut [u8]) -> usize {
        let decimals = self.decimals;
        let telegram = SenTelegram {
            ipoc: counter,
            correction: answer.correction.map(|counts| Decimal { counts, decimals }),
            stop: answer.stop,
        };
        // The counts of a limited step always fit.
        write_sen(&telegram, &self.tags, bytes).unwrap_or(0)
    }
}

/// Position and quaternion of x y z (m), A B C (rad).
fn pose([x, y, z, a, b, c]: [f64; 6]) -> [f64; 7] {
    let believed = [a, b, c]
        .iter()
        .all(|angle| angle.abs() <= LARGEST_ANGLE_RAD);
    let [w, i, j, k] = match believed {
        true => {
            let q = orientation_from_abc::<f64>(&[a, b, c]);
            [q.w, q.i, q.j, q.k]
        }
        false => [f64::NAN; 4],
    };
    [x, y, z, w, i, j, k]
}
