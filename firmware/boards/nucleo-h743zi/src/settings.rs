//! Settings in the last two sectors of flash.

use embassy_stm32::Peri;
use embassy_stm32::flash::Flash;
use embassy_stm32::peripherals::FLASH;
use softdock_app::image::{self, IMAGE_MAX_BYTES, Image, ImageError, Slot};

/// Offsets of the two slots from the start of flash: the region SETTINGS of memory.x.
const SLOT_A: u32 = 0x1C_0000;
const SLOT_B: u32 = 0x1E_0000;

/// The newer usable settings and the slot in which they lie, or why there are none.
pub(crate) fn read(flash: Peri<'static, FLASH>) -> Result<(Image, Slot), ImageError> {
    let mut flash = Flash::new_blocking(flash);
    let mut slot = |offset| {
        let mut bytes = [0xff; IMAGE_MAX_BYTES];
        // A slot that cannot be read holds nothing.
        let _ = flash.blocking_read(offset, &mut bytes);
        bytes
    };
    image::newest(&slot(SLOT_A), &slot(SLOT_B))
}
