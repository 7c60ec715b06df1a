//! A few bytes that are handed over from one start to the next, and a count of the starts.
#![allow(unsafe_code, reason = "a static outside of .bss, see `Memory`")]

use crate::memory::Memory;

/// Bytes that are handed over.
pub const RETAINED_BYTES: usize = 16;
/// With the count of the starts, in whole words.
const KEPT_BYTES: usize = RETAINED_BYTES + 8;

#[unsafe(link_section = ".retained.SOFTDOCK_RETAINED")]
static MEMORY: Memory<KEPT_BYTES> = Memory::new();

/// Does something with the count of the starts and the bytes.
fn with<R>(change: impl FnOnce(&mut u64, &mut [u8; RETAINED_BYTES]) -> R) -> R {
    cortex_m::interrupt::free(|_| {
        let mut kept = MEMORY.read();
        let (starts, bytes) = kept.split_at_mut(KEPT_BYTES - RETAINED_BYTES);
        let mut count = starts.try_into().map_or(0, u64::from_ne_bytes);
        let mut handed_over = [0; RETAINED_BYTES];
        handed_over.copy_from_slice(bytes);
        let result = change(&mut count, &mut handed_over);
        starts.copy_from_slice(&count.to_ne_bytes());
        bytes.copy_from_slice(&handed_over);
        MEMORY.write(&kept);
        result
    })
}

/// Hands bytes over to the next start, if it comes by a reset.
pub(crate) fn retain(handed_over: [u8; RETAINED_BYTES]) {
    with(|_, bytes| *bytes = handed_over);
}

/// Takes what the start before handed over: for once, whatever becomes of it. After power-up it is
/// anything, so it should have a checksum.
pub fn take_retained() -> [u8; RETAINED_BYTES] {
    with(|_, bytes| core::mem::replace(bytes, [0; RETAINED_BYTES]))
}

/// Counts the starts since power-up, from any number on. To be called once per start.
pub fn count_start() -> u32 {
    with(|starts, _| {
        *starts = starts.wrapping_add(1);
        // The lower half counts on.
        *starts as u32
    })
}
