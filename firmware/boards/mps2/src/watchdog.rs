//! The watchdog of the CMSDK (Arm DDI 0479, APB watchdog). It runs only while the firmware hangs deliberately: emulated time
//! goes on while the host is busy with other work, and a running watchdog would reset the board.
#![allow(unsafe_code, reason = "addresses of registers")]

use crate::chip;
use crate::register::Register;
use softdock_app::watchdog::RESET_AFTER_US;

const LOAD: Register = register(0x00);
const CONTROL: Register = register(0x08);
const LOCK: Register = register(0xC00);

const fn register(offset: usize) -> Register {
    // SAFETY: the offsets above are those of the device's registers.
    unsafe { Register::at(chip::WATCHDOG + offset) }
}

/// Hangs, until the watchdog resets the board.
pub(crate) fn hang() -> ! {
    const KEY: u32 = 0x1ACC_E551;
    /// Counts, and resets the board after the second count to zero.
    const RESETS: u32 = 0b11;
    LOCK.write(KEY);
    LOAD.write(chip::CLOCK_HZ / 1_000_000 * RESET_AFTER_US / 2);
    CONTROL.write(RESETS);
    softdock_crash::hang()
}
