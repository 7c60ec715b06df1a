//! Flash memory that is read and written in words, as the two slots of a store.

use super::WORD_BYTES;
use embedded_storage_async::nor_flash::{ErrorType, NorFlash, NorFlashErrorKind, ReadNorFlash};

/// Access to a board's memory for the two slots. Offsets are in bytes from the first slot on, and stay within the slots.
#[allow(
    async_fn_in_trait,
    reason = "one executor, one thread: no Send is needed"
)]
pub trait FlashWords {
    /// Size of a slot, bytes; the unit of erasure.
    const SLOT_BYTES: usize;

    /// Reads a word.
    ///
    /// # Errors
    /// Its check code is wrong, as after an interrupted write.
    fn read_word(&mut self, offset: usize) -> Result<[u8; WORD_BYTES], NorFlashErrorKind>;

    /// Writes a word, once between two erasures.
    ///
    /// # Errors
    /// The memory says that it was not written.
    async fn write_word(
        &mut self,
        offset: usize,
        word: &[u8; WORD_BYTES],
    ) -> Result<(), NorFlashErrorKind>;

    /// Erases the slot that begins at `offset`.
    ///
    /// # Errors
    /// The memory says that it was not erased.
    async fn erase_slot(&mut self, offset: usize) -> Result<(), NorFlashErrorKind>;
}

/// Two slots of such words, with every access checked.
#[derive(Debug)]
pub struct WordFlash<W>(W);

impl<W: FlashWords> WordFlash<W> {
    /// The slots in a memory.
    pub fn new(words: W) -> Self {
        Self(words)
    }

    /// Offsets of the units of `size` bytes that an access of `length` bytes covers.
    fn units(
        &self,
        offset: u32,
        length: usize,
        size: usize,
    ) -> Result<impl Iterator<Item = usize> + use<W>, NorFlashErrorKind> {
        let start = offset as usize;
        match start.checked_add(length) {
            _ if !start.is_multiple_of(size) => Err(NorFlashErrorKind::NotAligned),
            Some(end) if end <= self.capacity() => Ok((start..end).step_by(size)),
            _ => Err(NorFlashErrorKind::OutOfBounds),
        }
    }
}

impl<W> ErrorType for WordFlash<W> {
    type Error = NorFlashErrorKind;
}

impl<W: FlashWords> ReadNorFlash for WordFlash<W> {
    const READ_SIZE: usize = WORD_BYTES;

    async fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), NorFlashErrorKind> {
        let words = self.units(offset, bytes.len(), WORD_BYTES)?;
        for (at, bytes) in words.zip(bytes.chunks_mut(WORD_BYTES)) {
            let word = self.0.read_word(at)?;
            for (byte, value) in bytes.iter_mut().zip(word) {
                *byte = value;
            }
        }
        Ok(())
    }

    fn capacity(&self) -> usize {
        2 * W::SLOT_BYTES
    }
}

impl<W: FlashWords> NorFlash for WordFlash<W> {
    const WRITE_SIZE: usize = WORD_BYTES;
    const ERASE_SIZE: usize = W::SLOT_BYTES;

    async fn erase(&mut self, from: u32, to: u32) -> Result<(), NorFlashErrorKind> {
        let length = to.saturating_sub(from) as usize;
        for slot in self.units(from, length, W::SLOT_BYTES)? {
            self.0.erase_slot(slot).await?;
        }
        Ok(())
    }

    async fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), NorFlashErrorKind> {
        let words = self.units(offset, bytes.len(), WORD_BYTES)?;
        for (at, word) in words.zip(bytes.as_chunks::<WORD_BYTES>().0) {
            self.0.write_word(at, word).await?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use embassy_futures::block_on;

    const SLOT: usize = 4 * WORD_BYTES;

    struct Memory([u8; 2 * SLOT]);

    impl FlashWords for Memory {
        const SLOT_BYTES: usize = SLOT;

        fn read_word(&mut self, offset: usize) -> Result<[u8; WORD_BYTES], NorFlashErrorKind> {
            Ok(self.0[offset..offset + WORD_BYTES].try_into().unwrap())
        }

        async fn write_word(
            &mut self,
            offset: usize,
            word: &[u8; WORD_BYTES],
        ) -> Result<(), NorFlashErrorKind> {
            self.0[offset..offset + WORD_BYTES].copy_from_slice(word);
            Ok(())
        }

        async fn erase_slot(&mut self, offset: usize) -> Result<(), NorFlashErrorKind> {
            self.0[offset..offset + SLOT].fill(0xff);
            Ok(())
        }
    }

    #[test]
    fn words_and_slots_go_where_they_belong_and_nowhere_else() {
        let mut flash = WordFlash::new(Memory([0; 2 * SLOT]));
        let slot = SLOT as u32;
        block_on(flash.erase(slot, 2 * slot)).unwrap();
        assert!(flash.0.0[..SLOT].iter().all(|byte| *byte == 0));
        assert!(flash.0.0[SLOT..].iter().all(|byte| *byte == 0xff));
        block_on(flash.write(slot + 32, &[7; 2 * WORD_BYTES])).unwrap();
        let mut found = [0; WORD_BYTES + 1];
        block_on(flash.read(slot + 64, &mut found)).unwrap();
        assert_eq!(found[..WORD_BYTES], [7; WORD_BYTES]);
        assert_eq!(found[WORD_BYTES], 0xff);
    }

    #[test]
    fn what_lies_outside_of_the_slots_is_refused() {
        let mut flash = WordFlash::new(Memory([0; 2 * SLOT]));
        let end = 2 * SLOT as u32;
        let outside = Err(NorFlashErrorKind::OutOfBounds);
        assert_eq!(block_on(flash.read(end - 32, &mut [0; 33])), outside);
        assert_eq!(block_on(flash.write(end, &[0; WORD_BYTES])), outside);
        assert_eq!(block_on(flash.erase(0, end + 1)), outside);
        let unaligned = Err(NorFlashErrorKind::NotAligned);
        assert_eq!(block_on(flash.write(1, &[0; WORD_BYTES])), unaligned);
    }
}
