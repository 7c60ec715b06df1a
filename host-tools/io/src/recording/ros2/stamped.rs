//! Wrenches, poses and velocities as messages with time and frame.
//!
//! In a recording the linear part of a velocity is in axes of C, the angular part in axes of the body. A `TwistStamped` has
//! one frame, so the angular part is rotated into C.

use super::definitions::{Definition, POSE_STAMPED, TWIST_STAMPED, WRENCH_STAMPED};
use super::messages::{header, pose, vector};
use crate::recording::cdr::Encoder;
use nalgebra::Vector3;
use softdock_app::record::CycleRecord;
use softdock_control::frames;

/// A topic of standard messages with time and frame.
pub(super) struct Stamped {
    pub(super) topic: &'static str,
    /// Frame in whose axes the numbers are.
    frame: &'static str,
    quantity: Quantity,
}

enum Quantity {
    /// Force (N) and torque (N·m).
    Wrench(fn(&CycleRecord) -> [f64; 6]),
    /// Position (m), quaternion (w first).
    Pose(fn(&CycleRecord) -> [f64; 7]),
    /// Velocity (m/s) in the frame, angular velocity (rad/s) in the axes of the body, and the body's pose.
    Twist(fn(&CycleRecord) -> ([f64; 6], [f64; 7])),
}

const fn stamped(topic: &'static str, frame: &'static str, quantity: Quantity) -> Stamped {
    Stamped {
        topic,
        frame,
        quantity,
    }
}

/// All stamped topics.
pub(super) static ALL: [Stamped; 9] = [
    stamped(
        "/rig/wrench",
        "M",
        Quantity::Wrench(|c| c.trace.wrench_at_m),
    ),
    stamped(
        "/rig/sensor_wrench",
        "S",
        Quantity::Wrench(|c| c.inputs.sensor.wrench),
    ),
    stamped("/rig/pose", "C", Quantity::Pose(|c| c.trace.pose)),
    stamped(
        "/rig/command_pose",
        "C",
        Quantity::Pose(|c| c.trace.command_pose),
    ),
    stamped(
        "/rig/executed_velocity",
        "C",
        Quantity::Twist(|c| (c.trace.executed_velocity, c.trace.pose)),
    ),
    stamped(
        "/rig/sent_velocity",
        "C",
        Quantity::Twist(|c| (c.trace.sent_velocity, c.trace.pose)),
    ),
    stamped(
        "/rig/model_velocity",
        "C",
        Quantity::Twist(|c| (c.trace.model_velocity, c.trace.pose)),
    ),
    stamped(
        "/docking/pose",
        "P",
        Quantity::Pose(|c| c.trace.docking.pose),
    ),
    stamped(
        "/docking/velocity",
        "P",
        Quantity::Twist(|c| (c.trace.docking.velocity, c.trace.docking.pose)),
    ),
];

impl Stamped {
    pub(super) fn definition(&self) -> &'static Definition {
        match self.quantity {
            Quantity::Wrench(_) => &WRENCH_STAMPED,
            Quantity::Pose(_) => &POSE_STAMPED,
            Quantity::Twist(_) => &TWIST_STAMPED,
        }
    }

    /// Whether the cycle has this quantity: one that a log lacks is zero throughout.
    pub(super) fn is_known(&self, cycle: &CycleRecord) -> bool {
        let known = |numbers: &[f64]| numbers.iter().any(|number| *number != 0.0);
        match self.quantity {
            Quantity::Wrench(of) => known(&of(cycle)),
            Quantity::Pose(of) => known(&of(cycle)[3..]),
            Quantity::Twist(of) => known(&of(cycle).0),
        }
    }

    pub(super) fn write(&self, message: &mut Encoder, time_ns: u64, cycle: &CycleRecord) {
        header(message, time_ns, self.frame);
        match self.quantity {
            Quantity::Wrench(of) => vector(message, &of(cycle)),
            Quantity::Pose(of) => pose(message, of(cycle)),
            Quantity::Twist(of) => {
                let (velocity, body) = of(cycle);
                vector(message, &in_one_frame(velocity, &body));
            }
        }
    }
}

/// The velocity with its angular part rotated into the axes of the linear part.
fn in_one_frame([x, y, z, rx, ry, rz]: [f64; 6], body: &[f64; 7]) -> [f64; 6] {
    let [_, _, _, w, i, j, k] = *body;
    let turned = frames::pose::<f64>(&[0.0; 3], &[w, i, j, k]).rotation * Vector3::new(rx, ry, rz);
    [x, y, z, turned.x, turned.y, turned.z]
}
