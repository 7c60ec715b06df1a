//! Crashes on demand, to test in QEMU what the next start reports about them.

use core::hint::black_box;
use softdock_app::emulated_flash::Crash;

/// Crashes in the given way.
#[allow(clippy::panic, reason = "it is what was asked for")]
pub(crate) fn crash(kind: Crash) -> ! {
    match kind {
        Crash::Panic => panic!("a panic was asked for"),
        Crash::StackOverflow => {
            deeper(0);
            panic!("the stack has no end")
        }
        Crash::Fault => cortex_m::asm::udf(),
    }
}

/// Calls itself until the stack is exhausted.
#[inline(never)]
fn deeper(depth: u32) -> u32 {
    let frame = black_box([depth; 64]);
    let below = match black_box(true) {
        true => deeper(depth.wrapping_add(1)),
        false => 0,
    };
    // Used after the call, so that the compiler does not turn the call into a jump.
    frame.iter().fold(below, |sum, n| sum.wrapping_add(*n))
}
