//! Drives the whole cycle with telegrams and samples that are healthy unless a test spoils them.

use softdock_app::record::{CycleRecord, Inputs};
use softdock_app::robot_cycle::RobotCycle;
use softdock_control::delay::LawName;
use softdock_control::io::Sequence;
use softdock_control::modes::{Command, Mode};
use softdock_control::scalar::Scalar;
use softdock_control::settings::Settings;

/// A cycle and the inputs that it gets next.
#[derive(Clone, Debug)]
pub struct Driver<S: Scalar> {
    /// The cycle under test.
    pub cycle: RobotCycle<S>,
    /// The next healthy inputs; what a test writes here stays.
    pub inputs: Inputs,
    period_ms: u64,
}

impl<S: Scalar> Driver<S> {
    /// A cycle in Idle and a robot at rest at the origin, before the first telegram.
    ///
    /// # Panics
    /// If the settings are not valid.
    pub fn new(settings: &Settings) -> Self {
        let mut inputs = Inputs::default();
        inputs.robot.pose = Some([0.0; 6]);
        Self {
            cycle: RobotCycle::new(settings).expect("valid settings"),
            inputs,
            period_ms: (settings.robot.cycle_s * 1e3) as u64,
        }
    }

    /// One healthy cycle.
    pub fn step(&mut self) -> CycleRecord {
        self.step_with(|_| {})
    }

    /// One cycle whose inputs are spoiled by `change`, for this cycle only.
    pub fn step_with(&mut self, change: impl FnOnce(&mut Inputs)) -> CycleRecord {
        self.inputs.sensor.counter += 1;
        // A real gauge flickers.
        self.inputs.sensor.counts[5] ^= 1;
        self.step_stale(change)
    }

    /// One cycle without a new sensor sample.
    pub fn step_stale(&mut self, change: impl FnOnce(&mut Inputs)) -> CycleRecord {
        let mut inputs = self.inputs;
        self.inputs.robot.counter += self.period_ms;
        self.inputs.robot.sequence = Sequence::Next;
        change(&mut inputs);
        self.cycle.step(&inputs)
    }

    /// One healthy cycle with a command.
    pub fn command(&mut self, command: Command) -> CycleRecord {
        self.step_with(|inputs| inputs.command = Some(command))
    }

    /// Through Hold and Armed to Running; answers the first running cycle.
    ///
    /// # Panics
    /// If the cycle refuses.
    pub fn start(&mut self) -> CycleRecord {
        self.arm();
        let record = self.command(Command::Start);
        assert_eq!(record.trace.mode, Mode::Running, "{:?}", record.trace);
        record
    }

    /// Through Hold to Armed.
    ///
    /// # Panics
    /// If the cycle refuses.
    pub fn arm(&mut self) {
        self.command(Command::Hold);
        let record = self.command(Command::Arm);
        assert_eq!(record.trace.mode, Mode::Armed, "{:?}", record.trace);
    }
}

/// Settings of a spacecraft that flies at `speed_m_s` along x in front of a fixed one.
pub fn flying(speed_m_s: f64) -> Settings {
    let mut settings = Settings::default();
    settings.body_k.velocity_m_s = [speed_m_s, 0.0, 0.0];
    settings.body_q.fixed = true;
    // The robot of these inputs does not answer the commands.
    settings.delay.law = LawName::None;
    settings
}

/// A driver whose spacecraft flies with its full velocity: the start ramp is over.
pub fn cruising<S: Scalar>(settings: &Settings) -> Driver<S> {
    let mut driver = Driver::new(settings);
    driver.start();
    for _ in 0..settings.start.zero_cycles + settings.start.ramp_cycles {
        driver.step();
    }
    driver
}
