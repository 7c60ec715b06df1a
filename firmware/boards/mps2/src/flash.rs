//! The emulated flash: PSRAM whose content is a file of the host.
#![allow(unsafe_code, reason = "memory that the linker does not know of")]

use crate::chip;
use softdock_app::emulated_flash::{
    BOOT_OPTIONS_BYTES, BOOT_OPTIONS_OFFSET, BootOptions, SETTINGS_OFFSET,
};
use softdock_app::image::{IMAGE_MAX_BYTES, Image, ImageError};

/// Reads the block of settings.
pub(crate) fn settings() -> Result<Image, ImageError> {
    Image::decode(part::<IMAGE_MAX_BYTES>(SETTINGS_OFFSET))
}

/// Reads the boot options.
pub(crate) fn boot_options() -> BootOptions {
    BootOptions::decode(part::<BOOT_OPTIONS_BYTES>(BOOT_OPTIONS_OFFSET))
}

fn part<const LENGTH: usize>(offset: usize) -> &'static [u8; LENGTH] {
    let address = (chip::PSRAM + offset) as *const [u8; LENGTH];
    // SAFETY: the PSRAM is readable memory, the parts above lie in its 16 MiB, and the firmware
    // does not write it.
    unsafe { &*address }
}
