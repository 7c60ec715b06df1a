//! Sets of flags. Recordings say what each bit means in the words of its doc comment.

/// Declares a set of flags, each with the number of its bit.
///
/// ```
/// softdock_control::flags! {
/// /// State of a lamp.
/// pub struct Lamp {
///     /// It is lit.
///     0 => LIT,
///     /// It blinks.
///     1 => BLINKS,
/// }
/// }
/// let mut lamp = Lamp::default();
/// lamp.set(Lamp::BLINKS);
/// assert_eq!((lamp, lamp.has(Lamp::LIT)), (Lamp(2), false));
/// assert_eq!(Lamp::MEANING, "State of a lamp. Bit 0: It is lit. Bit 1: It blinks.");
/// ```
#[macro_export]
macro_rules! flags {
    (
        $(#[doc = $about:literal])+
        pub struct $name:ident {
            $($(#[doc = $line:literal])+ $bit:literal => $flag:ident,)+
        }
    ) => {
        $(#[doc = $about])+
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
        #[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
        pub struct $name(pub u16);

        impl $name {
            $($(#[doc = $line])+ pub const $flag: Self = Self(1 << $bit);)+

            /// What each bit means.
            pub const MEANING: &'static str = concat!(
                $($about,)+ $(" Bit ", $bit, ":", $($line),+),+
            )
            .trim_ascii_start();

            /// Adds flags.
            pub fn set(&mut self, flags: Self) {
                self.0 |= flags.0;
            }

            /// These flags less others.
            pub fn without(self, flags: Self) -> Self {
                Self(self.0 & !flags.0)
            }

            /// Whether any of `flags` is set.
            pub fn has(self, flags: Self) -> bool {
                self.0 & flags.0 != 0
            }
        }
    };
}
