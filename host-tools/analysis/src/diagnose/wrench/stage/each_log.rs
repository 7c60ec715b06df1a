//! Whether the logs are of one machine: effects whose amounts differ, and those that one log alone shows.

use super::Work;
use crate::diagnose::evidence::DIFFERS;
use crate::diagnose::wrench::search::{Hypothesis, Part, evaluate};
use crate::diagnose::wrench::tested::{Care, Tested, fitted_to};
use crate::diagnose::{evidence, structure};
use rayon::prelude::*;
use softdock_physics::model::load::Column;
use softdock_physics::model::load::effects::Sign;
use std::collections::{BTreeMap, BTreeSet};

/// An effect about which the logs disagree.
#[derive(Clone, Debug)]
pub(crate) struct Disagreement {
    /// Its id.
    pub id: &'static str,
    /// Its coefficients with units, as each log alone has them.
    pub amounts: Vec<(&'static str, &'static str, Vec<f64>)>,
}

impl Disagreement {
    fn new(id: &'static str, each: &[Tested]) -> Self {
        let of_log = |own: &Tested| {
            let effect = own.effects.iter().find(|effect| effect.id == id);
            effect.map_or_else(BTreeMap::new, |effect| effect.parameters.clone())
        };
        let each: Vec<BTreeMap<_, _>> = each.iter().map(of_log).collect();
        let names = each
            .iter()
            .flat_map(|own| own.iter().filter(|p| p.1.1 > 0.0));
        let names: BTreeSet<(&str, &str)> = names.map(|(name, p)| (*name, p.2)).collect();
        let values = |name: &str| {
            each.iter()
                .map(|own| own.get(name).map_or(0.0, |p| p.0))
                .collect()
        };
        let amounts = names
            .into_iter()
            .map(|(name, unit)| (name, unit, values(name)));
        Self {
            id,
            amounts: amounts.collect(),
        }
    }
}

impl Work<'_> {
    /// Effects about which the logs disagree: in amounts of its own for each log they explain more. What all logs show
    /// even so is something else, which is of no log alone.
    pub(super) fn disagreeing(&self, accepted: Option<&Tested>) -> Vec<Disagreement> {
        let one = self.of_one_log(accepted);
        let mut all: Vec<Disagreement> = one
            .iter()
            .filter_map(|h| Some((self.ids(h), self.of_each_log(h)?)))
            .flat_map(|(ids, each)| ids.into_iter().map(move |id| Disagreement::new(id, &each)))
            .collect();
        let Some(accepted) = accepted else {
            return all;
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
        let differing = each.filter(|([own, common], _)| {
            evidence::disagree(*own, explained, 1, count) && *own > DIFFERS * common
        });
        let differing: Vec<&str> = differing.map(|(_, effect)| effect.id).collect();
        let of_each_log = || {
            let hypothesis = evaluate(self.library, self.parts(accepted), self.price);
            hypothesis.and_then(|h| self.of_each_log(&h))
        };
        if !differing.is_empty()
            && let Some(each) = of_each_log()
        {
            all.extend(differing.iter().map(|id| Disagreement::new(id, &each)));
        }
        all
    }

    fn ids(&self, hypothesis: &Hypothesis) -> Vec<&'static str> {
        let variants = hypothesis.parts.iter().map(|p| p.variant);
        variants
            .map(|k| self.library.variants[k].effect.id)
            .collect()
    }

    /// The effects as each log alone has them, if these leave no structure that all logs show.
    fn of_each_log(&self, hypothesis: &Hypothesis) -> Option<Vec<Tested>> {
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
        let logs = &self.joint.logs;
        let each: Vec<Tested> = (0..logs.len()).into_par_iter().map(of).collect();
        let parts = each.iter().zip(logs);
        let parts: Vec<Column> = parts
            .map(|(own, log)| own.contribution(&log.scene))
            .collect();
        let gain = each.iter().map(|own| own.gain).sum();
        let left = structure::left_apart(self.joint, &parts, gain);
        (!left.any()).then_some(each)
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
}
