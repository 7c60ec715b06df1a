//! What a simulated run's recording holds in single precision, and how it gets all digits back.
//!
//! A cycle is a function of the inputs up to it, and in a simulated run this program itself is the board. Its recording has
//! the inputs, the measured motion, the answer and the status in full, and what the cycle computed in between in single
//! precision, as a viewer draws it, with a checksum of the numbers in full. A reader computes them again; where the checksum
//! is another, because the reader is another version than the writer was, the numbers stay as they were written.
//! A board's recording says what the board did, whatever this program would compute: it has everything in full.

use super::cdr::Encoder;
use super::field::{EachNumber, Number};
use super::topics::{Row, Topic};
use super::{Header, Recording};
use softdock_app::robot_cycle::RobotCycle;
use softdock_control::io::Trace;

/// From which cycle on numbers have single precision, because this program computes others.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rounded {
    /// Place of the cycle in the recording.
    pub place: usize,
    /// Checksum of its numbers as they were computed when it was recorded.
    pub checksum: u32,
}

impl Recording {
    /// What a reader of its numbers should know of the file.
    pub fn notes(&self) -> impl Iterator<Item = String> + use<> {
        self.cut.clone().into_iter().chain(self.rounding())
    }

    /// That numbers are [`Self::rounded`].
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

/// Checksum of what a cycle computes: CRC-32 of the messages in full. All NaN count as the same number.
pub(super) fn checksum(scratch: &mut Encoder, row: &mut Row) -> u32 {
    scratch.begin();
    for topic in Topic::COMPUTED {
        let Ok(()) = topic.visit(&mut OneNan(scratch), row);
    }
    crc32fast::hash(scratch.bytes())
}

/// Encodes numbers, whichever NaN the hardware makes.
struct OneNan<'a>(&'a mut Encoder);

impl EachNumber for OneNan<'_> {
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

/// Computes the cycles of a recording again.
pub(super) struct Again {
    controller: RobotCycle<f64>,
    scratch: Encoder,
}

impl Again {
    /// None if this version cannot run with these settings.
    pub(super) fn new(header: &Header) -> Option<Self> {
        let settings = header.control_settings().ok()?;
        Some(Self {
            controller: RobotCycle::new(&settings).ok()?,
            scratch: Encoder::default(),
        })
    }

    /// Gives the next cycle all digits; false if it was computed otherwise.
    pub(super) fn complete(&mut self, row: &mut Row) -> bool {
        let recorded = row.cycle;
        let mut again = Row {
            cycle: self.controller.step(&recorded.inputs),
            ..*row
        };
        if checksum(&mut self.scratch, &mut again) != row.checksum {
            return false;
        }
        row.cycle.trace = recorded_in_full(&recorded.trace, again.cycle.trace);
        true
    }
}

/// The computed numbers with the others as they were recorded.
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
