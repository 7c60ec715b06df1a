//! Bodies that collide with a mechanism, for tests.

use crate::{EnergyBalance, EnergyTracked, Mechanism, Relative};
use nalgebra::{Point3, Translation3, UnitQuaternion, Vector3};
use softdock_control::frames::{Pose, Twist, Wrench};

/// Result of a mass that flew along x into a mechanism.
#[derive(Debug)]
pub(crate) struct Bounce {
    pub(crate) restitution: f64,
    pub(crate) duration_s: f64,
    pub(crate) depth_m: f64,
    pub(crate) balance: EnergyBalance,
}

impl Bounce {
    /// Asserts that the energy balance holds and that the loss of the mechanism equals that of the mass, both as shares of
    /// the mass's energy.
    pub(crate) fn assert_balanced(&self, mass_kg: f64, speed_m_s: f64, share: f64) {
        let energy = 0.5 * mass_kg * speed_m_s * speed_m_s;
        assert!(
            self.balance.imbalance_j().abs() < share * energy,
            "{self:?}"
        );
        let gone = energy * (1.0 - self.restitution * self.restitution);
        let left = self.balance.dissipated_j + self.balance.stored_j;
        assert!(
            (left - gone).abs() < 10.0 * share * energy,
            "{self:?} lost {gone}"
        );
    }
}

/// A mass that reaches J = P with a speed; simulated until the mechanism releases it.
pub(crate) fn bounce(
    mechanism: impl Mechanism,
    mass_kg: f64,
    speed_m_s: f64,
    step_s: f64,
) -> Bounce {
    let (mut x, mut v, mut t) = (0.0, speed_m_s, 0.0);
    let mut depth_m = 0.0_f64;
    let mut tracked = EnergyTracked::new(mechanism);
    let mut force = tracked
        .advance(&Relative::along_x(x, v), 0.0)
        .wrench
        .force
        .x;
    for _ in 0..10_000_000 {
        v += force / mass_kg * step_s;
        x += v * step_s;
        t += step_s;
        depth_m = depth_m.max(x);
        force = tracked
            .advance(&Relative::along_x(x, v), step_s)
            .wrench
            .force
            .x;
        if force == 0.0 && v < 0.0 {
            break;
        }
    }
    Bounce {
        restitution: -v / speed_m_s,
        duration_s: t,
        depth_m,
        balance: tracked.balance(),
    }
}

/// A free rigid body. Its momenta are integrated, so that a force and its reaction cancel to the last digit.
pub(crate) struct Body {
    mass: f64,
    inertia: Vector3<f64>,
    pose: Pose<f64>,
    momentum: Vector3<f64>,
    spin: Vector3<f64>,
}

impl Body {
    /// A body at a position, flying along x.
    pub(crate) fn new(mass: f64, inertia: [f64; 3], place: [f64; 3], speed: f64) -> Self {
        Self {
            mass,
            inertia: inertia.into(),
            pose: Pose::from_parts(Vector3::from(place).into(), UnitQuaternion::identity()),
            momentum: Vector3::new(mass * speed, 0.0, 0.0),
            spin: Vector3::zeros(),
        }
    }

    /// Angular velocity in the axes of the world.
    fn turning(&self) -> Vector3<f64> {
        let own = self.pose.rotation.inverse() * self.spin;
        self.pose.rotation * own.component_div(&self.inertia)
    }

    /// Applies a force at a point, then moves.
    fn step(&mut self, point: &Vector3<f64>, [force, torque]: [Vector3<f64>; 2], step_s: f64) {
        let lever = point - self.pose.translation.vector;
        self.momentum += force * step_s;
        self.spin += (torque + lever.cross(&force)) * step_s;
        self.pose.translation.vector += self.momentum * (step_s / self.mass);
        self.pose.rotation =
            UnitQuaternion::from_scaled_axis(self.turning() * step_s) * self.pose.rotation;
    }

    /// Change of velocity of a point along a normal per unit impulse along it at that point, 1/kg.
    pub(crate) fn inverse_effective_mass(
        &self,
        point: &Vector3<f64>,
        normal: &Vector3<f64>,
    ) -> f64 {
        let lever = point - self.pose.translation.vector;
        let own = self.pose.rotation.inverse() * lever.cross(normal);
        1.0 / self.mass + own.dot(&own.component_div(&self.inertia))
    }

    fn velocity_at(&self, point: &Vector3<f64>) -> Vector3<f64> {
        self.momentum / self.mass
            + self
                .turning()
                .cross(&(point - self.pose.translation.vector))
    }
}

/// Two free bodies with their docking frames, whose axes are those of the bodies.
pub(crate) struct Pair {
    pub(crate) k: Body,
    pub(crate) q: Body,
    pub(crate) k_from_j: Vector3<f64>,
    pub(crate) q_from_p: Vector3<f64>,
}

impl Pair {
    pub(crate) fn relative(&self) -> Relative {
        let world_from_p = self.q.pose * Translation3::from(self.q_from_p);
        let world_from_j = self.k.pose * Translation3::from(self.k_from_j);
        let tip = world_from_j.translation.vector;
        let apart = self.k.velocity_at(&tip) - self.q.velocity_at(&tip);
        Relative {
            p_from_j: world_from_p.inverse() * world_from_j,
            twist: Twist {
                linear: world_from_p.rotation.inverse() * apart,
                angular: world_from_j.rotation.inverse() * (self.k.turning() - self.q.turning()),
            },
        }
    }

    /// Linear momentum, and angular momentum about the origin of the world.
    pub(crate) fn momentum(&self) -> (Vector3<f64>, Vector3<f64>) {
        let angular = |b: &Body| b.spin + b.pose.translation.vector.cross(&b.momentum);
        (
            self.k.momentum + self.q.momentum,
            angular(&self.k) + angular(&self.q),
        )
    }

    pub(crate) fn kinetic_j(&self) -> f64 {
        [&self.k, &self.q]
            .iter()
            .map(|b| 0.5 * (b.momentum.norm_squared() / b.mass + b.spin.dot(&b.turning())))
            .sum()
    }

    /// One step with a wrench on K at J, and its reaction on Q at the same point.
    pub(crate) fn step(&mut self, wrench: &Wrench<f64>, step_s: f64) {
        let point = self.k.pose * Point3::from(self.k_from_j);
        let [force, torque] = [wrench.force, wrench.torque].map(|v| self.k.pose.rotation * v);
        self.k.step(&point.coords, [force, torque], step_s);
        self.q.step(&point.coords, [-force, -torque], step_s);
    }
}

/// Result of the collision of two bodies.
#[derive(Debug)]
pub(crate) struct CollisionResult {
    /// Point and direction of the first force on K, in the world.
    pub(crate) point: Vector3<f64>,
    pub(crate) normal: Vector3<f64>,
    pub(crate) duration_s: f64,
    /// Speeds along the first normal before and after.
    pub(crate) closing_m_s: f64,
    pub(crate) parting_m_s: f64,
    pub(crate) balance: EnergyBalance,
}

/// Two bodies fly until they have met and separated, for at most `steps` steps.
pub(crate) fn collide(
    pair: &mut Pair,
    mechanism: impl Mechanism,
    step_s: f64,
    steps: usize,
) -> Option<CollisionResult> {
    let mut tracked = EnergyTracked::new(mechanism);
    let mut collision: Option<CollisionResult> = None;
    for _ in 0..steps {
        let at = pair.relative();
        let wrench = tracked.advance(&at, step_s).wrench;
        if wrench != Wrench::zero() {
            let collision = collision.get_or_insert_with(|| first_touch(pair, &wrench));
            collision.duration_s += step_s;
        } else if let Some(mut collision) = collision {
            let apart = pair.k.velocity_at(&collision.point) - pair.q.velocity_at(&collision.point);
            collision.parting_m_s = apart.dot(&collision.normal);
            collision.balance = tracked.balance();
            return Some(collision);
        }
        pair.step(&wrench, step_s);
    }
    None
}

/// The line of action of a pure force passes through the foot of the perpendicular from J.
fn first_touch(pair: &Pair, wrench: &Wrench<f64>) -> CollisionResult {
    let foot = wrench.force.cross(&wrench.torque) / wrench.force.norm_squared();
    let point = (pair.k.pose * Point3::from(pair.k_from_j + foot)).coords;
    let normal = pair.k.pose.rotation * wrench.force.normalize();
    let apart = pair.k.velocity_at(&point) - pair.q.velocity_at(&point);
    CollisionResult {
        point,
        normal,
        duration_s: 0.0,
        closing_m_s: apart.dot(&normal),
        parting_m_s: 0.0,
        balance: EnergyBalance::default(),
    }
}
