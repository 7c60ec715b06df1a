//! From a datagram to its answer: sender, form, sequence, then one control cycle.
//!
//! Whatever comes, the robot gets an answer with its own IPOC as long as that can be read; a
//! sender that is not the robot gets none and changes nothing.

use crate::settings::{BoardSettings, BoardSettingsError};
use crate::shared::LinkCounters;
use core::net::{IpAddr, SocketAddr};
use softdock_control::correction::Counts;
use softdock_control::cost::Probe;
use softdock_control::cycle::Cycle;
use softdock_control::io::{CycleRecord, Inputs, RobotSample, SensorSample, Sequence};
use softdock_control::modes::{Command, Mode};
use softdock_control::scalar::Scalar;
use softdock_link::decimal::Decimal;
use softdock_link::rsi::{
    self, RobTelegram, SEN_MAX_BYTES, SenTelegram, SequenceTracker, Tags, parse_rob, salvage_ipoc,
    write_sen,
};

/// Cycles without a telegram after which the robot counts as silent.
const SILENT_CYCLES: u64 = 3;

/// An answer as bytes.
pub type Answer = heapless::Vec<u8, SEN_MAX_BYTES>;

/// The robot's link and the control cycle behind it.
#[derive(Clone, Debug)]
pub struct RobotLink<S: Scalar> {
    cycle: Cycle<S>,
    tags: Tags,
    decimals: u8,
    sequence: SequenceTracker,
    allowed: Option<IpAddr>,
    cycle_us: u64,
    silence_us: u64,
    /// The robot's address and when it was last heard.
    robot: Option<(SocketAddr, u64)>,
    /// The answer of the last cycle, and whether it asks the robot to stop.
    last_answer: Answer,
    stop: bool,
    counters: LinkCounters,
}

/// What a datagram turned out to be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Incoming {
    /// A telegram of the robot; [`RobotLink::follow`] says where it stands in the sequence.
    Telegram(RobTelegram),
    /// A telegram of the robot of which only the time stamp can be read: no cycle is run, the
    /// answer is [`RobotLink::resting_answer`]. The next telegram then follows a gap.
    Unreadable {
        /// Its time stamp, ms.
        ipoc: u64,
    },
    /// No answer.
    Ignored,
}

impl<S: Scalar> RobotLink<S> {
    /// From settings, which are checked here.
    pub fn new(settings: &BoardSettings) -> Result<Self, BoardSettingsError> {
        settings.validate()?;
        let robot = &settings.control.robot;
        // Whole milliseconds: 4 or 12 on a KUKA controller.
        let cycle_ms = (robot.cycle_s * 1e3 + 0.5) as u64;
        Ok(Self {
            cycle: Cycle::new(&settings.control)?,
            tags: settings.rsi.tags()?,
            decimals: robot.correction_decimals,
            sequence: SequenceTracker::new(cycle_ms, settings.rsi.new_run_after_lost),
            allowed: settings.rsi.robot_ip()?,
            cycle_us: cycle_ms * 1000,
            silence_us: settings.rsi.silence_us(),
            robot: None,
            last_answer: Answer::new(),
            stop: false,
            counters: LinkCounters::default(),
        })
    }

    /// The mode of the control cycle.
    pub fn mode(&self) -> Mode {
        self.cycle.mode()
    }

    /// The control cycle, for observers.
    pub fn cycle(&self) -> &Cycle<S> {
        &self.cycle
    }

    /// What was counted.
    pub fn counters(&self) -> LinkCounters {
        self.counters
    }

    /// Counts a telegram of the robot that a newer one has overtaken.
    pub fn count_overtaken(&mut self) {
        self.counters.overtaken = self.counters.overtaken.saturating_add(1);
    }

    /// When the robot counts as silent unless it is heard before, µs; never before the first
    /// telegram.
    pub fn silent_at_us(&self) -> u64 {
        self.robot.map_or(u64::MAX, |(_, heard_us)| {
            heard_us.saturating_add(SILENT_CYCLES * self.cycle_us)
        })
    }

    /// Looks at a datagram; `now_us` is only used to tell silence.
    pub fn receive(&mut self, datagram: &[u8], from: SocketAddr, now_us: u64) -> Incoming {
        if !self.is_robot(from, now_us) {
            self.counters.foreign = self.counters.foreign.saturating_add(1);
            return Incoming::Ignored;
        }
        match parse_rob(datagram, &self.tags) {
            Ok(telegram) => {
                self.connect(from, now_us);
                Incoming::Telegram(telegram)
            }
            Err(_) => self.malformed(datagram, from, now_us),
        }
    }

    /// Where a telegram stands in the sequence; none for the last one again, which is not to move
    /// anything a second time: its answer is [`Self::last_answer`].
    pub fn follow(&mut self, telegram: &RobTelegram) -> Option<Sequence> {
        let counters = &mut self.counters;
        match self.sequence.classify(telegram.ipoc) {
            rsi::Sequence::First | rsi::Sequence::NewRun => {
                counters.runs = counters.runs.saturating_add(1);
                Some(Sequence::NewRun)
            }
            rsi::Sequence::Next => Some(Sequence::Next),
            rsi::Sequence::Gap { lost } => {
                counters.lost = counters.lost.saturating_add(lost);
                Some(Sequence::Gap(lost))
            }
            rsi::Sequence::Duplicate => {
                counters.duplicates = counters.duplicates.saturating_add(1);
                None
            }
        }
    }

    /// Runs the control cycle for a telegram; the answer is then [`Self::last_answer`].
    pub fn run_cycle(
        &mut self,
        telegram: &RobTelegram,
        sequence: Sequence,
        sensor: SensorSample,
        command: Option<Command>,
    ) -> CycleRecord {
        self.run_cycle_counted(telegram, sequence, sensor, command, &mut ())
    }

    /// [`Self::run_cycle`], telling which phases of the cycle are finished.
    pub fn run_cycle_counted(
        &mut self,
        telegram: &RobTelegram,
        sequence: Sequence,
        sensor: SensorSample,
        command: Option<Command>,
        probe: &mut impl Probe,
    ) -> CycleRecord {
        let robot = RobotSample {
            ipoc: telegram.ipoc,
            sequence,
            pose: telegram.actual_pose.map(si_pose),
            late_answers: telegram.late_answers.unwrap_or_default(),
            poscorr_stat: telegram.poscorr_stat.unwrap_or_default(),
        };
        let record = self.cycle.step_counted(
            &Inputs {
                robot,
                sensor,
                command,
            },
            probe,
        );
        self.stop = record.output.stop;
        self.last_answer = self.answer(telegram.ipoc, &record.output.correction);
        self.counters.cycles += 1;
        record
    }

    /// The answer of the last cycle.
    pub fn last_answer(&self) -> &Answer {
        &self.last_answer
    }

    /// The answer that moves nothing, to a telegram that no cycle is run for.
    pub fn resting_answer(&self, ipoc: u64) -> Answer {
        self.answer(ipoc, &self.cycle.resting_correction())
    }

    /// Whether a datagram may be the robot's: its configured address, and the sender that is
    /// connected, unless that has been silent for too long.
    fn is_robot(&self, from: SocketAddr, now_us: u64) -> bool {
        let allowed = self.allowed.is_none_or(|ip| ip == from.ip());
        let free = match self.robot {
            Some((robot, heard)) => robot == from || now_us.saturating_sub(heard) > self.silence_us,
            None => true,
        };
        allowed && free
    }

    fn connect(&mut self, from: SocketAddr, now_us: u64) {
        if self.robot.is_none_or(|(robot, _)| robot != from) {
            self.sequence.reset();
        }
        self.robot = Some((from, now_us));
    }

    /// The connected robot gets an answer if its time stamp can be read.
    fn malformed(&mut self, datagram: &[u8], from: SocketAddr, now_us: u64) -> Incoming {
        self.counters.malformed = self.counters.malformed.saturating_add(1);
        if self.robot.is_none_or(|(robot, _)| robot != from) {
            return Incoming::Ignored;
        }
        self.robot = Some((from, now_us));
        match salvage_ipoc(datagram) {
            Some(ipoc) => Incoming::Unreadable { ipoc },
            None => Incoming::Ignored,
        }
    }

    fn answer(&self, ipoc: u64, correction: &Counts) -> Answer {
        let decimals = self.decimals;
        let telegram = SenTelegram {
            ipoc,
            correction: correction.map(|counts| Decimal { counts, decimals }),
            stop: self.stop,
        };
        let mut bytes = [0; SEN_MAX_BYTES];
        // The buffer holds the longest answer, and counts of a limited step fit any digit: an
        // error cannot occur. Were it to, no answer is better than a wrong one.
        let length = write_sen(&telegram, &self.tags, &mut bytes).unwrap_or(0);
        Answer::from_slice(bytes.get(..length).unwrap_or_default()).unwrap_or_default()
    }
}

/// mm and degrees of a telegram in m and rad.
fn si_pose(pose: [f64; 6]) -> [f64; 6] {
    let [x, y, z, a, b, c] = pose;
    let m = |mm: f64| mm * 1e-3;
    [
        m(x),
        m(y),
        m(z),
        a.to_radians(),
        b.to_radians(),
        c.to_radians(),
    ]
}
