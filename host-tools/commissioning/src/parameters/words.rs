//! Values that a board reports by their names in the firmware, in words.

use serde::de::value::Error;
use serde::de::{DeserializeOwned, IntoDeserializer};
use std::fmt::Display;

/// The value with this name; None if only a newer firmware has it, or the name was cut off.
pub(super) fn named<T: DeserializeOwned>(name: &str) -> Option<T> {
    let name = IntoDeserializer::<Error>::into_deserializer(name);
    T::deserialize(name).ok()
}

/// Its words; the name itself if it is not known here.
pub fn words<T: DeserializeOwned + Display>(name: &str) -> String {
    named::<T>(name).map_or_else(|| name.to_owned(), |value| value.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;
    use softdock_control::modes::{FaultCode, Refusal};

    #[test]
    fn a_name_that_is_known_is_told_in_words() {
        let refusal = words::<Refusal>("WrongMode");
        assert_eq!(refusal, "it does not apply in this mode");
        assert_eq!(
            words::<FaultCode>("TelegramsLost"),
            "telegrams lost in a row"
        );
        assert_eq!(words::<Refusal>("Newer"), "Newer");
    }
}
