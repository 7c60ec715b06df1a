//! State shared by the tasks: the newest sample, the operator's commands, and the state for display.

use core::cell::Cell;
use embassy_sync::blocking_mutex::Mutex;
use embassy_sync::blocking_mutex::raw::RawMutex;
use embassy_sync::channel::Channel;
use embassy_sync::signal::Signal;
use softdock_control::io::SensorSample;
use softdock_control::modes::{Command, Fault, Mode, Refusal};
use softdock_link::sensor::{SensorCounters, SensorState};
use softdock_link::service::{
    AnswerTimes, EthernetHealth, InputStatistics, LoopBack, Machine, StackUse, Word, Work,
};

/// Commands that may wait for the next telegram.
const COMMANDS: usize = 8;

/// Counters of the robot's link; they only rise.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LinkCounters {
    /// Cycles that were run and answered.
    pub cycles: u64,
    /// Telegrams that came twice and got the same answer twice.
    pub duplicates: u32,
    /// Telegrams missing in the sequence, whether they were lost, overtaken or malformed.
    pub lost: u32,
    /// Telegrams that could not be read.
    pub malformed: u32,
    /// Datagrams of other senders; they got no answer.
    pub foreign: u32,
    /// Telegrams that were overtaken by a newer one before they could be answered.
    pub overtaken: u32,
    /// Number of runs of the robot, including the first.
    pub runs: u32,
}

/// Content of the robot's last telegram.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LastTelegram {
    /// Its counter of late or rejected answers.
    pub late_answers: u32,
    /// Its status bits, see [`RobotReport::status`](crate::record::RobotReport::status).
    pub status: u32,
    /// It sent its pose.
    pub pose: bool,
}

/// The newest sample, without its values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LastSample {
    /// Its number.
    pub counter: u32,
    /// When it was taken, µs.
    pub at_us: u64,
    /// Status word of the sensor.
    pub status: u32,
    /// A gauge is at its range.
    pub saturated: bool,
}

/// State for the service, the display and the watchdog.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Status {
    /// Mode of the last cycle.
    pub mode: Mode,
    /// The latched fault.
    pub fault: Option<Fault>,
    /// The last refused command, until one is accepted.
    pub refusal: Option<(Command, Refusal)>,
    /// Commands that were carried out or refused.
    pub commands: u32,
    /// The robot moves, or may begin to without a further command of a person: it is armed, the
    /// loop is closed, a jog runs, or a stop fades out.
    pub moves: bool,
    /// The board is about to start over: no command that leads to a motion is taken any more.
    pub restarting: bool,
    /// The robot sends telegrams: the last one is at most three cycles old. What else is said of
    /// the robot is as of the last telegram.
    pub connected: bool,
    /// Counters of the robot's link.
    pub link: LinkCounters,
    /// The robot's last telegram that led to a cycle.
    pub telegram: Option<LastTelegram>,
    /// State of the sensor's driver.
    pub sensor: Option<SensorState>,
    /// Counters of the sensor's driver.
    pub sensor_counters: SensorCounters,
    /// The newest sample.
    pub sample: Option<LastSample>,
    /// Times that the CAN controller went bus-off.
    pub bus_offs: u32,
    /// Times that the CAN controller lost frames.
    pub can_losses: u32,
}

/// A change of state that is reported at once.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Change {
    /// The robot sends telegrams, or has fallen silent.
    Connected(bool),
    /// Another mode.
    Mode(Mode),
    /// A fault was latched.
    Fault(Fault),
    /// A command was refused.
    Refusal(Command, Refusal),
    /// Another state of the sensor's driver.
    Sensor(SensorState),
}

impl Status {
    /// The changes since `last`.
    pub fn changes_since(&self, last: &Self) -> impl Iterator<Item = Change> + use<> {
        let fault = self.fault.filter(|_| self.fault != last.fault);
        let refusal = self.refusal.filter(|_| self.refusal != last.refusal);
        let sensor = self.sensor.filter(|_| self.sensor != last.sensor);
        let changes = [
            (self.connected != last.connected).then_some(Change::Connected(self.connected)),
            (self.mode != last.mode).then_some(Change::Mode(self.mode)),
            fault.map(Change::Fault),
            refusal.map(|(command, refusal)| Change::Refusal(command, refusal)),
            sensor.map(Change::Sensor),
        ];
        changes.into_iter().flatten()
    }
}

/// State of the board itself, see [`softdock_link::service::Machine`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MachineState {
    /// Cause of the last reset.
    pub reset: &'static str,
    /// The stack of a microcontroller.
    pub stack: Option<StackUse>,
    /// The Ethernet of a microcontroller.
    pub ethernet: Option<EthernetHealth>,
    /// Times from a telegram to its answer.
    pub answers: AnswerTimes,
    /// Statistics of the inputs.
    pub inputs: InputStatistics,
    /// Cycles of the processor for an answer.
    pub work: Option<Work>,
}

impl MachineState {
    /// In the types of service and telemetry.
    pub fn to_machine(&self) -> Machine {
        Machine {
            reset: Word::try_from(self.reset).unwrap_or_default(),
            stack: self.stack,
            ethernet: self.ethernet,
            answers: self.answers,
            inputs: self.inputs,
            work: self.work,
        }
    }
}

/// Whether each LED is lit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Leds {
    /// The mode.
    pub green: bool,
    /// The links.
    pub yellow: bool,
    /// Faults.
    pub red: bool,
}

impl From<[bool; 3]> for Leds {
    /// Green, yellow, red.
    fn from([green, yellow, red]: [bool; 3]) -> Self {
        Self { green, yellow, red }
    }
}

/// The shared state.
pub struct Shared<M: RawMutex> {
    sample: Mutex<M, Cell<SensorSample>>,
    status: Mutex<M, Cell<Status>>,
    machine: Mutex<M, Cell<MachineState>>,
    /// LEDs that a test has lit, and the end of the test, µs.
    leds: Mutex<M, Cell<Option<(Leds, u64)>>>,
    /// Raised with each new sample.
    pub(crate) fresh: Signal<M, ()>,
    /// Raised when a telegram asks for a sample.
    pub(crate) wanted: Signal<M, ()>,
    /// Raised when the sensor shall start over.
    pub(crate) restart_sensor: Signal<M, ()>,
    /// Raised when the sensor's task shall test its bus.
    pub(crate) bus_test: Signal<M, ()>,
    /// Result of the test.
    pub(crate) bus_tested: Signal<M, Option<LoopBack>>,
    /// The operator's commands; each cycle takes one. A new RSI run drops those that wait: what
    /// was asked for while no robot was there must not move it when it comes.
    pub commands: Channel<M, Command, COMMANDS>,
}

impl<M: RawMutex> Default for Shared<M> {
    fn default() -> Self {
        Self::new()
    }
}

impl<M: RawMutex> Shared<M> {
    /// Nothing measured, nothing commanded.
    pub const fn new() -> Self {
        Self {
            sample: Mutex::new(Cell::new(NO_SAMPLE)),
            status: Mutex::new(Cell::new(BOOT)),
            machine: Mutex::new(Cell::new(NEW_MACHINE)),
            leds: Mutex::new(Cell::new(None)),
            fresh: Signal::new(),
            wanted: Signal::new(),
            restart_sensor: Signal::new(),
            bus_test: Signal::new(),
            bus_tested: Signal::new(),
            commands: Channel::new(),
        }
    }

    /// The newest sample.
    pub fn sample(&self) -> SensorSample {
        self.sample.lock(Cell::get)
    }

    pub(crate) fn publish(&self, sample: SensorSample) {
        self.sample.lock(|cell| cell.set(sample));
        self.fresh.signal(());
    }

    /// Sets or clears that the board is about to restart.
    pub fn set_restarting(&self, restarting: bool) {
        self.update_status(|status| status.restarting = restarting);
    }

    /// The present state.
    pub fn status(&self) -> Status {
        self.status.lock(Cell::get)
    }

    /// State of the board itself.
    pub fn machine(&self) -> MachineState {
        self.machine.lock(Cell::get)
    }

    /// Updates the state of the board itself.
    pub fn update_machine(&self, change: impl FnOnce(&mut MachineState)) {
        self.machine.lock(|cell| {
            let mut machine = cell.get();
            change(&mut machine);
            cell.set(machine);
        });
    }

    /// Lights these LEDs until the given time, µs; `None`: they show the state again.
    pub(crate) fn light(&self, leds: Option<(Leds, u64)>) {
        self.leds.lock(|cell| cell.set(leds));
    }

    /// The LEDs that a test has lit.
    pub(crate) fn leds(&self, now_us: u64) -> Option<Leds> {
        let lit = self.leds.lock(Cell::get);
        lit.filter(|(_, until_us)| now_us < *until_us)
            .map(|(leds, _)| leds)
    }

    pub(crate) fn update_status(&self, change: impl FnOnce(&mut Status)) {
        self.status.lock(|cell| {
            let mut status = cell.get();
            change(&mut status);
            cell.set(status);
        });
    }
}

/// At boot.
const NEW_MACHINE: MachineState = MachineState {
    reset: "",
    stack: None,
    ethernet: None,
    answers: AnswerTimes::NONE,
    inputs: InputStatistics::NONE,
    work: None,
};

/// Before the first sample.
const NO_SAMPLE: SensorSample = SensorSample {
    counter: 0,
    wrench: [0.0; 6],
    counts: [0; 6],
    status: 0,
    saturated: false,
};

/// At boot.
const BOOT: Status = Status {
    mode: Mode::Idle,
    fault: None,
    refusal: None,
    commands: 0,
    moves: false,
    restarting: false,
    connected: false,
    link: LinkCounters {
        cycles: 0,
        duplicates: 0,
        lost: 0,
        malformed: 0,
        foreign: 0,
        overtaken: 0,
        runs: 0,
    },
    telegram: None,
    sensor: None,
    sensor_counters: SensorCounters {
        timeouts: 0,
        retries: 0,
        late: 0,
        unpaired: 0,
        unknown: 0,
        invalid: 0,
    },
    sample: None,
    bus_offs: 0,
    can_losses: 0,
};
