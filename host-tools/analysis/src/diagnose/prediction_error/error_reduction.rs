//! How the error falls as named effects are added one after the other, and which effects are refused for it.

use super::brakes::{Braking, with_what_brakes};
use super::for_prediction;
use super::late_by_foretelling;
use super::left_over::left_of_actuator;
use super::noise_of_motion::Drowned;
use super::reversal;
use crate::diagnose::evidence::{FORETELLS, RISES};
use crate::diagnose::logs::Logs;
use crate::diagnose::named::{NamedEffect, with_effects};
use crate::diagnose::question::Question;
use crate::diagnose::stages::accepted;
use crate::diagnose::stages::{Stages, predict_all};
use crate::diagnose::wrench::finding::WrenchFinding;
use crate::levels::{ChannelLevels, Step};
use softdock_io::recording::Recording;
use softdock_physics::model::load::effects::LoadEffect;
use softdock_physics::model::prediction::Prediction;
use softdock_physics::model::stage::Stage;
use softdock_physics::model::{EffectModel, Model, WrenchMeaning};
use std::collections::BTreeMap;

/// The fall of the error, and what is named.
pub(crate) struct ErrorReduction {
    /// Named effects with their share in the fall of the squared error on the logs of the fit, the largest share first.
    pub named: Vec<(NamedEffect, f64)>,
    /// The error with none, one, two ... of them.
    pub steps: Vec<Step>,
    /// Effects that are refused, as the error does not fall enough with them.
    pub refused: Vec<Refused>,
    /// Error on unseen data with the parameters of the likelihood and with those of least squares; `None` if the former were
    /// kept.
    pub refitted: Option<[f64; 2]>,
    /// Id of a late effect that was found by its error on unseen data.
    pub late: Option<String>,
    /// An effect that was found by the simulated swing.
    pub braking: Option<Braking>,
    /// Ids of effects that were dropped, as a late effect, or a friction with a finite transition speed, foretells better without
    /// them.
    pub done_without: Vec<String>,
    /// Ids of effects that are not named, as the intervals of all their parameters include 0.
    pub undetermined: Vec<String>,
    /// Ids of masses and inertias that are not named, as they follow from an acceleration that is mostly noise.
    pub drowned: Vec<(String, Drowned)>,
    /// Ids and names of amounts without which unseen data are predicted better, with the error with and without each.
    pub left_out: Vec<(String, String, [f64; 2])>,
    /// Ids of named masses and inertias with the share of noise in the squared acceleration, by which their intervals are wider.
    pub noisy: Vec<(String, f64)>,
}

/// Effects with which the error is larger, or hardly smaller where structure is left or errors of form may be all that they
/// explain.
pub(crate) struct Refused {
    /// Their ids; several if all of them together are refused.
    pub ids: Vec<String>,
    /// The error without and with them.
    pub errors: [f64; 2],
    /// The errors are those on the logs of the fit, not those on unseen data.
    pub of_fit: bool,
}

impl ErrorReduction {
    /// The fall of the error, and the predictions with all that is named. If the user asked for an effect, none is refused.
    pub(crate) fn of(
        model: &Model,
        recordings: &Logs<&Recording>,
        stages: &Stages,
        question: &Question<'_>,
    ) -> anyhow::Result<(Self, Logs<Prediction>)> {
        let asked = question.is_asked();
        let NamedEffects {
            named: found,
            turned,
            late,
            braking,
            done_without,
        } = NamedEffects::of(model, recordings, stages, question)?;
        let mut known = SubsetPredictions::new(model, recordings, found, stages, asked);
        let mut everything: Vec<usize> = (0..known.all.len()).collect();
        known.refit(&everything)?;
        let (drowned, undetermined, refused) = match asked {
            true => (Vec::new(), Vec::new(), Vec::new()),
            false => (
                known.without_drowned(&mut everything)?,
                known.without_vague(&mut everything)?,
                known.refuse(&mut everything)?,
            ),
        };
        let left_out = known.without_misleading_amounts(&everything)?;
        let noisy = known.widened_by_noise(&everything)?;
        let named = known.shares(&everything)?;
        let order: Vec<usize> = named.iter().map(|(k, _)| *k).collect();
        let steps = known.steps(&order)?;
        let end = known.levels(&order)?;
        let named = named.iter();
        let named = named.map(|(k, share)| (known.all[*k].clone(), *share));
        let named = named.collect();
        let turned = turned.map(|before| [before, end.test]);
        let refitted = turned.or(known.refitted);
        let predictions = known.into_predictions(&order)?;
        let reduction = Self {
            named,
            steps,
            refused,
            refitted,
            undetermined,
            drowned,
            left_out,
            noisy,
            late,
            braking,
            done_without,
        };
        Ok((reduction, predictions))
    }
}

/// The effects that go into the fall.
struct NamedEffects {
    named: Vec<NamedEffect>,
    /// Error on unseen data before frictions were given a transition speed or a late effect was added; `None` if neither was.
    turned: Option<f64>,
    /// Id of a late effect, if it was found by its error on unseen data.
    late: Option<String>,
    /// See [`ErrorReduction::braking`].
    braking: Option<Braking>,
    /// Ids of effects that were dropped then.
    done_without: Vec<String>,
}

impl NamedEffects {
    fn of(
        model: &Model,
        recordings: &Logs<&Recording>,
        stages: &Stages,
        question: &Question<'_>,
    ) -> anyhow::Result<Self> {
        let mut answer = Self::or_late(model, recordings, stages, question)?;
        // Who asks for effects gets these.
        let searched = stages.wrench.as_ref().filter(|_| !question.is_asked());
        if let Some(wrench) = searched
            && let Some(braking) = with_what_brakes(model, recordings, &answer.named, wrench)?
        {
            answer.named = braking.named.clone();
            answer.braking = Some(braking);
        }
        Ok(answer)
    }

    /// What the stages accepted, with frictions that turn round over a speed, or a late effect, where these foretell better.
    fn or_late(
        model: &Model,
        recordings: &Logs<&Recording>,
        stages: &Stages,
        question: &Question<'_>,
    ) -> anyhow::Result<Self> {
        let named = accepted::all(model, stages);
        let turns_round = |w: &&WrenchFinding| w.beside_remainder.is_some() && w.can_foretell();
        let Some(wrench) = stages.wrench.as_ref().filter(turns_round) else {
            return Ok(Self::as_named(named));
        };
        let speed = wrench.prepared.pace().speed;
        let turned = reversal::with_reversals(model, recordings, &named, speed)?;
        let so_far = turned.as_ref().map_or(&named, |(turned, _)| turned);
        let late = late_effects(model, wrench, question);
        let late =
            late_by_foretelling::with_what_is_late(model, recordings, so_far, wrench, &late)?;
        let before = turned
            .as_ref()
            .or(late.as_ref())
            .map(|(_, [before, _])| *before);
        Ok(match late.or(turned) {
            Some((better, _)) => {
                let is_in = |all: &[NamedEffect], one: &NamedEffect| {
                    all.iter().any(|o| o.effect.id == one.effect.id)
                };
                let gone = named.iter().filter(|one| !is_in(&better, one));
                let late = better.iter().find(|one| !is_in(&named, one));
                Self {
                    done_without: gone.map(|one| one.effect.id.clone()).collect(),
                    late: late.map(|one| one.effect.id.clone()),
                    turned: before,
                    named: better,
                    braking: None,
                }
            }
            None => Self::as_named(named),
        })
    }

    fn as_named(named: Vec<NamedEffect>) -> Self {
        Self {
            named,
            turned: None,
            late: None,
            braking: None,
            done_without: Vec::new(),
        }
    }
}

/// Late effects that may be tried, each with the upper end of its searched range. Empty if an effect of the answer or of the
/// model is late already.
fn late_effects(
    model: &Model,
    wrench: &WrenchFinding,
    question: &Question<'_>,
) -> Vec<(&'static LoadEffect, f64)> {
    let is_late = |effect: &&LoadEffect| {
        let is_tried = effect.is_late() && question.tries(model, effect.id);
        is_tried && effect.parameters.iter().all(|p| p.low >= 0.0)
    };
    let knows =
        |known: &EffectModel| LoadEffect::find(model, &known.id).is_some_and(LoadEffect::is_late);
    if !wrench.late_ids().is_empty() || model.effects.iter().any(knows) {
        return Vec::new();
    }
    let logs = &wrench.prepared.logs;
    let acts = |effect: &&LoadEffect| logs.iter().any(|log| effect.acts(&log.scene));
    let late = LoadEffect::all(model).filter(is_late).filter(acts);
    let with_end = |effect: &'static LoadEffect| {
        let [parameter] = &effect.parameters[..] else {
            return None;
        };
        let [_, end] = effect.search_range(parameter, wrench.prepared.pace());
        Some((effect, end))
    };
    late.filter_map(with_end).collect()
}

/// Rms errors on the logs of the fit and on the unseen ones.
pub(super) struct Error {
    pub(super) train: f64,
    pub(super) test: f64,
}

/// Predictions with subsets of the found effects; each subset is predicted once.
pub(super) struct SubsetPredictions<'a> {
    pub(super) model: &'a Model,
    pub(super) recordings: &'a Logs<&'a Recording>,
    /// The effects with the parameters of the search.
    pub(super) found: Vec<NamedEffect>,
    /// The effects with the parameters that foretell best.
    pub(super) all: Vec<NamedEffect>,
    pub(super) refitted: Option<[f64; 2]>,
    pub(super) predictions: BTreeMap<Vec<usize>, Logs<Prediction>>,
    /// Structure is left, so that the likelihood and the error itself may prefer different parameters.
    leaves_structure: bool,
    /// Some effects were held while others were found beside them.
    in_rounds: bool,
    /// A shape that the user asked for stands at the end of its searched range: least squares may go beyond.
    at_an_end: bool,
    pub(super) can_foretell: bool,
    /// See [`may_be_form`].
    may_be_form: bool,
}

/// Whether the effects of a servo may explain only errors of form of each other: on a machine that is no docking rig they always
/// leave structure.
fn may_be_form(stages: &Stages) -> bool {
    let leaves = |found| left_of_actuator(found, stages, 0.0).is_structured();
    let of_a_servo = stages.wrench.is_none() && !stages.logs.have_spacecraft();
    of_a_servo && stages.actuator.as_ref().is_some_and(leaves)
}

impl<'a> SubsetPredictions<'a> {
    fn new(
        model: &'a Model,
        recordings: &'a Logs<&'a Recording>,
        found: Vec<NamedEffect>,
        stages: &Stages,
        asked: bool,
    ) -> Self {
        let wrench = stages.wrench.as_ref();
        let is_at_end =
            |named: &NamedEffect| wrench.is_some_and(|w| named.at_its_end(&w.prepared).is_some());
        Self {
            model,
            recordings,
            all: found.clone(),
            refitted: None,
            predictions: BTreeMap::new(),
            leaves_structure: wrench.is_some_and(|w| w.beside_remainder.is_some()),
            in_rounds: wrench.is_some_and(|w| !w.earlier.0.is_empty()),
            at_an_end: asked && found.iter().any(is_at_end),
            can_foretell: match wrench {
                Some(wrench) => wrench.can_foretell(),
                None => recordings.fitted < recordings.all.len(),
            },
            may_be_form: may_be_form(stages),
            found,
        }
    }

    /// Errors with these effects.
    pub(super) fn levels(&mut self, effects: &[usize]) -> anyhow::Result<Error> {
        let key = sorted(effects);
        let both = match self.predictions.remove(&key) {
            Some(both) => both,
            None => self.predicted(&key)?,
        };
        let totals = Error {
            train: ChannelLevels::of(both.train()).rms(),
            test: ChannelLevels::of(both.test()).rms(),
        };
        self.predictions.insert(key, both);
        Ok(totals)
    }

    /// For each of these effects its share in the fall of the squared error on the logs of the fit, beside the others; the
    /// largest first.
    fn shares(&mut self, effects: &[usize]) -> anyhow::Result<Vec<(usize, f64)>> {
        let square = |error: Error| error.train * error.train;
        let (start, end) = (square(self.levels(&[])?), square(self.levels(effects)?));
        let mut shares = Vec::new();
        for &k in effects {
            let lost = square(self.levels(&without(effects, k))?) - end;
            shares.push((k, lost / (start - end).max(1e-12)));
        }
        shares.sort_by(|a, b| b.1.total_cmp(&a.1));
        in_signal_order(&mut shares, &self.all);
        Ok(shares)
    }

    /// The error with none, one, two ... of these effects.
    fn steps(&mut self, order: &[usize]) -> anyhow::Result<Vec<Step>> {
        let unseen = self.recordings.fitted < self.recordings.all.len();
        let mut steps = Vec::new();
        for count in 0..=order.len() {
            let so_far = self.levels(&order[..count])?;
            let last = order[..count].last();
            let effect = last.map_or("nominal", |k| &self.all[*k].effect.id);
            steps.push(Step {
                effect: effect.to_owned(),
                train_error: so_far.train,
                test_error: unseen.then_some(so_far.test),
            });
        }
        Ok(steps)
    }

    /// Whether parameters from least squares are tried.
    fn is_refitted(&self) -> bool {
        self.leaves_structure || self.in_rounds || self.at_an_end
    }

    /// Gives these effects the parameters that foretell best beside each other.
    pub(super) fn refit(&mut self, effects: &[usize]) -> anyhow::Result<()> {
        if !self.is_refitted() {
            return Ok(());
        }
        let named: Vec<NamedEffect> = effects.iter().map(|k| self.found[*k].clone()).collect();
        let better = for_prediction::refit(self.model, self.recordings, &named, self.in_rounds)?;
        let (best, errors) = better.map_or((named, None), |(best, errors)| (best, Some(errors)));
        effects
            .iter()
            .zip(best)
            .for_each(|(&k, best)| self.all[k] = best);
        self.refitted = errors;
        self.predictions.clear();
        Ok(())
    }

    /// Removes effects whose intervals do not exclude that they are absent, one at a time; an effect without which unseen data
    /// are foretold much worse stays. Returns the ids of those removed.
    fn without_vague(&mut self, effects: &mut Vec<usize>) -> anyhow::Result<Vec<String>> {
        let mut gone = Vec::new();
        let mut kept: Vec<usize> = Vec::new();
        loop {
            let is_vague =
                |k: &&usize| !kept.contains(k) && !self.all[**k].is_significant(self.model);
            let Some(vague) = effects.iter().find(is_vague).copied() else {
                return Ok(gone);
            };
            let with = self.levels(effects)?.test;
            let others = without(effects, vague);
            self.refit(&others)?;
            let worse = self.levels(&others)?.test / with;
            if self.can_foretell && worse > FORETELLS {
                self.found[vague].foretells(worse);
                self.refit(effects)?;
                kept.push(vague);
                continue;
            }
            gone.push(self.all[vague].effect.id.clone());
            *effects = others;
        }
    }

    /// Removes effects with which the error does not fall enough, one at a time, the worst first. An effect goes if the error on
    /// unseen data is larger with it; if it moves neither error ([`Self::is_immaterial`]); or if the intervals of its amounts
    /// include 0 and the error on the logs of the fit is larger with it. All go if the error on unseen data is larger with all of
    /// them together (they may cancel each other), or, where they may be errors of form, not much smaller.
    fn refuse(&mut self, effects: &mut Vec<usize>) -> anyhow::Result<Vec<Refused>> {
        let mut refused = Vec::new();
        if effects.is_empty() {
            return Ok(refused);
        }
        let (none, all) = (self.levels(&[])?, self.levels(effects)?);
        let factor = match self.may_be_form {
            true => FORETELLS.recip(),
            false => RISES,
        };
        if all.test > factor * none.test {
            let gone = std::mem::take(effects).into_iter();
            let gone = gone.map(|k| self.all[k].effect.id.clone()).collect();
            return Ok(vec![Refused {
                ids: gone,
                errors: [none.test, all.test],
                of_fit: false,
            }]);
        }
        loop {
            let with = self.levels(effects)?;
            let mut worst: Option<(usize, Refused)> = None;
            for &k in effects.iter() {
                let (less, factor) = self.error_without(effects, k)?;
                let of_unseen =
                    with.test > factor * less.test || self.is_immaterial(k, &with, &less);
                let of_fit = !of_unseen;
                let errors = match of_fit {
                    true => [less.train, with.train],
                    false => [less.test, with.test],
                };
                // Effects that unseen data refute go first.
                let is_worse = |worst: &(usize, Refused)| {
                    let worst = &worst.1;
                    (!of_fit && worst.of_fit)
                        || (of_fit == worst.of_fit && errors[0] < worst.errors[0])
                };
                // A fit by likelihood may raise the error on the logs of the fit, but not by effects that may be 0. Up to a tenth
                // is allowed if the error on unseen data is a tenth smaller with the effect.
                let is_nothing = || self.all[k].amounts_may_be_0(self.model);
                let allowed = match less.test > FORETELLS * with.test {
                    true => FORETELLS,
                    false => RISES,
                };
                let rises = of_unseen || (with.train > allowed * less.train && is_nothing());
                if rises && worst.as_ref().is_none_or(is_worse) {
                    let ids = vec![self.all[k].effect.id.clone()];
                    let refused = Refused {
                        ids,
                        errors,
                        of_fit,
                    };
                    worst = Some((k, refused));
                }
            }
            let Some((k, worst)) = worst else {
                return Ok(refused);
            };
            refused.push(worst);
            *effects = without(effects, k);
            self.refit(effects)?;
        }
    }

    /// Whether an effect reduces neither error by more than noise would, where structure is left: any further parameter explains
    /// a little of that. Not so for what brakes a free swing, which takes little that nothing else takes, nor for late effects,
    /// which have limits of their own at the end of their range.
    fn is_immaterial(&self, k: usize, with: &Error, without: &Error) -> bool {
        let swings = self.model.sensor.wrench == WrenchMeaning::Free;
        let effect = LoadEffect::find(self.model, &self.all[k].effect.id);
        let hardly = |with: f64, without: f64| RISES * with > without;
        let on_both = hardly(with.test, without.test) && hardly(with.train, without.train);
        self.leaves_structure && !swings && !effect.is_some_and(LoadEffect::is_late) && on_both
    }

    /// Errors with the other effects alone, and the factor by which the error on unseen data has to be larger with effect `k` for
    /// it to be refused. If parameters are not fitted anew, the others stay as they are and the factor is [`RISES`]. Otherwise
    /// the others are refitted, and any rise counts, unless the logs of the fit are explained much worse without the effect: then
    /// the factor is again [`RISES`].
    fn error_without(&mut self, effects: &[usize], k: usize) -> anyhow::Result<(Error, f64)> {
        let others = without(effects, k);
        if !(self.is_refitted() && self.can_foretell) {
            return Ok((self.levels(&others)?, RISES));
        }
        let with = self.levels(effects)?.train;
        let kept = (self.all.clone(), self.refitted);
        self.refit(&others)?;
        let less = self.levels(&others)?;
        (self.all, self.refitted) = kept;
        self.predictions.clear();
        let much_worse = less.train > FORETELLS * with;
        Ok((less, if much_worse { RISES } else { 1.0 }))
    }

    /// The predictions with these effects.
    fn into_predictions(mut self, effects: &[usize]) -> anyhow::Result<Logs<Prediction>> {
        let key = sorted(effects);
        match self.predictions.remove(&key) {
            Some(both) => Ok(both),
            None => self.predicted(&key),
        }
    }

    pub(super) fn predicted(&self, effects: &[usize]) -> anyhow::Result<Logs<Prediction>> {
        let model = with_effects(self.model, effects.iter().map(|k| &self.all[*k]));
        predict_all(&model, self.recordings)
    }
}

pub(super) fn without(effects: &[usize], one: usize) -> Vec<usize> {
    let others = effects.iter().copied();
    others.filter(|other| *other != one).collect()
}

fn sorted(effects: &[usize]) -> Vec<usize> {
    let mut key = effects.to_vec();
    key.sort_unstable();
    key
}

/// Reorders actuator stages whose shares are of the same size into the order of the signal chain.
fn in_signal_order(named: &mut [(usize, f64)], all: &[NamedEffect]) {
    /// Shares within this factor are of the same size.
    const SAME_SIZE: f64 = 3.0;
    let place = |k: usize| Stage::ALL.iter().position(|s| s.id() == all[k].effect.id);
    for k in 1..named.len() {
        let (first, second) = (&named[k - 1], &named[k]);
        let alike = first.1 < SAME_SIZE * second.1;
        if let (Some(a), Some(b)) = (place(first.0), place(second.0))
            && alike
            && b < a
        {
            named.swap(k - 1, k);
        }
    }
}
