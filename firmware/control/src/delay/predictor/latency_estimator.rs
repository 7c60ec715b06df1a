//! The multiple-model latency estimator. The pose may be older than the force by an unknown number of cycles: the contact is
//! estimated for each possible latency (a bank of models, Magill 1965), and the one with the smallest squared error is believed.

use super::V6;
use super::contact_estimator::{Estimate, Information, Prior};
use super::observer::AtForce;
use super::tuning::*;
use nalgebra::ComplexField;

/// A latency, limited to the largest for which there is a hypothesis.
pub(super) fn told_apart(latency: usize) -> usize {
    latency.min(LATENCIES - 1)
}

/// The identification at one latency.
#[derive(Clone, Debug)]
pub(super) struct Hypothesis {
    pub(super) information: Information,
    pub(super) estimate: Estimate,
}

/// The multiple-model latency estimator.
#[derive(Clone, Debug)]
pub(super) struct LatencyEstimator {
    hypotheses: [Hypothesis; LATENCIES],
    loads: u32,
    /// The latency is beyond doubt.
    pub(super) settled: bool,
    /// The largest latency that is not refuted.
    pub(super) latest: usize,
    /// Displacement between the last free and the first loaded sample, m, and the error of the load at the onset that is added to
    /// that of the displacement, N.
    onset: (f64, f64),
    /// Error of a load as expected at the onset, N.
    sigma: f64,
}

impl LatencyEstimator {
    /// A new contact. It began between the previous positions and those now, with a closing velocity (m/s) and a displacement
    /// between the two samples (m). The force at the onset is zero within a threshold (N). `remembered` is the information on an
    /// earlier contact there, with the latency at which it was identified.
    pub(super) fn new(
        previous: &[V6; LATENCIES],
        now: &AtForce,
        prior: &Prior,
        (closing, travel, threshold): (f64, f64, f64),
        remembered: Option<(usize, &Information)>,
    ) -> Self {
        let onset = (travel, threshold);
        let deviation = onset_deviation(prior.stiffness, onset);
        let hypothesis = |l: usize| {
            let middle = (previous[l] + now.position[l]) * 0.5;
            let mut information = Information::new(middle);
            if let Some((latency, known)) = remembered
                && latency == l
            {
                information = known.clone();
            }
            information.begin(&middle, closing, deviation, prior.sigma);
            let estimate = information.solve(prior, closing);
            Hypothesis {
                information,
                estimate,
            }
        };
        Self {
            hypotheses: core::array::from_fn(hypothesis),
            loads: 0,
            settled: false,
            latest: LATENCIES - 1,
            onset,
            sigma: prior.sigma,
        }
    }

    /// The hypothesis of a latency.
    pub(super) fn at(&self, latency: usize) -> &Hypothesis {
        &self.hypotheses[told_apart(latency)]
    }

    /// Takes in a load λ, N, in a contact that began with a velocity of the axes. When the latency is known, `only` is the one
    /// hypothesis that is updated, which saves time.
    pub(super) fn add(
        &mut self,
        now: &AtForce,
        load: f64,
        (prior, before): (&Prior, &V6),
        only: Option<usize>,
    ) {
        self.loads += 1;
        for (l, hypothesis) in self.hypotheses.iter_mut().enumerate() {
            if now.resumed[l] || only.is_some_and(|only| only != l) {
                continue;
            }
            let Hypothesis {
                information,
                estimate,
            } = hypothesis;
            let (position, velocity) = (&now.position[l], &now.velocity[l]);
            let gradient = estimate.gradient;
            information.add(position, gradient.dot(&(velocity - before)), load);
            // The position of the onset is known to within a displacement, so the force there is less certain if the contact is
            // stiffer than expected.
            let stiffness = estimate.stiffness.max(prior.stiffness);
            let ratio = self.sigma / onset_deviation(stiffness, self.onset);
            information.onset = ratio * ratio;
            *estimate = information.solve(prior, gradient.dot(before));
        }
    }

    /// The latency to believe, given the present one, the noise of a load (N) and of a position (m), and the closing
    /// velocity (m/s).
    pub(super) fn choose(&mut self, present: usize, noise: (f64, f64), closing: f64) -> usize {
        if self.loads < LATENCY_LOADS || self.settled {
            return present;
        }
        let floor_n = self.at(present).estimate.floor_n(noise, closing);
        let floor = f64::from(self.loads) * floor_n * floor_n;
        let cost = |l: usize| self.hypotheses[l].estimate.squared_error + floor;
        let best = (0..LATENCIES).fold(present, |a, b| if cost(b) < cost(a) { b } else { a });
        let better_than = |l: usize, factor: f64| cost(l) > factor * cost(best);
        // A latency is constant: what disturbs the fit later, such as a pause, says nothing about it.
        self.settled = (0..LATENCIES).all(|l| l == best || better_than(l, LATENCY_SETTLED));
        let possible = |l: &usize| !better_than(*l, LATENCY_EVIDENCE);
        self.latest = (0..LATENCIES).rev().find(possible).unwrap_or(best);
        if better_than(present, LATENCY_EVIDENCE) {
            best
        } else {
            present
        }
    }

    /// Number of loads taken in.
    pub(super) fn loads(&self) -> u32 {
        self.loads
    }
}

impl Estimate {
    /// Standard deviation of a load below which residuals decide nothing, N.
    fn floor_n(&self, (noise, noise_m): (f64, f64), closing: f64) -> f64 {
        let inverse_mass = (1.0 / self.mass).max(1e-9);
        let peak = closing * ComplexField::sqrt(self.stiffness / inverse_mass);
        let (noise, part) = (LATENCY_FLOOR_NOISE * noise, LATENCY_FLOOR_PEAK * peak);
        let apart = LATENCY_FLOOR_NOISE * self.stiffness * noise_m;
        ComplexField::sqrt(noise * noise + part * part + apart * apart)
    }
}

/// Standard deviation of the load at the onset, N, from a stiffness (N/m), the displacement between the samples around it (m) and
/// the threshold of a load (N).
fn onset_deviation(stiffness: f64, (travel, threshold): (f64, f64)) -> f64 {
    (stiffness * travel / ONSET_SPREAD).max(1e-6) + threshold
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::delay::predictor::bounce::assert_near;
    use crate::delay::predictor::oblique::{direction, gradient, sample};

    /// Closing velocity, m/s.
    const CLOSING: f64 = 0.006;

    fn prior() -> Prior {
        Prior::new((2e5, 0.05, 0.0), CLOSING, direction())
    }

    #[test]
    fn the_load_at_the_onset_is_known_to_the_way_between_two_samples() {
        assert_near(onset_deviation(2e5, (3.5e-5, 0.5)), 2.5, 1e-6);
        assert_near(onset_deviation(2e5, (0.0, 0.5)), 0.5 + 1e-6, 1e-6);
    }

    /// The hypotheses in a contact with a pose that is `late` cycles late: the robot has moved as the contact requires, and each
    /// hypothesis sees it as late as it assumes.
    fn bank(
        late: usize,
        loads: i32,
        only: Option<usize>,
        resumed: Option<usize>,
    ) -> LatencyEstimator {
        let prior = prior();
        let before = gradient() * (CLOSING / gradient().norm_squared());
        let at_force = |n: i32| {
            let seen = |l: usize| sample(n + l as i32 - late as i32, CLOSING, 2000.0, 0.0);
            AtForce {
                position: core::array::from_fn(|l| seen(l).0),
                velocity: core::array::from_fn(|l| before * (1.0 + seen(l).1 / CLOSING)),
                resumed: core::array::from_fn(|l| resumed == Some(l)),
            }
        };
        let onset = (CLOSING, 2.4e-5, 0.5);
        let previous = at_force(0).position;
        let mut bank = LatencyEstimator::new(&previous, &at_force(1), &prior, onset, None);
        for n in 1..=loads {
            let (_, _, load) = sample(n, CLOSING, 2000.0, 0.0);
            bank.add(&at_force(n), load, (&prior, &before), only);
        }
        bank
    }

    #[test]
    fn the_latency_of_the_pose_is_the_one_that_fits() {
        for late in 0..LATENCIES {
            let mut bank = bank(late, 16, None, None);
            assert_eq!(bank.choose(2, (0.01, 0.0), CLOSING), late);
            assert!(bank.settled);
            assert_eq!((bank.latest, bank.loads()), (late, 16));
            // A settled latency is not reconsidered.
            bank.hypotheses[late].estimate.squared_error = 1e9;
            assert_eq!(bank.choose(2, (0.01, 0.0), CLOSING), 2);
        }
    }

    /// Only the hypothesis of a known latency is updated, and none for which the robot has ended a pause within the cycle.
    #[test]
    fn hypotheses_that_say_nothing_take_no_load() {
        let loads =
            |bank: &LatencyEstimator| bank.hypotheses.clone().map(|h| h.information.samples);
        assert_eq!(loads(&bank(1, 4, None, None)), [4.0; 5]);
        assert_eq!(loads(&bank(1, 4, Some(3), None)), [0.0, 0.0, 0.0, 4.0, 0.0]);
        assert_eq!(loads(&bank(1, 4, None, Some(2))), [4.0, 4.0, 0.0, 4.0, 4.0]);
    }

    /// The onset lies between the last free and the first loaded position; the load there is zero within noise and a
    /// displacement, and less certain with a stiffness above the expected one.
    #[test]
    fn a_contact_begins_between_two_samples() {
        let bank = bank(0, 1, None, None);
        let prior = prior();
        for hypothesis in &bank.hypotheses {
            let stiffness = hypothesis.information.onset;
            let most = (prior.sigma / onset_deviation(2e5, (2.4e-5, 0.5))).powi(2);
            assert!(stiffness <= most * (1.0 + 1e-12));
        }
        let middle = (sample(0, CLOSING, 0.0, 0.0).0 + sample(1, CLOSING, 0.0, 0.0).0) * 0.5;
        assert!((bank.at(0).information.origin - middle).amax() < 1e-15);
        assert_eq!(
            bank.at(99).information.origin,
            bank.at(LATENCIES - 1).information.origin
        );
        assert_eq!(bank.latest, LATENCIES - 1);
        let remembered = bank.at(3).information.clone();
        let now = AtForce {
            position: [V6::repeat(0.3); LATENCIES],
            velocity: [V6::zeros(); LATENCIES],
            resumed: [false; LATENCIES],
        };
        let again = LatencyEstimator::new(
            &[V6::repeat(0.4); LATENCIES],
            &now,
            &prior,
            (CLOSING, 2.4e-5, 0.5),
            Some((3, &remembered)),
        );
        let samples = again.hypotheses.clone().map(|h| h.information.samples);
        assert_eq!(samples, [0.0, 0.0, 0.0, 0.5, 0.0]);
    }

    /// Squared errors of the five hypotheses, the number of loads, with a floor of 1 N² per load; then the latency that is
    /// believed, whether it is settled, and the largest that is not refuted.
    #[test]
    fn a_latency_is_changed_for_one_that_is_better_by_half() {
        for (errors, loads, chosen, settled, latest) in [
            ([0.0, 0.0, 0.0, 0.0, 0.0], 4, 1, false, 4),
            // With a floor of 4 N²: 4 + 3.9 is less than twice 4.
            ([0.0, 3.9, 9.0, 9.0, 9.0], 4, 1, false, 1),
            ([0.0, 4.1, 9.0, 9.0, 9.0], 4, 0, false, 0),
            ([9.0, 4.1, 9.0, 0.0, 3.0], 4, 3, false, 4),
            ([0.0, 395.0, 397.0, 999.0, 999.0], 4, 0, false, 0),
            ([0.0, 397.0, 397.0, 999.0, 999.0], 4, 0, true, 0),
            ([397.0, 0.0, 397.0, 999.0, 999.0], 4, 1, true, 1),
            ([0.0, 1e3, 1e3, 1e3, 1e3], 2, 1, false, 4),
            ([0.0, 1e3, 1e3, 1e3, 1e3], 3, 0, true, 0),
        ] {
            let mut bank = bank(0, 0, None, None);
            bank.loads = loads;
            for (hypothesis, error) in bank.hypotheses.iter_mut().zip(errors) {
                hypothesis.estimate.squared_error = error;
            }
            let noise = (1.0 / LATENCY_FLOOR_NOISE, 0.0);
            assert_eq!(bank.choose(1, noise, 0.0), chosen, "{errors:?}");
            assert_eq!((bank.settled, bank.latest), (settled, latest), "{errors:?}");
        }
    }

    /// Zero to four cycles are distinguished.
    #[test]
    fn a_pose_that_is_older_than_all_that_are_told_apart_is_the_oldest() {
        assert_eq!([0, 3, 4, 5, 99].map(told_apart), [0, 3, 4, 4, 4]);
    }

    /// 1.5 times the noise, of a load or from a position, and 0.0002 of the peak V √(k m).
    #[test]
    fn the_error_of_a_load_that_decides_nothing_is_that_of_its_noise() {
        let estimate = Estimate::exact(2e5, 0.0, 500.0);
        let peak = 0.005 * (2e5_f64 * 500.0).sqrt();
        for (noise, closing, expected) in [
            ((0.2, 0.0), 0.0, 0.3),
            ((0.0, 1e-6), 0.0, 0.3),
            ((0.0, 0.0), 0.005, 2e-4 * peak),
            ((0.2, 1e-6), 0.005, (0.18 + 4e-8 * peak * peak).sqrt()),
        ] {
            assert_near(estimate.floor_n(noise, closing), expected, 1e-6);
        }
    }
}
