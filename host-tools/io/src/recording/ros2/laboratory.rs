//! Poses of the frames of a run in the laboratory. The names are those of `softdock_control::frames`.
//!
//! ```text
//! C  the robot's base
//! ├─ M  the moved point on the flange, as measured
//! │  └─ S  the sensor
//! └─ Q  the spacecraft that stands in the laboratory
//!    ├─ P  its docking surface
//!    └─ K  the moved spacecraft, as the model sees it: the robot is late by what lies between K and M
//!       └─ J  its docking surface
//! ```

use super::messages::Transform;
use softdock_control::frames::{self, Pose, pose_from_components};
use softdock_control::io::Trace;
use softdock_control::modes::Mode;
use softdock_control::settings::Settings;

/// The frames as far as a recording determines them.
pub(super) struct Laboratory {
    /// None for logs of other programs.
    settings: Option<Settings>,
    /// Q in C. It is determined from the first pose, and again whenever the rig is armed, as its run begins there.
    c_from_q: Option<Pose<f64>>,
    /// Mode in the cycle before.
    mode: Option<Mode>,
}

impl Laboratory {
    pub(super) fn new(settings: Option<Settings>) -> Self {
        Self {
            settings,
            c_from_q: None,
            mode: None,
        }
    }

    pub(super) fn settings(&self) -> Option<&Settings> {
        self.settings.as_ref()
    }

    /// Takes the next cycle, in order. Returns whether the fixed frames have to be published.
    pub(super) fn see(&mut self, trace: &Trace) -> bool {
        let before = self.mode.replace(trace.mode);
        let is_armed = trace.mode == Mode::Armed && before != Some(Mode::Armed);
        if self.c_from_q.is_some() && !is_armed {
            return false;
        }
        // K is at M at this instant.
        let stands = known(&trace.pose)
            .zip(q_from_k(trace))
            .map(|(c_from_m, q_from_k)| c_from_m * q_from_k.inverse());
        self.c_from_q = stands.or(self.c_from_q);
        stands.is_some() || before.is_none()
    }

    /// Frames that do not move.
    pub(super) fn fixed(&self) -> Vec<Transform> {
        let mut fixed = Vec::new();
        let mut add = |parent, child, pose| {
            fixed.push(Transform {
                parent,
                child,
                pose,
            });
        };
        if let Some(c_from_q) = self.c_from_q {
            add("C", "Q", c_from_q);
        }
        if let Some(Settings { sensor, frames, .. }) = &self.settings {
            let (position, orientation) = (&sensor.position_m, &sensor.orientation_wxyz);
            add("M", "S", frames::pose(position, orientation));
            let (position, orientation) = (&frames.p_position_m, &frames.p_orientation_wxyz);
            add("Q", "P", frames::pose(position, orientation));
            let (position, orientation) = (&frames.j_position_m, &frames.j_orientation_wxyz);
            add("K", "J", frames::pose(position, orientation));
        }
        fixed
    }

    /// Frames that move.
    pub(super) fn moving(&self, trace: &Trace) -> Vec<Transform> {
        let m = known(&trace.pose).map(|pose| ("C", "M", pose));
        let k = q_from_k(trace).map(|pose| ("Q", "K", pose));
        let moving = [m, k].into_iter().flatten();
        moving
            .map(|(parent, child, pose)| Transform {
                parent,
                child,
                pose,
            })
            .collect()
    }
}

/// K as Q sees it, if the model was recorded.
fn q_from_k(trace: &Trace) -> Option<Pose<f64>> {
    Some(known(&trace.body_q.pose)?.inverse() * known(&trace.body_k.pose)?)
}

/// The pose, if there is one.
fn known(pose: &[f64; 7]) -> Option<Pose<f64>> {
    let [.., w, i, j, k] = *pose;
    let is_one = pose.iter().all(|number| number.is_finite()) && [w, i, j, k] != [0.0; 4];
    is_one.then(|| pose_from_components(pose))
}
