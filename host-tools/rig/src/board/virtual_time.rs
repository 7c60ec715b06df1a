//! A board and a simulated rig in virtual time: deterministic, and as fast as the machine allows.
//!
//! All codecs are in the loop: the robot's telegrams and the answers are RSI text, the sensor's
//! readings are CAN frames. Between two events all tasks come to rest; then the clock jumps to
//! the next event. The board itself takes no virtual time to answer.

use super::simulated_segment::SimulatedSegment;
use super::simulated_sensor::SimulatedSensor;
use super::tasks;
use super::time_driver::VirtualTime;
use super::world::Handle;
use crate::ethercat::Segment;
use crate::peer::telegrams::Telegrams;
use crate::rig::{Rig, SensorSampleSim, Truth};
use anyhow::{Context as _, Result, bail};
use embassy_sync::blocking_mutex::raw::NoopRawMutex;
use softdock_app::record::CycleRecord;
use softdock_app::robot_link::{Prepared, RobotLink};
use softdock_app::settings::BoardSettings;
use softdock_app::shared::Status;
use softdock_control::frames::pose_components;
use softdock_control::modes::Command;
use softdock_io::recording::TruthRecord;
use softdock_link::can::ati::AtiCalibration;
use std::collections::VecDeque;
use std::future::Future;
use std::ops::ControlFlow;
use std::pin::Pin;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::task::{Context, Wake, Waker};

/// The tasks of a simulated board share one thread.
type Shared = softdock_app::shared::Shared<NoopRawMutex>;

/// What the simulation calls after each cycle; `Break` ends it.
pub type OnCycle<'a> = dyn FnMut(&CycleRecord, &TruthRecord) -> ControlFlow<()> + 'a;

/// Callback before each telegram, with its number. It may disturb the EtherCAT segment.
pub type OnTelegram<'a> = dyn FnMut(u64, &mut Segment, &Status) + 'a;

/// A simulation to run.
pub struct Simulation<'a> {
    /// Settings of the board.
    pub board: &'a BoardSettings,
    /// The rig.
    pub rig: Rig,
    /// Calibration that the simulated sensor reports about itself.
    pub calibration: AtiCalibration,
    /// Length of the run, s.
    pub duration_s: f64,
    /// Operator's commands with their cycles, in order; if it is empty, the board arms and starts by itself.
    pub commands: Vec<(u64, Command)>,
}

/// Runs a simulation to its end and calls `on_cycle` after each cycle. Returns the rig in its final state.
pub fn simulate(simulation: Simulation<'_>, on_cycle: &mut OnCycle<'_>) -> Result<Rig> {
    simulate_disturbed(simulation, &mut |_, _, _| {}, on_cycle)
}

/// The same with disturbances of the EtherCAT segment.
pub fn simulate_disturbed(
    simulation: Simulation<'_>,
    on_telegram: &mut OnTelegram<'_>,
    on_cycle: &mut OnCycle<'_>,
) -> Result<Rig> {
    let settings = simulation.board;
    let link = RobotLink::<f64>::new(Prepared::new(settings)?);
    let handle = Handle::default();
    let shared = Shared::new();
    let start = simulation.commands.is_empty();
    let wait = settings.sample_wait_us();
    let mut conductor = Conductor::new(simulation, handle.clone(), &shared)?;
    let _time = VirtualTime::of(handle.clone());

    let (bus, port, clock) = (handle.clone(), handle.clone(), handle.clone());
    let sensor = tasks::sensor(&shared, settings.clone(), Some(bus), Some(port), clock);
    let (io, mut recorder) = ((handle.clone(), handle.clone()), handle);
    let robot = tasks::robot(&shared, link, start, wait, io, &mut recorder);
    // The telegram is the last part of an event, and the task that was woken last is polled first.
    let mut tasks = [Task::new(robot), Task::new(sensor)];
    while !conductor.ended {
        tasks.iter_mut().for_each(Task::poll_if_woken);
        conductor.turn(on_telegram, on_cycle)?;
    }
    drop(tasks);
    Ok(conductor.rig)
}

/// A task that is polled in place: an executor that sleeps between two turns costs a system call for each wake.
struct Task<'a> {
    /// None when it has ended.
    future: Option<Pin<Box<dyn Future<Output = ()> + 'a>>>,
    woken: Arc<Woken>,
    waker: Waker,
}

impl<'a> Task<'a> {
    fn new(future: impl Future<Output = ()> + 'a) -> Self {
        let woken = Arc::new(Woken(AtomicBool::new(true)));
        Self {
            future: Some(Box::pin(future)),
            waker: Waker::from(woken.clone()),
            woken,
        }
    }

    fn poll_if_woken(&mut self) {
        if !self.woken.0.swap(false, Ordering::Relaxed) {
            return;
        }
        let mut context = Context::from_waker(&self.waker);
        if let Some(future) = &mut self.future
            && future.as_mut().poll(&mut context).is_ready()
        {
            self.future = None;
        }
    }
}

/// Whether a task was woken since it was polled.
struct Woken(AtomicBool);

impl Wake for Woken {
    fn wake(self: Arc<Self>) {
        self.wake_by_ref();
    }

    fn wake_by_ref(self: &Arc<Self>) {
        self.0.store(true, Ordering::Relaxed);
    }
}

/// Moves the virtual clock and plays robot and sensor.
struct Conductor<'a> {
    handle: Handle,
    shared: &'a Shared,
    rig: Rig,
    sensor: SimulatedSensor,
    segment: SimulatedSegment,
    robot: Telegrams,
    commands: VecDeque<(u64, Command)>,
    cycle_us: u64,
    cycles_left: u64,
    next_telegram_us: u64,
    telegrams: u64,
    ended: bool,
    truth: TruthRecord,
    stop_asked: bool,
    seen_activity: u64,
}

impl<'a> Conductor<'a> {
    fn new(simulation: Simulation<'_>, handle: Handle, shared: &'a Shared) -> Result<Self> {
        let Simulation {
            board,
            rig,
            calibration,
            duration_s,
            commands,
        } = simulation;
        let cycle_s = board.control.robot.cycle_s;
        if !(duration_s > 0.0 && duration_s <= 86_400.0) {
            bail!("a run lasts more than 0 s and at most a day; {duration_s} s were asked for");
        }
        Ok(Self {
            sensor: SimulatedSensor::new(&board.can, calibration)?,
            segment: SimulatedSegment::new(calibration),
            robot: Telegrams::new(board.rsi.tags()?, (cycle_s * 1e6).round() as u64),
            commands: commands.into(),
            cycle_us: (cycle_s * 1e6).round() as u64,
            cycles_left: (duration_s / cycle_s).ceil() as u64,
            next_telegram_us: 0,
            telegrams: 0,
            ended: false,
            truth: TruthRecord::default(),
            stop_asked: false,
            seen_activity: 0,
            handle,
            shared,
            rig,
        })
    }

    /// Called whenever the tasks that were woken have been polled.
    fn turn(&mut self, on_telegram: &mut OnTelegram<'_>, on_cycle: &mut OnCycle<'_>) -> Result<()> {
        let activity = self.handle.0.borrow().activity;
        let at_rest = activity == self.seen_activity;
        self.seen_activity = activity;
        if !at_rest {
            return Ok(());
        }
        self.take_outputs(on_cycle)?;
        self.next_event(on_telegram)
    }

    /// Takes what the board has sent since the last event.
    fn take_outputs(&mut self, on_cycle: &mut OnCycle<'_>) -> Result<()> {
        let now_us = self.handle.0.borrow().now_us;
        while let Some(request) = self.pop(|world| world.frames_from_board.pop_front()) {
            let rig = &mut self.rig;
            self.sensor
                .receive(&request, now_us, &mut || sense(rig, now_us));
        }
        while let Some(frame) = self.pop(|world| world.ethernet_from_board.pop_front()) {
            let rig = &mut self.rig;
            self.segment
                .receive(&frame, now_us, &mut || sense(rig, now_us));
        }
        while let Some(answer) = self.pop(|world| world.answers.pop_front()) {
            let answer = self.robot.read(&answer).context("the board's answer")?;
            self.rig.answer(answer.correction, answer.stop);
        }
        let mut world = self.handle.0.borrow_mut();
        for record in &world.records {
            self.ended |= on_cycle(record, &self.truth).is_break();
        }
        world.records.clear();
        Ok(())
    }

    fn pop<T>(&self, take: impl FnOnce(&mut super::world::World) -> Option<T>) -> Option<T> {
        take(&mut self.handle.0.borrow_mut())
    }

    /// Lets the clock jump to the next alarm, frame or telegram, and carries that out.
    fn next_event(&mut self, on_telegram: &mut OnTelegram<'_>) -> Result<()> {
        let mut world = self.handle.0.borrow_mut();
        let alarm = world
            .alarms
            .iter()
            .map(|alarm| alarm.at_us)
            .min()
            .unwrap_or(u64::MAX);
        let sensor = self.sensor.next_us().min(self.segment.next_us());
        let next_us = alarm.min(sensor).min(self.next_telegram_us);
        world.now_us = next_us.max(world.now_us);
        let now_us = world.now_us;
        world.alarms.retain(|alarm| {
            let due = alarm.at_us <= now_us;
            if due {
                alarm.waker.wake_by_ref();
            }
            !due
        });
        let rig = &mut self.rig;
        while let Some(frame) = self.sensor.poll(now_us, &mut || sense(rig, now_us)) {
            world.frames_to_board.push(frame);
        }
        while let Some(frame) = self.segment.poll(now_us) {
            world.ethernet_to_board.push(frame);
        }
        drop(world);
        if self.next_telegram_us <= now_us {
            let status = self.shared.status();
            on_telegram(self.telegrams, &mut self.segment.segment, &status);
            self.send_telegram(now_us)?;
        }
        Ok(())
    }

    fn send_telegram(&mut self, now_us: u64) -> Result<()> {
        self.rig.advance_to(now_us);
        // The robot may have ended RSI; the records so far are valid.
        let report = if self.cycles_left > 0 {
            self.rig.begin_cycle()
        } else {
            None
        };
        let Some(report) = report else {
            self.ended = true;
            return Ok(());
        };
        self.truth = truth_record(&self.rig.truth());
        let telegram = self.robot.write(&report)?;
        self.robot.advance();
        while self
            .commands
            .front()
            .is_some_and(|(cycle, _)| *cycle <= self.telegrams)
        {
            if let Some((_, command)) = self.commands.pop_front() {
                // A full queue would mean eight commands in one cycle.
                let _ = self.shared.commands.try_send(command);
            }
        }
        if self.rig.asks_to_stop() && !self.stop_asked {
            self.stop_asked = true;
            let _ = self.shared.commands.try_send(Command::Stop);
        }
        self.handle.0.borrow_mut().telegrams.push(telegram);
        self.telegrams += 1;
        self.next_telegram_us += self.cycle_us;
        self.cycles_left -= 1;
        Ok(())
    }
}

fn truth_record(truth: &Truth) -> TruthRecord {
    TruthRecord {
        time_s: truth.time_s,
        pose: pose_components(&truth.pose),
        velocity: truth.twist.get(),
        contact_wrench: truth.contact.get(),
    }
}

/// A reading at this instant.
fn sense(rig: &mut Rig, now_us: u64) -> SensorSampleSim {
    rig.advance_to(now_us);
    rig.gauges()
}
