//! Reads settings from their bytes in postcard's format and tracks their names on the way.

use core::ops::Range;
use heapless::String;
use postcard::Error;
use serde::Deserialize;
use serde::de::value::U32Deserializer;
use serde::de::{self, DeserializeOwned, DeserializeSeed, Visitor};
use serde::forward_to_deserialize_any;

/// Longest path, bytes.
const PATH_BYTES: usize = 96;

/// Error for a kind of value that cannot be a setting.
pub(super) const NO_SETTING: Error = Error::WontImplement;

/// Names from the outermost struct to a field, with dots in between.
pub(super) type Path = String<PATH_BYTES>;

/// Width and sign of a whole number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Width {
    U8,
    U16,
    U32,
    U64,
    I8,
    I16,
    I32,
    I64,
}

/// Type of a setting's value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Flag,
    Whole(Width),
    Real,
    /// One of these words.
    Word(&'static [&'static str]),
    Text,
    /// Real numbers, row by row.
    Array {
        rows: u8,
        columns: u8,
    },
}

/// A setting and its place.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Leaf {
    pub(super) path: Path,
    pub(super) kind: Kind,
    /// The bytes of its value.
    pub(super) bytes: Range<usize>,
    /// The struct and its field that declare it.
    pub(super) owner: &'static str,
    pub(super) field: &'static str,
}

/// The setting to be found.
#[derive(Clone, Copy, Debug)]
pub(super) enum Wanted<'a> {
    Index(u16),
    Path(&'a str),
}

/// The wanted setting in the bytes of a `T`, if there is one.
///
/// # Errors
/// The bytes are not those of a `T`, or it holds something that is no setting.
pub(super) fn find<T: DeserializeOwned>(
    bytes: &[u8],
    wanted: Wanted<'_>,
) -> Result<Option<Leaf>, Error> {
    let mut walk = Walk::new(bytes, wanted);
    T::deserialize(&mut walk)?;
    Ok(walk.found)
}

/// Number of settings in a `T`.
///
/// # Errors
/// As [`find`].
pub(super) fn count<T: DeserializeOwned>(bytes: &[u8]) -> Result<u16, Error> {
    let mut walk = Walk::new(bytes, Wanted::Path(""));
    T::deserialize(&mut walk)?;
    Ok(walk.index)
}

struct Walk<'a> {
    bytes: &'a [u8],
    wanted: Wanted<'a>,
    /// Bytes that were read.
    at: usize,
    /// Settings that were read.
    index: u16,
    path: Path,
    owner: &'static str,
    field: &'static str,
    /// Within an array: numbers per row, 0 while unknown.
    array: Option<u8>,
    found: Option<Leaf>,
}

impl<'a> Walk<'a> {
    fn new(bytes: &'a [u8], wanted: Wanted<'a>) -> Self {
        Self {
            bytes,
            wanted,
            at: 0,
            index: 0,
            path: Path::new(),
            owner: "",
            field: "",
            array: None,
            found: None,
        }
    }

    /// Reads a value as postcard does.
    fn take<T: Deserialize<'a>>(&mut self) -> Result<T, Error> {
        let rest = self.bytes.get(self.at..).ok_or(NO_SETTING)?;
        let (value, rest) = postcard::take_from_bytes(rest)?;
        self.at = self.bytes.len() - rest.len();
        Ok(value)
    }

    /// Called at the end of a setting that began at `start`.
    fn leaf(&mut self, kind: Kind, start: usize) {
        let wanted = match self.wanted {
            Wanted::Index(index) => index == self.index,
            Wanted::Path(path) => path == self.path,
        };
        self.index = self.index.saturating_add(1);
        if wanted {
            self.found = Some(Leaf {
                path: self.path.clone(),
                kind,
                bytes: start..self.at,
                owner: self.owner,
                field: self.field,
            });
        }
    }

    /// A value that is a setting by itself.
    fn single<T: Deserialize<'a>>(&mut self, kind: Kind) -> Result<T, Error> {
        // Arrays hold real numbers only.
        if self.array.is_some() {
            return Err(NO_SETTING);
        }
        let start = self.at;
        let value = self.take()?;
        self.leaf(kind, start);
        Ok(value)
    }
}

/// Values that are settings by themselves.
macro_rules! values {
    ($($deserialize:ident $visit:ident($type:ty) $kind:expr,)+) => {
        $(fn $deserialize<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
            visitor.$visit(self.single::<$type>($kind)?)
        })+
    };
}

impl<'de> de::Deserializer<'de> for &mut Walk<'_> {
    type Error = Error;

    values! {
        deserialize_bool visit_bool(bool) Kind::Flag,
        deserialize_i8 visit_i8(i8) Kind::Whole(Width::I8),
        deserialize_i16 visit_i16(i16) Kind::Whole(Width::I16),
        deserialize_i32 visit_i32(i32) Kind::Whole(Width::I32),
        deserialize_i64 visit_i64(i64) Kind::Whole(Width::I64),
        deserialize_u8 visit_u8(u8) Kind::Whole(Width::U8),
        deserialize_u16 visit_u16(u16) Kind::Whole(Width::U16),
        deserialize_u32 visit_u32(u32) Kind::Whole(Width::U32),
        deserialize_u64 visit_u64(u64) Kind::Whole(Width::U64),
        deserialize_str visit_str(&str) Kind::Text,
        deserialize_string visit_str(&str) Kind::Text,
    }

    fn deserialize_any<V: Visitor<'de>>(self, _: V) -> Result<V::Value, Error> {
        Err(NO_SETTING)
    }

    forward_to_deserialize_any! {
        f32 char bytes byte_buf option unit unit_struct seq tuple_struct map identifier ignored_any
    }

    fn deserialize_f64<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        match self.array {
            Some(_) => visitor.visit_f64(self.take()?),
            None => visitor.visit_f64(self.single(Kind::Real)?),
        }
    }

    fn deserialize_newtype_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        visitor: V,
    ) -> Result<V::Value, Error> {
        visitor.visit_newtype_struct(self)
    }

    fn deserialize_tuple<V: Visitor<'de>>(
        self,
        length: usize,
        visitor: V,
    ) -> Result<V::Value, Error> {
        let length = u8::try_from(length).map_err(|_| NO_SETTING)?;
        let elements = |walk| Elements {
            walk,
            names: [].iter(),
            left: length.into(),
        };
        if self.array.is_some() {
            // A row of a matrix.
            self.array = Some(length);
            return visitor.visit_seq(elements(self));
        }
        let start = self.at;
        self.array = Some(0);
        let value = visitor.visit_seq(elements(&mut *self))?;
        let (rows, columns) = match self.array.take() {
            Some(columns) if columns > 0 => (length, columns),
            _ => (1, length),
        };
        self.leaf(Kind::Array { rows, columns }, start);
        Ok(value)
    }

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        name: &'static str,
        fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Error> {
        let outside = core::mem::replace(&mut self.owner, name);
        let value = visitor.visit_seq(Elements {
            names: fields.iter(),
            left: fields.len(),
            walk: &mut *self,
        })?;
        self.owner = outside;
        Ok(value)
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        _: &'static str,
        variants: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Error> {
        let index: u32 = self.single(Kind::Word(variants))?;
        // Variants have no fields.
        visitor.visit_enum(U32Deserializer::new(index))
    }

    fn is_human_readable(&self) -> bool {
        // As postcard, whose bytes are read.
        false
    }
}

/// The fields of a struct, or the elements of an array.
struct Elements<'w, 'a> {
    walk: &'w mut Walk<'a>,
    names: core::slice::Iter<'static, &'static str>,
    left: usize,
}

impl<'de> de::SeqAccess<'de> for Elements<'_, '_> {
    type Error = Error;

    fn next_element_seed<T: DeserializeSeed<'de>>(
        &mut self,
        seed: T,
    ) -> Result<Option<T::Value>, Error> {
        let Some(left) = self.left.checked_sub(1) else {
            return Ok(None);
        };
        self.left = left;
        let Some(name) = self.names.next() else {
            return seed.deserialize(&mut *self.walk).map(Some);
        };
        let outside = self.walk.path.len();
        let dot = match outside {
            0 => "",
            _ => ".",
        };
        let path = &mut self.walk.path;
        path.push_str(dot).map_err(|_| NO_SETTING)?;
        path.push_str(name).map_err(|_| NO_SETTING)?;
        self.walk.field = name;
        let value = seed.deserialize(&mut *self.walk)?;
        self.walk.path.truncate(outside);
        Ok(Some(value))
    }
}
