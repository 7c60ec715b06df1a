//! Two-body Newton-Euler dynamics, relative motion and the observation frames (section 3.2).
//!
//! Velocities are integrated in C, angular velocities in body axes (A17). The space manipulator enters once, as accelerations
//! that the operator sets (A12) and, beyond the paper, as spring and damper. States and integrator are deliberately those of the
//! paper: this is the model that a recording is compared with.

use crate::bodies::{BodySettings, FrameSettings};
use crate::frames::{self, Pose, Twist, Wrench, components, matrix, saturated, vector};
use crate::manipulator::ManipulatorResistance;
use crate::scalar::Scalar;
use nalgebra::{Matrix3, Vector3};

/// Declared ranges of the model, per component: several times what the settings and the limits of the correction allow. A model
/// that diverges saturates here, with every scalar type, while the limits flag it and then latch a fault.
const FASTEST_M_S: f64 = 100.0;
/// Likewise, rad/s: 0.08 rad in a cycle, where the small-motion series still hold.
const FASTEST_RAD_S: f64 = 20.0;
/// Likewise, rad/s².
const LARGEST_RAD_S2: f64 = 1.0e6;
/// Likewise, m: as far as the initial velocity leads in a day.
const FARTHEST_M: f64 = 1.0e6;
/// Largest component of the distance between the two spacecraft that is taken as a lever, m: twice
/// what the settings allow. The largest contact force at its end stays within fixed point, also
/// while the product is turned from one frame into another.
const LONGEST_LEVER_M: f64 = 4.0e3;

/// Motion of one spacecraft.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BodyState<S: Scalar> {
    /// Body frame (axes of the spacecraft, origin in its centre of mass) in C.
    pub c_from_body: Pose<S>,
    /// Velocity in C and angular velocity in body axes.
    pub velocity: Twist<S>,
}

impl<S: Scalar> BodyState<S> {
    /// The operator's initial conditions.
    pub fn initial(settings: &BodySettings) -> Self {
        Self {
            c_from_body: frames::pose(&settings.position_m, &settings.orientation_wxyz),
            velocity: Twist {
                linear: vector(&settings.velocity_m_s),
                angular: vector(&settings.angular_velocity_rad_s),
            },
        }
    }
}

/// Inertia tensor and its inverse, both divided by the tensor's largest element: in fixed point
/// the inverse of a large tensor would otherwise have no digits left.
#[derive(Clone, Debug)]
struct Inertia<S: Scalar> {
    scale: S,
    tensor: Matrix3<S>,
    inverse: Matrix3<S>,
    /// Largest torque that is taken, N·m: 1e4 rad/s² of the largest moment of inertia.
    torque_limit: f64,
}

impl<S: Scalar> Inertia<S> {
    fn new(tensor_kg_m2: &[[f64; 3]; 3]) -> Self {
        let tensor = Matrix3::from_fn(|r, c| tensor_kg_m2[r][c]);
        let scale = tensor.amax().max(f64::MIN_POSITIVE);
        let inverse = (tensor / scale)
            .try_inverse()
            .unwrap_or_else(Matrix3::identity);
        let rows = |m: &Matrix3<f64>| matrix(&[0, 1, 2].map(|r| components(&m.row(r).transpose())));
        Self {
            scale: S::of(scale),
            tensor: rows(&(tensor / scale)),
            inverse: rows(&inverse),
            torque_limit: (scale * 1e4).min(1e9),
        }
    }

    /// A torque in units of the scale, within its declared range.
    fn scaled(&self, torque: &Vector3<S>) -> Vector3<S> {
        saturated(torque, self.torque_limit) / self.scale
    }

    /// I⁻¹ (T − ω × I ω): Euler's equation in body axes, rad/s², for a [`scaled`](Self::scaled) torque.
    fn angular_acceleration(&self, torque: &Vector3<S>, omega: &Vector3<S>) -> Vector3<S> {
        let alpha = self.inverse * (torque - omega.cross(&(self.tensor * omega)));
        saturated(&alpha, LARGEST_RAD_S2)
    }
}

/// Whether a component has reached a limit, to within the rounding of the coarsest scalar.
fn reaches<S: Scalar>(v: &Vector3<S>, limit: f64) -> bool {
    v.amax() >= S::of(limit * (1.0 - 1e-6))
}

/// From Q to K, axes of C, within the declared range of a lever.
fn lever<S: Scalar>(k: &BodyState<S>, q: &BodyState<S>) -> Vector3<S> {
    let apart = k.c_from_body.translation.vector - q.c_from_body.translation.vector;
    saturated(&apart, LONGEST_LEVER_M)
}

/// One spacecraft, ready to run.
#[derive(Clone, Debug)]
pub struct Body<S: Scalar> {
    fixed: bool,
    mass: S,
    inertia: Inertia<S>,
    /// a_ARM in C and α_ARM in body axes.
    arm: Twist<S>,
    /// Resistance of the space manipulator per kilogram, and the position in C at which its spring is relaxed.
    resistance: Option<(ManipulatorResistance<S>, Vector3<S>)>,
}

impl<S: Scalar> Body<S> {
    /// From validated settings.
    pub fn new(settings: &BodySettings) -> Self {
        Self {
            fixed: settings.fixed,
            mass: S::of(settings.mass_kg),
            inertia: Inertia::new(&settings.inertia_kg_m2),
            arm: Twist {
                linear: vector(&settings.arm_acceleration_m_s2),
                angular: vector(&settings.arm_angular_acceleration_rad_s2),
            },
            resistance: Self::resistance(settings),
        }
    }

    fn resistance(settings: &BodySettings) -> Option<(ManipulatorResistance<S>, Vector3<S>)> {
        let (stiffness, damping) = settings.arm_resistance_per_kg();
        if stiffness == 0.0 && damping == 0.0 {
            return None;
        }
        let law = ManipulatorResistance::new(stiffness, damping).ok()?;
        Some((law, vector(&settings.position_m)))
    }

    /// Acceleration by the space manipulator, m/s² in C: a_ARM, and its resistance.
    fn arm_acceleration(&self, state: &BodyState<S>) -> Vector3<S> {
        let Some((law, relaxed_m)) = &self.resistance else {
            return self.arm.linear;
        };
        let away = state.c_from_body.translation.vector - relaxed_m;
        let away = saturated(&away, LONGEST_LEVER_M);
        let pull = away.zip_map(&state.velocity.linear, |displacement, speed| {
            law.force(displacement, speed)
        });
        self.arm.linear + pull
    }

    /// Mean angular acceleration over one cycle by the paper's four stages, rad/s².
    ///
    /// α₁ to α₄ of section 3.2: a Runge-Kutta step of ω with the torque frozen, the attitude not
    /// staged (A18).
    pub fn angular_acceleration(
        &self,
        torque: &Vector3<S>,
        omega: &Vector3<S>,
        ts: S,
    ) -> Vector3<S> {
        let half = S::of(0.5) * ts;
        let torque = self.inertia.scaled(torque);
        let alpha = |omega: Vector3<S>| {
            let omega = saturated(&omega, FASTEST_RAD_S);
            self.inertia.angular_acceleration(&torque, &omega)
        };
        let a1 = alpha(*omega);
        let a2 = alpha(omega + a1 * half);
        let a3 = alpha(omega + a2 * half);
        let a4 = alpha(omega + a3 * ts);
        (a1 + (a2 + a3) * S::of(2.0) + a4) / S::of(6.0)
    }

    /// The state one cycle later under a wrench at the centre of mass, in body axes (N, N·m).
    ///
    /// `v += (F/m + a_ARM − (k (p − p0) + c v)/m) Ts`, `ω += (α + α_ARM) Ts`, pose by the mean of old and new velocity.
    pub fn step(&self, state: &BodyState<S>, wrench: &Wrench<S>, ts: S) -> BodyState<S> {
        if self.fixed {
            return *state;
        }
        let Twist {
            linear: v,
            angular: omega,
        } = state.velocity;
        let force_c = state.c_from_body.rotation * wrench.force;
        let arm = self.arm_acceleration(state);
        let alpha = self.angular_acceleration(&wrench.torque, &omega, ts) + self.arm.angular;
        let velocity = Twist {
            linear: saturated(&(v + force_c * ts / self.mass + arm * ts), FASTEST_M_S),
            angular: saturated(&(omega + alpha * ts), FASTEST_RAD_S),
        };
        let mean = (state.velocity + velocity) * S::of(0.5);
        let mut c_from_body = advanced(&state.c_from_body, &mean, ts);
        let position = &mut c_from_body.translation.vector;
        *position = saturated(position, FARTHEST_M);
        BodyState {
            c_from_body,
            velocity,
        }
    }

    /// Acceleration from rest by a wrench at the centre of mass, all in body axes.
    fn answer(&self, wrench: &Wrench<S>) -> Twist<S> {
        if self.fixed {
            return Twist::zero();
        }
        let torque = self.inertia.scaled(&wrench.torque);
        Twist {
            linear: wrench.force / self.mass,
            angular: self
                .inertia
                .angular_acceleration(&torque, &Vector3::zeros()),
        }
    }

    /// Kinetic energy (J) of a state of this body.
    pub fn kinetic_energy(&self, state: &BodyState<S>) -> S {
        let Twist { linear, angular } = state.velocity;
        let rotation = angular.dot(&(self.inertia.tensor * angular)) * self.inertia.scale;
        (linear.norm_squared() * self.mass + rotation) * S::of(0.5)
    }

    /// Linear momentum (kg·m/s) and angular momentum about the origin of C (kg·m²/s), axes of C.
    pub fn momentum(&self, state: &BodyState<S>) -> (Vector3<S>, Vector3<S>) {
        let linear = state.velocity.linear * self.mass;
        let spin = self.inertia.tensor * state.velocity.angular * self.inertia.scale;
        let orbital = state.c_from_body.translation.vector.cross(&linear);
        (linear, orbital + state.c_from_body.rotation * spin)
    }
}

/// A pose moved for one cycle: linear velocity in the pose's outer frame, angular velocity in its
/// own axes (A19: the translation is added in C, not multiplied from the right in body axes).
pub fn advanced<S: Scalar>(pose: &Pose<S>, velocity: &Twist<S>, ts: S) -> Pose<S> {
    let position = pose.translation.vector + frames::scaled(&velocity.linear, ts);
    let rotation = frames::rotated(&pose.rotation, &frames::scaled(&velocity.angular, ts));
    Pose::from_parts(position.into(), rotation)
}

/// Velocity of K relative to Q as an observer on Q sees it: linear in axes of Q, angular in body
/// axes of K.
///
/// `v_K − v_Q − ω_Q × p` with p = r_K − r_Q, all in C, then turned into Q (A19);
/// `ω_K − ω_Q` in the axes of K.
pub fn relative_velocity<S: Scalar>(k: &BodyState<S>, q: &BodyState<S>) -> Twist<S> {
    let (rk, rq) = (k.c_from_body.rotation, q.c_from_body.rotation);
    let omega_q_c = rq * q.velocity.angular;
    let linear_c = k.velocity.linear - q.velocity.linear - omega_q_c.cross(&lever(k, q));
    Twist {
        linear: rq.inverse() * linear_c,
        angular: k.velocity.angular - rk.inverse() * omega_q_c,
    }
}

/// Both spacecraft and the coupling between them.
#[derive(Clone, Debug)]
pub struct TwoBody<S: Scalar> {
    /// Passive spacecraft, moved by the rig.
    pub k: Body<S>,
    /// Active spacecraft.
    pub q: Body<S>,
    ts: S,
}

/// Motion of both spacecraft.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TwoBodyState<S: Scalar> {
    /// Passive spacecraft.
    pub k: BodyState<S>,
    /// Active spacecraft.
    pub q: BodyState<S>,
}

impl<S: Scalar> TwoBodyState<S> {
    /// Whether a quantity has reached the limit of its declared range, where it saturates.
    pub fn at_its_limits(&self) -> bool {
        let apart = self.k.c_from_body.translation.vector - self.q.c_from_body.translation.vector;
        let beyond = |body: &BodyState<S>| {
            reaches(&body.velocity.linear, FASTEST_M_S)
                || reaches(&body.velocity.angular, FASTEST_RAD_S)
                || reaches(&body.c_from_body.translation.vector, FARTHEST_M)
        };
        beyond(&self.k) || beyond(&self.q) || reaches(&apart, LONGEST_LEVER_M)
    }

    /// Pose of K in Q.
    pub fn q_from_k(&self) -> Pose<S> {
        self.q.c_from_body.inverse() * self.k.c_from_body
    }
}

impl<S: Scalar> TwoBody<S> {
    /// From validated settings; `ts` is the cycle in s.
    pub fn new(k: &BodySettings, q: &BodySettings, ts: f64) -> Self {
        Self {
            k: Body::new(k),
            q: Body::new(q),
            ts: S::of(ts),
        }
    }

    /// One cycle under the wrench measured on K (at K, body axes); Q gets the reaction.
    ///
    /// Returns the new state and the wrench on Q (at Q, body axes of Q).
    pub fn step(&self, s: &TwoBodyState<S>, on_k: &Wrench<S>) -> (TwoBodyState<S>, Wrench<S>) {
        let (k, q) = (&s.k.c_from_body, &s.q.c_from_body);
        let on_k_c = on_k.map(|v| k.rotation * v);
        let on_q_c = on_k_c.reaction(&-lever(&s.k, &s.q));
        let on_q = on_q_c.map(|v| q.rotation.inverse() * v);
        let next = TwoBodyState {
            k: self.k.step(&s.k, on_k, self.ts),
            q: self.q.step(&s.q, &on_q, self.ts),
        };
        (next, on_q)
    }
}

impl<S: Scalar> TwoBody<S> {
    /// Relative acceleration of K and Q by a wrench on K (at K, body axes): linear (m/s²) and angular (rad/s²), both in body axes
    /// of K. Terms of the motion itself (ω × I ω and the like) are left out: the result is the inverse inertia matrix of the pair
    /// times the wrench.
    pub fn mobility(&self, s: &TwoBodyState<S>, on_k: &Wrench<S>) -> Twist<S> {
        let (rk, rq) = (s.k.c_from_body.rotation, s.q.c_from_body.rotation);
        let lever = lever(&s.k, &s.q);
        let on_q_c = on_k.map(|v| rk * v).reaction(&-lever);
        let k = self.k.answer(on_k);
        let q = self.q.answer(&on_q_c.map(|v| rq.inverse() * v));
        let turning_c = rq * q.angular;
        let q_linear_c = rq * q.linear + turning_c.cross(&lever);
        Twist {
            linear: k.linear - rk.inverse() * q_linear_c,
            angular: k.angular - rk.inverse() * turning_c,
        }
    }
}

/// The observation frames: J (= N) on K, P on Q.
#[derive(Clone, Debug)]
pub struct ObservationFrames<S: Scalar> {
    k_from_j: Pose<S>,
    q_from_p: Pose<S>,
}

/// Relative motion of the docking surfaces as an observer sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Observation<S: Scalar> {
    /// J in C.
    pub c_from_j: Pose<S>,
    /// P in C.
    pub c_from_p: Pose<S>,
    /// J seen from P: becomes identity at docking.
    pub p_from_j: Pose<S>,
    /// Velocity of J relative to P: linear in axes of P, angular in axes of J.
    pub relative_velocity: Twist<S>,
}

impl<S: Scalar> ObservationFrames<S> {
    /// From validated settings.
    pub fn new(settings: &FrameSettings) -> Self {
        Self {
            k_from_j: frames::pose(&settings.j_position_m, &settings.j_orientation_wxyz),
            q_from_p: frames::pose(&settings.p_position_m, &settings.p_orientation_wxyz),
        }
    }

    /// Poses and relative velocity of the docking surfaces in a state.
    pub fn observe(&self, state: &TwoBodyState<S>) -> Observation<S> {
        let at = |body: &BodyState<S>, offset: &Pose<S>| BodyState {
            c_from_body: body.c_from_body * offset,
            velocity: surface_velocity(body, offset),
        };
        let (j, p) = (at(&state.k, &self.k_from_j), at(&state.q, &self.q_from_p));
        Observation {
            c_from_j: j.c_from_body,
            c_from_p: p.c_from_body,
            p_from_j: p.c_from_body.inverse() * j.c_from_body,
            relative_velocity: relative_velocity(&j, &p),
        }
    }
}

/// Velocity of a frame fixed to a body: linear in C, angular in the frame's own axes.
fn surface_velocity<S: Scalar>(body: &BodyState<S>, offset: &Pose<S>) -> Twist<S> {
    let spin = body.velocity.angular.cross(&offset.translation.vector);
    Twist {
        linear: body.velocity.linear + body.c_from_body.rotation * spin,
        angular: offset.rotation.inverse() * body.velocity.angular,
    }
}

#[cfg(test)]
mod tests;
