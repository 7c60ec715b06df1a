//! A board with its two tasks, a robot that sends telegrams, and a sensor.

use crate::world::{Event, Handle, Sent, Task, World, run};
use embassy_sync::blocking_mutex::raw::NoopRawMutex;
use softdock_app::auto_start::AutoStart;
use softdock_app::meter::Meter;
use softdock_app::record::CycleRecord;
use softdock_app::robot::RobotTask;
use softdock_app::robot_link::{Prepared, RobotLink};
use softdock_app::settings::BoardSettings;
use softdock_app::shared::{Shared, Status};
use softdock_control::modes::{Command, FaultCode, Mode};
use softdock_link::rsi::{RobTelegram, SenTelegram, Tags, parse_sen, write_rob};
use std::cell::RefMut;
use std::net::SocketAddr;

/// The robot's cycle, µs.
pub(crate) const CYCLE_US: u64 = 4_000;
/// Time of the first telegram, after the start of the sensor, µs.
pub(crate) const FIRST_TELEGRAM_US: u64 = 40_000;
/// Correction X of one cycle of [`flying`]: 10 mm/s · 4 ms = 0.04 mm, with four decimals.
pub(crate) const CRUISE_COUNTS: i64 = 400;
/// Cycles of a start: hold, arm, start, zero cycles and ramp.
pub(crate) const START_CYCLES: usize = 30;

/// A robot's address.
pub(crate) fn robot() -> SocketAddr {
    "192.168.1.10:49152".parse().unwrap()
}

/// Another computer on the network.
pub(crate) fn stranger() -> SocketAddr {
    "192.168.1.66:49152".parse().unwrap()
}

/// Settings of a spacecraft that moves at 10 mm/s along x.
pub(crate) fn flying() -> BoardSettings {
    let mut settings = BoardSettings::default();
    settings.control.body_k.velocity_m_s = [0.01, 0.0, 0.0];
    settings.control.body_q.fixed = true;
    // The simulated robot does not execute the corrections.
    settings.control.delay.law = softdock_control::delay::LawName::None;
    settings
}

pub(crate) struct Bench {
    world: Handle,
    pub(crate) shared: &'static Shared<NoopRawMutex>,
    pub(crate) tasks: Vec<Task>,
    tags: Tags,
    /// Content of the next telegrams; the time stamp is set by [`Self::cycle`].
    pub(crate) says: RobTelegram,
    pub(crate) next_at_us: u64,
}

impl Bench {
    /// A board before the first telegram, with a running sensor. It starts automatically if `auto_start` is set.
    pub(crate) fn new(settings: &BoardSettings, auto_start: bool) -> Self {
        let mut bench = Self::switched_on(settings, auto_start);
        bench.run_to(FIRST_TELEGRAM_US - 1);
        bench
    }

    /// A board at time zero.
    pub(crate) fn switched_on(settings: &BoardSettings, auto_start: bool) -> Self {
        let world = Handle::default();
        let shared: &'static Shared<NoopRawMutex> = Box::leak(Box::new(Shared::new()));
        let driver = settings.can.driver();
        let mut task = RobotTask {
            shared,
            link: RobotLink::<f64>::new(Prepared::new(settings).unwrap()),
            auto_start: AutoStart::new(auto_start),
            sample_wait_us: settings.sample_wait_us(),
            meter: Meter::default(),
        };
        let (mut bus, bus_clock) = (world.clone(), world.clone());
        let (mut socket, clock, mut recorder) = (world.clone(), world.clone(), world.clone());
        let tasks = vec![
            Task::new(async move {
                softdock_app::sensor::run(shared, &mut bus, &bus_clock, driver).await;
            }),
            Task::new(async move { task.run(&mut socket, &clock, &mut recorder).await }),
        ];
        Self {
            world,
            shared,
            tasks,
            tags: settings.rsi.tags().unwrap(),
            says: RobTelegram {
                ipoc: 1_000_000,
                actual_pose: Some([1000.0, 0.0, 1000.0, 0.0, 0.0, 0.0]),
                late_answers: Some(0),
                poscorr_stat: Some(1),
                ..RobTelegram::default()
            },
            next_at_us: FIRST_TELEGRAM_US,
        }
    }

    /// A board that moves the robot at full speed.
    pub(crate) fn cruising(settings: &BoardSettings) -> Self {
        let mut bench = Self::new(settings, true);
        bench.cycles(START_CYCLES);
        assert_eq!(bench.status().mode, Mode::Running);
        bench
    }

    /// Another handle on the world, for a task.
    pub(crate) fn handle(&self) -> Handle {
        self.world.clone()
    }

    pub(crate) fn world(&self) -> RefMut<'_, World> {
        self.world.0.borrow_mut()
    }

    pub(crate) fn status(&self) -> Status {
        self.shared.status()
    }

    pub(crate) fn fault(&self) -> Option<FaultCode> {
        self.status().fault.map(|fault| fault.code)
    }

    /// Asserts a latched fault and its numbers.
    pub(crate) fn assert_fault(&self, code: FaultCode, expected: f64, received: f64) {
        let status = self.status();
        assert_eq!(status.mode, Mode::Fault);
        let fault = status.fault.map(|f| (f.code, f.expected, f.received));
        assert_eq!(fault, Some((code, expected, received)));
    }

    pub(crate) fn run_to(&mut self, at_us: u64) {
        run(&self.world, &mut self.tasks, at_us);
    }

    /// The next telegram of the robot.
    pub(crate) fn telegram(&self) -> Vec<u8> {
        self.telegram_at(self.says.ipoc)
    }

    pub(crate) fn telegram_at(&self, ipoc: u64) -> Vec<u8> {
        let mut bytes = [0; 1024];
        let telegram = RobTelegram { ipoc, ..self.says };
        let length = write_rob(&telegram, 6, &self.tags, &mut bytes).unwrap();
        bytes[..length].to_vec()
    }

    /// The time stamp of the last telegram.
    pub(crate) fn last_ipoc(&self) -> u64 {
        self.says.ipoc - CYCLE_US / 1000
    }

    /// Skips telegrams, as if the network had lost them.
    pub(crate) fn lose(&mut self, telegrams: u64) {
        self.says.ipoc += telegrams * CYCLE_US / 1000;
        self.next_at_us += telegrams * CYCLE_US;
    }

    /// Delivers datagrams at the time of the next telegram, instead of it, and runs to the end of the cycle; returns the
    /// answers.
    pub(crate) fn datagrams(&mut self, datagrams: &[(&[u8], SocketAddr)]) -> Vec<Sent> {
        let answered = self.world().answers.len();
        for (bytes, from) in datagrams {
            let event = Event::Datagram(bytes.to_vec(), *from);
            self.world().schedule(self.next_at_us, event);
        }
        self.says.ipoc += CYCLE_US / 1000;
        self.next_at_us += CYCLE_US;
        self.run_to(self.next_at_us - 1);
        self.world().answers[answered..].to_vec()
    }

    /// The answer to one datagram.
    pub(crate) fn datagram(&mut self, bytes: &[u8], from: SocketAddr) -> Option<Sent> {
        let mut answers = self.datagrams(&[(bytes, from)]);
        assert!(answers.len() <= 1);
        answers.pop()
    }

    /// Sends one telegram of the robot; returns the answer.
    pub(crate) fn cycle(&mut self) -> SenTelegram {
        let (ipoc, telegram) = (self.says.ipoc, self.telegram());
        let answer = self.datagram(&telegram, robot()).expect("an answer");
        assert_eq!(answer.to, robot());
        let answer = self.parse(&answer);
        assert_eq!(answer.ipoc, ipoc);
        answer
    }

    pub(crate) fn cycles(&mut self, count: usize) {
        for _ in 0..count {
            self.cycle();
        }
    }

    /// Runs one cycle with a command of the operator; returns its record.
    pub(crate) fn command(&mut self, command: Command) -> CycleRecord {
        self.shared.commands.try_send(command).unwrap();
        self.cycle();
        self.last_record()
    }

    pub(crate) fn last_record(&self) -> CycleRecord {
        *self.world().records.last().expect("a record")
    }

    pub(crate) fn parse(&self, answer: &Sent) -> SenTelegram {
        parse_sen(&answer.bytes, &self.tags).expect("a whole answer")
    }
}

/// The components of a correction, in units of the last digit.
pub(crate) fn counts(answer: &SenTelegram) -> [i64; 6] {
    answer.correction.map(|decimal| decimal.counts)
}
