//! Misfit of an actuator: measured minus simulated positions of an axis.

use super::track::Track;
use levenberg_marquardt::{LeastSquaresProblem, LevenbergMarquardt};
use nalgebra::storage::Owned;
use nalgebra::{DMatrix, DVector, Dyn};
use softdock_actuator::{Chain, PauseKind, PauseTrigger, Reading, Resonance, Timing, simulate};

/// What follows the transport delay.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Response {
    /// Nothing.
    Direct,
    /// A first-order lag.
    Lag,
    /// A second-order servo.
    Servo,
}

/// A limit of acceleration or velocity.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Limit {
    /// None.
    None,
    /// Of the acceleration, by the planner before the servo.
    Planned,
    /// Of the acceleration, by the drive behind it.
    Executed,
    /// Of the velocity, by the planner.
    Velocity,
}

impl Limit {
    /// Smallest value with which the limit does not act in this recording, in units of the axis.
    pub(super) fn never_acts(self, track: &Track) -> f64 {
        match self {
            Self::Velocity => track.fastest(),
            _ => track.largest_step() / track.cycle_s,
        }
    }
}

/// Form of a pause.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Pause {
    /// What begins it.
    pub trigger: PauseTrigger,
    /// Whether the axis restarts from rest.
    pub restarts: bool,
}

/// A structure of the actuator.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Structure {
    /// What follows the delay.
    pub response: Response,
    /// Standstill at a reversal.
    pub pause: Option<Pause>,
    /// Limit of acceleration or velocity.
    pub limit: Limit,
}

/// Index of the delay among the parameters. The others follow in this order, as far as the structure has them: lag, or frequency
/// and damping of the servo; pause; limit.
pub(super) const DELAY: usize = 0;

/// Longest time constant or delay of a fit, s.
const LONGEST_S: f64 = 0.5;

impl Structure {
    /// Number of parameters.
    pub(super) fn count(&self) -> usize {
        let response = match self.response {
            Response::Direct => 0,
            Response::Lag => 1,
            Response::Servo => 2,
        };
        1 + response + usize::from(self.pause.is_some()) + usize::from(self.limit != Limit::None)
    }

    /// Index of the pause.
    pub(super) fn pause_at(&self) -> usize {
        match self.response {
            Response::Direct => 1,
            Response::Lag => 2,
            Response::Servo => 3,
        }
    }

    /// Index of the limit.
    pub(super) fn limit_at(&self) -> usize {
        self.pause_at() + usize::from(self.pause.is_some())
    }

    /// Range and step of each parameter; times in s, frequency in Hz, limits in units of the axis.
    fn ranges(&self, track: &Track) -> Vec<Range> {
        let time = Range {
            low: 0.0,
            high: LONGEST_S,
            step: 2e-4,
        };
        let mut ranges = vec![time];
        match self.response {
            Response::Direct => {}
            Response::Lag => ranges.push(time),
            Response::Servo => ranges.extend([
                Range {
                    low: 0.5,
                    // Faster than that, a servo cannot be told from a delay.
                    high: 0.2 / track.cycle_s,
                    step: 0.02,
                },
                Range {
                    low: 0.05,
                    high: 0.999,
                    step: 2e-3,
                },
            ]),
        }
        if self.pause.is_some() {
            ranges.push(time);
        }
        if self.limit != Limit::None {
            let most = self.limit.never_acts(track).max(f64::MIN_POSITIVE);
            ranges.push(Range {
                low: 1e-4 * most,
                high: 10.0 * most,
                step: 1e-3 * most,
            });
        }
        ranges
    }

    /// The actuator with these parameters.
    pub(super) fn chain(&self, values: &[f64]) -> Chain {
        let at = |k: usize| values.get(k).copied().unwrap_or(0.0);
        let mut chain = Chain::nominal(at(DELAY), 0.0);
        match self.response {
            Response::Direct => {}
            Response::Lag => chain.lag_s = at(1),
            Response::Servo => {
                chain.resonance = Some(Resonance {
                    frequency_hz: at(1),
                    damping_ratio: at(2),
                });
            }
        }
        if let Some(pause) = self.pause {
            chain.pause_s = at(self.pause_at());
            chain.pause_trigger = pause.trigger;
            chain.pause_kind = if pause.restarts {
                PauseKind::RestartsFromRest
            } else {
                PauseKind::Resumes
            };
        }
        match self.limit {
            Limit::None => {}
            Limit::Planned => chain.planner.acceleration = at(self.limit_at()),
            Limit::Executed => chain.drive.acceleration = at(self.limit_at()),
            Limit::Velocity => chain.planner.velocity = at(self.limit_at()),
        }
        chain
    }
}

#[derive(Clone, Copy)]
struct Range {
    low: f64,
    high: f64,
    step: f64,
}

/// A structure with its best parameters.
#[derive(Clone, Debug)]
pub(super) struct Fit {
    /// The structure.
    pub structure: Structure,
    /// Its parameters.
    pub values: Vec<f64>,
    /// Residual of each judged position, m or rad; its mean is 0.
    pub left: Vec<f64>,
    /// The same with steps at reversals removed, followed by the cost of these steps: the residual vector of the fit.
    pub residual: Vec<f64>,
    /// Derivative of the residual by each parameter.
    slopes: DMatrix<f64>,
}

impl Fit {
    /// Sum of the squares of the residual.
    pub(super) fn squares(&self) -> f64 {
        self.residual.iter().map(|r| r * r).sum()
    }

    /// Root mean square of the residual, m or rad.
    pub(super) fn rms(&self) -> f64 {
        (self.squares() / self.residual.len().max(1) as f64).sqrt()
    }

    /// The part of the residual that belongs to positions.
    pub(super) fn of_positions(&self) -> &[f64] {
        &self.residual[..self.left.len()]
    }

    /// Covariance of the parameters for a noise of the positions whose variance is `variance`.
    pub(super) fn covariance(&self, variance: f64) -> DMatrix<f64> {
        let count = self.values.len();
        let information = self.slopes.transpose() * &self.slopes;
        // Scaled to ones on the diagonal: seconds and accelerations differ by many orders.
        let scale: Vec<f64> = (0..count)
            .map(|k| 1.0 / information[(k, k)].sqrt().max(f64::MIN_POSITIVE))
            .collect();
        let scaled = DMatrix::from_fn(count, count, |i, k| {
            information[(i, k)] * scale[i] * scale[k]
        });
        let inverse = scaled
            .pseudo_inverse(1e-12)
            .unwrap_or_else(|_| DMatrix::identity(count, count));
        DMatrix::from_fn(count, count, |i, k| {
            inverse[(i, k)] * scale[i] * scale[k] * variance
        })
    }
}

/// Residual vector of an actuator, with the origin and the steps at reversals that suit it best removed.
pub(super) fn residual(track: &Track, chain: &Chain) -> Vec<f64> {
    track.steps.removed(residuals(track, chain))
}

/// Measured minus simulated judged positions; the mean is 0.
fn residuals(track: &Track, chain: &Chain) -> Vec<f64> {
    let timing = Timing::uniform(track.cycle_s);
    let velocity = simulate(chain, &track.sent, &timing, Reading::Mean);
    let mut place = 0.0;
    let mut left: Vec<f64> = Vec::with_capacity(track.judged());
    for (n, (velocity, measured)) in velocity.iter().zip(&track.position).enumerate() {
        place += velocity * track.cycle_s;
        if n >= track.first {
            left.push(measured - place);
        }
    }
    let mean = left.iter().sum::<f64>() / left.len().max(1) as f64;
    left.iter_mut().for_each(|l| *l -= mean);
    left
}

/// Fits a structure from `start` on.
pub(super) fn fit(track: &Track, structure: Structure, start: &[f64]) -> Fit {
    let ranges = structure.ranges(track);
    let problem = Problem {
        track,
        structure,
        start: start.to_vec(),
        steps: DVector::zeros(structure.count()),
        ranges,
    };
    let (found, _) = LevenbergMarquardt::new()
        .with_patience(12)
        .with_ftol(1e-9)
        .with_xtol(1e-9)
        .minimize(problem);
    let values = found.values();
    let left = residuals(track, &structure.chain(&values));
    Fit {
        structure,
        residual: track.steps.removed(left.clone()),
        left,
        slopes: found.slopes(&values),
        values,
    }
}

/// The least-squares problem; its unknowns are counted in steps from the start.
struct Problem<'a> {
    track: &'a Track,
    structure: Structure,
    start: Vec<f64>,
    steps: DVector<f64>,
    ranges: Vec<Range>,
}

impl Problem<'_> {
    fn values(&self) -> Vec<f64> {
        let value = |((start, range), step): ((&f64, &Range), &f64)| {
            (start + step * range.step).clamp(range.low, range.high)
        };
        let starts = self.start.iter().zip(&self.ranges);
        starts.zip(self.steps.iter()).map(value).collect()
    }

    /// Central differences; one-sided where a range ends.
    fn slopes(&self, values: &[f64]) -> DMatrix<f64> {
        let mut columns = Vec::with_capacity(values.len());
        for (k, range) in self.ranges.iter().enumerate() {
            let at = |value: f64| {
                let mut moved = values.to_vec();
                moved[k] = value;
                residual(self.track, &self.structure.chain(&moved))
            };
            let low = (values[k] - range.step).max(range.low);
            let high = (values[k] + range.step).min(range.high);
            let (below, above) = (at(low), at(high));
            columns.push((DVector::from(above) - DVector::from(below)) / (high - low));
        }
        DMatrix::from_columns(&columns)
    }
}

impl LeastSquaresProblem<f64, Dyn, Dyn> for Problem<'_> {
    type ResidualStorage = Owned<f64, Dyn>;
    type JacobianStorage = Owned<f64, Dyn, Dyn>;
    type ParameterStorage = Owned<f64, Dyn>;

    fn set_params(&mut self, steps: &DVector<f64>) {
        self.steps.copy_from(steps);
    }

    fn params(&self) -> DVector<f64> {
        self.steps.clone()
    }

    fn residuals(&self) -> Option<DVector<f64>> {
        let left = residual(self.track, &self.structure.chain(&self.values()));
        left.iter().all(|r| r.is_finite()).then(|| left.into())
    }

    fn jacobian(&self) -> Option<DMatrix<f64>> {
        let mut slopes = self.slopes(&self.values());
        for (k, range) in self.ranges.iter().enumerate() {
            slopes.column_mut(k).scale_mut(range.step);
        }
        slopes.iter().all(|v| v.is_finite()).then_some(slopes)
    }
}
