//! The state machine of a SubDevice (ETG.1000.6, 6.4).

/// A state, as it stands in the AL registers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum AlState {
    /// Registers alone.
    Init = 1,
    /// Mailbox as well.
    PreOp = 2,
    /// Inputs as well.
    SafeOp = 4,
    /// Outputs as well.
    Op = 8,
}

/// Why a transition was refused (ETG.1000.6, table 11).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Refused {
    Transition = 0x11,
    UnknownState = 0x12,
    MailboxConfiguration = 0x16,
    OutputConfiguration = 0x1D,
    InputConfiguration = 0x1E,
}

/// What a transition depends on.
#[derive(Clone, Copy, Debug)]
pub(super) struct Configured {
    pub(super) mailbox: bool,
    pub(super) outputs: bool,
    pub(super) inputs: bool,
}

impl AlState {
    /// The state with this number.
    pub(super) fn from_number(number: u8) -> Option<Self> {
        [Self::Init, Self::PreOp, Self::SafeOp, Self::Op]
            .into_iter()
            .find(|state| *state as u8 == number)
    }

    /// Whether the SubDevice may go from here to the state with this number.
    pub(super) fn request(self, number: u8, configured: Configured) -> Result<Self, Refused> {
        let wanted = Self::from_number(number).ok_or(Refused::UnknownState)?;
        match (self, wanted) {
            // Every state may go to a lower one, or stay.
            (from, to) if to <= from => Ok(to),
            (Self::Init, Self::PreOp) if !configured.mailbox => Err(Refused::MailboxConfiguration),
            (Self::PreOp, Self::SafeOp) if !configured.outputs => Err(Refused::OutputConfiguration),
            (Self::PreOp, Self::SafeOp) if !configured.inputs => Err(Refused::InputConfiguration),
            (Self::Init, Self::PreOp) | (Self::PreOp, Self::SafeOp) | (Self::SafeOp, Self::Op) => {
                Ok(wanted)
            }
            _ => Err(Refused::Transition),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: Configured = Configured {
        mailbox: true,
        outputs: true,
        inputs: true,
    };

    #[test]
    fn it_goes_up_step_by_step_and_down_at_once() {
        assert_eq!(AlState::Init.request(2, ALL), Ok(AlState::PreOp));
        assert_eq!(AlState::Init.request(8, ALL), Err(Refused::Transition));
        assert_eq!(AlState::PreOp.request(8, ALL), Err(Refused::Transition));
        assert_eq!(AlState::Op.request(1, ALL), Ok(AlState::Init));
        assert_eq!(AlState::Op.request(3, ALL), Err(Refused::UnknownState));
    }

    #[test]
    fn it_goes_up_only_when_configured() {
        let without = |change: fn(&mut Configured)| {
            let mut configured = ALL;
            change(&mut configured);
            configured
        };
        let mailbox = AlState::Init.request(2, without(|c| c.mailbox = false));
        assert_eq!(mailbox, Err(Refused::MailboxConfiguration));
        let outputs = AlState::PreOp.request(4, without(|c| c.outputs = false));
        assert_eq!(outputs, Err(Refused::OutputConfiguration));
        let inputs = AlState::PreOp.request(4, without(|c| c.inputs = false));
        assert_eq!(inputs, Err(Refused::InputConfiguration));
    }
}
