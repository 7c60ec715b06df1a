//! Whether the logs are of one machine: effects whose amounts differ, and those that one log alone shows.

use super::Work;
use crate::diagnose::evidence::DIFFERS;
use crate::diagnose::wrench::prepared_log::PreparedLog;
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
        let differing = each.filter(|([own, common], _)| {
            evidence::disagree(*own, explained, 1, count) && *own > DIFFERS * common
        });
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
}
