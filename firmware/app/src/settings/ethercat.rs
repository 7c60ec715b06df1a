//! The sensor's EtherCAT link.

use super::{BoardSettingsError, microseconds};
use softdock_control::range::in_range;
use softdock_link::ethercat::{AtiSubDevice, Control, EtherCatConfig};

softdock_control::described! {
/// The sensor's EtherCAT link: ATI Axia80 or EtherCAT F/T, alone on the cable.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct EtherCatSettings: "ethercat" {
    /// The sensor is on EtherCAT, and `can` is not used. The firmware must have the link:
    /// `cargo firmware -- --sensor ethercat`.
    pub enabled: bool = false,
    /// Low-pass filter of the sensor: 0 none, 1 to 8 ever lower; its manual has the frequencies.
    /// Its lag is part of the loop.
    pub filter: u8 = 0 => 0.0..=8.0,
    /// Calibration of the sensor, 0 to 15.
    pub calibration: u8 = 0 => 0.0..=15.0,
    /// Axia80: rate of its samples, 0 to 3; its manual has the frequencies.
    pub sample_rate: u8 = 0 => 0.0..=3.0,
    /// Longest time from one exchange to the next, s. Each telegram asks for one at once; this is
    /// the pace in between, which also keeps the sensor's watchdog at rest.
    pub poll_period_s: f64 = 0.001 => 0.0005..=0.02,
    /// Time after which an exchange counts as lost, s; 0.15 ms is normal.
    pub answer_timeout_s: f64 = 0.001 => 0.0002..=1.0,
    /// Longest time for which a telegram waits for the sample that it asks for, s; then the newest
    /// one is used. While the sensor does not answer, each answer to the robot is later by all of this.
    pub sample_wait_s: f64 = 0.001,
}
}

impl EtherCatSettings {
    /// Checks every field; `longest_wait_s` for a sample.
    pub(super) fn validate(&self, longest_wait_s: f64) -> Result<(), BoardSettingsError> {
        self.check_ranges()?;
        let wait_s = self.sample_wait_s;
        in_range("ethercat.sample_wait_s", wait_s, 0.0, longest_wait_s)?;
        Ok(())
    }

    /// The driver of the sensor.
    pub fn driver(&self) -> AtiSubDevice {
        AtiSubDevice::new(EtherCatConfig {
            poll_period_us: microseconds(self.poll_period_s),
            answer_timeout_us: microseconds(self.answer_timeout_s),
            control: Control {
                clear_bias: false,
                filter: self.filter,
                calibration: self.calibration,
                sample_rate: self.sample_rate,
            },
        })
    }

    /// Time after which an exchange counts as lost, µs.
    pub fn answer_timeout_us(&self) -> u64 {
        microseconds(self.answer_timeout_s)
    }
}
