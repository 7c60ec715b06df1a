//! The interrupts in use, their vector table and their priorities.
#![allow(unsafe_code, reason = "the vector table")]

use cortex_m::interrupt::InterruptNumber;
use cortex_m::peripheral::NVIC;

/// Length of the vector table.
const INTERRUPTS: usize = 32;

/// Above the executors: handlers that only move bytes and wake tasks.
const DEVICES: u8 = 0x20;
/// Network, sensor and robot.
const CONTROL: u8 = 0x40;
/// Work that may wait for the control cycle.
const BACKGROUND: u8 = 0x80;
/// The service, which formats texts and writes flash.
const SERVICE: u8 = 0xC0;

macro_rules! interrupts {
    ($($(#[$doc:meta])* $name:ident = $number:literal at $priority:ident;)*) => {
        /// An interrupt line (QEMU's hw/arm/mps2.c).
        #[allow(clippy::upper_case_acronyms, reason = "names of the manual")]
        #[allow(non_camel_case_types, reason = "names of the manual")]
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub(crate) enum Interrupt {
            $($(#[$doc])* $name = $number,)*
        }

        unsafe extern "C" {
            fn DefaultHandler();
            $(fn $name();)*
        }

        /// The part of the vector table behind the exceptions.
        // SAFETY: cortex-m-rt places this symbol behind the exceptions.
        #[unsafe(link_section = ".vector_table.interrupts")]
        #[unsafe(no_mangle)]
        static __INTERRUPTS: [unsafe extern "C" fn(); INTERRUPTS] = {
            let mut table: [unsafe extern "C" fn(); INTERRUPTS] = [DefaultHandler; INTERRUPTS];
            $(table[$number] = $name;)*
            table
        };

        /// Gives each line its priority. Call it before any is unmasked.
        pub(crate) fn set_priorities(nvic: &mut NVIC) {
            // SAFETY: no critical section is based on priorities, and nothing is unmasked yet.
            unsafe {
                $(nvic.set_priority(Interrupt::$name, $priority);)*
            }
        }
    };
}

interrupts! {
    /// Sensor: a byte was received.
    UARTRX0 = 0 at DEVICES;
    /// Sensor: a byte was sent.
    UARTTX0 = 1 at DEVICES;
    /// Log: a byte was sent. Low priority: the log may wait.
    UARTTX1 = 3 at BACKGROUND;
    /// Service: a byte was received.
    UARTRX2 = 4 at DEVICES;
    /// Service: a byte was sent.
    UARTTX2 = 5 at BACKGROUND;
    /// The alarm of the time driver.
    TIMER0 = 8 at DEVICES;
    /// A frame was received.
    ETHERNET = 13 at DEVICES;
    /// Not wired: the executor of the service.
    EXECUTOR_SERVICE = 29 at SERVICE;
    /// Not wired: the executor of the control cycle.
    EXECUTOR_CONTROL = 30 at CONTROL;
    /// Not wired: the executor of everything else.
    EXECUTOR_BACKGROUND = 31 at BACKGROUND;
}

// SAFETY: the numbers are those of the lines.
unsafe impl InterruptNumber for Interrupt {
    fn number(self) -> u16 {
        self as u16
    }
}

/// Enables an interrupt.
pub(crate) fn unmask(interrupt: Interrupt) {
    // SAFETY: no critical section masks single lines.
    unsafe { NVIC::unmask(interrupt) }
}
