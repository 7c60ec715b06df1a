//! The element names that the robot's Ethernet configuration file leaves free.

use core::fmt;

/// A name of an XML element or a `SENTYPE`: an ASCII letter or `_`, then letters, digits, `_` or `-`, at most
/// [`Name::MAX_BYTES`] long. Such a name needs no escaping.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub struct Name {
    bytes: [u8; Name::MAX_BYTES],
    len: u8,
}

/// Why a [`Name`] or a set of [`Tags`] is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum TagError {
    /// Longer than [`Name::MAX_BYTES`], or empty.
    #[error("a name has 1 to {max} characters, this one has {received}")]
    Length {
        /// Bytes received.
        received: usize,
        /// Most bytes allowed.
        max: usize,
    },
    /// A character that a name cannot have.
    #[error(
        "character {at} is not allowed: use letters, digits, '_' and '-', a letter or '_' first"
    )]
    Character {
        /// Offset in the name.
        at: usize,
    },
    /// Two settings share a name, or a name is one of RSI's own.
    #[error("the name '{name}' is already in use")]
    Taken {
        /// The name.
        name: Name,
    },
}

impl Name {
    /// Longest name.
    pub const MAX_BYTES: usize = 24;

    /// Checks `text` and keeps it.
    ///
    /// # Errors
    /// [`TagError::Length`] or [`TagError::Character`].
    pub const fn new(text: &str) -> Result<Self, TagError> {
        let mut name = Self {
            bytes: [0; Self::MAX_BYTES],
            len: text.len() as u8,
        };
        let length = TagError::Length {
            received: text.len(),
            max: Self::MAX_BYTES,
        };
        if text.is_empty() {
            return Err(length);
        }
        match name.bytes.split_at_mut_checked(text.len()) {
            Some((head, _)) => head.copy_from_slice(text.as_bytes()),
            None => return Err(length),
        }
        let mut rest = text.as_bytes();
        while let [byte, tail @ ..] = rest {
            let at = text.len() - rest.len();
            let fits = byte.is_ascii_alphabetic()
                || *byte == b'_'
                || (at > 0 && (byte.is_ascii_digit() || *byte == b'-'));
            if !fits {
                return Err(TagError::Character { at });
            }
            rest = tail;
        }
        Ok(name)
    }

    /// A name that is known when the program is compiled.
    #[expect(
        clippy::panic,
        reason = "evaluated by the compiler, never on the board"
    )]
    const fn known(text: &'static str) -> Self {
        match Self::new(text) {
            Ok(name) => name,
            Err(_) => panic!("not a name"),
        }
    }

    /// The name as text.
    pub fn as_str(&self) -> &str {
        // `new` admits ASCII only, so the conversion cannot fail.
        core::str::from_utf8(self.as_bytes()).unwrap_or_default()
    }

    pub(super) fn as_bytes(&self) -> &[u8] {
        self.bytes.get(..self.len.into()).unwrap_or_default()
    }
}

impl fmt::Display for Name {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.as_str())
    }
}

impl fmt::Debug for Name {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Debug::fmt(self.as_str(), f)
    }
}

/// The names in the telegrams; they must be the same as in the robot's Ethernet configuration file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tags {
    /// `SENTYPE`, the `Type` of every answer; the robot rejects any other.
    pub sentype: Name,
    /// Element with the correction in the attributes X, Y, Z, A, B, C (`TAG="RKorr.X"` ...).
    pub correction: Name,
    /// Element with the stop request (TYPE `BOOL`); `None` if the configuration does not receive one.
    pub stop: Option<Name>,
    /// Element with POSCORR's `Stat` bits; `None` if the configuration does not send them.
    pub poscorr_stat: Option<Name>,
}

impl Default for Tags {
    /// The names in KUKA's example configuration.
    fn default() -> Self {
        const SENTYPE: Name = Name::known("ImFree");
        const CORRECTION: Name = Name::known("RKorr");
        const STOP: Name = Name::known("Stop");
        Self {
            sentype: SENTYPE,
            correction: CORRECTION,
            stop: Some(STOP),
            poscorr_stat: None,
        }
    }
}

impl Tags {
    /// Names that RSI itself gives to elements (`DEF_...` tags, `IPOC`, `Dat`).
    const RESERVED: [&'static str; 11] = [
        "IPOC", "EStr", "Dat", "RIst", "RSol", "AIPos", "ASPos", "EIPos", "ESPos", "Delay", "Tech",
    ];

    /// Checks that no two elements of one telegram share a name.
    ///
    /// # Errors
    /// [`TagError::Taken`] with the name that is in use.
    pub fn validate(&self) -> Result<(), TagError> {
        let elements = [Some(self.correction), self.stop, self.poscorr_stat];
        for name in elements.into_iter().flatten() {
            if Self::RESERVED.contains(&name.as_str()) {
                return Err(TagError::Taken { name });
            }
        }
        // `poscorr_stat` travels in the other direction and cannot clash with the answer's names.
        if self.stop == Some(self.correction) {
            return Err(TagError::Taken {
                name: self.correction,
            });
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_checked() {
        assert_eq!(Name::new("RKorr").unwrap().as_str(), "RKorr");
        assert_eq!(Name::new("_a-9").unwrap().to_string(), "_a-9");
        assert_eq!(
            Name::new(""),
            Err(TagError::Length {
                received: 0,
                max: 24
            })
        );
        assert_eq!(Name::new("9a"), Err(TagError::Character { at: 0 }));
        assert_eq!(Name::new("a<b"), Err(TagError::Character { at: 1 }));
        assert_eq!(Name::new("aé"), Err(TagError::Character { at: 1 }));
        assert!(Name::new(&"x".repeat(Name::MAX_BYTES)).is_ok());
        assert!(Name::new(&"x".repeat(Name::MAX_BYTES + 1)).is_err());
        assert!(Name::new(&"x".repeat(256 + 5)).is_err());
    }

    #[test]
    fn clashing_names_are_refused() {
        assert_eq!(Tags::default().validate(), Ok(()));
        let name = Name::new("RKorr").unwrap();
        let clash = Tags {
            stop: Some(name),
            ..Tags::default()
        };
        assert_eq!(clash.validate(), Err(TagError::Taken { name }));
        let name = Name::new("IPOC").unwrap();
        let reserved = Tags {
            correction: name,
            ..Tags::default()
        };
        assert_eq!(reserved.validate(), Err(TagError::Taken { name }));
    }
}
