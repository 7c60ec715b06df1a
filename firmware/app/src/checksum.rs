//! The checksum of everything that this crate writes as bytes.

use crc::{CRC_32_ISO_HDLC, Crc};

/// CRC-32 (ISO-HDLC, that of Ethernet and zip). Up to 91 kbit it finds every error of up to three
/// flipped bits (Koopman, "32-bit cyclic redundancy codes for Internet applications", 2002).
pub(crate) static CHECKSUM: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);
