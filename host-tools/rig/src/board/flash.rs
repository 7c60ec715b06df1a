//! The board's flash: a file, or memory that is forgotten.

use anyhow::{Context, Result, ensure};
use embedded_storage_async::nor_flash::{ErrorType, NorFlash, NorFlashErrorKind, ReadNorFlash};
use softdock_app::image::{IMAGE_MAX_BYTES, Image};
use softdock_app::settings::BoardSettings;
use softdock_app::store::WORD_BYTES;
use std::fs::File;
use std::io::{Read, Seek, SeekFrom, Write};
use std::path::Path;

/// Slot of a board that is a process: what is erased at once.
pub const SLOT_BYTES: usize = 2 * IMAGE_MAX_BYTES;
/// Erased flash.
pub(super) const ERASED: u8 = 0xff;

/// Two slots for settings, of so many bytes each.
#[derive(Debug)]
pub struct FileFlash<const SLOT: usize = SLOT_BYTES> {
    bytes: Vec<u8>,
    /// Locked, so that no other board uses it.
    file: Option<File>,
}

impl<const SLOT: usize> FileFlash<SLOT> {
    /// In memory, with given contents.
    pub(super) fn of(bytes: Vec<u8>) -> Self {
        Self { bytes, file: None }
    }

    /// Opens the file, or makes one that is erased; without a path it is memory.
    ///
    /// # Errors
    /// The file cannot be read, is not as long as a flash, or is in use.
    pub fn open(path: Option<&Path>) -> Result<Self> {
        let mut bytes = vec![ERASED; 2 * SLOT];
        let Some(path) = path else {
            return Ok(Self { bytes, file: None });
        };
        let what = || format!("the flash {}", path.display());
        let mut file = File::options()
            .read(true)
            .write(true)
            .create(true)
            .truncate(false)
            .open(path)
            .with_context(what)?;
        ensure!(
            file.try_lock().is_ok(),
            "{} is in use by another board",
            path.display()
        );
        let mut found = Vec::new();
        file.read_to_end(&mut found).with_context(what)?;
        ensure!(
            found.is_empty() || found.len() == 2 * SLOT,
            "{} has {} bytes; the flash of a board has {}: choose another file",
            path.display(),
            found.len(),
            2 * SLOT
        );
        match found.is_empty() {
            true => file.write_all(&bytes).with_context(what)?,
            false => bytes = found,
        }
        let file = Some(file);
        Ok(Self { bytes, file })
    }

    /// Writes settings as valid ones if the flash is entirely erased. Returns whether it was.
    ///
    /// # Errors
    /// The settings may not be used, or the file cannot be written.
    pub fn put_if_empty(&mut self, settings: BoardSettings) -> Result<bool> {
        if self.bytes.iter().any(|byte| *byte != ERASED) {
            return Ok(false);
        }
        let mut block = [ERASED; IMAGE_MAX_BYTES];
        let sequence = 1;
        Image { sequence, settings }.encode(&mut block)?;
        self.change(0, &block).context("the board's flash")?;
        Ok(true)
    }

    fn change(&mut self, offset: usize, new: &[u8]) -> std::io::Result<()> {
        let place = self.bytes.get_mut(offset..offset + new.len());
        let place = place.ok_or(std::io::ErrorKind::InvalidInput)?;
        place.copy_from_slice(new);
        if let Some(file) = &mut self.file {
            file.seek(SeekFrom::Start(offset as u64))?;
            file.write_all(new)?;
            file.sync_data()?;
        }
        Ok(())
    }
}

impl<const SLOT: usize> ErrorType for FileFlash<SLOT> {
    type Error = NorFlashErrorKind;
}

impl<const SLOT: usize> ReadNorFlash for FileFlash<SLOT> {
    const READ_SIZE: usize = 1;

    async fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), NorFlashErrorKind> {
        let offset = offset as usize;
        let found = self.bytes.get(offset..offset + bytes.len());
        bytes.copy_from_slice(found.ok_or(NorFlashErrorKind::OutOfBounds)?);
        Ok(())
    }

    fn capacity(&self) -> usize {
        2 * SLOT
    }
}

impl<const SLOT: usize> NorFlash for FileFlash<SLOT> {
    const WRITE_SIZE: usize = WORD_BYTES;
    const ERASE_SIZE: usize = SLOT;

    async fn erase(&mut self, from: u32, to: u32) -> Result<(), NorFlashErrorKind> {
        let length = (to - from) as usize;
        self.change(from as usize, &vec![ERASED; length])
            .map_err(|_| NorFlashErrorKind::Other)
    }

    async fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), NorFlashErrorKind> {
        self.change(offset as usize, bytes)
            .map_err(|_| NorFlashErrorKind::Other)
    }
}
