//! A constant whose value differs from log to log.

use super::{Disagreement, SearchState};
use crate::diagnose::evidence::MOST;
use crate::diagnose::wrench::regression::hypothesis::{Part, evaluate};
use crate::diagnose::wrench::regression::prepared_log::PreparedLog;
use crate::diagnose::wrench::regression::tested::TestedHypothesis;
use softdock_physics::model::Axis;
use softdock_physics::model::load::Column;
use softdock_physics::model::load::effects::{LoadEffect, Sign};

/// By how much χ² falls with a constant for each log.
struct OwnConstants {
    /// Further fall against one common constant.
    more: f64,
    /// χ² that is left with common constants.
    left: f64,
    /// Further fall if each log also gets a slope in time.
    slopes: f64,
}

impl SearchState<'_> {
    /// A constant of each log's own, if it explains most of what effects leave: a zero that was set anew, or a weight in another
    /// pose. The common part of such constants may be nothing, so that other effects are found in their place, or are refused, as
    /// they foretell no other log. `None` if a log moves in one direction only: there a friction is a constant, too.
    pub(crate) fn own_constant(&self, accepted: &TestedHypothesis) -> Option<Disagreement> {
        /// If slopes explain this share of what is left beside the constants, they are no constants: of a random walk a slope
        /// explains three fifths of what its mean leaves. Set by hand.
        const SLOPE: f64 = 0.25;
        let library = self.library;
        if !self.joint.logs.iter().all(moves_both_ways) {
            return None;
        }
        let of = |place: usize| {
            let variant = &library.variants[place];
            let columns = variant.columns.iter().map(|k| &library.columns[*k]);
            let columns: Vec<&Column> = columns.collect();
            let OwnConstants { more, left, slopes } = self.own_constants(accepted, &columns)?;
            let amounts = columns.len() * (self.joint.logs.len() - 1);
            let is_most = more > MOST * left && slopes < SLOPE * (left - more);
            (is_most && self.says_that_logs_disagree(more, amounts, accepted))
                .then_some((more, place))
        };
        let all = 0..library.variants.len();
        let constants = all.filter(|k| library.variants[*k].effect.is_a_constant());
        let most = constants.filter_map(of);
        let (_, place) = most.max_by(|a, b| a.0.total_cmp(&b.0))?;
        let id = library.variants[place].effect.id;
        let mut parts = self.parts(accepted);
        if !accepted.effects.iter().any(|one| one.id == id) {
            parts.push(Part {
                variant: place,
                used: (0..library.variants[place].columns.len()).collect(),
            });
        }
        let with_it = evaluate(library, parts, self.price)?;
        let found = Disagreement::new(id, &self.of_each_log(&with_it));
        found.differs().then_some(found)
    }

    /// What constants of each log's own explain beside a hypothesis. `constants` are the whitened columns of the common ones.
    fn own_constants(
        &self,
        tested: &TestedHypothesis,
        constants: &[&Column],
    ) -> Option<OwnConstants> {
        let effects = tested.effects.iter();
        // A constant that the hypothesis has already would repeat these columns.
        let effects = effects.filter(|one| !self.is_a_constant(one.id));
        let parts: Vec<Column> = effects
            .map(|one| self.joint.white_part_of(tested, one))
            .collect();
        let own = |columns: &[&Column]| -> Vec<Column> {
            let logs = 0..self.joint.logs.len();
            let each = logs.flat_map(|log| columns.iter().map(move |c| (*c, log)));
            each.map(|(c, log)| self.joint.problem.masked(c, log))
                .collect()
        };
        let gain = |with: &[&Column]| {
            let columns: Vec<&Column> = parts.iter().chain(with.iter().copied()).collect();
            let free = vec![Sign::Free; columns.len()];
            Some(self.joint.problem.solve_whitened(&columns, &free)?.gain)
        };
        let ramps: Vec<Column> = Axis::ALL.iter().map(|axis| self.ramp(*axis)).collect();
        let ramps: Vec<&Column> = ramps
            .iter()
            .filter(|c| !c.0.iter().all(Vec::is_empty))
            .collect();
        let (levels, slopes) = (own(constants), own(&ramps));
        let (levels, common) = (levels.iter().collect::<Vec<_>>(), gain(constants)?);
        let with_levels = gain(&levels)?;
        let with_slopes = gain(&levels.into_iter().chain(&slopes).collect::<Vec<_>>())?;
        Some(OwnConstants {
            more: with_levels - common,
            left: self.joint.problem.chi2 - common,
            slopes: with_slopes - with_levels,
        })
    }

    fn is_a_constant(&self, id: &str) -> bool {
        let model = self.joint.logs.first().map(|log| &log.scene.model);
        let load = model.and_then(|model| LoadEffect::find(model, id));
        load.is_some_and(LoadEffect::is_a_constant)
    }

    /// A ramp from −0.5 to 0.5 over each log on one axis, whitened; empty for an axis that was not recorded.
    fn ramp(&self, axis: Axis) -> Column {
        let of = |log: &PreparedLog| {
            let mut ramp = Column::default();
            let rows = log.residual.0[axis.index()].len();
            let at = |n: usize| n as f64 / rows as f64 - 0.5;
            ramp.0[axis.index()] = (0..rows).map(at).collect();
            ramp
        };
        let of_logs: Vec<Column> = self.joint.logs.iter().map(of).collect();
        self.joint
            .problem
            .whitened(&of_logs.iter().collect::<Vec<_>>())
    }
}

/// Whether each axis of a log moves in both directions, or not at all.
pub(super) fn moves_both_ways(log: &PreparedLog) -> bool {
    /// Least share of the way that goes back. Set by hand.
    const BACK: f64 = 0.1;
    let mut ways = [[0.0; 2]; 6];
    for motion in log.scene.motion.iter() {
        for (way, velocity) in ways.iter_mut().zip(motion.velocity.get()) {
            way[usize::from(velocity < 0.0)] += velocity.abs();
        }
    }
    ways.iter()
        .all(|[there, back]| there.min(*back) >= BACK * (there + back))
}
