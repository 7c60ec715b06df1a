//! The robot's link with its cycle, and a robot and a sensor that the test controls. Every answer is parsed and checked.

use crate::event::Event;
use core::net::SocketAddr;
use softdock_app::robot_link::{Incoming, Prepared, RobotLink};
use softdock_app::settings::BoardSettings;
use softdock_control::delay::LawName;
use softdock_control::io::SensorSample;
use softdock_control::jog::Jog;
use softdock_control::modes::{Command, Mode};
use softdock_link::rsi::{RobTelegram, Tags, parse_sen, write_rob};

/// A row of the table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Row {
    Idle,
    Hold,
    Stopping,
    Armed,
    Starting,
    Running,
    Jogging,
    Fault,
}

impl Row {
    pub(crate) const ALL: [Self; 8] = [
        Self::Idle,
        Self::Hold,
        Self::Stopping,
        Self::Armed,
        Self::Starting,
        Self::Running,
        Self::Jogging,
        Self::Fault,
    ];

    /// Whether the robot may move.
    pub(crate) fn moves(self) -> bool {
        matches!(
            self,
            Self::Starting | Self::Running | Self::Jogging | Self::Stopping
        )
    }
}

/// Cycles of a start: two with zero velocity, and the ramp.
const START_CYCLES: u32 = 27;
const CYCLE_MS: u64 = 4;
const FIRST_IPOC: u64 = 1_000_000;

#[derive(Clone)]
pub(crate) struct Rig {
    link: RobotLink<f64>,
    sensor: SensorSample,
    ipoc: u64,
    pub(crate) late_answers: u32,
    /// Cycles since the last start.
    running: u32,
    /// Whether the last cycle sent a velocity.
    fading: bool,
    /// Whether the last event sent a correction that is not zero.
    pub(crate) moved: bool,
}

fn robot() -> SocketAddr {
    SocketAddr::from(([192, 168, 1, 10], 50_000))
}

impl Rig {
    /// In Idle, connected, with a spacecraft that moves at 10 mm/s.
    fn new() -> Self {
        let mut settings = BoardSettings::default();
        settings.rsi.robot_ip = "192.168.1.10".try_into().unwrap();
        settings.control.body_k.velocity_m_s = [0.01, 0.0, 0.0];
        settings.control.body_q.fixed = true;
        settings.control.delay.law = LawName::None;
        let mut rig = Self {
            link: RobotLink::new(Prepared::new(&settings).unwrap()),
            sensor: SensorSample::default(),
            ipoc: FIRST_IPOC,
            late_answers: 0,
            running: 0,
            fading: false,
            moved: false,
        };
        rig.cycle();
        rig
    }

    /// A rig in the given row of the table.
    pub(crate) fn in_row(row: Row) -> Self {
        let mut rig = Self::new();
        let (hold, arm, start) = (Command::Hold, Command::Arm, Command::Start);
        let way: &[Event] = &match row {
            Row::Idle => vec![],
            Row::Hold => vec![Event::Command(hold)],
            Row::Armed => [hold, arm].map(Event::Command).into(),
            Row::Starting => [hold, arm, start].map(Event::Command).into(),
            Row::Running | Row::Stopping => {
                let mut way: Vec<_> = [hold, arm, start].map(Event::Command).into();
                way.push(Event::Quiet);
                way.extend((row == Row::Stopping).then_some(Event::Command(Command::Stop)));
                way
            }
            Row::Jogging => [hold, Command::Jog(Jog::X)].map(Event::Command).into(),
            Row::Fault => vec![Event::Command(hold), Event::Command(arm), Event::Saturated],
        };
        way.iter().for_each(|event| event.happen(&mut rig));
        assert_eq!(rig.row(), row);
        rig
    }

    pub(crate) fn row(&self) -> Row {
        match self.link.mode() {
            Mode::Idle => Row::Idle,
            Mode::Hold if self.fading => Row::Stopping,
            Mode::Hold => Row::Hold,
            Mode::Armed => Row::Armed,
            Mode::Running if self.running < START_CYCLES => Row::Starting,
            Mode::Running => Row::Running,
            Mode::Jogging => Row::Jogging,
            Mode::Fault => Row::Fault,
        }
    }

    /// A new reading of the sensor, with the usual flicker.
    pub(crate) fn sample(&mut self, change: impl FnOnce(&mut SensorSample)) {
        let counts = [0, 0, 0, 0, 0, i32::from(self.sensor.counts[5] == 0)];
        self.sensor = SensorSample {
            counter: self.sensor.counter + 1,
            counts,
            ..SensorSample::default()
        };
        change(&mut self.sensor);
    }

    /// One cycle without an event.
    pub(crate) fn cycle(&mut self) {
        self.spoiled(|_| {});
    }

    /// One cycle with a changed sample.
    pub(crate) fn spoiled(&mut self, change: impl FnOnce(&mut SensorSample)) {
        self.sample(change);
        self.telegram(|_| {}, None);
    }

    pub(crate) fn lose(&mut self, telegrams: u64) {
        self.ipoc += telegrams * CYCLE_MS;
    }

    pub(crate) fn restart_robot(&mut self) {
        self.ipoc -= 1000 * CYCLE_MS;
    }

    /// Sends the next telegram and checks the answer.
    pub(crate) fn telegram(
        &mut self,
        change: impl FnOnce(&mut RobTelegram),
        command: Option<Command>,
    ) {
        self.ipoc += CYCLE_MS;
        let bytes = self.written(change);
        let Incoming::Telegram(report) = self.receive(&bytes, robot()) else {
            panic!("a telegram was not read");
        };
        let sequence = self.link.follow(&report).expect("not twice");
        let record = self.link.run_cycle(&report, sequence, self.sensor, command);
        let answer = self.link.last_answer().to_vec();
        self.check(&answer, record.output.correction);
        self.fading = record.trace.sent_velocity != [0.0; 6];
        self.running = match record.trace.mode {
            Mode::Running => self.running + 1,
            _ => 0,
        };
    }

    /// Repeats the last telegram: the same answer, and no cycle.
    pub(crate) fn repeat(&mut self) {
        let before = self.link.last_answer().to_vec();
        let bytes = self.written(|_| {});
        let Incoming::Telegram(report) = self.receive(&bytes, robot()) else {
            panic!("a telegram was not read");
        };
        // If the first one was answered without a cycle, the repeated one is an ordinary telegram.
        match self.link.follow(&report) {
            None => assert_eq!(self.link.last_answer(), before),
            Some(sequence) => {
                let record = self.link.run_cycle(&report, sequence, self.sensor, None);
                let answer = self.link.last_answer().to_vec();
                self.check(&answer, record.output.correction);
            }
        }
    }

    /// A telegram of which only the counter is readable: the answer is zero.
    pub(crate) fn unreadable(&mut self) {
        self.ipoc += CYCLE_MS;
        let bytes = format!(
            "<Rob TYPE=\"KUKA\"><RIst X=\"?\"/><IPOC>{}</IPOC></Rob>",
            self.ipoc
        );
        let Incoming::Unreadable { counter } = self.receive(bytes.as_bytes(), robot()) else {
            panic!("the counter was not read");
        };
        let answer = self.link.resting_answer(counter);
        self.check(&answer, [0; 6]);
        self.ipoc -= CYCLE_MS;
    }

    pub(crate) fn garbage(&mut self) {
        assert_eq!(self.receive(b"<Rob", robot()), Incoming::Ignored);
    }

    pub(crate) fn stranger(&mut self) {
        let bytes = self.written(|_| {});
        let from = SocketAddr::from(([192, 168, 1, 66], 50_000));
        assert_eq!(self.receive(&bytes, from), Incoming::Ignored);
    }

    fn written(&self, change: impl FnOnce(&mut RobTelegram)) -> Vec<u8> {
        let mut telegram = RobTelegram {
            ipoc: self.ipoc,
            actual_pose: Some([0.0; 6]),
            setpoint_pose: None,
            late_answers: Some(self.late_answers),
            poscorr_stat: Some(0),
        };
        change(&mut telegram);
        let mut bytes = [0; 1024];
        let length = write_rob(&telegram, 6, &tags(), &mut bytes).unwrap();
        bytes[..length].to_vec()
    }

    fn receive(&mut self, bytes: &[u8], from: SocketAddr) -> Incoming {
        self.link.receive(bytes, from, self.ipoc * 1000)
    }

    /// Checks that the answer contains the counter of its telegram and the correction of its cycle.
    fn check(&mut self, answer: &[u8], correction: [i64; 6]) {
        let answer = parse_sen(answer, &tags()).expect("an answer");
        assert_eq!(answer.ipoc, self.ipoc);
        assert_eq!(answer.correction.map(|axis| axis.counts), correction);
        self.moved |= correction != [0; 6];
    }
}

fn tags() -> Tags {
    BoardSettings::default().rsi.tags().unwrap()
}
