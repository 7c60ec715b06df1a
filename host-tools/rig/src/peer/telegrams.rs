//! RSI as the simulated robot speaks it: reports in mm and degrees out, corrections in m and rad in.

use crate::rig::RobotReport;
use softdock_link::rsi::{RobTelegram, RsiError, Tags, parse_sen, write_rob};

/// Decimals of the telegrams; `softdock robot-config` asks for the same.
const DECIMALS: u8 = 6;
/// The first time stamp, ms.
const FIRST_IPOC: u64 = 1_000_000;
/// Room for a telegram.
const TELEGRAM_BYTES: usize = 1024;

/// The telegrams of a robot, one after the other.
#[derive(Clone, Debug)]
pub struct Telegrams {
    tags: Tags,
    cycle_us: u64,
    runs: u64,
    sent: u64,
}

/// What the board answered.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Answer {
    /// Time stamp of the telegram that it answers to.
    pub ipoc: u64,
    /// X Y Z (m), A B C (rad).
    pub correction: [f64; 6],
    /// The same in units of the last decimal of mm and degrees.
    pub counts: [i64; 6],
    /// Whether the robot is to stop.
    pub stop: bool,
}

impl Telegrams {
    /// Those of a robot with these names and this cycle.
    pub fn new(tags: Tags, cycle_us: u64) -> Self {
        Self {
            tags,
            cycle_us,
            runs: 0,
            sent: 0,
        }
    }

    /// Time stamp of the telegram that is next, or repeated.
    pub fn ipoc(&self) -> u64 {
        FIRST_IPOC - self.runs + self.sent * self.cycle_us / 1000
    }

    /// The telegram of this cycle.
    ///
    /// # Errors
    /// A pose that is not finite.
    pub fn write(&self, report: &RobotReport) -> Result<Vec<u8>, RsiError> {
        let telegram = RobTelegram {
            ipoc: self.ipoc(),
            actual_pose: Some(mm_and_degrees(report.actual_pose)),
            setpoint_pose: Some(mm_and_degrees(report.setpoint_pose)),
            late_answers: Some(report.late_answers),
            poscorr_stat: Some(report.poscorr_stat),
        };
        let mut bytes = vec![0; TELEGRAM_BYTES];
        let length = write_rob(&telegram, DECIMALS, &self.tags, &mut bytes)?;
        bytes.truncate(length);
        Ok(bytes)
    }

    /// Goes on to the next cycle.
    pub fn advance(&mut self) {
        self.sent += 1;
    }

    /// RSI begins anew. Its first time stamp lies before all that were sent, so that no board takes it for a gap,
    /// however long the gaps that it forgives.
    pub fn begin_run(&mut self) {
        (self.runs, self.sent) = (self.runs + 1, 0);
    }

    /// Reads an answer.
    ///
    /// # Errors
    /// Bytes that are none.
    pub fn read(&self, answer: &[u8]) -> Result<Answer, RsiError> {
        let answer = parse_sen(answer, &self.tags)?;
        let [x, y, z, a, b, c] = answer.correction.map(|decimal| decimal.to_f64());
        let [a, b, c] = [a, b, c].map(f64::to_radians);
        Ok(Answer {
            ipoc: answer.ipoc,
            correction: [x * 1e-3, y * 1e-3, z * 1e-3, a, b, c],
            counts: answer.correction.map(|decimal| decimal.counts),
            stop: answer.stop,
        })
    }
}

fn mm_and_degrees([x, y, z, a, b, c]: [f64; 6]) -> [f64; 6] {
    let [a, b, c] = [a, b, c].map(f64::to_degrees);
    [x * 1e3, y * 1e3, z * 1e3, a, b, c]
}
