//! Common Data Representation, the byte format of ROS 2 messages: plain CDR (XCDR1 of OMG
//! DDS-XTypes 1.3, 7.4.3), little-endian. Each number is aligned to its own size, counted from
//! the end of the four-byte encapsulation header; arrays of fixed length have no length word.

use super::field::{EachNumber, Field, Number, Visitor, Words};

/// Encapsulation header: representation CDR_LE, no options.
const HEADER: [u8; 4] = [0, 1, 0, 0];

/// Encodes messages into one buffer, each replacing the one before or appended to it.
#[derive(Debug, Default)]
pub(super) struct Encoder {
    /// Never shortened: as long as the longest content so far.
    buffer: Vec<u8>,
    /// Offset of the present message's body, from which alignment counts.
    body: usize,
    /// End of the content.
    end: usize,
}

impl Encoder {
    /// Begins a message, replacing all content.
    pub(super) fn begin(&mut self) {
        self.clear();
        self.begin_next();
    }

    /// Begins a message after the present content.
    pub(super) fn begin_next(&mut self) {
        self.raw(&HEADER);
        self.body = self.end;
    }

    /// Removes all content.
    pub(super) fn clear(&mut self) {
        self.end = 0;
    }

    /// Appends bytes that are not part of a message.
    pub(super) fn raw(&mut self, bytes: &[u8]) {
        self.body = self.end;
        self.room::<u8>(bytes.len()).copy_from_slice(bytes);
    }

    /// Appends a string: its length including the zero byte that ends it, its bytes, the zero byte.
    pub(super) fn text(&mut self, text: &str) {
        self.count(text.len() + 1);
        self.room::<u8>(text.len()).copy_from_slice(text.as_bytes());
        self.number(0_u8);
    }

    /// Appends the length of a sequence, whose elements follow.
    pub(super) fn count(&mut self, count: usize) {
        self.number(count as u32);
    }

    /// The content so far: one message after [`Self::begin`].
    pub(super) fn bytes(&self) -> &[u8] {
        &self.buffer[..self.end]
    }

    /// The content so far, mutable.
    pub(super) fn bytes_mut(&mut self) -> &mut [u8] {
        &mut self.buffer[..self.end]
    }

    /// Space for `count` numbers, aligned to the size of one.
    #[inline]
    fn room<T: Number>(&mut self, count: usize) -> &mut [u8] {
        // A compile-time constant: `next_multiple_of` costs no division.
        let size = size_of::<T::Bytes>();
        let length = self.end - self.body;
        let padding = length.next_multiple_of(size) - length;
        let start = self.end + padding;
        let end = start + size * count;
        if end > self.buffer.len() {
            self.buffer.resize(end, 0);
        }
        // Most numbers need no padding, and a call of `fill` for zero bytes would cost more than storing the number.
        if padding > 0 {
            self.buffer[self.end..start].fill(0);
        }
        self.end = end;
        &mut self.buffer[start..end]
    }
}

impl EachNumber for Encoder {
    #[inline]
    fn number<T: Number>(&mut self, value: T) {
        self.row(&[value]);
    }

    #[inline(always)] // a field's few numbers, how many is known, are stored without a call
    fn row<T: Number>(&mut self, values: &[T]) {
        let room = self.room::<T>(values.len());
        let places = room.chunks_exact_mut(size_of::<T::Bytes>());
        for (place, value) in places.zip(values) {
            place.copy_from_slice(value.to_bytes().as_ref());
        }
    }
}

/// Error in bytes that are not the expected message.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub(super) enum CdrError {
    #[error("expected a message of little-endian CDR (00 01 00 00), it begins with {0:02x?}")]
    Header(Vec<u8>),
    #[error("field `{field}` ends at byte {expected}, the message at byte {received}")]
    Short {
        field: String,
        expected: usize,
        received: usize,
    },
    #[error("field `{field}` holds the byte {received}; expected is at most {most}")]
    Value {
        field: String,
        most: usize,
        received: u8,
    },
    #[error("expected a message of {expected} bytes, received {received}")]
    Long { expected: usize, received: usize },
}

/// Decodes one message.
#[derive(Debug)]
pub(super) struct Decoder<'a> {
    /// The message without its encapsulation header.
    body: &'a [u8],
    at: usize,
}

impl<'a> Decoder<'a> {
    pub(super) fn new(message: &'a [u8]) -> Result<Self, CdrError> {
        match message.split_first_chunk() {
            Some((&HEADER, body)) => Ok(Self { body, at: 0 }),
            _ => Err(CdrError::Header(message.iter().copied().take(4).collect())),
        }
    }

    /// An error unless all bytes were read.
    pub(super) fn finish(self) -> Result<(), CdrError> {
        if self.at == self.body.len() {
            return Ok(());
        }
        Err(CdrError::Long {
            expected: HEADER.len() + self.at,
            received: HEADER.len() + self.body.len(),
        })
    }

    /// The next `size` bytes, aligned.
    fn take(&mut self, field: &Field, size: usize) -> Result<&'a [u8], CdrError> {
        let start = self.at.next_multiple_of(size);
        let end = start + size;
        let bytes = self.body.get(start..end).ok_or_else(|| CdrError::Short {
            field: field.wire_name(),
            expected: HEADER.len() + end,
            received: HEADER.len() + self.body.len(),
        })?;
        self.at = end;
        Ok(bytes)
    }
}

impl Visitor for Decoder<'_> {
    type Error = CdrError;

    fn numbers<T: Number>(&mut self, field: &Field, values: &mut [T]) -> Result<(), CdrError> {
        for value in values {
            let bytes = self.take(field, size_of::<T::Bytes>())?;
            let number = T::Bytes::try_from(bytes).ok().and_then(T::from_bytes);
            // Only a bool can have invalid bytes.
            *value = number.ok_or_else(|| not_below(field, 2, bytes))?;
        }
        Ok(())
    }

    fn choice(&mut self, field: &Field, words: Words, code: &mut u8) -> Result<(), CdrError> {
        let bytes = self.take(field, 1)?;
        *code = bytes
            .first()
            .copied()
            .filter(|byte| usize::from(*byte) < words.len())
            .ok_or_else(|| not_below(field, words.len(), bytes))?;
        Ok(())
    }
}

fn not_below(field: &Field, limit: usize, bytes: &[u8]) -> CdrError {
    CdrError::Value {
        field: field.wire_name(),
        most: limit - 1,
        received: bytes.first().copied().unwrap_or_default(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::field::{Parts, Unit};

    const FIELD: Field = Field {
        name: "x",
        unit: Unit::NONE,
        parts: Parts::NONE,
        about: "",
    };

    /// Hand-made bytes: u16 at 0, three bytes of words and flags, f64 aligned to 8.
    #[test]
    fn known_bytes() {
        let mut encoder = Encoder::default();
        encoder.begin();
        let Ok(()) = encoder.numbers(&FIELD, &mut [0x1234_u16]);
        let Ok(()) = encoder.choice(&FIELD, &["a", "b"], &mut 1);
        let Ok(()) = encoder.numbers(&FIELD, &mut [true, false]);
        let Ok(()) = encoder.numbers(&FIELD, &mut [1.0_f64, -2.0]);
        let expected = [
            &[0, 1, 0, 0, 0x34, 0x12, 1, 1, 0, 0, 0, 0][..],
            &[0, 0, 0, 0, 0, 0, 0xf0, 0x3f],
            &[0, 0, 0, 0, 0, 0, 0, 0xc0],
        ];
        assert_eq!(encoder.bytes(), expected.concat());

        let mut decoder = Decoder::new(encoder.bytes()).unwrap();
        let (mut word, mut code, mut flags, mut reals) = ([0_u16], 0, [false; 2], [0.0; 2]);
        decoder.numbers(&FIELD, &mut word).unwrap();
        decoder.choice(&FIELD, &["a", "b"], &mut code).unwrap();
        decoder.numbers(&FIELD, &mut flags).unwrap();
        decoder.numbers(&FIELD, &mut reals).unwrap();
        decoder.finish().unwrap();
        assert_eq!((word, code, flags), ([0x1234], 1, [true, false]));
        assert_eq!(reals, [1.0, -2.0]);
    }

    #[test]
    fn wrong_bytes_are_told_with_their_numbers() {
        let header = Decoder::new(&[0, 0, 0, 0]).unwrap_err();
        assert_eq!(header, CdrError::Header(vec![0; 4]));
        assert_eq!(Decoder::new(&[]).unwrap_err(), CdrError::Header(vec![]));

        let mut decoder = Decoder::new(&[0, 1, 0, 0, 7, 7]).unwrap();
        let error = decoder.numbers(&FIELD, &mut [0.0]).unwrap_err();
        let text = "field `x` ends at byte 12, the message at byte 6";
        assert_eq!(error.to_string(), text);
        let error = decoder.numbers(&FIELD, &mut [false]).unwrap_err();
        let text = "field `x` holds the byte 7; expected is at most 1";
        assert_eq!(error.to_string(), text);
        let error = decoder.choice(&FIELD, &["a"; 7], &mut 0).unwrap_err();
        let text = "field `x` holds the byte 7; expected is at most 6";
        assert_eq!(error.to_string(), text);

        let (expected, received) = (4, 5);
        let long = Decoder::new(&[0, 1, 0, 0, 0]).unwrap().finish();
        assert_eq!(long, Err(CdrError::Long { expected, received }));
    }
}
