//! CAN 2.0 frames.

use core::fmt;

/// Identifier of a frame; the smaller one has priority on the bus.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Id {
    /// 11 bit (CAN 2.0A).
    Standard(u16),
    /// 29 bit (CAN 2.0B).
    Extended(u32),
}

impl Id {
    /// Largest standard identifier.
    pub const MAX_STANDARD: u16 = 0x7FF;
    /// Largest extended identifier.
    pub const MAX_EXTENDED: u32 = 0x1FFF_FFFF;

    fn is_valid(self) -> bool {
        match self {
            Self::Standard(id) => id <= Self::MAX_STANDARD,
            Self::Extended(id) => id <= Self::MAX_EXTENDED,
        }
    }
}

/// A valid data or remote frame of at most eight bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Frame {
    id: Id,
    /// Bytes beyond `len`, and all bytes of a remote frame, are zero, so that equality compares the frames.
    data: [u8; Frame::MAX_BYTES],
    len: u8,
    remote: bool,
}

/// Why there is no such frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FrameError {
    /// The identifier has more than 11 or 29 bits.
    Id {
        /// The identifier.
        id: Id,
    },
    /// More than eight data bytes.
    Length {
        /// Bytes asked for.
        received: usize,
        /// [`Frame::MAX_BYTES`].
        max: usize,
    },
}

impl fmt::Display for FrameError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Id {
                id: Id::Standard(id),
            } => write!(f, "identifier {id:#x} has more than 11 bits"),
            Self::Id {
                id: Id::Extended(id),
            } => write!(f, "identifier {id:#x} has more than 29 bits"),
            Self::Length { received, max } => {
                write!(
                    f,
                    "a frame carries at most {max} bytes, {received} were given"
                )
            }
        }
    }
}

impl core::error::Error for FrameError {}

impl Frame {
    /// Most data bytes of a CAN 2.0 frame.
    pub const MAX_BYTES: usize = 8;

    /// A data frame.
    ///
    /// # Errors
    /// [`FrameError::Id`] or [`FrameError::Length`].
    pub fn new(id: Id, data: &[u8]) -> Result<Self, FrameError> {
        let mut frame = Self::new_remote(id, data.len())?;
        frame.remote = false;
        for (slot, byte) in frame.data.iter_mut().zip(data) {
            *slot = *byte;
        }
        Ok(frame)
    }

    /// A remote frame, which asks for `dlc` bytes and carries none.
    ///
    /// # Errors
    /// [`FrameError::Id`] or [`FrameError::Length`].
    pub fn new_remote(id: Id, dlc: usize) -> Result<Self, FrameError> {
        if !id.is_valid() {
            return Err(FrameError::Id { id });
        }
        let too_long = FrameError::Length {
            received: dlc,
            max: Self::MAX_BYTES,
        };
        let len = u8::try_from(dlc).map_err(|_| too_long)?;
        if dlc > Self::MAX_BYTES {
            return Err(too_long);
        }
        Ok(Self {
            id,
            data: [0; Self::MAX_BYTES],
            len,
            remote: true,
        })
    }

    /// Identifier.
    pub fn id(&self) -> Id {
        self.id
    }

    /// Data bytes; empty for a remote frame.
    pub fn data(&self) -> &[u8] {
        let len = if self.remote { 0 } else { self.len };
        self.data.get(..len.into()).unwrap_or_default()
    }

    /// Data length code, 0 to 8; for a remote frame the number of bytes asked for.
    pub fn dlc(&self) -> usize {
        self.len.into()
    }

    /// Whether this is a remote frame.
    pub fn is_remote(&self) -> bool {
        self.remote
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn validates_identifier_and_length() {
        for id in [Id::Standard(0x800), Id::Extended(0x2000_0000)] {
            assert_eq!(Frame::new(id, &[]), Err(FrameError::Id { id }));
        }
        assert!(Frame::new(Id::Standard(0x7FF), &[0; 8]).is_ok());
        assert!(Frame::new(Id::Extended(0x1FFF_FFFF), &[]).is_ok());
        for received in [9, 256, 300] {
            let error = FrameError::Length { received, max: 8 };
            assert_eq!(
                Frame::new(Id::Standard(1), &[0; 300][..received]),
                Err(error)
            );
            assert_eq!(Frame::new_remote(Id::Standard(1), received), Err(error));
        }
    }

    #[test]
    fn remote_frames_carry_a_length_and_no_data() {
        let frame = Frame::new_remote(Id::Standard(1), 3).unwrap();
        assert_eq!(
            (frame.dlc(), frame.data(), frame.is_remote()),
            (3, &[][..], true)
        );
        let frame = Frame::new(Id::Standard(1), &[1, 2, 3]).unwrap();
        assert_eq!(
            (frame.dlc(), frame.data(), frame.is_remote()),
            (3, &[1, 2, 3][..], false)
        );
    }
}
