//! What a law would explain with the sign that physics forbids it: what pulls where a spring would push is no spring, and
//! looks like one.

use crate::diagnose::catalogue::has;
use crate::diagnose::evidence::MOST;
use crate::diagnose::wrench::Tested;
use crate::diagnose::wrench::regression::joint::Joint;
use softdock_physics::model::Model;
use softdock_physics::model::load::Column;
use softdock_physics::model::load::effects::{LoadEffect, Sign};
use softdock_report::number;

/// A law with a sign that it cannot have.
pub(crate) struct OtherSign {
    /// Id of its effect.
    pub id: &'static str,
    /// Its amount with the unit, in words.
    pub amount: String,
    /// Share of χ² that is left of the reading, and more than noise, that it would explain.
    pub share: f64,
}

/// The law that would explain most of what effects leave, if it does so with a sign that physics forbids it.
pub(crate) fn other_sign(joint: &Joint, accepted: &Tested) -> Option<OtherSign> {
    let model = &joint.logs.first()?.scene.model;
    let known: Vec<Column> = accepted
        .effects
        .iter()
        .map(|one| joint.white_part_of(accepted, one))
        .collect();
    let gain = |columns: &[Column]| {
        let free = vec![Sign::Free; columns.len()];
        joint.problem.solve_whitened(columns, &free)
    };
    let alone = gain(&known).map_or(0.0, |solution| solution.gain);
    if !joint.has_much_left(alone) {
        return None;
    }
    let left = joint.left(alone);
    let with = |(effect, place): (&'static LoadEffect, usize)| -> Option<(f64, OtherSign)> {
        let defaults: Vec<f64> = effect.shapes.iter().map(|shape| shape.tried[0]).collect();
        let own = joint.columns(&joint.problem, effect, &defaults, &[place], &[])?;
        let solution = gain(&[&known[..], &own].concat())?;
        let coefficient = &effect.coefficients[place];
        let value = *solution.coefficients.last()?;
        let more = solution.gain - alone;
        let amount = number::significant(value, 3);
        let one = OtherSign {
            id: effect.id,
            amount: format!("{} = {amount} {}", coefficient.name, coefficient.unit),
            share: (more / left).min(1.0),
        };
        (coefficient.sign == Sign::Positive && value < 0.0 && more > MOST * left)
            .then_some((more, one))
    };
    let best = simple_laws(joint, model, accepted).filter_map(with);
    let best = best.max_by(|a, b| a.0.total_cmp(&b.0));
    best.map(|(_, one)| one)
}

/// Laws without a free shape that are not found yet, with the place of each coefficient that may be there alone.
fn simple_laws(
    joint: &Joint,
    model: &Model,
    accepted: &Tested,
) -> impl Iterator<Item = (&'static LoadEffect, usize)> {
    let is_simple = |effect: &&LoadEffect| {
        let acts = joint.logs.iter().any(|log| effect.acts(&log.scene));
        // Less of what the model has is no other sign.
        acts && !has(model, effect.id)
            && !effect.acts_on_reading()
            && effect.shapes.iter().all(|shape| shape.choice)
    };
    let is_new = |effect: &&LoadEffect| accepted.effects.iter().all(|one| one.id != effect.id);
    let all = LoadEffect::all(model).filter(is_simple).filter(is_new);
    all.flat_map(|effect| {
        let places = 0..effect.coefficients.len();
        let alone = places.filter(|k| (effect.effect.is_whole)(&[*k], &|_| true));
        alone.map(move |place| (effect, place))
    })
}
