//! The search over stages of the actuator, over all logs together.
//!
//! Every stage is tried alone; the best stages are searched in pairs, both at once; and what is
//! best is added to, exchanged and taken back one stage at a time as long as the evidence rises.

use super::cost::{AxisCost, Cost, Term};
use super::forms::other_forms;
use super::grid::combinations;
use super::pairs::best_pair;
use super::refine::{improved, refined};
use super::steps::best_step;
use super::tried::specs;
use crate::diagnose::evidence::{self, Support, TOLD_APART, threshold};
use crate::diagnose::finding::Trial;
use crate::diagnose::question::Watch;
use rayon::prelude::*;
use softdock_physics::model::Channel;
use softdock_physics::model::stage::Stage;

/// Gain on the grid below which a stage is not searched further.
const NEGLIGIBLE_GAIN: f64 = 5.0;
/// Residual over noise at which nothing is left to explain.
const AT_NOISE: f64 = 1.03;
/// Most stages that an actuator may lack.
const MOST: usize = 4;
/// Stages that are tried beside others.
const TRIED_BESIDE: usize = 6;

/// A hypothesis with its best parameters.
#[derive(Clone, Debug)]
pub(crate) struct Candidate {
    /// One stage, or several.
    pub terms: Vec<Term>,
    /// χ² over all logs.
    pub chi2: f64,
    /// χ² of each log.
    pub each: Vec<f64>,
}

impl Candidate {
    /// With these terms.
    pub(super) fn new(terms: Vec<Term>, cost: &Cost<'_>) -> Self {
        Self {
            chi2: cost.of(&terms),
            each: cost.of_each(&terms),
            terms,
        }
    }

    /// Number of parameters.
    pub(crate) fn parameters(&self) -> usize {
        self.terms.iter().map(|t| t.values.len()).sum()
    }

    fn trial(&self, nominal: &Self) -> Trial {
        Trial {
            effects: self.ids().into_iter().map(str::to_owned).collect(),
            channel: Channel::ExecutedVelocity,
            gain: nominal.chi2 - self.chi2,
        }
    }

    /// Ids of its effects, each once.
    pub(crate) fn ids(&self) -> Vec<&'static str> {
        let mut ids: Vec<&str> = self.terms.iter().map(|t| t.stage.id()).collect();
        ids.sort_unstable();
        ids.dedup();
        ids
    }

    /// χ² with the price of the parameters and the prior odds of the effects.
    pub(super) fn priced(&self, cost: &Cost<'_>) -> f64 {
        let price = evidence::price(cost.count());
        self.chi2 + price * self.parameters() as f64 + evidence::prior() * self.ids().len() as f64
    }
}

/// Result of the search.
#[derive(Clone, Debug)]
pub(crate) struct Search {
    /// The nominal actuator.
    pub nominal: Candidate,
    /// Stages alone, best first.
    pub singles: Vec<Candidate>,
    /// What is accepted, if anything: its parameters are those of the logs of the fit.
    pub accepted: Option<Candidate>,
    /// What speaks for each of its effects.
    pub support: Vec<(&'static str, Support)>,
    /// The accepted terms with the parameters of each log alone, if the logs disagree about them.
    pub apart: Option<Vec<Vec<Term>>>,
    /// Other forms of what is accepted that explain the logs as well.
    pub equal_forms: Vec<Candidate>,
}

impl Search {
    /// Takes the noise of the logs from what the best hypotheses leave; returns whether it is less.
    pub(crate) fn quieten(&self, cost: &mut Cost<'_>) -> bool {
        /// Hypotheses whose remainder is looked at.
        const BEST: usize = 3;
        let accepted = self.accepted.iter();
        let best = accepted.chain(self.singles.iter().take(BEST));
        cost.quieten(best.map(|c| &c.terms[..]))
    }

    /// The largest evidence of any stage alone.
    pub(crate) fn strongest(&self, cost: &Cost<'_>) -> Option<f64> {
        let nominal = self.nominal.priced(cost);
        let causes = self.singles.iter().filter(|c| is_a_cause(c, cost));
        causes
            .map(|c| nominal - c.priced(cost))
            .max_by(f64::total_cmp)
    }

    /// What is accepted.
    pub(crate) fn terms(&self) -> &[Term] {
        self.accepted.as_ref().map_or(&[], |c| &c.terms)
    }

    /// χ² with what is accepted.
    pub(crate) fn reached(&self) -> f64 {
        self.accepted.as_ref().unwrap_or(&self.nominal).chi2
    }
}

/// What is asked of a search.
pub(crate) struct Ask<'a> {
    /// Effects that are not tried.
    pub excluded: &'a (dyn Fn(&str) -> bool + Sync),
    /// The best stage is taken although it is not significant.
    pub forced: bool,
    /// No pairs: what is left is known not to be the actuator's.
    pub alone: bool,
    /// Number of logs of the fit, the first ones.
    pub fitted: usize,
    /// Who follows it.
    pub watch: Watch<'a>,
}

/// Searches. Tolerances that the answer strains are taken away, and the search begins anew.
pub(crate) fn search(cost: &mut Cost<'_>, ask: &Ask<'_>) -> Search {
    let mut found = searched(cost, ask);
    if cost.freeze_strained(found.terms()) {
        found = searched(cost, ask);
    }
    found
}

fn searched(cost: &Cost<'_>, ask: &Ask<'_>) -> Search {
    let nominal = Candidate::new(Vec::new(), cost);
    let scopes = scopes(&cost.active);
    let singles: Vec<Candidate> = Stage::ALL
        .par_iter()
        .filter(|stage| !(ask.excluded)(stage.id()))
        .filter_map(|stage| best_single(*stage, &scopes, cost, &[]))
        .inspect(|found| ask.watch.tell(|| found.trial(&nominal)))
        .collect();
    let mut order: Vec<(f64, Candidate)> =
        singles.into_iter().map(|c| (c.priced(cost), c)).collect();
    order.sort_by(|a, b| a.0.total_cmp(&b.0));
    let singles: Vec<Candidate> = order.into_iter().map(|o| o.1).collect();
    let first = singles.iter().find(|c| is_a_cause(c, cost));
    let mut best = first.cloned().unwrap_or_else(|| nominal.clone());
    let unfinished = |c: &Candidate| level(c.chi2, cost) > AT_NOISE;
    let significant = |c: &Candidate| nominal.priced(cost) - c.priced(cost) > threshold(0.0);
    if unfinished(&best) && !ask.alone && singles.iter().any(significant) {
        best = climbed(best, &singles, &scopes, cost);
        ask.watch.tell(|| best.trial(&nominal));
    }
    // What leaves less for its price than all that it could imitate is no imitation.
    let leaves_less = |c: &&Candidate| c.priced(cost) + TOLD_APART < best.priced(cost);
    let mut servos = singles.iter().filter(|c| is_a_servo(c));
    if let Some(servo) = servos.find(leaves_less).filter(|_| unfinished(&best)) {
        best = match ask.alone {
            true => servo.clone(),
            false => climbed(servo.clone(), &singles, &scopes, cost),
        };
        ask.watch.tell(|| best.trial(&nominal));
    }
    let mut accepted = pruned(best, &nominal, cost);
    if ask.forced && accepted.is_none() {
        accepted = singles.first().cloned();
    }
    let mut equal_forms = Vec::new();
    if let Some(candidate) = &mut accepted {
        equal_forms = choose_form(candidate, cost);
        prefer_exact_nominal(candidate, cost);
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

/// Residual over noise of a χ².
pub(crate) fn level(chi2: f64, cost: &Cost<'_>) -> f64 {
    (chi2 / cost.count().max(1) as f64).sqrt()
}

/// Pairs, then one stage more at a time, as long as the evidence rises.
fn climbed(
    start: Candidate,
    singles: &[Candidate],
    scopes: &[[bool; 6]],
    cost: &Cost<'_>,
) -> Candidate {
    let better = |new: &Candidate, old: &Candidate| {
        let more = new.ids().len() > old.ids().len();
        let form = if more {
            threshold(singles.first().map_or(0.0, |_| cost.of(&[]) - old.chi2)) - threshold(0.0)
        } else {
            0.0
        };
        new.priced(cost) + form < old.priced(cost)
    };
    let mut now = start;
    if let Some(pair) = best_pair(singles, cost).filter(|pair| better(pair, &now)) {
        now = pair;
    }
    while now.ids().len() < MOST && level(now.chi2, cost) > AT_NOISE {
        let new = |c: &&Candidate| !c.ids().iter().any(|id| now.ids().contains(id));
        let stages: Vec<Stage> = singles
            .iter()
            .filter(|c| is_a_cause(c, cost))
            .filter(new)
            .filter_map(|c| Some(c.terms.first()?.stage))
            .take(TRIED_BESIDE)
            .collect();
        let beside = |stage: &Stage| best_single(*stage, scopes, cost, &now.terms);
        let more: Vec<Candidate> = stages.par_iter().filter_map(beside).collect();
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

/// What is left without one effect, with the others at their best.
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

/// Evidence for each effect beside the others.
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

/// What speaks for each effect: also against the stages alone that do without it.
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
        (id, Support::alone(beside).with_rival(best - priced))
    };
    each(candidate, nominal, cost).into_iter().map(of).collect()
}

/// Without the effects that are not worth their price beside the others.
fn pruned(found: Candidate, nominal: &Candidate, cost: &Cost<'_>) -> Option<Candidate> {
    let mut now = found;
    while !now.terms.is_empty() {
        let each = each(&now, nominal, cost);
        let (id, evidence) = *each.iter().min_by(|a, b| a.1.total_cmp(&b.1))?;
        let others = nominal.chi2 - now.chi2 - evidence;
        if evidence >= threshold(if each.len() > 1 { others } else { 0.0 }) {
            return Some(now);
        }
        now = without(&now, id, nominal, cost);
    }
    None
}

/// The terms with the parameters of each log alone, if the logs disagree about them.
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
        // Both with nominal values of the log's own, which what is common does not have to pay for.
        match own < common {
            true => (common - own, terms),
            false => (0.0, candidate.terms.clone()),
        }
    };
    let own = (0..cost.logs.len()).into_par_iter().map(own);
    let (gains, terms): (Vec<f64>, Vec<Vec<Term>>) = own.unzip();
    let gain = gains.iter().sum::<f64>();
    let explained = nominal.chi2 - candidate.chi2;
    evidence::disagree(gain, explained, more, cost.count()).then_some(terms)
}

/// The same stages with the parameters that the logs of the fit alone give.
fn of_fit(candidate: Candidate, cost: &Cost<'_>, fitted: usize) -> Candidate {
    let own = cost.of_logs(|log| log < fitted);
    let terms = refined(candidate.terms.clone(), &own);
    // What these logs do not show is taken from all.
    if own.of(&[]) - own.of(&terms) < NEGLIGIBLE_GAIN {
        return candidate;
    }
    Candidate::new(terms, cost)
}

/// Takes the form that explains the logs best; returns those that are not told from it.
fn choose_form(candidate: &mut Candidate, cost: &Cost<'_>) -> Vec<Candidate> {
    let mut others = other_forms(candidate, cost);
    others.sort_by(|a, b| a.chi2.total_cmp(&b.chi2));
    if let Some(best) = others.first_mut()
        && best.chi2 < candidate.chi2
    {
        std::mem::swap(best, candidate);
    }
    // In units of the noise that the best form leaves.
    let noise = (candidate.chi2 / cost.count().max(1) as f64).max(1.0);
    let as_good = candidate.chi2 + TOLD_APART * noise;
    others.retain(|other| other.chi2 < as_good);
    others
}

/// What a stage explains is not left to the tolerances: its parameters are fitted once more with
/// exact nominal values, if that explains the log as well.
fn prefer_exact_nominal(candidate: &mut Candidate, cost: &Cost<'_>) {
    let exact = improved(candidate.terms.clone(), cost, &|terms| cost.exactly(terms));
    if cost.exactly(&exact) < candidate.chi2 + TOLD_APART {
        *candidate = Candidate::new(exact, cost);
    }
}

/// Whether it is a damped second order and nothing else.
fn is_a_servo(candidate: &Candidate) -> bool {
    let mut stages = candidate.terms.iter().map(|term| term.stage);
    stages.all(|stage| matches!(stage, Stage::Servo | Stage::ServoForLag))
}

/// A damped second order imitates delay, lag and limits together: it is a cause only where it leaves
/// nothing but noise, or less than these. A structure rings.
pub(super) fn is_a_cause(candidate: &Candidate, cost: &Cost<'_>) -> bool {
    /// Damping ratio up to which a mode rings.
    const RINGS: f64 = 0.25;
    candidate.terms.iter().all(|term| match term.stage {
        Stage::Servo | Stage::ServoForLag => level(candidate.chi2, cost) < AT_NOISE,
        Stage::Resonance => term.values.get(1).is_some_and(|damping| *damping < RINGS),
        _ => true,
    })
}

/// Sets of axes that may have a stage of their own.
fn scopes(active: &[bool; 6]) -> Vec<[bool; 6]> {
    let linear = std::array::from_fn(|i| i < 3 && active[i]);
    let angular = std::array::from_fn(|i| i >= 3 && active[i]);
    let mut scopes = vec![*active];
    let count = active.iter().filter(|a| **a).count();
    if count > 1 {
        for scope in [linear, angular] {
            if scope != *active && scope.contains(&true) {
                scopes.push(scope);
            }
        }
        for axis in (0..6).filter(|a| active[*a]) {
            scopes.push(std::array::from_fn(|i| i == axis));
        }
    }
    scopes
}

/// The best values of a stage beside given terms, which are refined with it.
fn best_single(
    stage: Stage,
    scopes: &[[bool; 6]],
    cost: &Cost<'_>,
    beside: &[Term],
) -> Option<Candidate> {
    let terms = if stage.has_units_of_its_axes() {
        by_kind(stage, cost, beside)?
    } else {
        vec![best_scope(stage, scopes, cost, beside)?]
    };
    let all = [beside, &terms[..]].concat();
    // What the grid does not show at all is not worth a search.
    let hopeless = cost.of(beside) - cost.of(&all) < NEGLIGIBLE_GAIN && !slips_through(stage);
    let all = if hopeless {
        all
    } else if stage.has_units_of_its_axes() {
        refined(all, cost)
    } else {
        let scoped = rescoped(refined(all, cost), scopes, cost);
        if beside.is_empty() {
            on_all_axes(scoped, cost)
        } else {
            scoped
        }
    };
    Some(Candidate::new(all, cost))
}

/// The last term on other axes, where these explain clearly more: the grid that they were chosen on
/// is coarse, and a mode that is not quite right there is no better on the axes that have it.
fn rescoped(terms: Vec<Term>, scopes: &[[bool; 6]], cost: &Cost<'_>) -> Vec<Term> {
    let on = |scope: &[bool; 6]| {
        let mut terms = terms.clone();
        if let Some(last) = terms.last_mut() {
            last.axes = *scope;
        }
        (cost.of(&terms), terms)
    };
    let best = scopes.iter().map(on).min_by(|a, b| a.0.total_cmp(&b.0));
    match best {
        Some((chi2, other)) if chi2 + TOLD_APART < cost.of(&terms) => refined(other, cost),
        _ => terms,
    }
}

/// What the grid saw on some axes only may be on all of them, with a value between its own.
fn on_all_axes(terms: Vec<Term>, cost: &Cost<'_>) -> Vec<Term> {
    let some = |t: &Term| (0..6).any(|axis| cost.active[axis] && !t.axes[axis]);
    if !terms.iter().any(some) {
        return terms;
    }
    let everywhere = terms.iter().map(|t| Term {
        axes: cost.active,
        ..t.clone()
    });
    let everywhere = refined(everywhere.collect(), cost);
    if cost.of(&everywhere) < cost.of(&terms) + TOLD_APART {
        everywhere
    } else {
        terms
    }
}

/// Whether the best value may lie between two values of the grid that both make things worse.
fn slips_through(stage: Stage) -> bool {
    matches!(stage, Stage::Delay | Stage::Lag | Stage::Gain)
}

/// The costs of all axes on the grid of a stage beside given terms.
fn table(
    stage: Stage,
    axes: &[bool; 6],
    cost: &Cost<'_>,
    beside: &[Term],
) -> Vec<(Vec<f64>, [AxisCost; 6])> {
    combinations(&specs(stage, &cost.scale(axes)))
        .into_par_iter()
        .map(|values| {
            let term = Term {
                stage,
                values: values.clone(),
                axes: *axes,
            };
            let terms = [beside, &[term]].concat();
            let costs = cost.of_axes(&terms, axes);
            (values, costs)
        })
        .collect()
}

/// The best values and the best set of axes for a stage.
fn best_scope(
    stage: Stage,
    scopes: &[[bool; 6]],
    cost: &Cost<'_>,
    beside: &[Term],
) -> Option<Term> {
    let bare = cost.of_axes(beside, &cost.active);
    let table = table(stage, scopes.first()?, cost, beside);
    let mut best: Option<(f64, Term)> = None;
    for scope in scopes {
        for (values, costs) in &table {
            let mixed = std::array::from_fn(|a| if scope[a] { costs[a] } else { bare[a] });
            let chi2 = cost.total(&mixed);
            if best.as_ref().is_none_or(|(least, _)| chi2 < least - 1e-9) {
                let term = Term {
                    stage,
                    values: values.clone(),
                    axes: *scope,
                };
                best = Some((chi2, term));
            }
        }
    }
    best.map(|b| b.1)
}

/// Translations and rotations with a value each, as far as both gain by it.
fn by_kind(stage: Stage, cost: &Cost<'_>, beside: &[Term]) -> Option<Vec<Term>> {
    let bare = cost.of_axes(beside, &cost.active);
    let mut kinds: Vec<(f64, Term)> = Vec::new();
    for kind in [0..3, 3..6] {
        let axes: [bool; 6] = std::array::from_fn(|a| kind.contains(&a) && cost.active[a]);
        if !axes.contains(&true) {
            continue;
        }
        let of = |(values, costs): (Vec<f64>, [AxisCost; 6])| {
            let mixed = std::array::from_fn(|a| if axes[a] { costs[a] } else { bare[a] });
            (cost.total(&mixed), values)
        };
        let best = table(stage, &axes, cost, beside).into_iter().map(of);
        let mut values = best.min_by(|a, b| a.0.total_cmp(&b.0))?.1;
        if stage == Stage::CommandStep
            && let Some(step) = best_step(&axes, cost)
        {
            values = vec![step];
        }
        let mut term = vec![Term {
            stage,
            values,
            axes,
        }];
        // The grid is coarse: where there is something to explain, a kind is judged by its best
        // value.
        let of_kind = |terms: &[Term]| {
            let all = [beside, terms].concat();
            cost.total(&cost.of_axes(&all, &axes))
        };
        let noise = AT_NOISE * AT_NOISE * cost.count_of(&axes) as f64;
        if of_kind(&[]) > noise {
            term = improved(term, cost, &of_kind);
        }
        kinds.push((of_kind(&[]) - of_kind(&term), term.swap_remove(0)));
    }
    kinds.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut terms: Vec<Term> = Vec::new();
    for (gain, term) in kinds {
        if terms.is_empty() || gain > threshold(0.0) + evidence::price(cost.count()) {
            terms.push(term);
        }
    }
    (!terms.is_empty()).then_some(terms)
}
