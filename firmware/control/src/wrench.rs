//! Raw sensor wrench -> gravity, zero and tool inertia removed -> wrench at M (section 3.2).
//!
//! The sensor reads the load's action on it: contact + tool weight − tool mass × acceleration.

use crate::frames::{self, Pose, Twist, Wrench, matrix, saturated, vector};
use crate::scalar::Scalar;
use crate::settings::{DynamicCompensation, SensorSettings};
use nalgebra::{Matrix3, UnitQuaternion, Vector3};

/// Largest velocity that the estimator accepts, m/s and rad/s: a jump of the measured pose, as when the robot restarts, must not
/// leave the range of fixed point as an acceleration.
const FASTEST: f64 = 10.0;
/// Largest acceleration of the estimator, m/s² and rad/s²: its gains hold for steps of one length, and gaps that alternate with
/// cycles would make the estimate grow without bound.
const LARGEST_ACCELERATION: f64 = 1.0e3;
/// Largest acceleration of the tool's centre of mass that is taken, m/s² (100 g), likewise.
const LARGEST_M_S2: f64 = 1.0e3;

/// Compensation of the sensor wrench, ready to run.
#[derive(Clone, Debug)]
pub struct Compensation<S: Scalar> {
    m_from_s: Pose<S>,
    bias: Wrench<S>,
    gravity: Vector3<S>,
    gravity_torque: Vector3<S>,
    mass: S,
    com: Vector3<S>,
    inertia: Matrix3<S>,
    /// +1 load reaction, −1 as printed; `None`: switched off.
    inertial_sign: Option<S>,
}

/// A compensated wrench and what was removed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Compensated<S: Scalar> {
    /// Weight of the tool, in S.
    pub gravity: Wrench<S>,
    /// Inertial wrench of the tool, in S (zero when switched off).
    pub inertial: Wrench<S>,
    /// Wrench of the contact, in S.
    pub contact_in_s: Wrench<S>,
    /// Wrench of the contact about M, axes of M.
    pub at_m: Wrench<S>,
}

/// Motion of M from measurement: velocity and acceleration (linear in C, angular in M).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion<S: Scalar> {
    /// m/s in C, rad/s in M.
    pub velocity: Twist<S>,
    /// m/s² in C, rad/s² in M.
    pub acceleration: Twist<S>,
}

impl<S: Scalar> Compensation<S> {
    /// From validated settings.
    pub fn new(settings: &SensorSettings) -> Self {
        Self {
            m_from_s: frames::pose(&settings.position_m, &settings.orientation_wxyz),
            bias: Wrench::of(&settings.bias),
            gravity: vector(&settings.gravity_m_s2),
            gravity_torque: vector(&settings.gravity_torque_n_m),
            mass: S::of(settings.tool_mass_kg),
            com: vector(&settings.tool_com_m),
            inertia: matrix(&settings.tool_inertia_kg_m2),
            inertial_sign: match settings.dynamic_compensation {
                DynamicCompensation::Off => None,
                DynamicCompensation::LoadReaction => Some(S::one()),
                DynamicCompensation::Printed => Some(-S::one()),
            },
        }
    }

    /// Adds to the zero-load reading.
    pub fn shift_bias(&mut self, by: &Wrench<S>) {
        self.bias = self.bias + *by;
    }

    /// The tool's weight in S: `R G^G` and `R T_G + com × R G^G` (A13: G^S turns with the pose).
    pub fn gravity_wrench(&self, c_from_m: &UnitQuaternion<S>) -> Wrench<S> {
        let s_from_c = (c_from_m * self.m_from_s.rotation).inverse();
        let force = s_from_c * self.gravity * self.mass;
        let torque = s_from_c * self.gravity_torque + self.com.cross(&force);
        Wrench { force, torque }
    }

    /// What the sensor reads because the tool accelerates: `−m a`, `−(I α + ω × I ω) − com × m a`,
    /// with a of the tool's centre of mass, in S.
    pub fn inertial_wrench(&self, c_from_m: &UnitQuaternion<S>, motion: &Motion<S>) -> Wrench<S> {
        let s_from_m = self.m_from_s.rotation.inverse();
        let omega = motion.velocity.angular;
        let alpha = motion.acceleration.angular;
        let arm = self.m_from_s.translation.vector + self.m_from_s.rotation * self.com;
        let a_m = c_from_m.inverse() * motion.acceleration.linear
            + alpha.cross(&arm)
            + omega.cross(&omega.cross(&arm));
        let a_m = saturated(&a_m, LARGEST_M_S2);
        let force = s_from_m * a_m * -self.mass;
        let (omega, alpha) = (s_from_m * omega, s_from_m * alpha);
        let spin = self.inertia * alpha + omega.cross(&(self.inertia * omega));
        Wrench {
            force,
            torque: self.com.cross(&force) - spin,
        }
    }

    /// The contact wrench at M from the raw reading in S (N, N·m).
    pub fn compensate(
        &self,
        raw: &Wrench<S>,
        c_from_m: &UnitQuaternion<S>,
        motion: &Motion<S>,
    ) -> Compensated<S> {
        let gravity = self.gravity_wrench(c_from_m);
        let inertial = match self.inertial_sign {
            Some(sign) => self.inertial_wrench(c_from_m, motion) * sign,
            None => Wrench::zero(),
        };
        let contact = *raw - gravity - self.bias - inertial;
        Compensated {
            gravity,
            inertial,
            contact_in_s: contact,
            at_m: contact.transferred(&self.m_from_s),
        }
    }
}

/// Most cycles between two poses over which the estimate is extrapolated.
const LONGEST_GAP: u32 = 100;

/// Velocity and acceleration of M from its measured pose, by a critically damped (fading-memory,
/// g-h) filter on the pose increments; both poles at `exp(−2π f Ts)`. The acceleration lags by
/// about 1/(π f).
#[derive(Clone, Debug)]
pub struct MotionEstimator<S: Scalar> {
    ts: S,
    g: S,
    h: S,
    last: Option<Pose<S>>,
    /// Cycles since the last pose.
    cycles: u32,
    raw_velocity: Twist<S>,
    motion: Motion<S>,
    saturates: bool,
}

impl<S: Scalar> MotionEstimator<S> {
    /// From a bandwidth in Hz and the cycle in s.
    pub fn new(bandwidth_hz: f64, cycle_s: f64) -> Self {
        let theta = nalgebra::ComplexField::exp(-core::f64::consts::TAU * bandwidth_hz * cycle_s);
        Self {
            ts: S::of(cycle_s),
            g: S::of(1.0 - theta * theta),
            h: S::of((1.0 - theta) * (1.0 - theta)),
            last: None,
            cycles: 0,
            raw_velocity: Twist::zero(),
            motion: Motion {
                velocity: Twist::zero(),
                acceleration: Twist::zero(),
            },
            saturates: false,
        }
    }

    /// Forgets the past; the next pose is the first.
    pub fn reset(&mut self) {
        self.last = None;
        self.cycles = 0;
        self.raw_velocity = Twist::zero();
        self.motion = Motion {
            velocity: Twist::zero(),
            acceleration: Twist::zero(),
        };
        self.saturates = false;
    }

    /// Whether a pose was taken since the beginning.
    pub fn has_pose(&self) -> bool {
        self.last.is_some()
    }

    /// The last pose that was taken (identity before the first).
    pub fn last_pose(&self) -> Pose<S> {
        self.last.unwrap_or_else(Pose::identity)
    }

    /// Velocity and acceleration as estimated from the poses so far.
    pub fn motion(&self) -> Motion<S> {
        self.motion
    }

    /// Difference of the last two poses over the time between them.
    pub fn raw_velocity(&self) -> Twist<S> {
        self.raw_velocity
    }

    /// Whether the last pose implies a motion that no robot makes: the estimate is at the limit of its range.
    pub fn saturates(&self) -> bool {
        self.saturates
    }

    /// Takes this cycle's measured pose of M in C, `cycles` after the last telegram; a telegram
    /// without a pose only lets time pass.
    pub fn update(&mut self, c_from_m: Option<&Pose<S>>, cycles: u32) {
        // After a longer gap the estimate is worthless; the bound keeps it within fixed point.
        self.cycles = self.cycles.saturating_add(cycles).min(LONGEST_GAP);
        let Some(c_from_m) = c_from_m else { return };
        let elapsed = self.ts * S::of(f64::from(core::mem::take(&mut self.cycles)));
        if let Some(last) = self.last {
            let turn = (last.rotation.inverse() * c_from_m.rotation)
                .quaternion()
                .imag();
            let raw = Twist {
                linear: (c_from_m.translation.vector - last.translation.vector) / elapsed,
                // The rotation vector of a small turn is twice the imaginary part.
                angular: turn * S::of(2.0) / elapsed,
            };
            self.raw_velocity = raw;
            let predicted = self.motion.velocity + self.motion.acceleration * elapsed;
            let believed = raw.map(|v| saturated(v, FASTEST));
            let error = believed - predicted;
            let velocity = predicted + error * self.g;
            let acceleration = self.motion.acceleration + error.map(|v| v / elapsed) * self.h;
            self.motion = Motion {
                velocity: velocity.map(|v| saturated(v, FASTEST)),
                acceleration: acceleration.map(|a| saturated(a, LARGEST_ACCELERATION)),
            };
            self.saturates = raw != believed
                || self.motion.velocity != velocity
                || self.motion.acceleration != acceleration;
        }
        self.last = Some(*c_from_m);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn tool() -> SensorSettings {
        SensorSettings {
            position_m: [0.0, 0.02, -0.3],
            orientation_wxyz: [0.9, 0.1, -0.2, 0.3],
            tool_mass_kg: 12.0,
            tool_com_m: [0.01, -0.02, 0.09],
            tool_inertia_kg_m2: [[0.2, 0.01, 0.0], [0.01, 0.3, 0.0], [0.0, 0.0, 0.1]],
            bias: [3.0, -2.0, 1.0, 0.1, 0.2, -0.3],
            dynamic_compensation: DynamicCompensation::LoadReaction,
            ..SensorSettings::default()
        }
    }

    proptest! {
        /// Known answer: in any pose a resting tool reads its weight at its centre of mass.
        #[test]
        fn weight_and_bias_leave_nothing(abc in prop::array::uniform3(-3.0..3.0f64)) {
            let settings = tool();
            let compensation = Compensation::<f64>::new(&settings);
            let c_from_m = frames::orientation_from_abc(&abc);
            let s_from_c = (c_from_m * frames::pose::<f64>(&[0.0; 3], &settings.orientation_wxyz)
                .rotation).inverse();
            let weight = s_from_c * Vector3::new(0.0, 0.0, -9.81 * 12.0);
            let lever = Vector3::new(0.01, -0.02, 0.09);
            let raw = Wrench { force: weight, torque: lever.cross(&weight) }
                + Wrench::of(&settings.bias);
            let still = Motion { velocity: Twist::zero(), acceleration: Twist::zero() };
            let left = compensation.compensate(&raw, &c_from_m, &still).at_m.get();
            prop_assert!(left.iter().all(|v| v.abs() < 1e-10), "{left:?}");
        }
    }

    #[test]
    fn estimator_finds_a_constant_acceleration() {
        let mut estimator = MotionEstimator::<f64>::new(20.0, 0.004);
        for n in 0..500 {
            let t = f64::from(n) * 0.004;
            let rotation =
                UnitQuaternion::from_scaled_axis(Vector3::new(0.0, 0.5 * 0.2 * t * t, 0.0));
            let pose = Pose::from_parts(Vector3::new(0.5 * 0.3 * t * t, 0.0, 0.1).into(), rotation);
            estimator.update(Some(&pose), 1);
        }
        let acceleration = estimator.motion().acceleration.get();
        assert!((acceleration[0] - 0.3).abs() < 1e-6, "{acceleration:?}");
        assert!((acceleration[4] - 0.2).abs() < 1e-4, "{acceleration:?}");
    }
}
