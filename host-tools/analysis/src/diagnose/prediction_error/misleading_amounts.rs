//! Amounts of a named effect that fit the logs of the fit and mislead on others.

use super::error_reduction::SubsetPredictions;
use crate::diagnose::evidence::{FORETELLS, RISES};

impl SubsetPredictions<'_> {
    /// Leaves out amounts of effects whose amounts are independent (the cosine of a weight that hangs straight, say) if the unseen
    /// logs are predicted better without and the logs of the fit about as well. Returns the ids and names, with the error on
    /// unseen data with and without each.
    pub(super) fn without_misleading_amounts(
        &mut self,
        effects: &[usize],
    ) -> anyhow::Result<Vec<(String, String, [f64; 2])>> {
        let mut left_out = Vec::new();
        if !self.can_foretell {
            return Ok(left_out);
        }
        for &k in effects {
            // Of one that is left nothing could be taken.
            while let Some((name, errors)) = self.most_misleading_amount(effects, k)? {
                self.leave_out(effects, k, name)?;
                let id = self.found[k].effect.id.clone();
                left_out.push((id, name.to_owned(), errors));
            }
        }
        Ok(left_out)
    }

    /// The amount without which the unseen logs are predicted best, if better than with it, and the error on them with and without.
    fn most_misleading_amount(
        &mut self,
        effects: &[usize],
        k: usize,
    ) -> anyhow::Result<Option<(&'static str, [f64; 2])>> {
        let with = self.levels(effects)?;
        let mut best: Option<(&'static str, [f64; 2])> = None;
        for name in self.found[k].independent_amounts(self.model) {
            let kept = (self.found[k].clone(), self.all.clone(), self.refitted);
            self.leave_out(effects, k, name)?;
            let less = self.levels(effects)?;
            (self.found[k], self.all, self.refitted) = kept;
            self.predictions.clear();
            let least = best.map_or(with.test / RISES, |(_, [_, least])| least);
            if less.test < least && less.train < FORETELLS * with.train {
                best = Some((name, [with.test, less.test]));
            }
        }
        Ok(best)
    }

    fn leave_out(&mut self, effects: &[usize], k: usize, name: &str) -> anyhow::Result<()> {
        self.found[k].leave_out(name);
        self.all[k].leave_out(name);
        self.predictions.clear();
        self.refit(effects)
    }
}
