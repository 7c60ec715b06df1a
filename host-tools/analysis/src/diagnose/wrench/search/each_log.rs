//! Whether the logs are of one machine in one state: finds effects whose amounts differ from log to log, or that one log alone
//! shows.

use super::own_constant::moves_both_ways;
use super::{AmountByLog, Disagreement, SearchState};
use crate::diagnose::evidence::{self, DIFFERS, MOST};
use crate::diagnose::wrench::left::{self, REMAINDER};
use crate::diagnose::wrench::regression::fit::fitted_to;
use crate::diagnose::wrench::regression::gram::dot;
use crate::diagnose::wrench::regression::hypothesis::{Hypothesis, Part, evaluate};
use crate::diagnose::wrench::regression::shaped::Care;
use crate::diagnose::wrench::regression::tested::TestedHypothesis;
use rayon::prelude::*;
use softdock_physics::model::load::Column;
use softdock_physics::model::load::effects::Sign;
use std::collections::{BTreeMap, BTreeSet};

impl Disagreement {
    pub(super) fn new(id: &'static str, each: &[TestedHypothesis]) -> Self {
        // A log of which the fit explains nothing has no amount; the fit hands on the common one.
        let of_log = |own: &TestedHypothesis| {
            let mut effects = own.effects.iter().filter(|_| own.gain > 0.0);
            let effect = effects.find(|effect| effect.id == id);
            effect.map_or_else(BTreeMap::new, |effect| effect.parameters.clone())
        };
        let each: Vec<BTreeMap<_, _>> = each.iter().map(of_log).collect();
        let names = each
            .iter()
            .flat_map(|own| own.iter().filter(|(_, p)| p.sigma > 0.0));
        let names: BTreeSet<(&'static str, &'static str)> =
            names.map(|(name, p)| (*name, p.unit)).collect();
        let values = |name: &str| {
            each.iter()
                .map(|own| own.get(name).map_or(0.0, |p| p.value))
                .collect()
        };
        let amounts = names.into_iter().map(|(name, unit)| AmountByLog {
            name,
            unit,
            values: values(name),
        });
        Self {
            id,
            amounts: amounts.collect(),
        }
    }

    /// Whether one log shows so much more of something than another, by [`DIFFERS`]. A difference is compared with the size of
    /// all amounts in the same unit together: of a weight that hangs to one side either the sine or the cosine is next to
    /// nothing, and may have either sign.
    pub(super) fn differs(&self) -> bool {
        self.units_that_differ().next().is_some()
    }

    /// Whether what differs has the same sign in all logs. A weight that hangs up in one log and down in another fits something
    /// else that is left.
    pub(super) fn is_of_all(&self) -> bool {
        self.units_that_differ().all(|unit| {
            let in_one_sense = |[one, other]: [usize; 2]| self.product(unit, one, other) > 0.0;
            self.pairs().all(in_one_sense)
        })
    }

    fn units_that_differ(&self) -> impl Iterator<Item = &'static str> + '_ {
        let size = |unit: &str, log: usize| self.product(unit, log, log).sqrt();
        let differ = move |values: &[f64], unit: &str, [one, other]: [usize; 2]| {
            let sizes = size(unit, one) + size(unit, other);
            (values[one] - values[other]).powi(2) > DIFFERS * sizes * sizes
        };
        let of = self
            .amounts
            .iter()
            .filter(move |of| self.pairs().any(|pair| differ(&of.values, of.unit, pair)));
        of.map(|amount| amount.unit)
    }

    /// Sum over all amounts in a unit of their products in two logs.
    fn product(&self, unit: &str, one: usize, other: usize) -> f64 {
        let same = self.amounts.iter().filter(|amount| amount.unit == unit);
        same.map(|amount| amount.values[one] * amount.values[other])
            .sum()
    }

    fn pairs(&self) -> impl Iterator<Item = [usize; 2]> + use<> {
        let logs = self.amounts.first().map_or(0, |amount| amount.values.len());
        (0..logs).flat_map(|one| (0..one).map(move |other| [one, other]))
    }
}

impl SearchState<'_> {
    /// Effects about which the logs disagree: amounts of each log's own explain more than common ones. What is left in all logs
    /// even with own amounts is no difference between logs, and then such effects count only in two cases: the answer leaves most
    /// of one log, or own amounts explain most of what is left.
    pub(crate) fn disagreeing(&self, accepted: Option<&TestedHypothesis>) -> Vec<Disagreement> {
        let one = self.of_one_log(accepted);
        let mut all: Vec<Disagreement> = one
            .iter()
            .map(|h| (self.ids(h), self.of_each_log(h)))
            .filter(|(_, each)| is_physical_where_it_shows_most(each) && self.leave_nothing(each))
            .flat_map(|(ids, each)| ids.into_iter().map(move |id| Disagreement::new(id, &each)))
            .collect();
        let Some(accepted) = accepted else {
            return all;
        };
        let differing = self.differing(accepted);
        let leaves_a_log = self.leaves_most_of_a_log(accepted);
        if differing.is_empty() && !leaves_a_log {
            return all;
        }
        let Some(same) = evaluate(self.library, self.parts(accepted), self.price) else {
            return all;
        };
        let each = self.of_each_log(&same);
        let counts = |id: &&&'static str| self.counts(id, &each);
        let of = |id: &&'static str| Disagreement::new(id, &each);
        if leaves_a_log && self.is_of_other_logs(accepted, &each) {
            let ids = accepted.effects_in_order();
            let ids = ids.iter().filter(counts);
            all.extend(ids.map(of).filter(Disagreement::differs));
        } else if self.leave_nothing(&each) {
            let ids = differing.iter().filter(counts);
            all.extend(ids.map(of).filter(Disagreement::differs));
        } else if self.explain_most(accepted, &each) {
            let ids = differing.iter().filter(counts).map(of);
            all.extend(ids.filter(|one| one.differs() && one.is_of_all()));
        }
        all
    }

    /// Whether an effect, with each log's own amounts, does more to the reading of any log than may be left of it without being called
    /// structure.
    fn counts(&self, id: &str, each: &[TestedHypothesis]) -> bool {
        let problem = &self.joint.problem;
        let parts = each.iter().zip(&self.joint.logs).map(|(own, log)| {
            let effect = own.effects.iter().find(|effect| effect.id == id);
            effect.map_or_else(Column::default, |effect| own.part(&log.scene, effect))
        });
        let parts: Vec<Column> = parts.collect();
        let white = problem.whitened(&parts.iter().collect::<Vec<_>>());
        let mut logs = problem.chi2_of_logs.iter().enumerate();
        logs.any(|(log, chi2)| {
            let part = problem.part(&white, log);
            dot(&part, &part) > REMAINDER * chi2
        })
    }

    /// Effects of which one log shows half as much again as the others, in the sense of [`DIFFERS`], with enough evidence for it.
    /// None where common amounts leave no log more than the noise, as a model that agrees with all of them is that of one machine,
    /// and none where a log moves in one direction only: there a friction is a constant.
    fn differing(&self, accepted: &TestedHypothesis) -> Vec<&'static str> {
        let back_and_forth = self.joint.logs.iter().all(moves_both_ways);
        if !back_and_forth || !self.joint.exceeds_noise(accepted) {
            return Vec::new();
        }
        let each = self.joint.contrasts(accepted).into_iter();
        let each = each.zip(&accepted.effects);
        let differing = each.filter(|([own, common], _)| {
            self.says_that_logs_disagree(*own, 1, accepted) && *own > DIFFERS * common
        });
        differing.map(|(_, effect)| effect.id).collect()
    }

    /// Whether `own`, the gain of that many further amounts, is more than errors of form of the common effects may cause.
    pub(super) fn says_that_logs_disagree(
        &self,
        own: f64,
        amounts: usize,
        accepted: &TestedHypothesis,
    ) -> bool {
        let explained = self.joint.explained(accepted.gain);
        evidence::disagree(own, explained, amounts, self.joint.problem.count)
    }

    /// Whether a hypothesis leaves more than [`MOST`] of a log, and nothing was known before it.
    fn leaves_most_of_a_log(&self, accepted: &TestedHypothesis) -> bool {
        let mut logs = self.joint.problem.chi2_of_logs.iter().zip(&accepted.gains);
        self.joint.known <= 0.0 && logs.any(|(chi2, gain)| chi2 - gain > MOST * chi2)
    }

    /// Whether there is a log of which common amounts leave most, and of this rest the log's own amounts of the same effects
    /// explain most. The hypothesis is then about the other logs, whatever else all logs show. Nominal parameters are the same in
    /// all logs.
    fn is_of_other_logs(&self, accepted: &TestedHypothesis, each: &[TestedHypothesis]) -> bool {
        let problem = &self.joint.problem;
        let own = self.gains(each);
        let amounts = accepted.parameters;
        let logs = problem.chi2_of_logs.iter().zip(&accepted.gains);
        let mut logs = logs.zip(own).zip(each);
        logs.any(|(((chi2, common), own), alone)| {
            let (left, more) = (chi2 - common, own - common);
            alone.wrong.is_empty()
                && left > MOST * chi2
                && more > MOST * left
                && self.says_that_logs_disagree(more, amounts, accepted)
        })
    }

    /// Whether own amounts of each log explain most of the χ² that common amounts leave. A machine always leaves something for
    /// which no amounts are the cause.
    fn explain_most(&self, accepted: &TestedHypothesis, each: &[TestedHypothesis]) -> bool {
        let chi2: f64 = self.joint.problem.chi2_of_logs.iter().sum();
        let common: f64 = accepted.gains.iter().sum();
        let more = self.gains(each).iter().sum::<f64>() - common;
        each.iter().all(|own| own.wrong.is_empty()) && more > MOST * (chi2 - common)
    }

    /// By how much χ² of each log falls with amounts of its own.
    fn gains(&self, each: &[TestedHypothesis]) -> Vec<f64> {
        let problem = &self.joint.problem;
        let parts = self.contributions(each);
        problem.gains(&problem.whitened(&parts.iter().collect::<Vec<_>>()))
    }

    /// What the own amounts of each log contribute to its reading.
    fn contributions(&self, each: &[TestedHypothesis]) -> Vec<Column> {
        let parts = each.iter().zip(&self.joint.logs);
        parts
            .map(|(own, log)| own.contribution(&log.scene))
            .collect()
    }

    fn ids(&self, hypothesis: &Hypothesis) -> Vec<&'static str> {
        let variants = hypothesis.parts.iter().map(|p| p.variant);
        variants
            .map(|k| self.library.variants[k].effect.id)
            .collect()
    }

    /// A hypothesis fitted to each log by itself. One entry per log.
    pub(super) fn of_each_log(&self, hypothesis: &Hypothesis) -> Vec<TestedHypothesis> {
        let of = |log: usize| {
            let problem = self.joint.of_rows(|k, _| k == log);
            fitted_to(
                &problem,
                self.library,
                hypothesis,
                self.joint,
                Care::Estimating,
            )
        };
        (0..self.joint.logs.len()).into_par_iter().map(of).collect()
    }

    /// Whether the effects, fitted to each log by itself, leave no structure that all logs show.
    fn leave_nothing(&self, each: &[TestedHypothesis]) -> bool {
        let gain = each.iter().map(|own| own.gain).sum();
        !left::of_wrench_apart(self.joint, &self.contributions(each), gain).any()
    }

    /// The effect that one log alone shows, if it explains more there than the common answer does in all logs: several effects
    /// together can imitate what changes from log to log. `None` for a single log, or for rounded readings, whose steps look
    /// different in each log.
    fn of_one_log(&self, accepted: Option<&TestedHypothesis>) -> Option<Hypothesis> {
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
            .filter(|k| self.details_stand_alone || !detail(k))
            .filter_map(|k| (0..logs).filter_map(|log| alone(k, log)).max_by(better))
            .max_by(better)?;
        let common = accepted.map_or(0.0, |t| t.evidence.max(0.0));
        let explained = accepted.map_or(0.0, |t| t.gain);
        (best.evidence > common + self.joint.threshold(explained)).then_some(best)
    }
}

/// Whether physics allows the amounts of the log that an effect explains most of.
fn is_physical_where_it_shows_most(each: &[TestedHypothesis]) -> bool {
    let most = each.iter().max_by(|a, b| a.gain.total_cmp(&b.gain));
    most.is_some_and(|own| own.wrong.is_empty())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn amount(name: &'static str, unit: &'static str, values: [f64; 2]) -> AmountByLog {
        let values = values.to_vec();
        AmountByLog { name, unit, values }
    }

    fn differs(amounts: &[AmountByLog]) -> bool {
        let of_logs = Disagreement {
            id: "bearing_gravity",
            amounts: amounts.to_vec(),
        };
        of_logs.differs()
    }

    /// In the logs that lack the effect, noise may give it any sign.
    #[test]
    fn physics_has_to_allow_an_effect_in_the_log_that_shows_it() {
        let log = |gain: f64, wrong: &[&str]| TestedHypothesis {
            gain,
            wrong: wrong.iter().map(|w| (*w).to_owned()).collect(),
            ..TestedHypothesis::default()
        };
        let forbidden = ["physics forbids it"];
        assert!(is_physical_where_it_shows_most(&[
            log(900.0, &[]),
            log(3.0, &forbidden)
        ]));
        assert!(!is_physical_where_it_shows_most(&[
            log(3.0, &[]),
            log(900.0, &forbidden)
        ]));
    }

    #[test]
    fn what_all_logs_show_has_one_sense() {
        let weight = |sine: [f64; 2], cosine: [f64; 2]| Disagreement {
            id: "bearing_gravity",
            amounts: vec![amount("sine", "N·m", sine), amount("cosine", "N·m", cosine)],
        };
        assert!(weight([2.0, 1.0], [-0.1, 0.2]).is_of_all());
        assert!(!weight([-0.02, -0.4], [0.32, -1.04]).is_of_all());
        assert!(!weight([2.0, 0.0], [0.1, 0.0]).is_of_all());
        let spring = Disagreement {
            id: "cable_stiffness",
            amounts: vec![
                amount("stiffness", "N/m", [1e3, 2e3]),
                amount("hardening", "N/m^3", [1e6, 1.1e6]),
            ],
        };
        assert!(spring.is_of_all());
    }

    /// Half as much again differs, a third does not; a small cosine beside a sine of 2 N·m does not.
    #[test]
    fn amounts_differ_by_what_all_of_a_unit_are() {
        assert!(differs(&[amount("force_n", "N", [1.0, 1.55])]));
        assert!(!differs(&[amount("force_n", "N", [1.0, 1.3])]));
        assert!(differs(&[amount("force_n", "N", [0.1, -0.1])]));
        let cosine = amount("cosine", "N·m", [-0.3, 0.2]);
        assert!(differs(std::slice::from_ref(&cosine)));
        let sine = |unit: &'static str| amount("sine", unit, [2.0, 1.9]);
        assert!(!differs(&[sine("N·m"), cosine.clone()]));
        assert!(differs(&[sine("N"), cosine]));
    }
}
