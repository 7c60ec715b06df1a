//! Fitting a model's parameters to recordings.
//!
//! [`refit`] moves all parameters of the added effects, and every nominal parameter that has a
//! tolerance, together: by Levenberg and Marquardt's method on the residuals of all channels of
//! [`softdock_physics::model::prediction`], each in units of its expected noise, with the tolerances as
//! Gaussian priors. A parameter that the recording does not determine keeps its value and is
//! reported as undetermined, in place of a value with a meaninglessly wide interval.
//!
//! [`Logs`] are the recordings of a fit, checked; [`judged`] judges a fit on unseen data; [`record`] writes the steps of a
//! model's history; [`excitation`] says what a recording cannot show at all.

pub mod excitation;
pub mod judged;
pub mod record;

mod determined;
mod least_squares;
pub(crate) mod logs;
mod nominal;
mod parameter;
mod parameter_id;
mod residual;
pub(crate) mod same_rig;
mod sandwich;

pub use logs::Logs;
pub use parameter::Parameter;
pub use parameter_id::ParameterId;

use anyhow::ensure;
use determined::Doubt;
use least_squares::{Solution, minimise};
use residual::Residuals;
use serde::Serialize;
use softdock_io::recording::Recording;
use softdock_physics::model::Model;
use softdock_physics::model::edit::rounded;
use softdock_physics::model::load::effects::latest_s;
use softdock_physics::model::log::stretches;
use softdock_physics::model::prediction::signals::Signals;
use softdock_statistics::DEVIATIONS_95;
use std::ops::Range;

/// Why a file keeps its value: the rig's controller has a copy of it, with which it computes the
/// model velocity; an error of it is an effect of its own, such as `tool_mass_error`.
const CONTROLLERS: &str = "kept: the controller's own";
/// Why a file keeps its value: the new interval contains the old value.
const NO_NEWS: &str = "kept: no significant change";
/// Why a model keeps its value: nominal parameters were not to be fitted.
const EXACT: &str = "kept: as in the model";
/// Relative fall of χ² at which each round ends. After a round each channel is weighted by the rms that its residuals then have;
/// the weights of the first round need no exact values.
const ROUNDS: [f64; 2] = [1e-6, 1e-9];

/// A parameter that the recording determines.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Refitted {
    /// Its key in the model file.
    pub name: String,
    /// SI unit, `-` if it has none.
    pub unit: String,
    /// Value in the model file.
    pub before: f64,
    /// Fitted value.
    pub value: f64,
    /// Lower end of its 95 % interval.
    pub low: f64,
    /// Upper end.
    pub high: f64,
    /// Share of the knowledge about it that comes from its tolerance and not from the recording,
    /// 0 to 1.
    pub prior_share: f64,
    /// The model file keeps its value all the same: see the note.
    pub kept: bool,
    /// What has to be known to read the value rightly.
    pub note: Option<String>,
}

/// A parameter that the recording does not determine.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Undetermined {
    /// Its key in the model file.
    pub name: String,
    /// SI unit, `-` if it has none.
    pub unit: &'static str,
    /// Value in the model file, which it keeps.
    pub value: f64,
    /// Why the recording does not determine it.
    pub reason: String,
}

/// Result of a fit of all parameters.
#[derive(Clone, Debug)]
pub struct Refit {
    /// Parameters that the recording determines.
    pub parameters: Vec<Refitted>,
    /// Parameters that it does not determine.
    pub undetermined: Vec<Undetermined>,
    /// The model with the fitted values.
    pub after: Model,
}

/// Fits all parameters of the model's effects and all nominal parameters with a tolerance.
///
/// # Errors
///
/// A recording that cannot be predicted, or a model without anything to fit.
pub fn refit(
    model: &Model,
    recordings: &[&Recording],
    progress: &dyn Fn(f64, &str),
) -> anyhow::Result<Refit> {
    refit_those(model, recordings, &|_| true, progress)
}

/// [`refit`] of the effects with indices from `first` on; the other effects are held exactly. Nominal parameters are free, so
/// that their tolerances widen the intervals, but keep their values.
pub(crate) fn refit_effects(
    model: &Model,
    first: usize,
    recordings: &[&Recording],
) -> anyhow::Result<Refit> {
    let those = |parameter: &Parameter| match parameter.id {
        ParameterId::Effect(place, _) => place >= first,
        _ => true,
    };
    let fit = fitted(model, recordings, &those, &|_, _| {})?;
    Ok(fit.result(model, Some(EXACT)))
}

/// [`refit`] of the parameters that `those` accepts; the others are held exactly.
pub(crate) fn refit_those(
    model: &Model,
    recordings: &[&Recording],
    those: &dyn Fn(&Parameter) -> bool,
    progress: &dyn Fn(f64, &str),
) -> anyhow::Result<Refit> {
    Ok(fitted(model, recordings, those, progress)?.result(model, None))
}

/// Result of a fit, before it is decided which values are kept.
struct Fitted {
    /// Parameters that were fitted.
    free: Vec<Parameter>,
    /// Parameters that were held, as the recordings do not determine them.
    held: Vec<(Parameter, Doubt)>,
    solution: Solution,
    /// [`Residuals::believed`].
    believed: bool,
}

fn fitted(
    model: &Model,
    recordings: &[&Recording],
    those: &dyn Fn(&Parameter) -> bool,
    progress: &dyn Fn(f64, &str),
) -> anyhow::Result<Fitted> {
    let signals = recordings.iter().map(|recording| Signals::new(recording));
    let signals = signals.collect::<anyhow::Result<Vec<_>>>()?;
    let mut free = parameter::all(model);
    free.retain(those);
    let latest_s = latest_s(signals.iter().map(longest_s).fold(f64::INFINITY, f64::min));
    free.iter_mut()
        .for_each(|one| one.no_later_than(latest_s, model));
    ensure!(
        !free.is_empty(),
        "there is nothing to fit: the model has no effects, and all of its tolerances are 0"
    );
    let mut residuals = Residuals::new(model, &signals);
    let mut solution = Solution::start(&free);
    let mut held: Vec<(Parameter, Doubt)> = Vec::new();
    progress(0.05, "looking for what the log determines");
    let at_start = least_squares::jacobian(&residuals, model, &free);
    let doubts = determined::undetermined_alone(&at_start, &free);
    hold(&mut free, &mut solution.values, &mut held, doubts);
    for (round, tolerance) in ROUNDS.into_iter().enumerate() {
        loop {
            let share = 0.1 + 0.8 * round as f64 / ROUNDS.len() as f64;
            progress(share, &format!("fitting {} parameters", free.len()));
            solution = minimise(&residuals, model, &free, &solution.values, tolerance);
            let doubts = determined::undetermined_together(&solution, &free);
            if doubts.is_empty() {
                break;
            }
            hold(&mut free, &mut solution.values, &mut held, doubts);
        }
        residuals.weigh(&solution.model(model, &free));
    }
    progress(1.0, "done");
    Ok(Fitted {
        free,
        held,
        solution,
        believed: residuals.believed,
    })
}

/// Duration of the longest stretch of a log without gaps, s.
fn longest_s(signals: &Signals<'_>) -> f64 {
    let longest = stretches(signals).iter().map(Range::len).max();
    longest.unwrap_or_default() as f64 * signals.cycle_s
}

/// Moves undetermined parameters from `free` to `held`, and drops their values from the starting point of the next fit.
fn hold(
    free: &mut Vec<Parameter>,
    values: &mut Vec<f64>,
    held: &mut Vec<(Parameter, Doubt)>,
    doubts: Vec<(usize, Doubt)>,
) {
    let at = held.len();
    // From the end, so that the places of the others stay.
    for (k, doubt) in doubts.into_iter().rev() {
        held.insert(at, (free.remove(k), doubt));
        values.remove(k);
    }
}

impl Fitted {
    /// The model after the fit. Some parameters keep their values; the others get the best values given these. `nominal`: the
    /// reason to keep all nominal parameters, if they are to be kept.
    fn result(self, model: &Model, nominal: Option<&'static str>) -> Refit {
        let kept = |k: usize| {
            let why = nominal.filter(|_| self.free[k].tolerance.is_some());
            why.or_else(|| self.keeps(k))
        };
        let why: Vec<Option<&'static str>> = (0..self.free.len()).map(kept).collect();
        let kept = self.free.iter().zip(&why).enumerate();
        let kept = kept.filter(|(_, (_, why))| why.is_some());
        let kept: Vec<(usize, f64)> = kept.map(|(k, (one, _))| (k, one.value)).collect();
        let beside_kept = self.solution.values_with_held(&kept);
        let mut after = model.clone();
        let mut parameters = Vec::new();
        for (k, (parameter, why)) in self.free.iter().zip(why).enumerate() {
            let value = match why {
                Some(_) => self.solution.values[k],
                None => beside_kept[k].clamp(parameter.low, parameter.high),
            };
            let one = self.refitted(k, rounded(value), why);
            if !one.kept {
                parameter.write(&mut after, one.value);
                parameter.set_interval(&mut after, [one.low, one.high]);
            }
            parameters.push(one);
        }
        let undetermined = self.held.into_iter();
        let undetermined = undetermined.map(|(parameter, doubt)| Undetermined {
            reason: doubt.reason(&parameter),
            name: parameter.name,
            unit: parameter.unit,
            value: parameter.value,
        });
        Refit {
            parameters,
            undetermined: undetermined.collect(),
            after,
        }
    }

    /// Half of the 95 % interval of a parameter.
    fn reach(&self, k: usize) -> f64 {
        (DEVIATIONS_95 * self.solution.sigma(k)).max(self.free[k].resolution)
    }

    /// Why the file keeps the value of a parameter, if it does.
    fn keeps(&self, k: usize) -> Option<&'static str> {
        let parameter = &self.free[k];
        if self.believed && parameter.is_of_the_reading() {
            return Some(CONTROLLERS);
        }
        let moved = (self.solution.values[k] - parameter.value).abs();
        (parameter.tolerance.is_some() && moved < self.reach(k)).then_some(NO_NEWS)
    }

    /// Report on parameter `k` with a `value`; `kept`: why the file keeps its own value, if it does.
    fn refitted(&self, k: usize, value: f64, kept: Option<&'static str>) -> Refitted {
        let parameter = &self.free[k];
        let reach = self.reach(k);
        let [low, high] = [value - reach, value + reach].map(rounded);
        let mut partners = self.held.iter();
        let partner = partners.find(|(_, doubt)| doubt.partner() == Some(&parameter.name));
        let with = |(other, _): &(Parameter, Doubt)| format!("with {} as it is", other.name);
        Refitted {
            name: parameter.name.clone(),
            unit: parameter.unit.to_owned(),
            before: parameter.value,
            value,
            low,
            high,
            prior_share: parameter
                .tolerance
                .map_or(0.0, |t| (self.solution.sigma(k) / t).powi(2).min(1.0)),
            kept: kept.is_some(),
            note: kept.map(str::to_owned).or_else(|| partner.map(with)),
        }
    }
}
