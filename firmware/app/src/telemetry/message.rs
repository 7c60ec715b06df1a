//! Content of the messages, in postcard's format.

use super::datagram::PAYLOAD_MAX_BYTES;
use crate::record::CycleRecord;
use softdock_link::service::Machine;

/// Longest message, bytes: four datagrams. A record takes about 1.2 kB, the announcement what its
/// settings take (at most [`IMAGE_MAX_BYTES`](crate::image::IMAGE_MAX_BYTES)) and its text.
pub const MESSAGE_MAX_BYTES: usize = 4 * PAYLOAD_MAX_BYTES;

/// The schema of the records: it changes when the form of [`CycleRecord`] does.
pub fn schema() -> u32 {
    crate::schema::of::<CycleRecord>().unwrap_or_default()
}

/// Identity and settings of the sender: enough to replay the records.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct Announcement<'a> {
    /// The settings as a block ([`Image`](crate::image::Image)).
    pub image: &'a [u8],
    /// Name, version and git state of the firmware.
    pub identity: &'a str,
}

/// Why bytes are not a message, or a value cannot be one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum MessageError {
    /// It is longer than [`MESSAGE_MAX_BYTES`].
    #[error("a message takes at most {MESSAGE_MAX_BYTES} bytes")]
    TooLong,
    /// The bytes end too early or hold something else.
    #[error("what should be a message cannot be read")]
    Payload,
    /// Bytes are left over.
    #[error("a message is followed by {received} bytes too many")]
    Trailing {
        /// Their number.
        received: usize,
    },
}

/// Reads a record that has [`schema()`].
pub fn read_record(message: &[u8]) -> Result<CycleRecord, MessageError> {
    read(message)
}

/// Reads the state of the board itself.
pub fn read_machine(message: &[u8]) -> Result<Machine, MessageError> {
    read(message)
}

impl<'a> Announcement<'a> {
    /// Reads an announcement. Its settings are still encoded, so that the identity of a firmware with other settings can be read
    /// nevertheless.
    pub fn read(message: &'a [u8]) -> Result<Self, MessageError> {
        read(message)
    }
}

fn read<'a, T: serde::Deserialize<'a>>(message: &'a [u8]) -> Result<T, MessageError> {
    match postcard::take_from_bytes(message) {
        Ok((value, [])) => Ok(value),
        Ok((_, rest)) => Err(MessageError::Trailing {
            received: rest.len(),
        }),
        Err(_) => Err(MessageError::Payload),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A recorder of another version refuses the records if this changes, and says so.
    #[test]
    fn the_schema_changes_only_with_the_record() {
        assert_eq!(schema(), SCHEMA_OF_THIS_VERSION, "{:#010x}", schema());
    }

    /// See [`the_schema_changes_only_with_the_record`].
    const SCHEMA_OF_THIS_VERSION: u32 = 0x47f1_48c7;
}
