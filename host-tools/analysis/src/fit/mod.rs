//! Fitting a model's parameters to recordings.
//!
//! [`refit`] moves all parameters of the added effects, and every nominal parameter that has a
//! tolerance, together: by Levenberg and Marquardt's method on the residuals of all channels of
//! [`softdock_physics::model::prediction`], each in units of its expected noise, with the tolerances as
//! Gaussian priors. What the recording does not determine stays as it is and is said to be
//! undetermined; a number with an interval of the size of the universe is no result.
//!
//! [`Logs`] are the recordings of a fit, checked; [`judged`] holds a fit against what it has not seen; [`record`] writes the
//! steps of a model's history, [`excitation`] says what a recording cannot teach at all.

pub mod excitation;
pub mod judged;
pub mod record;

mod determined;
mod least_squares;
pub(crate) mod logs;
mod nominal;
mod parameter;
mod residual;
pub(crate) mod same_rig;
mod sandwich;

pub use logs::Logs;
pub use parameter::{Parameter, ParameterId};

use anyhow::ensure;
use determined::Doubt;
use least_squares::{Solution, minimise};
use residual::Residuals;
use serde::Serialize;
use softdock_io::recording::Recording;
use softdock_physics::model::Model;
use softdock_physics::model::edit::rounded;
use softdock_physics::model::prediction::signals::Signals;
use softdock_statistics::DEVIATIONS_95;

/// Why a file keeps its value: the rig's controller has a copy of it, with which it computes the
/// model velocity; an error of it is an effect of its own, such as `tool_mass_error`.
const CONTROLLERS: &str = "kept: the controller's own";
/// Why a file keeps its value: the new interval contains the old value.
const NO_NEWS: &str = "kept: no significant change";
/// Each round gives the channels the weights that the last one found; two suffice.
const ROUNDS: usize = 2;

/// A parameter that the recording determines.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Refitted {
    /// Its place in the model file.
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
    /// Its place in the model file.
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
    /// What the recording determines.
    pub parameters: Vec<Refitted>,
    /// What it does not.
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

/// [`refit`] of the model's effects from the place `first` on, beside the nominal parameters; the others are exact.
pub(crate) fn refit_effects(
    model: &Model,
    first: usize,
    recordings: &[&Recording],
) -> anyhow::Result<Refit> {
    let those = |parameter: &Parameter| match parameter.id {
        ParameterId::Effect(place, _) => place >= first,
        _ => true,
    };
    refit_those(model, recordings, &those, &|_, _| {})
}

/// [`refit`] of some of the parameters; the others are exact.
pub(crate) fn refit_those(
    model: &Model,
    recordings: &[&Recording],
    those: &dyn Fn(&Parameter) -> bool,
    progress: &dyn Fn(f64, &str),
) -> anyhow::Result<Refit> {
    let signals = recordings.iter().map(|recording| Signals::new(recording));
    let signals = signals.collect::<anyhow::Result<Vec<_>>>()?;
    let mut free = parameter::all(model);
    free.retain(those);
    ensure!(
        !free.is_empty(),
        "there is nothing to fit: the model has no effects, and all of its tolerances are 0"
    );
    let mut residuals = Residuals::new(model, &signals);
    let mut solution = Solution::start(&free);
    let mut held: Vec<(Parameter, Doubt)> = Vec::new();
    progress(0.05, "looking for what the log determines");
    let at_start = least_squares::jacobian(&residuals, model, &free);
    let doubts = determined::alone(&at_start, &free);
    hold(&mut free, &mut solution.values, &mut held, doubts);
    for round in 0..ROUNDS {
        loop {
            let share = 0.1 + 0.8 * round as f64 / ROUNDS as f64;
            progress(share, &format!("fitting {} parameters", free.len()));
            solution = minimise(&residuals, model, &free, &solution.values);
            let doubts = determined::together(&solution, &free);
            if doubts.is_empty() {
                break;
            }
            hold(&mut free, &mut solution.values, &mut held, doubts);
        }
        residuals.weigh(&solution.model(model, &free));
    }
    progress(1.0, "done");
    Ok(result(model, &free, held, &solution, residuals.believed))
}

/// Takes what is in doubt out of the fit, and its value out of the values from which that goes on.
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

fn result(
    model: &Model,
    free: &[Parameter],
    held: Vec<(Parameter, Doubt)>,
    solution: &Solution,
    believed: bool,
) -> Refit {
    let mut after = model.clone();
    let mut parameters = Vec::new();
    for (k, parameter) in free.iter().enumerate() {
        let fitted = (rounded(solution.values[k]), solution.sigma(k));
        let one = refitted(parameter, fitted, &held, believed);
        if !one.kept {
            parameter.write(&mut after, one.value);
            parameter.set_interval(&mut after, [one.low, one.high]);
        }
        parameters.push(one);
    }
    let undetermined = held
        .into_iter()
        .map(|(parameter, doubt)| Undetermined {
            reason: doubt.reason(&parameter),
            name: parameter.name,
            unit: parameter.unit,
            value: parameter.value,
        })
        .collect();
    Refit {
        parameters,
        undetermined,
        after,
    }
}

/// A parameter of the fit with its value and standard deviation; `believed`: see [`Residuals`].
fn refitted(
    parameter: &Parameter,
    (value, sigma): (f64, f64),
    held: &[(Parameter, Doubt)],
    believed: bool,
) -> Refitted {
    let reach = (DEVIATIONS_95 * sigma).max(parameter.resolution);
    let [low, high] = [value - reach, value + reach].map(rounded);
    let nominal = parameter.tolerance.is_some();
    let kept = if believed && parameter.is_of_the_reading() {
        Some(CONTROLLERS)
    } else {
        (nominal && (value - parameter.value).abs() < reach).then_some(NO_NEWS)
    };
    let mut partners = held.iter();
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
            .map_or(0.0, |t| (sigma / t).powi(2).min(1.0)),
        kept: kept.is_some(),
        note: kept.map(str::to_owned).or_else(|| partner.map(with)),
    }
}
