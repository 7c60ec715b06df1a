//! The search for effects on the reading over all logs together.
//!
//! The best effects alone and in pairs are refined; from the best of them the search goes on by
//! adding, exchanging and removing one effect at a time as long as the evidence rises. What is left
//! at the end is worth its price beside all others.

mod each_log;
mod foretold;
mod in_place;
mod in_time;
pub(crate) mod model_selection;
pub(crate) mod other_sign;
mod own_constant;
mod own_effect;

use super::regression::fit::{fitted_to, tested};
use super::regression::fitted::Fitted;
use super::regression::hypothesis::{ALIKE, Hypothesis, Part, evaluate, ids, pairs, with_one_more};
use super::regression::joint::Joint;
use super::regression::problem::Problem;
use super::regression::shaped::Care;
use super::regression::tested::TestedHypothesis;
use super::regression::variants::{Library, Variant};
use crate::diagnose::evidence::{self, NAMED, Support, threshold};
use crate::diagnose::watch::Watch;
use model_selection::{Rival, parts_of, widen, with_forms_reselected};
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Mutex, PoisonError};

/// Pieces into which the logs are cut, to leave out each in turn.
const PIECES: usize = 6;
/// Most effects on one channel.
const MOST: usize = 5;
/// Hypotheses that are refined at the start: so many of one effect, and so many pairs.
const TRIED: usize = 12;
/// Hypotheses that are refined at each further step.
const TRIED_LATER: usize = 3;
/// Starts of a climb, each with other effects.
const STARTS: usize = 2;
/// Steps after which a climb is ended. To add [`MOST`] effects and to exchange each once takes half of
/// them; of 43 logs with up to three effects none takes more than 4.
const STEPS: usize = 4 * MOST;
/// Gain in χ² below which a hypothesis is not looked at again.
const NEGLIGIBLE_GAIN: f64 = 15.0;

/// Result of the search on the reading.
#[derive(Default)]
pub(crate) struct SearchResult {
    /// The accepted hypothesis, if any. Its parameters are those of the logs of the fit.
    pub accepted: Option<TestedHypothesis>,
    /// What speaks for each accepted effect.
    pub support: Vec<Support>,
    /// All hypotheses that were tried, best first.
    pub ranked: Vec<TestedHypothesis>,
    /// Rivals of the same kind as one of several accepted effects, in its place.
    pub rivals: Vec<Rival>,
    /// Number of steps after which the search was ended although the evidence was still rising.
    pub ended_after: Option<usize>,
    /// Effects about which the logs disagree.
    pub disagreeing: Vec<Disagreement>,
    /// Ids of the effects that were accepted before late effects were tried beside them; empty if no late effect was added.
    pub before_late: Vec<String>,
    /// Ids of late effects that were removed, as a general curve does as well in their place.
    pub curve_in_place_of: Vec<String>,
}

/// An effect about which the logs disagree.
#[derive(Clone, Debug)]
pub(crate) struct Disagreement {
    /// Its id.
    pub id: &'static str,
    /// Its coefficients.
    pub amounts: Vec<AmountByLog>,
}

/// A coefficient that was fitted to each log alone.
#[derive(Clone, Debug)]
pub(crate) struct AmountByLog {
    /// Its name.
    pub name: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// One value per log.
    pub values: Vec<f64>,
}

/// The options of a search.
pub(crate) struct Ask<'a> {
    /// Effects that are in the model already, or not to be tried.
    pub excluded: &'a dyn Fn(&str) -> bool,
    /// The best hypothesis is taken although it is not significant.
    pub forced: bool,
    /// Also ask whether the logs disagree.
    pub each_log: bool,
    /// Receives each hypothesis when it is tried.
    pub watch: Watch<'a>,
}

impl SearchResult {
    /// The result of a search that was repeated after one in which logs disagreed. If it finds nothing, the disagreement stands,
    /// as nothing accounts for it.
    fn keeping_disagreements(self, disagreeing: Vec<Disagreement>) -> Self {
        match self.accepted.is_none() && self.disagreeing.is_empty() {
            true => Self {
                disagreeing,
                ..self
            },
            false => self,
        }
    }
}

/// What a search works with.
struct SearchState<'a> {
    joint: &'a Joint,
    library: &'a Library,
    /// The regression of the logs of the fit.
    of_fit: &'a Problem,
    price: f64,
    /// Details of other effects may stand alone.
    details_stand_alone: bool,
    watch: Watch<'a>,
    /// Hypotheses that were tested, by parts, as several paths lead to the same one.
    known: Mutex<BTreeMap<Vec<Part>, TestedHypothesis>>,
    /// Places of variants that foretell the unseen logs worse than nothing in their place does.
    misled: Mutex<BTreeSet<usize>>,
    /// Effects that physics forbids together when their parameters are estimated.
    forbidden: Mutex<BTreeSet<Vec<&'static str>>>,
}

/// Searches for effects. If the answer needs nominal parameters too far off, these are held at their values and the search is
/// repeated. Beside the answer late effects, and effects that too coarse grids of shapes may have hidden, are then asked once
/// more.
pub(crate) fn search(joint: &mut Joint, ask: &Ask<'_>) -> SearchResult {
    /// Repetitions, as further parameters may turn out to be too far off when others are held.
    const ROUNDS: usize = 3;
    let mut library = Library::new(joint, ask.excluded);
    let mut found = search_from_best(joint, &library, ask);
    for _ in 0..ROUNDS {
        if !joint.hold_strained(found.accepted.as_ref()) {
            break;
        }
        library = library.anew(joint);
        found = search_from_best(joint, &library, ask).keeping_disagreements(found.disagreeing);
    }
    match found.accepted.clone() {
        Some(accepted) => beside_found(joint, library, &accepted, found, ask),
        None => found,
    }
}

/// Continues the search beside an answer: from the answer itself, and from its sharpest form with a late effect. Returns the best
/// end.
fn beside_found(
    joint: &Joint,
    library: Library,
    accepted: &TestedHypothesis,
    found: SearchResult,
    ask: &Ask<'_>,
) -> SearchResult {
    let price = evidence::price(joint.problem.count);
    let tried = evaluate(&library, parts_of(&library, accepted), price);
    // The tried shapes lose so much against the refined ones that this could hide or feign another effect.
    let are_apart = tried.is_none_or(|tried| accepted.gain > tried.solution.gain + NAMED);
    let Some(library) = library.around(joint, accepted, are_apart) else {
        return found;
    };
    // If the logs disagree only once further effects are there, that is an error of the form of these.
    let ask = &Ask {
        each_log: ask.each_log && !found.disagreeing.is_empty(),
        ..*ask
    };
    let of_fit = joint.of_fit();
    let state = SearchState::new(joint, &library, &of_fit, ask);
    let accepted = state.retested(accepted);
    let end = state.climbed_from(&accepted);
    let late = state.late_beside_sharp_forms(&accepted);
    if let Some(late) = late.filter(|late| late.evidence > end.0.evidence)
        && let Some(library) = Library::new(joint, ask.excluded).around(joint, &late, true)
    {
        let state = SearchState::new(joint, &library, &of_fit, ask);
        let of_late = state.climbed_from(&state.retested(&late));
        if of_late.0.evidence > end.0.evidence {
            return state.with_later_end(of_late, &accepted, found, ask);
        }
    }
    state.with_later_end(end, &accepted, found, ask)
}

/// A hypothesis, those without one of its effects, and the best with another effect in the place of one, all under one noise
/// model.
pub(crate) fn exchanged(
    joint: &Joint,
    of: &TestedHypothesis,
    ask: &Ask<'_>,
) -> Vec<TestedHypothesis> {
    let plain = || Library::new(joint, ask.excluded);
    // Without the loads of the hypothesis a delay in the place of a lag would have nothing to move.
    let around = plain().around(joint, of, true);
    let library = around.unwrap_or_else(plain);
    let of_fit = joint.of_fit();
    let state = SearchState::new(joint, &library, &of_fit, ask);
    let parts = state.parts(of);
    // Without one of its effects it is another hypothesis.
    if parts.len() < of.effects.len() {
        return Vec::new();
    }
    let itself = evaluate(&library, parts, state.price);
    state.tested(&itself.into_iter().collect::<Vec<_>>(), 1);
    let mut all = state.exchanges(of, TRIED);
    let fewer = state.fewer(of);
    all.extend(state.tested(&fewer, fewer.len()));
    all.extend(state.in_twos(of));
    all
}

/// Searches from the best single effects and pairs.
fn search_from_best(joint: &Joint, library: &Library, ask: &Ask<'_>) -> SearchResult {
    let of_fit = joint.of_fit();
    let state = SearchState::new(joint, library, &of_fit, ask);
    let ranked = state.singles_and_pairs();
    let possible = ranked.iter().filter(|t| state.is_possible(t));
    // Two starts with the same effects would climb to the same end.
    let mut seen = BTreeSet::new();
    let starts = possible.filter(|t| seen.insert(t.effects_in_order()));
    let starts: Vec<&TestedHypothesis> = starts.take(STARTS).collect();
    let ends = starts.into_par_iter();
    let ends: Vec<(TestedHypothesis, bool)> =
        ends.map(|start| state.climbed(start.clone())).collect();
    state.concluded(ends, ranked, ask)
}

impl<'a> SearchState<'a> {
    fn new(joint: &'a Joint, library: &'a Library, of_fit: &'a Problem, ask: &Ask<'a>) -> Self {
        let is_detail = |variant: &Variant| variant.effect.effect.is_detail();
        Self {
            price: evidence::price(joint.problem.count),
            // If only details are asked for, the model has the effects that they are details of.
            details_stand_alone: ask.forced || library.variants.iter().all(is_detail),
            library,
            joint,
            of_fit,
            watch: ask.watch,
            known: Mutex::default(),
            misled: Mutex::default(),
            forbidden: Mutex::default(),
        }
    }
}

impl SearchState<'_> {
    /// The end of a climb from an answer, small effects included, and whether the climb came to its end.
    fn climbed_from(&self, start: &TestedHypothesis) -> (TestedHypothesis, bool) {
        let (end, came_to_end) = self.climbed(start.clone());
        (self.with_small(end), came_to_end)
    }

    /// The result with the end of a further climb in it, if that has more evidence than before.
    fn with_later_end(
        &self,
        end: (TestedHypothesis, bool),
        before: &TestedHypothesis,
        found: SearchResult,
        ask: &Ask<'_>,
    ) -> SearchResult {
        if end.0.evidence <= before.evidence {
            return found;
        }
        let is_later = self.is_late(&end.0) && !self.is_late(before);
        let concluded = self.concluded(vec![end], found.ranked, ask);
        SearchResult {
            before_late: if is_later { before.ids() } else { Vec::new() },
            ..concluded.keeping_disagreements(found.disagreeing)
        }
    }

    /// Decides what is accepted of the ends of the climbs, and collects its support, rivals and disagreements.
    fn concluded(
        &self,
        ends: Vec<(TestedHypothesis, bool)>,
        mut ranked: Vec<TestedHypothesis>,
        ask: &Ask<'_>,
    ) -> SearchResult {
        let best = ends.iter().map(|end| end.0.clone());
        let best = best.max_by(|a, b| a.evidence.total_cmp(&b.evidence));
        let settled = best.clone().map(|best| self.settled(best));
        let came_to_end =
            settled.as_ref().is_none_or(|settled| settled.1) && ends.iter().all(|end| end.1);
        let ended_after = (!came_to_end).then_some(STEPS);
        let mut accepted = settled.and_then(|settled| settled.0);
        accepted = accepted.map(|accepted| self.undominated(accepted, &ranked));
        if ask.forced && accepted.is_none() {
            accepted = ranked.iter().find(|t| t.wrong.is_empty()).cloned();
        }
        if let Some(accepted) = &accepted {
            ranked.extend(self.alike(accepted));
            // If the search ends with fewer effects than it once had, single effects and smaller sets may not have been among its
            // starts.
            let fewer = self.fewer(accepted);
            ranked.extend(self.tested(&fewer, fewer.len()));
            ranked.push(accepted.clone());
            ranked.sort_by(|a, b| b.evidence.total_cmp(&a.evidence));
        }
        let support = accepted.as_ref().map_or_else(Vec::new, |t| self.support(t));
        let rivals = accepted.as_ref().map_or_else(Vec::new, |t| self.rivals(t));
        ranked.extend(accepted.iter().flat_map(|t| self.in_twos(t)));
        let best = accepted.as_ref().or(best.as_ref());
        let constant = best.filter(|_| ask.each_log);
        let constant = constant.and_then(|best| self.own_constant(best));
        let own = constant.or_else(|| {
            let asked = ask.each_log.then_some(());
            asked.and_then(|()| self.own_effect(best))
        });
        let disagreeing = match own {
            Some(own) => vec![own],
            None if ask.each_log => self.disagreeing(accepted.as_ref()),
            None => Vec::new(),
        };
        SearchResult {
            accepted: accepted.map(|all| self.of_fit(all)),
            support,
            ranked,
            rivals,
            ended_after,
            disagreeing,
            before_late: Vec::new(),
            curve_in_place_of: Vec::new(),
        }
    }

    fn tested(&self, hypotheses: &[Hypothesis], most: usize) -> Vec<TestedHypothesis> {
        let misled = self.misled().clone();
        let leads = |h: &&Hypothesis| !h.parts.iter().any(|part| misled.contains(&part.variant));
        let hypotheses: Vec<Hypothesis> = hypotheses.iter().filter(leads).cloned().collect();
        distinct(self.library, &hypotheses, most)
            .par_iter()
            .map(|h| self.test(h))
            .collect()
    }

    /// Effects alone and in pairs, best first.
    fn singles_and_pairs(&self) -> Vec<TestedHypothesis> {
        let singles = self.without_stray_details(with_one_more(self.library, &[], self.price));
        let doubles = self.without_stray_details(pairs(self.library, self.price));
        let mut ranked = self.tested(&singles, TRIED);
        ranked.extend(self.tested(&doubles, TRIED));
        ranked.sort_by(|a, b| b.evidence.total_cmp(&a.evidence));
        ranked
    }

    /// A hypothesis of another search, tested with this library.
    fn retested(&self, found: &TestedHypothesis) -> TestedHypothesis {
        let same = evaluate(self.library, self.parts(found), self.price);
        same.map_or_else(|| found.clone(), |same| self.test(&same))
    }

    fn test(&self, hypothesis: &Hypothesis) -> TestedHypothesis {
        let known = || self.known.lock().unwrap_or_else(PoisonError::into_inner);
        let found = known().get(&hypothesis.parts).cloned();
        found.unwrap_or_else(|| {
            let new = tested(self.library, hypothesis, self.joint);
            self.watch.tell(|| new.trial());
            known().insert(hypothesis.parts.clone(), new.clone());
            new
        })
    }

    /// Drops hypotheses with details, unless these may stand alone.
    fn without_stray_details(&self, all: Vec<Hypothesis>) -> Vec<Hypothesis> {
        let is_detail = |part: &Part| {
            self.library.variants[part.variant]
                .effect
                .effect
                .is_detail()
        };
        let whole = |h: &Hypothesis| self.details_stand_alone || !h.parts.iter().any(is_detail);
        all.into_iter().filter(whole).collect()
    }

    /// Whether physics allows it, and it goes beyond the rounding of the readings.
    fn is_possible(&self, tested: &TestedHypothesis) -> bool {
        let price =
            self.price * tested.parameters as f64 + evidence::prior() * tested.effects.len() as f64;
        let is_allowed = || !self.forbidden().contains(&tested.effects_in_order());
        tested.wrong.is_empty()
            && is_allowed()
            && tested.beyond_rounding > self.joint.threshold(0.0) + price
    }

    /// Whether one of its effects moves the reading in time.
    fn is_late(&self, tested: &TestedHypothesis) -> bool {
        let mut parts = self.parts(tested).into_iter();
        parts.any(|part| self.library.variants[part.variant].effect.is_late())
    }

    fn parts(&self, tested: &TestedHypothesis) -> Vec<Part> {
        parts_of(self.library, tested)
    }

    /// Adds one effect at a time as long as the evidence rises; where it does not, exchanges or removes one. The flag says
    /// whether the climb came to its end within [`STEPS`].
    fn climbed(&self, start: TestedHypothesis) -> (TestedHypothesis, bool) {
        let mut now = start;
        for _ in 0..STEPS {
            let more = if now.effects.len() < MOST {
                with_one_more(self.library, &self.parts(&now), self.price)
            } else {
                Vec::new()
            };
            let next = self.best_of(&now, more).or_else(|| {
                let (exchanged, fewer) = (self.exchanged(&now), self.fewer(&now));
                self.best_of(&now, exchanged.into_iter().chain(fewer).collect())
            });
            match next {
                Some(next) => now = next,
                None => return (now, true),
            }
        }
        (now, false)
    }

    /// The best of some hypotheses, if it has more evidence than the present one. An added effect also has to exceed errors of
    /// form.
    fn best_of(
        &self,
        now: &TestedHypothesis,
        mut all: Vec<Hypothesis>,
    ) -> Option<TestedHypothesis> {
        all.sort_by(|a, b| b.evidence.total_cmp(&a.evidence));
        let known = now.effects_in_order();
        let better = |t: &TestedHypothesis| {
            let mut new = t.effects_in_order().into_iter();
            let new = new.find(|id| !known.contains(id));
            let form = match new.filter(|_| t.effects.len() > now.effects.len()) {
                Some(new) => self.joint.threshold_of(new, now.gain) - threshold(0.0),
                None => 0.0,
            };
            t.evidence > now.evidence + form + 1e-6
        };
        let all = self.tested(&all, TRIED_LATER).into_iter();
        let best = all
            .filter(|t| self.is_possible(t) && better(t))
            .max_by(|a, b| a.evidence.total_cmp(&b.evidence))?;
        let again = with_forms_reselected(self.library, self.parts(&best), self.price);
        let again = again.map(|h| self.test(&h));
        let again = again.filter(|t| self.is_possible(t) && t.evidence > best.evidence);
        Some(again.unwrap_or(best))
    }

    /// All hypotheses with one effect exchanged for another.
    fn exchanged(&self, now: &TestedHypothesis) -> Vec<Hypothesis> {
        let parts = self.parts(now);
        let without = |place| with_one_more(self.library, &without(&parts, place), self.price);
        (0..parts.len()).flat_map(without).collect()
    }

    /// All hypotheses with one effect less; none if there is only one.
    fn fewer(&self, now: &TestedHypothesis) -> Vec<Hypothesis> {
        let parts = self.parts(now);
        if parts.len() < 2 {
            return Vec::new();
        }
        let without =
            |place| with_forms_reselected(self.library, without(&parts, place), self.price);
        (0..parts.len()).filter_map(without).collect()
    }

    /// Evidence for each effect: that of the whole less that without the effect, the forms of the others chosen again.
    fn evidence_of_each(&self, now: &TestedHypothesis) -> Vec<f64> {
        let of = |place: usize| match now.effects.len() {
            1 => now.evidence,
            _ => {
                let rest = without(&self.parts(now), place);
                let rest = with_forms_reselected(self.library, rest, self.price);
                let rest = rest.map(|h| self.test(&h));
                now.evidence - rest.map_or(0.0, |t| t.evidence.max(0.0))
            }
        };
        (0..now.effects.len()).into_par_iter().map(of).collect()
    }

    /// Support of each effect: its evidence beside the others, and that against the best tested hypothesis without it.
    fn support(&self, now: &TestedHypothesis) -> Vec<Support> {
        let beside = self.evidence_of_each(now);
        let known = self.known.lock().unwrap_or_else(PoisonError::into_inner);
        let misled = self.misled();
        let leads = |(parts, _): &(&Vec<Part>, &TestedHypothesis)| {
            !parts.iter().any(|p| misled.contains(&p.variant))
        };
        let possible = known.iter().filter(leads).map(|(_, tested)| tested);
        let possible: Vec<&TestedHypothesis> = possible.filter(|t| self.is_possible(t)).collect();
        let of = |(beside, own): (f64, &Fitted)| {
            let lacks_it = |t: &&&TestedHypothesis| t.effects.iter().all(|e| e.id != own.id);
            let rivals = possible.iter().filter(lacks_it).map(|t| t.evidence);
            let best = rivals.fold(0.0, f64::max);
            Support::without_rival(beside).with_rival(now.evidence - best)
        };
        beside.into_iter().zip(&now.effects).map(of).collect()
    }

    /// The same effects with the parameters of the logs of the fit alone. If these leave some undetermined, or give one that
    /// physics forbids, the parameters are those of all logs, and the reason is kept.
    fn of_fit(&self, all: TestedHypothesis) -> TestedHypothesis {
        let held_back = self.joint.fitted < self.joint.logs.len();
        let Some(hypothesis) = evaluate(self.library, self.parts(&all), self.price) else {
            return TestedHypothesis {
                of_all_logs: held_back.then(|| "they could not be fitted anew".to_owned()),
                ..all
            };
        };
        let mut fitted = self.estimated(self.of_fit, &hypothesis);
        let why = match fitted.wrong.first() {
            Some(wrong) => Some(format!("fitted to the logs of the fit alone: {wrong}")),
            None if is_determined(&fitted) => None,
            None => Some("the logs of the fit alone do not determine them".to_owned()),
        };
        let mut estimated = match &why {
            Some(_) => self.estimated(&self.joint.problem, &hypothesis).effects,
            None => std::mem::take(&mut fitted.effects),
        };
        if self.joint.has_much_left(all.gain) {
            let logs = match &why {
                Some(_) => self.joint.logs.len(),
                None => self.joint.fitted,
            };
            widen(&mut estimated, &self.without_each_piece(&hypothesis, logs));
        }
        TestedHypothesis {
            effects: estimated,
            of_all_logs: why.filter(|_| held_back),
            ..all
        }
    }

    /// A hypothesis fitted to some rows with the effort of an estimate, so that its standard deviations are joint ones.
    fn estimated(&self, problem: &Problem, hypothesis: &Hypothesis) -> TestedHypothesis {
        let (library, joint) = (self.library, self.joint);
        fitted_to(problem, library, hypothesis, joint, Care::Estimating)
    }

    /// A hypothesis fitted to the first `logs` without each of their pieces in turn.
    fn without_each_piece(&self, hypothesis: &Hypothesis, logs: usize) -> Vec<TestedHypothesis> {
        let of = |piece: usize| {
            let problem = self.joint.without(piece, PIECES, logs);
            let (library, joint) = (self.library, self.joint);
            fitted_to(&problem, library, hypothesis, joint, Care::Screening)
        };
        (0..PIECES).into_par_iter().map(of).collect()
    }
}

fn without(parts: &[Part], place: usize) -> Vec<Part> {
    let mut rest = parts.to_vec();
    rest.remove(place);
    rest
}

/// Whether all parameters of a fit and their standard deviations are finite.
fn is_determined(fitted: &TestedHypothesis) -> bool {
    let mut parameters = fitted.effects.iter().flat_map(|e| e.parameters.values());
    parameters.all(|p| p.value.is_finite() && p.sigma.is_finite())
}

/// The best hypotheses, at most `most`, and at most [`ALIKE`] of the same effects.
fn distinct(library: &Library, hypotheses: &[Hypothesis], most: usize) -> Vec<Hypothesis> {
    let mut kept: Vec<(Vec<&str>, Hypothesis)> = Vec::new();
    let worth = hypotheses
        .iter()
        .filter(|h| h.solution.gain >= NEGLIGIBLE_GAIN);
    for hypothesis in worth {
        let ids = ids(library, hypothesis);
        if kept.iter().filter(|k| k.0 == ids).count() < ALIKE {
            kept.push((ids, hypothesis.clone()));
        }
        if kept.len() >= most {
            break;
        }
    }
    kept.into_iter().map(|k| k.1).collect()
}
