//! What a board's processor can compute within a cycle.

use crate::settings::BoardSettings;
use softdock_control::delay::LawName;

/// The processor of a board.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Processor {
    /// With a floating-point unit for f64: every law fits into a cycle.
    #[default]
    DoublePrecision,
    /// Without one. A law that computes in f64 takes several times a cycle of 4 ms at 100 MHz.
    Integer,
}

/// A law that does not end within the cycle on the board's processor.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "control.delay.law {} is too slow for this board, which has no f64 unit: choose seed or lead",
    .0.name()
)]
pub struct TooSlow(LawName);

impl Processor {
    /// Whether the processor keeps up with settings.
    ///
    /// # Errors
    /// [`TooSlow`]: the law must not be armed on this board.
    pub fn accepts(self, settings: &BoardSettings) -> Result<(), TooSlow> {
        match (self, settings.control.delay.law) {
            (Self::Integer, law) if law.needs_double_precision() => Err(TooSlow(law)),
            _ => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn laws_that_compute_in_f64_need_floating_point() {
        let mut settings = BoardSettings::default();
        for law in LawName::ALL {
            settings.control.delay.law = law;
            assert!(Processor::DoublePrecision.accepts(&settings).is_ok());
            let integer = Processor::Integer.accepts(&settings);
            assert_eq!(integer.is_err(), law.needs_double_precision(), "{law:?}");
        }
    }
}
