//! Memory whose content survives a reset, written in whole words of its error correction.
//!
//! The AXI SRAM of the STM32H7 corrects words of 64 bits. The last write, and every write of less than such a word, stays in
//! a register in front of the memory until another word is accessed, and is lost if a reset comes first (AN5342, error
//! correction code management; ST's FAQ "SRAM content is not preserved after reset"). So this module writes whole words, and
//! then one more word.

/// Memory of this kind.
pub(crate) trait Words {
    /// Stores a whole word, at once.
    fn store(&mut self, index: usize, value: u64);
    /// Waits until all stores have left the processor.
    fn barrier(&mut self);
}

/// Writes words from the first on, and then one more word, which is never read.
pub(crate) fn keep(memory: &mut impl Words, words: impl IntoIterator<Item = u64>) {
    let mut behind = 0;
    for word in words {
        memory.store(behind, word);
        behind += 1;
    }
    memory.barrier();
    memory.store(behind, 0);
    memory.barrier();
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Debug, PartialEq)]
    enum Done {
        Store(usize, u64),
        Barrier,
    }

    #[derive(Default)]
    struct Noted(Vec<Done>);

    impl Words for Noted {
        fn store(&mut self, index: usize, value: u64) {
            self.0.push(Done::Store(index, value));
        }

        fn barrier(&mut self) {
            self.0.push(Done::Barrier);
        }
    }

    /// The type of a store already makes it a whole word.
    #[test]
    fn whole_words_then_a_barrier_then_another_word_then_a_barrier() {
        let mut memory = Noted::default();
        keep(&mut memory, [7, 8, u64::MAX]);
        assert_eq!(
            memory.0,
            [
                Done::Store(0, 7),
                Done::Store(1, 8),
                Done::Store(2, u64::MAX),
                Done::Barrier,
                Done::Store(3, 0),
                Done::Barrier,
            ]
        );
    }
}
