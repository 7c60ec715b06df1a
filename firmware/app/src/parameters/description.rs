//! What the settings mean: the doc comments of their fields.

use crate::settings::{BoardSettings, CanSettings, NetworkSettings, RsiSettings};
use softdock_control::delay::DelaySettings;
use softdock_control::delay::actuator::ActuatorSettings;
use softdock_control::delay::ats::AtsSettings;
use softdock_control::delay::lead::LeadSettings;
use softdock_control::delay::passivity::PassivitySettings;
use softdock_control::delay::polynomial::PolynomialSettings;
use softdock_control::delay::predictor::PredictorSettings;
use softdock_control::delay::seed::{SeedCoefficients, SeedSettings};
use softdock_control::delay::smith::SmithSettings;
use softdock_control::described::Description;
use softdock_control::jog::JogSettings;
use softdock_control::limits::LimitSettings;
use softdock_control::settings::{
    BodySettings, FrameSettings, RobotSettings, SensorSettings, Settings, StartSettings,
};

/// All structs of settings. A test says which one is missing.
const ALL: &[Description] = &[
    ActuatorSettings::DESCRIPTION,
    AtsSettings::DESCRIPTION,
    BoardSettings::DESCRIPTION,
    BodySettings::DESCRIPTION,
    CanSettings::DESCRIPTION,
    DelaySettings::DESCRIPTION,
    FrameSettings::DESCRIPTION,
    JogSettings::DESCRIPTION,
    LeadSettings::DESCRIPTION,
    LimitSettings::DESCRIPTION,
    NetworkSettings::DESCRIPTION,
    PassivitySettings::DESCRIPTION,
    PolynomialSettings::DESCRIPTION,
    PredictorSettings::DESCRIPTION,
    RobotSettings::DESCRIPTION,
    RsiSettings::DESCRIPTION,
    SeedCoefficients::DESCRIPTION,
    SeedSettings::DESCRIPTION,
    SensorSettings::DESCRIPTION,
    Settings::DESCRIPTION,
    SmithSettings::DESCRIPTION,
    StartSettings::DESCRIPTION,
];

/// The doc comment of a struct's field; empty: none.
pub(super) fn of(owner: &str, field: &str) -> &'static str {
    ALL.iter()
        .find(|description| description.name == owner)
        .and_then(|description| description.fields.iter().find(|(name, _)| *name == field))
        .map_or("", |(_, text)| text)
}
