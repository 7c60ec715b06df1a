//! Assembles messages from the parts of a stream, which come in order with gaps.

use softdock_app::telemetry::{Kind, MessagePart};

/// The head of a part, without its payload.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Head {
    kind: Kind,
    part: u8,
    parts: u8,
    /// Number of the message's first datagram.
    first: u32,
}

impl Head {
    fn of(part: &MessagePart<'_>) -> Self {
        Self {
            kind: part.kind,
            part: part.part,
            parts: part.parts,
            first: part.sequence.wrapping_sub(u32::from(part.part)),
        }
    }

    /// The head of the next part of the same message.
    fn next(self) -> Self {
        Self {
            part: self.part.saturating_add(1),
            ..self
        }
    }
}

/// The message that is being assembled.
#[derive(Debug, Default)]
pub(super) struct Assembly {
    /// Head of the part that has to come next; None between two messages.
    expected: Option<Head>,
    bytes: Vec<u8>,
    /// First datagram of the message that was last found to be torn, so that it is counted once.
    torn_first: Option<u32>,
    torn: u64,
}

impl Assembly {
    /// Number of records of which some parts came, but not all.
    pub(super) fn torn(&self) -> u64 {
        self.torn
    }

    /// Takes the next part. Returns the message if this part completes it.
    pub(super) fn push(&mut self, part: &MessagePart<'_>) -> Option<(Kind, Vec<u8>)> {
        let head = Head::of(part);
        if head.part == 0 {
            self.tear();
            self.bytes.clear();
        } else if self.expected != Some(head) {
            self.tear();
            self.count(head);
            return None;
        }
        self.bytes.extend_from_slice(part.payload);
        let next = head.next();
        if next.part < head.parts {
            self.expected = Some(next);
            return None;
        }
        self.expected = None;
        Some((head.kind, std::mem::take(&mut self.bytes)))
    }

    /// Gives up the present message if it is incomplete.
    pub(super) fn tear(&mut self) {
        if let Some(head) = self.expected.take() {
            self.count(head);
        }
    }

    fn count(&mut self, head: Head) {
        if head.kind == Kind::Record && self.torn_first != Some(head.first) {
            self.torn_first = Some(head.first);
            self.torn += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Messages of one to four parts, consecutively numbered; each payload contains the numbers of message and part.
    fn messages(parts: &[u8]) -> Vec<Vec<(Head, [u8; 2])>> {
        let mut first = u32::MAX - 5;
        (0..)
            .zip(parts)
            .map(|(message, parts)| {
                let head = |part| Head {
                    kind: Kind::Record,
                    part,
                    parts: *parts,
                    first,
                };
                let all = (0..*parts)
                    .map(|part| (head(part), [message, part]))
                    .collect();
                first = first.wrapping_add(u32::from(*parts));
                all
            })
            .collect()
    }

    fn push(assembly: &mut Assembly, head: Head, payload: &[u8]) -> Option<(Kind, Vec<u8>)> {
        assembly.push(&MessagePart {
            kind: head.kind,
            part: head.part,
            parts: head.parts,
            boot: 0,
            sequence: head.first.wrapping_add(u32::from(head.part)),
            schema: 0,
            lost: 0,
            payload,
        })
    }

    proptest! {
        /// Whichever parts are missing: complete messages come out, the others are counted.
        #[test]
        fn only_whole_messages_come(
            sent in prop::collection::vec((1..=4_u8, 0..16_u8), 1..60),
        ) {
            let (parts, missing): (Vec<u8>, Vec<u8>) = sent.into_iter().unzip();
            let mut assembly = Assembly::default();
            let (mut whole, mut torn) = (Vec::<Vec<u8>>::new(), 0);
            let mut received = Vec::new();
            for (message, missing) in messages(&parts).into_iter().zip(missing) {
                let there = |head: Head| missing & (1 << head.part) == 0;
                let came = message.iter().filter(|(head, _)| there(*head)).count();
                if came == message.len() {
                    whole.push(message.iter().flat_map(|(_, bytes)| *bytes).collect());
                } else if came > 0 {
                    torn += 1;
                }
                for (head, bytes) in message.into_iter().filter(|(head, _)| there(*head)) {
                    received.extend(push(&mut assembly, head, &bytes).map(|(_, bytes)| bytes));
                }
            }
            assembly.tear();
            prop_assert_eq!(received, whole);
            prop_assert_eq!(assembly.torn(), torn);
        }
    }
}
