//! The settings in flash: two slots, of which one is intact at any time.
//!
//! A set of settings is stored in two steps. [`Store::write`] puts it **on trial** into the slot that is not in use and reads it
//! back; the firmware restarts with it. [`Store::confirm`] keeps it by a word after the block. Until then the block counts only
//! for the one start whose [`Trial`] was handed over in memory, which does not survive a loss of power. Without a confirmation,
//! the second start at the latest uses the old set, whatever happens.
//!
//! | offset in a slot | what |
//! |---|---|
//! | 0 | a block of [`crate::image`], by itself ("SDK1") or on trial ("SDT1") |
//! | [`IMAGE_MAX_BYTES`] | the word (`confirmation`) that keeps a block on trial |
//!
//! An interrupted erasure or write cannot be mistaken for a block or its word: both have checksums, and the word contains that of
//! its block.

mod confirmation;
mod slot;
mod trial;
mod word_flash;

pub use confirmation::WORD_BYTES;
pub use slot::{Slots, StoreError};
pub use trial::{TRIAL_BYTES, Trial};
pub use word_flash::{FlashWords, WordFlash};

use crate::image::{IMAGE_MAX_BYTES, Image, ImageError, Slot, newest_of};
use crate::settings::BoardSettings;
use embedded_storage_async::nor_flash::NorFlash;

/// Room for a block.
pub type Block = [u8; IMAGE_MAX_BYTES];

/// Origin of the settings at boot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Origin {
    /// From flash, for good.
    Flash {
        /// Number of the set.
        sequence: u32,
        /// Its place.
        slot: Slot,
    },
    /// From flash, on trial.
    Trial(Trial),
    /// The firmware's defaults, as there are no usable settings.
    Defaults(ImageError),
}

/// The settings to start with.
#[derive(Clone, Debug, PartialEq)]
pub struct Boot {
    /// The settings.
    pub settings: BoardSettings,
    /// Where they came from.
    pub origin: Origin,
}

/// Settings in the two slots of a flash memory.
#[derive(Debug)]
pub struct Store<F> {
    slots: Slots<F>,
}

impl<F: NorFlash> Store<F> {
    /// A store in a memory that is two slots, one behind the other.
    pub fn new(flash: F) -> Self {
        Self {
            slots: Slots::new(flash),
        }
    }

    /// The settings to start with: those on trial if there is one and its block is there, else the
    /// newer kept set, else the defaults.
    pub async fn boot(&mut self, trial: Option<Trial>, block: &mut Block) -> Boot {
        if let Some(trial) = trial
            && let Ok(image) = self.slots.on_trial(&trial, block).await
        {
            return Boot {
                settings: image.settings,
                origin: Origin::Trial(trial),
            };
        }
        match self.newest(block).await {
            Ok((Image { sequence, settings }, slot)) => Boot {
                settings,
                origin: Origin::Flash { sequence, slot },
            },
            Err(error) => Boot {
                settings: BoardSettings::default(),
                origin: Origin::Defaults(error),
            },
        }
    }

    /// The newer of the kept sets; else an error, rather a damage than an absence.
    async fn newest(&mut self, block: &mut Block) -> Result<(Image, Slot), ImageError> {
        let a = self.slots.kept(Slot::A, block).await;
        let b = self.slots.kept(Slot::B, block).await;
        newest_of(a, b)
    }

    /// Puts settings on trial into the slot that is not in use, and reads them back.
    ///
    /// # Errors
    /// The settings may not be used, or the flash cannot be written. The set in use stays.
    pub async fn write(
        &mut self,
        settings: &BoardSettings,
        in_use: &Origin,
        confirm_within_s: u16,
        block: &mut Block,
    ) -> Result<Trial, StoreError> {
        let (slot, sequence) = match in_use {
            Origin::Flash { sequence, slot } => (slot.other(), sequence.wrapping_add(1)),
            Origin::Trial(_) => return Err(StoreError::OnTrial),
            Origin::Defaults(_) => (self.free(block).await, 1),
        };
        let checksum = self.slots.write(slot, settings, sequence, block).await?;
        Ok(Trial {
            slot,
            sequence,
            checksum,
            confirm_within_s,
        })
    }

    /// The slot to write when neither can be used: one without a block or with an unconfirmed one, so that settings of another
    /// firmware are preserved for it.
    async fn free(&mut self, block: &mut Block) -> Slot {
        match self.slots.kept(Slot::A, block).await {
            Err(ImageError::Absent | ImageError::NotConfirmed) => Slot::A,
            _ => Slot::B,
        }
    }

    /// Keeps the settings that are on trial. Returns their new origin.
    ///
    /// # Errors
    /// Their block is not there any more, or the flash cannot be written.
    pub async fn confirm(
        &mut self,
        trial: &Trial,
        block: &mut Block,
    ) -> Result<Origin, StoreError> {
        self.slots.on_trial(trial, block).await?;
        self.slots.confirm(trial).await?;
        self.slots.kept(trial.slot, block).await?;
        Ok(Origin::Flash {
            sequence: trial.sequence,
            slot: trial.slot,
        })
    }

    /// Content of the two slots: the number of the kept set, or why there is none.
    pub async fn slots(&mut self, block: &mut Block) -> [Result<u32, ImageError>; 2] {
        let a = self.slots.kept(Slot::A, block).await;
        let b = self.slots.kept(Slot::B, block).await;
        [a, b].map(|kept| kept.map(|image| image.sequence))
    }

    /// The kept settings before those in use, if they are still there.
    pub async fn previous(&mut self, in_use: &Origin, block: &mut Block) -> Option<BoardSettings> {
        let slot = match in_use {
            Origin::Flash { slot, .. } => slot.other(),
            Origin::Trial(_) | Origin::Defaults(_) => return None,
        };
        let image = self.slots.kept(slot, block).await.ok()?;
        Some(image.settings)
    }
}

#[cfg(test)]
pub(crate) mod tests;
