//! A robot whose pose is x y z (m) and A B C (rad), and that takes steps of them in digits.

use softdock_control::frames::{abc_from_orientation, orientation_from_abc, pose_from_components};
use softdock_control::io::{Motion, Output};
use softdock_control::robot::RobotInterface;

/// Digits per mm and degree: so many that rounding is no effect of its own.
const DIGITS: f64 = 1e6;

/// Without a gimbal lock where these tests go.
pub(crate) fn interface(cycle_s: f64) -> RobotInterface {
    RobotInterface {
        cycle_s,
        gimbal_lock: None,
    }
}

/// Position and quaternion of a measured pose.
pub(crate) fn pose([x, y, z, a, b, c]: [f64; 6]) -> Option<[f64; 7]> {
    let q = orientation_from_abc::<f64>(&[a, b, c]);
    Some([x, y, z, q.w, q.i, q.j, q.k])
}

/// Where the robot was sent so far, in digits from the start.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Commanded {
    start_abc: [f64; 3],
    sent: [f64; 6],
}

impl Commanded {
    /// Velocities of x y z A B C in this cycle. `measured`: where displacements count from if they
    /// count anew.
    pub(crate) fn velocity(
        &mut self,
        output: &Output,
        measured: [f64; 6],
        cycle_s: f64,
    ) -> [f64; 6] {
        if output.start {
            let [_, _, _, a, b, c] = measured;
            *self = Self {
                start_abc: [a, b, c],
                sent: [0.0; 6],
            };
        }
        let Motion::Move {
            displacement_m: [x, y, z],
            orientation_wxyz: [w, i, j, k],
            ..
        } = output.motion
        else {
            return [0.0; 6];
        };
        let commanded = pose_from_components::<f64>(&[x, y, z, w, i, j, k]);
        let abc = abc_from_orientation(&commanded.rotation);
        let turned: [f64; 3] = core::array::from_fn(|axis| {
            (abc[axis] - self.start_abc[axis]) * DIGITS * 180.0 / core::f64::consts::PI
        });
        let metres = |way: f64| way * 1e3 * DIGITS;
        let [a, b, c] = turned;
        let next = [metres(x), metres(y), metres(z), a, b, c].map(f64::round);
        let before = core::mem::replace(&mut self.sent, next);
        let unit = [1e-3 / DIGITS, (1.0 / DIGITS).to_radians()];
        core::array::from_fn(|axis| (next[axis] - before[axis]) * unit[axis / 3] / cycle_s)
    }
}
