//! The direction of a contact, and force and motion along it.
//!
//! The direction is that of the measured wrench: its force and its lever, averaged over some cycles. Along it a law computes with
//! scalars instead of vectors, for any pose and two free spacecraft. A contact opens when the force exceeds a threshold while the
//! two approach each other. It is followed until the force is gone and the law lets it close. A load that is a torque alone does
//! not count as a contact here.

use super::LawInput;
use super::actuator::ActuatorSettings;
use super::status::{LawFlags, LawStatus};
use crate::frames::{Pose, Twist, Wrench};
use crate::scalar::Scalar;
use nalgebra::Vector3;

/// Forgetting factor of the averaged wrench, per cycle: a memory of ten cycles.
const FORGETTING_FACTOR: f64 = 0.9;
/// Largest force along a contact that a law deals with, N.
const LARGEST_N: f64 = 1e5;
/// Largest lever, m.
const LONGEST_M: f64 = 1e2;
/// Cycles below the threshold after which a contact is over: an impact's force may cross zero in between.
const QUIET_CYCLES: u32 = 8;
/// Number of latencies of the reported pose that are compensated: 0 to 8 cycles.
pub(super) const LATENCIES: usize = 9;

/// The line of a contact and the state that is needed to follow it.
#[derive(Clone, Debug)]
pub(super) struct ContactLine<S: Scalar> {
    threshold: S,
    latency: usize,
    /// Exponentially forgetting sum of the wrench; only its direction is used.
    average: Wrench<S>,
    /// Force part of length 1, along the push of the surface; axes of M.
    direction: Wrench<S>,
    /// Measured pose of the last cycle.
    last_pose: Option<Pose<S>>,
    /// Loads of the last cycles, newest first.
    loads: [S; LATENCIES],
    open: bool,
    quiet_cycles: u32,
}

/// A cycle of a contact, seen along its direction. Away from the surface is positive.
#[derive(Clone, Copy, Debug)]
pub(super) struct Along<S: Scalar> {
    /// The contact opened in this cycle.
    pub(super) opened: bool,
    /// Force, N.
    pub(super) load: S,
    /// Force at the time of the reported pose, N.
    pub(super) load_then: S,
    /// Measured motion since the last cycle, m.
    pub(super) moved: S,
    /// Velocity of the model before this cycle's wrench, m/s.
    pub(super) velocity: S,
    /// Change of velocity per impulse: inverse of the mass that the contact feels, 1/kg.
    pub(super) mobility: S,
}

impl<S: Scalar> ContactLine<S> {
    /// `threshold_n` is the force that opens a contact, N.
    pub(super) fn new(threshold_n: f64, actuator: &ActuatorSettings) -> Self {
        Self {
            threshold: S::of(threshold_n),
            latency: usize::from(actuator.feedback_latency_cycles).min(LATENCIES - 1),
            average: Wrench::zero(),
            direction: Wrench::zero(),
            last_pose: None,
            loads: [S::zero(); LATENCIES],
            open: false,
            quiet_cycles: 0,
        }
    }

    /// Takes in a cycle. Returns the quantities along the contact; `None` if none is open.
    pub(super) fn update(&mut self, input: &LawInput<'_, S>) -> Option<Along<S>> {
        let before = self.last_pose.replace(*input.measured);
        self.average = self.average * S::of(FORGETTING_FACTOR) + *input.wrench;
        let force = length(&input.wrench.force);
        let mut opened = false;
        if force >= self.threshold {
            self.quiet_cycles = 0;
            self.turn();
            opened = !self.open && self.velocity(input) < S::zero();
            self.open |= opened;
            if opened {
                self.loads = [S::zero(); LATENCIES];
            }
        } else {
            self.quiet_cycles = self.quiet_cycles.saturating_add(1);
        }
        if !self.open {
            self.average = Wrench::zero();
            return None;
        }
        Some(self.along(input, before, opened))
    }

    /// Whether a contact is open.
    pub(super) fn is_open(&self) -> bool {
        self.open
    }

    /// The part of the status that all laws along a contact share: whether a contact is open.
    pub(super) fn status(&self) -> LawStatus {
        let mut status = LawStatus::default();
        if self.open {
            status.flags.set(LawFlags::CONTACT);
        }
        status
    }

    /// Closes the contact if the force has been below the threshold for more than [`QUIET_CYCLES`].
    pub(super) fn close_when_quiet(&mut self) {
        self.close_after(QUIET_CYCLES);
    }

    /// Closes the contact if the force has been below the threshold for more than `cycles` cycles.
    pub(super) fn close_after(&mut self, cycles: u32) {
        if self.quiet_cycles > cycles {
            self.open = false;
            self.average = Wrench::zero();
        }
    }

    /// A force along the contact as a wrench at M, axes of M.
    pub(super) fn wrench(&self, force: S) -> Wrench<S> {
        self.direction * force
    }

    /// The part of a wrench that acts along the contact, N.
    pub(super) fn load(&self, wrench: &Wrench<S>) -> S {
        saturated(self.direction.force.dot(&wrench.force), LARGEST_N)
    }

    /// The component of a motion along the contact. `motion` is linear in C, angular in M.
    pub(super) fn part(&self, motion: &Twist<S>, input: &LawInput<'_, S>) -> S {
        let linear = input.measured.rotation.inverse() * motion.linear;
        self.direction.force.dot(&linear) + self.direction.torque.dot(&motion.angular)
    }

    /// The motion that a force along the contact gives the pair of spacecraft, normalised to 1 along the contact; linear in C,
    /// angular in M. Zero if the force moves nothing.
    pub(super) fn push(&self, input: &LawInput<'_, S>) -> Twist<S> {
        let answer = input.bodies.mobility(input.state, &self.direction);
        let size = self.dot(&answer);
        if size <= S::zero() {
            return Twist::zero();
        }
        let push = answer * (S::one() / size);
        Twist {
            linear: input.measured.rotation * push.linear,
            angular: push.angular,
        }
    }

    fn velocity(&self, input: &LawInput<'_, S>) -> S {
        self.part(&input.model_end, input)
    }

    /// Updates the direction from the averaged wrench; where forces cancel (below a tenth of the threshold) it stays.
    fn turn(&mut self) {
        let force = length(&self.average.force);
        if force < self.threshold * S::of(0.1) {
            return;
        }
        let per_force = S::one() / force;
        let lever = |v: S| saturated(v * per_force, LONGEST_M);
        self.direction = Wrench {
            force: self.average.force * per_force,
            torque: self.average.torque.map(lever),
        };
    }

    fn along(
        &mut self,
        input: &LawInput<'_, S>,
        before: Option<Pose<S>>,
        opened: bool,
    ) -> Along<S> {
        let load = self.load(input.wrench);
        self.loads.rotate_right(1);
        self.loads[0] = load;
        let moved = before.map_or(Twist::zero(), |before| step(&before, input.measured));
        Along {
            opened,
            load,
            load_then: self.loads[self.latency],
            moved: self.part(&moved, input),
            velocity: self.velocity(input),
            mobility: self.dot(&input.bodies.mobility(input.state, &self.direction)),
        }
    }

    fn dot(&self, answer: &Twist<S>) -> S {
        self.direction.force.dot(&answer.linear) + self.direction.torque.dot(&answer.angular)
    }
}

/// Motion from one pose to the next: m in C, rad in the moving axes.
pub(super) fn step<S: Scalar>(before: &Pose<S>, now: &Pose<S>) -> Twist<S> {
    let turn = before.rotation.inverse() * now.rotation;
    let two = S::of(if turn.w < S::zero() { -2.0 } else { 2.0 });
    Twist {
        linear: now.translation.vector - before.translation.vector,
        angular: Vector3::new(turn.i, turn.j, turn.k) * two,
    }
}

/// Length. It is scaled by the largest component, as squares might leave fixed point.
fn length<S: Scalar>(v: &Vector3<S>) -> S {
    let largest = v.amax();
    if largest <= S::zero() {
        S::zero()
    } else {
        (v / largest).norm() * largest
    }
}

/// A number within ±limit.
pub(super) fn saturated<S: Scalar>(v: S, limit: f64) -> S {
    v.clamp(S::of(-limit), S::of(limit))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::delay::spacecraft::{CYCLE_S, Spacecraft};
    use crate::settings::BodySettings;
    use nalgebra::{Quaternion, UnitQuaternion};

    /// The line of a contact from 1 N on, with a reported pose that is this many cycles late.
    fn line(latency: u8) -> ContactLine<f64> {
        let actuator = ActuatorSettings {
            feedback_latency_cycles: latency,
            ..ActuatorSettings::default()
        };
        ContactLine::new(1.0, &actuator)
    }

    fn wrench(force: [f64; 3], torque: [f64; 3]) -> Wrench<f64> {
        let ([x, y, z], [a, b, c]) = (force, torque);
        Wrench::of(&[x, y, z, a, b, c])
    }

    /// Two spacecraft that approach each other while they rotate, K beside Q, and the force between them.
    fn meeting() -> (Spacecraft, Wrench<f64>) {
        let k = BodySettings {
            position_m: [0.5, 0.3, -0.2],
            orientation_wxyz: [0.8, 0.3, -0.4, 0.33],
            velocity_m_s: [-0.02, -0.01, 0.01],
            angular_velocity_rad_s: [0.01, 0.03, -0.02],
            ..BodySettings::default()
        };
        let spacecraft = Spacecraft::new(&k, &BodySettings::default());
        let away = spacecraft.measured.rotation.inverse() * Vector3::new(0.6, 0.5, -0.4);
        let force: [f64; 3] = (away * 50.0).into();
        (spacecraft, wrench(force, [2.0, -3.0, 4.0]))
    }

    #[test]
    fn a_contact_opens_at_a_force_against_the_approach() {
        for (force, velocity, opens) in [
            (1.0, -0.001, true),
            (-1.0, 0.001, true),
            (0.99, -0.001, false),
            (1.0, 0.001, false),
            (1.0, 0.0, false),
        ] {
            let spacecraft = Spacecraft::before_a_wall([velocity, 0.0, 0.0]);
            let mut line = line(0);
            let load = wrench([force, 0.0, 0.0], [0.0; 3]);
            let along = line.update(&spacecraft.input(&load));
            assert_eq!(along.is_some(), opens, "{force} {velocity}");
            assert_eq!(line.is_open(), opens);
            assert_eq!(line.status().flags.has(LawFlags::CONTACT), opens);
        }
    }

    #[test]
    fn a_contact_opens_once_and_is_followed_when_it_goes_apart() {
        let mut line = line(0);
        let load = wrench([5.0, 0.0, 0.0], [0.0; 3]);
        let opened = [-0.001, -0.0005, 0.001, -0.001].map(|velocity| {
            let spacecraft = Spacecraft::before_a_wall([velocity, 0.0, 0.0]);
            line.update(&spacecraft.input(&load)).unwrap().opened
        });
        assert_eq!(opened, [true, false, false, false]);
    }

    /// The contact closes after eight cycles below the threshold, or after as many as a law asks for.
    #[test]
    fn a_contact_is_over_when_it_has_been_quiet_for_long_enough() {
        let spacecraft = Spacecraft::before_a_wall([-0.001, 0.0, 0.0]);
        let (load, none) = (wrench([5.0, 0.0, 0.0], [0.0; 3]), Wrench::zero());
        for (cycles, close) in [
            (
                8,
                ContactLine::close_when_quiet as fn(&mut ContactLine<f64>),
            ),
            (3, |line| line.close_after(3)),
        ] {
            let mut line = line(0);
            for _ in 0..2 {
                line.update(&spacecraft.input(&load));
                for _ in 0..cycles {
                    line.update(&spacecraft.input(&none));
                    close(&mut line);
                    assert!(line.is_open());
                }
            }
            line.update(&spacecraft.input(&none));
            close(&mut line);
            assert!(!line.is_open());
            assert!(line.update(&spacecraft.input(&none)).is_none());
            // The next one has its own direction.
            line.update(&spacecraft.input(&wrench([4.0, -3.0, 0.0], [0.0; 3])));
            assert!((line.direction.force - Vector3::new(0.8, -0.6, 0.0)).norm() < 1e-12);
        }
    }

    /// A wrench of one cycle ago has 0.9 of its weight. Forces are limited to 100 kN and levers to 100 m.
    #[test]
    fn the_direction_is_that_of_the_averaged_force_with_its_lever() {
        let spacecraft = Spacecraft::before_a_wall([-0.001, -0.001, 0.0]);
        let mut line = line(0);
        line.update(&spacecraft.input(&wrench([10.0, 0.0, 0.0], [0.0, 2.0, 0.0])));
        line.update(&spacecraft.input(&wrench([0.0, 12.0, 0.0], [0.0, 0.0, 3.0])));
        let direction = line.direction.get();
        let expected = [9.0, 12.0, 0.0, 0.0, 1.8, 3.0].map(|part| part / 15.0);
        for (found, expected) in direction.into_iter().zip(expected) {
            assert!((found - expected).abs() < 1e-12, "{direction:?}");
        }
        let force = line.wrench(30.0);
        assert!((force.force - Vector3::new(18.0, 24.0, 0.0)).norm() < 1e-12);
        assert!((force.torque - Vector3::new(0.0, 3.6, 6.0)).norm() < 1e-12);
        assert!((line.load(&force) - 30.0).abs() < 1e-12);
        assert_eq!(line.load(&line.wrench(-2e5)), -LARGEST_N);
        line.update(&spacecraft.input(&wrench([10.0, 0.0, 0.0], [0.0, 0.0, 1e6])));
        assert_eq!(line.direction.torque.z, LONGEST_M);
    }

    /// A force that changes its sign leaves a sum of 0.05 N, then of 0.15 N: from a tenth of the threshold on a direction is
    /// taken.
    #[test]
    fn forces_that_cancel_each_other_do_not_turn_the_direction() {
        for (back, turned) in [(-8.95, false), (-9.05, false), (-8.85, true), (-9.15, true)] {
            let spacecraft = Spacecraft::before_a_wall([-0.001, 0.0, 0.0]);
            let mut line = line(0);
            line.update(&spacecraft.input(&wrench([10.0, 0.0, 0.0], [0.0; 3])));
            line.update(&spacecraft.input(&wrench([back, 0.0, 0.0], [0.0, 1.0, 0.0])));
            assert_eq!(line.direction.torque.y != 0.0, turned, "{back}");
        }
    }

    #[test]
    fn motion_along_a_contact_is_that_at_the_lever_of_its_force() {
        let (mut spacecraft, load) = meeting();
        let mut line = line(0);
        line.update(&spacecraft.input(&load)).expect("a contact");
        // Power of a unit force at its lever.
        let power = |spacecraft: &Spacecraft| {
            let twist = spacecraft.input(&load).model;
            let back = spacecraft.measured.rotation.inverse();
            let force = load.force.dot(&(back * twist.linear));
            (force + load.torque.dot(&twist.angular)) / load.force.norm()
        };
        let before = power(&spacecraft);
        let found = line.update(&spacecraft.input(&load)).unwrap();
        assert!((found.velocity - before).abs() < 1e-12);
        assert!((found.load - load.force.norm()).abs() < 1e-9);
        assert_eq!(found.moved, 0.0);
        // The change by a wrench, and the displacement after a cycle.
        spacecraft.step(&load);
        let after = power(&spacecraft);
        let change = found.mobility * load.force.norm() * CYCLE_S;
        assert!(
            (after - before - change).abs() < 1e-2 * change,
            "{before} {after} {change}"
        );
        let moved = line.update(&spacecraft.input(&load)).unwrap().moved;
        let mean = 0.5 * (before + after) * CYCLE_S;
        assert!((moved / mean - 1.0).abs() < 1e-3, "{moved} {mean}");
    }

    /// It is 1 along the contact, and has the direction of the response of the pair to a force along it.
    #[test]
    fn a_push_is_the_motion_that_a_force_along_the_contact_makes() {
        let (spacecraft, load) = meeting();
        let mut line = line(0);
        let input = spacecraft.input(&load);
        assert_eq!(line.push(&input), Twist::zero());
        line.update(&input);
        let push = line.push(&input);
        assert!((line.part(&push, &input) - 1.0).abs() < 1e-12);
        let answer = spacecraft.bodies.mobility(&spacecraft.state, &load);
        let linear = spacecraft.measured.rotation.inverse() * push.linear;
        let scale = answer.angular.norm() / push.angular.norm();
        assert!((linear * scale - answer.linear).norm() < 1e-9 * answer.linear.norm());
        assert!((push.angular * scale - answer.angular).norm() < 1e-9 * answer.angular.norm());
    }

    #[test]
    fn the_load_is_told_as_it_was_when_the_pose_was_true() {
        for latency in [0, 1, 3, 8] {
            let spacecraft = Spacecraft::before_a_wall([-0.001, 0.0, 0.0]);
            let mut line = line(latency);
            // Loads before the contact do not count.
            for cycle in 0..12 {
                let load = wrench([10.0 + f64::from(cycle), 0.0, 0.0], [0.0; 3]);
                let along = line.update(&spacecraft.input(&load)).unwrap();
                let then = f64::from(cycle - i32::from(latency));
                let expected = if then < 0.0 { 0.0 } else { 10.0 + then };
                assert!(
                    (along.load_then - expected).abs() < 1e-12,
                    "{latency} {cycle}"
                );
            }
        }
    }

    /// The settings allow eight cycles.
    #[test]
    fn a_pose_that_is_older_than_all_that_is_kept_counts_as_the_oldest() {
        assert_eq!(line(200).latency, 8);
    }

    #[test]
    fn a_step_is_the_same_turn_with_either_sign_of_the_quaternion() {
        let turn = UnitQuaternion::from_scaled_axis(Vector3::new(2e-4, -3e-4, 1e-4));
        let before = Pose::from_parts(
            Vector3::new(1.0, 2.0, 3.0).into(),
            UnitQuaternion::from_euler_angles(0.3, -0.2, 1.0),
        );
        let after = Pose::from_parts(Vector3::new(1.1, 1.8, 3.3).into(), before.rotation * turn);
        let other = Pose::from_parts(
            after.translation,
            UnitQuaternion::new_unchecked(Quaternion::from(-after.rotation.coords)),
        );
        for after in [after, other] {
            let moved = step(&before, &after);
            assert!((moved.linear - Vector3::new(0.1, -0.2, 0.3)).norm() < 1e-12);
            assert!(
                (moved.angular - turn.scaled_axis()).norm() < 1e-10,
                "{moved:?}"
            );
        }
    }

    /// This holds also where squares would leave fixed point.
    #[test]
    fn a_length_is_that_of_the_vector() {
        use crate::scalar::Fixed;
        let vector = |parts: [f64; 3]| Vector3::from(parts.map(Fixed::of));
        for (parts, expected) in [
            ([0.0; 3], 0.0),
            ([3.0, -4.0, 12.0], 13.0),
            ([3e5, 4e5, 0.0], 5e5),
            ([0.0, 0.0, -1e-3], 1e-3),
        ] {
            let found = length(&vector(parts)).get();
            assert!(
                (found - expected).abs() < 1e-6 * expected.max(1e-3),
                "{parts:?}: {found}"
            );
        }
    }
}
