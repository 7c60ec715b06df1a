//! Where a parameter stands in a model.

/// A spacecraft of the model.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Spacecraft {
    /// Moved by the robot.
    K,
    /// The other one, which the robot does not move.
    Q,
}

/// Place of a parameter in a model. Numbers are axes, or indices of a list.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ParameterId {
    /// Transport delay.
    TransportDelay,
    /// Lag.
    Lag,
    /// Stiffness of a wall.
    WallStiffness(usize),
    /// Damping of a wall.
    WallDamping(usize),
    /// Position of a wall along its normal, as a shift.
    WallPosition(usize),
    /// Stiffness of the guide.
    GuideStiffness,
    /// Damping of the guide.
    GuideDamping,
    /// Centre line of the guide, along one axis.
    GuidePosition(usize),
    /// Number in a docking mechanism: index of the mechanism, JSON pointer of the number.
    Docking(usize, String),
    /// Position of a docking mechanism: its index, axis.
    DockingPosition(usize, usize),
    /// Mass of the tool.
    ToolMass,
    /// Centre of mass of the tool.
    ToolCom(usize),
    /// Diagonal element of the tool's inertia.
    ToolInertia(usize),
    /// Zero of the sensor, one of its six axes.
    Bias(usize),
    /// Position of the sensor.
    SensorPosition(usize),
    /// Orientation of the sensor, as a turn.
    SensorOrientation(usize),
    /// Mass of a spacecraft.
    BodyMass(Spacecraft),
    /// Diagonal element of a spacecraft's inertia.
    BodyInertia(Spacecraft, usize),
    /// Parameter of an added effect: its place in the list, and its name.
    Effect(usize, &'static str),
}

impl ParameterId {
    /// Whether every prediction is linear in a nominal parameter, whatever the others are.
    pub(super) fn is_linear(&self) -> bool {
        matches!(
            self,
            Self::GuideStiffness
                | Self::GuideDamping
                | Self::ToolMass
                | Self::ToolCom(_)
                | Self::ToolInertia(_)
                | Self::Bias(_)
        )
    }
}
