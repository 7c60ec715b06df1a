//! Settings that have passed their checks.

use crate::range::SettingsError;
use crate::robot::RobotInterface;
use crate::settings::Settings;

/// Validated settings for a robot, from which a [`Cycle`](crate::cycle::Cycle) can be built without an error, and therefore in
/// the memory in which it is to stay.
#[derive(Clone, Debug)]
pub struct Checked {
    pub(crate) settings: Settings,
    pub(crate) robot: RobotInterface,
}

impl Checked {
    /// Validates settings. The length of a cycle is taken from the robot, whatever the settings say.
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
