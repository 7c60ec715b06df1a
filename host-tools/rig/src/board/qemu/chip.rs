//! The machines that are emulated.

use crate::firmware::BoardImage;
use clap::ValueEnum;

/// A chip on Arm's MPS2 board.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Chip {
    /// Cortex-M7 with a double-precision FPU, as the real board's; the cycle runs in f64
    #[default]
    An500,
    /// Cortex-M3 without FPU; the cycle runs in 64-bit fixed point
    An385,
}

impl Chip {
    /// QEMU's name of the machine.
    pub fn machine(self) -> &'static str {
        match self {
            Self::An500 => "mps2-an500",
            Self::An385 => "mps2-an385",
        }
    }

    /// Rust's name of the target.
    pub fn target(self) -> &'static str {
        match self {
            Self::An500 => "thumbv7em-none-eabihf",
            Self::An385 => "thumbv7m-none-eabi",
        }
    }

    /// Its firmware, for a sensor on CAN or on EtherCAT.
    pub(super) fn image(self, ethercat: bool) -> BoardImage {
        BoardImage {
            package: "softdock-mps2",
            target: self.target(),
            features: if ethercat { &["ethercat"] } else { &[] },
        }
    }
}
