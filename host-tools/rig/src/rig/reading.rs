//! Hidden effects between the load of the sensor and what it reads.
//!
//! Mounting, cross-talk and gains act on the load; filter and line act on the result. Then the zero is added here, and noise by
//! the sensor. Range, resolution and lost samples act on the samples that are sent.

use super::hidden::{self, Hidden};
use softdock_control::frames::Wrench;
use softdock_physics::effects::{DelayLine, Group, Law, Values};
use softdock_statistics::RandomStream;

/// Hidden effects on the reading.
#[derive(Clone, Debug)]
pub(super) struct Reading {
    /// Laws with their values, in the catalogue's order.
    laws: Vec<(Law, Vec<f64>)>,
    /// Delays and filters, in series.
    late: Vec<DelayLine>,
    step_s: f64,
    /// The last sample that was sent.
    sent: Wrench<f64>,
    noise: RandomStream,
}

impl Reading {
    pub(super) fn new(hidden: &[Hidden], step_s: f64, noise: RandomStream) -> Self {
        let laws = hidden::in_order(hidden, Group::Sensor);
        let mut reading = Self {
            laws: laws.map(|(effect, values)| (effect.law, values)).collect(),
            late: Vec::new(),
            step_s,
            sent: Wrench::zero(),
            noise,
        };
        reading.settle(&Wrench::zero());
        reading
    }

    /// Whether it has a state that has to follow every integration step.
    pub(super) fn has_memory(&self) -> bool {
        !self.late.is_empty()
    }

    /// Load as the rotated, coupled and wrongly scaled sensor feels it.
    pub(super) fn distorted(&self, load: &Wrench<f64>) -> Wrench<f64> {
        self.laws.iter().fold(*load, |wrench, (law, p)| match law {
            Law::SensorGain(law) => law(p, &wrench),
            _ => wrench,
        })
    }

    /// Starts as if the wrench had been felt for a long time.
    pub(super) fn settle(&mut self, wrench: &Wrench<f64>) {
        let (step_s, first) = (self.step_s, wrench.get());
        let late = self.laws.iter().filter_map(|(law, p)| match law {
            Law::ReadingDelay(law) => Some(DelayLine::new(law(p), step_s, first)),
            _ => None,
        });
        self.late = late.collect();
    }

    /// Advances delays and filters by an integration step.
    pub(super) fn advance(&mut self, wrench: &Wrench<f64>) {
        let mut felt = wrench.get();
        for late in &mut self.late {
            felt = late.advance(felt);
        }
    }

    /// Output of filter and line; None if there is neither.
    pub(super) fn felt(&self) -> Option<Wrench<f64>> {
        self.late.last().map(|late| Wrench::of(&late.value()))
    }

    /// Zero of the sensor at a time, s.
    pub(super) fn zero(&self, time_s: f64) -> Wrench<f64> {
        let zero = |(law, p): &(Law, Vec<f64>)| match law {
            Law::SensorZero(law) => law(p, time_s),
            _ => Wrench::zero(),
        };
        let all = self.laws.iter().map(zero);
        all.fold(Wrench::zero(), |sum, zero| sum + zero)
    }

    /// One sample as it is sent.
    pub(super) fn sampled(&mut self, wrench: Wrench<f64>) -> Wrench<f64> {
        let mut read = wrench;
        for (law, p) in &self.laws {
            let p: Values<'_> = p;
            read = match law {
                Law::Saturation(law) => law(p, &read),
                // Uniform in (0, 1], so that a share of 0 never holds and one of 1 always does.
                Law::Sample(law) => (law.sent)(p, &read, &self.sent, 1.0 - self.noise.uniform()),
                _ => read,
            };
        }
        self.sent = read;
        read
    }
}
