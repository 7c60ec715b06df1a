//! A few bytes that are handed over from one start to the next, and a count of the starts.
#![allow(unsafe_code, reason = "a static outside of .bss, see `Store`")]

use core::cell::UnsafeCell;
use core::mem::MaybeUninit;

/// Bytes that are handed over.
pub const RETAINED_BYTES: usize = 16;

/// Memory that start-up code neither clears nor fills.
#[repr(C)]
struct Kept {
    starts: u32,
    bytes: [u8; RETAINED_BYTES],
}

struct Store(UnsafeCell<MaybeUninit<Kept>>);

// SAFETY: there is one core, and the memory is used in critical sections only.
unsafe impl Sync for Store {}

#[unsafe(link_section = ".uninit.SOFTDOCK_RETAINED")]
static STORE: Store = Store(UnsafeCell::new(MaybeUninit::uninit()));

/// Does something with what is there.
fn with<R>(change: impl FnOnce(&mut Kept) -> R) -> R {
    cortex_m::interrupt::free(|_| {
        let kept = STORE.0.get().cast::<Kept>();
        // SAFETY: `kept` is valid and aligned, any bytes are a `Kept`, and nobody else uses it, see
        // `Store`. Volatile, as what is read here was written before the reset.
        unsafe {
            let mut found = kept.read_volatile();
            let result = change(&mut found);
            kept.write_volatile(found);
            result
        }
    })
}

/// Hands bytes over to the next start, if it comes by a reset.
pub(crate) fn retain(bytes: [u8; RETAINED_BYTES]) {
    with(|kept| kept.bytes = bytes);
}

/// Takes what the start before handed over: for once, whatever becomes of it. After power-up it is
/// anything, so it should have a checksum.
pub fn take_retained() -> [u8; RETAINED_BYTES] {
    with(|kept| core::mem::replace(&mut kept.bytes, [0; RETAINED_BYTES]))
}

/// Counts the starts since power-up, from any number on. To be called once per start.
pub fn count_start() -> u32 {
    with(|kept| {
        kept.starts = kept.starts.wrapping_add(1);
        kept.starts
    })
}
