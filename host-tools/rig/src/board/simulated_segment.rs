//! The sensor at the far end of the simulated EtherCAT cable.

use crate::ethercat::{Description, Segment, SubDevice};
use crate::rig::SensorSampleSim;
use softdock_link::can::ati::AtiCalibration;
use softdock_link::ethercat::Product;
use std::collections::BTreeMap;

/// Time from a frame's leaving to its coming back, µs: 100 B each way at 100 Mbit/s, and the controllers on both sides.
const ROUND_TRIP_US: u64 = 40;
/// Time between two samples of the sensor, µs: an Axia80 at 7.8 kHz.
const SAMPLE_US: u64 = 128;

/// Copies the reading of the rig's gauges to the sensors of a segment, once per sample.
pub(crate) struct ReadingSampler {
    calibration: AtiCalibration,
    /// Number of the newest sample.
    sample: u64,
}

impl ReadingSampler {
    /// The calibration is that of the rig's gauges.
    pub(crate) fn new(calibration: AtiCalibration) -> Self {
        Self {
            calibration,
            sample: 0,
        }
    }

    /// Takes a reading if the next sample is due.
    pub(crate) fn measure(
        &mut self,
        segment: &mut Segment,
        now_us: u64,
        sense: &mut dyn FnMut() -> SensorSampleSim,
    ) {
        let sample = now_us / SAMPLE_US;
        if sample <= self.sample {
            return;
        }
        self.sample = sample;
        let gauges = sense();
        segment.measure(self.calibration.wrench(&gauges.counts), gauges.status);
    }
}

/// A segment, and frames on its cable.
pub(super) struct SimulatedSegment {
    pub(super) segment: Segment,
    sampler: ReadingSampler,
    /// Frames on the cable by time of arrival and number.
    on_cable: BTreeMap<(u64, u64), Vec<u8>>,
    frames: u64,
}

impl SimulatedSegment {
    /// An Axia80 alone. The calibration is that of the rig's gauges.
    pub(super) fn new(calibration: AtiCalibration) -> Self {
        let axia = SubDevice::new(Description::of(Product::Axia80));
        Self {
            segment: Segment::new(vec![axia]),
            sampler: ReadingSampler::new(calibration),
            on_cable: BTreeMap::new(),
            frames: 0,
        }
    }

    /// Takes a frame of the board; `sense` is a reading at this instant.
    pub(super) fn receive(
        &mut self,
        frame: &[u8],
        now_us: u64,
        sense: &mut dyn FnMut() -> SensorSampleSim,
    ) {
        self.sampler.measure(&mut self.segment, now_us, sense);
        for (late_us, back) in self.segment.pass(frame) {
            let at_us = now_us + ROUND_TRIP_US + late_us;
            self.on_cable.insert((at_us, self.frames), back);
            self.frames += 1;
        }
    }

    /// Time of the next event, µs; `u64::MAX` if there is none.
    pub(super) fn next_us(&self) -> u64 {
        let first = self.on_cable.first_key_value();
        first.map_or(u64::MAX, |((at_us, _), _)| *at_us)
    }

    /// The next frame that has arrived by now.
    pub(super) fn poll(&mut self, now_us: u64) -> Option<Vec<u8>> {
        let first = self.on_cable.first_entry()?;
        (first.key().0 <= now_us).then(|| first.remove())
    }
}
