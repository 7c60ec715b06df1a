//! An effect whose amount each log has of its own, beside a constant of its own: logs of two machines, each of which hangs at rest
//! elsewhere. What is common to both explains little of either, and a search that begins with common amounts ends at something else.

use super::own_constant::moves_both_ways;
use super::{Disagreement, TRIED, Work};
use crate::diagnose::evidence::{self, MOST};
use crate::diagnose::wrench::regression::hypothesis::{Part, evaluate};
use crate::diagnose::wrench::regression::tested::Tested;
use crate::diagnose::wrench::regression::variants::Variant;
use rayon::prelude::*;
use softdock_physics::model::load::Column;
use softdock_physics::model::load::effects::Sign;

/// An effect with a constant beside it.
struct Beside {
    parts: [Part; 2],
    /// By how much χ² falls with amounts of each log's own, less their price.
    worth: f64,
}

impl Work<'_> {
    /// The effect that explains, in amounts of each log's own, most of what the answer leaves, and of what is left with a common amount
    /// of it. Not asked where the answer leaves no more than noise, nor of logs that move one way alone, where a friction is a constant.
    pub(crate) fn own_effect(&self, accepted: Option<&Tested>) -> Option<Disagreement> {
        let is_left = self.joint.has_much_left(accepted.map_or(0.0, |t| t.gain));
        let back_and_forth = self.joint.logs.iter().all(moves_both_ways);
        if self.joint.logs.len() < 2 || self.joint.is_rounded() || !is_left || !back_and_forth {
            return None;
        }
        let (constants, others): (Vec<usize>, Vec<usize>) =
            (0..self.library.variants.len()).partition(|k| self.variant(*k).effect.is_a_constant());
        let is_asked = |k: &usize| {
            let effect = self.variant(*k).effect;
            !effect.is_late() && (self.any || !effect.effect.is_detail())
        };
        let others = others.into_iter().filter(is_asked);
        let pairs = others.flat_map(|k| constants.iter().map(move |constant| [k, *constant]));
        let pairs: Vec<[usize; 2]> = pairs.collect();
        let found = pairs.into_par_iter();
        let found = found.filter_map(|both| self.in_own_amounts(accepted, both));
        let mut found: Vec<Beside> = found.collect();
        found.sort_by(|a, b| b.worth.total_cmp(&a.worth));
        found.iter().take(TRIED).find_map(|b| self.about(b))
    }

    /// What the logs disagree about, if each alone has an amount of it that is plausible.
    fn about(&self, beside: &Beside) -> Option<Disagreement> {
        let parts = beside.parts.to_vec();
        let effect = self.variant(parts[0].variant).effect;
        let each = self.of_each_log(&evaluate(self.library, parts, self.price)?);
        let found = Disagreement::new(effect.id, &each);
        // Not how much of it the constant takes away, which is where it begins to count.
        let model = &self.joint.logs.first()?.scene.model;
        let amounts = found.amounts.iter();
        let mut amounts =
            amounts.flat_map(|(name, _, values)| values.iter().map(move |v| (name, v)));
        let is_plausible = amounts.all(|(name, v)| !effect.is_implausible(model, name, *v));
        (is_plausible && found.differs() && found.is_of_all()).then_some(found)
    }

    fn variant(&self, place: usize) -> &Variant {
        &self.library.variants[place]
    }

    /// An effect, with all of its amounts or with one, and a constant, all in amounts of each log's own; None where they explain less
    /// than most of what the answer leaves, or of what common amounts of the effect leave.
    fn in_own_amounts(
        &self,
        accepted: Option<&Tested>,
        [effect, constant]: [usize; 2],
    ) -> Option<Beside> {
        let problem = &self.joint.problem;
        let whole = |variant: usize| Part {
            variant,
            used: (0..self.variant(variant).columns.len()).collect(),
        };
        let (all, constant) = (whole(effect), whole(constant));
        let levels = self.signed(&constant, true);
        let gain = |part: &Part, own: bool| {
            let columns = [self.signed(part, own), levels.clone()].concat();
            let (columns, signs): (Vec<Column>, Vec<Sign>) = columns.into_iter().unzip();
            let solution = problem.solve_whitened(&columns, &signs)?;
            (solution.wrong.is_empty() || !own).then_some(solution.gain)
        };
        let alone = all.used.iter().map(|k| Part {
            used: vec![*k],
            ..all.clone()
        });
        let entry = self.variant(effect).effect.effect;
        let is_whole = |part: &Part| (entry.is_whole)(&part.used, &|_| true);
        let tried = alone.filter(is_whole).chain([all.clone()]);
        let logs = self.joint.logs.len();
        let paid = |part: &Part| self.price * (part.used.len() * logs) as f64;
        let tried = tried.filter_map(|part| Some((gain(&part, true)?, part)));
        let worth = |(gain, part): &(f64, Part)| gain - paid(part);
        let (own, part) = tried.max_by(|a, b| worth(a).total_cmp(&worth(b)))?;
        let best = accepted.map_or(0.0, |t| t.gain).max(gain(&part, false)?);
        let chi2: f64 = problem.chi2_of_logs.iter().sum();
        let further = (part.used.len() + constant.used.len()) * (logs - 1);
        let explained = self.joint.explained(accepted.map_or(0.0, |t| t.gain));
        let is_most = own - best > MOST * (chi2 - best);
        let disagree = evidence::disagree(own - best, explained, further, problem.count);
        (is_most && disagree).then_some(Beside {
            worth: own - paid(&part),
            parts: [part, constant],
        })
    }

    /// Columns of a part with their signs, common to all logs or of each log's own: those of an amount follow each other.
    fn signed(&self, part: &Part, own: bool) -> Vec<(Column, Sign)> {
        let variant = self.variant(part.variant);
        let logs = match own {
            true => (0..self.joint.logs.len()).map(Some).collect(),
            false => vec![None],
        };
        let of = |k: &usize| {
            let column = &self.library.columns[variant.columns[*k]];
            let masked = |log: &Option<usize>| {
                let masked = log.map(|log| self.joint.problem.masked(column, log));
                (masked.unwrap_or_else(|| column.clone()), variant.signs[*k])
            };
            logs.iter().map(masked).collect::<Vec<_>>()
        };
        part.used.iter().flat_map(of).collect()
    }
}
