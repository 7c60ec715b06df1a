//! Numbers in single precision: half as long, and of a number that is new in each cycle zstd leaves nearly all of its bytes.

use super::field::{Field, Number, Parts, Visitor, Words};

/// The longest field of numbers that a cycle computes: a quaternion.
const LONGEST: usize = 4;

/// Goes through a message in single precision; what was visited has no more digits afterwards.
pub(super) struct Single<'a, V>(pub(super) &'a mut V);

impl<V: Visitor> Visitor for Single<'_, V> {
    type Error = V::Error;

    #[inline(always)] // as for the encoder's rows
    fn numbers<T: Number>(&mut self, field: &Field, values: &mut [T]) -> Result<(), V::Error> {
        let parts = Parts {
            message: field.parts.single,
            ..field.parts
        };
        let mut room = [T::Single::default(); LONGEST];
        let singles = &mut room[..values.len()];
        for (single, value) in singles.iter_mut().zip(&*values) {
            *single = value.to_single();
        }
        self.0.numbers(&Field { parts, ..*field }, singles)?;
        for (value, single) in values.iter_mut().zip(singles) {
            *value = T::from_single(*single);
        }
        Ok(())
    }

    fn choice(&mut self, field: &Field, words: Words, code: &mut u8) -> Result<(), V::Error> {
        self.0.choice(field, words, code)
    }
}
