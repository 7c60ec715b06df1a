//! A number that changes when the form of the settings does: the CRC-32 of the names and types of
//! all fields in their order.
//!
//! The form is found by writing the default settings with a serializer that notes names and types
//! in place of values, so no list of fields has to be kept beside the settings themselves.

use super::CHECKSUM;
use crate::settings::BoardSettings;
use core::fmt::Display;
use crc::Digest;
use serde::Serialize;
use serde::ser::{self, Impossible};

/// The schema of [`BoardSettings`].
pub fn schema() -> u32 {
    let mut form = Form(CHECKSUM.digest());
    // Nothing in the settings is of a kind that the serializer below refuses; were it, the schema
    // would change with it, which is the safe side.
    let _ = BoardSettings::default().serialize(&mut form);
    form.0.finalize()
}

/// Collects names and types.
struct Form(Digest<'static, u32>);

impl Form {
    fn note(&mut self, word: &str) -> Result<(), NotSettings> {
        self.0.update(word.as_bytes());
        self.0.update(&[0]);
        Ok(())
    }
}

/// A kind of value that settings do not have.
#[derive(Debug)]
struct NotSettings;

impl Display for NotSettings {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "a kind of value that settings do not have")
    }
}

impl core::error::Error for NotSettings {}

impl ser::Error for NotSettings {
    fn custom<T: Display>(_: T) -> Self {
        Self
    }
}

/// Numbers and texts: the type is the form.
macro_rules! values {
    ($($method:ident($type:ty)),* $(,)?) => {
        $(fn $method(self, _: $type) -> Result<(), NotSettings> {
            self.note(stringify!($type))
        })*
    };
}

impl<'a> ser::Serializer for &'a mut Form {
    type Ok = ();
    type Error = NotSettings;
    type SerializeSeq = &'a mut Form;
    type SerializeTuple = &'a mut Form;
    type SerializeStruct = &'a mut Form;
    type SerializeTupleStruct = Impossible<(), NotSettings>;
    type SerializeTupleVariant = Impossible<(), NotSettings>;
    type SerializeMap = Impossible<(), NotSettings>;
    type SerializeStructVariant = Impossible<(), NotSettings>;

    values! {
        serialize_bool(bool),
        serialize_i8(i8),
        serialize_i16(i16),
        serialize_i32(i32),
        serialize_i64(i64),
        serialize_u8(u8),
        serialize_u16(u16),
        serialize_u32(u32),
        serialize_u64(u64),
        serialize_f32(f32),
        serialize_f64(f64),
        serialize_char(char),
        serialize_str(&str),
        serialize_bytes(&[u8]),
    }

    fn serialize_none(self) -> Result<(), NotSettings> {
        self.note("none")
    }

    fn serialize_some<T: Serialize + ?Sized>(self, value: &T) -> Result<(), NotSettings> {
        self.note("some")?;
        value.serialize(self)
    }

    fn serialize_unit(self) -> Result<(), NotSettings> {
        self.note("unit")
    }

    fn serialize_unit_struct(self, name: &'static str) -> Result<(), NotSettings> {
        self.note(name)
    }

    fn serialize_unit_variant(
        self,
        name: &'static str,
        _: u32,
        variant: &'static str,
    ) -> Result<(), NotSettings> {
        self.note(name)?;
        self.note(variant)
    }

    fn serialize_newtype_struct<T: Serialize + ?Sized>(
        self,
        name: &'static str,
        value: &T,
    ) -> Result<(), NotSettings> {
        self.note(name)?;
        value.serialize(self)
    }

    fn serialize_newtype_variant<T: Serialize + ?Sized>(
        self,
        name: &'static str,
        _: u32,
        variant: &'static str,
        value: &T,
    ) -> Result<(), NotSettings> {
        self.note(name)?;
        self.note(variant)?;
        value.serialize(self)
    }

    fn serialize_seq(self, _: Option<usize>) -> Result<Self, NotSettings> {
        self.note("sequence")?;
        Ok(self)
    }

    fn serialize_tuple(self, _: usize) -> Result<Self, NotSettings> {
        self.note("array")?;
        Ok(self)
    }

    fn serialize_struct(self, name: &'static str, _: usize) -> Result<Self, NotSettings> {
        self.note(name)?;
        Ok(self)
    }

    fn serialize_tuple_struct(
        self,
        _: &'static str,
        _: usize,
    ) -> Result<Self::SerializeTupleStruct, NotSettings> {
        Err(NotSettings)
    }

    fn serialize_tuple_variant(
        self,
        _: &'static str,
        _: u32,
        _: &'static str,
        _: usize,
    ) -> Result<Self::SerializeTupleVariant, NotSettings> {
        Err(NotSettings)
    }

    fn serialize_map(self, _: Option<usize>) -> Result<Self::SerializeMap, NotSettings> {
        Err(NotSettings)
    }

    fn serialize_struct_variant(
        self,
        _: &'static str,
        _: u32,
        _: &'static str,
        _: usize,
    ) -> Result<Self::SerializeStructVariant, NotSettings> {
        Err(NotSettings)
    }

    fn collect_str<T: Display + ?Sized>(self, _: &T) -> Result<(), NotSettings> {
        self.note("text")
    }

    fn is_human_readable(&self) -> bool {
        // As postcard, whose bytes this form describes.
        false
    }
}

impl ser::SerializeSeq for &mut Form {
    type Ok = ();
    type Error = NotSettings;

    fn serialize_element<T: Serialize + ?Sized>(&mut self, value: &T) -> Result<(), NotSettings> {
        value.serialize(&mut **self)
    }

    fn end(self) -> Result<(), NotSettings> {
        self.note("end")
    }
}

impl ser::SerializeTuple for &mut Form {
    type Ok = ();
    type Error = NotSettings;

    fn serialize_element<T: Serialize + ?Sized>(&mut self, value: &T) -> Result<(), NotSettings> {
        value.serialize(&mut **self)
    }

    fn end(self) -> Result<(), NotSettings> {
        self.note("end")
    }
}

impl ser::SerializeStruct for &mut Form {
    type Ok = ();
    type Error = NotSettings;

    fn serialize_field<T: Serialize + ?Sized>(
        &mut self,
        name: &'static str,
        value: &T,
    ) -> Result<(), NotSettings> {
        self.note(name)?;
        value.serialize(&mut **self)
    }

    fn end(self) -> Result<(), NotSettings> {
        self.note("end")
    }
}
