//! Fault handlers that do not trust the stack.
//!
//! When the stack overflows, the processor cannot save registers on it either. With the
//! configurable faults enabled it then enters their handler all the same, with a stack pointer
//! outside of the stack (Armv7-M Architecture Reference Manual, B1.5.13, derived exceptions); with
//! only the hard fault it would lock up. The first thing that a handler does is therefore to take
//! another stack.
#![allow(unsafe_code, reason = "exception handlers in assembly")]

use cortex_m::peripheral::SCB;
use cortex_m::peripheral::scb::Exception;

/// Enables memory, bus and usage faults, so that they have handlers of their own.
pub fn arm(scb: &mut SCB) {
    scb.enable(Exception::MemoryManagement);
    scb.enable(Exception::BusFault);
    scb.enable(Exception::UsageFault);
}

/// Writes handlers that pass the stack pointer and the address of the faulty instruction (0 if the
/// stack pointer has left the stack) to [`report`], which gets the whole stack for itself: nobody
/// comes back to what was on it.
macro_rules! handlers {
    ($($name:ident)*) => {$(
        // SAFETY: cortex-m-rt's vector table names this symbol, for a function of this kind.
        #[unsafe(no_mangle)]
        #[unsafe(naked)]
        #[allow(non_snake_case, reason = "cortex-m-rt's name")]
        unsafe extern "C" fn $name() -> ! {
            core::arch::naked_asm!(
                "mov r0, sp",
                "movs r1, #0",
                "movw r2, #:lower16:_stack_end",
                "movt r2, #:upper16:_stack_end",
                "cmp r0, r2",
                "blo 1f",
                // The saved program counter is the seventh word.
                "ldr r1, [r0, #24]",
                "1:",
                "movw r2, #:lower16:_stack_start",
                "movt r2, #:upper16:_stack_start",
                "mov sp, r2",
                "b {report}",
                report = sym report,
            )
        }
    )*};
}

handlers! { HardFault MemoryManagement BusFault UsageFault }

/// Keeps what is known of the fault and resets.
extern "C" fn report(stack_pointer: u32, instruction: u32) -> ! {
    // SAFETY: reading the fault registers has no side effect, and nobody else runs any more.
    let scb = unsafe { &*SCB::PTR };
    let (cfsr, hfsr, bfar) = (scb.cfsr.read(), scb.hfsr.read(), scb.bfar.read());
    match instruction {
        0 => crate::message::keep(format_args!(
            "stack overflow: stack pointer {stack_pointer:#010x}, CFSR {cfsr:#010x}"
        )),
        _ => crate::message::keep(format_args!(
            "fault at {instruction:#010x}: CFSR {cfsr:#010x}, HFSR {hfsr:#010x}, address {bfar:#010x}"
        )),
    }
    SCB::sys_reset()
}
