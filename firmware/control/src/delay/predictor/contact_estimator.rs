//! The contact estimator: recursive least squares with a prior.
//!
//! Along the direction h of its load a contact is a spring and a damper,
//!
//! ```text
//! λ = κ · (p − p₀) + c (s' − V) + b
//! ```
//!
//! with λ the load along h, p the six positions and s' − V the change of the closing velocity since the onset, so that the offset
//! b includes c V. κ has six components because with friction the force does not point in the direction of the stiffness. κ gives
//! the stiffness k = κ·Bh / h·Bh, the gradient a = κ/k and the effective mass 1/(a·Bh), where B is the velocity per impulse of
//! the six axes (Kelvin-Voigt model; regularised recursive least squares in information form, with a forgetting factor from
//! contact to contact).

use super::least_squares::{Ldlt, shrunk};
use super::tuning::*;
use super::{M6, V6};
use nalgebra::{ComplexField, SMatrix, SVector};

/// Unknowns: κ (6), c, b.
pub(super) const UNKNOWNS: usize = 8;
pub(super) const DAMPING: usize = 6;
pub(super) const OFFSET: usize = 7;
pub(super) type Unknowns = SVector<f64, UNKNOWNS>;

/// Measurements of a contact: the sums of the normal equations.
#[derive(Clone, Debug)]
pub(super) struct Information {
    /// p₀: positions count from here, m; in a contact the position where it began.
    pub(super) origin: V6,
    /// Weight of the condition that there is no force at the onset, relative to that of a load.
    pub(super) onset: f64,
    products: SMatrix<f64, UNKNOWNS, UNKNOWNS>,
    with_load: Unknowns,
    load_squared: f64,
    pub(super) samples: f64,
}

/// What is expected of a contact before it is identified.
#[derive(Clone, Copy, Debug)]
pub(super) struct Prior {
    /// Stiffness, N/m.
    pub(super) stiffness: f64,
    /// Error of a load, N.
    pub(super) sigma: f64,
    /// h: direction of the load, with a force part of 1.
    pub(super) direction: V6,
    /// Bh: velocity of the axes per impulse along that direction.
    pub(super) mobility: V6,
    /// Standard deviation of the robot's delay, s.
    pub(super) delay_s: f64,
}

/// A contact as identified.
#[derive(Clone, Copy, Debug)]
pub(super) struct Estimate {
    /// N/m and N·s/m.
    pub(super) stiffness: f64,
    pub(super) damping: f64,
    /// a, and the position s = a · p at which the spring is unloaded, m.
    pub(super) gradient: V6,
    pub(super) surface: f64,
    /// Effective mass along a, kg.
    pub(super) mass: f64,
    /// d: direction into which a force along the contact pushes; d · a = 1.
    pub(super) push: V6,
    /// Misfit: rms of the residuals over that of the loads.
    pub(super) misfit: f64,
    /// Standard deviation of the residuals, N.
    pub(super) error: f64,
    /// Sum of squared residuals of the best fit, before its damping is shrunk, N².
    pub(super) squared_error: f64,
}

impl Prior {
    /// For a contact at a closing velocity (m/s), from the expected stiffness (N/m), the noise of a load (N) and the standard
    /// deviation of the robot's delay (s), and from h and Bh.
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

    /// Variance of a damping, (N·s/m)², from that in units of σ²: a delay that is assumed too long by Δ looks like a damping k Δ.
    pub(super) fn damping_variance(&self, units: f64, stiffness: f64) -> f64 {
        self.noise_variance(units, self.sigma, stiffness)
    }

    /// The same for loads with this noise alone, N.
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
        // The offset is practically free; the onset determines it.
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

    /// Adds a load λ (N) at a position, with the change of the closing velocity since the onset (m/s).
    ///
    /// Only the change enters: it is along the contact, where the gradient is known. The velocity before the contact has other
    /// components, too, which a gradient that turns during the identification would turn into a damping.
    pub(super) fn add(&mut self, position: &V6, change: f64, load: f64) {
        let row = self.row(position, change);
        self.take(&row, load, 1.0);
        self.load_squared += load * load;
        self.samples += 1.0;
    }

    /// A contact begins within half a cycle of this position: the force is zero there, with a standard deviation of `deviation`
    /// (N); `sigma` is the error of a load (N). Information of earlier contacts loses weight, and is expressed by velocities that
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

    /// The contact has ended: the information is expressed by velocities relative to zero.
    pub(super) fn end(&mut self, closing: f64) {
        let mut row = Unknowns::zeros();
        (row[DAMPING], row[OFFSET]) = (-closing, 1.0);
        self.take(&row, 0.0, self.onset);
        self.onset = 0.0;
        self.shift(&V6::zeros(), closing);
    }

    /// Rewrites the sums as if all positions and velocities had been larger by these.
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

    /// The contact that fits best, with velocities that change from `closing` (m/s) on.
    pub(super) fn solve(&self, prior: &Prior, closing: f64) -> Estimate {
        let (factor, target) = self.normal_equations(prior, closing);
        let mut unknowns = factor.solve(&target);
        let column = covariance_of_damping(&factor);
        let c = unknowns[DAMPING];
        let stiffness = prior.stiffness_of(&unknowns);
        let variance = prior.damping_variance(column[DAMPING], stiffness);
        let most = DAMPING_LIMIT * ComplexField::sqrt(stiffness / prior.inverse_mass());
        // A damping that cannot be distinguished from an error of the onset is set to zero.
        let damping = shrunk(c, variance, DAMPING_SIGNIFICANCE).clamp(0.0, most);
        let mut squared_error = 0.0;
        if column[DAMPING] > 0.0 {
            let with = |damping: f64| unknowns + column * ((damping - c) / column[DAMPING]);
            squared_error = self.squared_error(&with(c.max(0.0)), closing);
            unknowns = with(damping);
        }
        let left = self.squared_error(&unknowns, closing);
        // The surface is where a robot at rest feels no force.
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

    /// The normal equations with the prior, in units of 1/σ²: factorisation and right side.
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

    /// Sum of squared residuals, with that of the condition at the onset, N².
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
    factor.solve(&Unknowns::ith(DAMPING, 1.0))
}

fn kappa(unknowns: &Unknowns) -> V6 {
    V6::from_iterator(unknowns.iter().take(6).copied())
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

#[cfg(test)]
impl Estimate {
    /// A spring (N/m) and a damper (N·s/m) against a mass (kg) along the first axis, free at 0, that fit exactly.
    pub(super) fn exact(stiffness: f64, damping: f64, mass: f64) -> Self {
        let along = V6::ith(0, 1.0);
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
    use crate::delay::predictor::batch::{Batch, assert_batch};
    use crate::delay::predictor::bounce::assert_near;
    use crate::delay::predictor::oblique;

    /// Closing velocity, m/s.
    const CLOSING: f64 = 0.006;

    fn prior() -> Prior {
        let direction = V6::ith(0, 1.0);
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
        let at = |x: f64| V6::ith(0, x);
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

    /// A remembered contact is the same contact, wherever and at whatever speed the next one begins.
    #[test]
    fn a_contact_is_remembered() {
        let mut information = Information::new(V6::zeros());
        contact(&mut information, 0.3);
        information.end(0.005);
        let position = V6::ith(0, 0.2999);
        information.begin(&position, 0.003, 1.0, 1e-6);
        assert_found(&information.solve(&prior(), 0.003), 0.3);
    }

    fn oblique(stiffness: f64, delay_s: f64) -> Prior {
        Prior::new((stiffness, 0.05, delay_s), CLOSING, oblique::direction())
    }

    /// A sample at a position other than the origin.
    fn sample(n: i32, damping: f64, noise: f64) -> (V6, f64, f64) {
        let (position, change, load) = oblique::sample(n, CLOSING, damping, noise);
        (V6::repeat(0.2) + position, change, load)
    }

    /// Dampings of zero, some, too large and negative; a stiffness at the end of its range; a delay that is uncertain.
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

    /// Loads of an earlier contact, at another place and speed, have half the weight of those of the present one.
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
        // With closing velocities: the change is relative to that of the present contact.
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
        let (h, bh) = (V6::ith(0, 1.0), V6::ith(0, 0.002));
        let peak = 0.005 * (2e5_f64 * 500.0).sqrt();
        for (noise, closing, expected) in [
            (0.2, 0.0, 0.2),
            (0.0, 0.005, 0.003 * peak),
            (0.0, -0.005, 0.003 * peak),
            (0.2, 0.005, (0.04 + 9e-6 * peak * peak).sqrt()),
        ] {
            let prior = Prior::new((2e5, noise, 0.0), closing, (h, bh));
            assert_near(prior.sigma, expected, 1e-6);
        }
    }

    /// κ gives the gradient only if its stiffness along the force exceeds half of the bounded one; else the gradient is the
    /// direction of the load.
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

    /// The direction has a force part of 1; a torque alone counts as if its force part were a tenth.
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
}
