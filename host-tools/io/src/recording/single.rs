//! Numbers in single precision: half as long. zstd cannot compress the bits of a number that is new in each cycle.

use super::field::{Field, Number, Parts, Visitor, Words};

/// Number of components of the longest field that a cycle computes: a quaternion.
const LONGEST: usize = 4;

/// Visits a message in single precision. The visited numbers are rounded to it afterwards.
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
