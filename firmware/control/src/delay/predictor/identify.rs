//! The contact, from the load and the place of the robot: along the force a spring and a damper.
//!
//! λ = κ · (p − p₀) + c s' + b, with λ the load along its own direction h, p the six positions and
//! s' the closing velocity. κ is six numbers because with friction the force does not point to
//! where its stiffness does. From κ come k = κ·Bh / h·Bh, the direction a = κ/k of the stiffness and
//! the effective mass 1/(a·Bh), where B is the velocity per impulse of the six axes.

use super::linear::Factor;
use super::{M6, V6};
use nalgebra::{ComplexField, SMatrix, SVector};

/// Unknowns: κ (6), c, b.
pub(super) const UNKNOWNS: usize = 8;
pub(super) const DAMPING: usize = 6;
const OFFSET: usize = 7;
pub(super) type Row = SVector<f64, UNKNOWNS>;

/// Prior standard deviation of the stiffness, in units of the expected one, along and across the
/// direction of the force.
const SPREAD_ALONG: f64 = 2.0;
const SPREAD_ACROSS: f64 = 0.1;
/// Bounds of the stiffness in units of the expected one.
const STIFFNESS: [f64; 2] = [0.02, 50.0];
/// A damping within so many standard deviations of zero is shrunk to zero.
const DOUBT: f64 = 1.5;
/// How much of an earlier contact with the same wall counts.
const REMEMBERED: f64 = 0.5;
/// Largest damping, in units of √(k m).
const MOST_DAMPING: f64 = 1.9;

/// What has been measured of a contact: sums of products.
#[derive(Clone, Debug)]
pub(super) struct Evidence {
    /// p₀: positions count from here, m; in a contact the place where it began.
    pub(super) origin: V6,
    /// How much the beginning counts against a load.
    onset: f64,
    products: SMatrix<f64, UNKNOWNS, UNKNOWNS>,
    with_load: Row,
    load_squared: f64,
    samples: f64,
}

/// What is expected of any contact.
#[derive(Clone, Copy, Debug)]
pub(super) struct Expected {
    /// Stiffness, N/m.
    pub(super) stiffness: f64,
    /// Error of a load, N.
    pub(super) sigma: f64,
    /// Direction of the load, with a force part of 1.
    pub(super) direction: V6,
    /// Velocity of the axes per impulse along that direction.
    pub(super) mobility: V6,
}

/// A contact as identified.
#[derive(Clone, Copy, Debug)]
pub(super) struct Estimate {
    /// N/m and N·s/m.
    pub(super) stiffness: f64,
    pub(super) damping: f64,
    /// a, and s = a · p at which the spring is free, m.
    pub(super) gradient: V6,
    pub(super) wall: f64,
    /// Effective mass along a, kg.
    pub(super) mass: f64,
    /// Into which a force along the contact pushes; with a it makes 1.
    pub(super) push: V6,
    /// Misfit, as a part of the load.
    pub(super) misfit: f64,
    /// Standard deviation of the residuals, N.
    pub(super) error: f64,
    /// Sum of squared residuals of the best fit without doubt about damping, N².
    pub(super) rest: f64,
}

impl Expected {
    /// Velocity along the direction per impulse along it, 1/kg.
    pub(super) fn inverse_mass(&self) -> f64 {
        self.direction.dot(&self.mobility).max(1e-9)
    }
}

impl Evidence {
    pub(super) fn new(origin: V6) -> Self {
        Self {
            origin,
            onset: 0.0,
            products: SMatrix::zeros(),
            with_load: Row::zeros(),
            load_squared: 0.0,
            samples: 0.0,
        }
    }

    fn row(&self, position: &V6, closing: f64) -> Row {
        let p = position - self.origin;
        Row::from([p[0], p[1], p[2], p[3], p[4], p[5], closing, 1.0])
    }

    fn take(&mut self, row: &Row, load: f64, weight: f64) {
        for i in 0..UNKNOWNS {
            let scaled = row[i] * weight;
            for j in 0..=i {
                self.products[(i, j)] += scaled * row[j];
            }
            self.with_load[i] += scaled * load;
        }
    }

    /// A load λ (N) at a place, and by how much the closing velocity has changed in the contact (m/s).
    ///
    /// The change is along the contact, where the gradient is known. The velocity before is not: a
    /// gradient that turns while the contact is identified would turn it into a damping.
    pub(super) fn add(&mut self, position: &V6, change: f64, load: f64) {
        let row = self.row(position, change);
        self.take(&row, load, 1.0);
        self.load_squared += load * load;
        self.samples += 1.0;
    }

    /// A contact begins within half a cycle of a place: no force there, to `deviation` (N); in
    /// units of the samples' error `sigma`. What is known already counts half, with velocities that
    /// change from `closing` (m/s) on.
    pub(super) fn begin(&mut self, place: &V6, closing: f64, deviation: f64, sigma: f64) {
        self.fade(REMEMBERED);
        let moved = self.origin - place;
        self.shift(&moved, -closing);
        self.origin = *place;
        let ratio = sigma / deviation;
        self.onset = ratio * ratio;
    }

    /// The contact has ended: velocities count from zero.
    pub(super) fn end(&mut self, closing: f64) {
        let mut row = Row::zeros();
        (row[DAMPING], row[OFFSET]) = (-closing, 1.0);
        self.take(&row, 0.0, self.onset);
        self.onset = 0.0;
        self.shift(&V6::zeros(), closing);
    }

    /// As if all places and velocities had been larger.
    fn shift(&mut self, place: &V6, closing: f64) {
        let by = self.row(&(place + self.origin), closing);
        let of_one: Row = Row::from_fn(|j, _| self.products[(OFFSET, j)]);
        let (weight, load) = (of_one[OFFSET], self.with_load[OFFSET]);
        for i in 0..OFFSET {
            for j in 0..=i {
                self.products[(i, j)] += by[i] * (of_one[j] + by[j] * weight) + by[j] * of_one[i];
            }
            self.products[(OFFSET, i)] += by[i] * weight;
            self.with_load[i] += by[i] * load;
        }
    }

    /// Lets the past count less.
    fn fade(&mut self, factor: f64) {
        self.products *= factor;
        self.with_load *= factor;
        self.load_squared *= factor;
        self.samples *= factor;
    }

    /// The contact that fits best, of velocities that change from `closing` (m/s) on.
    pub(super) fn solve(&self, expected: &Expected, closing: f64) -> Estimate {
        let Expected {
            stiffness: k0,
            sigma,
            direction: h,
            mobility: bh,
        } = *expected;
        let inverse_mass = expected.inverse_mass();
        let (factor, target) = self.normal(expected, closing);
        let mut unknowns = factor.solve(&target);
        let mut unit = Row::zeros();
        unit[DAMPING] = 1.0;
        let column = factor.solve(&unit);
        // Damping that cannot be told from an error of the onset is none.
        let stiffness_of = |u: &Row| {
            let kappa = V6::from_iterator(u.iter().take(6).copied());
            (kappa.dot(&bh) / inverse_mass).clamp(STIFFNESS[0] * k0, STIFFNESS[1] * k0)
        };
        let c = unknowns[DAMPING];
        let variance = (column[DAMPING] * sigma * sigma).max(0.0);
        let doubt = DOUBT * DOUBT * variance / (c * c).max(f64::MIN_POSITIVE);
        let most = MOST_DAMPING * ComplexField::sqrt(stiffness_of(&unknowns) / inverse_mass);
        let damping = (c * (1.0 - doubt).max(0.0)).clamp(0.0, most);
        let mut rest = 0.0;
        if column[DAMPING] > 0.0 {
            let with = |damping: f64| unknowns + column * ((damping - c) / column[DAMPING]);
            rest = self.rest(&with(c.max(0.0)), closing);
            unknowns = with(damping);
        }
        let left = self.rest(&unknowns, closing);
        // The wall is where a robot that stands still feels nothing.
        unknowns[OFFSET] -= damping * closing;
        let mut estimate = self.describe(unknowns, stiffness_of(&unknowns), (h, bh), inverse_mass);
        estimate.misfit = ComplexField::sqrt(left / self.load_squared.max(f64::MIN_POSITIVE));
        estimate.error = ComplexField::sqrt(left / self.samples.max(1.0));
        estimate.rest = rest;
        estimate
    }

    /// The normal equations with what is expected, in units of 1/σ²: factor and right side.
    pub(super) fn normal(&self, expected: &Expected, closing: f64) -> (Factor<UNKNOWNS>, Row) {
        let inverse_mass = expected.inverse_mass();
        let (mut information, mut target) = (self.products, self.with_load);
        information[(DAMPING, DAMPING)] += self.onset * closing * closing;
        information[(OFFSET, DAMPING)] -= self.onset * closing;
        information[(OFFSET, OFFSET)] += self.onset;
        self.add_prior(expected, inverse_mass, &mut information, &mut target);
        (Factor::new(&information), target)
    }

    /// Prior information in units of 1/σ².
    fn add_prior(
        &self,
        expected: &Expected,
        inverse_mass: f64,
        information: &mut SMatrix<f64, UNKNOWNS, UNKNOWNS>,
        target: &mut Row,
    ) {
        let Expected {
            stiffness: k0,
            sigma,
            direction: h,
            ..
        } = *expected;
        let squared = h.norm_squared();
        let weight = |spread: f64| {
            let ratio = sigma / (spread * k0);
            ratio * ratio / squared
        };
        let (along, across) = (weight(SPREAD_ALONG), weight(SPREAD_ACROSS));
        let tilt = (along - across) / squared;
        for i in 0..6 {
            for j in 0..=i {
                information[(i, j)] += tilt * h[i] * h[j];
            }
            information[(i, i)] += across;
            target[i] += along * k0 * h[i];
        }
        let damping = 2.0 * ComplexField::sqrt(k0 / inverse_mass);
        let ratio = sigma / damping;
        information[(DAMPING, DAMPING)] += ratio * ratio;
        // An offset is as good as unknown; the onset holds it.
        information[(OFFSET, OFFSET)] += 1e-9;
    }

    fn describe(
        &self,
        unknowns: Row,
        stiffness: f64,
        (h, bh): (V6, V6),
        inverse_mass: f64,
    ) -> Estimate {
        let kappa = V6::from_iterator(unknowns.iter().take(6).copied());
        let along = kappa.dot(&bh) / inverse_mass;
        // Loads that do not grow into the wall say nothing about its direction.
        let gradient = if along > 0.5 * stiffness {
            kappa / along
        } else {
            h
        };
        let wall = gradient.dot(&self.origin) - unknowns[OFFSET] / stiffness;
        Estimate {
            stiffness,
            damping: unknowns[DAMPING],
            gradient,
            wall,
            mass: 1.0 / inverse_mass,
            push: bh / inverse_mass,
            misfit: 0.0,
            error: 0.0,
            rest: 0.0,
        }
    }

    /// Sum of squared residuals, with that of the beginning, N².
    fn rest(&self, u: &Row, closing: f64) -> f64 {
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

/// Direction of the load and what a force along it does, from the load's running sum.
pub(super) fn direction(sum: &V6, mobility: &M6) -> (V6, V6) {
    let force = sum.fixed_rows::<3>(0).norm();
    let size = force.max(0.1 * sum.norm()).max(f64::MIN_POSITIVE);
    let h = sum / size;
    (h, mobility * h)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn expected() -> Expected {
        let direction = V6::new(1.0, 0.0, 0.0, 0.0, 0.0, 0.0);
        Expected {
            stiffness: 2e5,
            sigma: 1e-6,
            direction,
            mobility: direction / 500.0,
        }
    }

    /// A contact at 5 mm/s of 220,500 N/m and 2,100 N·s/m whose wall is at `wall`.
    fn contact(evidence: &mut Evidence, wall: f64) {
        let at = |x: f64| V6::new(x, 0.0, 0.0, 0.0, 0.0, 0.0);
        evidence.begin(&at(wall), 0.005, 1e-4, 1e-6);
        for n in 1..30 {
            let t = 0.004 * f64::from(n);
            let (sin, cos) = (21.0 * t).sin_cos();
            let (depth, closing) = (0.005 / 21.0 * sin, 0.005 * cos);
            let load = 220_500.0 * depth + 2100.0 * closing;
            evidence.add(&at(wall + depth), closing - 0.005, load);
        }
    }

    fn assert_found(estimate: &Estimate, wall: f64) {
        assert!((estimate.stiffness / 220_500.0 - 1.0).abs() < 1e-4);
        assert!((estimate.damping / 2100.0 - 1.0).abs() < 1e-3);
        assert!((estimate.wall - wall).abs() < 1e-7, "{}", estimate.wall);
    }

    #[test]
    fn a_contact_is_found_from_what_changes_in_it() {
        let mut evidence = Evidence::new(V6::zeros());
        contact(&mut evidence, 0.3);
        assert_found(&evidence.solve(&expected(), 0.005), 0.3);
    }

    /// What is remembered of a contact is the same contact, wherever and however fast the next begins.
    #[test]
    fn a_contact_is_remembered() {
        let mut evidence = Evidence::new(V6::zeros());
        contact(&mut evidence, 0.3);
        evidence.end(0.005);
        let place = V6::new(0.2999, 0.0, 0.0, 0.0, 0.0, 0.0);
        evidence.begin(&place, 0.003, 1.0, 1e-6);
        assert_found(&evidence.solve(&expected(), 0.003), 0.3);
    }
}
