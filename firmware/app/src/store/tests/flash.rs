//! Flash like that of the STM32H7: words of 32 bytes, each written once between two erasures. Power may be lost at any word,
//! which is then partly written or unreadable.

use embedded_storage_async::nor_flash::{ErrorType, NorFlash, NorFlashErrorKind, ReadNorFlash};

pub(crate) const WORD: usize = 32;
pub(crate) const SLOT: usize = 8192;

/// State of a word whose writing or erasing a loss of power has interrupted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Torn {
    /// The old content.
    Old,
    /// The new content.
    New,
    /// Some bytes of each.
    Half,
    /// Unreadable: its check code is wrong.
    Unreadable,
}

pub(crate) const TORN: [Torn; 4] = [Torn::Old, Torn::New, Torn::Half, Torn::Unreadable];

#[derive(Clone, Debug)]
pub(crate) struct Flash {
    /// `None`: it cannot be read.
    words: Vec<Option<[u8; WORD]>>,
    /// Number of words that are still written or erased before the power is lost, and the state of the next one.
    pub(crate) power: Option<(usize, Torn)>,
    /// Number of words that were written or erased.
    pub(crate) done: usize,
    /// A worn cell: a bit of this byte always reads as zero; the memory reports no error.
    pub(crate) worn: Option<usize>,
    /// It reports success, and does nothing.
    pub(crate) deaf: bool,
}

impl Flash {
    pub(crate) fn erased() -> Self {
        Self {
            words: vec![Some([0xff; WORD]); 2 * SLOT / WORD],
            power: None,
            done: 0,
            worn: None,
            deaf: false,
        }
    }

    /// Writes bytes as a launcher or a probe does.
    pub(crate) fn put(&mut self, offset: usize, bytes: &[u8]) {
        for (word, bytes) in self.words[offset / WORD..]
            .iter_mut()
            .zip(bytes.chunks(WORD))
        {
            word.get_or_insert([0xff; WORD])[..bytes.len()].copy_from_slice(bytes);
        }
    }

    pub(crate) fn flip(&mut self, byte: usize) {
        self.words[byte / WORD].as_mut().unwrap()[byte % WORD] ^= 4;
    }

    fn change(&mut self, word: usize, new: [u8; WORD]) -> Result<(), NorFlashErrorKind> {
        let old = self.words[word];
        if let Some((left, torn)) = &mut self.power {
            if *left == 0 {
                self.words[word] = match torn {
                    Torn::Old => old,
                    Torn::New => Some(new),
                    Torn::Half => old.map(|old| {
                        core::array::from_fn(|i| if i % 3 == 0 { new[i] } else { old[i] })
                    }),
                    Torn::Unreadable => None,
                };
                // Nothing more happens without power.
                *torn = Torn::Old;
                return Err(NorFlashErrorKind::Other);
            }
            *left -= 1;
        }
        if !self.deaf {
            self.words[word] = Some(new);
        }
        self.done += 1;
        Ok(())
    }
}

impl ErrorType for &mut Flash {
    type Error = NorFlashErrorKind;
}

impl ReadNorFlash for &mut Flash {
    const READ_SIZE: usize = 1;

    async fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), NorFlashErrorKind> {
        for (i, byte) in bytes.iter_mut().enumerate() {
            let at = offset as usize + i;
            *byte = self.words[at / WORD].ok_or(NorFlashErrorKind::Other)?[at % WORD];
            if self.worn == Some(at) {
                *byte &= !1;
            }
        }
        Ok(())
    }

    fn capacity(&self) -> usize {
        self.words.len() * WORD
    }
}

impl NorFlash for &mut Flash {
    const WRITE_SIZE: usize = WORD;
    const ERASE_SIZE: usize = SLOT;

    async fn erase(&mut self, from: u32, to: u32) -> Result<(), NorFlashErrorKind> {
        assert!((from as usize).is_multiple_of(SLOT) && (to as usize).is_multiple_of(SLOT));
        for word in from as usize / WORD..to as usize / WORD {
            self.change(word, [0xff; WORD])?;
        }
        Ok(())
    }

    async fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), NorFlashErrorKind> {
        assert!((offset as usize).is_multiple_of(WORD) && bytes.len().is_multiple_of(WORD));
        for (i, new) in bytes.chunks_exact(WORD).enumerate() {
            let word = offset as usize / WORD + i;
            // A word that was written or torn has to be erased first.
            if !self.deaf && self.words[word] != Some([0xff; WORD]) {
                return Err(NorFlashErrorKind::Other);
            }
            self.change(word, new.try_into().unwrap())?;
        }
        Ok(())
    }
}
