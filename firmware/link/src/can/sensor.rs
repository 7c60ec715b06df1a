//! The driver that gives all CAN sensors one interface.

use super::Frame;
use super::ati::AtiDriver;
use super::sri::SriDriver;
use crate::sensor::{SensorCounters, SensorDriver, SensorReading, SensorState};

/// Any supported CAN sensor.
#[derive(Clone, Debug)]
#[expect(
    clippy::large_enum_variant,
    reason = "there is one per board, and no heap to put it on"
)]
pub enum CanSensor {
    /// ATI NETCANOEM.
    Ati(AtiDriver),
    /// SRI M8123B2.
    Sri(SriDriver),
}

/// Calls the method of the actual sensor's driver.
macro_rules! delegate {
    ($self:ident . $method:ident ( $($argument:expr),* )) => {
        match $self {
            CanSensor::Ati(driver) => driver.$method($($argument),*),
            CanSensor::Sri(driver) => driver.$method($($argument),*),
        }
    };
}

impl SensorDriver for CanSensor {
    type Frame = Frame;

    fn poll_transmit(&mut self, now_us: u64) -> Option<Frame> {
        delegate!(self.poll_transmit(now_us))
    }

    fn next_deadline_us(&self) -> u64 {
        delegate!(self.next_deadline_us())
    }

    fn receive(&mut self, frame: &Frame, now_us: u64) -> Option<SensorReading> {
        delegate!(self.receive(frame, now_us))
    }

    fn expedite(&mut self, now_us: u64) {
        if let Self::Ati(driver) = self {
            driver.expedite(now_us);
        }
    }

    fn state(&self) -> SensorState {
        delegate!(self.state())
    }

    fn counters(&self) -> SensorCounters {
        delegate!(self.counters())
    }

    fn restart(&mut self) {
        delegate!(self.restart());
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::can::Id;
    use crate::can::ati::{AtiCalibration, AtiConfig, AtiDevice, ForceUnit, TorqueUnit};
    use crate::can::sri::{SriConfig, stream_frames};

    /// Asserts that a driver behaves the same directly and through the common interface: at start-up, readings, an unexpected
    /// frame, silence, an expedited request, and a restart. `answers` is the sensor.
    macro_rules! assert_alike {
        ($bare:ident, $variant:ident, $answers:expr) => {
            let mut common = CanSensor::$variant($bare.clone());
            let mut readings = 0;
            for step in 0..1_200 {
                let now_us = 1_000 * step;
                let asked = $bare.poll_transmit(now_us);
                assert_eq!(common.poll_transmit(now_us), asked);
                assert_eq!(common.next_deadline_us(), $bare.next_deadline_us());
                let silent = (30..34).contains(&step);
                let answers: Vec<Frame> = $answers(asked);
                let stray = Frame::new(Id::Standard(0x7f0), &[1, 2]).ok();
                for frame in answers.into_iter().chain(stray).filter(|_| !silent) {
                    let reading = $bare.receive(&frame, now_us + 300);
                    assert_eq!(common.receive(&frame, now_us + 300), reading);
                    readings += u32::from(reading.is_some());
                }
                assert_eq!(common.state(), $bare.state());
                assert_eq!(common.counters(), $bare.counters());
                if step == 50 {
                    $bare.restart();
                    common.restart();
                    assert_eq!(common.state(), $bare.state());
                }
            }
            assert_eq!(common.state(), SensorState::Running);
            assert!(readings > 20, "{readings}");
            assert_ne!(common.counters(), SensorCounters::default());
        };
    }

    fn ati() -> AtiDriver {
        AtiDriver::new(AtiConfig::default())
    }

    fn ati_device() -> AtiDevice {
        let mut matrix = [[0.0; 6]; 6];
        for (i, row) in matrix.iter_mut().enumerate() {
            row[i] = 1.0;
        }
        let calibration = AtiCalibration {
            matrix,
            counts_per_force: 1_000.0,
            counts_per_torque: 50_000.0,
        };
        let units = (ForceUnit::Newton, TorqueUnit::NewtonMetre);
        AtiDevice::new(0x20, &calibration, units.0, units.1).unwrap()
    }

    #[test]
    fn an_ati_sensor_is_driven_as_by_its_own_driver() {
        let (mut bare, mut device) = (ati(), ati_device());
        let answers = |asked: Option<Frame>| {
            let asked = asked.into_iter();
            asked
                .flat_map(|frame| device.answer(&frame, [1, -2, 3, -4, 5, -6], 0))
                .collect()
        };
        let mut answers = answers;
        assert_alike!(bare, Ati, answers);
    }

    #[test]
    fn an_sri_sensor_is_driven_as_by_its_own_driver() {
        let mut bare = SriDriver::new(SriConfig::default());
        let answers = |_| stream_frames([1.5; 6]).unwrap().to_vec();
        assert_alike!(bare, Sri, answers);
    }

    /// A request that waits for its period goes out at once; a stream has none.
    #[test]
    fn a_request_can_be_made_to_hurry() {
        let (mut sensor, mut device) = (CanSensor::Ati(ati()), ati_device());
        let (mut now_us, mut read) = (0, false);
        while !read {
            now_us = sensor.next_deadline_us().max(now_us);
            let asked = sensor.poll_transmit(now_us).into_iter();
            for answer in asked.flat_map(|frame| device.answer(&frame, [0; 6], 0)) {
                read |= sensor.receive(&answer, now_us + 300).is_some();
            }
        }
        now_us += 301;
        assert!(sensor.next_deadline_us() > now_us);
        assert_eq!(sensor.poll_transmit(now_us), None);
        sensor.expedite(now_us);
        assert!(sensor.poll_transmit(now_us).is_some());

        let mut stream = CanSensor::Sri(SriDriver::new(SriConfig::default()));
        assert!(stream.poll_transmit(0).is_some());
        stream.expedite(1);
        assert_eq!(stream.poll_transmit(1), None);
    }
}
