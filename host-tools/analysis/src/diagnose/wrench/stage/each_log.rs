//! Whether the logs are of one machine: effects whose amounts differ, and those that one log alone shows.

use super::Work;
use crate::diagnose::evidence::FORETELLS;
use crate::diagnose::wrench::problem::Problem;
use crate::diagnose::wrench::search::{Hypothesis, Part, evaluate};
use crate::diagnose::wrench::tested::{Care, Tested, fitted_to};
use crate::diagnose::{evidence, structure};
use rayon::prelude::*;
use softdock_physics::model::load::Column;
use softdock_physics::model::load::effects::Sign;

impl Work<'_> {
    /// Effects about which the logs disagree: in amounts of its own for each log they explain more. What all logs show
    /// even so is something else, which is of no log alone.
    pub(super) fn disagreeing(&self, accepted: Option<&Tested>) -> Vec<&'static str> {
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

    /// Whether effects that are fitted to each log alone leave no structure that all logs show, and much less of the unseen
    /// logs than those that are fitted to the others: errors of form, which differ with the motion, are no other machine.
    fn explains_each_log(&self, hypothesis: &Hypothesis) -> bool {
        let fitted_to = |problem: &Problem| {
            let care = Care::Estimating;
            fitted_to(problem, self.library, hypothesis, self.joint, care)
        };
        let logs = self.joint.logs.par_iter().enumerate();
        let of_log = |(log, _)| fitted_to(&self.joint.of_rows(|k, _| k == log));
        let each: Vec<Tested> = logs.map(of_log).collect();
        let of_unseen = self.joint.error_on_unseen_of(|log| &each[log]);
        let foretold = self.joint.error_on_unseen(&fitted_to(self.of_fit));
        let all_fitted = self.joint.fitted == self.joint.logs.len();
        if !all_fitted && foretold < FORETELLS * of_unseen {
            return false;
        }
        let both = each.iter().zip(&self.joint.logs);
        let own: Vec<Column> = both
            .map(|(own, log)| own.contribution(&log.scene))
            .collect();
        let gain = each.iter().map(|own| own.gain).sum();
        !structure::left_apart(self.joint, &own, gain).any()
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
