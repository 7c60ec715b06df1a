//! Where two records of the same cycle differ, down to the bit.

use super::cdr::Encoder;
use super::field::{EachNumber, Number};
use super::recomputation::{Rounded, checksum};
use super::text::{CellWriter, columns};
use super::topics::{Form, Row, Topic};
use softdock_app::record::CycleRecord;

/// A number that differs.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Difference {
    /// Name of the number: that of its column in a CSV file.
    pub quantity: String,
    /// Its text in both records.
    pub texts: [String; 2],
    /// Its bits in both records, hexadecimal.
    pub bits: [String; 2],
}

/// Compares cycles. It keeps its buffers between calls.
#[derive(Debug, Default)]
pub struct Comparison {
    encoders: [Encoder; 2],
}

impl Comparison {
    /// The first number that differs, if any. All NaN count as the same number, as their bit pattern differs between
    /// processors.
    pub fn first_difference(&mut self, cycles: [&CycleRecord; 2]) -> Option<Difference> {
        let forms = Topic::all(false).iter().copied().map(Form::Full);
        self.first_of(forms, cycles.map(row))
    }

    /// As [`Self::first_difference`] for a first record in single precision: the second one is rounded too before they are
    /// compared. A difference that the rounding hides is found in the checksum of all digits.
    pub fn first_difference_rounded(
        &mut self,
        cycles: [&CycleRecord; 2],
        rounded: Rounded,
    ) -> Option<Difference> {
        let [mut recorded, mut recomputed] = cycles.map(row);
        recorded.checksum = rounded.checksum;
        recomputed.checksum = checksum(&mut Encoder::default(), &mut recomputed);
        let forms = Topic::all(false).iter().copied().map(Topic::in_single);
        let forms = forms.chain([Form::Full(Topic::Checksum)]);
        self.first_of(forms, [recorded, recomputed])
    }

    fn first_of(
        &mut self,
        mut forms: impl Iterator<Item = Form>,
        mut rows: [Row; 2],
    ) -> Option<Difference> {
        forms.find_map(|form| {
            for (encoder, row) in self.encoders.iter_mut().zip(&mut rows) {
                encoder.begin();
                let Ok(()) = form.visit(encoder, row);
            }
            let [recorded, recomputed] = &self.encoders;
            let same = recorded.bytes() == recomputed.bytes();
            if same { None } else { named(form, &mut rows) }
        })
    }
}

fn row(cycle: &CycleRecord) -> Row {
    Row {
        cycle: *cycle,
        ..Row::default()
    }
}

/// The first difference within a topic, with name, texts and bits.
fn named(form: Form, rows: &mut [Row; 2]) -> Option<Difference> {
    let [mut recorded, mut recomputed] = rows.each_mut().map(|row| {
        let (mut cells, mut bits) = (CellWriter::default(), BitWriter::default());
        let Ok(()) = form.visit(&mut cells, row);
        let Ok(()) = form.visit(&mut bits, row);
        cells.cells.into_iter().zip(bits.0)
    });
    columns(form.topic()).find_map(|quantity| {
        let (one, other) = (recorded.next()?, recomputed.next()?);
        (one.0 != other.0).then_some(Difference {
            quantity,
            texts: [one.0, other.0],
            bits: [one.1, other.1],
        })
    })
}

/// Collects the bits of each number.
#[derive(Debug, Default)]
struct BitWriter(Vec<String>);

impl EachNumber for BitWriter {
    fn number<T: Number>(&mut self, value: T) {
        let bytes = value.to_bytes();
        let digits = bytes.as_ref().iter().rev().map(|b| format!("{b:02x}"));
        self.0.push(format!("0x{}", digits.collect::<String>()));
    }
}
