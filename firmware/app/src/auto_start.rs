//! Arms and starts without an operator, as soon as robot and sensor are healthy: for test rigs
//! and automated runs (`--start`). It starts once: after a fault, a stop, or any other command of
//! an operator, it is a person who starts.

use softdock_control::modes::{Command, Mode};

/// The commands still to be given.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct AutoStart {
    wanted: bool,
}

impl AutoStart {
    /// Starts if `wanted`.
    pub fn new(wanted: bool) -> Self {
        Self { wanted }
    }

    /// An operator has taken over.
    pub fn cancel(&mut self) {
        self.wanted = false;
    }

    /// The command for the next cycle. Before the first reading of the sensor (`sensed`) nothing is armed; a refused
    /// command is given again in the next cycle.
    pub fn command(&mut self, mode: Mode, sensed: bool) -> Option<Command> {
        if !self.wanted {
            return None;
        }
        match mode {
            Mode::Idle => Some(Command::Hold),
            Mode::Hold => sensed.then_some(Command::Arm),
            Mode::Armed => Some(Command::Start),
            Mode::Running | Mode::Jogging | Mode::Fault => {
                self.wanted = false;
                None
            }
        }
    }
}
