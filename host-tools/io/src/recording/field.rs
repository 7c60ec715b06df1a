//! Fields of the recorded messages, and the ways of going through them.
//!
//! `topics` visits every field of every message once, in the order of the wire. A [`Visitor`] decides what is done with a
//! field: encode it, decode it, describe it, write it as text or read it from text. Schema, encoder, decoder and CSV columns
//! therefore cannot disagree.

use std::convert::Infallible;

/// SI unit of a field.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Unit {
    /// As part of a name: `m_s`; empty for a number without unit.
    pub(super) suffix: &'static str,
    /// As printed: `m/s`.
    pub(super) symbol: &'static str,
}

impl Unit {
    pub(super) const NONE: Self = Self::new("", "1");
    pub(super) const CYCLES: Self = Self::new("cycles", "cycles");
    pub(super) const COUNTS: Self = Self::new("counts", "counts");
    pub(super) const MILLISECOND: Self = Self::new("ms", "ms");
    pub(super) const SECOND: Self = Self::new("s", "s");
    pub(super) const METRE: Self = Self::new("m", "m");
    pub(super) const RADIAN: Self = Self::new("rad", "rad");
    pub(super) const METRE_PER_SECOND: Self = Self::new("m_s", "m/s");
    pub(super) const RADIAN_PER_SECOND: Self = Self::new("rad_s", "rad/s");
    pub(super) const NEWTON: Self = Self::new("n", "N");
    pub(super) const NEWTON_METRE: Self = Self::new("n_m", "N·m");
    pub(super) const NEWTON_SECOND: Self = Self::new("n_s", "N·s");
    pub(super) const NEWTON_METRE_SECOND: Self = Self::new("n_m_s", "N·m·s");
    pub(super) const NEWTON_PER_METRE: Self = Self::new("n_per_m", "N/m");
    pub(super) const NEWTON_SECOND_PER_METRE: Self = Self::new("n_s_per_m", "N·s/m");

    const fn new(suffix: &'static str, symbol: &'static str) -> Self {
        Self { suffix, symbol }
    }
}

/// The components of a field.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Parts {
    /// Names of the components; empty for a single number.
    pub(super) names: &'static [&'static str],
    /// Message type that the schema uses for these components, `package/Type`; None for an array.
    pub(super) message: Option<&'static str>,
    /// Message type of the same components in single precision.
    pub(super) single: Option<&'static str>,
}

impl Parts {
    /// A single number.
    pub(super) const NONE: Self = Self::array(&[]);

    pub(super) const fn array(names: &'static [&'static str]) -> Self {
        let (message, single) = (None, None);
        Self {
            names,
            message,
            single,
        }
    }

    pub(super) const fn message(name: &'static str, names: &'static [&'static str]) -> Self {
        let (message, single) = (Some(name), None);
        Self {
            names,
            message,
            single,
        }
    }

    /// The same components, with a message type for single precision.
    pub(super) const fn or_single(self, name: &'static str) -> Self {
        let single = Some(name);
        Self { single, ..self }
    }
}

/// One field of a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Field {
    /// Name without the unit.
    pub(super) name: &'static str,
    /// Unit of all its numbers.
    pub(super) unit: Unit,
    /// Components, if the field has several.
    pub(super) parts: Parts,
    /// Meaning of the field.
    pub(super) about: &'static str,
}

impl Field {
    /// Name with the unit, as in the schema: `position_m`.
    pub(super) fn wire_name(&self) -> String {
        joined(&[self.name, self.unit.suffix])
    }

    /// Names of the columns under a prefix, one for each number: `motion_position_x_m`.
    pub(super) fn columns(&self, prefix: &str) -> Vec<String> {
        let column = |part: &str| joined(&[prefix, self.name, part, self.unit.suffix]);
        match self.parts.names {
            [] => vec![column("")],
            names => names.iter().map(|part| column(part)).collect(),
        }
    }
}

fn joined(words: &[&str]) -> String {
    let words: Vec<&str> = words.iter().copied().filter(|w| !w.is_empty()).collect();
    words.join("_")
}

/// The words of a choice, in the order of their codes.
pub(super) type Words = &'static [&'static str];

/// An operation on all fields of a message. Each field is passed as a mutable reference, so that one walk serves to read and
/// to write.
pub(super) trait Visitor {
    /// Error of the operation.
    type Error;

    /// A number or an array of numbers; `values` is as long as the field has parts.
    fn numbers<T: Number>(&mut self, field: &Field, values: &mut [T]) -> Result<(), Self::Error>;

    /// One of several words; `code` is its index in `words`.
    fn choice(&mut self, field: &Field, words: Words, code: &mut u8) -> Result<(), Self::Error>;
}

/// A visitor that treats all numbers alike: the components of an array one by one, a word as its code.
pub(super) trait EachNumber {
    fn number<T: Number>(&mut self, value: T);

    /// The components of an array.
    #[inline]
    fn row<T: Number>(&mut self, values: &[T]) {
        values.iter().for_each(|value| self.number(*value));
    }
}

impl<V: EachNumber> Visitor for V {
    type Error = Infallible;

    #[inline(always)] // as for the encoder's rows
    fn numbers<T: Number>(&mut self, _: &Field, values: &mut [T]) -> Result<(), Infallible> {
        self.row(values);
        Ok(())
    }

    fn choice(&mut self, _: &Field, _: Words, code: &mut u8) -> Result<(), Infallible> {
        self.number(*code);
        Ok(())
    }
}

/// A type of number that a message can hold.
pub(super) trait Number: Copy + Default {
    /// Its name in a `ros2msg` schema.
    const ROS_TYPE: &'static str;
    /// The corresponding type in single precision.
    type Single: Number;
    /// Its bytes, least significant first.
    type Bytes: AsRef<[u8]> + for<'a> TryFrom<&'a [u8]>;

    fn to_bytes(self) -> Self::Bytes;
    /// `None` if the bytes are not a valid number.
    fn from_bytes(bytes: Self::Bytes) -> Option<Self>;
    fn to_single(self) -> Self::Single;
    fn from_single(single: Self::Single) -> Self;
    /// The number for a plot; integers beyond 2⁵³ are rounded.
    fn as_f64(self) -> f64;
    /// The shortest text that reads back to the same bits.
    fn text(self) -> String;
    fn parse(text: &str) -> Option<Self>;
}

macro_rules! number {
    ($($type:ty, $ros:literal, $format:literal, $single:ty;)+) => {$(
        impl Number for $type {
            const ROS_TYPE: &'static str = $ros;
            type Single = $single;
            type Bytes = [u8; size_of::<$type>()];

            fn to_bytes(self) -> Self::Bytes {
                self.to_le_bytes()
            }
            fn from_bytes(bytes: Self::Bytes) -> Option<Self> {
                Some(Self::from_le_bytes(bytes))
            }
            fn to_single(self) -> $single {
                self as $single
            }
            fn from_single(single: $single) -> Self {
                single as Self
            }
            fn as_f64(self) -> f64 {
                self as f64
            }
            fn text(self) -> String {
                format!($format, self)
            }
            fn parse(text: &str) -> Option<Self> {
                text.parse().ok()
            }
        }
    )+};
}

// `{:?}` writes very large and very small floating-point numbers with an exponent, `{}` does not.
number! {
    f64, "float64", "{:?}", f32;
    f32, "float32", "{:?}", f32;
    i64, "int64", "{}", i64;
    u64, "uint64", "{}", u64;
    u32, "uint32", "{}", u32;
    i32, "int32", "{}", i32;
    u16, "uint16", "{}", u16;
    i16, "int16", "{}", i16;
    u8, "uint8", "{}", u8;
}

impl Number for bool {
    const ROS_TYPE: &'static str = "bool";
    type Single = Self;
    type Bytes = [u8; 1];

    fn to_bytes(self) -> Self::Bytes {
        [u8::from(self)]
    }
    fn from_bytes(bytes: Self::Bytes) -> Option<Self> {
        match bytes {
            [0] => Some(false),
            [1] => Some(true),
            _ => None,
        }
    }
    fn to_single(self) -> Self {
        self
    }
    fn from_single(single: Self) -> Self {
        single
    }
    fn as_f64(self) -> f64 {
        f64::from(u8::from(self))
    }
    fn text(self) -> String {
        self.to_string()
    }
    fn parse(text: &str) -> Option<Self> {
        text.parse().ok()
    }
}
