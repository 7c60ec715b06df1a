//! The rig computer's model of the spacecraft: compensated wrench in, velocity command out.

use nalgebra::{Matrix3, UnitQuaternion, Vector3, Vector6};

use crate::meta::{Meta, angular, linear, matrix, stack};

/// Computes the acceleration of the body, m/s² in C and rad/s² in M, from a raw reading:
/// `F = f - m g - b`, `T_M = t - com x m g - b + r_S x F`,
/// `a = R F / m_sc`, `alpha = I^-1 (T_M - w x I w)`.
#[derive(Clone, Debug)]
pub(crate) struct Dynamics<'a> {
    meta: &'a Meta,
    inertia: Matrix3<f64>,
    inverse: Matrix3<f64>,
}

impl<'a> Dynamics<'a> {
    /// A singular inertia keeps the rotation at rest.
    pub(crate) fn new(meta: &'a Meta) -> Self {
        let inertia = matrix(&meta.spacecraft.inertia_kg_m2);
        Self {
            meta,
            inertia,
            inverse: inertia.try_inverse().unwrap_or_else(Matrix3::zeros),
        }
    }

    /// Force in C, N, and torque about the origin of M in M, Nm, that remain after compensation.
    pub(crate) fn compensated(
        &self,
        reading: &Vector6<f64>,
        rotation: &UnitQuaternion<f64>,
    ) -> Vector6<f64> {
        let gravity = rotation.inverse_transform_vector(&self.meta.gravity());
        let load = reading - self.meta.tool.weight(&gravity) - self.meta.bias();
        let force = linear(&load);
        let torque = angular(&load) + self.meta.sensor().cross(&force);
        stack(&(rotation * force), &torque)
    }

    /// Euler's equation, rad/s².
    pub(crate) fn spin(&self, torque: &Vector3<f64>, omega: &Vector3<f64>) -> Vector3<f64> {
        self.inverse * (torque - omega.cross(&(self.inertia * omega)))
    }

    /// Acceleration with the locked axes at zero.
    pub(crate) fn acceleration(
        &self,
        reading: &Vector6<f64>,
        rotation: &UnitQuaternion<f64>,
        omega: &Vector3<f64>,
    ) -> Vector6<f64> {
        let load = self.compensated(reading, rotation);
        let linear = linear(&load) / self.meta.spacecraft.mass_kg;
        self.meta
            .masked(stack(&linear, &self.spin(&angular(&load), omega)))
    }
}

/// Integrator of the hardware-in-the-loop phase.
#[derive(Clone, Debug)]
pub(crate) struct Body<'a> {
    dynamics: Dynamics<'a>,
    mass_ratio: f64,
    /// Stiffness and damping of a resistance, N/m and N s/m.
    resistance: (f64, f64),
    velocity: Vector6<f64>,
}

impl<'a> Body<'a> {
    /// Begins with the last command of the jog.
    pub(crate) fn new(
        meta: &'a Meta,
        mass_ratio: f64,
        resistance: (f64, f64),
        velocity: Vector6<f64>,
    ) -> Self {
        Self {
            dynamics: Dynamics::new(meta),
            mass_ratio,
            resistance,
            velocity,
        }
    }

    /// One tick: `v += a Ts` (the rotation by RK4 with held torque). The output is the mean of the old
    /// and the new velocity.
    pub(crate) fn tick(
        &mut self,
        reading: &Vector6<f64>,
        position: &Vector3<f64>,
        rotation: &UnitQuaternion<f64>,
    ) -> Vector6<f64> {
        let meta = self.dynamics.meta;
        let h = meta.sample_time_s;
        let load = self.dynamics.compensated(reading, rotation);
        let old = self.velocity;
        let (stiffness, damping) = self.resistance;
        let resisted = linear(&load) - position * stiffness - linear(&old) * damping;
        let mass = meta.spacecraft.mass_kg * self.mass_ratio;
        let torque = angular(&load);
        let omega = angular(&old);
        let k1 = self.dynamics.spin(&torque, &omega);
        let k2 = self.dynamics.spin(&torque, &(omega + k1 * (0.5 * h)));
        let k3 = self.dynamics.spin(&torque, &(omega + k2 * (0.5 * h)));
        let k4 = self.dynamics.spin(&torque, &(omega + k3 * h));
        let spin = (k1 + (k2 + k3) * 2.0 + k4) / 6.0;
        self.velocity += meta.masked(stack(&(resisted / mass), &spin)) * h;
        (old + self.velocity) * 0.5
    }
}
