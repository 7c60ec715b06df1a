//! A board between a plant and its faults, at the level of datagrams.

use crate::lockstep::Board;
use softdock_app::record::CycleRecord;
use softdock_app::settings::BoardSettings;
use softdock_control::io::SensorSample;
use softdock_control::modes::Command;
use softdock_link::rsi::{RobTelegram, Tags, parse_sen, write_rob};
use softdock_lockstep::{Done, STRANGER, Step};

const CYCLE_MS: i64 = 4;
/// Number of stored readings: more than any fault uses.
const MOST_READINGS: usize = 32;

/// Events of one cycle of the robot.
#[derive(Clone, Debug)]
pub(super) struct Cycle {
    /// A new reading of the sensor.
    pub(super) sample: Option<SensorSample>,
    /// Pose in the telegram, mm and degrees.
    pub(super) pose: Option<[f64; 6]>,
    pub(super) late_answers: u32,
    pub(super) clamps: bool,
    pub(super) lost: bool,
    pub(super) twice: bool,
    /// Text instead of the telegram; {} stands for its counter.
    pub(super) text: Option<&'static str>,
    /// Sender of the telegram; 0 is the robot.
    pub(super) sender: u8,
    pub(super) strangers: usize,
    pub(super) garbage: usize,
    pub(super) command: Option<Command>,
}

impl Cycle {
    /// A cycle without a fault.
    pub(super) fn new(wrench: [f64; 6], pose_m_rad: [f64; 6]) -> Self {
        let [x, y, z, a, b, c] = pose_m_rad;
        let degrees = [a, b, c].map(f64::to_degrees);
        Self {
            sample: Some(SensorSample {
                wrench,
                counts: wrench.map(|part| (part * 1e3) as i32),
                ..SensorSample::default()
            }),
            pose: Some([
                x * 1e3,
                y * 1e3,
                z * 1e3,
                degrees[0],
                degrees[1],
                degrees[2],
            ]),
            late_answers: 0,
            clamps: false,
            lost: false,
            twice: false,
            text: None,
            sender: 0,
            strangers: 0,
            garbage: 0,
            command: None,
        }
    }

    pub(super) fn drop_sample(&mut self, dropped: bool) {
        if dropped {
            self.sample = None;
        }
    }

    pub(super) fn change(&mut self, change: impl FnOnce(&mut SensorSample)) {
        if let Some(sample) = &mut self.sample {
            change(sample);
        }
    }
}

/// Result of a cycle.
pub(super) struct Answered {
    /// None if no cycle was run.
    pub(super) record: Option<CycleRecord>,
    /// The correction, in counts; none if the robot got no answer.
    pub(super) correction: Option<[i64; 6]>,
}

/// A board and its history.
pub(super) struct Line {
    board: Box<dyn Board>,
    tags: Tags,
    ipoc: i64,
    now_us: u64,
    /// The newest sample of the sensor.
    sensor: SensorSample,
    /// The reading of the last healthy cycle.
    pub(super) last_reading: SensorSample,
    /// Healthy readings, the newest last.
    readings: Vec<SensorSample>,
}

impl Line {
    pub(super) fn new(settings: &BoardSettings, board: Box<dyn Board>) -> Self {
        Self {
            board,
            tags: settings.rsi.tags().unwrap(),
            ipoc: 1_000_000,
            now_us: 0,
            sensor: SensorSample::default(),
            last_reading: SensorSample::default(),
            readings: Vec::new(),
        }
    }

    /// The reading of some cycles ago.
    pub(super) fn earlier(&self, cycles: usize) -> SensorSample {
        let place = self.readings.len().saturating_sub(1 + cycles);
        self.readings.get(place).copied().unwrap_or_default()
    }

    /// Stores a healthy reading. During a fault, the last reading before it is kept.
    pub(super) fn remember(&mut self, reading: SensorSample, healthy: bool) {
        if self.readings.len() >= 2 * MOST_READINGS {
            self.readings.drain(..MOST_READINGS);
        }
        self.readings.push(reading);
        if healthy {
            self.last_reading = reading;
        }
    }

    /// Moves the counter by some cycles.
    pub(super) fn jump(&mut self, cycles: i64) {
        self.ipoc += cycles * CYCLE_MS;
    }

    /// Runs one cycle of the robot. Every readable telegram of the robot is answered with its counter.
    pub(super) fn run(&mut self, cycle: &Cycle) -> Answered {
        self.ipoc += CYCLE_MS;
        self.now_us += CYCLE_MS as u64 * 1000;
        if let Some(sample) = cycle.sample {
            let counter = self.sensor.counter + 1;
            self.sensor = SensorSample { counter, ..sample };
        }
        let telegram = self.telegram(cycle);
        for _ in 0..cycle.strangers {
            self.ignores(&telegram, STRANGER);
        }
        for sender in 0..cycle.garbage as u8 {
            self.ignores(b"\0<Rob", sender);
        }
        if cycle.lost {
            return Answered {
                record: None,
                correction: None,
            };
        }
        let done = self.take(&telegram, cycle.sender, cycle.command);
        let correction = (!done.answer.is_empty()).then(|| self.read(&done.answer));
        let decided = done
            .record
            .map_or([0; 6], |record| record.output.correction);
        assert!(
            correction.is_none_or(|sent| sent == decided),
            "without a cycle no motion, and with one its own"
        );
        if cycle.twice && done.record.is_some() {
            let again = self.take(&telegram, cycle.sender, cycle.command);
            assert!(
                again.record.is_none(),
                "a telegram moves nothing a second time"
            );
            assert_eq!(again.answer, done.answer);
        }
        Answered {
            record: done.record,
            correction,
        }
    }

    fn telegram(&self, cycle: &Cycle) -> Vec<u8> {
        if let Some(text) = cycle.text {
            return text.replace("{}", &self.ipoc.to_string()).into_bytes();
        }
        let telegram = RobTelegram {
            ipoc: self.ipoc as u64,
            actual_pose: cycle.pose,
            setpoint_pose: None,
            late_answers: Some(cycle.late_answers),
            poscorr_stat: Some(if cycle.clamps { 2 } else { 1 }),
        };
        let mut bytes = [0; 1024];
        let length = write_rob(&telegram, 6, &self.tags, &mut bytes).unwrap();
        bytes[..length].to_vec()
    }

    fn ignores(&mut self, datagram: &[u8], sender: u8) {
        let done = self.take(datagram, sender, None);
        assert!(done.answer.is_empty() && done.record.is_none());
    }

    fn take(&mut self, datagram: &[u8], sender: u8, command: Option<Command>) -> Done {
        self.board.take(Step {
            datagram: heapless::Vec::from_slice(datagram).unwrap(),
            sender,
            now_us: self.now_us,
            sample: self.sensor,
            command,
        })
    }

    /// The correction of an answer, which must have the counter of its telegram.
    fn read(&self, answer: &[u8]) -> [i64; 6] {
        let answer = parse_sen(answer, &self.tags).expect("an answer");
        assert_eq!(answer.ipoc as i64, self.ipoc);
        answer.correction.map(|axis| axis.counts)
    }
}
