//! The emulated flash: PSRAM whose content is a file on the host.
#![allow(unsafe_code, reason = "memory that the linker does not know of")]

use crate::chip;
use core::ptr;
use embedded_storage_async::nor_flash::NorFlashErrorKind;
use softdock_app::emulated_flash::{
    BOOT_OPTIONS_BYTES, BOOT_OPTIONS_OFFSET, BootOptions, SETTINGS_OFFSET, SLOT_BYTES,
};
use softdock_app::store::{FlashWords, WORD_BYTES};

/// Value of an erased byte.
const ERASED: u8 = 0xff;

/// Reads the boot options.
pub(crate) fn boot_options() -> BootOptions {
    let mut bytes = [0; BOOT_OPTIONS_BYTES];
    read(BOOT_OPTIONS_OFFSET, &mut bytes);
    BootOptions::decode(&bytes)
}

fn read(offset: usize, bytes: &mut [u8]) {
    for (address, byte) in (chip::PSRAM + offset..).zip(bytes) {
        // SAFETY: the callers stay in the 16 MiB of the PSRAM, which is readable memory.
        *byte = unsafe { ptr::read_volatile(address as *const u8) };
    }
}

fn write(offset: usize, bytes: impl Iterator<Item = u8>) {
    for (address, byte) in (chip::PSRAM + offset..).zip(bytes) {
        // SAFETY: the callers stay in the slots of the settings, and the firmware has no reference
        // into them.
        unsafe { ptr::write_volatile(address as *mut u8, byte) }
    }
}

/// The two slots for settings. There is one instance.
pub(crate) struct Psram(());

impl Psram {
    /// To be called once.
    pub(crate) fn new() -> Self {
        Self(())
    }
}

impl FlashWords for Psram {
    const SLOT_BYTES: usize = SLOT_BYTES;

    fn read_word(&mut self, offset: usize) -> Result<[u8; WORD_BYTES], NorFlashErrorKind> {
        let mut word = [0; WORD_BYTES];
        read(SETTINGS_OFFSET + offset, &mut word);
        Ok(word)
    }

    async fn write_word(
        &mut self,
        offset: usize,
        word: &[u8; WORD_BYTES],
    ) -> Result<(), NorFlashErrorKind> {
        write(SETTINGS_OFFSET + offset, word.iter().copied());
        Ok(())
    }

    async fn erase_slot(&mut self, offset: usize) -> Result<(), NorFlashErrorKind> {
        let erased = core::iter::repeat_n(ERASED, SLOT_BYTES);
        write(SETTINGS_OFFSET + offset, erased);
        Ok(())
    }
}
