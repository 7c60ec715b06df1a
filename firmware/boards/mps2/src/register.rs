//! Memory-mapped registers.
#![allow(
    unsafe_code,
    reason = "registers are memory that the compiler does not know of"
)]

/// A register of 32 bits.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Register(usize);

impl Register {
    /// The register at an address.
    ///
    /// # Safety
    /// It is a register of a device of the board, and aligned.
    pub(crate) const unsafe fn at(address: usize) -> Self {
        Self(address)
    }

    /// Reads the register.
    pub(crate) fn read(self) -> u32 {
        // SAFETY: the address is that of a register, see `at`.
        unsafe { (self.0 as *const u32).read_volatile() }
    }

    /// Writes the register.
    pub(crate) fn write(self, value: u32) {
        // SAFETY: the address is that of a register, see `at`.
        unsafe { (self.0 as *mut u32).write_volatile(value) }
    }
}
