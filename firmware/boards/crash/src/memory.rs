//! Memory that the start-up code neither clears nor fills.

use crate::words::{Words, keep};
use core::cell::UnsafeCell;
use core::mem::MaybeUninit;

/// Bytes of a word.
const WORD: usize = 8;

/// `BYTES` of memory that the start-up code neither clears nor fills, followed by one more word; `BYTES` is a multiple of 8.
#[repr(C)]
pub(crate) struct Memory<const BYTES: usize> {
    bytes: UnsafeCell<MaybeUninit<[u8; BYTES]>>,
    behind: UnsafeCell<MaybeUninit<u64>>,
    /// Aligns the bytes to whole words.
    aligned: [u64; 0],
}

// SAFETY: there is one core, and the memory is used in critical sections and fault handlers only.
#[allow(unsafe_code, reason = "memory that several contexts use")]
unsafe impl<const BYTES: usize> Sync for Memory<BYTES> {}

#[allow(
    unsafe_code,
    reason = "volatile: what is read was written before the reset"
)]
impl<const BYTES: usize> Memory<BYTES> {
    /// Memory with an undefined content: arbitrary, or that before the reset.
    pub(crate) const fn new() -> Self {
        const { assert!(BYTES.is_multiple_of(WORD)) }
        Self {
            bytes: UnsafeCell::new(MaybeUninit::uninit()),
            behind: UnsafeCell::new(MaybeUninit::uninit()),
            aligned: [],
        }
    }

    /// The content. To be called where nothing else runs, as [`Self::write`].
    pub(crate) fn read(&self) -> [u8; BYTES] {
        // SAFETY: the place is valid and aligned, any bytes are bytes, and nobody else writes.
        unsafe { self.bytes.get().cast::<[u8; BYTES]>().read_volatile() }
    }

    /// Writes all bytes, in a way that survives even an immediate reset.
    pub(crate) fn write(&self, bytes: &[u8; BYTES]) {
        let words = bytes.as_chunks().0.iter();
        keep(
            &mut Stores(self),
            words.map(|word| u64::from_ne_bytes(*word)),
        );
    }
}

/// Stores that the compiler neither splits nor reorders.
struct Stores<'a, const BYTES: usize>(&'a Memory<BYTES>);

#[allow(unsafe_code, reason = "volatile stores of whole words")]
impl<const BYTES: usize> Words for Stores<'_, BYTES> {
    fn store(&mut self, index: usize, value: u64) {
        let word = match index * WORD < BYTES {
            // SAFETY: the index is inside of the bytes.
            true => unsafe { self.0.bytes.get().cast::<u64>().add(index) },
            false => self.0.behind.get().cast(),
        };
        // SAFETY: the place is valid, aligned by `Memory::aligned`, and nobody else uses it.
        unsafe { word.write_volatile(value) }
    }

    fn barrier(&mut self) {
        cortex_m::asm::dsb();
    }
}
