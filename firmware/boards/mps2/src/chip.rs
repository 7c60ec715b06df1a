//! All differences between the two chips, besides their instruction sets.

use softdock_app::processor::Processor;

/// The number type of the control cycle.
#[cfg(chip = "an500")]
pub(crate) type Number = f64;
/// The number type of the control cycle: fixed point, as there is no floating-point unit.
#[cfg(chip = "an385")]
pub(crate) type Number = softdock_control::scalar::Fixed;

/// The arithmetic with which the processor is fast enough for the control cycle.
pub(crate) const PROCESSOR: Processor = if cfg!(chip = "an500") {
    Processor::DoublePrecision
} else {
    Processor::Integer
};

/// Board and chip, for the log.
#[cfg(chip = "an500")]
pub(crate) const NAME: &str = "QEMU mps2-an500, Cortex-M7, f64";
/// Board and chip, for the log.
#[cfg(chip = "an385")]
pub(crate) const NAME: &str = "QEMU mps2-an385, Cortex-M3, 64-bit fixed point";

/// Registers of the Ethernet controller.
#[cfg(chip = "an500")]
pub(crate) const ETHERNET: usize = 0xA000_0000;
/// Registers of the Ethernet controller.
#[cfg(chip = "an385")]
pub(crate) const ETHERNET: usize = 0x4020_0000;

/// The PSRAM, whose content is a file of the host: the emulated flash.
#[cfg(chip = "an500")]
pub(crate) const PSRAM: usize = 0x6000_0000;
/// The PSRAM, whose content is a file of the host: the emulated flash.
#[cfg(chip = "an385")]
pub(crate) const PSRAM: usize = 0x2100_0000;

// The same on both, from QEMU's hw/arm/mps2.c and Arm's application notes 385 and 500.

/// System clock, and that of timers and counters, Hz.
pub(crate) const CLOCK_HZ: u32 = 25_000_000;
/// CMSDK timer 0.
pub(crate) const TIMER0: usize = 0x4000_0000;
/// CMSDK UARTs 0 to 2.
pub(crate) const UARTS: [usize; 3] = [0x4000_4000, 0x4000_5000, 0x4000_6000];
/// CMSDK watchdog.
pub(crate) const WATCHDOG: usize = 0x4000_8000;
/// The free-running counter of the FPGA's I/O block.
pub(crate) const COUNTER: usize = 0x4002_8018;
