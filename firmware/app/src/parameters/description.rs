//! Descriptions of the settings: the doc comments of their fields.

use crate::settings::{BoardSettings, CanSettings, EtherCatSettings, NetworkSettings, RsiSettings};
use softdock_control::delay::DelaySettings;
use softdock_control::described::Description;
use softdock_control::jog::JogSettings;
use softdock_control::limits::LimitSettings;
use softdock_control::settings::{
    BodySettings, FrameSettings, RobotSettings, SensorSettings, Settings, StartSettings,
};

/// All structs of settings but those of the delay compensation. A test says which one is missing.
const ALL: &[Description] = &[
    BoardSettings::DESCRIPTION,
    BodySettings::DESCRIPTION,
    CanSettings::DESCRIPTION,
    EtherCatSettings::DESCRIPTION,
    FrameSettings::DESCRIPTION,
    JogSettings::DESCRIPTION,
    LimitSettings::DESCRIPTION,
    NetworkSettings::DESCRIPTION,
    RobotSettings::DESCRIPTION,
    RsiSettings::DESCRIPTION,
    SensorSettings::DESCRIPTION,
    Settings::DESCRIPTION,
    StartSettings::DESCRIPTION,
];

/// The doc comment of a struct's field; empty: none.
pub(super) fn of(owner: &str, field: &str) -> &'static str {
    ALL.iter()
        .chain(DelaySettings::DESCRIPTIONS)
        .find(|description| description.name == owner)
        .and_then(|description| description.fields.iter().find(|(name, _)| *name == field))
        .map_or("", |(_, text)| text)
}
