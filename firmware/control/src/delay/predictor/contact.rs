//! A contact from its onset to its end, with the impulse that it gives between samples.
//!
//! The trapezoidal sum of the measured loads is wrong where they begin and end, between two samples. Both pieces are computed
//! from the identified contact instead, and are bounded by the neighbouring load.

use super::contact_estimator::{Estimate, Information, Prior, direction};
use super::guard::Outcome;
use super::latency_estimator::{Hypothesis, LatencyEstimator, told_apart};
use super::observer::{AtForce, Observer};
use super::preload::Preload;
use super::reference::Reference;
use super::restitution::RestitutionEstimate;
use super::stiffening::{Curve, Stiffening};
use super::tuning::*;
use super::{M6, V6};
use nalgebra::ComplexField;

/// A contact that is going on.
#[derive(Clone, Debug)]
pub(super) struct Contact {
    pub(super) estimator: LatencyEstimator,
    /// Direction of the load: running sum.
    pub(super) load_sum: V6,
    pub(super) mobility: M6,
    /// Velocity of the model before the contact.
    pub(super) velocity: V6,
    /// Cycle of the first load, and the position of the robot then, for each latency.
    first_cycle: usize,
    first_position: [V6; LATENCIES],
    /// Latency that was believed at the first load, cycles.
    pub(super) first_latency: usize,
    /// Impulse along the contact that the model got for the first load, N·s, and the correction that makes it that of the contact
    /// since the onset.
    onset_felt: f64,
    onset_added: f64,
    /// Longest time from the onset to the first load, cycles.
    longest_onset: f64,
    /// Cycles without a significant load.
    quiet: u32,
    /// The last significant load, along the contact, N.
    last: f64,
    noise: f64,
    stiffness: f64,
    delay_sigma_s: f64,
    cycle_s: f64,
    /// Displacement of the commands' preload so far.
    pub(super) preload: Preload,
    /// The latency and, for the positions at it, the parabola through the loads.
    stiffening: (usize, Stiffening),
    /// Error of a load as expected at the onset, N.
    sigma: f64,
}

/// Initial data of a contact.
pub(super) struct Onset<'a> {
    pub(super) velocity: V6,
    pub(super) mobility: M6,
    /// Standard deviation of a load and the least significant one, N.
    pub(super) noise: f64,
    pub(super) threshold: f64,
    /// Expected stiffness, N/m.
    pub(super) stiffness: f64,
    /// Standard deviation of the robot's delay, s.
    pub(super) delay_sigma_s: f64,
    pub(super) remembered: Option<(usize, &'a Information)>,
    /// Latency that is believed, cycles.
    pub(super) latency: usize,
    pub(super) cycle_s: f64,
}

impl Contact {
    pub(super) fn new(observer: &Observer, onset: &Onset<'_>) -> Self {
        let load = &observer.load;
        let (h, bh) = direction(&-load, &onset.mobility);
        let closing = h.dot(&onset.velocity).max(0.0);
        let expected = (onset.stiffness, onset.noise, onset.delay_sigma_s);
        let prior = Prior::new(expected, closing, (h, bh));
        let travel = closing * onset.cycle_s;
        let estimator = LatencyEstimator::new(
            &observer.previous,
            &observer.at_force,
            &prior,
            (closing, travel, onset.threshold.min(load.norm())),
            onset.remembered,
        );
        let per_cycle = (onset.stiffness * travel).max(f64::MIN_POSITIVE);
        Self {
            estimator,
            load_sum: -load,
            mobility: onset.mobility,
            velocity: onset.velocity,
            first_cycle: observer.cycle,
            first_position: observer.at_force.position,
            first_latency: onset.latency,
            onset_felt: 0.5 * load_along(load, &h) * onset.cycle_s,
            onset_added: 0.0,
            longest_onset: 1.0 + (onset.threshold / per_cycle).min(EARLIEST_ONSET - 1.0),
            quiet: 0,
            last: 0.0,
            noise: onset.noise,
            stiffness: onset.stiffness,
            delay_sigma_s: onset.delay_sigma_s,
            cycle_s: onset.cycle_s,
            preload: Preload::default(),
            stiffening: (onset.latency, Stiffening::default()),
            sigma: prior.sigma,
        }
    }

    /// Takes in a cycle's load, N, if it is at least the threshold; else the cycle counts as quiet.
    pub(super) fn add(
        &mut self,
        load: &V6,
        at_force: &AtForce,
        threshold: f64,
        latency: usize,
        only: Option<usize>,
    ) {
        if load.norm() < threshold {
            self.quiet += 1;
            return;
        }
        self.quiet = 0;
        self.load_sum = self.load_sum * DIRECTION_FORGETTING - load;
        let direction = self.direction();
        self.last = load_along(load, &direction.0);
        // The next fit expects errors as large as the residuals so far.
        let prior = self.prior(direction, self.estimate(latency).error);
        let known = (&prior, &self.velocity);
        self.estimator.add(at_force, self.last, known, only);
        self.add_to_parabola(at_force, latency);
    }

    /// Adds the last load, minus that of the damping, to the parabola at the displacement since the first load.
    fn add_to_parabola(&mut self, at_force: &AtForce, latency: usize) {
        if self.stiffening.0 != latency {
            self.stiffening = (latency, Stiffening::default());
        }
        let l = told_apart(latency);
        let estimate = self.estimate(latency);
        let along = |motion: V6| estimate.gradient.dot(&motion);
        let way = along(at_force.position[l] - self.first_position[l]);
        let elastic = self.last - estimate.damping * along(at_force.velocity[l]);
        self.stiffening.1.add(way, elastic);
    }

    /// Load over depth of a contact that stiffens; `None` if it is a linear spring.
    pub(super) fn curve(&self, latency: usize) -> Option<Curve> {
        let estimate = self.estimate(latency);
        let origin = estimate
            .gradient
            .dot(&self.first_position[told_apart(latency)]);
        self.stiffening.1.curve(estimate, origin, self.sigma)
    }

    /// The prior of the contact, from h and Bh and the error of the present fit, N.
    fn prior(&self, (h, bh): (V6, V6), error: f64) -> Prior {
        let closing = h.dot(&self.velocity);
        let expected = (self.stiffness, error.max(self.noise), self.delay_sigma_s);
        Prior::new(expected, closing, (h, bh))
    }

    /// h and Bh: direction of the load with a force part of 1, and velocity per impulse along it.
    pub(super) fn direction(&self) -> (V6, V6) {
        direction(&self.load_sum, &self.mobility)
    }

    /// The contact as identified at a latency.
    pub(super) fn estimate(&self, latency: usize) -> &Estimate {
        &self.estimator.at(latency).estimate
    }

    /// The ideal contact from the onset on.
    pub(super) fn reference(&self, latency: usize) -> Reference {
        let estimate = self.estimate(latency);
        let closing = estimate.gradient.dot(&self.velocity).max(1e-9);
        let since = self.since_onset(latency);
        let first = self.first_position[told_apart(latency)];
        let onset = (
            self.first_cycle as f64 - since,
            first - self.velocity * (since * self.cycle_s),
        );
        Reference::into_contact(estimate, onset, (self.velocity, closing))
    }

    /// Time from the onset to the first load, cycles.
    fn since_onset(&self, latency: usize) -> f64 {
        let estimate = self.estimate(latency);
        let closing = estimate.gradient.dot(&self.velocity).max(1e-9);
        let first = &self.first_position[told_apart(latency)];
        let depth = estimate.gradient.dot(first) - estimate.surface;
        (depth / (closing * self.cycle_s)).clamp(0.0, self.longest_onset)
    }

    /// Impulse along the contact (N·s) that is still to be added for the time from the onset to the first load: the sum of the
    /// samples has a triangle there, while the spacecraft feel ∫ (k v t + c v) dt.
    pub(super) fn onset_correction(&mut self, latency: usize) -> f64 {
        let estimate = self.estimate(latency);
        let closing = estimate.gradient.dot(&self.velocity).max(0.0);
        let t = self.since_onset(latency) * self.cycle_s;
        let impulse = (estimate.damping + 0.5 * estimate.stiffness * t) * closing * t;
        // Bounded by the first load, whatever is identified.
        let most = self.onset_felt.abs() * self.longest_onset;
        let wanted = (impulse - self.onset_felt).clamp(-most, most);
        let step = wanted - self.onset_added;
        self.onset_added = wanted;
        step
    }

    /// Impulse along the contact (N·s) to be added in the first quiet cycle, negative: the trapezoid from the last significant
    /// load to this cycle is too large, as the contact ended in between. 0 in any other cycle.
    pub(super) fn release_correction(&self, velocity: &V6, latency: usize) -> f64 {
        if self.quiet != 1 || self.last <= 0.0 {
            return 0.0;
        }
        let estimate = self.estimate(latency);
        let leaving = -estimate.gradient.dot(velocity);
        if leaving <= 0.0 {
            return 0.0;
        }
        let left = (self.last / (estimate.stiffness * leaving)).min(self.cycle_s);
        0.5 * self.last * (left - self.cycle_s)
    }

    /// Whether the contact is over at a cycle, or has lasted longer than the identified one could. `delay` is that from a command
    /// to its execution, cycles.
    pub(super) fn is_over(&self, cycle: usize, reference: &Reference, delay: f64) -> bool {
        let end = reference.end(self.cycle_s);
        let late = cycle as f64 > end || f64::from(self.quiet) >= delay + QUIET_CYCLES_LATE;
        let longest =
            DURATION_LIMIT * (end - reference.onset) + delay + DURATION_MARGIN_S / self.cycle_s;
        (self.quiet >= QUIET_CYCLES && late) || (cycle - self.first_cycle) as f64 > longest
    }

    /// The information on the contact, to be remembered for the next one at the same place.
    pub(super) fn information(&self, latency: usize) -> Information {
        let mut information = self.estimator.at(latency).information.clone();
        information.end(self.estimate(latency).gradient.dot(&self.velocity));
        information
    }

    /// The outcome of the contact, from the velocity of the axes after it and the noise of a load (N).
    pub(super) fn outcome(
        &self,
        latency: usize,
        reference: &Reference,
        after: &V6,
        noise: f64,
    ) -> Outcome {
        let estimate = self.estimate(latency);
        let closing = reference.closing;
        let impedance = ComplexField::sqrt(estimate.stiffness * estimate.mass);
        let peak = closing * impedance.max(f64::MIN_POSITIVE);
        let loads = f64::from(self.estimator.loads());
        let momentum = estimate.mass * closing;
        Outcome {
            closing,
            after: estimate.gradient.dot(after),
            restitution: reference.restitution(),
            misfit: estimate.misfit,
            noise_misfit: noise / (MEAN_LOAD * peak),
            noise: noise * self.cycle_s * ComplexField::sqrt(loads) / momentum,
        }
    }

    /// The restitution that follows from all loads with this noise (N), and the velocity of the axes after the contact.
    pub(super) fn restitution(
        &self,
        latency: usize,
        after: &V6,
        noise: f64,
    ) -> RestitutionEstimate {
        let Hypothesis {
            information,
            estimate,
        } = self.estimator.at(latency);
        let direction = self.direction();
        let prior = self.prior(direction, estimate.error);
        let loads = f64::from(self.estimator.loads());
        let noise = noise / direction.0.norm();
        let velocities = (&self.velocity, after);
        RestitutionEstimate::new(information, estimate, &prior, velocities, (loads, noise))
    }
}

/// λ: the load along h, N, positive for a push against h.
fn load_along(load: &V6, h: &V6) -> f64 {
    -load.dot(h) / h.norm_squared()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::delay::predictor::bounce::{
        Bounce, CLOSING, FIRST, MASS, OMEGA, STIFFNESS, SURFACE, assert_near, x,
    };
    use crate::delay::spacecraft::CYCLE_S;

    /// For any time from the onset to the first load within a cycle.
    #[test]
    fn the_reference_is_the_motion_of_the_contact() {
        for (zeta, phase) in [(0.0, 0.1), (0.0, 0.9), (0.1, 0.4)] {
            let bounce = Bounce {
                zeta,
                ..Bounce::spring(phase)
            };
            let contact = bounce.followed(0.01, 25);
            let reference = contact.reference(0);
            assert_near(reference.onset, FIRST as f64 - phase, 1e-4);
            assert_near(reference.closing, CLOSING, 1e-3);
            for cycle in [45, 55, 70, 100] {
                let found = reference.position_at(cycle as f64, CYCLE_S)[0] - SURFACE;
                let depth = bounce.at(bounce.time(cycle)).depth;
                assert!(
                    (found - depth).abs() < 1e-7,
                    "{zeta} {phase} {cycle}: {found} {depth}"
                );
            }
        }
    }

    /// From the onset to the first load the samples give half of that load over a cycle.
    #[test]
    fn what_the_samples_cannot_see_of_the_onset_is_added() {
        for (zeta, phase) in [(0.0, 0.1), (0.0, 0.5), (0.0, 1.0), (0.1, 0.3), (0.2, 0.8)] {
            let bounce = Bounce {
                zeta,
                ..Bounce::spring(phase)
            };
            let mut contact = bounce.begun(0.01);
            let mut added = 0.0;
            for cycle in FIRST..FIRST + 25 {
                let observer = bounce.observer(cycle);
                contact.add(&observer.load, &observer.at_force, 0.01, 0, Some(0));
                added += contact.onset_correction(0);
            }
            let until = phase * CYCLE_S;
            let exact: f64 = (0..1000)
                .map(|n| bounce.at((f64::from(n) + 0.5) / 1000.0 * until).load * until / 1000.0)
                .sum();
            let seen = 0.5 * bounce.at(until).load * CYCLE_S;
            let error = added - (exact - seen);
            assert!(
                error.abs() < 0.01 * seen,
                "{zeta} {phase}: {added} {exact} {seen}"
            );
        }
    }

    /// Bounded by the first load over the longest time that may have passed before it, whatever is identified.
    #[test]
    fn what_is_added_at_the_onset_is_bounded_by_the_first_load() {
        for (threshold, longest) in [(0.0, 1.0), (6.0, 3.0)] {
            let mut contact = Bounce::spring(0.9).begun(threshold);
            let felt = 0.5 * Bounce::spring(0.9).at(0.9 * CYCLE_S).load * CYCLE_S;
            assert_near(contact.onset_felt, felt, 1e-9);
            // A first load that was hardly felt.
            contact.onset_felt = 1e-9;
            assert_near(contact.onset_correction(0), longest * 1e-9, 1e-6);
        }
    }

    /// 0.5 N are reached in the third cycle after the onset: the onset is at most three cycles, and one more, before the first
    /// load.
    #[test]
    fn an_onset_is_as_old_as_the_threshold_may_hide() {
        // With the expected stiffness of 150 kN/m and 20 µm per cycle.
        for (threshold, longest) in [(0.0, 1.0), (6.0, 3.0), (99.0, 8.0)] {
            assert_near(
                Bounce::spring(2.5).begun(threshold).longest_onset,
                longest,
                1e-12,
            );
        }
        for (threshold, phase, since) in [(6.0, 2.5, 2.5), (6.0, 4.0, 3.0), (0.0, 2.5, 1.0)] {
            let mut contact = Bounce::spring(phase).begun(threshold);
            for cycle in FIRST..FIRST + 25 {
                let observer = Bounce::spring(phase).observer(cycle);
                contact.add(&observer.load, &observer.at_force, 0.01, 0, Some(0));
            }
            let found = contact.since_onset(0);
            assert!((found - since).abs() < 0.1, "{threshold} {phase}: {found}");
        }
    }

    /// The contact ended between the last significant load and the first free sample: up to half of that load over a cycle is too
    /// much.
    #[test]
    fn what_the_samples_cannot_see_of_the_end_is_taken_away() {
        for phase in [0.1, 0.45, 0.8] {
            let bounce = Bounce::spring(phase);
            let contact = |cycles| bounce.followed(1e-3, cycles);
            let end = core::f64::consts::PI / OMEGA / CYCLE_S - phase;
            let (last, first_free) = (end.floor(), end.floor() as usize + 1);
            let load = bounce.at((last + phase) * CYCLE_S).load;
            let expected = 0.5 * load * CYCLE_S * ((end - last) - 1.0);
            let velocity = x(bounce.at(bounce.time(FIRST + first_free)).rate);
            let found = contact(first_free + 1).release_correction(&velocity, 0);
            assert!(
                (found - expected).abs() < 1e-3 * load * CYCLE_S,
                "{phase}: {found} {expected}"
            );
            // Only once, and only if the two separate.
            assert_eq!(contact(first_free).release_correction(&velocity, 0), 0.0);
            assert_eq!(
                contact(first_free + 2).release_correction(&velocity, 0),
                0.0
            );
            let closing = contact(first_free + 1).release_correction(&-velocity, 0);
            assert_eq!(closing, 0.0);
            // A slow contact has ended at the end of the cycle.
            let slow = contact(first_free + 1).release_correction(&(velocity * 1e-6), 0);
            assert_eq!(slow, 0.0);
        }
    }

    /// It is over after four quiet cycles if it should be over, or when it has been quiet for six and the delay; in any case
    /// after 2.2 times its own duration, the delay and 50 ms.
    #[test]
    fn a_contact_is_over_when_it_is_quiet_at_the_right_time() {
        let mut contact = Bounce::spring(0.5).followed(0.01, 25);
        let reference = contact.reference(0);
        let end = reference.end(CYCLE_S);
        assert!((end - 86.9).abs() < 0.1, "{end}");
        for (quiet, cycle, delay, over) in [
            (3, 88, 8.0, false),
            (4, 88, 8.0, true),
            (4, 86, 8.0, false),
            (13, 70, 8.0, false),
            (14, 70, 8.0, true),
            (15, 70, 9.5, false),
            (16, 70, 9.5, true),
            (0, 152, 8.0, false),
            (0, 153, 8.0, true),
            (0, 153, 9.0, false),
        ] {
            contact.quiet = quiet;
            let found = contact.is_over(cycle, &reference, delay);
            assert_eq!(found, over, "{quiet} {cycle} {delay}");
        }
    }

    #[test]
    fn a_contact_is_quiet_since_its_last_significant_load() {
        let bounce = Bounce::spring(0.5);
        let mut contact = bounce.begun(1.0);
        let loads = [2.0, 0.9, 0.9, 1.0, 0.5];
        let quiet = loads.map(|load| {
            let observer = bounce.observer(FIRST + 3);
            contact.add(&x(-load), &observer.at_force, 1.0, 0, Some(0));
            contact.quiet
        });
        assert_eq!(quiet, [0, 1, 2, 0, 1]);
        assert_near(contact.last, 1.0, 1e-12);
        assert_eq!(contact.estimator.loads(), 2);
    }

    /// A memory of ten cycles.
    #[test]
    fn the_direction_of_a_contact_is_that_of_its_recent_loads() {
        let bounce = Bounce::spring(0.5);
        let mut contact = bounce.begun(0.01);
        let observer = bounce.observer(FIRST);
        let mut sum = -observer.load;
        for load in [
            x(-3.0),
            V6::new(-3.0, 4.0, 0.0, 0.0, 0.0, 1.0),
            V6::new(0.0, 2.0, 0.0, 0.0, 0.0, 0.0),
        ] {
            contact.add(&load, &observer.at_force, 0.01, 0, Some(0));
            sum = sum * 0.9 - load;
        }
        let (h, bh) = contact.direction();
        let expected = sum / sum.fixed_rows::<3>(0).norm();
        assert!((h - expected).amax() < 1e-12, "{h} {expected}");
        assert!((bh - expected / MASS).amax() < 1e-15, "{bh}");
        // λ is the component of a load along h, so that λ h is the load.
        assert_near(load_along(&(h * -7.0), &h), 7.0, 1e-12);
        assert_near(
            contact.last,
            load_along(&V6::new(0.0, 2.0, 0.0, 0.0, 0.0, 0.0), &h),
            1e-12,
        );
    }

    /// Relative to the peak V √(k m) and to the momentum m V.
    #[test]
    fn the_outcome_tells_what_noise_makes_of_it() {
        for zeta in [0.0, 0.1] {
            let bounce = Bounce {
                zeta,
                ..Bounce::spring(0.5)
            };
            let contact = bounce.followed(0.01, 36);
            let loads = f64::from(contact.estimator.loads());
            let reference = contact.reference(0);
            let outcome = contact.outcome(0, &reference, &x(-0.004), 0.3);
            assert_near(outcome.closing, CLOSING, 1e-3);
            assert_near(outcome.after, -0.004, 1e-3);
            let angle = core::f64::consts::PI - 2.0 * f64::asin(zeta);
            let e = (-zeta / (1.0 - zeta * zeta).sqrt() * angle).exp();
            assert_near(outcome.restitution, e, 1e-3);
            assert!(outcome.misfit < 1e-3 && outcome.fits());
            let peak = CLOSING * MASS * OMEGA;
            assert_near(outcome.noise_misfit, 0.3 / (0.7 * peak), 1e-3);
            assert_near(
                outcome.noise,
                0.3 * CYCLE_S * loads.sqrt() / (MASS * CLOSING),
                1e-3,
            );
            // A damping that the loads show is not reported as hidden by noise.
            let estimate = contact.restitution(0, &x(-0.004), 0.3);
            assert!(!estimate.hides_damping || zeta == 0.0);
        }
    }

    /// A load with a lever is larger than its force.
    #[test]
    fn the_noise_of_a_load_counts_by_its_length() {
        let mut contact = Bounce::spring(0.5).followed(0.01, 36);
        contact.load_sum[4] = 2.0 * contact.load_sum[0];
        let (direction, after) = (contact.direction(), x(-0.004));
        let Hypothesis {
            information,
            estimate,
        } = contact.estimator.at(0);
        let prior = contact.prior(direction, estimate.error);
        let mut hidden = 0;
        for n in 0..60 {
            let noise = 1e-3 * 1.25_f64.powi(n);
            let alone = (36.0, noise / 5.0_f64.sqrt());
            let velocities = (&contact.velocity, &after);
            let expected =
                RestitutionEstimate::new(information, estimate, &prior, velocities, alone);
            let found = contact.restitution(0, &after, noise);
            assert_eq!(found.hides_damping, expected.hides_damping, "{noise}");
            hidden += usize::from(found.hides_damping);
        }
        assert!((1..60).contains(&hidden), "{hidden}");
    }

    /// Loads of the curve that was found and of the spring, at three depths.
    fn curve_and_spring(contact: &Contact) -> [(f64, f64); 3] {
        let curve = contact.curve(0).expect("a curve");
        [5e-5, 1e-4, 2e-4].map(|depth| {
            let inside = SURFACE + depth - curve.surface;
            let felt = (curve.stiffness + curve.stiffening * inside) * inside;
            (felt, (STIFFNESS + 4e8 * depth) * depth)
        })
    }

    /// 220 kN/m where it is free, and twice as much at its deepest.
    #[test]
    fn a_contact_that_hardens_has_a_curve() {
        let bounce = Bounce {
            stiffening: 4e8,
            ..Bounce::spring(0.5)
        };
        let contact = bounce.followed(0.01, 30);
        for (felt, load) in curve_and_spring(&contact) {
            assert_near(felt, load, 0.02);
        }
        // At another latency it is fitted anew, and a linear spring has no curve.
        let mut other = contact.clone();
        let observer = bounce.observer(FIRST + 30);
        other.add(&observer.load, &observer.at_force, 0.01, 1, None);
        assert_eq!(other.stiffening.0, 1);
        assert!(other.curve(1).is_none());
        assert!(Bounce::spring(0.5).followed(0.01, 30).curve(0).is_none());
    }

    /// The curve is that of the spring alone; the loads of the damper are subtracted.
    #[test]
    fn a_damped_contact_that_hardens_has_the_curve_of_its_spring() {
        let bounce = Bounce {
            zeta: 0.02,
            stiffening: 4e8,
            ..Bounce::spring(0.5)
        };
        for (felt, load) in curve_and_spring(&bounce.followed(0.01, 30)) {
            assert!((felt - load).abs() < 3.0, "{felt} {load}");
        }
    }

    /// The loads of a damper grow with the velocity, not with the depth.
    #[test]
    fn a_damped_spring_has_no_curve() {
        let damped = Bounce {
            zeta: 0.3,
            ..Bounce::spring(0.5)
        };
        assert!(damped.followed(0.01, 25).curve(0).is_none());
    }
}
