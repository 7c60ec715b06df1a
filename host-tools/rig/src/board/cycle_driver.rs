//! The control cycle alone, without tasks and bytes: it gets telegrams and samples that are healthy
//! unless somebody spoils them. Benchmarks, `check` and the tests close their loops around it.

use softdock_app::record::{Correction, CycleRecord, Inputs};
use softdock_app::robot_cycle::RobotCycle;
use softdock_control::io::Sequence;
use softdock_control::modes::{Command, Fault, Mode};
use softdock_control::range::SettingsError;
use softdock_control::scalar::Scalar;
use softdock_control::settings::Settings;
use thiserror::Error;

/// A cycle and its next inputs.
#[derive(Clone, Debug)]
pub struct CycleDriver<S: Scalar> {
    /// The cycle.
    pub cycle: RobotCycle<S>,
    /// The next healthy inputs; changes made here persist.
    pub inputs: Inputs,
    cycle_s: f64,
    /// Value of the last digit of a correction, m and rad.
    digit: [f64; 2],
}

/// The board did not enter the commanded mode.
#[derive(Clone, Copy, Debug, Error)]
#[error("the board does not go into {wanted:?}, it is in {found:?} ({fault:?})")]
pub struct Refused {
    wanted: Mode,
    found: Mode,
    fault: Option<Fault>,
}

impl<S: Scalar> CycleDriver<S> {
    /// A cycle in Idle and a robot at rest at the origin, before the first telegram.
    ///
    /// # Errors
    /// The settings are not valid.
    pub fn new(settings: &Settings) -> Result<Self, SettingsError> {
        let mut inputs = Inputs::default();
        inputs.robot.pose = Some([0.0; 6]);
        let digit = 0.1_f64.powi(settings.robot.correction_decimals.into());
        Ok(Self {
            cycle: RobotCycle::new(settings)?,
            inputs,
            cycle_s: settings.robot.cycle_s,
            digit: [digit * 1e-3, digit.to_radians()],
        })
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
        self.inputs.robot.counter += (self.cycle_s * 1e3).round() as u64;
        self.inputs.robot.sequence = Sequence::Next;
        change(&mut inputs);
        self.cycle.step(&inputs)
    }

    /// One healthy cycle with a command.
    pub fn command(&mut self, command: Command) -> CycleRecord {
        self.step_with(|inputs| inputs.command = Some(command))
    }

    /// Goes through Hold to Armed. Returns the first armed cycle.
    ///
    /// # Errors
    /// The cycle refuses.
    pub fn arm(&mut self) -> Result<CycleRecord, Refused> {
        self.command(Command::Hold);
        let record = self.command(Command::Arm);
        in_mode(Mode::Armed, record)
    }

    /// Goes through Hold and Armed to Running. Returns the first running cycle.
    ///
    /// # Errors
    /// The cycle refuses.
    pub fn start(&mut self) -> Result<CycleRecord, Refused> {
        self.arm()?;
        let record = self.command(Command::Start);
        in_mode(Mode::Running, record)
    }

    /// Length of a cycle, s.
    pub fn cycle_s(&self) -> f64 {
        self.cycle_s
    }

    /// Velocity of X Y Z A B C that a relative correction asks of the robot, m/s and rad/s.
    pub fn velocity(&self, correction: &Correction) -> [f64; 6] {
        std::array::from_fn(|i| correction[i] as f64 * self.digit[i / 3] / self.cycle_s)
    }
}

fn in_mode(wanted: Mode, record: CycleRecord) -> Result<CycleRecord, Refused> {
    let found = record.trace.mode;
    let fault = record.trace.fault;
    if found == wanted {
        Ok(record)
    } else {
        Err(Refused {
            wanted,
            found,
            fault,
        })
    }
}
