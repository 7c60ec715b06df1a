//! Arms and starts without an operator, as soon as robot and sensor are healthy: for test rigs and automated runs (`--start`). It
//! starts only once: after a fault, a stop, or any other command of an operator, a person has to start.

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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_starts_once_and_not_before_the_sensor_reads() {
        let mut auto = AutoStart::new(true);
        assert_eq!(auto.command(Mode::Idle, false), Some(Command::Hold));
        assert_eq!(auto.command(Mode::Hold, false), None);
        for _ in 0..2 {
            assert_eq!(
                auto.command(Mode::Hold, true),
                Some(Command::Arm),
                "refused once"
            );
        }
        assert_eq!(auto.command(Mode::Armed, true), Some(Command::Start));
        assert_eq!(auto.command(Mode::Running, true), None);
        assert_eq!(auto.command(Mode::Idle, true), None, "after a stop");
    }

    #[test]
    fn an_operator_takes_over_for_good() {
        let mut auto = AutoStart::new(true);
        auto.cancel();
        assert_eq!(auto.command(Mode::Idle, true), None);
    }
}
