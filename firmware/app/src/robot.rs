//! The robot task: answers each telegram with one control cycle. The robot is the clock.

use crate::auto_start::AutoStart;
use crate::board::{Clock, DatagramSocket, IoError, Recorder};
use crate::meter::Meter;
use crate::record::{CycleRecord, RobotReport};
use crate::robot_link::{Incoming, RobotLink};
use crate::robot_protocol::RobotProtocol;
use crate::rsi::Rsi;
use crate::shared::{LastTelegram, Shared};
use core::net::SocketAddr;
use embassy_futures::select::{Either, select};
use embassy_sync::blocking_mutex::raw::RawMutex;
use softdock_control::io::{SensorSample, Sequence};
use softdock_control::modes::{Command, Mode, Refusal};
use softdock_control::scalar::Scalar;
use softdock_link::sensor::SensorState;

/// Longest telegram that is read: the payload of an Ethernet frame, which no robot exceeds.
pub const TELEGRAM_BYTES: usize = 1500;

/// Most queued datagrams that are read before one is answered, so that a flood of foreign ones cannot keep the robot waiting.
const MOST_QUEUED: usize = 32;

/// What the robot task owns.
pub struct RobotTask<'a, M: RawMutex, S: Scalar, P: RobotProtocol = Rsi> {
    /// State shared with the other tasks.
    pub shared: &'a Shared<M>,
    /// The link and the cycle.
    pub link: RobotLink<S, P>,
    /// Commands without an operator.
    pub auto_start: AutoStart,
    /// Longest wait for the sample that a telegram asks for, µs.
    pub sample_wait_us: u64,
    /// Measures, after the answer.
    pub meter: Meter,
}

impl<M: RawMutex, S: Scalar, P: RobotProtocol> RobotTask<'_, M, S, P> {
    /// Runs until the socket is closed.
    pub async fn run(
        &mut self,
        socket: &mut impl DatagramSocket,
        clock: &impl Clock,
        recorder: &mut impl Recorder,
    ) {
        let mut buffer = [0; TELEGRAM_BYTES];
        loop {
            let (incoming, from) = match self.newest(socket, clock, &mut buffer).await {
                Ok(newest) => newest,
                Err(IoError::Closed) => return,
                Err(IoError::BusOff | IoError::Lost) => continue,
            };
            // Read before the next one comes.
            let came_us = socket.came_us(from).unwrap_or(self.link.heard_us());
            let record = self.run_cycle(incoming, clock).await;
            let sent = self.answer(incoming, socket, from).await;
            let (gone_us, gone) = (clock.now_us(), clock.processor_cycles());
            self.publish(record.as_ref(), incoming != Incoming::Ignored);
            if let Some(record) = &record {
                self.meter.end(gone);
                self.measure(record, came_us, gone_us);
                recorder.record(record);
            }
            if sent == Err(IoError::Closed) {
                return;
            }
        }
    }

    /// The newest queued datagram of the robot; older ones are counted and dropped, as their answers would be late.
    async fn newest(
        &mut self,
        socket: &mut impl DatagramSocket,
        clock: &impl Clock,
        buffer: &mut [u8],
    ) -> Result<(Incoming, SocketAddr), IoError> {
        let (length, mut from) = self.next(socket, clock, buffer).await?;
        self.meter.begin(clock.processor_cycles());
        let mut newest = self.read(buffer, length, from, clock);
        for _ in 0..MOST_QUEUED {
            let Some((length, sender)) = socket.try_receive(buffer) else {
                break;
            };
            let incoming = self.read(buffer, length, sender, clock);
            if incoming == Incoming::Ignored {
                continue;
            }
            if newest != Incoming::Ignored {
                self.link.count_overtaken();
                if self.link.is_late(&incoming, &newest) {
                    continue;
                }
            }
            (newest, from) = (incoming, sender);
        }
        Ok((newest, from))
    }

    /// Waits for a datagram, and publishes if the robot falls silent.
    async fn next(
        &self,
        socket: &mut impl DatagramSocket,
        clock: &impl Clock,
        buffer: &mut [u8],
    ) -> Result<(usize, SocketAddr), IoError> {
        loop {
            let silent_at_us = match self.shared.status().connected {
                true => self.link.silent_at_us(),
                false => u64::MAX,
            };
            let silence = clock.wait_until(silent_at_us);
            match select(socket.receive(buffer), silence).await {
                Either::First(received) => return received,
                Either::Second(()) => self.shared.update_status(|status| status.connected = false),
            }
        }
    }

    fn read(
        &mut self,
        buffer: &[u8],
        length: usize,
        from: SocketAddr,
        clock: &impl Clock,
    ) -> Incoming {
        let datagram = buffer.get(..length).unwrap_or_default();
        self.link.receive(datagram, from, clock.now_us())
    }

    /// Runs the cycle that a datagram triggers, if any.
    async fn run_cycle(&mut self, incoming: Incoming, clock: &impl Clock) -> Option<CycleRecord> {
        let Incoming::Telegram(telegram) = incoming else {
            return None;
        };
        let sequence = self.link.follow(&telegram)?;
        let sample = self.sample_now(clock).await;
        let command = self.command(sequence, &sample);
        Some(self.link.run_cycle(&telegram, sequence, sample, command))
    }

    async fn answer(
        &self,
        incoming: Incoming,
        socket: &mut impl DatagramSocket,
        from: SocketAddr,
    ) -> Result<(), IoError> {
        let resting;
        let answer = match incoming {
            Incoming::Telegram(telegram) if self.link.has_answered(&telegram) => {
                self.link.last_answer()
            }
            Incoming::Telegram(RobotReport { counter, .. }) | Incoming::Unreadable { counter } => {
                resting = self.link.resting_answer(counter);
                &resting
            }
            Incoming::Ignored => &[],
        };
        match answer.is_empty() {
            true => Ok(()),
            false => socket.send(answer, from).await,
        }
    }

    /// Requests a sample for this telegram, so that force and pose are of one instant, and returns it; the newest one if it takes
    /// longer than the wait (0.35 ms is normal on CAN).
    async fn sample_now(&self, clock: &impl Clock) -> SensorSample {
        if self.shared.status().sensor == Some(SensorState::Running) {
            let until = clock.now_us() + self.sample_wait_us;
            self.shared.fresh.reset();
            self.shared.wanted.signal(());
            select(self.shared.fresh.wait(), clock.wait_until(until)).await;
        }
        self.shared.sample()
    }

    fn command(&mut self, sequence: Sequence, sample: &SensorSample) -> Option<Command> {
        if sequence == Sequence::NewRun {
            self.shared.commands.clear();
        }
        if self.shared.status().restarting {
            // Nothing may begin to move that the restart would cut off.
            self.shared.commands.clear();
            return None;
        }
        match self.shared.commands.try_receive() {
            Ok(command) => {
                self.auto_start.cancel();
                Some(command)
            }
            Err(_) => self
                .auto_start
                .command(self.link.mode(), sample.counter > 0),
        }
    }

    fn publish(&self, record: Option<&CycleRecord>, heard: bool) {
        let link = self.link.counters();
        self.shared.update_status(|status| {
            status.link = link;
            status.connected |= heard;
            if let Some(record) = record {
                status.mode = record.trace.mode;
                status.fault = record.trace.fault;
                status.moves = moves(record);
                status.telegram = Some(last_telegram(record));
                if let Some(command) = record.inputs.command {
                    status.commands = status.commands.wrapping_add(1);
                    status.refusal = record.trace.refusal.map(|refusal| (command, refusal));
                }
            }
        });
        if record.is_some_and(restarts_sensor) {
            self.shared.restart_sensor.signal(());
        }
    }
}

impl<M: RawMutex, S: Scalar, P: RobotProtocol> RobotTask<'_, M, S, P> {
    fn measure(&mut self, record: &CycleRecord, came_us: u64, gone_us: u64) {
        self.meter
            .take(record, came_us, gone_us, self.link.cycle_us());
        let meter = self.meter;
        self.shared.update_machine(|machine| {
            machine.answers = meter.answers();
            machine.inputs = meter.inputs();
            machine.work = meter.work();
        });
    }
}

fn last_telegram(record: &CycleRecord) -> LastTelegram {
    let robot = &record.inputs.robot;
    LastTelegram {
        late_answers: robot.late_answers,
        status: robot.status,
        pose: robot.pose.is_some(),
    }
}

/// Whether the robot moves or may begin to; a jog and a stop that fades out count as motions.
fn moves(record: &CycleRecord) -> bool {
    let mode = record.trace.mode;
    mode == Mode::Armed || mode.moves() || record.trace.sent_velocity != [0.0; 6]
}

/// Whether the operator's reset applies to the sensor: the sensor's data do not allow the reset, or there is no fault. The sensor
/// of a closed loop is not reset.
fn restarts_sensor(record: &CycleRecord) -> bool {
    let allowed = match record.trace.refusal {
        Some(Refusal::SensorStale | Refusal::SensorUnhealthy) => true,
        Some(Refusal::WrongMode) => record.trace.mode != Mode::Armed && !record.trace.mode.moves(),
        _ => false,
    };
    allowed && record.inputs.command == Some(Command::Reset)
}
