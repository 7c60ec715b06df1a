//! From the findings of the stages to the diagnosis.

use super::closest_rival;
use super::equivalent;
use super::notes::Answer;
use super::ranking;
use super::regions;
use super::sentence;
use super::unaccounted::Unaccounted;
use super::verdict::{Judged, is_driven, of_a_rig, untested};
use crate::diagnose::evidence;
use crate::diagnose::finding::{Diagnosis, Equivalent, Nominal, Ranked, Region, RunnerUp, Verdict};
use crate::diagnose::logs::Logs;
use crate::diagnose::named::{NamedEffect, with_effects};
use crate::diagnose::prediction_error::error_reduction::ErrorReduction;
use crate::diagnose::prediction_error::left_over::left_over;
use crate::diagnose::prediction_error::log_to_log::from_log_to_log;
use crate::diagnose::question::Question;
use crate::diagnose::stages::Stages;
use crate::diagnose::wrench::NominalEstimate;
use crate::diagnose::wrench::left::RemainingStructure;
use crate::levels::{BeforeAfter, Step};
use softdock_io::recording::Recording;
use softdock_physics::model::Model;
use softdock_physics::model::load::effects::LoadEffect;
use softdock_physics::model::prediction::Prediction;
use softdock_statistics::DEVIATIONS_95;
use std::collections::BTreeMap;

/// The diagnosis, and the model with the named effects.
pub(crate) struct Outcome {
    /// What the user sees.
    pub diagnosis: Diagnosis,
    /// The model with the named effects.
    pub after: Model,
    /// Predictions of this model.
    pub predictions: Logs<Prediction>,
}

/// Draws the conclusion. `unseen`: the unseen log was given, and not held back from the one of the fit.
pub(crate) fn conclude(
    model: &Model,
    recordings: &Logs<&Recording>,
    stages: &Stages,
    unseen: bool,
    question: &Question<'_>,
) -> anyhow::Result<Outcome> {
    let (reduction, predictions) = ErrorReduction::of(model, recordings, stages, question)?;
    let named: Vec<&NamedEffect> = reduction.named.iter().map(|(named, _)| named).collect();
    let after = with_effects(model, named.iter().copied());
    let found: Vec<String> = named.iter().map(|n| n.effect.id.clone()).collect();
    // Beside named effects, refused ones are errors of form, which notes mention. If nothing is named, what they would explain
    // counts as left.
    let refused = reduction.refused.iter().flat_map(|r| &r.ids);
    let refused = refused.chain(&reduction.undetermined);
    let refused = refused.chain(reduction.drowned.iter().map(|(id, _)| id));
    let refused: Vec<&String> = refused.filter(|_| found.is_empty()).collect();
    let left = left_over(model, stages, &predictions, (&named, &refused));
    let in_sample = recordings.fitted == recordings.all.len();
    let judged = Judged::new(model, stages, question, found, &left, in_sample);
    let rest = Unaccounted::new(stages, &left, &judged);
    let same = equivalent::of(named.iter().copied()).filter(|_| !judged.is_unnamed());
    let asks_logs = judged.verdict == Verdict::Named && !question.of_one_log;
    let log_to_log = asks_logs
        .then(|| from_log_to_log(&after, recordings, &predictions, &named))
        .flatten();
    let notes = Answer {
        model,
        stages,
        fitted: recordings.fitted,
        verdict: judged.verdict,
        reduction: &reduction,
        log_to_log,
        rest: &rest,
        equivalent: same.as_ref(),
    };
    let notes = notes.all(judged.unexplained, in_sample);
    let of_all_logs = of_all_logs(stages, &reduction);
    let is_named = |id: &&String| named.iter().any(|one| one.effect.id == **id);
    let inputs = DiagnosisInputs {
        stages,
        late: reduction.late.as_ref().filter(is_named).map(|_| model),
        named,
        left: &left,
        judged: &judged,
        rest,
        predictions: &predictions,
    };
    let mut diagnosis = inputs.diagnosis(same, reduction.steps, notes, unseen);
    if let Some(why) = of_all_logs {
        diagnosis.is_of_all_logs(why);
    }
    diagnosis.sentence = sentence::of(&diagnosis, &left, judged.untestable);
    if judged.verdict == Verdict::NothingMissing {
        // Nothing is missing in what was tested; this says what was not.
        let untested = untested(stages).flat_map(|lack| [" ", lack]);
        diagnosis.sentence.extend(untested);
    }
    Ok(Outcome {
        diagnosis,
        after,
        predictions,
    })
}

/// All from which a diagnosis is put together.
struct DiagnosisInputs<'a> {
    stages: &'a Stages,
    /// The model, if a late effect is named that was found by its error on unseen data.
    late: Option<&'a Model>,
    named: Vec<&'a NamedEffect>,
    left: &'a [RemainingStructure],
    judged: &'a Judged,
    rest: Unaccounted,
    predictions: &'a Logs<Prediction>,
}

impl DiagnosisInputs<'_> {
    /// The diagnosis but for its sentence.
    fn diagnosis(
        self,
        equivalent: Option<Equivalent>,
        steps: Vec<Step>,
        notes: Vec<String>,
        unseen: bool,
    ) -> Diagnosis {
        let (stages, judged, predictions) = (self.stages, self.judged, self.predictions);
        let ranked = ranking::ranked(stages);
        let (runner_up, further_ties) = closest_rival::all(&judged.found, &self.rivals(&ranked));
        let named = self.named.iter();
        Diagnosis {
            sentence: String::new(),
            verdict: judged.verdict,
            experiment: runner_up.as_ref().and_then(|rival| {
                let is_felt = !is_driven(stages);
                closest_rival::experiment(judged.named().first(), rival, is_felt, of_a_rig(stages))
            }),
            looks_like: self.looks_like(),
            parameters: named
                .map(|n| (n.effect.id.clone(), n.estimates.clone()))
                .collect(),
            equivalent,
            effects: judged.named().to_vec(),
            probability: self.probability(runner_up.iter().chain(&further_ties).collect()),
            nominal: nominal(stages),
            residual_rms_sigma: BeforeAfter::of(stages.before.test(), predictions.test()),
            steps,
            runner_up,
            further_ties,
            regions: self.regions(),
            remainder: self.rest.remainder,
            ranked: ranking::reported(&ranked, &judged.found),
            strongest_evidence: ranking::strongest(stages),
            noise: stages.noise.clone(),
            notes,
            unseen,
            in_sample: predictions.fitted == predictions.all.len(),
            of_all_logs: None,
            seconds: 0.0,
            disagreeing: judged.disagreeing.clone(),
        }
    }

    /// What the error looks like, unproven. Effects whose intervals all include 0 are left out if others remain.
    fn looks_like(&self) -> Vec<String> {
        let may_be_0 = |id: &String| {
            let named = self.named.iter().find(|named| named.effect.id == *id);
            named.is_some_and(|named| named.may_be_0())
        };
        let (unsure, told): (Vec<String>, Vec<String>) = self
            .rest
            .looks_like(self.judged)
            .into_iter()
            .partition(may_be_0);
        match told.is_empty() {
            true => unsure,
            false => told,
        }
    }

    /// Hypotheses that may be rivals. If a late effect was found by its error on unseen data, the likelihood says nothing about
    /// hypotheses without one, which foretell worse.
    fn rivals(&self, ranked: &[Ranked]) -> Vec<Ranked> {
        let is_late = |model: &Model, id: &String| {
            LoadEffect::find(model, id).is_some_and(LoadEffect::is_late)
        };
        let may_be = |r: &&Ranked| {
            let late = |model| r.effects.iter().any(|id| is_late(model, id));
            self.late.is_none_or(late)
        };
        ranked.iter().filter(may_be).cloned().collect()
    }

    /// Probability of each named effect beside its rivals; empty if nothing is named.
    fn probability(&self, rivals: Vec<&RunnerUp>) -> BTreeMap<String, f64> {
        match self.judged.is_unnamed() {
            true => BTreeMap::new(),
            false => probabilities(&self.named, &rivals, self.rest.remainder.share > 0.0),
        }
    }

    /// Windows where the error shows: what is left, if nothing is named, else what is explained.
    fn regions(&self) -> Vec<Region> {
        match self.judged.is_unnamed() {
            true => regions::left_over(self.left, self.stages),
            false => {
                let [before, after] = [&self.stages.before, self.predictions].map(Logs::shown);
                regions::explained(before, after, self.stages)
            }
        }
    }
}

/// Why the named effects have the parameters of all logs. `None` if they have not, as parameters from least squares, which are
/// always those of the logs of the fit.
fn of_all_logs(stages: &Stages, reduction: &ErrorReduction) -> Option<String> {
    let of_search = reduction.refitted.is_none() && !reduction.named.is_empty();
    let wrench = stages.wrench.as_ref().filter(|_| of_search)?;
    wrench.found.accepted.as_ref()?.of_all_logs.clone()
}

/// Probability of each named effect: of two that the logs do not tell apart none is certain.
fn probabilities(
    named: &[&NamedEffect],
    rivals: &[&RunnerUp],
    leaves_structure: bool,
) -> BTreeMap<String, f64> {
    let of = |named: &&NamedEffect| {
        // A rival that fits better, but in whose place a simpler effect was taken, counts as equally likely.
        let own = named.support.against.max(0.0);
        let of_it = rivals.iter().find(|rival| rival.of == named.effect.id);
        let against = of_it.map_or(own, |rival| own.min(rival.against()));
        let probability = evidence::probability(against, leaves_structure);
        (named.effect.id.clone(), probability)
    };
    named.iter().map(of).collect()
}

/// Estimates of the nominal parameters beside the named effects, by name.
fn nominal(stages: &Stages) -> BTreeMap<String, Nominal> {
    let of = |estimate: &NominalEstimate| {
        let reach = DEVIATIONS_95 * estimate.sigma;
        let nominal = Nominal {
            value: estimate.value,
            low: estimate.value - reach,
            high: estimate.value + reach,
            tolerances: estimate.tolerances,
        };
        (estimate.name.clone(), nominal)
    };
    stages.nominal.iter().map(of).collect()
}
