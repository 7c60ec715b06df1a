//! Recordings of simulated runs hold computed numbers in single precision; this module restores all digits.
//!
//! A cycle is a function of the inputs up to it, and in a simulated run this program itself is the board. The recording holds
//! inputs, measured motion, answer and status in full. What the cycle computes in between it holds in single precision, as a
//! viewer draws it, with a checksum of the full numbers. A reader computes these numbers again. If the checksum differs,
//! because reader and writer are different versions, the single-precision numbers stay. The recording of a board holds
//! everything in full: it says what the board did, whatever this program would compute.

use super::cdr::Encoder;
use super::field::{EachNumber, Number};
use super::topics::{Row, Topic};
use super::{Header, Recording};
use softdock_app::robot_cycle::RobotCycle;
use softdock_control::io::Trace;

/// First cycle whose numbers stay in single precision, because this program computes other numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rounded {
    /// Index of the cycle in the recording.
    pub place: usize,
    /// Checksum of its numbers as the writer computed them.
    pub checksum: u32,
}

impl Recording {
    /// Remarks on the file for readers of its numbers: that it was cut off, that numbers are rounded.
    pub fn notes(&self) -> impl Iterator<Item = String> + use<> {
        self.cut.clone().into_iter().chain(self.rounding())
    }

    /// A sentence on [`Self::rounded`]; None if no numbers are rounded.
    pub fn rounding(&self) -> Option<String> {
        self.rounded.map(|rounded| {
            format!(
                "From cycle {} on, this version computes other numbers than `{}` did; what was computed there has the \
                 seven digits that the recording holds.",
                rounded.place, self.header.identity
            )
        })
    }
}

/// CRC-32 of the computed messages in double precision. All NaN count as the same number.
pub(super) fn checksum(scratch: &mut Encoder, row: &mut Row) -> u32 {
    scratch.begin();
    for topic in Topic::COMPUTED {
        let Ok(()) = topic.visit(&mut CanonicalNan(scratch), row);
    }
    crc32fast::hash(scratch.bytes())
}

/// Encodes numbers with one bit pattern for all NaN: it differs between processors.
struct CanonicalNan<'a>(&'a mut Encoder);

impl EachNumber for CanonicalNan<'_> {
    #[inline]
    fn number<T: Number>(&mut self, value: T) {
        let nan = value.as_f64().is_nan().then(|| T::parse("NaN")).flatten();
        self.0.number(nan.unwrap_or(value));
    }

    #[inline(always)] // as for the encoder's rows
    fn row<T: Number>(&mut self, values: &[T]) {
        if values.iter().any(|value| value.as_f64().is_nan()) {
            values.iter().for_each(|value| self.number(*value));
        } else {
            self.0.row(values);
        }
    }
}

/// Recomputes the cycles of a recording.
pub(super) struct Recomputation {
    controller: RobotCycle<f64>,
    scratch: Encoder,
}

impl Recomputation {
    /// None if this version cannot run with the settings of the recording.
    pub(super) fn new(header: &Header) -> Option<Self> {
        let settings = header.control_settings().ok()?;
        Some(Self {
            controller: RobotCycle::new(&settings).ok()?,
            scratch: Encoder::default(),
        })
    }

    /// Replaces the computed numbers of the next cycle by the recomputed ones. Returns false, and leaves the cycle as it is,
    /// if their checksum differs.
    pub(super) fn complete(&mut self, row: &mut Row) -> bool {
        let recorded = row.cycle;
        let mut recomputed = Row {
            cycle: self.controller.step(&recorded.inputs),
            ..*row
        };
        if checksum(&mut self.scratch, &mut recomputed) != row.checksum {
            return false;
        }
        row.cycle.trace = recorded_in_full(&recorded.trace, recomputed.cycle.trace);
        true
    }
}

/// The recomputed trace with those numbers that are recorded in full.
fn recorded_in_full(recorded: &Trace, computed: Trace) -> Trace {
    Trace {
        cycle: recorded.cycle,
        time_s: recorded.time_s,
        mode: recorded.mode,
        fault: recorded.fault,
        refusal: recorded.refusal,
        limits: recorded.limits,
        sensor_age: recorded.sensor_age,
        pose: recorded.pose,
        executed_velocity: recorded.executed_velocity,
        ..computed
    }
}
