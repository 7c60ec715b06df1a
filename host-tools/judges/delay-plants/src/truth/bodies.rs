//! Two free spacecraft with the mechanism between them, integrated in fine steps.

use crate::Axes;
use crate::contact::{Contact, Load};
use crate::log::{ContactRecord, Log};
use crate::pose::RobotPose;
use nalgebra::{Matrix3, Quaternion, Rotation3, UnitQuaternion, Vector3};

/// Step in and near a contact, s.
const FINE_S: f64 = 20e-6;
/// Step in free flight, s.
const COARSE_S: f64 = 1e-3;

/// Velocity in the laboratory (m/s), angular velocity in the spacecraft's own axes (rad/s).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Twist {
    /// Linear, m/s, laboratory.
    pub linear: Vector3<f64>,
    /// Angular, rad/s, body axes.
    pub angular: Vector3<f64>,
}

/// One spacecraft at the start.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Body {
    /// Mass, kg; infinite: the spacecraft does not move.
    pub mass_kg: f64,
    /// Moments of inertia about its axes, kg·m².
    pub inertia_kg_m2: [f64; 3],
    /// Centre of mass, m.
    pub position_m: [f64; 3],
    /// Velocity at the start.
    pub velocity: Twist,
}

/// The ideal test: K carries the probes, Q the surfaces. The surfaces are given at their initial positions; both spacecraft
/// begin with the orientation of the laboratory.
#[derive(Clone, Debug, PartialEq)]
pub struct FreeTest {
    /// The spacecraft that the robot stands for.
    pub k: Body,
    /// The other one.
    pub q: Body,
    /// The mechanism between them.
    pub contact: Contact,
}

/// Result of the ideal test.
#[derive(Clone, Debug, PartialEq)]
pub struct Outcome {
    /// Motion of K at the end.
    pub k: Twist,
    /// Motion of Q at the end.
    pub q: Twist,
    /// All contacts.
    pub contacts: Vec<ContactRecord>,
    /// Kinetic energy at the start and at the end, J.
    pub energy_j: (f64, f64),
}

#[derive(Clone, Copy, Debug)]
struct State {
    position: Vector3<f64>,
    rotation: Quaternion<f64>,
    velocity: Vector3<f64>,
    spin: Vector3<f64>,
}

impl State {
    fn new(body: &Body) -> Self {
        Self {
            position: body.position_m.into(),
            rotation: Quaternion::identity(),
            velocity: body.velocity.linear,
            spin: body.velocity.angular,
        }
    }

    fn turn(&self) -> Rotation3<f64> {
        UnitQuaternion::from_quaternion(self.rotation).to_rotation_matrix()
    }

    /// The state plus `h` times a rate of change.
    fn plus(&self, rate: &Self, h: f64) -> Self {
        Self {
            position: self.position + rate.position * h,
            rotation: self.rotation + rate.rotation * h,
            velocity: self.velocity + rate.velocity * h,
            spin: self.spin + rate.spin * h,
        }
    }
}

impl Body {
    /// Rate of change under a force and a torque about the centre of mass, in the laboratory.
    fn rate(&self, state: &State, force: &Vector3<f64>, torque: &Vector3<f64>) -> State {
        let inertia = Matrix3::from_diagonal(&Vector3::from(self.inertia_kg_m2));
        let spin = state.spin;
        let in_body = state.turn().inverse() * torque;
        let gyroscopic = spin.cross(&(inertia * spin));
        let fixed = self.mass_kg.is_infinite();
        let spun = (in_body - gyroscopic).component_div(&Vector3::from(self.inertia_kg_m2));
        State {
            position: state.velocity,
            rotation: state.rotation * Quaternion::from_imag(spin) * 0.5,
            velocity: force / self.mass_kg,
            spin: if fixed { Vector3::zeros() } else { spun },
        }
    }

    fn energy_j(&self, state: &State) -> f64 {
        if self.mass_kg.is_infinite() {
            return 0.0;
        }
        let inertia: Vector3<f64> = self.inertia_kg_m2.into();
        let spun = state.spin.component_mul(&inertia).dot(&state.spin);
        0.5 * (self.mass_kg * state.velocity.norm_squared() + spun)
    }
}

impl FreeTest {
    /// Pose of the flange of a perfect robot: K relative to Q, in the laboratory.
    fn seen_from_q(&self, k: &State, q: &State) -> RobotPose {
        let (turn_k, turn_q) = (k.turn(), q.turn());
        let apart = k.position - q.position;
        let spin_q = turn_q * q.spin;
        let back = turn_q.inverse();
        RobotPose {
            position: Vector3::from(self.q.position_m) + back * apart,
            rotation: back * turn_k,
            velocity: back * (k.velocity - q.velocity - spin_q.cross(&apart)),
            spin: back * (turn_k * k.spin - spin_q),
        }
    }

    fn rates(&self, k: &State, q: &State) -> (State, State, Load) {
        let load = self.contact.load(&self.seen_from_q(k, q));
        let turn_q = q.turn();
        let (force, torque) = (turn_q * load.force, turn_q * load.torque);
        let about_q = torque + (k.position - q.position).cross(&force);
        (
            self.k.rate(k, &force, &torque),
            self.q.rate(q, &-force, &-about_q),
            load,
        )
    }

    /// One step of the classical Runge-Kutta method.
    fn step(&self, k: &State, q: &State, h: f64) -> (State, State) {
        let (k1, q1, _) = self.rates(k, q);
        let (k2, q2, _) = self.rates(&k.plus(&k1, 0.5 * h), &q.plus(&q1, 0.5 * h));
        let (k3, q3, _) = self.rates(&k.plus(&k2, 0.5 * h), &q.plus(&q2, 0.5 * h));
        let (k4, q4, _) = self.rates(&k.plus(&k3, h), &q.plus(&q3, h));
        let sum = |s: &State, [a, b, c, d]: [&State; 4]| {
            let mut next = s.plus(a, h / 6.0).plus(b, h / 3.0);
            next = next.plus(c, h / 3.0).plus(d, h / 6.0);
            next.rotation = next.rotation.normalize();
            next
        };
        (sum(k, [&k1, &k2, &k3, &k4]), sum(q, [&q1, &q2, &q3, &q4]))
    }

    /// Simulates for `duration_s`, or until `contacts` contacts are over.
    pub fn run(&self, duration_s: f64, contacts: usize) -> Outcome {
        let (mut k, mut q) = (State::new(&self.k), State::new(&self.q));
        let energy = |k: &State, q: &State| self.k.energy_j(k) + self.q.energy_j(q);
        let before = energy(&k, &q);
        let (mut log, mut time_s) = (Log::default(), 0.0);
        log.begin(&self.contact.load(&self.seen_from_q(&k, &q)));
        let over = |log: &Log| {
            let closed = log.contacts.iter().filter(|c| c.release_s.is_some());
            closed.count() >= contacts
        };
        while time_s < duration_s && !over(&log) {
            let pose = self.seen_from_q(&k, &q);
            let h = if self.clear_of_contact(&pose) {
                COARSE_S
            } else {
                FINE_S
            };
            (k, q) = self.step(&k, &q, h);
            time_s += h;
            log.add_sample(time_s, &self.contact.load(&self.seen_from_q(&k, &q)));
        }
        let twist = |s: &State| Twist {
            linear: s.velocity,
            angular: s.spin,
        };
        Outcome {
            k: twist(&k),
            q: twist(&q),
            energy_j: (before, energy(&k, &q)),
            contacts: log.contacts,
        }
    }

    /// Whether no probe can reach a surface within a coarse step.
    fn clear_of_contact(&self, pose: &RobotPose) -> bool {
        let fastest = self.contact.probes.iter().fold(0.0, |fastest: f64, probe| {
            fastest.max(pose.point(&Vector3::from(*probe)).1.norm())
        });
        self.contact.load(pose).depth < -2.0 * fastest * COARSE_S
    }

    /// Robot axes that correspond to the position of K at the start.
    pub fn start(&self) -> Axes {
        let [x, y, z] = self.k.position_m;
        [x, y, z, 0.0, 0.0, 0.0]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::{Cone, ForceLaw, Surface, Wall};
    use crate::truth::Bounce;

    fn spacecraft(mass_kg: f64, x: f64, v: f64) -> Body {
        Body {
            mass_kg,
            inertia_kg_m2: [100.0, 120.0, 90.0],
            position_m: [x, 0.0, 0.0],
            velocity: Twist {
                linear: Vector3::new(v, 0.0, 0.0),
                angular: Vector3::zeros(),
            },
        }
    }

    fn wall(law: ForceLaw) -> Surface {
        Wall {
            point: [0.3, 0.0, 0.0],
            normal: [-1.0, 0.0, 0.0],
            law,
        }
        .into()
    }

    /// One spacecraft on a fixed wall agrees with the bounce in closed form.
    #[test]
    fn bounce_in_closed_form() {
        for zeta in [0.0, 0.1, 0.4] {
            let k = 220_500.0;
            let law = ForceLaw::linear(k, 2.0 * zeta * f64::sqrt(k * 500.0));
            let test = FreeTest {
                k: spacecraft(500.0, 0.29, 0.005),
                q: spacecraft(f64::INFINITY, 1.0, 0.0),
                contact: Contact {
                    probes: vec![[0.0; 3]],
                    surfaces: vec![wall(law)],
                },
            };
            let outcome = test.run(5.0, 1);
            let known = Bounce::new(500.0, k, zeta, 0.005);
            let (e, contact) = (-outcome.k.linear.x / 0.005, outcome.contacts[0]);
            assert!((e - known.restitution).abs() < 5e-4, "{zeta}: {e}");
            assert!((contact.peak_force_n / known.peak_force_n - 1.0).abs() < 1e-3);
            let contact_s = contact.duration_s().unwrap();
            assert!((contact_s - known.contact_s).abs() < 5e-5, "{contact_s}");
            let impulse = 500.0 * 0.005 * (1.0 + e);
            assert!((contact.impulse_n_s.x / impulse + 1.0).abs() < 1e-3);
        }
    }

    /// Without damping and friction energy and momentum are conserved for any geometry.
    #[test]
    fn conserves_energy_and_momentum() {
        let cone = Cone {
            apex: [0.4, 0.0, 0.0],
            axis: [-1.0, 0.0, 0.0],
            half_angle: 0.8,
            law: ForceLaw::linear(220_500.0, 0.0),
        };
        let mut test = FreeTest {
            k: spacecraft(500.0, 0.0, 0.03),
            q: spacecraft(2000.0, 1.0, 0.0),
            contact: Contact {
                probes: vec![[0.3, 0.05, 0.02]],
                surfaces: vec![cone.into()],
            },
        };
        test.k.velocity.angular = Vector3::new(0.002, -0.003, 0.004);
        let outcome = test.run(8.0, 9);
        assert!(outcome.contacts.len() >= 2, "{:?}", outcome.contacts.len());
        let (before, after) = outcome.energy_j;
        assert!((after / before - 1.0).abs() < 1e-4, "{before} {after}");
        let momentum = outcome.k.linear * 500.0 + outcome.q.linear * 2000.0;
        assert!((momentum - Vector3::new(15.0, 0.0, 0.0)).norm() < 1e-9);
    }

    /// Off-centre on a wall: v_x = 1 − 2/(1 + a²) with a = lever / radius of gyration.
    #[test]
    fn off_centre() {
        for a in [0.5, 1.0, 2.0] {
            let lever = a * f64::sqrt(90.0 / 500.0);
            let test = FreeTest {
                k: spacecraft(500.0, 0.29, 0.005),
                q: spacecraft(f64::INFINITY, 1.0, 0.0),
                contact: Contact {
                    probes: vec![[0.0, lever, 0.0]],
                    surfaces: vec![wall(ForceLaw::linear(220_500.0, 0.0))],
                },
            };
            let outcome = test.run(5.0, 1);
            let known = 1.0 - 2.0 / (1.0 + a * a);
            let v = outcome.k.linear.x / 0.005;
            assert!((v - known).abs() < 1e-4, "{a}: {v}, known {known}");
        }
    }
}
