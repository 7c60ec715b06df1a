//! Numbers the datagrams of a boot and splits messages into them.

use super::datagram::{Kind, MessagePart, PAYLOAD_MAX_BYTES};
use super::message::{Announcement, MESSAGE_MAX_BYTES, MessageError, schema};
use crate::record::CycleRecord;
use softdock_link::service::Machine;

/// All messages of a boot, one after the other.
#[derive(Clone, Debug)]
pub struct Stream {
    boot: u32,
    schema: u32,
    /// Number of the next datagram.
    sequence: u32,
    /// Records that had no room since boot.
    lost: u32,
    /// The present message.
    message: [u8; MESSAGE_MAX_BYTES],
}

impl Stream {
    /// The first message of a boot. `boot` must differ from that of every other boot: a random
    /// number, or a counter in flash together with the chip's number.
    pub fn new(boot: u32) -> Self {
        Self {
            boot,
            schema: schema(),
            sequence: 0,
            lost: 0,
            message: [0; MESSAGE_MAX_BYTES],
        }
    }

    /// Sets the number of records without room since boot, which the recorder gets from the next message on.
    pub fn set_lost(&mut self, lost: u32) {
        self.lost = lost;
    }

    /// The datagrams of a record.
    pub fn record(&mut self, record: &CycleRecord) -> Result<MessageParts<'_>, MessageError> {
        self.message(Kind::Record, record)
    }

    /// The datagrams of the announcement.
    pub fn announcement(
        &mut self,
        announcement: &Announcement<'_>,
    ) -> Result<MessageParts<'_>, MessageError> {
        self.message(Kind::Announcement, announcement)
    }

    /// The datagrams of the state of the board itself.
    pub fn machine(&mut self, machine: &Machine) -> Result<MessageParts<'_>, MessageError> {
        self.message(Kind::Machine, machine)
    }

    fn message(
        &mut self,
        kind: Kind,
        value: &impl serde::Serialize,
    ) -> Result<MessageParts<'_>, MessageError> {
        let message =
            postcard::to_slice(value, &mut self.message).map_err(|_| MessageError::TooLong)?;
        let first = self.sequence;
        let parts = message.len().div_ceil(PAYLOAD_MAX_BYTES);
        let parts = u8::try_from(parts).map_err(|_| MessageError::TooLong)?;
        self.sequence = first.wrapping_add(u32::from(parts));
        Ok(MessageParts {
            next: MessagePart {
                kind,
                part: 0,
                parts,
                boot: self.boot,
                sequence: first,
                schema: self.schema,
                lost: self.lost,
                payload: &[],
            },
            payloads: message.chunks(PAYLOAD_MAX_BYTES),
        })
    }
}

/// The datagrams of a message, in their order.
#[derive(Clone, Debug)]
pub struct MessageParts<'a> {
    /// Header of the next one.
    next: MessagePart<'a>,
    payloads: core::slice::Chunks<'a, u8>,
}

impl<'a> Iterator for MessageParts<'a> {
    type Item = MessagePart<'a>;

    fn next(&mut self) -> Option<MessagePart<'a>> {
        let payload = self.payloads.next()?;
        let part = MessagePart {
            payload,
            ..self.next
        };
        self.next.part = part.part.saturating_add(1);
        self.next.sequence = part.sequence.wrapping_add(1);
        Some(part)
    }
}
