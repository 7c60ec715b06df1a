//! Fault handlers that do not rely on the stack.
//!
//! After a stack overflow, the processor cannot save registers on the stack either. With the configurable faults enabled, it
//! still enters their handler, with a stack pointer outside of the stack (Armv7-M Architecture Reference Manual, B1.5.13,
//! derived exceptions); with only the hard fault it would lock up. So a handler first sets another stack pointer.
#![allow(unsafe_code, reason = "exception handlers in assembly")]

use cortex_m::peripheral::scb::Exception;
use cortex_m::peripheral::{MPU, SCB};

/// Size of the guard below the stack, as a power of 2: 64 KiB, more than any frame of a function.
const GUARD_LOG2: u32 = 16;
/// Region of the MPU for the guard. If regions overlap, the one with the highest number counts, so this is the last of the
/// eight that every MPU has.
const GUARD_REGION: u32 = 7;

unsafe extern "C" {
    /// Lower end of the stack.
    static _stack_end: u32;
}

/// Enables memory, bus and usage faults, so that they have handlers of their own, and forbids access to the memory below the
/// stack: not every board faults at unused addresses; QEMU's does not.
pub fn arm(scb: &mut SCB, mpu: &mut MPU) {
    scb.enable(Exception::MemoryManagement);
    scb.enable(Exception::BusFault);
    scb.enable(Exception::UsageFault);

    const VALID: u32 = 1 << 4;
    // No access, no execution, size as its logarithm less one, enabled.
    const FORBIDDEN: u32 = 1 << 28 | (GUARD_LOG2 - 1) << 1 | 1;
    // Enabled, with the default map where no region is.
    const ON: u32 = 1 << 2 | 1;
    // An address of 32 bits; aligned to the guard's size, see the documentation of the crate.
    let guard = (&raw const _stack_end) as u32 - (1 << GUARD_LOG2);
    // SAFETY: nothing that is used lies in the guard.
    unsafe {
        mpu.rbar.write(guard | VALID | GUARD_REGION);
        mpu.rasr.write(FORBIDDEN);
        mpu.ctrl.modify(|control| control | ON);
    }
    cortex_m::asm::dsb();
    cortex_m::asm::isb();
}

/// Defines handlers that pass the stack pointer and the address of the faulty instruction (0 if the stack pointer has left
/// the stack) to [`report`]. They set the stack pointer to the upper end of the stack: the
/// content of the stack is not needed any more.
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

/// Keeps a message about the fault and resets.
extern "C" fn report(stack_pointer: u32, instruction: u32) -> ! {
    // SAFETY: reading the fault registers has no side effect, and nobody else runs any more.
    let scb = unsafe { &*SCB::PTR };
    let (cfsr, hfsr) = (scb.cfsr.read(), scb.hfsr.read());
    const MMFAR_IS_VALID: u32 = 1 << 7;
    let address = match cfsr & MMFAR_IS_VALID {
        0 => scb.bfar.read(),
        _ => scb.mmfar.read(),
    };
    match instruction {
        0 => crate::message::keep(format_args!(
            "stack overflow: stack pointer {stack_pointer:#010x}, CFSR {cfsr:#010x}"
        )),
        _ => crate::message::keep(format_args!(
            "fault at {instruction:#010x}: CFSR {cfsr:#010x}, HFSR {hfsr:#010x}, address {address:#010x}"
        )),
    }
    SCB::sys_reset()
}
