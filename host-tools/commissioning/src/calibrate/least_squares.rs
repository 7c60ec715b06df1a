//! Least squares with one noise of all forces and one of all torques, both estimated from the residuals.

use super::equations::{AT_REST, BIAS, MASS, MOMENT, Unknowns};
use super::gravity::Gravity;
use super::observation::{Group, Observation};
use nalgebra::{DMatrix, DVector};
use softdock_statistics::f_p;
use std::borrow::Borrow;

/// Steps in which noise and direction of gravity settle; each step is a linear problem, and a tilt
/// of 10° is found to 1e-12 rad in four.
const STEPS: usize = 8;
/// Noise to begin with, N and N·m.
const START_SIGMA: [f64; 2] = [0.3, 0.01];
/// Lower bounds of the noise, N and N·m: readings without noise are possible.
const LEAST_SIGMA: [f64; 2] = [1e-9, 1e-10];
/// Singular values below this share of the largest are zero.
const ZERO: f64 = 1e-10;

/// The unknowns with all that is known about them.
#[derive(Clone, Debug)]
pub(super) struct Solution {
    /// The unknowns in the order of `equations`.
    pub values: DVector<f64>,
    /// Their covariance.
    pub covariance: DMatrix<f64>,
    /// Noise of a force (N) and a torque (N·m).
    pub sigma: [f64; 2],
    /// Degrees of freedom of both.
    pub freedom: [f64; 2],
    /// Ratio of the largest and smallest singular value; infinite if there is no solution.
    pub condition: f64,
    /// The combination of unknowns that is known worst.
    pub weakest: Weakest,
    /// Gravity in C.
    pub gravity: Gravity,
}

/// A combination of unknowns, each in units of what it adds to the readings.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Weakest {
    /// Shares of the unknowns.
    shares: DVector<f64>,
    unknowns: Unknowns,
}

impl Weakest {
    /// The undetermined quantity, as the end of a sentence.
    pub(super) fn sentence(&self) -> String {
        let part = |from: usize, count: usize| self.shares.rows(from, count).norm();
        let (mass, moment) = (part(MASS, 1), part(MOMENT, 3));
        let inertia = part(AT_REST, self.unknowns.tilt_at() - AT_REST);
        let tilt = part(
            self.unknowns.tilt_at(),
            self.unknowns.count() - self.unknowns.tilt_at(),
        );
        let largest = [mass, moment, inertia, tilt]
            .into_iter()
            .fold(0.0, f64::max);
        if largest == inertia {
            "a moment of inertia cannot be told from the zero of the torques".to_owned()
        } else if largest == tilt {
            "the direction of gravity cannot be told from the sensor's zero".to_owned()
        } else if largest == mass {
            "the mass cannot be told from the zero of the forces".to_owned()
        } else {
            format!(
                "the centre of mass along {} of the sensor cannot be told from the zero of the torques",
                self.axis_words()
            )
        }
    }

    /// The axis of the sensor along which the moment is weak.
    fn axis_words(&self) -> String {
        /// Share of a direction that makes it an axis.
        const ALONG: f64 = 0.95;
        let moment = self.shares.rows(MOMENT, 3).normalize();
        let axes = ["x", "y", "z"];
        match (0..3).find(|k| moment[*k].abs() > ALONG) {
            Some(k) => axes[k].to_owned(),
            None => format!("({:.2}, {:.2}, {:.2})", moment[0], moment[1], moment[2]),
        }
    }
}

/// Solves for the unknowns from the groups.
pub(super) fn solve<G: Borrow<Group>>(
    groups: &[G],
    unknowns: &Unknowns,
    start: &Gravity,
) -> Solution {
    solve_weighted(groups, &vec![1.0; groups.len()], unknowns, start)
}

/// The same with a weight for each group: the inverse of how much larger its noise is.
pub(super) fn solve_weighted<G: Borrow<Group>>(
    groups: &[G],
    weights: &[f64],
    unknowns: &Unknowns,
    start: &Gravity,
) -> Solution {
    let mut gravity = *start;
    let mut sigma = START_SIGMA;
    let mut values = DVector::zeros(unknowns.count());
    values[MASS] = 1.0;
    let mut last = None;
    for step in 0..STEPS {
        let problem = Problem::new(groups, weights, unknowns, &gravity, &values, sigma);
        let solved = problem.solve();
        values = solved.values.clone();
        let left = problem.residual_noise(&values);
        sigma = left.sigma;
        // The covariance belongs to the noise with which the rows were scaled.
        let rescaled = problem.covariance(&solved, sigma);
        last = Some((solved, rescaled, left));
        if unknowns.tilt && step + 1 < STEPS {
            let at = unknowns.tilt_at();
            gravity = gravity.turned([values[at], values[at + 1]]);
            values[at] = 0.0;
            values[at + 1] = 0.0;
        }
    }
    finished(last, unknowns, values, gravity)
}

fn finished(
    last: Option<(Solved, DMatrix<f64>, ResidualNoise)>,
    unknowns: &Unknowns,
    values: DVector<f64>,
    gravity: Gravity,
) -> Solution {
    let count = unknowns.count();
    let (condition, shares, covariance, left) = match last {
        Some((solved, covariance, left)) => (solved.condition, solved.weakest, covariance, left),
        None => (
            f64::INFINITY,
            DVector::zeros(count),
            DMatrix::zeros(count, count),
            ResidualNoise::default(),
        ),
    };
    Solution {
        values,
        covariance,
        sigma: left.sigma,
        freedom: left.freedom,
        condition,
        weakest: Weakest {
            shares,
            unknowns: *unknowns,
        },
        gravity,
    }
}

/// What a set of poses determines, whatever the readings are.
pub(super) struct Determined {
    /// See [`Solution::condition`].
    pub condition: f64,
    /// Number of combinations of unknowns that are undetermined.
    pub open: usize,
    /// See [`Solution::weakest`].
    pub weakest: Weakest,
}

/// Judges a problem by its poses alone.
pub(super) fn determined<G: Borrow<Group>>(
    groups: &[G],
    unknowns: &Unknowns,
    gravity: &Gravity,
) -> Determined {
    let mut values = DVector::zeros(unknowns.count());
    values[MASS] = 1.0;
    let weights = vec![1.0; groups.len()];
    let solved = Problem::new(groups, &weights, unknowns, gravity, &values, START_SIGMA).solve();
    Determined {
        condition: solved.condition,
        open: solved.open,
        weakest: Weakest {
            shares: solved.weakest,
            unknowns: *unknowns,
        },
    }
}

impl Solution {
    /// Prediction error of an observation: six numbers.
    pub(super) fn error(&self, observation: &Observation, unknowns: &Unknowns) -> DVector<f64> {
        let rows = observation.rows(unknowns, &self.gravity, &self.values);
        observation.read() - rows * &self.values
    }

    /// Zero-load reading.
    pub(super) fn bias(&self) -> [f64; 6] {
        std::array::from_fn(|k| self.values[BIAS + k])
    }
}

/// A straight drift of the zeros of three forces or of three torques.
pub(super) struct Drift {
    /// Change of the zeros from the first group to the last, N or N·m.
    pub over: [f64; 3],
    /// Probability that chance explains as much.
    pub p: f64,
}

/// Linear drifts of the forces and of the torques over the time of the groups: three more unknowns each beside a solution. None
/// for a part whose readings leave no degrees of freedom, or if the groups cover no time.
pub(super) fn drifts(
    groups: &[&Group],
    unknowns: &Unknowns,
    fit: &Solution,
) -> Option<[Option<Drift>; 2]> {
    let weights = vec![1.0; groups.len()];
    let mut problem = Problem::new(
        groups,
        &weights,
        unknowns,
        &fit.gravity,
        &fit.values,
        fit.sigma,
    );
    let left = &problem.read - &problem.rows * &fit.values;
    let middle = |group: &Group| 0.5 * (group.time_s[0] + group.time_s[1]);
    let (first, last) = (middle(groups.first()?), middle(groups.last()?));
    let shares = groups
        .iter()
        .flat_map(|g| vec![(middle(g) - first) / (last - first); g.observations.len()]);
    let shares: Vec<f64> = shares.collect();
    // Residual of a drift of one axis by the other unknowns: the part of its column that these cannot explain.
    let mut own = |axis: usize| {
        problem.read.fill(0.0);
        for (n, share) in shares.iter().enumerate() {
            problem.read[6 * n + axis] = share / fit.sigma[axis / 3];
        }
        &problem.read - &problem.rows * problem.solve().values
    };
    let mut of = |part: usize| {
        let columns = DMatrix::from_columns(&[0, 1, 2].map(|axis| own(3 * part + axis)));
        let over = columns.tr_mul(&columns).cholesky()?;
        let over = over.solve(&columns.tr_mul(&left));
        // A tilt of gravity couples forces and torques. The change of the other part's residual is left out: it has another
        // number of readings and unknowns.
        let [without, with] = [&left, &(&left - &columns * &over)].map(|left| squares(left, part));
        let freedom = fit.freedom[part] - 3.0;
        let times = (without - with) / 3.0 / (with / freedom);
        Some(Drift {
            over: [over[0], over[1], over[2]],
            p: f_p(times.max(0.0), 3.0, freedom),
        })
    };
    Some([of(0), of(1)])
}

/// Sum of the squares of the forces or of the torques among residuals.
fn squares(residual: &DVector<f64>, part: usize) -> f64 {
    let own = residual
        .iter()
        .enumerate()
        .filter(|(i, _)| i % 6 / 3 == part);
    own.map(|(_, r)| r * r).sum()
}

/// Rows in units of the noise.
struct Problem {
    rows: DMatrix<f64>,
    read: DVector<f64>,
    sigma: [f64; 2],
    unknowns: Unknowns,
}

struct Solved {
    values: DVector<f64>,
    condition: f64,
    open: usize,
    weakest: DVector<f64>,
    /// Inverse of the rows' normal matrix.
    inverse: DMatrix<f64>,
}

impl Solved {
    /// The result if no row contains any of so many unknowns.
    fn nothing(count: usize) -> Self {
        Self {
            values: DVector::zeros(count),
            condition: f64::INFINITY,
            open: count,
            weakest: DVector::zeros(count),
            inverse: DMatrix::zeros(count, count),
        }
    }
}

/// Noise that the rows leave, and its degrees of freedom; each for forces and torques.
#[derive(Clone, Copy, Default)]
struct ResidualNoise {
    sigma: [f64; 2],
    freedom: [f64; 2],
}

impl Problem {
    fn new<G: Borrow<Group>>(
        groups: &[G],
        weights: &[f64],
        unknowns: &Unknowns,
        gravity: &Gravity,
        values: &DVector<f64>,
        sigma: [f64; 2],
    ) -> Self {
        let of_group = |(group, weight): (&'_ G, &f64)| -> Vec<(Observation, f64)> {
            let observations = Borrow::<Group>::borrow(group).observations.iter();
            observations.map(|o| (o.clone(), *weight)).collect()
        };
        let observations: Vec<(Observation, f64)> =
            groups.iter().zip(weights).flat_map(of_group).collect();
        // At least as many rows as unknowns, so that what is not seen at all shows as a zero.
        let height = (6 * observations.len()).max(unknowns.count());
        let mut rows = DMatrix::zeros(height, unknowns.count());
        let mut read = DVector::zeros(height);
        for (n, (observation, weight)) in observations.iter().enumerate() {
            let mut own = observation.rows(unknowns, gravity, values);
            let mut wrench = observation.read();
            for i in 0..6 {
                own.row_mut(i).scale_mut(weight / sigma[i / 3]);
                wrench[i] *= weight / sigma[i / 3];
            }
            rows.rows_mut(6 * n, 6).copy_from(&own);
            read.rows_mut(6 * n, 6).copy_from(&wrench);
        }
        Self {
            rows,
            read,
            sigma,
            unknowns: *unknowns,
        }
    }

    /// The rows with all columns scaled to one length, as the condition must not depend on units; and the factors of the columns.
    fn scaled(&self) -> (DMatrix<f64>, Vec<f64>) {
        let length = self.rows.column_iter().map(|c| c.norm());
        let scale: Vec<f64> = length
            .map(|l| if l > 0.0 { 1.0 / l } else { 0.0 })
            .collect();
        let mut scaled = self.rows.clone();
        for (mut column, scale) in scaled.column_iter_mut().zip(&scale) {
            column.scale_mut(*scale);
        }
        (scaled, scale)
    }

    fn solve(&self) -> Solved {
        let count = self.rows.ncols();
        let (scaled, scale) = self.scaled();
        // The triangle of a QR decomposition has the singular values of the rows and is small.
        let (q, r) = scaled.qr().unpack();
        let svd = r.svd(true, true);
        let (Some(u), Some(v_t)) = (svd.u, svd.v_t) else {
            return Solved::nothing(count);
        };
        let singular = &svd.singular_values;
        let largest = singular.max();
        let projected = u.transpose() * (q.transpose() * &self.read);
        let mut values = DVector::zeros(count);
        let mut inverse = DMatrix::zeros(count, count);
        for (k, s) in singular
            .iter()
            .enumerate()
            .filter(|(_, s)| **s > ZERO * largest)
        {
            let direction = v_t.row(k).transpose();
            values += &direction * (projected[k] / s);
            inverse += &direction * direction.transpose() / (s * s);
        }
        for i in 0..count {
            values[i] *= scale[i];
            for k in 0..count {
                inverse[(i, k)] *= scale[i] * scale[k];
            }
        }
        let smallest = singular.imin();
        let open = singular.iter().filter(|s| **s <= ZERO * largest).count();
        Solved {
            values,
            condition: if open > 0 {
                f64::INFINITY
            } else {
                largest / singular[smallest]
            },
            open,
            weakest: v_t.row(smallest).transpose(),
            inverse,
        }
    }

    /// Noise of forces and torques that these values leave; the unknowns reduce the degrees of freedom.
    fn residual_noise(&self, values: &DVector<f64>) -> ResidualNoise {
        let residual = &self.read - &self.rows * values;
        let of = |part: usize, unknowns: usize| {
            let freedom = (residual.len() as f64 / 2.0 - unknowns as f64).max(1.0);
            let sigma = self.sigma[part] * (squares(&residual, part) / freedom).sqrt();
            (sigma.max(LEAST_SIGMA[part]), freedom)
        };
        let (force, torque) = (
            of(0, self.unknowns.of_forces()),
            of(1, self.unknowns.of_torques()),
        );
        ResidualNoise {
            sigma: [force.0, torque.0],
            freedom: [force.1, torque.1],
        }
    }

    /// Covariance of the values when the noise is `sigma`: rows were scaled with another one.
    fn covariance(&self, solved: &Solved, sigma: [f64; 2]) -> DMatrix<f64> {
        let mut noise = self.rows.clone();
        for (i, mut row) in noise.row_iter_mut().enumerate() {
            let part = i % 6 / 3;
            row.scale_mut(sigma[part] / self.sigma[part]);
        }
        let spread = &noise * &solved.inverse;
        spread.transpose() * spread
    }
}
