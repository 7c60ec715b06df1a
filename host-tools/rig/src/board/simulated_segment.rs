//! The sensor at the far end of the simulated EtherCAT cable.

use crate::ethercat::{Description, Measurement, Segment, SubDevice};
use crate::rig::Rig;
use softdock_link::can::ati::AtiCalibration;
use softdock_link::ethercat::Product;
use std::collections::BTreeMap;

/// Time from a frame's leaving to its coming back, µs: 100 B each way at 100 Mbit/s, and the controllers on both sides.
const ROUND_TRIP_US: u64 = 40;
/// Time between two samples of the sensor, µs: an Axia80 at 7.8 kHz.
const SAMPLE_US: u64 = 128;

/// A segment, and frames on its cable.
pub(super) struct SimulatedSegment {
    pub(super) segment: Segment,
    calibration: AtiCalibration,
    /// By the time at which they arrive, and in order.
    on_cable: BTreeMap<(u64, u64), Vec<u8>>,
    frames: u64,
    /// Number of the newest sample.
    sample: u64,
}

impl SimulatedSegment {
    /// An Axia80 alone. The calibration is that of the rig's gauges.
    pub(super) fn new(calibration: AtiCalibration) -> Self {
        let axia = SubDevice::new(Description::of(Product::Axia80));
        Self {
            segment: Segment::new(vec![axia]),
            calibration,
            on_cable: BTreeMap::new(),
            frames: 0,
            sample: 0,
        }
    }

    /// Takes a frame of the board.
    pub(super) fn receive(&mut self, frame: &[u8], rig: &mut Rig, now_us: u64) {
        let sample = now_us / SAMPLE_US;
        if sample > self.sample {
            self.sample = sample;
            rig.advance_to(now_us);
            self.measure(rig);
        }
        for (late_us, back) in self.segment.pass(frame) {
            let at_us = now_us + ROUND_TRIP_US + late_us;
            self.on_cable.insert((at_us, self.frames), back);
            self.frames += 1;
        }
    }

    fn measure(&mut self, rig: &mut Rig) {
        let gauges = rig.gauges();
        let wrench = self.calibration.wrench(&gauges.counts);
        for device in &mut self.segment.devices {
            let per_unit = device.counts_per_unit();
            device.measure(Measurement::of(wrench, per_unit, gauges.status.into()));
        }
    }

    /// When something happens next.
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
