//! The emulated flash: PSRAM whose content is a file of the host.
#![allow(unsafe_code, reason = "memory that the linker does not know of")]

use crate::chip;
use core::ptr;
use embedded_storage_async::nor_flash::{ErrorType, NorFlash, NorFlashErrorKind, ReadNorFlash};
use softdock_app::emulated_flash::{
    BOOT_OPTIONS_BYTES, BOOT_OPTIONS_OFFSET, BootOptions, SETTINGS_OFFSET, SLOT_BYTES,
};
use softdock_app::store::WORD_BYTES;

/// Erased flash.
const ERASED: u8 = 0xff;

/// Reads the boot options.
pub(crate) fn boot_options() -> BootOptions {
    let mut bytes = [0; BOOT_OPTIONS_BYTES];
    read(BOOT_OPTIONS_OFFSET, &mut bytes);
    BootOptions::decode(&bytes)
}

fn read(offset: usize, bytes: &mut [u8]) {
    for (place, byte) in (chip::PSRAM + offset..).zip(bytes) {
        // SAFETY: the callers stay in the 16 MiB of the PSRAM, which is readable memory.
        *byte = unsafe { ptr::read_volatile(place as *const u8) };
    }
}

fn write(offset: usize, bytes: impl Iterator<Item = u8>) {
    for (place, byte) in (chip::PSRAM + offset..).zip(bytes) {
        // SAFETY: the callers stay in the slots of the settings, and the firmware has no reference
        // into them.
        unsafe { ptr::write_volatile(place as *mut u8, byte) }
    }
}

/// The two slots for settings. There is one of it.
pub(crate) struct Slots(());

impl Slots {
    /// To be called once.
    pub(crate) fn new() -> Self {
        Self(())
    }

    fn check(&self, offset: u32, length: usize) -> Result<usize, NorFlashErrorKind> {
        let offset = offset as usize;
        match offset.saturating_add(length) <= self.capacity() {
            true => Ok(SETTINGS_OFFSET + offset),
            false => Err(NorFlashErrorKind::OutOfBounds),
        }
    }
}

impl ErrorType for Slots {
    type Error = NorFlashErrorKind;
}

impl ReadNorFlash for Slots {
    const READ_SIZE: usize = 1;

    async fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), NorFlashErrorKind> {
        read(self.check(offset, bytes.len())?, bytes);
        Ok(())
    }

    fn capacity(&self) -> usize {
        2 * SLOT_BYTES
    }
}

impl NorFlash for Slots {
    const WRITE_SIZE: usize = WORD_BYTES;
    const ERASE_SIZE: usize = SLOT_BYTES;

    async fn erase(&mut self, from: u32, to: u32) -> Result<(), NorFlashErrorKind> {
        let length = to.saturating_sub(from) as usize;
        let at = self.check(from, length)?;
        write(at, core::iter::repeat_n(ERASED, length));
        Ok(())
    }

    async fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), NorFlashErrorKind> {
        write(self.check(offset, bytes.len())?, bytes.iter().copied());
        Ok(())
    }
}
