//! 95 % intervals of the parameters of stages.
//!
//! Where χ² is smooth, its curvature gives the interval. A pause or a play shows only in the cycles that it holds still, so χ² is
//! a staircase there. It is scanned, and the interval is where 2 Δ log L stays below that of 95 %, with the other parameters at
//! their best for each value.

use super::candidate::Search;
use super::cost::{Cost, Term};
use super::refine::refined;
use super::tried::{Spec, at_an_end, plateau_step, specs};
use nalgebra::DMatrix;
use softdock_physics::model::stage::Stage;
use softdock_physics::optimise::brent;
use softdock_report::number;
use softdock_statistics::{DEVIATIONS_95, correlated_cycles, dot};

/// 2 Δ log L at the ends of a 95 % interval of one parameter (χ² with one degree of freedom).
const LIKELY_95: f64 = DEVIATIONS_95 * DEVIATIONS_95;
/// A scan ends after this many successive values outside of the interval.
const OUTSIDE: usize = 8;
/// Most values of a scan to one side: two and a half cycles, or once more the width of a play.
const FARTHEST: usize = 100;
/// Resolution of an instant, in cycles: half of a part into which the simulation cuts a cycle.
const RESOLVED: f64 = 1.0 / 16.0;

/// Ends of the 95 % interval of each parameter of each accepted term, from the logs of the fit; empty if nothing is accepted.
/// Forms that the logs do not tell apart widen it, as any of them may be the true one.
pub(crate) fn intervals(search: &Search, train: &Cost<'_>) -> Vec<Vec<[f64; 2]>> {
    let Some(accepted) = &search.accepted else {
        return Vec::new();
    };
    let mut all = of_terms(&accepted.terms, train);
    for form in &search.equal_forms {
        let other = of_terms(&form.terms, &train.around(&form.terms));
        let pairs = all.iter_mut().flatten().zip(other.into_iter().flatten());
        for (own, other) in pairs {
            *own = [own[0].min(other[0]), own[1].max(other[1])];
        }
    }
    all
}

/// χ² of terms as a function of all their parameters in a row.
struct Profile<'a> {
    terms: &'a [Term],
    train: &'a Cost<'a>,
    flat: Vec<f64>,
    /// The smallest value of each parameter that can be simulated: no limit and no width is negative.
    smallest: Vec<f64>,
    least: f64,
    /// χ² per value over that of noise, times the number of successive values that count as one. It widens intervals, as errors
    /// of form go on for many cycles.
    excess: f64,
}

impl<'a> Profile<'a> {
    fn new(terms: &'a [Term], train: &'a Cost<'a>) -> Self {
        let flat: Vec<f64> = terms
            .iter()
            .flat_map(|t| t.values.iter().copied())
            .collect();
        let least = train.of(terms);
        Self {
            terms,
            train,
            flat,
            smallest: terms.iter().flat_map(|t| smallest(t, train)).collect(),
            least,
            excess: (least / train.count().max(1) as f64).max(1.0) * correlated(terms, train),
        }
    }

    fn at(&self, values: &[f64]) -> f64 {
        let values = values.iter().zip(&self.smallest);
        let values: Vec<f64> = values.map(|(value, least)| value.max(*least)).collect();
        let mut at = 0;
        let moved: Vec<Term> = self
            .terms
            .iter()
            .map(|term| {
                let own = values[at..at + term.values.len()].to_vec();
                at += term.values.len();
                Term {
                    values: own,
                    ..term.clone()
                }
            })
            .collect();
        self.train.of(&moved)
    }

    /// χ² with one parameter given, the others at their best within 4 standard deviations.
    fn chi2_with(&self, i: usize, value: f64, sigma: &[f64]) -> f64 {
        /// Precision of each of the others, in standard deviations.
        const TOLERANCE: f64 = 0.1;
        let mut values = self.flat.clone();
        values[i] = value;
        for k in (0..values.len()).filter(|k| *k != i) {
            let reach = 4.0 * sigma[k];
            let range = (values[k] - reach, values[k], values[k] + reach);
            let mut moved = values.clone();
            let (best, _) = brent(range, TOLERANCE * sigma[k], |x| {
                moved[k] = x;
                self.at(&moved)
            });
            values[k] = best;
        }
        self.at(&values).min({
            let mut alone = self.flat.clone();
            alone[i] = value;
            self.at(&alone)
        })
    }
}

/// The smallest values that the parameters of a term may have.
fn smallest(term: &Term, train: &Cost<'_>) -> Vec<f64> {
    /// Share of the smallest value that a search tries.
    const BELOW: f64 = 1e-3;
    // Delay and lag are added to those of the nominal actuator, which may be too long, so they may be negative.
    let is_added = matches!(term.stage, Stage::Delay | Stage::Lag);
    let specs = specs(term.stage, &train.scale(&term.axes));
    let of = |spec: &Spec| match spec.low >= 0.0 && !is_added {
        true => BELOW * spec.low,
        false => f64::NEG_INFINITY,
    };
    specs.iter().map(of).collect()
}

/// Number of successive residuals that count as one: the mean over logs and axes, weighted by χ².
fn correlated(terms: &[Term], train: &Cost<'_>) -> f64 {
    let white = train.whitened_residuals(terms);
    let left = white.iter().flatten().filter(|series| !series.is_empty());
    let (sum, squares) = left.fold((0.0, 0.0), |(sum, squares), series| {
        let own = dot(series, series);
        (sum + own * correlated_cycles(series), squares + own)
    });
    if squares > 0.0 { sum / squares } else { 1.0 }
}

/// Intervals around the best values with nuisance parameters free. They are extended to the value of the fit, which may be that
/// for exact nominal parameters.
fn of_terms(terms: &[Term], train: &Cost<'_>) -> Vec<Vec<[f64; 2]>> {
    let best = refined(terms.to_vec(), train);
    let mut all = around_best(&best, train);
    let fitted = terms.iter().flat_map(|t| &t.values);
    for (interval, value) in all.iter_mut().flatten().zip(fitted) {
        *interval = [interval[0].min(*value), interval[1].max(*value)];
    }
    for (term, intervals) in terms.iter().zip(&mut all) {
        let specs = specs(term.stage, &train.scale(&term.axes));
        for ((spec, value), interval) in specs.iter().zip(&term.values).zip(intervals) {
            // At the end of a search the curvature says nothing of what lies beyond, so the interval is open.
            let [low, high] = at_an_end(term.stage, spec, *value);
            interval[0] = if low { f64::NEG_INFINITY } else { interval[0] };
            interval[1] = if high { f64::INFINITY } else { interval[1] };
        }
    }
    all
}

/// A sentence for each parameter that lies at an end of its searched range.
pub(super) fn at_their_ends(terms: &[Term], train: &Cost<'_>) -> Vec<String> {
    let of_term = |term: &Term| {
        let specs = specs(term.stage, &train.scale(&term.axes));
        let names = term.stage.parameters((3..6).any(|axis| term.axes[axis]));
        let each = specs.into_iter().zip(term.values.clone()).zip(names);
        let stage = term.stage;
        each.filter_map(move |((spec, value), (name, unit))| {
            let end = match at_an_end(stage, &spec, value) {
                [true, _] => spec.low,
                [_, true] => spec.high,
                _ => return None,
            };
            let unit = match *unit {
                "-" => String::new(),
                unit => format!(" {unit}"),
            };
            Some(format!(
                "Of `{}` {name} reaches the end of what the search tries, {}{unit}: the true one may lie beyond.",
                stage.id(),
                number::significant(end, 3)
            ))
        })
        .collect::<Vec<_>>()
    };
    terms.iter().flat_map(of_term).collect()
}

fn around_best(terms: &[Term], train: &Cost<'_>) -> Vec<Vec<[f64; 2]>> {
    let profile = Profile::new(terms, train);
    let sigma = deviations(&profile);
    let mut i = 0;
    terms
        .iter()
        .map(|term| {
            let own = term.values.iter().map(|value| {
                let interval = match plateau_step(term.stage, *value, train.cycle_s()) {
                    Some(step) => {
                        // A play is a length, which the parts of a cycle do not limit.
                        let is_time = matches!(term.stage, Stage::Pause(..));
                        let resolved = if is_time {
                            RESOLVED * train.cycle_s()
                        } else {
                            0.0
                        };
                        let reach = scanned(&profile, i, &sigma, step);
                        let [down, up] = reach.map(|reach| reach.max(resolved));
                        [(value - down).max(0.0), value + up]
                    }
                    None => {
                        let reach = DEVIATIONS_95 * sigma[i] * profile.excess.sqrt();
                        [value - reach, value + reach]
                    }
                };
                i += 1;
                interval
            });
            own.collect()
        })
        .collect()
}

/// How far likely values reach below and above the best one.
fn scanned(profile: &Profile<'_>, i: usize, sigma: &[f64], step: f64) -> [f64; 2] {
    let best = profile.flat[i];
    let likely = profile.least + LIKELY_95 * profile.excess;
    let end = |side: f64| {
        let (mut last, mut outside) = (0, 0);
        for n in 1..=FARTHEST {
            let value = best + side * n as f64 * step;
            if value <= 0.0 || outside == OUTSIDE {
                break;
            }
            if profile.chi2_with(i, value, sigma) <= likely {
                (last, outside) = (n, 0);
            } else {
                outside += 1;
            }
        }
        // The limit lies between the last value inside and the first outside.
        (last as f64 + 0.5) * step
    };
    [end(-1.0), end(1.0)]
}

/// Standard deviation of each parameter from the curvature of χ², all parameters free.
fn deviations(profile: &Profile<'_>) -> Vec<f64> {
    let size = profile.flat.len();
    let steps: Vec<f64> = (0..size).map(|i| step_to_one(i, profile)).collect();
    let moved = |i: usize, k: usize, si: f64, sk: f64| {
        let mut values = profile.flat.clone();
        values[i] += si * steps[i];
        values[k] += sk * steps[k];
        profile.at(&values)
    };
    let half_hessian = DMatrix::from_fn(size, size, |i, k| {
        if i == k {
            (moved(i, i, 0.5, 0.5) + moved(i, i, -0.5, -0.5) - 2.0 * profile.least) / 2.0
        } else {
            (moved(i, k, 1.0, 1.0) + moved(i, k, -1.0, -1.0)
                - moved(i, k, 1.0, -1.0)
                - moved(i, k, -1.0, 1.0))
                / 8.0
        }
    });
    let covariance = half_hessian.cholesky().map(|c| c.inverse());
    (0..size)
        .map(|i| {
            let own = covariance.as_ref().map_or(f64::NAN, |c| c[(i, i)].sqrt());
            // A cost that is not smooth may have no usable curvature; a rise of χ² by one is one deviation all the same.
            steps[i] * if own.is_finite() { own.max(1.0) } else { 1.0 }
        })
        .collect()
}

/// Step of one parameter that raises χ² by about one.
fn step_to_one(i: usize, profile: &Profile<'_>) -> f64 {
    let mut step = 1e-6 * profile.flat[i].abs().max(1e-9);
    for _ in 0..48 {
        let rise = [step, -step].into_iter().map(|s| {
            let mut values = profile.flat.clone();
            values[i] += s;
            profile.at(&values) - profile.least
        });
        if rise.fold(0.0, f64::max) >= 1.0 {
            break;
        }
        step *= 1.5;
    }
    step
}
