//! The contact estimator: recursive least squares with a prior, once for each latency of the reported pose.
//!
//! Along the direction h of its load a contact is a spring and a damper,
//!
//! ```text
//! λ = κ · (p − p₀) + c (s' − V) + b
//! ```
//!
//! with λ the load along h, p the six positions and s' − V the change of the closing velocity since the onset,
//! so that b is c V and an offset. κ is six numbers because with friction the force does not point to where its
//! stiffness does. From κ follow the stiffness k = κ·Bh / h·Bh, the gradient a = κ/k and the effective mass
//! 1/(a·Bh), where B is the velocity per impulse of the six axes (Kelvin-Voigt model; regularised recursive
//! least squares in information form, with a forgetting factor from contact to contact).
//!
//! The pose may be older than the force by a number of cycles that nobody knows: the same estimate is made
//! for each (a bank of models, Magill 1965), and the one that leaves the smallest squared error is believed.

use super::least_squares::{Ldlt, shrunk};
use super::observer::AtForce;
use super::tuning::*;
use super::{M6, V6};
use nalgebra::{ComplexField, SMatrix, SVector};

/// Unknowns: κ (6), c, b.
const UNKNOWNS: usize = 8;
pub(super) const DAMPING: usize = 6;
const OFFSET: usize = 7;
pub(super) type Unknowns = SVector<f64, UNKNOWNS>;

/// What has been measured of a contact: the sums of the normal equations.
#[derive(Clone, Debug)]
pub(super) struct Information {
    /// p₀: positions count from here, m; in a contact the position where it began.
    pub(super) origin: V6,
    /// Weight of the onset against that of a load.
    onset: f64,
    products: SMatrix<f64, UNKNOWNS, UNKNOWNS>,
    with_load: Unknowns,
    load_squared: f64,
    samples: f64,
}

/// What is expected of any contact.
#[derive(Clone, Copy, Debug)]
pub(super) struct Prior {
    /// Stiffness, N/m.
    stiffness: f64,
    /// Error of a load, N.
    pub(super) sigma: f64,
    /// h: direction of the load, with a force part of 1.
    direction: V6,
    /// Bh: velocity of the axes per impulse along that direction.
    mobility: V6,
    /// Standard deviation of the robot's delay, s.
    delay_s: f64,
}

/// A contact as identified.
#[derive(Clone, Copy, Debug)]
pub(super) struct Estimate {
    /// N/m and N·s/m.
    pub(super) stiffness: f64,
    pub(super) damping: f64,
    /// a, and s = a · p at which the spring is free, m.
    pub(super) gradient: V6,
    pub(super) surface: f64,
    /// Effective mass along a, kg.
    pub(super) mass: f64,
    /// d: into which a force along the contact pushes; d · a = 1.
    pub(super) push: V6,
    /// Misfit, as a part of the load.
    pub(super) misfit: f64,
    /// Standard deviation of the residuals, N.
    pub(super) error: f64,
    /// Sum of squared residuals of the best fit, before its damping is shrunk, N².
    squared_error: f64,
}

impl Prior {
    /// For a contact at a closing velocity (m/s), with the error of a load by noise (N) and h and Bh.
    pub(super) fn new(
        (stiffness, noise, delay_s): (f64, f64, f64),
        closing: f64,
        (h, bh): (V6, V6),
    ) -> Self {
        let inverse_mass = h.dot(&bh).max(1e-9);
        let peak = closing.abs() * ComplexField::sqrt(stiffness / inverse_mass);
        let part = MODEL_ERROR * peak;
        Self {
            stiffness,
            sigma: ComplexField::sqrt(noise * noise + part * part).max(1e-9),
            direction: h,
            mobility: bh,
            delay_s,
        }
    }

    /// Variance of a damping, from that in units of σ²: a delay that is believed too long by Δ looks like a
    /// damping k Δ.
    pub(super) fn damping_variance(&self, units: f64, stiffness: f64) -> f64 {
        self.noise_variance(units, self.sigma, stiffness)
    }

    /// Likewise by a noise of the loads alone, N.
    pub(super) fn noise_variance(&self, units: f64, noise: f64, stiffness: f64) -> f64 {
        let late = stiffness * self.delay_s;
        (units * noise * noise).max(0.0) + late * late
    }

    /// Velocity along the direction per impulse along it, 1/kg.
    fn inverse_mass(&self) -> f64 {
        self.direction.dot(&self.mobility).max(1e-9)
    }

    /// Adds its information, in units of 1/σ².
    fn add_to(&self, information: &mut SMatrix<f64, UNKNOWNS, UNKNOWNS>, target: &mut Unknowns) {
        let (k0, sigma, h) = (self.stiffness, self.sigma, &self.direction);
        let squared = h.norm_squared();
        let weight = |spread: f64| {
            let ratio = sigma / (spread * k0);
            ratio * ratio / squared
        };
        let (along, across) = (weight(PRIOR_SPREAD_ALONG), weight(PRIOR_SPREAD_ACROSS));
        let tilt = (along - across) / squared;
        for i in 0..6 {
            for j in 0..=i {
                information[(i, j)] += tilt * h[i] * h[j];
            }
            information[(i, i)] += across;
            target[i] += along * k0 * h[i];
        }
        let critical = 2.0 * ComplexField::sqrt(k0 / self.inverse_mass());
        let ratio = sigma / (critical * PRIOR_DAMPING_RATIO);
        information[(DAMPING, DAMPING)] += ratio * ratio;
        // An offset is as good as unknown; the onset holds it.
        information[(OFFSET, OFFSET)] += OFFSET_REGULARISATION;
    }

    /// k of the κ among the unknowns, N/m.
    fn stiffness_of(&self, unknowns: &Unknowns) -> f64 {
        let k = kappa(unknowns).dot(&self.mobility) / self.inverse_mass();
        let [least, most] = STIFFNESS_RANGE;
        k.clamp(least * self.stiffness, most * self.stiffness)
    }
}

impl Information {
    pub(super) fn new(origin: V6) -> Self {
        Self {
            origin,
            onset: 0.0,
            products: SMatrix::zeros(),
            with_load: Unknowns::zeros(),
            load_squared: 0.0,
            samples: 0.0,
        }
    }

    fn row(&self, position: &V6, closing: f64) -> Unknowns {
        let p = position - self.origin;
        Unknowns::from([p[0], p[1], p[2], p[3], p[4], p[5], closing, 1.0])
    }

    fn take(&mut self, row: &Unknowns, load: f64, weight: f64) {
        for i in 0..UNKNOWNS {
            let scaled = row[i] * weight;
            for j in 0..=i {
                self.products[(i, j)] += scaled * row[j];
            }
            self.with_load[i] += scaled * load;
        }
    }

    /// A load λ (N) at a position, and by how much the closing velocity has changed in the contact (m/s).
    ///
    /// The change is along the contact, where the gradient is known. The velocity before is not: a
    /// gradient that turns while the contact is identified would turn it into a damping.
    pub(super) fn add(&mut self, position: &V6, change: f64, load: f64) {
        let row = self.row(position, change);
        self.take(&row, load, 1.0);
        self.load_squared += load * load;
        self.samples += 1.0;
    }

    /// A contact begins within half a cycle of a position: no force there, to `deviation` (N); in
    /// units of the samples' error `sigma`. What is known already counts less, with velocities that
    /// change from `closing` (m/s) on.
    pub(super) fn begin(&mut self, position: &V6, closing: f64, deviation: f64, sigma: f64) {
        self.products *= MEMORY_FORGETTING;
        self.with_load *= MEMORY_FORGETTING;
        self.load_squared *= MEMORY_FORGETTING;
        self.samples *= MEMORY_FORGETTING;
        let moved = self.origin - position;
        self.shift(&moved, -closing);
        self.origin = *position;
        let ratio = sigma / deviation;
        self.onset = ratio * ratio;
    }

    /// The contact has ended: velocities count from zero.
    pub(super) fn end(&mut self, closing: f64) {
        let mut row = Unknowns::zeros();
        (row[DAMPING], row[OFFSET]) = (-closing, 1.0);
        self.take(&row, 0.0, self.onset);
        self.onset = 0.0;
        self.shift(&V6::zeros(), closing);
    }

    /// As if all positions and velocities had been larger.
    fn shift(&mut self, position: &V6, closing: f64) {
        let by = self.row(&(position + self.origin), closing);
        let of_one = Unknowns::from_fn(|j, _| self.products[(OFFSET, j)]);
        let (weight, load) = (of_one[OFFSET], self.with_load[OFFSET]);
        for i in 0..OFFSET {
            for j in 0..=i {
                self.products[(i, j)] += by[i] * (of_one[j] + by[j] * weight) + by[j] * of_one[i];
            }
            self.products[(OFFSET, i)] += by[i] * weight;
            self.with_load[i] += by[i] * load;
        }
    }

    /// The contact that fits best, of velocities that change from `closing` (m/s) on.
    pub(super) fn solve(&self, prior: &Prior, closing: f64) -> Estimate {
        let (factor, target) = self.normal_equations(prior, closing);
        let mut unknowns = factor.solve(&target);
        let column = covariance_of_damping(&factor);
        let c = unknowns[DAMPING];
        let stiffness = prior.stiffness_of(&unknowns);
        let variance = prior.damping_variance(column[DAMPING], stiffness);
        let most = DAMPING_LIMIT * ComplexField::sqrt(stiffness / prior.inverse_mass());
        // Damping that cannot be told from an error of the onset is none.
        let damping = shrunk(c, variance, DAMPING_SIGNIFICANCE).clamp(0.0, most);
        let mut squared_error = 0.0;
        if column[DAMPING] > 0.0 {
            let with = |damping: f64| unknowns + column * ((damping - c) / column[DAMPING]);
            squared_error = self.squared_error(&with(c.max(0.0)), closing);
            unknowns = with(damping);
        }
        let left = self.squared_error(&unknowns, closing);
        // The surface is where a robot that stands still feels nothing.
        unknowns[OFFSET] -= damping * closing;
        let stiffness = prior.stiffness_of(&unknowns);
        let gradient = gradient(&unknowns, stiffness, prior);
        Estimate {
            stiffness,
            damping: unknowns[DAMPING],
            gradient,
            surface: gradient.dot(&self.origin) - unknowns[OFFSET] / stiffness,
            mass: 1.0 / prior.inverse_mass(),
            push: prior.mobility / prior.inverse_mass(),
            misfit: ComplexField::sqrt(left / self.load_squared.max(f64::MIN_POSITIVE)),
            error: ComplexField::sqrt(left / self.samples.max(1.0)),
            squared_error,
        }
    }

    /// The normal equations with the prior, in units of 1/σ²: factor and right side.
    pub(super) fn normal_equations(
        &self,
        prior: &Prior,
        closing: f64,
    ) -> (Ldlt<UNKNOWNS>, Unknowns) {
        let (mut information, mut target) = (self.products, self.with_load);
        information[(DAMPING, DAMPING)] += self.onset * closing * closing;
        information[(OFFSET, DAMPING)] -= self.onset * closing;
        information[(OFFSET, OFFSET)] += self.onset;
        prior.add_to(&mut information, &mut target);
        (Ldlt::new(information), target)
    }

    /// Sum of squared residuals, with that of the onset, N².
    fn squared_error(&self, u: &Unknowns, closing: f64) -> f64 {
        let began = u[OFFSET] - u[DAMPING] * closing;
        let mut quadratic = self.onset * began * began;
        for i in 0..UNKNOWNS {
            let mut row = self.products[(i, i)] * u[i];
            for j in 0..i {
                row += 2.0 * self.products[(i, j)] * u[j];
            }
            quadratic += row * u[i];
        }
        (self.load_squared - 2.0 * u.dot(&self.with_load) + quadratic).max(0.0)
    }
}

/// Covariance of all unknowns with the damping, in units of σ².
pub(super) fn covariance_of_damping(factor: &Ldlt<UNKNOWNS>) -> Unknowns {
    let mut unit = Unknowns::zeros();
    unit[DAMPING] = 1.0;
    factor.solve(&unit)
}

fn kappa(unknowns: &Unknowns) -> V6 {
    V6::from_iterator(unknowns.iter().take(6).copied())
}

/// Deviation of the load where the contact began, N, by a stiffness (N/m), the displacement between the samples beside it
/// (m) and the threshold of a load (N).
fn onset_deviation(stiffness: f64, (travel, threshold): (f64, f64)) -> f64 {
    (stiffness * travel / ONSET_SPREAD).max(1e-6) + threshold
}

/// a, from the unknowns and their stiffness within its bounds.
fn gradient(unknowns: &Unknowns, stiffness: f64, prior: &Prior) -> V6 {
    let kappa = kappa(unknowns);
    let along = kappa.dot(&prior.mobility) / prior.inverse_mass();
    // Loads that do not grow into the contact say nothing about its direction.
    if along > GRADIENT_TRUST * stiffness {
        kappa / along
    } else {
        prior.direction
    }
}

/// h and Bh, from the running sum of the load.
pub(super) fn direction(sum: &V6, mobility: &M6) -> (V6, V6) {
    let force = sum.fixed_rows::<3>(0).norm();
    let size = force.max(LEAST_FORCE_PART * sum.norm());
    let h = sum / size.max(f64::MIN_POSITIVE);
    (h, mobility * h)
}

/// A latency among those that are told apart.
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
    /// Displacement between the last free and the first loaded sample, m, and the error of the onset's load beside it, N.
    onset: (f64, f64),
    /// Error of a load that was expected then, N.
    sigma: f64,
}

impl LatencyEstimator {
    /// A new contact: it began between the positions before and now, with a closing velocity (m/s), a displacement (m)
    /// apart; there is no force there, to a threshold (N).
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

    /// A load λ, N, in a contact that began with a velocity of the axes. `only` one hypothesis is worth
    /// the work when the latency is known.
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
            // Where the contact began is known to a displacement: the load there less well if it is stiffer than expected.
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
        // A latency does not change; what disturbs the fit later, such as a pause, says nothing about it.
        self.settled = (0..LATENCIES).all(|l| l == best || better_than(l, LATENCY_SETTLED));
        let possible = |l: &usize| !better_than(*l, LATENCY_EVIDENCE);
        self.latest = (0..LATENCIES).rev().find(possible).unwrap_or(best);
        if better_than(present, LATENCY_EVIDENCE) {
            best
        } else {
            present
        }
    }

    /// Loads taken.
    pub(super) fn loads(&self) -> u32 {
        self.loads
    }
}

impl Estimate {
    /// Error of a load that decides nothing, N.
    fn floor_n(&self, (noise, noise_m): (f64, f64), closing: f64) -> f64 {
        let inverse_mass = (1.0 / self.mass).max(1e-9);
        let peak = closing * ComplexField::sqrt(self.stiffness / inverse_mass);
        let (noise, part) = (LATENCY_FLOOR_NOISE * noise, LATENCY_FLOOR_PEAK * peak);
        let apart = LATENCY_FLOOR_NOISE * self.stiffness * noise_m;
        ComplexField::sqrt(noise * noise + part * part + apart * apart)
    }
}

#[cfg(test)]
impl Estimate {
    /// A spring (N/m) and a damper (N·s/m) against a mass (kg) along the first axis, free at 0, that fit exactly.
    pub(super) fn exact(stiffness: f64, damping: f64, mass: f64) -> Self {
        let along = V6::new(1.0, 0.0, 0.0, 0.0, 0.0, 0.0);
        Self {
            stiffness,
            damping,
            gradient: along,
            surface: 0.0,
            mass,
            push: along,
            misfit: 0.0,
            error: 0.0,
            squared_error: 0.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn prior() -> Prior {
        let direction = V6::new(1.0, 0.0, 0.0, 0.0, 0.0, 0.0);
        Prior {
            stiffness: 2e5,
            sigma: 1e-6,
            direction,
            mobility: direction / 500.0,
            delay_s: 0.0,
        }
    }

    /// A contact at 5 mm/s of 220,500 N/m and 2,100 N·s/m whose surface is at `surface`.
    fn contact(information: &mut Information, surface: f64) {
        let at = |x: f64| V6::new(x, 0.0, 0.0, 0.0, 0.0, 0.0);
        information.begin(&at(surface), 0.005, 1e-4, 1e-6);
        for n in 1..30 {
            let t = 0.004 * f64::from(n);
            let (sin, cos) = (21.0 * t).sin_cos();
            let (depth, closing) = (0.005 / 21.0 * sin, 0.005 * cos);
            let load = 220_500.0 * depth + 2100.0 * closing;
            information.add(&at(surface + depth), closing - 0.005, load);
        }
    }

    fn assert_found(estimate: &Estimate, surface: f64) {
        assert!((estimate.stiffness / 220_500.0 - 1.0).abs() < 1e-4);
        assert!((estimate.damping / 2100.0 - 1.0).abs() < 1e-3);
        assert!(
            (estimate.surface - surface).abs() < 1e-7,
            "{}",
            estimate.surface
        );
    }

    #[test]
    fn a_contact_is_found_from_what_changes_in_it() {
        let mut information = Information::new(V6::zeros());
        contact(&mut information, 0.3);
        assert_found(&information.solve(&prior(), 0.005), 0.3);
    }

    /// What is remembered of a contact is the same contact, wherever and however fast the next begins.
    #[test]
    fn a_contact_is_remembered() {
        let mut information = Information::new(V6::zeros());
        contact(&mut information, 0.3);
        information.end(0.005);
        let position = V6::new(0.2999, 0.0, 0.0, 0.0, 0.0, 0.0);
        information.begin(&position, 0.003, 1.0, 1e-6);
        assert_found(&information.solve(&prior(), 0.003), 0.3);
    }

    /// All that is known of a contact as the rows of one least-squares problem, in units of a load's error: rows, right side, and
    /// how many of them are no prior.
    struct Batch {
        rows: SMatrix<f64, 80, UNKNOWNS>,
        right: SVector<f64, 80>,
        used: usize,
        data: usize,
    }

    impl Batch {
        fn new() -> Self {
            Self {
                rows: SMatrix::zeros(),
                right: SVector::zeros(),
                used: 0,
                data: 0,
            }
        }

        fn push(&mut self, row: Unknowns, right: f64, weight: f64) {
            self.rows.set_row(self.used, &(row.transpose() * weight));
            self.right[self.used] = right * weight;
            self.used += 1;
        }

        /// κ is k₀ h to a factor of two along h and to a tenth across it, any damping up to a critical one, any offset.
        fn push_prior(&mut self, prior: &Prior) {
            self.data = self.used;
            let (k0, sigma) = (prior.stiffness, prior.sigma);
            let size = prior.direction.norm();
            let unit = prior.direction / size;
            let of_kappa = |v: V6| Unknowns::from_fn(|i, _| if i < 6 { v[i] } else { 0.0 });
            self.push(of_kappa(unit), k0 * size, sigma / (2.0 * k0) / size);
            for i in 0..6 {
                let mut axis = V6::zeros();
                axis[i] = 1.0;
                let across = axis - unit * unit.dot(&axis);
                self.push(of_kappa(across), 0.0, sigma / (0.1 * k0) / size);
            }
            let mass = 1.0 / prior.direction.dot(&prior.mobility);
            let mut row = Unknowns::zeros();
            row[DAMPING] = 1.0;
            self.push(row, 0.0, sigma / (2.0 * (k0 * mass).sqrt()));
            row = Unknowns::zeros();
            row[OFFSET] = 1.0;
            self.push(row, 0.0, 1e-9_f64.sqrt());
        }

        /// The best unknowns, with a damping that is given or not.
        fn solve(&self, damping: Option<f64>) -> Unknowns {
            let (mut rows, mut right) = (self.rows, self.right);
            if let Some(damping) = damping {
                right -= rows.column(DAMPING) * damping;
                rows.column_mut(DAMPING).fill(0.0);
                (rows[(self.used, DAMPING)], right[self.used]) = (1.0, damping);
            }
            let qr = rows.qr();
            let right = qr.q().transpose() * right;
            qr.r().solve_upper_triangular(&right).expect("a rank")
        }

        /// Sum of the squares that they leave of what was measured.
        fn left(&self, unknowns: &Unknowns) -> f64 {
            let left = self.rows * unknowns - self.right;
            left.rows(0, self.data).norm_squared()
        }

        /// Variance of the damping, in units of σ².
        fn variance(&self) -> f64 {
            let information = self.rows.transpose() * self.rows;
            let inverse = information.try_inverse().expect("a rank");
            inverse[(DAMPING, DAMPING)]
        }
    }

    /// Friction turns the force away from where the stiffness points.
    fn oblique(stiffness: f64, delay_s: f64) -> Prior {
        let direction = V6::new(0.8, -0.6, 0.0, 0.1, 0.0, -0.2);
        let mobility = V6::new(1.6, -1.1, 0.1, 0.3, -0.1, -0.5) * 1e-3;
        Prior::new((stiffness, 0.05, delay_s), 0.006, (direction, mobility))
    }

    /// Motion of a contact at a cycle: position, change of the closing velocity, and load with some noise.
    fn sample(n: i32, damping: f64, noise: f64) -> (V6, f64, f64) {
        let t = f64::from(n) * 0.004;
        let depth = 0.006 / 21.0 * (21.0 * t).sin();
        let change = 0.006 * ((21.0 * t).cos() - 1.0);
        let wave = |rate: f64| (rate * f64::from(n)).sin();
        let across = V6::new(
            wave(1.1),
            wave(2.3),
            wave(1.7),
            wave(0.9),
            wave(2.9),
            wave(1.3),
        );
        let position = V6::new(0.9, -0.5, 0.1, 0.0, 0.2, -0.1) * depth + across * 1e-5;
        let kappa = V6::new(0.9, -0.5, 0.2, 0.1, 0.1, -0.1) * 2.2e5;
        let load = kappa.dot(&position) + damping * (0.006 + change) + noise * wave(3.7);
        (V6::repeat(0.2) + position, change, load)
    }

    fn assert_same(found: f64, expected: f64, what: &str) {
        let apart = (found - expected).abs();
        assert!(
            apart <= 1e-6 * expected.abs() + 1e-12,
            "{what}: {found} {expected}"
        );
    }

    /// What follows from the best unknowns of a batch.
    fn assert_batch(
        estimate: &Estimate,
        batch: &Batch,
        prior: &Prior,
        (origin, closing): (V6, f64),
        loads: (f64, f64),
    ) {
        let (squares, count) = loads;
        let inverse_mass = prior.direction.dot(&prior.mobility);
        let stiffness_of = |u: &Unknowns| {
            let k = u.fixed_rows::<6>(0).dot(&prior.mobility) / inverse_mass;
            k.clamp(0.02 * prior.stiffness, 50.0 * prior.stiffness)
        };
        let free = batch.solve(None);
        let late = stiffness_of(&free) * prior.delay_s;
        let variance = batch.variance() * prior.sigma * prior.sigma + late * late;
        let doubt = 1.5 * 1.5 * variance / (free[DAMPING] * free[DAMPING]);
        let most = 1.9 * (stiffness_of(&free) / inverse_mass).sqrt();
        let damping = (free[DAMPING] * (1.0 - doubt).max(0.0)).clamp(0.0, most);
        let best = batch.solve(Some(damping));
        let (stiffness, left) = (stiffness_of(&best), batch.left(&best));
        assert_same(estimate.damping, damping, "damping");
        assert_same(estimate.stiffness, stiffness, "stiffness");
        let not_negative = batch.solve(Some(free[DAMPING].max(0.0)));
        assert_same(
            estimate.squared_error,
            batch.left(&not_negative),
            "squared error",
        );
        assert_same(estimate.error, (left / count).sqrt(), "error");
        assert_same(estimate.misfit, (left / squares).sqrt(), "misfit");
        assert_same(estimate.mass, 1.0 / inverse_mass, "mass");
        // Where a robot that stands still feels nothing.
        let kappa: V6 = best.fixed_rows::<6>(0).into();
        let way = estimate.surface - estimate.gradient.dot(&origin);
        let at_rest = best[OFFSET] - best[DAMPING] * closing;
        assert_same(way * stiffness, -at_rest, "surface");
        let along = kappa.dot(&prior.mobility) / inverse_mass;
        let expected = match along > 0.5 * stiffness {
            true => kappa / along,
            false => prior.direction,
        };
        assert!((estimate.gradient - expected).amax() < 1e-6, "{expected}");
        assert_same(estimate.gradient.dot(&estimate.push), 1.0, "push");
    }

    /// Dampings that are none, some, too large and negative; a stiffness that is at the end of its range; a delay that is
    /// uncertain.
    #[test]
    fn the_recursive_estimate_is_that_of_all_loads_at_once() {
        for (stiffness, damping, noise, delay_s) in [
            (2e5, 2000.0, 0.3, 0.0),
            (1e5, 300.0, 3.0, 0.0),
            (2e5, 2000.0, 0.3, 0.004),
            (2e5, 9e4, 0.3, 0.0),
            (2e5, -3000.0, 0.3, 0.0),
            (3e3, 0.0, 0.0, 0.0),
        ] {
            let prior = oblique(stiffness, delay_s);
            let (origin, deviation) = (V6::repeat(0.2), 2.0);
            let mut information = Information::new(V6::repeat(0.1));
            information.begin(&origin, 0.006, deviation, prior.sigma);
            let mut batch = Batch::new();
            let mut row = Unknowns::zeros();
            (row[DAMPING], row[OFFSET]) = (-0.006, 1.0);
            batch.push(row, 0.0, prior.sigma / deviation);
            let mut squares = 0.0;
            for n in 1..30 {
                let (position, change, load) = sample(n, damping, noise);
                information.add(&position, change, load);
                let p = position - origin;
                let row = [p[0], p[1], p[2], p[3], p[4], p[5], change, 1.0];
                batch.push(row.into(), load, 1.0);
                squares += load * load;
            }
            batch.push_prior(&prior);
            let estimate = information.solve(&prior, 0.006);
            assert_batch(&estimate, &batch, &prior, (origin, 0.006), (squares, 29.0));
        }
    }

    /// Half as much as the present one counts what an earlier contact showed, at another place and speed.
    #[test]
    fn what_is_remembered_counts_half() {
        let prior = oblique(2e5, 0.0);
        let (old, new) = (
            V6::repeat(0.2),
            V6::repeat(0.2) + V6::new(3.0, 1.0, -2.0, 0.5, 0.0, 1.0) * 1e-4,
        );
        let (closing, slower, deviation) = (0.006, 0.004, 2.0);
        let mut information = Information::new(old);
        let mut batch = Batch::new();
        let half = 0.5_f64.sqrt();
        // By closing velocities: the change is counted from the present one.
        let row = |position: &V6, velocity: f64| -> Unknowns {
            let p = position - new;
            [p[0], p[1], p[2], p[3], p[4], p[5], velocity - slower, 1.0].into()
        };
        information.begin(&old, closing, deviation, prior.sigma);
        batch.push(row(&old, 0.0), 0.0, half * prior.sigma / deviation);
        let (mut squares, mut count) = (0.0, 0.0);
        for n in 1..30 {
            let (position, change, load) = sample(n, 2000.0, 0.5);
            information.add(&position, change, load);
            batch.push(row(&position, closing + change), load, half);
            (squares, count) = (squares + 0.5 * load * load, count + 0.5);
        }
        information.end(closing);
        information.begin(&new, slower, deviation, prior.sigma);
        let mut began = Unknowns::zeros();
        (began[DAMPING], began[OFFSET]) = (-slower, 1.0);
        batch.push(began, 0.0, prior.sigma / deviation);
        for n in 1..12 {
            let (position, change, load) = sample(n + 2, 2500.0, 0.5);
            information.add(&position, change, load);
            batch.push(row(&position, slower + change), load, 1.0);
            (squares, count) = (squares + load * load, count + 1.0);
        }
        batch.push_prior(&prior);
        let estimate = information.solve(&prior, slower);
        assert_batch(&estimate, &batch, &prior, (new, slower), (squares, count));
    }

    /// Three thousandths of the peak V √(k m), beside the noise.
    #[test]
    fn the_expected_error_of_a_load_is_noise_and_that_of_the_model() {
        let (h, bh) = (
            V6::new(1.0, 0.0, 0.0, 0.0, 0.0, 0.0),
            V6::new(0.002, 0.0, 0.0, 0.0, 0.0, 0.0),
        );
        let peak = 0.005 * (2e5_f64 * 500.0).sqrt();
        for (noise, closing, expected) in [
            (0.2, 0.0, 0.2),
            (0.0, 0.005, 0.003 * peak),
            (0.0, -0.005, 0.003 * peak),
            (0.2, 0.005, (0.04 + 9e-6 * peak * peak).sqrt()),
        ] {
            assert_same(
                Prior::new((2e5, noise, 0.0), closing, (h, bh)).sigma,
                expected,
                "sigma",
            );
        }
    }

    /// A load of a contact that is stiffer than a tenth of what it seems points into it.
    #[test]
    fn loads_that_do_not_grow_into_the_contact_say_nothing_about_its_direction() {
        let prior = prior();
        for (along, believed) in [(0.49, false), (0.51, true)] {
            let mut unknowns = Unknowns::zeros();
            (unknowns[0], unknowns[1]) = (along * 1e5, 3e4);
            let found = gradient(&unknowns, 1e5, &prior);
            let turned = V6::new(1.0, 0.3 / along, 0.0, 0.0, 0.0, 0.0);
            let expected = if believed { turned } else { prior.direction };
            assert!((found - expected).amax() < 1e-12, "{along}: {found}");
        }
    }

    /// With a force part of one; of a torque alone it is taken as a tenth.
    #[test]
    fn the_direction_of_a_load_is_per_force() {
        let mobility = M6::from_diagonal(&V6::new(1.0, 2.0, 3.0, 4.0, 5.0, 6.0));
        for (load, size) in [
            (V6::new(3.0, 0.0, -4.0, 1.0, 2.0, 0.0), 5.0),
            (V6::new(0.0, 0.0, 0.0, 3.0, 0.0, 4.0), 0.5),
        ] {
            let (h, bh) = direction(&load, &mobility);
            assert!((h * size - load).amax() < 1e-12, "{h}");
            assert!((bh - mobility * h).amax() < 1e-12, "{bh}");
        }
    }

    /// Of a cycle that began anywhere between two samples: the way between them by √12, and the threshold.
    #[test]
    fn the_load_at_the_onset_is_known_to_the_way_between_two_samples() {
        assert_same(onset_deviation(2e5, (3.5e-5, 0.5)), 2.5, "deviation");
        assert_same(onset_deviation(2e5, (0.0, 0.5)), 0.5 + 1e-6, "at rest");
    }

    /// The bank in a contact of a pose that is `late`: the robot has moved as the contact says, each hypothesis sees it as old as
    /// it believes.
    fn bank(
        late: usize,
        loads: i32,
        only: Option<usize>,
        resumed: Option<usize>,
    ) -> LatencyEstimator {
        let prior = oblique(2e5, 0.0);
        let gradient = V6::new(0.9, -0.5, 0.2, 0.1, 0.1, -0.1);
        let before = gradient * (0.006 / gradient.norm_squared());
        let at_force = |n: i32| {
            let seen = |l: usize| sample(n + l as i32 - late as i32, 2000.0, 0.0);
            AtForce {
                position: core::array::from_fn(|l| seen(l).0),
                velocity: core::array::from_fn(|l| before * (1.0 + seen(l).1 / 0.006)),
                resumed: core::array::from_fn(|l| resumed == Some(l)),
            }
        };
        let onset = (0.006, 2.4e-5, 0.5);
        let previous = at_force(0).position;
        let mut bank = LatencyEstimator::new(&previous, &at_force(1), &prior, onset, None);
        for n in 1..=loads {
            let (_, _, load) = sample(n, 2000.0, 0.0);
            bank.add(&at_force(n), load, (&prior, &before), only);
        }
        bank
    }

    #[test]
    fn the_latency_of_the_pose_is_the_one_that_fits() {
        for late in 0..LATENCIES {
            let mut bank = bank(late, 16, None, None);
            assert_eq!(bank.choose(2, (0.01, 0.0), 0.006), late);
            assert!(bank.settled);
            assert_eq!((bank.latest, bank.loads()), (late, 16));
            // Then it is not asked again.
            bank.hypotheses[late].estimate.squared_error = 1e9;
            assert_eq!(bank.choose(2, (0.01, 0.0), 0.006), 2);
        }
    }

    /// If the latency is known only that one is worth the work; and none in which the robot came out of a pause within the
    /// cycle.
    #[test]
    fn hypotheses_that_say_nothing_take_no_load() {
        let loads =
            |bank: &LatencyEstimator| bank.hypotheses.clone().map(|h| h.information.samples);
        assert_eq!(loads(&bank(1, 4, None, None)), [4.0; 5]);
        assert_eq!(loads(&bank(1, 4, Some(3), None)), [0.0, 0.0, 0.0, 4.0, 0.0]);
        assert_eq!(loads(&bank(1, 4, None, Some(2))), [4.0, 4.0, 0.0, 4.0, 4.0]);
    }

    /// Between the last free and the first loaded position, where the load is less than noise and a displacement make it; a
    /// stiffness beyond the expected one makes it less certain.
    #[test]
    fn a_contact_begins_between_two_samples() {
        let bank = bank(0, 1, None, None);
        let prior = oblique(2e5, 0.0);
        for hypothesis in &bank.hypotheses {
            let stiffness = hypothesis.information.onset;
            let most = (prior.sigma / onset_deviation(2e5, (2.4e-5, 0.5))).powi(2);
            assert!(stiffness <= most * (1.0 + 1e-12));
        }
        let middle = (sample(0, 0.0, 0.0).0 + sample(1, 0.0, 0.0).0) * 0.5;
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
            (0.006, 2.4e-5, 0.5),
            Some((3, &remembered)),
        );
        let samples = again.hypotheses.clone().map(|h| h.information.samples);
        assert_eq!(samples, [0.0, 0.0, 0.0, 0.5, 0.0]);
    }

    /// Squared errors of the five after so many loads, with a floor of 1 N² a load; what is believed, whether it is beyond doubt,
    /// and the largest that may be.
    #[test]
    fn a_latency_is_changed_for_one_that_is_better_by_half() {
        for (errors, loads, chosen, settled, latest) in [
            ([0.0, 0.0, 0.0, 0.0, 0.0], 4, 1, false, 4),
            // 4 N² of floor: 4 + 3.9 is less than twice 4.
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

    /// Zero to four cycles.
    #[test]
    fn a_pose_that_is_older_than_all_that_are_told_apart_is_the_oldest() {
        assert_eq!([0, 3, 4, 5, 99].map(told_apart), [0, 3, 4, 4, 4]);
    }

    /// One and a half of the noise, of a load or by a position, and 0.0002 of the peak V √(k m).
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
            assert_same(estimate.floor_n(noise, closing), expected, "floor");
        }
    }
}
