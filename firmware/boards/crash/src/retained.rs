//! A few bytes that are handed over to the next start, and a count of the starts.
#![allow(unsafe_code, reason = "a static outside of .bss, see `Memory`")]

use crate::memory::Memory;

/// Bytes that are handed over.
pub const RETAINED_BYTES: usize = 16;
/// Size of the bytes and the count of the starts, in whole words.
const KEPT_BYTES: usize = RETAINED_BYTES + 8;

#[unsafe(link_section = ".retained.SOFTDOCK_RETAINED")]
static MEMORY: Memory<KEPT_BYTES> = Memory::new();

/// Calls `change` with the count of the starts and the bytes, and stores both.
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

/// Takes the bytes that the previous start handed over, and clears them. After power-up they are arbitrary, so they should
/// contain a checksum.
pub fn take_retained() -> [u8; RETAINED_BYTES] {
    with(|_, bytes| core::mem::replace(bytes, [0; RETAINED_BYTES]))
}

/// Counts the starts since power-up; the count begins at an arbitrary number. To be called once per start.
pub fn count_start() -> u32 {
    with(|starts, _| {
        *starts = starts.wrapping_add(1);
        // The lower half is enough to count.
        *starts as u32
    })
}
