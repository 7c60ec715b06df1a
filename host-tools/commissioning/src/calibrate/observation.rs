//! What was seen: wrenches, and how the load moved.

use nalgebra::{UnitQuaternion, Vector3};
use softdock_control::frames::Wrench;

/// One wrench and how the load moved.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Observation {
    /// Orientation of S in C.
    pub c_from_s: UnitQuaternion<f64>,
    /// Acceleration of the sensor's origin, angular velocity and acceleration, axes of S.
    pub acceleration: Vector3<f64>,
    /// See `acceleration`.
    pub angular_velocity: Vector3<f64>,
    /// See `acceleration`.
    pub angular_acceleration: Vector3<f64>,
    /// Raw wrench in S.
    pub wrench: Wrench<f64>,
}

/// Observations that are kept or left out together: a pose, or a part of a motion.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Group {
    /// Begin and end, s.
    pub time_s: [f64; 2],
    /// Number of the pose, from 1, if it is one.
    pub pose: Option<usize>,
    /// What was seen.
    pub observations: Vec<Observation>,
}

impl Observation {
    /// At rest.
    pub(super) fn at_rest(c_from_s: UnitQuaternion<f64>, wrench: Wrench<f64>) -> Self {
        Self {
            c_from_s,
            acceleration: Vector3::zeros(),
            angular_velocity: Vector3::zeros(),
            angular_acceleration: Vector3::zeros(),
            wrench,
        }
    }
}
