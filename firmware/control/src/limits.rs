//! Bounds of the correction and of the load. A clamp is flagged; one that lasts latches a fault.
//!
//! The limits protect tool and process. They are not a safety function: that is the robot's own
//! safety controller.

use crate::frames::{Twist, Wrench, small_rotation, vector};
use crate::scalar::Scalar;
use nalgebra::{UnitQuaternion, Vector3};

crate::described! {
/// Bounds, all symmetric.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields, default))]
pub struct LimitSettings: "limits" {
    /// Largest translation per cycle, m.
    pub step_m: f64 = 0.002 => 1e-6..=0.02,
    /// Largest rotation per cycle, rad.
    pub step_rad: f64 = 0.005 => 1e-6..=0.05,
    /// Largest speed, m/s.
    pub speed_m_s: f64 = 0.3 => 1e-4..=5.0,
    /// Largest angular speed, rad/s.
    pub speed_rad_s: f64 = 0.5 => 1e-4..=5.0,
    /// Largest acceleration, m/s².
    pub acceleration_m_s2: f64 = 10.0 => 1e-3..=1e3,
    /// Largest angular acceleration, rad/s².
    pub acceleration_rad_s2: f64 = 20.0 => 1e-3..=1e3,
    /// Half-widths of the box around the position in which the robot began, axes of C, m. Smaller than the robot's
    /// own limits, which may clamp silently (POSCORR).
    pub box_m: [f64; 3] = [0.25; 3] => 1e-4..=5.0,
    /// Largest rotation away from the orientation in which the robot began, rad.
    pub box_rad: f64 = 0.35 => 1e-3..=1.5,
    /// Contact force that latches a fault, N.
    pub force_n: f64 = 3000.0 => 1.0..=1e5,
    /// Contact torque about M that latches a fault, N·m.
    pub torque_n_m: f64 = 500.0 => 0.1..=1e5,
    /// Cycles in a row with any clamp that latch a fault.
    pub clamp_fault_cycles: u32 = 25 => 1.0..=1e4,
    /// An overload also asks the robot to stop (`<Stop>1</Stop>`).
    pub stop_on_overload: bool = true,
}
}

crate::flags! {
/// Which limits acted in a cycle.
pub struct LimitFlags {
    /// Speed or step.
    0 => SPEED,
    /// Acceleration.
    1 => ACCELERATION,
    /// Box around the pose in which the robot began, or B near ±90°.
    2 => BOX,
    /// The robot reports that it clamps; the model's integration is frozen.
    3 => ROBOT_CLAMP,
    /// The sensor is stale; the rate is ramped down.
    4 => SENSOR_STALE,
    /// The model is at the edge of its declared ranges, where it saturates.
    5 => MODEL,
    /// A measured number was beyond its declared range and was taken at the edge: the wrench, or
    /// the motion of the robot.
    6 => MEASURED,
}
}

/// Fraction of the acceleration limit with which an axis brakes: the end of [`Limits::stopping_speed`] takes twice as much, and
/// three axes may brake at once: 2 √3 / 4 is less than 1.
const BRAKING_SHARE: f64 = 0.25;

/// The limits, ready to run.
#[derive(Clone, Debug)]
pub struct Limits<S: Scalar> {
    ts: S,
    /// Smaller of speed and step per cycle, m/s and rad/s.
    speed: [S; 2],
    /// Largest change of velocity per cycle.
    change: [S; 2],
    /// Decelerations with which a stop before the edge of the box is planned, see [`Self::stopping_speed`].
    braking: [S; 2],
    box_m: Vector3<S>,
    box_rad: S,
    force_n: S,
    torque_n_m: S,
}

impl<S: Scalar> Limits<S> {
    /// From validated settings and the cycle in s.
    pub fn new(settings: &LimitSettings, cycle_s: f64) -> Self {
        Self {
            ts: S::of(cycle_s),
            speed: [
                S::of(settings.speed_m_s.min(settings.step_m / cycle_s)),
                S::of(settings.speed_rad_s.min(settings.step_rad / cycle_s)),
            ],
            change: [
                S::of(settings.acceleration_m_s2 * cycle_s),
                S::of(settings.acceleration_rad_s2 * cycle_s),
            ],
            braking: [
                S::of(settings.acceleration_m_s2 * BRAKING_SHARE),
                S::of(settings.acceleration_rad_s2 * BRAKING_SHARE),
            ],
            box_m: vector(&settings.box_m),
            box_rad: S::of(settings.box_rad),
            force_n: S::of(settings.force_n),
            torque_n_m: S::of(settings.torque_n_m),
        }
    }

    /// The velocity that may be sent: limited in speed, then by the distance that is left to stop before the edge of the box,
    /// then in its change since `last`, and finally by the edge itself. `displacement` and `turn` lead from the centre of the box
    /// to the commanded pose.
    pub fn apply(
        &self,
        wanted: &Twist<S>,
        last: &Twist<S>,
        displacement: &Vector3<S>,
        turn: &UnitQuaternion<S>,
    ) -> (Twist<S>, LimitFlags) {
        let mut flags = LimitFlags::default();
        let mut capped = Twist {
            linear: capped(&wanted.linear, self.speed[0], LimitFlags::SPEED, &mut flags),
            angular: capped(
                &wanted.angular,
                self.speed[1],
                LimitFlags::SPEED,
                &mut flags,
            ),
        };
        self.brake_before_edge(&mut capped, displacement, turn, &mut flags);
        let change = capped - *last;
        let acceleration = LimitFlags::ACCELERATION;
        let mut sent = *last
            + Twist {
                linear: self::capped(&change.linear, self.change[0], acceleration, &mut flags),
                angular: self::capped(&change.angular, self.change[1], acceleration, &mut flags),
            };
        self.keep_in_box(&mut sent, displacement, turn, &mut flags);
        (sent, flags)
    }

    /// Cycles in which a velocity comes to rest with less than the largest acceleration.
    pub fn cycles_to_rest(&self, velocity: &Twist<S>) -> u32 {
        let cycles = |v: &Vector3<S>, change: S| (size(v).get() / change.get()) as u32;
        let linear = cycles(&velocity.linear, self.change[0]);
        linear
            .max(cycles(&velocity.angular, self.change[1]))
            .saturating_add(1)
    }

    /// Caps the speed towards an edge to `√(2 a d)` over the distance d that is left.
    fn brake_before_edge(
        &self,
        wanted: &mut Twist<S>,
        displacement: &Vector3<S>,
        turn: &UnitQuaternion<S>,
        flags: &mut LimitFlags,
    ) {
        for i in 0..3 {
            let v = wanted.linear[i];
            let left = if v < S::zero() {
                self.box_m[i] + displacement[i]
            } else {
                self.box_m[i] - displacement[i]
            };
            let fastest = self.stopping_speed(self.braking[0], left);
            if v.abs() > fastest {
                wanted.linear[i] = v.clamp(-fastest, fastest);
                flags.set(LimitFlags::BOX);
            }
        }
        // A rotation back towards the centre of the box is not limited.
        let outward = turn.imag().dot(&wanted.angular) * turn.w > S::zero();
        let fastest = self.stopping_speed(self.braking[1], self.box_rad - angle(turn));
        if outward && wanted.angular.amax() > fastest {
            wanted.angular = capped(&wanted.angular, fastest, LimitFlags::BOX, flags);
        }
    }

    /// Largest speed at a distance d from the edge: `√(2 a d)`, and near the edge half of the distance per cycle, so that whole
    /// cycles do not overshoot. Zero at or beyond the edge.
    fn stopping_speed(&self, deceleration: S, distance: S) -> S {
        if distance <= S::zero() {
            return S::zero();
        }
        let (two, half) = (S::of(2.0), S::of(0.5));
        (deceleration * distance * two)
            .sqrt()
            .min(distance * half / self.ts)
    }

    /// The final limit: no motion passes the edge, and what is beyond it already does not move further out.
    fn keep_in_box(
        &self,
        sent: &mut Twist<S>,
        displacement: &Vector3<S>,
        turn: &UnitQuaternion<S>,
        flags: &mut LimitFlags,
    ) {
        for i in 0..3 {
            let (now, edge) = (displacement[i], self.box_m[i]);
            let next = now + sent.linear[i] * self.ts;
            if next.abs() > edge && next.abs() > now.abs() {
                let kept = if now.abs() < edge {
                    next.clamp(-edge, edge)
                } else {
                    now
                };
                sent.linear[i] = (kept - now) / self.ts;
                flags.set(LimitFlags::BOX);
            }
        }
        let next = turn.quaternion() * small_rotation(&(sent.angular * self.ts)).quaternion();
        let (now, next) = (angle(turn), angle(&UnitQuaternion::new_unchecked(next)));
        if next > self.box_rad && next > now {
            sent.angular = Vector3::zeros();
            flags.set(LimitFlags::BOX);
        }
    }

    /// The force or torque that exceeds its limit: (limit, value).
    pub fn overload(&self, at_m: &Wrench<S>) -> Option<(f64, f64)> {
        load_beyond(at_m, self.force_n, self.torque_n_m)
    }
}

/// Force or torque, whichever is beyond its limit: (limit, value).
pub fn load_beyond<S: Scalar>(load: &Wrench<S>, force_n: S, torque_n_m: S) -> Option<(f64, f64)> {
    let beyond = |v: &Vector3<S>, limit: S| {
        let size = size(v);
        (size > limit).then(|| (limit.get(), size.get()))
    };
    beyond(&load.force, force_n).or_else(|| beyond(&load.torque, torque_n_m))
}

/// Length of a vector. It is scaled by the largest component, as squares might leave the range of fixed point.
fn size<S: Scalar>(v: &Vector3<S>) -> S {
    let largest = v.amax();
    if largest == S::zero() {
        largest
    } else {
        (v / largest).norm() * largest
    }
}

/// Angle of a rotation, 0 to π rad.
pub(crate) fn angle<S: Scalar>(turn: &UnitQuaternion<S>) -> S {
    let sine = turn.imag();
    let sine = size(&Vector3::new(sine.x, sine.y, sine.z));
    S::angle_of(sine, turn.w.abs()) * S::of(2.0)
}

/// A vector shortened to `limit`, with the flag set if it was.
fn capped<S: Scalar>(
    v: &Vector3<S>,
    limit: S,
    flag: LimitFlags,
    flags: &mut LimitFlags,
) -> Vector3<S> {
    // Scaling by the largest component first keeps the squares within the range of fixed point,
    // where those of a slow rig's limits would be zero.
    let largest = v.amax();
    if largest + largest <= limit {
        return *v;
    }
    let direction = v / largest;
    let longest = limit / direction.norm();
    if largest <= longest {
        return *v;
    }
    flags.set(flag);
    direction * longest
}

#[cfg(test)]
mod tests;
