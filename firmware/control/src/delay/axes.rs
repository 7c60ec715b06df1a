//! Six components of a motion in one array: the form in which the laws per component work.

use crate::frames::Twist;
use crate::scalar::Scalar;

/// Fastest component that a law deals with, m/s or rad/s: what the model itself is limited to.
/// Beyond it a law saturates, so that fixed point cannot wrap.
const FASTEST: f64 = 100.0;

/// X Y Z, then the three rotations.
pub(super) fn components<S: Scalar>(twist: &Twist<S>) -> [S; 6] {
    let (v, w) = (&twist.linear, &twist.angular);
    [v.x, v.y, v.z, w.x, w.y, w.z].map(saturated)
}

/// The inverse of [`components`].
pub(super) fn twist<S: Scalar>(components: [S; 6]) -> Twist<S> {
    let [x, y, z, a, b, c] = components;
    Twist {
        linear: nalgebra::Vector3::new(x, y, z),
        angular: nalgebra::Vector3::new(a, b, c),
    }
}

/// A velocity within the range that a law deals with.
pub(super) fn saturated<S: Scalar>(v: S) -> S {
    v.clamp(S::of(-FASTEST), S::of(FASTEST))
}
