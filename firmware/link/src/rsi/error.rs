//! Why a telegram could not be read or written.

use core::fmt;

/// The part of a telegram that an [`RsiError`] is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Field {
    /// `IPOC`, the time stamp that the answer must echo.
    Ipoc,
    /// `RIst`, the actual pose.
    ActualPose,
    /// `RSol`, the setpoint pose.
    SetpointPose,
    /// `Delay D`, the counter of late answers.
    LateAnswers,
    /// The channel with the `Stat` bits of POSCORR.
    PoscorrStat,
    /// The correction, `RKorr` by default.
    Correction,
    /// The stop request, `Stop` by default.
    Stop,
    /// The attribute `Type` of an answer, which must equal `SENTYPE`.
    SenType,
}

/// Why a telegram could not be read or written. Offsets are in bytes from the start of the telegram.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RsiError {
    /// The telegram ends before its root element is closed.
    Truncated {
        /// Bytes received.
        len: usize,
    },
    /// Not well-formed XML, or a part of XML that RSI does not use (DOCTYPE, CDATA).
    Markup {
        /// Where.
        at: usize,
    },
    /// Elements are nested deeper than any RSI telegram.
    TooDeep {
        /// Where.
        at: usize,
        /// Deepest supported nesting.
        max: usize,
    },
    /// The root element is not the expected one, `Rob` or `Sen`.
    WrongRoot {
        /// Where.
        at: usize,
    },
    /// A required element, attribute or text is absent.
    Missing {
        /// Which.
        field: Field,
    },
    /// An element, attribute or text comes twice, so that its value is ambiguous.
    Duplicate {
        /// Which.
        field: Field,
        /// Where the second one is.
        at: usize,
    },
    /// The text is not a finite number, or not one that the field can hold.
    BadValue {
        /// Which.
        field: Field,
        /// Where the text starts.
        at: usize,
    },
    /// A number to be written is not finite or too large.
    NotRepresentable {
        /// Which.
        field: Field,
    },
    /// The telegram does not fit into the output buffer.
    BufferTooSmall {
        /// Size of the buffer.
        available: usize,
    },
}

impl fmt::Display for RsiError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Truncated { len } => write!(f, "telegram is cut off after {len} bytes"),
            Self::Markup { at } => write!(f, "not well-formed XML at byte {at}"),
            Self::TooDeep { at, max } => {
                write!(f, "more than {max} nested elements at byte {at}")
            }
            Self::WrongRoot { at } => write!(f, "unexpected root element at byte {at}"),
            Self::Missing { field } => write!(f, "{field:?} is missing"),
            Self::Duplicate { field, at } => write!(f, "{field:?} comes twice, again at byte {at}"),
            Self::BadValue { field, at } => write!(f, "{field:?} has no valid value at byte {at}"),
            Self::NotRepresentable { field } => {
                write!(f, "{field:?} is not finite or too large to be written")
            }
            Self::BufferTooSmall { available } => {
                write!(f, "telegram does not fit into {available} bytes")
            }
        }
    }
}

impl core::error::Error for RsiError {}
