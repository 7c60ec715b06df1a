//! Encoding of the standard messages: common parts, and transforms.

use crate::recording::cdr::Encoder;
use crate::recording::field::EachNumber;
use softdock_control::frames::{Pose, pose_components};

const NS_PER_S: u64 = 1_000_000_000;

/// `std_msgs/Header`.
pub(super) fn header(message: &mut Encoder, time_ns: u64, frame: &str) {
    // ROS 2 has 32 bits for seconds, which last until 2038.
    message.number((time_ns / NS_PER_S) as i32);
    message.number((time_ns % NS_PER_S) as u32);
    message.text(frame);
}

/// `geometry_msgs/Point` or `Vector3`, also several of them.
pub(super) fn vector(message: &mut Encoder, components: &[f64]) {
    components.iter().for_each(|c| message.number(*c));
}

/// `geometry_msgs/Pose` or `Transform`, from position and quaternion (w first; in the message it is last).
pub(super) fn pose(message: &mut Encoder, [x, y, z, w, i, j, k]: [f64; 7]) {
    vector(message, &[x, y, z, i, j, k, w]);
}

/// Pose of a frame in its parent.
pub(super) struct Transform {
    pub(super) parent: &'static str,
    pub(super) child: &'static str,
    /// The child frame in the parent frame.
    pub(super) pose: Pose<f64>,
}

/// `tf2_msgs/TFMessage`.
pub(super) fn transforms(message: &mut Encoder, time_ns: u64, frames: &[Transform]) {
    message.count(frames.len());
    for frame in frames {
        header(message, time_ns, frame.parent);
        message.text(frame.child);
        pose(message, pose_components(&frame.pose));
    }
}
