//! A number that changes when the form of a type does: the CRC-32 of the names and types of all its fields, in order.
//!
//! Postcard's bytes are not self-describing, so reader and writer must agree on the form. It is found by deserializing the type
//! from a source that records each request and returns zeros; no list of fields has to be kept beside the type. Enumerations
//! request the names of all their variants. The type is read as often as the longest enumeration has variants, each time with the
//! next variant, so that the content of each is recorded too.

use crate::checksum::CHECKSUM;
use crc::Digest;
use postcard::Error;
use serde::de::value::U32Deserializer;
use serde::de::{self, DeserializeOwned, DeserializeSeed, Visitor};
use serde::forward_to_deserialize_any;

/// The schema of a type, or an error if it holds something that cannot be walked. Tests assert that those in use do not.
pub(crate) fn of<T: DeserializeOwned>() -> Result<u32, Error> {
    let mut form = Form {
        digest: CHECKSUM.digest(),
        variant: 0,
        variants: 1,
    };
    while form.variant < form.variants {
        T::deserialize(&mut form)?;
        form.variant += 1;
    }
    Ok(form.digest.finalize())
}

/// Notes names and types.
struct Form {
    digest: Digest<'static, u32>,
    /// The variant that enumerations return; those with fewer return their last.
    variant: u32,
    /// Variants of the longest enumeration so far.
    variants: u32,
}

impl Form {
    fn note(&mut self, word: &str) {
        self.digest.update(word.as_bytes());
        self.digest.update(&[0]);
    }

    /// Walks through the elements of a value; `names` is empty where they have none.
    fn elements<'de, V: Visitor<'de>>(
        &mut self,
        names: &'static [&'static str],
        length: usize,
        visitor: V,
    ) -> Result<V::Value, Error> {
        let value = visitor.visit_seq(Elements {
            form: self,
            names: names.iter(),
            left: length,
        })?;
        self.note("end");
        Ok(value)
    }
}

/// Numbers and texts: the type is the form.
macro_rules! values {
    ($($deserialize:ident $visit:ident($type:ty) $value:expr,)+) => {
        $(fn $deserialize<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
            self.note(stringify!($type));
            visitor.$visit($value)
        })+
    };
}

impl<'de> de::Deserializer<'de> for &mut Form {
    type Error = Error;

    values! {
        deserialize_bool visit_bool(bool) false,
        deserialize_i8 visit_i8(i8) 0,
        deserialize_i16 visit_i16(i16) 0,
        deserialize_i32 visit_i32(i32) 0,
        deserialize_i64 visit_i64(i64) 0,
        deserialize_u8 visit_u8(u8) 0,
        deserialize_u16 visit_u16(u16) 0,
        deserialize_u32 visit_u32(u32) 0,
        deserialize_u64 visit_u64(u64) 0,
        deserialize_f32 visit_f32(f32) 0.0,
        deserialize_f64 visit_f64(f64) 0.0,
        deserialize_char visit_char(char) '0',
        deserialize_str visit_str(str) "",
        deserialize_string visit_str(str) "",
        deserialize_bytes visit_bytes(bytes) &[],
        deserialize_byte_buf visit_bytes(bytes) &[],
    }

    /// A self-describing value has no form of its own.
    fn deserialize_any<V: Visitor<'de>>(self, _: V) -> Result<V::Value, Error> {
        Err(Error::WontImplement)
    }

    forward_to_deserialize_any! { map identifier ignored_any }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        self.note("option");
        visitor.visit_some(self)
    }

    fn deserialize_unit<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        self.note("unit");
        visitor.visit_unit()
    }

    fn deserialize_unit_struct<V: Visitor<'de>>(
        self,
        name: &'static str,
        visitor: V,
    ) -> Result<V::Value, Error> {
        self.note(name);
        visitor.visit_unit()
    }

    fn deserialize_newtype_struct<V: Visitor<'de>>(
        self,
        name: &'static str,
        visitor: V,
    ) -> Result<V::Value, Error> {
        self.note(name);
        visitor.visit_newtype_struct(self)
    }

    fn deserialize_seq<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        self.note("sequence");
        // One element shows the form of all.
        self.elements(&[], 1, visitor)
    }

    fn deserialize_tuple<V: Visitor<'de>>(
        self,
        length: usize,
        visitor: V,
    ) -> Result<V::Value, Error> {
        self.note("array");
        self.elements(&[], length, visitor)
    }

    fn deserialize_tuple_struct<V: Visitor<'de>>(
        self,
        name: &'static str,
        length: usize,
        visitor: V,
    ) -> Result<V::Value, Error> {
        self.note(name);
        self.elements(&[], length, visitor)
    }

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        name: &'static str,
        fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Error> {
        self.note(name);
        self.elements(fields, fields.len(), visitor)
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        name: &'static str,
        variants: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Error> {
        self.note(name);
        for variant in variants {
            self.note(variant);
        }
        let count = u32::try_from(variants.len()).unwrap_or(u32::MAX);
        self.variants = self.variants.max(count);
        let index = self.variant.min(count.saturating_sub(1));
        visitor.visit_enum(Choice { form: self, index })
    }

    fn is_human_readable(&self) -> bool {
        // As postcard, whose bytes this form describes.
        false
    }
}

/// The elements of a value.
struct Elements<'a> {
    form: &'a mut Form,
    names: core::slice::Iter<'static, &'static str>,
    left: usize,
}

impl<'de> de::SeqAccess<'de> for Elements<'_> {
    type Error = Error;

    fn next_element_seed<T: DeserializeSeed<'de>>(
        &mut self,
        seed: T,
    ) -> Result<Option<T::Value>, Error> {
        let Some(left) = self.left.checked_sub(1) else {
            return Ok(None);
        };
        self.left = left;
        if let Some(name) = self.names.next() {
            self.form.note(name);
        }
        seed.deserialize(&mut *self.form).map(Some)
    }
}

/// A variant of an enumeration.
struct Choice<'a> {
    form: &'a mut Form,
    index: u32,
}

impl<'de, 'a> de::EnumAccess<'de> for Choice<'a> {
    type Error = Error;
    type Variant = &'a mut Form;

    fn variant_seed<T: DeserializeSeed<'de>>(
        self,
        seed: T,
    ) -> Result<(T::Value, &'a mut Form), Error> {
        let variant = seed.deserialize(U32Deserializer::new(self.index))?;
        Ok((variant, self.form))
    }
}

impl<'de> de::VariantAccess<'de> for &mut Form {
    type Error = Error;

    fn unit_variant(self) -> Result<(), Error> {
        self.note("unit");
        Ok(())
    }

    fn newtype_variant_seed<T: DeserializeSeed<'de>>(self, seed: T) -> Result<T::Value, Error> {
        seed.deserialize(self)
    }

    fn tuple_variant<V: Visitor<'de>>(self, length: usize, visitor: V) -> Result<V::Value, Error> {
        self.elements(&[], length, visitor)
    }

    fn struct_variant<V: Visitor<'de>>(
        self,
        fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Error> {
        self.elements(fields, fields.len(), visitor)
    }
}

#[cfg(test)]
#[allow(dead_code, reason = "of these types only the form counts")]
mod tests {
    use super::*;
    use serde::Deserialize;

    #[derive(Deserialize)]
    struct Pair<A, B> {
        first: A,
        second: B,
    }

    /// Everything that may change in a type without a change of its name or of its defaults.
    #[test]
    fn every_change_of_the_form_shows() {
        mod changed {
            use serde::Deserialize;

            #[derive(Deserialize)]
            pub(super) struct Pair<A, B> {
                second: B,
                first: A,
            }
        }
        #[derive(Deserialize)]
        enum Two {
            A,
            B(u32),
        }
        mod other {
            use serde::Deserialize;

            #[derive(Deserialize)]
            pub(super) enum Two {
                B(u32),
                A,
            }
        }
        mod wider {
            use serde::Deserialize;

            #[derive(Deserialize)]
            pub(super) enum Two {
                A,
                B(u64),
            }
        }
        let schemas = [
            of::<Pair<u8, u8>>(),
            of::<changed::Pair<u8, u8>>(),
            of::<Pair<u8, u16>>(),
            of::<Pair<u8, Option<u8>>>(),
            of::<Pair<u8, Option<u16>>>(),
            of::<Pair<u8, [u8; 3]>>(),
            of::<Pair<u8, [u8; 4]>>(),
            of::<Two>(),
            of::<other::Two>(),
            of::<wider::Two>(),
            of::<Option<Two>>(),
        ];
        for (i, one) in schemas.iter().enumerate() {
            assert!(one.is_ok());
            for another in &schemas[i + 1..] {
                assert_ne!(one, another);
            }
        }
    }

    #[test]
    fn what_has_no_schema_is_an_error() {
        assert_eq!(of::<de::IgnoredAny>(), Err(Error::WontImplement));
    }
}
