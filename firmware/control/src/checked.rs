//! Settings that have passed their checks.

use crate::range::SettingsError;
use crate::robot::RobotInterface;
use crate::settings::Settings;

/// Settings for a robot, of which a [`Cycle`](crate::cycle::Cycle) can be built without an error, and
/// therefore where it is to stay.
#[derive(Clone, Debug)]
pub struct Checked {
    pub(crate) settings: Settings,
    pub(crate) robot: RobotInterface,
}

impl Checked {
    /// The length of a cycle is the robot's, whatever the settings say.
    ///
    /// # Errors
    /// A setting is outside of its range.
    pub fn new(settings: &Settings, robot: &RobotInterface) -> Result<Self, SettingsError> {
        let mut settings = settings.clone();
        settings.robot.cycle_s = robot.cycle_s;
        settings.validate()?;
        Ok(Self {
            settings,
            robot: *robot,
        })
    }
}
