//! The rounds of the search on the reading: beside what was found already, without effects that are unsure, late or a drift, and
//! beside a smooth remainder.

use super::beside::{self, Asking};
use super::finding::WrenchFinding;
use super::regression::tested::TestedHypothesis;
use crate::diagnose::catalogue::is_general_curve;
use crate::diagnose::evidence::FORETELLS;
use crate::diagnose::named::model_of;
use crate::diagnose::question::Question;
use softdock_physics::model::load::effects::LoadEffect;
use softdock_physics::model::{EffectModel, Model};
use std::collections::BTreeMap;

/// Most rounds of the search on the reading.
const ROUNDS: usize = 3;

/// What the logs say of the reading, where the model has effects that `add` fitted. An effect that is fitted and then held leaves
/// other residuals than one that is fitted together with the rest, so that the same question could get another answer after
/// `add`. If the finding is new or the logs disagree, the search is therefore repeated on the model without the added effects. If
/// that search finds all the added ones, only what it finds as well may be new.
pub(crate) fn wrench_rounds(asking: &mut Asking<'_>) -> Option<WrenchFinding> {
    let finding = rounds(asking)?;
    let (model, new) = (asking.model, finding.ids());
    let was_added = |effect: &EffectModel| {
        let load = LoadEffect::find(model, &effect.id);
        effect.was_fitted()
            && load.is_some_and(|load| !load.is_late() || model.sensor.wrench.drives())
    };
    let (added, other): (Vec<EffectModel>, Vec<EffectModel>) =
        model.effects.iter().cloned().partition(was_added);
    let agrees = |finding: &WrenchFinding| finding.found.disagreeing.is_empty();
    let says_nothing = new.is_empty() && agrees(&finding);
    if asking.question.is_asked() || says_nothing || added.is_empty() {
        return Some(finding);
    }
    let fresh = rounds(&mut Asking {
        model: &Model {
            effects: other,
            ..model.clone()
        },
        question: asking.question,
        search: &mut *asking.search,
    })?;
    let mut all = fresh.significant_ids();
    let finds = |id: &String| all.contains(id);
    let finds_the_same = new.iter().all(finds) && agrees(&finding);
    let finds_added = added.iter().all(|effect| finds(&effect.id)) && agrees(&fresh);
    if finds_the_same || !finds_added {
        return Some(finding);
    }
    all.retain(|id| added.iter().all(|effect| effect.id != *id));
    rounds(&mut Asking {
        model,
        question: &Question {
            among: Some(&all),
            ..*asking.question
        },
        search: &mut *asking.search,
    })
}

/// The answer of [`rounds_of`]; where the search was free to choose, also compared with the answers without late effects and
/// without drifts.
fn rounds(asking: &mut Asking<'_>) -> Option<WrenchFinding> {
    let mut finding = rounds_of(asking)?;
    let is_whole = asking.question.only.is_none() && asking.question.among.is_none();
    if is_whole && finding.found.disagreeing.is_empty() {
        finding = without_late(finding, asking)?;
        finding = without_drift(finding, asking)?;
        beside_rivals(&mut finding, asking);
    }
    Some(finding)
}

/// Tries others in the place of each effect of the answer once more, where structure is left. Rivals were tried while effects
/// were accepted that the answer has lost since, so what they explain is not comparable with the final answer.
fn beside_rivals(finding: &mut WrenchFinding, asking: &mut Asking<'_>) {
    let beside = finding.beside.clone();
    let asks = beside.is_some() || finding.remaining_structure().is_structured();
    let Some(answer) = finding.found.accepted.clone().filter(|_| asks) else {
        return;
    };
    if answer.effects.len() < 2 || !finding.earlier.0.is_empty() {
        return;
    }
    let question = Question {
        in_place_of: Some(&answer),
        beside: beside.as_ref(),
        ..*asking.question
    };
    let tried = asking.ask(&question).map(|others| others.found.ranked);
    let tried = tried.unwrap_or_default();
    let Some(now) = tried.iter().find(|t| t.is_same(&answer)) else {
        return;
    };
    // χ² is comparable only beside the same noise: hypotheses of the same size that were tried beside another noise go, and so do
    // earlier entries of what was tried anew.
    let (to_explain, count) = (now.to_explain, answer.effects.len());
    let ranked = &mut finding.found.ranked;
    ranked.retain(|other| !tried.iter().any(|anew| anew.is_same(other)));
    ranked.retain(|other| {
        let is_curve = other.effects.iter().any(|e| is_general_curve(e.id));
        other.effects.len() != count || is_curve || other.is_beside_noise_of(to_explain)
    });
    ranked.extend(tried);
    ranked.sort_by(|a, b| b.evidence.total_cmp(&a.evidence));
}

/// Repeats the search without late effects if the answer has such, has no dry friction and leaves structure; returns the better
/// answer. A delay of all that loads the sensor looks like a dry friction, and takes its place.
fn without_late(finding: WrenchFinding, asking: &mut Asking<'_>) -> Option<WrenchFinding> {
    let (late, axes) = (finding.late_ids(), finding.structured_axes());
    if late.is_empty() || axes.is_empty() || finding.has_dry_friction(asking.model) {
        return Some(finding);
    }
    let in_time = rounds_without(&late, asking);
    let nothing = asking.among(&[])?.prepared;
    match in_time {
        Some(in_time) => Some(beside::better(finding, in_time, &nothing, &axes)),
        None => Some(finding),
    }
}

/// Where structure is left and the answer has effects that depend on time alone: the answer without these, unless they foretell
/// unseen data much better ([`FORETELLS`]). A slow curve in time fits what many laws leave of one log.
fn without_drift(finding: WrenchFinding, asking: &mut Asking<'_>) -> Option<WrenchFinding> {
    let drifts = finding.drift_ids();
    if drifts.is_empty() || !finding.can_foretell() || finding.structured_axes().is_empty() {
        return Some(finding);
    }
    let Some(other) = rounds_without(&drifts, asking) else {
        return Some(finding);
    };
    let nothing = asking.among(&[])?.prepared;
    let [error, of_other] =
        [&finding, &other].map(|f| nothing.error_on_unseen(&f.whole_hypothesis()));
    match of_other > FORETELLS * error {
        true => Some(finding),
        false => Some(other),
    }
}

fn rounds_without(ids: &[String], asking: &mut Asking<'_>) -> Option<WrenchFinding> {
    let without = asking.question.also_without(ids);
    rounds_of(&mut Asking {
        question: &Question {
            without: &without,
            ..*asking.question
        },
        model: asking.model,
        search: &mut *asking.search,
    })
}

/// One complete answer: rounds of search as long as they find something, without effects whose rivals do as well, and compared
/// with a smooth remainder where structure is left.
fn rounds_of(asking: &mut Asking<'_>) -> Option<WrenchFinding> {
    let (mut finding, leaves_structure) = beside_earlier(asking)?;
    // What logs that disagree have in common is no answer that could be bettered.
    if !finding.found.disagreeing.is_empty() {
        if !beside::agree_on_a_curve(&finding, asking) {
            return Some(finding);
        }
        finding.found.disagreeing.clear();
    }
    let is_open = !asking.question.is_asked();
    let asks_beside = is_open && leaves_structure;
    let anew = asks_beside
        .then(|| beside::anew(&finding, asking))
        .flatten();
    if is_open {
        finding = without_unsure(finding, asking);
    }
    // What a later round finds may only fit the structure that the first one has left, and be no better than a smooth remainder.
    if asks_beside {
        finding = beside::beside_remainder(finding, asking);
    }
    finding = beside::beside_curves(finding, asking);
    if let Some(anew) = anew {
        let other = beside::beside_remainder(anew.finding, asking);
        let other = beside::beside_curves(other, asking);
        finding = beside::better(finding, other, &anew.nothing, &anew.axes);
    }
    if asks_beside {
        finding = beside::simpler(finding, asking);
    }
    Some(finding)
}

/// Searches again beside what was found, as long as much is left: a delay or a gain acts on the whole reading, including the
/// effects that were found first. The flag says whether any of these searches left structure.
fn beside_earlier(asking: &mut Asking<'_>) -> Option<(WrenchFinding, bool)> {
    let question = asking.question;
    let mut finding = asking.ask(question)?;
    let mut known = asking.model.clone();
    let mut leaves_structure = finding.remaining_structure().is_structured();
    for _ in 1..ROUNDS {
        let Some(accepted) = finding.found.accepted.as_ref() else {
            break;
        };
        let agree = finding.found.disagreeing.is_empty();
        let goes_on = question.only.is_none() && finding.prepared.has_much_left(accepted.gain);
        if !(goes_on && agree) {
            break;
        }
        let effects = accepted.effects.iter().map(model_of);
        known.effects.extend(effects);
        let worth = |more: &TestedHypothesis| more.gain > finding.prepared.threshold(accepted.gain);
        let found = |next: &WrenchFinding| next.found.accepted.as_ref().is_some_and(worth);
        let Some(mut next) = (asking.search)(&known, question).filter(found) else {
            break;
        };
        if let Some(last) = &mut next.found.accepted {
            last.of_all_logs = accepted.of_all_logs.clone().or(last.of_all_logs.take());
        }
        next.earlier = finding.earlier;
        next.earlier.0.extend(accepted.effects.iter().cloned());
        next.earlier.1.extend(finding.found.support);
        next.found.ranked.extend(finding.found.ranked);
        next.found.rivals.extend(finding.found.rivals);
        finding = next;
        leaves_structure |= finding.remaining_structure().is_structured();
    }
    Some((finding, leaves_structure))
}

/// Removes effects that are unsure, one at a time, if the answer without it is as good; an effect without which unseen data are
/// foretold much worse stays.
fn without_unsure(mut finding: WrenchFinding, asking: &mut Asking<'_>) -> WrenchFinding {
    let mut foretelling = BTreeMap::new();
    while let Some(gone) = finding.unsure(&foretelling) {
        let ids = finding.ids_without(std::slice::from_ref(&gone));
        let fewer = asking.among(&ids);
        let fewer = fewer.filter(|f| !f.ids().contains(&gone) && f.is_as_good_as(&finding));
        let Some(fewer) = fewer else {
            break;
        };
        match fewer.foretells_worse_by(finding.error_on_unseen()) {
            Some(worse) => {
                foretelling.insert(gone, worse);
            }
            None => finding = fewer,
        }
    }
    finding.foretell(&foretelling);
    finding
}
