//! The search over stages of the actuator, over all logs together.
//!
//! Every stage is tried alone. The best stages are searched in pairs, both at once. The search then adds one stage at a time as
//! long as the evidence rises, and once more without the stage that is needed least.

use super::alone::{NEGLIGIBLE_GAIN, best_single, scopes};
use super::candidate::{
    AT_NOISE, Candidate, Search, is_a_cause, is_a_gain, is_a_servo, level, rings,
};
use super::cost::{Cost, Term};
use super::forms::other_forms;
use super::pairs::best_pair;
use super::refine::{improved, refined};
use crate::diagnose::evidence::{self, Support, TOLD_APART, threshold};
use crate::diagnose::watch::Watch;
use rayon::prelude::*;
use softdock_physics::model::stage::Stage;

/// Most effects that an actuator may lack.
const MOST: usize = 4;
/// Most stages that are tried beside others.
const TRIED_BESIDE: usize = 6;

/// The options of a search.
pub(crate) struct Ask<'a> {
    /// Effects that are not tried.
    pub excluded: &'a (dyn Fn(&str) -> bool + Sync),
    /// The best stage is taken although it is not significant.
    pub forced: bool,
    /// No pairs: what is left is known not to be the actuator's.
    pub alone: bool,
    /// Number of logs of the fit, the first ones.
    pub fitted: usize,
    /// Receives each hypothesis when it is tried.
    pub watch: Watch<'a>,
}

/// Searches for stages. If the answer needs nuisance parameters too far off, these are held and the search is repeated.
pub(crate) fn search(cost: &mut Cost<'_>, ask: &Ask<'_>) -> Search {
    let mut found = searched(cost, ask);
    if cost.hold_strained(found.terms()) {
        found = searched(cost, ask);
    }
    found
}

fn searched(cost: &Cost<'_>, ask: &Ask<'_>) -> Search {
    let nominal = Candidate::new(Vec::new(), cost);
    let scopes = scopes(&cost.active);
    let singles: Vec<Candidate> = Stage::ALL
        .par_iter()
        .filter(|stage| !(ask.excluded)(stage.id()) && can_show(cost, **stage))
        .filter_map(|stage| best_single(*stage, &scopes, cost, &[], ask.excluded))
        .inspect(|found| ask.watch.tell(|| found.trial(&nominal)))
        .collect();
    let mut order: Vec<(f64, Candidate)> =
        singles.into_iter().map(|c| (c.priced(cost), c)).collect();
    order.sort_by(|a, b| a.0.total_cmp(&b.0));
    let singles: Vec<Candidate> = order.into_iter().map(|o| o.1).collect();
    let first = singles.iter().find(|c| is_a_cause(c, cost));
    let mut best = first.cloned().unwrap_or_else(|| nominal.clone());
    let unfinished = |c: &Candidate| level(c.chi2, cost) > AT_NOISE;
    let needed = threshold(cost.explained());
    let significant = |c: &Candidate| nominal.priced(cost) - c.priced(cost) > needed;
    if unfinished(&best) && !ask.alone && singles.iter().any(significant) {
        best = climbed(best, &singles, &scopes, cost, ask);
        ask.watch.tell(|| best.trial(&nominal));
    }
    // A servo that leaves less, its price paid, than all that it could imitate is no imitation.
    let leaves_less = |c: &&Candidate| c.priced(cost) + TOLD_APART < best.priced(cost);
    let mut servos = singles.iter().filter(|c| is_a_servo(c));
    if let Some(servo) = servos.find(leaves_less).filter(|_| unfinished(&best)) {
        best = match ask.alone {
            true => servo.clone(),
            false => climbed(servo.clone(), &singles, &scopes, cost, ask),
        };
        ask.watch.tell(|| best.trial(&nominal));
    }
    let mut accepted = pruned(best, &nominal, cost);
    while let Some(rest) = accepted
        .as_ref()
        .and_then(|c| without_misleading(c, &nominal, cost, ask))
    {
        accepted = pruned(rest, &nominal, cost);
    }
    if ask.forced && accepted.is_none() {
        accepted = singles.first().cloned();
    }
    let mut equal_forms = Vec::new();
    if let Some(candidate) = &mut accepted {
        let ids = candidate.ids();
        equal_forms = choose_form(candidate, cost, ask.excluded);
        prefer_exact_nominal(candidate, cost);
        // Beside a stage that continues beyond the range of another one, further stages may be worth their price.
        if candidate.ids() != ids && !ask.alone {
            let more = climbed(candidate.clone(), &singles, &scopes, cost, ask);
            if let Some(more) = pruned(more, &nominal, cost) {
                *candidate = more;
                equal_forms = choose_form(candidate, cost, ask.excluded);
                prefer_exact_nominal(candidate, cost);
            }
        }
    }
    let support = accepted
        .iter()
        .flat_map(|c| support(c, &singles, &nominal, cost))
        .collect();
    let apart = accepted.as_ref();
    let apart = apart.and_then(|c| apart_if_they_disagree(c, &nominal, cost));
    Search {
        accepted: accepted.map(|c| of_fit(c, cost, ask.fitted)),
        nominal,
        singles,
        support,
        apart,
        equal_forms,
    }
}

/// Whether the commands can show a stage. A static curve that is seen at one command size is a straight line, and commands in one
/// direction do not tell the gain of this direction from that of both.
fn can_show(cost: &Cost<'_>, stage: Stage) -> bool {
    let shows = |axis: usize| match stage {
        Stage::DeadZone | Stage::PlannerVelocity => cost.sizes_of_commands(axis) > 1,
        Stage::Direction => cost.is_sent_both_ways(axis),
        _ => true,
    };
    (0..6).any(|axis| cost.active[axis] && shows(axis))
}

/// Tries the best pair, then adds one stage at a time as long as the evidence rises; then once more without the stage that is
/// needed least.
fn climbed(
    start: Candidate,
    singles: &[Candidate],
    scopes: &[[bool; 6]],
    cost: &Cost<'_>,
    ask: &Ask<'_>,
) -> Candidate {
    let better = |new: &Candidate, old: &Candidate| {
        let more = new.ids().len() > old.ids().len();
        let form = if more {
            let explained = singles.first().map_or(0.0, |_| cost.of(&[]) - old.chi2);
            threshold(cost.explained() + explained) - threshold(0.0)
        } else {
            0.0
        };
        new.priced(cost) + form < old.priced(cost)
    };
    let mut now = start;
    if let Some(pair) = best_pair(singles, cost).filter(|pair| better(pair, &now)) {
        now = pair;
    }
    let now = one_more_at_a_time(now, None, &better, singles, scopes, cost, ask);
    // One stage may stand in the place of two. So the stage that is needed least is left out once, and others may take its place.
    let nominal = Candidate::new(Vec::new(), cost);
    let is_zone = |stage: Stage| stage == Stage::DeadZone || is_a_gain(stage);
    let of_zone = |id: &str| {
        let mut zone = Stage::ALL.iter().filter(|stage| is_zone(**stage));
        now.has(Stage::DeadZone) && zone.any(|stage| stage.id() == id)
    };
    let least = match level(now.chi2, cost) > AT_NOISE && now.causes() > 1 {
        true => each(&now, &nominal, cost),
        false => Vec::new(),
    };
    let least = least.into_iter().filter(|(id, _)| !of_zone(id));
    let Some((least, _)) = least.min_by(|a, b| a.1.total_cmp(&b.1)) else {
        return now;
    };
    let rest = without(&now, least, &nominal, cost);
    let other = one_more_at_a_time(rest, Some(least), &better, singles, scopes, cost, ask);
    match better(&other, &now) {
        true => other,
        false => now,
    }
}

/// Adds one stage at a time as long as the evidence rises, up to [`MOST`] effects; never the effect `but`.
fn one_more_at_a_time(
    start: Candidate,
    but: Option<&str>,
    better: &dyn Fn(&Candidate, &Candidate) -> bool,
    singles: &[Candidate],
    scopes: &[[bool; 6]],
    cost: &Cost<'_>,
    ask: &Ask<'_>,
) -> Candidate {
    let mut now = start;
    while now.causes() < MOST && level(now.chi2, cost) > AT_NOISE {
        // Only the first term is asked, as the gains that a dead zone brings along may be there already.
        let new = |c: &&Candidate| {
            let first = c.terms.first().map(|term| term.stage.id());
            let is_new = |id: &str| !now.ids().contains(&id) && but != Some(id);
            first.is_some_and(is_new)
        };
        let others = singles.iter().filter(|c| is_a_cause(c, cost)).filter(new);
        let others = others.filter_map(|c| Some(c.terms.first()?.stage));
        // A gain beyond a dead zone explains little alone, so it is tried whatever its rank.
        let of_zone = |stage: Stage| now.has(Stage::DeadZone) && is_a_gain(stage);
        let mut stages: Vec<Stage> = others
            .enumerate()
            .filter(|(place, stage)| *place < TRIED_BESIDE || of_zone(*stage))
            .map(|(_, stage)| stage)
            .collect();
        // A mode that imitates a delay when alone may ring behind that delay. It is tried only if there are no other stages, as
        // among many it would imitate what is left of them.
        if stages.is_empty() {
            let modes = singles.iter().filter(|c| !rings(c)).filter(new);
            stages.extend(modes.filter_map(|c| Some(c.terms.first()?.stage)));
        }
        let beside = |stage: &Stage| best_single(*stage, scopes, cost, &now.terms, ask.excluded);
        let mut more: Vec<Candidate> = stages.par_iter().filter_map(beside).collect();
        more.extend(the_other_way_round(
            &now, singles, &stages, scopes, cost, ask,
        ));
        more.retain(rings);
        let best = more
            .into_iter()
            .min_by(|a, b| a.priced(cost).total_cmp(&b.priced(cost)));
        match best.filter(|best| better(best, &now)) {
            Some(best) => now = best,
            None => break,
        }
    }
    now
}

/// Where a mode is the only term: the mode searched anew beside each other stage at the best values of that stage alone. The
/// frequency and damping of a mode behind a delay are found beside the delay and not alone.
fn the_other_way_round(
    now: &Candidate,
    singles: &[Candidate],
    others: &[Stage],
    scopes: &[[bool; 6]],
    cost: &Cost<'_>,
    ask: &Ask<'_>,
) -> Vec<Candidate> {
    let [only] = &now.terms[..] else {
        return Vec::new();
    };
    if only.stage != Stage::Resonance {
        return Vec::new();
    }
    let is_other = |c: &&Candidate| match &c.terms[..] {
        [other] => others.contains(&other.stage),
        _ => false,
    };
    let others: Vec<&Candidate> = singles.iter().filter(is_other).collect();
    let others = others.into_par_iter();
    others
        .filter_map(|c| best_single(only.stage, scopes, cost, &c.terms, ask.excluded))
        .collect()
}

/// The candidate without one effect, the other terms refined.
fn without(candidate: &Candidate, id: &str, nominal: &Candidate, cost: &Cost<'_>) -> Candidate {
    let rest: Vec<Term> = candidate
        .terms
        .iter()
        .filter(|t| t.stage.id() != id)
        .cloned()
        .collect();
    if rest.is_empty() {
        return nominal.clone();
    }
    Candidate::new(refined(rest, cost), cost)
}

/// Evidence for each effect: by how much the priced χ² rises without it, the others refined.
fn each(candidate: &Candidate, nominal: &Candidate, cost: &Cost<'_>) -> Vec<(&'static str, f64)> {
    let priced = candidate.priced(cost);
    let ids = candidate.ids().into_iter();
    ids.map(|id| {
        (
            id,
            without(candidate, id, nominal, cost).priced(cost) - priced,
        )
    })
    .collect()
}

/// Support of each effect: its evidence beside the others, and that against the best single stage without it.
fn support(
    candidate: &Candidate,
    singles: &[Candidate],
    nominal: &Candidate,
    cost: &Cost<'_>,
) -> Vec<(&'static str, Support)> {
    let priced = candidate.priced(cost);
    let of = |(id, beside): (&'static str, f64)| {
        let lacks_it = |c: &&Candidate| is_a_cause(c, cost) && !c.ids().contains(&id);
        let rivals = singles.iter().filter(lacks_it).map(|c| c.priced(cost));
        let best = rivals.fold(f64::INFINITY, f64::min);
        (id, Support::without_rival(beside).with_rival(best - priced))
    };
    each(candidate, nominal, cost).into_iter().map(of).collect()
}

/// Removes effects that are not worth their price beside the others, the weakest first. `None` if none is left.
fn pruned(found: Candidate, nominal: &Candidate, cost: &Cost<'_>) -> Option<Candidate> {
    let mut now = found;
    while !now.terms.is_empty() {
        let each = each(&now, nominal, cost);
        let (id, evidence) = *each.iter().min_by(|a, b| a.1.total_cmp(&b.1))?;
        let others = nominal.chi2 - now.chi2 - evidence;
        let others = if each.len() > 1 { others } else { 0.0 };
        if evidence >= threshold(cost.explained() + others) {
            return Some(now);
        }
        now = without(&now, id, nominal, cost);
    }
    None
}

/// The candidate without an effect that makes χ² of the unseen logs worse by more than [`TOLD_APART`]. `None` if there is no such
/// effect, or if the logs disagree.
fn without_misleading(
    candidate: &Candidate,
    nominal: &Candidate,
    cost: &Cost<'_>,
    ask: &Ask<'_>,
) -> Option<Candidate> {
    let unseen = |c: &Candidate| c.each.iter().skip(ask.fitted).sum::<f64>();
    let rest = candidate.ids().into_iter();
    let mut rest = rest.map(|id| without(candidate, id, nominal, cost));
    let better = rest.find(|rest| unseen(rest) + TOLD_APART < unseen(candidate))?;
    let disagree = apart_if_they_disagree(candidate, nominal, cost).is_some();
    (!disagree).then_some(better)
}

/// The terms fitted to each log alone, if the logs disagree about them; one entry per log. `None` if they agree.
fn apart_if_they_disagree(
    candidate: &Candidate,
    nominal: &Candidate,
    cost: &Cost<'_>,
) -> Option<Vec<Vec<Term>>> {
    if cost.logs.len() < 2 {
        return None;
    }
    let more = candidate.parameters() * (cost.logs.len() - 1);
    let own = |log: usize| {
        let alone = cost.of_logs(|k| k == log);
        let terms = refined(candidate.terms.clone(), &alone);
        let (own, common) = (alone.of(&terms), alone.of(&candidate.terms));
        // Both χ² have nuisance parameters of this log alone, so that the common values do not pay for these.
        match own < common {
            true => (common - own, terms),
            false => (0.0, candidate.terms.clone()),
        }
    };
    let own = (0..cost.logs.len()).into_par_iter().map(own);
    let (gains, terms): (Vec<f64>, Vec<Vec<Term>>) = own.unzip();
    let gain = gains.iter().sum::<f64>();
    let explained = cost.explained() + nominal.chi2 - candidate.chi2;
    evidence::disagree(gain, explained, more, cost.count()).then_some(terms)
}

/// The same stages with the parameters of the logs of the fit alone.
fn of_fit(candidate: Candidate, cost: &Cost<'_>, fitted: usize) -> Candidate {
    let own = cost.of_logs(|log| log < fitted);
    let terms = refined(candidate.terms.clone(), &own);
    // If these logs do not show the stages, the parameters are those of all logs.
    if own.of(&[]) - own.of(&terms) < NEGLIGIBLE_GAIN {
        return candidate;
    }
    Candidate::new(terms, cost)
}

/// Takes the form that explains the logs best. Returns the other forms of the same effects that the logs do not tell from it.
fn choose_form(
    candidate: &mut Candidate,
    cost: &Cost<'_>,
    excluded: &dyn Fn(&str) -> bool,
) -> Vec<Candidate> {
    let mut others = other_forms(candidate, cost, excluded);
    others.sort_by(|a, b| a.chi2.total_cmp(&b.chi2));
    if let Some(best) = others.first_mut()
        && best.chi2 < candidate.chi2
    {
        std::mem::swap(best, candidate);
    }
    // In units of the noise that the best form leaves.
    let noise = (candidate.chi2 / cost.count().max(1) as f64).max(1.0);
    let as_good = candidate.chi2 + TOLD_APART * noise;
    others.retain(|other| other.chi2 < as_good && other.ids() == candidate.ids());
    others
}

/// Fits the parameters once more with the nuisance parameters at their nominal values, and takes these if they explain the logs
/// as well: what a stage explains must not be left to the tolerances.
fn prefer_exact_nominal(candidate: &mut Candidate, cost: &Cost<'_>) {
    let exact = improved(candidate.terms.clone(), cost, &|terms| cost.exactly(terms));
    if cost.exactly(&exact) < candidate.chi2 + TOLD_APART {
        *candidate = Candidate::new(exact, cost);
    }
}
