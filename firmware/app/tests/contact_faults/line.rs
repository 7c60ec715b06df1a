//! The robot's link between a plant and its faults, at the level of datagrams.

use core::net::SocketAddr;
use softdock_app::record::CycleRecord;
use softdock_app::robot_link::{Incoming, Prepared, RobotLink};
use softdock_app::settings::BoardSettings;
use softdock_control::io::SensorSample;
use softdock_control::modes::Command;
use softdock_link::rsi::{RobTelegram, Tags, parse_sen, write_rob};

const CYCLE_MS: i64 = 4;
/// Readings that are kept: more than any fault looks back.
const MOST_READINGS: usize = 32;

/// What happens in one cycle of the robot.
#[derive(Clone, Debug)]
pub(crate) struct Cycle {
    /// A new reading of the sensor.
    pub(crate) sample: Option<SensorSample>,
    /// mm and degrees.
    pub(crate) pose: Option<[f64; 6]>,
    pub(crate) late_answers: u32,
    pub(crate) clamps: bool,
    pub(crate) lost: bool,
    pub(crate) twice: bool,
    /// In place of the telegram; {} stands for its counter.
    pub(crate) text: Option<&'static str>,
    pub(crate) from: SocketAddr,
    pub(crate) strangers: usize,
    pub(crate) garbage: usize,
    pub(crate) command: Option<Command>,
}

impl Cycle {
    /// A healthy one.
    pub(crate) fn new(wrench: [f64; 6], pose_m_rad: [f64; 6]) -> Self {
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
            from: robot_at(50_000),
            strangers: 0,
            garbage: 0,
            command: None,
        }
    }

    pub(crate) fn drop_sample(&mut self, dropped: bool) {
        if dropped {
            self.sample = None;
        }
    }

    pub(crate) fn change(&mut self, change: impl FnOnce(&mut SensorSample)) {
        if let Some(sample) = &mut self.sample {
            change(sample);
        }
    }
}

/// The robot's computer at a port.
pub(crate) fn robot_at(port: u16) -> SocketAddr {
    SocketAddr::from(([192, 168, 1, 10], port))
}

/// What a cycle came to.
pub(crate) struct Answered {
    /// None: no cycle was run.
    pub(crate) record: Option<CycleRecord>,
    /// The correction, in counts; none: the robot got no answer.
    pub(crate) correction: Option<[i64; 6]>,
}

/// The link and what it has seen.
pub(crate) struct Line {
    link: RobotLink<f64>,
    tags: Tags,
    ipoc: i64,
    now_us: u64,
    /// The newest sample of the sensor.
    sensor: SensorSample,
    /// The reading of the last healthy cycle.
    pub(crate) last_reading: SensorSample,
    /// Healthy readings, the newest last.
    readings: Vec<SensorSample>,
}

impl Line {
    pub(crate) fn new(settings: &BoardSettings) -> Self {
        Self {
            link: RobotLink::new(Prepared::new(settings).unwrap()),
            tags: settings.rsi.tags().unwrap(),
            ipoc: 1_000_000,
            now_us: 0,
            sensor: SensorSample::default(),
            last_reading: SensorSample::default(),
            readings: Vec::new(),
        }
    }

    /// A reading of so many cycles ago.
    pub(crate) fn earlier(&self, cycles: usize) -> SensorSample {
        let place = self.readings.len().saturating_sub(1 + cycles);
        self.readings.get(place).copied().unwrap_or_default()
    }

    /// Remembers a healthy reading; while a fault lasts, the last one before it stays.
    pub(crate) fn remember(&mut self, reading: SensorSample, healthy: bool) {
        if self.readings.len() >= 2 * MOST_READINGS {
            self.readings.drain(..MOST_READINGS);
        }
        self.readings.push(reading);
        if healthy {
            self.last_reading = reading;
        }
    }

    /// The counter goes on from elsewhere.
    pub(crate) fn jump(&mut self, cycles: i64) {
        self.ipoc += cycles * CYCLE_MS;
    }

    /// One cycle of the robot. Whatever is sent by the robot and can be read is answered with its counter.
    pub(crate) fn run(&mut self, cycle: &Cycle) -> Answered {
        self.ipoc += CYCLE_MS;
        self.now_us += CYCLE_MS as u64 * 1000;
        if let Some(sample) = cycle.sample {
            let counter = self.sensor.counter + 1;
            self.sensor = SensorSample { counter, ..sample };
        }
        let telegram = self.telegram(cycle);
        for _ in 0..cycle.strangers {
            let from = SocketAddr::from(([192, 168, 1, 66], 50_000));
            assert_eq!(
                self.link.receive(&telegram, from, self.now_us),
                Incoming::Ignored
            );
        }
        for port in 0..cycle.garbage as u16 {
            let from = robot_at(50_000 + port);
            assert_eq!(
                self.link.receive(b"\0<Rob", from, self.now_us),
                Incoming::Ignored
            );
        }
        if cycle.lost {
            return Answered {
                record: None,
                correction: None,
            };
        }
        let answered = self.take(&telegram, cycle.from, cycle.command);
        if cycle.twice && answered.record.is_some() {
            let first = self.link.last_answer().to_vec();
            let again = self.take(&telegram, cycle.from, cycle.command);
            assert!(
                again.record.is_none(),
                "a telegram moves nothing a second time"
            );
            assert_eq!(self.link.last_answer(), first);
        }
        answered
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

    fn take(&mut self, telegram: &[u8], from: SocketAddr, command: Option<Command>) -> Answered {
        match self.link.receive(telegram, from, self.now_us) {
            Incoming::Telegram(report) => {
                let Some(sequence) = self.link.follow(&report) else {
                    let answer = self.link.last_answer().to_vec();
                    return Answered {
                        record: None,
                        correction: Some(self.read(&answer)),
                    };
                };
                let record = self.link.run_cycle(&report, sequence, self.sensor, command);
                let answer = self.link.last_answer().to_vec();
                let correction = self.read(&answer);
                assert_eq!(correction, record.output.correction);
                Answered {
                    record: Some(record),
                    correction: Some(correction),
                }
            }
            Incoming::Unreadable { counter } => {
                let answer = self.link.resting_answer(counter);
                let correction = self.read(&answer);
                assert_eq!(correction, [0; 6], "no cycle, no motion");
                Answered {
                    record: None,
                    correction: Some(correction),
                }
            }
            Incoming::Ignored => Answered {
                record: None,
                correction: None,
            },
        }
    }

    /// The correction of an answer, which must bear the counter of its telegram.
    fn read(&self, answer: &[u8]) -> [i64; 6] {
        let answer = parse_sen(answer, &self.tags).expect("an answer");
        assert_eq!(answer.ipoc as i64, self.ipoc);
        answer.correction.map(|axis| axis.counts)
    }
}
