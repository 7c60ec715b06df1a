//! Puts numbered items in order and counts those that are missing.

use std::collections::BTreeMap;

/// Number of items that may wait for a missing one before that is given up: a quarter of a second of cycles.
const WAITING: usize = 64;

/// Items of one boot, numbered consecutively.
#[derive(Debug)]
pub(super) struct Window<T> {
    /// The number that has to come next; None before the first item.
    next: Option<u64>,
    waiting: BTreeMap<u64, T>,
    lost: u64,
    repeated: u64,
}

impl<T> Default for Window<T> {
    fn default() -> Self {
        Self {
            next: None,
            waiting: BTreeMap::new(),
            lost: 0,
            repeated: 0,
        }
    }
}

impl<T> Window<T> {
    /// Number of items that never came, or only after they had been given up.
    pub(super) fn lost(&self) -> u64 {
        self.lost
    }

    /// Number of items that came twice or too late.
    pub(super) fn repeated(&self) -> u64 {
        self.repeated
    }

    /// Takes an item; [`Self::take`] returns the items in order.
    pub(super) fn push(&mut self, sequence: u32, item: T) {
        // The first number is mapped to a large u64, so that earlier ones do not become negative.
        let next = *self.next.get_or_insert(u64::from(sequence) + (1 << 32));
        let ahead = sequence.wrapping_sub(next as u32).cast_signed();
        let number = next.saturating_add_signed(i64::from(ahead));
        if number < next || self.waiting.contains_key(&number) {
            self.repeated += 1;
            return;
        }
        self.waiting.insert(number, item);
    }

    /// The next item in order. None if it is missing, unless too many wait behind it or `give_up` is set: then it is skipped.
    pub(super) fn take(&mut self, give_up: bool) -> Option<T> {
        let next = self.next?;
        let full = self.waiting.len() > WAITING;
        let first = self.waiting.first_entry()?;
        let number = *first.key();
        if number != next && !full && !give_up {
            return None;
        }
        self.lost += number - next;
        self.next = Some(number + 1);
        Some(first.remove())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn drain(window: &mut Window<u32>, give_up: bool) -> Vec<u32> {
        std::iter::from_fn(|| window.take(give_up)).collect()
    }

    #[test]
    fn the_numbers_wrap() {
        let mut window = Window::default();
        for sequence in [u32::MAX - 1, 0, u32::MAX, 1] {
            window.push(sequence, sequence);
        }
        assert_eq!(drain(&mut window, false), [u32::MAX - 1, u32::MAX, 0, 1]);
        assert_eq!((window.lost(), window.repeated()), (0, 0));
    }

    #[test]
    fn a_missing_item_is_given_up_when_too_many_wait() {
        let mut window = Window::default();
        window.push(7, 7);
        let behind: Vec<u32> = (9..).take(WAITING + 1).collect();
        for sequence in &behind[..WAITING] {
            window.push(*sequence, *sequence);
        }
        assert_eq!(drain(&mut window, false), [7]);
        window.push(behind[WAITING], behind[WAITING]);
        assert_eq!(drain(&mut window, false), behind);
        assert_eq!(window.lost(), 1);
        // Item 8 comes too late.
        window.push(8, 8);
        assert_eq!(drain(&mut window, true), [0; 0]);
        assert_eq!((window.lost(), window.repeated()), (1, 1));
    }

    proptest! {
        /// Items are lost, swapped with near ones and repeated; the others come in order, and
        /// the losses between them are counted.
        #[test]
        fn order_and_losses_are_found_out(
            first: u32,
            fates in prop::collection::vec((0..20_u8, 0..WAITING), 1..300),
        ) {
            let mut sent: Vec<(usize, u32)> = Vec::new();
            let mut kept: Vec<u32> = Vec::new();
            for (number, (fate, later)) in (0..).zip(&fates) {
                let sequence = first.wrapping_add(number);
                // The first one must come first: where a stream begins is not known otherwise.
                let place = number as usize;
                match fate {
                    _ if number == 0 => sent.push((place, sequence)),
                    0 => continue,
                    1 => sent.extend([(place, sequence), (place + later, sequence)]),
                    2 => sent.push((place + later, sequence)),
                    _ => sent.push((place, sequence)),
                }
                kept.push(sequence);
            }
            sent.sort_by_key(|(place, _)| *place);
            let repeated = sent.len() - kept.len();
            let last = kept.last().map_or(0, |last| last.wrapping_sub(first));
            let lost = last as usize + 1 - kept.len();

            let mut window = Window::default();
            let mut received = Vec::new();
            for (_, sequence) in sent {
                window.push(sequence, sequence);
                received.extend(drain(&mut window, false));
            }
            received.extend(drain(&mut window, true));
            prop_assert_eq!(received, kept);
            prop_assert_eq!(window.lost(), lost as u64);
            prop_assert_eq!(window.repeated(), repeated as u64);
        }
    }
}
