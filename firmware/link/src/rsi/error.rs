//! Why a telegram could not be read or written.

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
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum RsiError {
    /// The telegram ends before its root element is closed.
    #[error("telegram is cut off after {len} bytes")]
    Truncated {
        /// Bytes received.
        len: usize,
    },
    /// Not well-formed XML, or a part of XML that RSI does not use (DOCTYPE, CDATA).
    #[error("not well-formed XML at byte {at}")]
    Markup {
        /// Where.
        at: usize,
    },
    /// Elements are nested deeper than any RSI telegram.
    #[error("more than {max} nested elements at byte {at}")]
    TooDeep {
        /// Where.
        at: usize,
        /// Deepest supported nesting.
        max: usize,
    },
    /// The root element is not the expected one, `Rob` or `Sen`.
    #[error("unexpected root element at byte {at}")]
    WrongRoot {
        /// Where.
        at: usize,
    },
    /// A required element, attribute or text is absent.
    #[error("{field:?} is missing")]
    Missing {
        /// Which.
        field: Field,
    },
    /// An element, attribute or text comes twice, so that its value is ambiguous.
    #[error("{field:?} comes twice, again at byte {at}")]
    Duplicate {
        /// Which.
        field: Field,
        /// Where the second one is.
        at: usize,
    },
    /// The text is not a finite number, or not one that the field can hold.
    #[error("{field:?} has no valid value at byte {at}")]
    BadValue {
        /// Which.
        field: Field,
        /// Where the text starts.
        at: usize,
    },
    /// A number to be written is not finite or too large.
    #[error("{field:?} is not finite or too large to be written")]
    NotRepresentable {
        /// Which.
        field: Field,
    },
    /// The telegram does not fit into the output buffer.
    #[error("telegram does not fit into {available} bytes")]
    BufferTooSmall {
        /// Size of the buffer.
        available: usize,
    },
}
