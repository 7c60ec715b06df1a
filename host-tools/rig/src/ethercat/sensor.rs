//! What the simulated sensor measures.

use softdock_link::ethercat::{INPUT_BYTES, Inputs};

/// A sample of the sensor.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Measurement {
    /// Counts of force X, Y, Z and torque X, Y, Z.
    pub counts: [i32; 6],
    /// Status word.
    pub status: u32,
}

impl Measurement {
    /// What a sensor with these counts per unit of force and torque shows of a wrench in its units.
    pub fn of(wrench: [f64; 6], (force, torque): (i32, i32), status: u32) -> Self {
        let counts = |axis: usize| {
            let per_unit = if axis < 3 { force } else { torque };
            // Values beyond 32 bits saturate.
            (wrench[axis] * f64::from(per_unit)).round() as i32
        };
        Self {
            counts: std::array::from_fn(counts),
            status,
        }
    }
}

/// The sensor behind the controller.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Sensor {
    measured: Measurement,
    sample: u32,
}

impl Sensor {
    pub(super) fn measure(&mut self, measured: Measurement) {
        self.measured = measured;
        self.sample = self.sample.wrapping_add(1);
    }

    pub(super) fn inputs(&self) -> [u8; INPUT_BYTES] {
        Inputs {
            counts: self.measured.counts,
            status: self.measured.status,
            sample: self.sample,
        }
        .encode()
    }
}
