//! The parameters that foretell unseen data best.
//!
//! Names are decided by the likelihood of the noise as it is, which gives slow errors little weight where the noise is slow.
//! Where the form of a law is wrong, that likelihood fits the parameters to the fast part of the residual. Parameters from least
//! squares, in which all errors count alike, then foretell the wrench better.

use super::foresight::Foresight;
use crate::diagnose::answer::ranking::foretells_alike;
use crate::diagnose::catalogue::is_general_curve;
use crate::diagnose::evidence::RISES;
use crate::diagnose::logs::Logs;
use crate::diagnose::named::{NamedEffect, of_reading, with_effects};
use crate::diagnose::stages::accepted;
use crate::diagnose::stages::{Stages, predict_all};
use crate::diagnose::wrench::TestedHypothesis;
use crate::diagnose::wrench::finding::WrenchFinding;
use crate::fit::refit_effects;
use crate::levels::ChannelLevels;
use softdock_io::recording::Recording;
use softdock_physics::model::prediction::Prediction;
use softdock_physics::model::{Channel, Model};

/// Effects with other parameters; the error on unseen data before, and with them.
pub(crate) type Better = (Vec<NamedEffect>, [f64; 2]);

/// The effects with the parameters of least squares; `None` if these do not foretell unseen data better. Each interval covers
/// those of both fits. With `in_rounds` it is that of least squares alone: some effects were held while others were found, so
/// that their intervals were too narrow or too wide.
pub(crate) fn refit(
    model: &Model,
    recordings: &Logs<&Recording>,
    named: &[NamedEffect],
    in_rounds: bool,
) -> anyhow::Result<Option<Better>> {
    if named.is_empty() {
        return Ok(None);
    }
    let before = Errors::of(model, recordings, named)?;
    let refitted = by_least_squares(model, recordings, named, in_rounds)?;
    let after = Errors::of(model, recordings, &refitted)?;
    let is_better = after.unseen * RISES < before.unseen; // not so for NaN
    Ok(is_better.then_some((refitted, [before.unseen, after.unseen])))
}

/// Most ties that are searched anew.
const TRIED: usize = 3;

/// Ties of the answer that foretell better ([`Foresight`]): each is a list of ids, with one effect in the place of another that
/// the logs of the fit do not tell from it, and no more parameters. Those with a better simulated motion come first. Where
/// structure is left, errors of form decide between an effect and its tie in the likelihood.
pub(crate) fn better_ties(
    model: &Model,
    recordings: &Logs<&Recording>,
    stages: &Stages,
) -> anyhow::Result<Vec<Vec<String>>> {
    let ties = stages.wrench.as_ref().map_or(Vec::new(), no_larger_ties);
    if ties.is_empty() {
        return Ok(Vec::new());
    }
    let fitted = |named: &[NamedEffect]| -> anyhow::Result<(Model, Errors)> {
        let named = by_least_squares(model, recordings, named, false)?;
        let errors = Errors::of(model, recordings, &named)?;
        Ok((with_effects(model, named.iter()), errors))
    };
    let named = accepted::all(model, stages);
    let (after, errors) = fitted(&named)?;
    let answer = Foresight::new(&after, errors, recordings.test());
    let mut better: Vec<((bool, f64), Vec<String>)> = Vec::new();
    for tie in ties {
        let mut others = named.clone();
        let accepted = stages.wrench.iter().flat_map(|w| &w.found.accepted);
        let accepted: Vec<String> = accepted.flat_map(TestedHypothesis::ids).collect();
        others.retain(|one| !accepted.contains(&one.effect.id));
        others.extend(tie.effects.iter().map(of_reading));
        let (after, errors) = fitted(&others)?;
        let tried = Foresight::new(&after, errors, recordings.test());
        if tried.is_better_than(&answer) {
            let ids = others.into_iter().map(|one| one.effect.id).collect();
            better.push(((!tried.moves_better_than(&answer), tried.unseen()), ids));
        }
    }
    better.sort_by(|(a, _), (b, _)| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
    better.truncate(TRIED);
    Ok(better.into_iter().map(|(_, ids)| ids).collect())
}

/// Hypotheses that tie with the answer, with another effect in the place of one and no more parameters.
fn no_larger_ties(wrench: &WrenchFinding) -> Vec<TestedHypothesis> {
    let ranked = &wrench.found.ranked;
    let accepted = wrench.found.accepted.as_ref();
    let answer = accepted.and_then(|accepted| ranked.iter().find(|t| t.is_same(accepted)));
    let Some(answer) =
        answer.filter(|_| wrench.can_foretell() && wrench.remaining_structure().is_structured())
    else {
        return Vec::new();
    };
    let error = |tested: &TestedHypothesis| wrench.prepared.error_on_unseen(tested);
    let alike = ranked.iter().filter(|t| t.beside == answer.beside);
    let alike = alike.map(|t| t.clone().beside_noise(answer.to_explain));
    let alike = alike.filter(|t| t.wrong.is_empty() && t.parameters <= answer.parameters);
    let alike = alike.filter(|t| !t.effects.iter().any(|one| is_general_curve(one.id)));
    alike
        .filter(|t| foretells_alike(answer, t, &error).is_some())
        .collect()
}

pub(crate) fn by_least_squares(
    model: &Model,
    recordings: &Logs<&Recording>,
    named: &[NamedEffect],
    anew: bool,
) -> anyhow::Result<Vec<NamedEffect>> {
    let first = model.effects.len();
    let found = refit_effects(
        &with_effects(model, named.iter()),
        first,
        recordings.train(),
    )?;
    let fitted = named.iter().zip(&found.after.effects[first..]);
    let refitted = fitted.map(|(named, fitted)| named.clone().refitted(model, fitted, anew));
    Ok(refitted.collect())
}

/// Whether less than half of the wrench of a log is predicted, because of a delay: then there is no error to compare.
fn predicts_little(prediction: &Prediction) -> bool {
    let rows = &prediction.channel(Channel::Wrench).predicted;
    2 * rows.iter().flatten().count() < rows.len()
}

/// Rms errors with some effects, in units of the noise; NaN where too little is predicted.
#[derive(Clone, Copy)]
pub(crate) struct Errors {
    /// Of the logs of the fit.
    pub(crate) of_fit: f64,
    /// On the unseen logs.
    pub(crate) unseen: f64,
}

impl Errors {
    pub(crate) fn of(
        model: &Model,
        recordings: &Logs<&Recording>,
        named: &[NamedEffect],
    ) -> anyhow::Result<Self> {
        let predictions = predict_all(&with_effects(model, named.iter()), recordings)?;
        Ok(Self::of_predictions(&predictions))
    }

    /// The errors of given predictions.
    pub(crate) fn of_predictions(predictions: &Logs<Prediction>) -> Self {
        if predictions.all.iter().any(predicts_little) {
            return Self {
                of_fit: f64::NAN,
                unseen: f64::NAN,
            };
        }
        Self {
            of_fit: ChannelLevels::of(predictions.train()).rms(),
            unseen: ChannelLevels::of(predictions.test()).rms(),
        }
    }
}
