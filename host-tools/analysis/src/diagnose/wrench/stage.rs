//! The search for effects on the reading over all logs together.
//!
//! The best effects alone and in pairs are refined; from the best of them the search goes on by
//! adding, exchanging and removing one effect at a time as long as the evidence rises. What is left
//! at the end is worth its price beside all others.

use super::fitted::Fitted;
use super::model_selection::{Rival, parts_of, rivals, widen, with_forms_reselected};
use super::prepared_log::{Joint, PreparedLog};
use super::problem::Problem;
use super::search::{Hypothesis, Part, evaluate, pairs, with_one_more};
use super::tested::{Care, Tested, fitted_to, tested};
use super::variants::{Library, Variant};
use crate::diagnose::engine::Watch;
use crate::diagnose::evidence::{self, Support, threshold};
use crate::diagnose::structure;
use rayon::prelude::*;
use softdock_physics::model::load::Column;
use softdock_physics::model::load::effects::Sign;
use std::collections::{BTreeSet, HashMap};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Pieces of a log that are left out in turn.
const PIECES: usize = 6;
/// Most effects on one channel.
const MOST: usize = 5;
/// Hypotheses that are refined, alone and in pairs.
const TRIED: usize = 12;
/// Hypotheses that are refined at each further step.
const TRIED_LATER: usize = 3;
/// Starts from which the search goes on.
const STARTS: usize = 2;
/// Steps after which a climb is ended. To add [`MOST`] effects and to exchange each once takes half of
/// them; of 43 logs with up to three effects none takes more than 4.
const STEPS: usize = 4 * MOST;
/// Gain in χ² below which a hypothesis is not looked at again.
const NEGLIGIBLE_GAIN: f64 = 15.0;

/// Result of the search on the reading.
pub(crate) struct Found {
    /// What is accepted, if anything: its parameters are those of the logs of the fit.
    pub accepted: Option<Tested>,
    /// What speaks for each accepted effect.
    pub support: Vec<Support>,
    /// All that were tried, best first.
    pub ranked: Vec<Tested>,
    /// Effects of the same kind in the place of one of several that are accepted.
    pub rivals: Vec<Rival>,
    /// Steps after which the search was ended, if the evidence rose still.
    pub ended_after: Option<usize>,
    /// Ids of effects about which the logs disagree.
    pub disagreeing: Vec<&'static str>,
}

/// What is asked of a search.
pub(crate) struct Ask<'a> {
    /// Effects that are in the model already, or not to be tried.
    pub excluded: &'a dyn Fn(&str) -> bool,
    /// The best hypothesis is taken although it is not significant.
    pub forced: bool,
    /// Whether the logs disagree is asked, too.
    pub each_log: bool,
    /// Who follows it.
    pub watch: Watch<'a>,
}

/// What a search works with.
struct Work<'a> {
    joint: &'a Joint,
    library: &'a Library,
    /// The regression of the logs of the fit.
    of_fit: &'a Problem,
    price: f64,
    /// Details of other effects may stand alone.
    any: bool,
    watch: Watch<'a>,
    /// What was tested: ways to a hypothesis meet.
    known: Mutex<HashMap<Vec<Part>, Tested>>,
    /// Variants that foretell the unseen logs worse than nothing in their place.
    misled: Mutex<BTreeSet<usize>>,
}

/// Searches. Tolerances that the answer strains are taken away, and the search begins anew.
pub(crate) fn search(joint: &mut Joint, ask: &Ask<'_>) -> Found {
    /// Tolerances that turn out to be strained when others were taken away.
    const ROUNDS: usize = 3;
    let mut library = Library::new(joint, ask.excluded);
    let mut found = searched(joint, &library, ask);
    for _ in 0..ROUNDS {
        if !joint.freeze_strained(found.accepted.as_ref()) {
            break;
        }
        library = library.anew(joint);
        found = searched(joint, &library, ask);
    }
    found
}

fn searched(joint: &Joint, library: &Library, ask: &Ask<'_>) -> Found {
    let is_detail = |variant: &Variant| variant.effect.effect.is_detail();
    let work = Work {
        price: evidence::price(joint.problem.count),
        // Who asks for a detail alone has in the model what it is a detail of.
        any: ask.forced || library.variants.iter().all(is_detail),
        library,
        joint,
        of_fit: &joint.of_fit(),
        watch: ask.watch,
        known: Mutex::default(),
        misled: Mutex::default(),
    };
    let singles = work.tested(
        &work.whole(with_one_more(work.library, &[], work.price)),
        TRIED,
    );
    let doubles = work.tested(&work.whole(pairs(work.library, work.price)), TRIED);
    let mut ranked = singles;
    ranked.extend(doubles);
    ranked.sort_by(|a, b| b.evidence.total_cmp(&a.evidence));
    let starts = ranked.iter().filter(|t| work.is_possible(t)).take(STARTS);
    let starts: Vec<&Tested> = starts.collect();
    let ends = starts.into_par_iter();
    let ends: Vec<(Tested, bool)> = ends.map(|start| work.climbed(start.clone())).collect();
    let best = ends.iter().map(|end| end.0.clone());
    let best = best.max_by(|a, b| a.evidence.total_cmp(&b.evidence));
    let settled = best.map(|best| work.settled(best));
    let came_to_end =
        settled.as_ref().is_none_or(|settled| settled.1) && ends.iter().all(|end| end.1);
    let ended_after = (!came_to_end).then_some(STEPS);
    let mut accepted = settled.and_then(|settled| settled.0);
    if ask.forced && accepted.is_none() {
        accepted = ranked.iter().find(|t| t.wrong.is_empty()).cloned();
    }
    let support = accepted.as_ref().map_or_else(Vec::new, |t| work.support(t));
    let rivals = accepted.as_ref().map_or_else(Vec::new, |t| work.rivals(t));
    let disagreeing = match ask.each_log {
        true => work.disagreeing(accepted.as_ref()),
        false => Vec::new(),
    };
    Found {
        accepted: accepted.map(|all| work.of_fit(all)),
        support,
        ranked,
        rivals,
        ended_after,
        disagreeing,
    }
}

impl Work<'_> {
    fn tested(&self, hypotheses: &[Hypothesis], most: usize) -> Vec<Tested> {
        let misled = self.misled().clone();
        let leads = |h: &&Hypothesis| !h.parts.iter().any(|part| misled.contains(&part.variant));
        let hypotheses: Vec<Hypothesis> = hypotheses.iter().filter(leads).cloned().collect();
        distinct(self.library, &hypotheses, most)
            .par_iter()
            .map(|h| self.test(h))
            .collect()
    }

    fn test(&self, hypothesis: &Hypothesis) -> Tested {
        let known = || self.known.lock().unwrap_or_else(PoisonError::into_inner);
        let found = known().get(&hypothesis.parts).cloned();
        found.unwrap_or_else(|| {
            let new = tested(self.library, hypothesis, self.joint);
            self.watch.tell(|| new.trial());
            known().insert(hypothesis.parts.clone(), new.clone());
            new
        })
    }

    /// Hypotheses without details of effects that they do not have.
    fn whole(&self, all: Vec<Hypothesis>) -> Vec<Hypothesis> {
        let is_detail = |part: &Part| {
            self.library.variants[part.variant]
                .effect
                .effect
                .is_detail()
        };
        let whole = |h: &Hypothesis| self.any || !h.parts.iter().any(is_detail);
        all.into_iter().filter(whole).collect()
    }

    /// Physics and the rounding of the readings allow it.
    fn is_possible(&self, tested: &Tested) -> bool {
        let price =
            self.price * tested.parameters as f64 + evidence::prior() * tested.effects.len() as f64;
        tested.wrong.is_empty() && tested.beyond_rounding > self.joint.threshold(0.0) + price
    }

    fn parts(&self, tested: &Tested) -> Vec<Part> {
        parts_of(self.library, tested)
    }

    /// Adds, exchanges and removes one effect at a time as long as the evidence rises, and whether that
    /// came to its end.
    fn climbed(&self, start: Tested) -> (Tested, bool) {
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

    /// The best of some hypotheses with more evidence than what there is.
    fn best_of(&self, now: &Tested, mut all: Vec<Hypothesis>) -> Option<Tested> {
        all.sort_by(|a, b| b.evidence.total_cmp(&a.evidence));
        let explained = self.joint.threshold(now.gain) - threshold(0.0);
        let better = |t: &Tested| {
            let form = if t.effects.len() > now.effects.len() {
                explained
            } else {
                0.0
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

    /// One effect exchanged for another.
    fn exchanged(&self, now: &Tested) -> Vec<Hypothesis> {
        let parts = self.parts(now);
        let without = |place| with_one_more(self.library, &without(&parts, place), self.price);
        (0..parts.len()).flat_map(without).collect()
    }

    /// One effect less.
    fn fewer(&self, now: &Tested) -> Vec<Hypothesis> {
        let parts = self.parts(now);
        if parts.len() < 2 {
            return Vec::new();
        }
        let without =
            |place| with_forms_reselected(self.library, without(&parts, place), self.price);
        (0..parts.len()).filter_map(without).collect()
    }

    /// Evidence for each effect beside the others.
    fn each(&self, now: &Tested) -> Vec<f64> {
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

    /// What speaks for each effect: also against all that was tested and does without it.
    fn support(&self, now: &Tested) -> Vec<Support> {
        let beside = self.each(now);
        let known = self.known.lock().unwrap_or_else(PoisonError::into_inner);
        let misled = self.misled();
        let leads =
            |(parts, _): &(&Vec<Part>, &Tested)| !parts.iter().any(|p| misled.contains(&p.variant));
        let possible = known.iter().filter(leads).map(|(_, tested)| tested);
        let possible: Vec<&Tested> = possible.filter(|t| self.is_possible(t)).collect();
        let of = |(beside, own): (f64, &Fitted)| {
            let lacks_it = |t: &&&Tested| t.effects.iter().all(|e| e.id != own.id);
            let rivals = possible.iter().filter(lacks_it).map(|t| t.evidence);
            let best = rivals.fold(0.0, f64::max);
            Support::alone(beside).with_rival(now.evidence - best)
        };
        beside.into_iter().zip(&now.effects).map(of).collect()
    }

    /// Without the effects that are not worth their price beside the others. Of several, each of which the others
    /// nearly imitate, the one goes without which the logs of the fit foretell the unseen ones best.
    fn pruned(&self, found: Tested) -> Option<Tested> {
        let mut now = found;
        loop {
            let each = self.each(&now);
            let worthless = |place: &usize| {
                let others = now.gain - now.gain.min(each[*place].max(0.0));
                each[*place] < self.joint.threshold(others)
            };
            let worthless: Vec<usize> = (0..each.len()).filter(worthless).collect();
            let parts = self.parts(&now);
            let worth = |place: usize| match worthless.len() {
                1 => None,
                _ => self.foretold(without(&parts, place)),
            };
            let mut order: Vec<(f64, usize)> = worthless
                .iter()
                .map(|&place| (worth(place).unwrap_or(-each[place]), place))
                .collect();
            order.sort_by(|a, b| b.0.total_cmp(&a.0));
            if !order.is_empty() && parts.len() < 2 {
                return None;
            }
            let rest = |(_, place): (f64, usize)| {
                let rest = evaluate(self.library, without(&parts, place), self.price)?;
                Some(self.test(&rest)).filter(|rest| self.is_possible(rest))
            };
            match order.into_iter().find_map(rest) {
                Some(rest) => now = rest,
                // Nothing that may go, or nothing without which the others are possible.
                None => return Some(now),
            }
        }
    }

    /// From a start to effects that foretell the unseen logs: forms that do not are left out, and the search goes on
    /// without them, in the end without adding others. And whether the climbs came to their ends.
    fn settled(&self, start: Tested) -> (Option<Tested>, bool) {
        /// Effects in whose place others are looked for.
        const REPLACED: usize = 3;
        let mut start = start;
        let mut ended = true;
        let mut replaced = 0;
        loop {
            let (end, came_to_end) = match replaced <= REPLACED {
                true => self.climbed(start),
                false => (start, true),
            };
            ended &= came_to_end;
            let Some(accepted) = self.pruned(end) else {
                return (None, ended);
            };
            let Some((rest, forms)) = self.misleading(&accepted) else {
                return (Some(accepted), ended);
            };
            self.misled().extend(forms);
            replaced += 1;
            let rest = evaluate(self.library, rest, self.price);
            match rest.filter(|rest| !rest.parts.is_empty()) {
                Some(rest) => start = self.test(&rest),
                None => return (None, ended),
            }
        }
    }

    fn misled(&self) -> MutexGuard<'_, BTreeSet<usize>> {
        self.misled.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The effect with which the unseen logs are foretold worse than without it, by more than would name it: what is there
    /// without it, and its forms that are no better.
    fn misleading(&self, accepted: &Tested) -> Option<(Vec<Part>, Vec<usize>)> {
        let parts = self.parts(accepted);
        let with = self.foretold(parts.clone())?;
        let rest = |place: usize| match parts.len() {
            1 => Some(0.0),
            _ => self.foretold(without(&parts, place)),
        };
        let worse = (0..parts.len()).filter_map(|place| Some((rest(place)?, place)));
        let (rest, place) = worse.max_by(|a, b| a.0.total_cmp(&b.0))?;
        let worse = |gain: f64| rest - gain > self.joint.threshold(0.0);
        if !worse(with) {
            return None;
        }
        let own = self.library.variants[parts[place].variant].effect.id;
        let misleads = |variant: &usize| {
            let mut other = parts.clone();
            other[place].variant = *variant;
            self.foretold(other).is_none_or(worse)
        };
        let same = (0..self.library.variants.len())
            .into_par_iter()
            .filter(|k| self.library.variants[*k].effect.id == own);
        Some((without(&parts, place), same.filter(misleads).collect()))
    }

    /// Fall of χ² of the unseen logs by a hypothesis that is fitted to the others; none if there are none.
    fn foretold(&self, parts: Vec<Part>) -> Option<f64> {
        let fitted = self.joint.fitted;
        if fitted >= self.joint.logs.len() {
            return None;
        }
        let hypothesis = evaluate(self.library, parts, self.price)?;
        let of_fit = fitted_to(
            self.of_fit,
            self.library,
            &hypothesis,
            self.joint,
            Care::Screening,
        );
        let all: Vec<Column> = self
            .joint
            .logs
            .iter()
            .map(|log| of_fit.contribution(&log.scene))
            .collect();
        let white = self.joint.problem.whitened(&all.iter().collect::<Vec<_>>());
        let gains = self.joint.problem.gains(&white);
        Some(gains.iter().skip(fitted).sum())
    }

    /// Effects about which the logs disagree: in amounts of its own for each log they explain more. What all logs show
    /// even so is something else, which is of no log alone.
    fn disagreeing(&self, accepted: Option<&Tested>) -> Vec<&'static str> {
        let one = self.of_one_log(accepted);
        let one = one.filter(|h| self.explains_each_log(h));
        let mut ids: Vec<&str> = one.iter().flat_map(|h| self.ids(h)).collect();
        let Some(accepted) = accepted else {
            return ids;
        };
        let (explained, count) = (
            self.joint.explained(accepted.gain),
            self.joint.problem.count,
        );
        let each = self
            .joint
            .contrasts(accepted)
            .into_iter()
            .zip(&accepted.effects);
        let differing = each.filter(|(own, _)| evidence::disagree(*own, explained, 1, count));
        let differing: Vec<&str> = differing.map(|(_, effect)| effect.id).collect();
        let all = || evaluate(self.library, self.parts(accepted), self.price);
        if !differing.is_empty() && all().is_some_and(|h| self.explains_each_log(&h)) {
            ids.extend(differing);
        }
        ids
    }

    fn ids(&self, hypothesis: &Hypothesis) -> Vec<&'static str> {
        let variants = hypothesis.parts.iter().map(|p| p.variant);
        variants
            .map(|k| self.library.variants[k].effect.id)
            .collect()
    }

    /// Whether effects that are fitted to each log alone leave no structure that all logs show.
    fn explains_each_log(&self, hypothesis: &Hypothesis) -> bool {
        let of = |(log, prepared): (usize, &PreparedLog)| {
            let problem = self.joint.of_rows(|k, _| k == log);
            let own = fitted_to(
                &problem,
                self.library,
                hypothesis,
                self.joint,
                Care::Estimating,
            );
            (own.contribution(&prepared.scene), own.gain)
        };
        let each = self.joint.logs.par_iter().enumerate().map(of);
        let (own, gains): (Vec<Column>, Vec<f64>) = each.unzip();
        let left = structure::left_apart(self.joint, &own, gains.iter().sum());
        !left.any()
    }

    /// The effect that one log alone shows, if it explains more by itself than what all logs are said to
    /// have in common: several effects together imitate what changes from log to log. Steps of a
    /// reading look different in each log.
    fn of_one_log(&self, accepted: Option<&Tested>) -> Option<Hypothesis> {
        let (problem, logs) = (&self.joint.problem, self.joint.logs.len());
        if logs < 2 || self.joint.is_rounded() {
            return None;
        }
        let which_log = 2.0 * (logs as f64).ln();
        let alone = |place: usize, log: usize| -> Option<Hypothesis> {
            let variant = &self.library.variants[place];
            let columns = variant.columns.iter().map(|k| &self.library.columns[*k]);
            let of_log: Vec<Column> = columns.map(|c| problem.masked(c, log)).collect();
            let solution = problem.solve_whitened(&of_log, &variant.signs)?;
            let open = variant.signs.iter().filter(|s| **s != Sign::One).count();
            let parameters = open + variant.scanned();
            let paid = self.price * parameters as f64 + evidence::prior() + which_log;
            let possible = solution.wrong.is_empty();
            possible.then(|| Hypothesis {
                parts: vec![Part {
                    variant: place,
                    used: (0..variant.columns.len()).collect(),
                }],
                evidence: solution.gain - paid,
                solution,
                parameters,
            })
        };
        let better = |a: &Hypothesis, b: &Hypothesis| a.evidence.total_cmp(&b.evidence);
        let detail = |k: &usize| self.library.variants[*k].effect.effect.is_detail();
        let all = (0..self.library.variants.len()).into_par_iter();
        let best = all
            .filter(|k| self.any || !detail(k))
            .filter_map(|k| (0..logs).filter_map(|log| alone(k, log)).max_by(better))
            .max_by(better)?;
        let common = accepted.map_or(0.0, |t| t.evidence.max(0.0));
        let explained = accepted.map_or(0.0, |t| t.gain);
        (best.evidence > common + self.joint.threshold(explained)).then_some(best)
    }

    fn rivals(&self, accepted: &Tested) -> Vec<Rival> {
        rivals(self.library, accepted, self.price, &|h| {
            self.tested(h, TRIED_LATER)
        })
    }

    /// The same effects with the parameters that the logs of the fit alone give, where these
    /// determine them.
    fn of_fit(&self, all: Tested) -> Tested {
        let Some(hypothesis) = evaluate(self.library, self.parts(&all), self.price) else {
            return all;
        };
        let mut fitted = fitted_to(
            self.of_fit,
            self.library,
            &hypothesis,
            self.joint,
            Care::Estimating,
        );
        if !fitted.wrong.is_empty() || !is_determined(&fitted) {
            return all;
        }
        if self.joint.has_much_left(all.gain) {
            let of = |k: usize| {
                let problem = self.joint.without(k, PIECES);
                fitted_to(
                    &problem,
                    self.library,
                    &hypothesis,
                    self.joint,
                    Care::Screening,
                )
            };
            let fits: Vec<Tested> = (0..PIECES).into_par_iter().map(of).collect();
            widen(&mut fitted, &fits);
        }
        Tested {
            effects: fitted.effects,
            ..all
        }
    }
}

fn without(parts: &[Part], place: usize) -> Vec<Part> {
    let mut rest = parts.to_vec();
    rest.remove(place);
    rest
}

/// Whether the parameters of a fit are known at all.
fn is_determined(fitted: &Tested) -> bool {
    let parameters = fitted.effects.iter().flat_map(|e| e.parameters.values());
    let mut parameters = parameters.map(|(value, sigma, _)| (*value, *sigma));
    parameters.all(|(value, sigma)| value.is_finite() && sigma.is_finite())
}

/// The best hypotheses, at most so many, and two shapes of the same effects.
fn distinct(library: &Library, hypotheses: &[Hypothesis], most: usize) -> Vec<Hypothesis> {
    let mut kept: Vec<(Vec<&str>, Hypothesis)> = Vec::new();
    for hypothesis in hypotheses {
        if hypothesis.solution.gain < NEGLIGIBLE_GAIN {
            continue;
        }
        let mut ids: Vec<&str> = hypothesis
            .parts
            .iter()
            .map(|p| library.variants[p.variant].effect.id)
            .collect();
        ids.sort_unstable();
        let alike = kept.iter().filter(|k| k.0 == ids).count();
        if alike < 2 {
            kept.push((ids, hypothesis.clone()));
        }
        if kept.len() >= most {
            break;
        }
    }
    kept.into_iter().map(|k| k.1).collect()
}
