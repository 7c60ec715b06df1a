//! The two slots of a flash memory.

use super::confirmation::{ERASED, WORD_BYTES, word};
use super::{Block, Trial};
use crate::image::{IMAGE_MAX_BYTES, Image, ImageError, Slot, checksum};
use crate::settings::BoardSettings;
use embedded_storage_async::nor_flash::{NorFlash, NorFlashError, NorFlashErrorKind};

/// Offset of the confirming word in its slot.
const WORD_OFFSET: u32 = IMAGE_MAX_BYTES as u32;

/// Why settings are not written or kept.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum StoreError {
    /// They may not be used, or are not there any more.
    #[error("{0}")]
    Image(ImageError),
    /// The flash reports an error.
    #[error("{0}")]
    Flash(NorFlashErrorKind),
    /// The data read back differ from those written.
    #[error("what was written does not come back")]
    ReadBack,
    /// Other settings are on trial.
    #[error("other settings are on trial")]
    OnTrial,
}

impl From<ImageError> for StoreError {
    fn from(error: ImageError) -> Self {
        Self::Image(error)
    }
}

/// The slots.
#[derive(Debug)]
pub struct Slots<F> {
    flash: F,
}

impl<F: NorFlash> Slots<F> {
    pub(super) fn new(flash: F) -> Self {
        Self { flash }
    }

    fn slot_bytes(&self) -> u32 {
        (self.flash.capacity() / 2) as u32
    }

    fn start(&self, slot: Slot) -> u32 {
        match slot {
            Slot::A => 0,
            Slot::B => self.slot_bytes(),
        }
    }

    /// Reads the start of a slot. Words that cannot be read, because writing them was interrupted, are set to zero, so that their
    /// block is damaged.
    async fn read(&mut self, slot: Slot, block: &mut Block) {
        let mut at = self.start(slot);
        for word in block.chunks_mut(WORD_BYTES) {
            if self.flash.read(at, word).await.is_err() {
                word.fill(0);
            }
            at += WORD_BYTES as u32;
        }
    }

    /// The settings of a slot if they are kept: by the type of their block or by the word after it.
    pub(super) async fn kept(
        &mut self,
        slot: Slot,
        block: &mut Block,
    ) -> Result<Image, ImageError> {
        self.read(slot, block).await;
        let by_itself = Image::decode(block);
        if by_itself != Err(ImageError::Absent) {
            return by_itself;
        }
        let image = Image::decode_on_trial(block)?;
        match self.is_confirmed(slot, &image, block).await {
            true => Ok(image),
            false => Err(ImageError::NotConfirmed),
        }
    }

    async fn is_confirmed(&mut self, slot: Slot, image: &Image, block: &Block) -> bool {
        let Some(checksum) = checksum(block) else {
            return false;
        };
        let mut found = [0; WORD_BYTES];
        let at = self.start(slot) + WORD_OFFSET;
        let read = self.flash.read(at, &mut found).await;
        read.is_ok() && found == word(image.sequence, checksum)
    }

    /// The settings that are on trial, if their block is still whole.
    pub(super) async fn on_trial(
        &mut self,
        trial: &Trial,
        block: &mut Block,
    ) -> Result<Image, ImageError> {
        self.read(trial.slot, block).await;
        let image = Image::decode_on_trial(block)?;
        match checksum(block) == Some(trial.checksum) && image.sequence == trial.sequence {
            true => Ok(image),
            false => Err(ImageError::Absent),
        }
    }

    /// Writes a block on trial and reads it back. Returns its checksum.
    pub(super) async fn write(
        &mut self,
        slot: Slot,
        settings: &BoardSettings,
        sequence: u32,
        block: &mut Block,
    ) -> Result<u32, StoreError> {
        block.fill(ERASED);
        let length = Image::encode_on_trial(sequence, settings, block)?;
        let written = checksum(block).ok_or(ImageError::Payload)?;
        let length = length.next_multiple_of(WORD_BYTES);
        let start = self.start(slot);
        self.flash
            .erase(start, start + self.slot_bytes())
            .await
            .map_err(flash_error)?;
        let bytes = block.get(..length).unwrap_or_default();
        self.flash.write(start, bytes).await.map_err(flash_error)?;
        self.read(slot, block).await;
        let image = Image::decode_on_trial(block)?;
        match checksum(block) == Some(written) && image.settings == *settings {
            true => Ok(written),
            false => Err(StoreError::ReadBack),
        }
    }

    /// Writes the word that keeps a block.
    pub(super) async fn confirm(&mut self, trial: &Trial) -> Result<(), StoreError> {
        let at = self.start(trial.slot) + WORD_OFFSET;
        let word = word(trial.sequence, trial.checksum);
        self.flash.write(at, &word).await.map_err(flash_error)
    }
}

fn flash_error(error: impl NorFlashError) -> StoreError {
    StoreError::Flash(error.kind())
}
