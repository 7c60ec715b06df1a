//! The control cycle behind a robot's protocol: takes a report, returns a correction and the record of both. There are no
//! datagrams: this is what a replay recomputes.

use crate::record::{Correction, CycleRecord, Inputs, Output};
use crate::robot_protocol::RobotProtocol;
use crate::rsi::Rsi;
use softdock_control::checked::Checked;
use softdock_control::cost::Probe;
use softdock_control::cycle::Cycle;
use softdock_control::io;
use softdock_control::modes::{Fault, Mode};
use softdock_control::range::SettingsError;
use softdock_control::scalar::Scalar;
use softdock_control::settings::Settings;

/// Control cycle and protocol.
#[derive(Clone, Debug)]
pub struct RobotCycle<S: Scalar, P: RobotProtocol = Rsi> {
    cycle: Cycle<S>,
    protocol: P,
}

impl<S: Scalar> RobotCycle<S, Rsi> {
    /// For a KUKA robot with the default names of elements.
    ///
    /// # Errors
    /// A setting is outside of its range.
    pub fn new(settings: &Settings) -> Result<Self, SettingsError> {
        let protocol = Rsi::unnamed(&settings.robot);
        let checked = Checked::new(settings, &protocol.interface())?;
        Ok(Self::with(checked, protocol))
    }
}

impl<S: Scalar, P: RobotProtocol> RobotCycle<S, P> {
    /// For any robot, with settings that were checked for its protocol.
    #[inline(always)] // as for the cycle itself
    pub fn with(settings: Checked, protocol: P) -> Self {
        Self {
            cycle: Cycle::new(settings),
            protocol,
        }
    }

    /// One cycle.
    pub fn step(&mut self, inputs: &Inputs) -> CycleRecord {
        self.step_counted(inputs, &mut ())
    }

    /// [`Self::step`] that reports the finished phases of the cycle.
    pub fn step_counted(&mut self, inputs: &Inputs, probe: &mut impl Probe) -> CycleRecord {
        let neutral = io::Inputs {
            robot: self.protocol.sample(&inputs.robot),
            sensor: inputs.sensor,
            command: inputs.command,
        };
        let mut record = CycleRecord {
            inputs: *inputs,
            ..CycleRecord::default()
        };
        let trace = &mut record.trace;
        let wanted = self.cycle.step_counted(&neutral, trace, probe);
        record.output = Output {
            correction: self.protocol.correct(&inputs.robot, &wanted),
            stop: wanted.stop,
        };
        record
    }

    /// The control cycle, for observers.
    pub fn cycle(&self) -> &Cycle<S> {
        &self.cycle
    }

    /// The mode of the cycle.
    pub fn mode(&self) -> Mode {
        self.cycle.mode()
    }

    /// The latched fault.
    pub fn fault(&self) -> Option<Fault> {
        self.cycle.fault()
    }

    /// The correction that moves nothing, for telegrams without a cycle.
    pub fn rest(&self) -> Correction {
        self.protocol.rest()
    }

    pub(crate) fn protocol(&self) -> &P {
        &self.protocol
    }

    pub(crate) fn protocol_mut(&mut self) -> &mut P {
        &mut self.protocol
    }
}
