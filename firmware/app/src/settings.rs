//! Settings of a board: those of the control cycle, and how its links are set up.

mod ethercat;
mod network;

pub use ethercat::EtherCatSettings;
pub use network::{Network, NetworkSettings};

use softdock_control::range::{SettingsError, in_range};
use softdock_control::settings::Settings;
use softdock_link::can::CanSensor;
use softdock_link::can::ati::{AtiConfig, AtiDriver};
use softdock_link::can::sri::{SriConfig, SriDriver};
use softdock_link::rsi::{Name, TagError, Tags};

/// Capacity for element names: slightly more than the longest allowed, so that a longer one is recognised.
const NAME_BYTES: usize = 32;

/// The word for a robot of any address.
pub const ANY_ROBOT: &str = "any";

/// Name of the setting that takes it.
const ROBOT_IP: &str = "rsi.robot_ip";

/// A short text of the settings.
pub type Text = heapless::String<NAME_BYTES>;

softdock_control::described! {
/// All settings of a board.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct BoardSettings {
    /// The control cycle.
    pub control: Settings,
    /// The sensor's CAN link.
    pub can: CanSettings,
    /// The sensor's EtherCAT link, in place of CAN.
    pub ethercat: EtherCatSettings,
    /// The robot's RSI link.
    pub rsi: RsiSettings,
    /// The board's place on the network.
    pub network: NetworkSettings,
}
}

/// Which CAN sensor is connected.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SensorKind {
    /// ATI NETCANOEM, polled.
    #[default]
    Ati,
    /// SRI M8123B2, streaming.
    Sri,
}

softdock_control::described! {
/// The sensor's CAN link.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct CanSettings: "can" {
    /// The sensor.
    pub sensor: SensorKind = SensorKind::Ati,
    /// ATI: base of the identifiers, 7 bits.
    pub base_id: u8 = 0x20 => 0.0..=127.0,
    /// ATI: longest time from one request to the next, s. Each telegram asks for a sample at once;
    /// this is the pace while the robot is silent.
    pub poll_period_s: f64 = 0.005 => 0.0005..=0.02,
    /// ATI: time after which an answer counts as lost, s. By default two control cycles, the age
    /// at which a sample counts as stale.
    pub answer_timeout_s: f64 = 0.008 => 0.0005..=1.0,
    /// ATI: gauge counts beyond which a gauge counts as saturated.
    pub saturation_counts: i16 = 32_000 => 1.0..=32767.0,
    /// SRI: force (N) and torque (N·m) beyond which an axis counts as saturated.
    pub saturation_force_n: f64 = 1e5 => 1.0..=1e6,
    /// See `saturation_force_n`.
    pub saturation_torque_n_m: f64 = 1e5 => 0.1..=1e6,
    /// SRI: silence after which the start command is sent again, s.
    pub stream_timeout_s: f64 = 0.1 => 0.005..=10.0,
    /// SRI: longest time from the first to the last frame of a reading, s. On a bus 0.0005; through
    /// a serial adapter frames come in bursts and need more. Shorter than the time between two
    /// readings.
    pub pairing_window_s: f64 = 0.0005 => 0.0001..=0.02,
    /// Longest time for which a telegram waits for the sample that it asks for, s; then the newest
    /// one is used. The exchange takes 0.35 ms at 1 Mbit/s; a sensor that falls silent makes each answer to
    /// the robot later by all of this, until `answer_timeout_s` (or `stream_timeout_s`) has told.
    pub sample_wait_s: f64 = 0.001,
}
}

softdock_control::described! {
/// The robot's RSI link. Element names must be those of the robot's Ethernet configuration, which
/// `softdock robot-config` writes from the same settings.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RsiSettings: "rsi" {
    /// `Type` of the answers.
    pub sentype: Text = text("ImFree"),
    /// Element of the correction.
    pub correction: Text = text("RKorr"),
    /// Element of the stop request; empty: no stop request is sent.
    pub stop: Text = text("Stop"),
    /// Element with POSCORR's status; empty: not sent by the robot.
    pub poscorr_stat: Text = text("PosCorrStat"),
    /// The robot's address. `any`: the first sender of a valid telegram is the robot, and who comes
    /// when it has been silent takes its place. Empty: likewise, but the service arms nothing.
    pub robot_ip: Text = Text::new(),
    /// Silence after which another sender may become the robot, s (in cycles of 4 ms: 100).
    pub silence_s: f64 = 0.4 => 0.02..=60.0,
    /// Lost telegrams after which a new RSI run is assumed.
    pub new_run_after_lost: u32 = 100 => 1.0..=1e6,
}
}

fn text(of: &str) -> Text {
    Text::try_from(of).unwrap_or_default()
}

/// Errors of a board's settings.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum BoardSettingsError {
    /// A number is outside of its range.
    #[error("{0}")]
    Range(SettingsError),
    /// A name cannot be an RSI element.
    #[error("`{field}`: {error}")]
    Name {
        /// Dotted name of the field.
        field: &'static str,
        /// What is wrong with it.
        error: TagError,
    },
    /// A text is not the IP address of a host.
    #[error(
        "`{field}` is not the IP address of a host; write it like \"192.168.1.10\"{}",
        if *.field == ROBOT_IP { ", or \"any\"" } else { "" }
    )]
    Address {
        /// Dotted name of the field.
        field: &'static str,
    },
    /// A text is not the IP address of a host with a port.
    #[error(
        "`{field}` is not the IP address of a host with a port; write it like \"192.168.1.10:49200\" or leave it empty"
    )]
    Socket {
        /// Dotted name of the field.
        field: &'static str,
    },
}

impl From<SettingsError> for BoardSettingsError {
    fn from(error: SettingsError) -> Self {
        Self::Range(error)
    }
}

/// µs of a time in s that was checked to be positive and short.
fn microseconds(seconds: f64) -> u64 {
    (seconds * 1e6) as u64
}

impl BoardSettings {
    /// Checks every field.
    pub fn validate(&self) -> Result<(), BoardSettingsError> {
        self.control.validate()?;
        let can = &self.can;
        can.check_ranges()?;
        in_range(
            "can.sample_wait_s",
            can.sample_wait_s,
            0.0,
            self.longest_wait_s(!self.ethercat.enabled),
        )?;
        self.ethercat
            .validate(self.longest_wait_s(self.ethercat.enabled))?;
        self.rsi.check_ranges()?;
        self.rsi.tags()?;
        self.rsi.robot_ip()?;
        self.network.build().map(|_| ())
    }

    /// How long a link may wait for a sample: half a cycle if it is the chosen one.
    fn longest_wait_s(&self, chosen: bool) -> f64 {
        /// Half of the longest cycle that the settings allow.
        const UNUSED_S: f64 = 0.01;
        match chosen {
            true => self.control.robot.cycle_s / 2.0,
            false => UNUSED_S,
        }
    }

    /// Longest wait for a sample of the sensor on the chosen link, µs.
    pub fn sample_wait_us(&self) -> u64 {
        microseconds(match self.ethercat.enabled {
            true => self.ethercat.sample_wait_s,
            false => self.can.sample_wait_s,
        })
    }
}

impl CanSettings {
    /// The driver of the chosen sensor.
    pub fn driver(&self) -> CanSensor {
        match self.sensor {
            SensorKind::Ati => CanSensor::Ati(AtiDriver::new(AtiConfig {
                base_id: self.base_id,
                poll_period_us: microseconds(self.poll_period_s),
                answer_timeout_us: microseconds(self.answer_timeout_s),
                saturation_counts: self.saturation_counts,
            })),
            SensorKind::Sri => {
                let (f, t) = (self.saturation_force_n, self.saturation_torque_n_m);
                CanSensor::Sri(SriDriver::new(SriConfig {
                    stream_timeout_us: microseconds(self.stream_timeout_s),
                    pairing_window_us: microseconds(self.pairing_window_s),
                    saturation: [f, f, f, t, t, t],
                }))
            }
        }
    }
}

impl RsiSettings {
    /// The element names.
    pub fn tags(&self) -> Result<Tags, BoardSettingsError> {
        let name = |field, text: &Text| {
            Name::new(text).map_err(|error| BoardSettingsError::Name { field, error })
        };
        let optional = |field, text: &Text| match text.is_empty() {
            true => Ok(None),
            false => name(field, text).map(Some),
        };
        let tags = Tags {
            sentype: name("rsi.sentype", &self.sentype)?,
            correction: name("rsi.correction", &self.correction)?,
            stop: optional("rsi.stop", &self.stop)?,
            poscorr_stat: optional("rsi.poscorr_stat", &self.poscorr_stat)?,
        };
        let clash = |error| BoardSettingsError::Name {
            field: "rsi",
            error,
        };
        tags.validate().map_err(clash)?;
        Ok(tags)
    }

    /// Whether the settings identify the robot, or allow any sender.
    pub fn says_who_is_robot(&self) -> bool {
        !self.robot_ip.is_empty()
    }

    /// The configured address of the robot, if any.
    pub fn robot_ip(&self) -> Result<Option<core::net::IpAddr>, BoardSettingsError> {
        if self.robot_ip.is_empty() || self.robot_ip == ANY_ROBOT {
            return Ok(None);
        }
        self.robot_ip
            .parse()
            .map(Some)
            .map_err(|_| BoardSettingsError::Address { field: ROBOT_IP })
    }

    /// Silence after which the connection is given up, µs.
    pub fn silence_us(&self) -> u64 {
        microseconds(self.silence_s)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_elements_of_a_telegram_are_named_as_it_is_set() {
        let mut rsi = RsiSettings {
            sentype: Text::try_from("Docking").unwrap(),
            correction: Text::try_from("Corr").unwrap(),
            stop: Text::try_from("Stop").unwrap(),
            poscorr_stat: Text::new(),
            ..RsiSettings::default()
        };
        let tags = rsi.tags().unwrap();
        let name = |text| Name::new(text).unwrap();
        assert_eq!(
            (tags.sentype, tags.correction),
            (name("Docking"), name("Corr"))
        );
        assert_eq!((tags.stop, tags.poscorr_stat), (Some(name("Stop")), None));
        rsi.sentype = Text::try_from("1st").unwrap();
        assert!(rsi.tags().is_err());
    }

    #[test]
    fn the_robot_is_who_is_named_or_anybody() {
        let robot_ip = |text| {
            let robot_ip = Text::try_from(text).unwrap();
            let rsi = RsiSettings {
                robot_ip,
                ..RsiSettings::default()
            };
            rsi.robot_ip()
        };
        assert_eq!(robot_ip("192.168.1.10"), Ok(Some([192, 168, 1, 10].into())));
        assert_eq!((robot_ip(""), robot_ip(ANY_ROBOT)), (Ok(None), Ok(None)));
        let field = ROBOT_IP;
        assert_eq!(
            robot_ip("robot"),
            Err(BoardSettingsError::Address { field })
        );
    }
}
