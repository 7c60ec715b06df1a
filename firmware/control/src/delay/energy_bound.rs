//! The energy bound: a contact gives back no more than it took, whatever a law believes.
//!
//! The work of the felt wrench w on both spacecraft together is the exact change of their kinetic energy: with v
//! the velocity of K seen from Q at M, and B the inverse inertia of the pair,
//!
//! ```text
//! ΔE = ½ (v + B w Ts)ᵀ B⁻¹ (v + B w Ts) − ½ vᵀ B⁻¹ v = w·v Ts + ½ wᵀ B w Ts²
//! ```
//!
//! Summed since the touch this is the energy that the mechanism has given. A passive mechanism has never given any, whatever the
//! direction and the shape of its force. A wrench with which the sum would exceed [`SLACK`] times the energy taken before is
//! scaled down until the sum is zero: the factor is the root, between 0 and 1, of a quadratic. Neither a contact model nor a
//! delay is needed, and no position feedback.
//!
//! It bounds energy, not momentum: the impulse by which the scaled wrench falls short is in the trace (`unaccounted_impulse`).

use super::LawInput;
use crate::dynamics::relative_velocity;
use crate::frames::Wrench;
use crate::scalar::Scalar;
use core::marker::PhantomData;
use nalgebra::ComplexField;

/// Energy that may be given back beyond what was taken, as a fraction of the latter: noise and sampling of a force make as much.
/// ↑ lets energy through; ↓ acts on rebounds that are right.
const SLACK: f64 = 0.008;
/// Cycles without a load after which a contact is over: longer than any law takes to end one (`smith`: 64).
const QUIET_CYCLES: u32 = 72;
/// Forgetting factor of the work before the touch, per cycle: ten cycles, in which a slow contact grows to its threshold.
const EARLIER: f64 = 0.9;
/// Lever by which a torque is compared with a force, m.
const ARM_M: f64 = 0.3;
/// Load below which work is neglected, N and N·m.
const LEAST_LOAD: f64 = 1e-3;
/// Size of the wrench for which the mobility is evaluated, N and N·m; the result is scaled. At the ends of all ranges (10⁻³ kg·m²
/// at a lever of 10³ m) the response to a larger one would leave fixed point.
const PROBE_LOAD: f64 = 1e-2;

/// The energy balance of a contact. It computes in f64 whatever the scalar type of the cycle is, as energies of light and heavy
/// spacecraft are too far apart for fixed point.
#[derive(Clone, Debug)]
pub(super) struct EnergyBound<S: Scalar> {
    cycle_s: f64,
    /// Force from which a contact counts, N.
    threshold_n: f64,
    /// Work on the spacecraft since the touch, and the least that it has been, J.
    work: f64,
    least: f64,
    /// What the last contact gave beyond what it took, J: the balance of the next one starts with it.
    debt: f64,
    /// Cycles since the last load; none before the first.
    quiet: Option<u32>,
    /// The wrench was scaled down in this cycle.
    pub(super) acts: bool,
    scalar: PhantomData<S>,
}

impl<S: Scalar> EnergyBound<S> {
    /// No contact yet; a contact counts from `threshold_n`, the cycle in s.
    pub(super) fn new(threshold_n: f64, cycle_s: f64) -> Self {
        Self {
            cycle_s,
            threshold_n,
            work: 0.0,
            least: 0.0,
            debt: 0.0,
            quiet: None,
            acts: false,
            scalar: PhantomData,
        }
    }

    /// The wrench that the spacecraft may feel in place of `felt`, at M in axes of M: `felt` itself, or scaled down.
    pub(super) fn bounded(&mut self, input: &LawInput<'_, S>, felt: Wrench<S>) -> Wrench<S> {
        self.acts = false;
        self.follow(&input.wrench.get());
        let (linear, quadratic) = self.work_of(input, &felt);
        let given = self.work + linear + quadratic;
        if self.quiet.is_none() {
            // A load that is still below the threshold belongs to the contact to come: its work is kept, with forgetting.
            self.work = given * EARLIER;
            self.least = self.work.min(0.0);
            return felt;
        }
        if given <= -self.least * SLACK {
            self.account(given);
            return felt;
        }
        self.acts = true;
        let share = largest_share(linear, quadratic, -self.work);
        self.account(self.work + (linear + quadratic * share) * share);
        felt * S::of(share)
    }

    /// Follows whether there is a contact, by the measured wrench, and closes the balance at its end.
    fn follow(&mut self, [x, y, z, a, b, c]: &[f64; 6]) {
        let largest = |parts: [&f64; 3]| parts.into_iter().fold(0.0, |m: f64, v| m.max(v.abs()));
        let load = largest([x, y, z]).max(largest([a, b, c]) / ARM_M);
        let loaded = load >= self.threshold_n;
        self.quiet = match self.quiet {
            Some(_) if loaded => Some(0),
            None if loaded => {
                self.work += self.debt;
                Some(0)
            }
            Some(quiet) if quiet < QUIET_CYCLES => Some(quiet + 1),
            Some(_) => {
                self.debt = self.work.max(0.0);
                (self.work, self.least) = (0.0, 0.0);
                None
            }
            None => None,
        };
    }

    fn account(&mut self, work: f64) {
        self.work = work;
        self.least = self.least.min(work);
    }

    /// w·v Ts and ½ wᵀ B w Ts², J.
    fn work_of(&self, input: &LawInput<'_, S>, felt: &Wrench<S>) -> (f64, f64) {
        let parts = felt.get();
        let size = parts.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
        if size < LEAST_LOAD {
            return (0.0, 0.0);
        }
        let along = |motion: [f64; 6]| parts.iter().zip(motion).map(|(w, v)| w * v).sum::<f64>();
        // In axes of the model's K, to which the wrench is applied: the robot's own attitude is late.
        let (k, q) = (&input.state.k, &input.state.q);
        let relative = relative_velocity(k, q);
        let in_c = q.c_from_body.rotation * relative.linear;
        let linear = (k.c_from_body.rotation.inverse() * in_c).map(S::get);
        let angular = relative.angular.map(S::get);
        let before = [
            linear.x, linear.y, linear.z, angular.x, angular.y, angular.z,
        ];
        let scale = PROBE_LOAD / size;
        let probe = Wrench::of(&parts.map(|part| part * scale));
        let answer = input.bodies.mobility(input.state, &probe).get();
        let change = answer.map(|v| v / scale * self.cycle_s);
        let ts = self.cycle_s;
        (along(before) * ts, 0.5 * along(change) * ts)
    }
}

/// The largest share α of a wrench with α a + α² b ≤ `room`, for a wrench that as a whole gives more; b ≥ 0.
fn largest_share(a: f64, b: f64, room: f64) -> f64 {
    if room <= 0.0 && a >= 0.0 {
        return 0.0;
    }
    let root = ComplexField::sqrt((a * a + 4.0 * b * room).max(0.0));
    // The form that does not cancel: for a ≥ 0, and for a < 0 where room may be negative.
    let share = if a >= 0.0 {
        2.0 * room / (a + root).max(f64::MIN_POSITIVE)
    } else {
        (root - a) / (2.0 * b).max(f64::MIN_POSITIVE)
    };
    share.clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::delay::spacecraft::{CYCLE_S, Spacecraft};
    use crate::settings::BodySettings;

    /// With the share α, α a + α² b equals the room, and no larger share does.
    #[test]
    fn the_share_is_the_largest_that_leaves_no_more_than_the_room() {
        for (a, b, room) in [
            (1.0_f64, 0.5, 0.2_f64),
            (-1.0, 2.0, 0.1),
            (-1.0, 2.0, 0.0),
            (-0.2, 0.1, 0.3),
            (1.0, 0.0, 0.5),
            (1.0, 0.5, 0.0),
            (0.3, 0.4, -0.1),
            (-0.3, 0.4, -0.01),
            (4e5, 3e3, 2e5),
        ] {
            let share = largest_share(a, b, room);
            let given = |share: f64| share * (a + share * b);
            assert!((0.0..=1.0).contains(&share), "{a} {b} {room}: {share}");
            let most = room.max(0.0) + 1e-9;
            assert!(given(share) <= most, "{a} {b} {room}: {share}");
            let larger = share * (1.0 + 1e-6) + 1e-9;
            let is_largest = share == 1.0 || given(larger) > room;
            assert!(is_largest, "{a} {b} {room}: {share}");
            if room < 0.0 && a < 0.0 {
                assert!((given(share) - room).abs() < 1e-9, "{a} {b} {room}");
            }
        }
    }

    /// Two rotating spacecraft, far apart, with equal moments of inertia, so that nothing but the wrench changes their energy.
    fn turning() -> Spacecraft {
        let k = BodySettings {
            mass_kg: 300.0,
            position_m: [1.2, -0.7, 0.4],
            orientation_wxyz: [0.8, 0.3, -0.4, 0.33],
            velocity_m_s: [0.02, -0.01, 0.03],
            angular_velocity_rad_s: [0.02, 0.03, -0.01],
            ..BodySettings::default()
        };
        let q = BodySettings {
            mass_kg: 900.0,
            orientation_wxyz: [0.7, -0.2, 0.5, 0.4],
            velocity_m_s: [-0.01, 0.02, 0.0],
            angular_velocity_rad_s: [-0.03, 0.01, 0.02],
            ..BodySettings::default()
        };
        Spacecraft::new(&k, &q)
    }

    #[test]
    fn the_work_of_a_wrench_is_the_change_of_the_kinetic_energy() {
        let bound = EnergyBound::new(1.0, CYCLE_S);
        for size in [1e-2, 1.0, 100.0, 1e4] {
            let mut spacecraft = turning();
            // The robot's pose does not enter, as its attitude is late.
            let wrench = Wrench::of(&[0.7, -0.4, 0.2, 0.1, -0.3, 0.25].map(|part| part * size));
            let before = spacecraft.energy();
            let (linear, quadratic) = bound.work_of(&spacecraft.input(&wrench), &wrench);
            spacecraft.step(&wrench);
            let work = spacecraft.energy() - before;
            let error = linear + quadratic - work;
            assert!(error.abs() < 1e-9 * work.abs() + 1e-13, "{size}: {error:e}");
        }
        // Too little to count.
        let small = Wrench::of(&[9e-4; 6]);
        let none = bound.work_of(&turning().input(&small), &small);
        assert_eq!(none, (0.0, 0.0));
    }

    /// A bounce of both spacecraft off a spring whose force is felt `late` cycles late, and multiplied by `gain` on the way out.
    /// Returns the kinetic energy after over that before, and the number of cycles in which the bound acted.
    fn bounce(bound: &mut EnergyBound<f64>, late: usize, gain: f64) -> (f64, usize) {
        let mut spacecraft = Spacecraft::before_a_wall([0.005, 0.0, 0.0]);
        let before = spacecraft.energy();
        let (mut loads, mut acted) = ([0.0; 16], 0);
        for _ in 0..400 {
            let x = spacecraft.state.k.c_from_body.translation.x - 1e-4;
            let leaves = spacecraft.state.k.velocity.linear.x < 0.0;
            loads.rotate_right(1);
            loads[0] = -220_500.0 * x.max(0.0) * if leaves { gain } else { 1.0 };
            let wrench = Wrench::of(&[loads[late], 0.0, 0.0, 0.0, 0.0, 0.0]);
            let taken = -bound.work;
            let felt = bound.bounded(&spacecraft.input(&wrench), wrench);
            acted += usize::from(bound.acts);
            // It gives back what was taken, and nothing if that is negative.
            let rest = bound.work - (-taken).max(0.0);
            assert!(!bound.acts || rest.abs() < 1e-12, "{rest:e}");
            assert_eq!(bound.acts, felt != wrench);
            spacecraft.step(&felt);
        }
        (spacecraft.energy() / before, acted)
    }

    #[test]
    fn a_contact_gives_back_no_more_than_it_took() {
        for (late, gain) in [(4, 1.0), (8, 1.0), (0, 1.3), (0, 3.0)] {
            let (energy, acted) = bounce(&mut EnergyBound::new(1.0, CYCLE_S), late, gain);
            assert!(acted > 0, "{late} {gain}");
            let given = energy - 1.0;
            assert!((-1e-9..=SLACK).contains(&given), "{late} {gain}: {given}");
        }
    }

    #[test]
    fn a_contact_that_gives_back_less_than_it_took_is_left_alone() {
        for gain in [0.8, 0.5, 0.0] {
            let (_, acted) = bounce(&mut EnergyBound::new(1.0, CYCLE_S), 0, gain);
            assert_eq!(acted, 0, "{gain}");
        }
    }

    /// The slack is granted once, not in every contact.
    #[test]
    fn what_a_contact_gave_is_taken_back_by_the_next() {
        let mut bound = EnergyBound::new(1.0, CYCLE_S);
        let given: f64 = (0..20).map(|_| bounce(&mut bound, 0, 1.02).0 - 1.0).sum();
        assert!((-1e-9..=SLACK).contains(&given), "{given}");
    }

    /// The wrench that is felt of this one while K moves at 10 mm/s, 40 µm in a cycle.
    fn pull(bound: &mut EnergyBound<f64>, wrench: [f64; 6]) -> [f64; 6] {
        let spacecraft = Spacecraft::before_a_wall([0.01, 0.0, 0.0]);
        let wrench = Wrench::of(&wrench);
        bound.bounded(&spacecraft.input(&wrench), wrench).get()
    }

    /// Energy that the ten cycles before the touch gave is owed, energy that they took may be given back: 9 times 0.5 N · 40 µm,
    /// and half of that at the 4 µm/s by which it changes the velocity.
    #[test]
    fn a_load_that_grows_to_the_threshold_belongs_to_the_contact() {
        let (before, touch) = (
            [0.5, 0.0, 0.0, 0.0, 0.0, 0.0],
            [2.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        );
        for sign in [1.0, -1.0] {
            let mut bound = EnergyBound::new(1.0, CYCLE_S);
            for _ in 0..200 {
                let load = before.map(|part| sign * part);
                assert_eq!(pull(&mut bound, load), load);
            }
            let cycle = 0.5 * (sign * 4e-5 + 0.5 * 4e-6 * CYCLE_S);
            let expected = 9.0 * cycle;
            assert!(
                (bound.work - expected).abs() < 1e-6 * expected.abs(),
                "{}",
                bound.work
            );
            assert_eq!(bound.least, bound.work.min(0.0));
            // A load that gave energy has to take first; one that took may give.
            let share = pull(&mut bound, touch)[0] / 2.0;
            assert_eq!(share, if sign > 0.0 { 0.0 } else { 1.0 });
        }
    }

    /// 0.3 N·m count as 1 N, with a lever of 0.3 m.
    #[test]
    fn a_contact_counts_from_its_threshold_by_force_or_by_torque() {
        for (load, counts) in [
            ([1.0, 0.0, 0.0, 0.0, 0.0, 0.0], true),
            ([0.0, 0.0, -1.0, 0.0, 0.0, 0.0], true),
            ([0.0, 0.0, 0.0, 0.0, -0.3001, 0.0], true),
            ([0.99, -0.99, 0.99, 0.29, 0.29, -0.29], false),
        ] {
            let mut bound = EnergyBound::<f64>::new(1.0, CYCLE_S);
            bound.follow(&load);
            assert_eq!(bound.quiet.is_some(), counts, "{load:?}");
        }
    }

    /// A contact is over after 72 quiet cycles; a load in between restarts the count. What it gave beyond what it took is owed by
    /// the next.
    #[test]
    fn a_contact_is_over_when_it_has_been_quiet_for_long_enough() {
        let (load, none) = ([2.0, 0.0, 0.0, 0.0, 0.0, 0.0], [0.0; 6]);
        let mut bound = EnergyBound::<f64>::new(1.0, CYCLE_S);
        bound.follow(&load);
        (bound.work, bound.least) = (0.5, -3.0);
        for _ in 0..2 {
            (0..QUIET_CYCLES).for_each(|_| bound.follow(&none));
            assert!(bound.quiet.is_some());
            bound.follow(&load);
        }
        (0..=QUIET_CYCLES).for_each(|_| bound.follow(&none));
        assert_eq!(bound.quiet, None);
        assert_eq!((bound.work, bound.least, bound.debt), (0.0, 0.0, 0.5));
        bound.work = 0.1;
        bound.follow(&load);
        assert_eq!(bound.work, 0.6);
        // One that took more than it gave carries nothing over.
        bound.work = -1.0;
        (0..=QUIET_CYCLES).for_each(|_| bound.follow(&none));
        assert_eq!(bound.debt, 0.0);
    }
}
