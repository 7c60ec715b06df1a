//! An effect whose amount differs from log to log, beside a constant that differs as well: logs of two machines, each of which is
//! at rest at another position. Their common part explains little of either log, and a search that begins with common amounts
//! ends elsewhere.

use super::own_constant::moves_both_ways;
use super::{Disagreement, SearchState, TRIED};
use crate::diagnose::evidence::{self, MOST};
use crate::diagnose::wrench::regression::hypothesis::{Part, evaluate};
use crate::diagnose::wrench::regression::problem::{Projected, best_gain, products};
use crate::diagnose::wrench::regression::tested::TestedHypothesis;
use crate::diagnose::wrench::regression::variants::Variant;
use nalgebra::DVector;
use rayon::prelude::*;
use softdock_physics::model::load::effects::Sign;

/// An effect with a constant beside it.
struct Beside {
    parts: [Part; 2],
    /// Fall of χ² with own amounts for each log, less the price of these.
    worth: f64,
}

/// The columns of each amount of an effect, with sign constraints: one column for all logs, or one for each log.
struct Amounts {
    part: Part,
    columns: Vec<Vec<(Projected, Sign)>>,
}

impl Amounts {
    /// Columns of the amounts in `used`.
    fn of(&self, used: &[usize]) -> impl Iterator<Item = (&Projected, Sign)> {
        let columns = used.iter().flat_map(|k| &self.columns[*k]);
        columns.map(|(column, sign)| (column, *sign))
    }
}

impl SearchState<'_> {
    /// The effect whose own amounts for each log explain most of what the answer leaves, and most of what a common amount of it
    /// would leave. `None` for a single log, for rounded readings, where the answer leaves no more than noise, and where a log
    /// moves in one direction only, as a friction is a constant there.
    pub(crate) fn own_effect(&self, accepted: Option<&TestedHypothesis>) -> Option<Disagreement> {
        let is_left = self.joint.has_much_left(accepted.map_or(0.0, |t| t.gain));
        let back_and_forth = self.joint.logs.iter().all(moves_both_ways);
        if self.joint.logs.len() < 2 || self.joint.is_rounded() || !is_left || !back_and_forth {
            return None;
        }
        let (constants, others): (Vec<usize>, Vec<usize>) =
            (0..self.library.variants.len()).partition(|k| self.variant(*k).effect.is_a_constant());
        let is_asked = |k: &usize| {
            let effect = self.variant(*k).effect;
            !effect.is_late() && (self.details_stand_alone || !effect.effect.is_detail())
        };
        let others: Vec<usize> = others.into_iter().filter(is_asked).collect();
        let levels: Vec<Amounts> = constants
            .into_iter()
            .map(|constant| self.amounts(constant, true))
            .collect();
        let found = others.into_par_iter().flat_map_iter(|effect| {
            let both = [true, false].map(|own| self.amounts(effect, own));
            let of = |levels| self.in_own_amounts(accepted, &both, levels);
            levels.iter().filter_map(of).collect::<Vec<_>>()
        });
        let mut found: Vec<Beside> = found.collect();
        found.sort_by(|a, b| b.worth.total_cmp(&a.worth));
        found.iter().take(TRIED).find_map(|b| self.about(b))
    }

    /// What the logs disagree about, if the amount is plausible in each log.
    fn about(&self, beside: &Beside) -> Option<Disagreement> {
        let parts = beside.parts.to_vec();
        let effect = self.variant(parts[0].variant).effect;
        let each = self.of_each_log(&evaluate(self.library, parts, self.price)?);
        let found = Disagreement::new(effect.id, &each);
        // The effect alone is asked, and not the constant, which only says where the effect begins to count.
        let model = &self.joint.logs.first()?.scene.model;
        let amounts = found.amounts.iter();
        let mut amounts =
            amounts.flat_map(|amount| amount.values.iter().map(move |v| (amount.name, v)));
        let is_plausible = amounts.all(|(name, v)| !effect.is_implausible(model, name, *v));
        (is_plausible && found.differs() && found.is_of_all()).then_some(found)
    }

    fn variant(&self, place: usize) -> &Variant {
        &self.library.variants[place]
    }

    /// An effect, with all of its amounts or one of them, and a constant, all with own amounts for each log. `None` where they
    /// explain less than most of what the answer leaves, or of what common amounts of the effect leave.
    fn in_own_amounts(
        &self,
        accepted: Option<&TestedHypothesis>,
        [own, common]: &[Amounts; 2],
        levels: &Amounts,
    ) -> Option<Beside> {
        let problem = &self.joint.problem;
        let (all, constant) = (own.part.clone(), levels.part.clone());
        let gain = |part: &Part, amounts: &Amounts| {
            let columns = amounts.of(&part.used).chain(levels.of(&constant.used));
            let (columns, signs): (Vec<&Projected>, Vec<Sign>) = columns.unzip();
            let right = DVector::from_iterator(columns.len(), columns.iter().map(|c| c.right));
            let places: Vec<usize> = (0..columns.len()).collect();
            let solution = best_gain(&products(&columns), &right, &places, &signs)?;
            Some((solution.gain, solution.wrong.is_empty()))
        };
        let alone = all.used.iter().map(|k| Part {
            used: vec![*k],
            ..all.clone()
        });
        let entry = self.variant(all.variant).effect.effect;
        let is_whole = |part: &Part| (entry.is_whole)(&part.used, &|_| true);
        let tried = alone.filter(is_whole).chain([all.clone()]);
        let logs = self.joint.logs.len();
        let paid = |part: &Part| self.price * (part.used.len() * logs) as f64;
        let tried = tried.filter_map(|part| {
            let (gain, is_allowed) = gain(&part, own)?;
            is_allowed.then_some((gain, part))
        });
        let worth = |(gain, part): &(f64, Part)| gain - paid(part);
        let (own, part) = tried.max_by(|a, b| worth(a).total_cmp(&worth(b)))?;
        let (of_common, _) = gain(&part, common)?;
        let best = accepted.map_or(0.0, |t| t.gain).max(of_common);
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

    /// The columns of all amounts of an effect, common to all logs or one for each log.
    fn amounts(&self, variant: usize, own: bool) -> Amounts {
        let problem = &self.joint.problem;
        let logs: Vec<Option<usize>> = match own {
            true => (0..self.joint.logs.len()).map(Some).collect(),
            false => vec![None],
        };
        let Variant { columns, signs, .. } = self.variant(variant);
        let of = |(column, sign): (&usize, &Sign)| {
            let column = &self.library.columns[*column];
            let masked = |log: &Option<usize>| {
                let masked = log.map(|log| problem.masked(column, log));
                (
                    problem.projected(masked.unwrap_or_else(|| column.clone())),
                    *sign,
                )
            };
            logs.iter().map(masked).collect()
        };
        Amounts {
            part: Part {
                variant,
                used: (0..columns.len()).collect(),
            },
            columns: columns.iter().zip(signs).map(of).collect(),
        }
    }
}
