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
const UNKNOWNS: usize = 8;
const DAMPING: usize = 6;
const OFFSET: usize = 7;
type Row = SVector<f64, UNKNOWNS>;

/// Prior standard deviation of the stiffness, in units of the expected one, along and across the
/// direction of the force.
const SPREAD_ALONG: f64 = 2.0;
const SPREAD_ACROSS: f64 = 0.1;
/// Bounds of the stiffness in units of the expected one.
const STIFFNESS: [f64; 2] = [0.02, 50.0];
/// A damping within so many standard deviations of zero is shrunk to zero.
const DOUBT: f64 = 1.5;
/// Largest damping, in units of √(k m).
const MOST_DAMPING: f64 = 1.9;

/// What has been measured of a contact: sums of products.
#[derive(Clone, Debug)]
pub(super) struct Evidence {
    /// p₀: positions count from here, m.
    pub(super) origin: V6,
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

impl Evidence {
    pub(super) fn new(origin: V6) -> Self {
        Self {
            origin,
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

    /// A load λ (N) at a place with a closing velocity (m/s).
    pub(super) fn add(&mut self, position: &V6, closing: f64, load: f64) {
        let row = self.row(position, closing);
        self.take(&row, load, 1.0);
        self.load_squared += load * load;
        self.samples += 1.0;
    }

    /// The contact began within half a cycle of a place: no force there, to `deviation` (N); in
    /// units of the samples' error `sigma`.
    pub(super) fn add_onset(&mut self, position: &V6, deviation: f64, sigma: f64) {
        let row = self.row(position, 0.0);
        let ratio = sigma / deviation;
        self.take(&row, 0.0, ratio * ratio);
    }

    /// Lets the past count less.
    pub(super) fn fade(&mut self, factor: f64) {
        self.products *= factor;
        self.with_load *= factor;
        self.load_squared *= factor;
        self.samples *= factor;
    }

    /// The contact that fits best.
    pub(super) fn solve(&self, expected: &Expected) -> Estimate {
        let Expected {
            stiffness: k0,
            sigma,
            direction: h,
            mobility: bh,
        } = *expected;
        let inverse_mass = h.dot(&bh).max(1e-9);
        let (mut information, mut target) = (self.products, self.with_load);
        self.add_prior(expected, inverse_mass, &mut information, &mut target);
        let factor = Factor::new(&information);
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
            rest = self.rest(&with(c.max(0.0)));
            unknowns = with(damping);
        }
        let mut estimate = self.describe(unknowns, stiffness_of(&unknowns), (h, bh), inverse_mass);
        estimate.rest = rest;
        estimate
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
            misfit: self.misfit(&unknowns),
            error: ComplexField::sqrt(self.rest(&unknowns) / self.samples.max(1.0)),
            rest: 0.0,
        }
    }

    /// Root of the mean squared residual over that of the load.
    fn misfit(&self, u: &Row) -> f64 {
        ComplexField::sqrt(self.rest(u) / self.load_squared.max(f64::MIN_POSITIVE))
    }

    /// Sum of squared residuals, N².
    fn rest(&self, u: &Row) -> f64 {
        let mut quadratic = 0.0;
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
