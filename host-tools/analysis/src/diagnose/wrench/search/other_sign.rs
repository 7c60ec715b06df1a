//! Laws that would explain the rest of the reading with a sign that physics forbids. What pulls where a spring would push is no
//! spring, but looks like one. A commanded load that comes after the motion would have a negative delay.

use crate::diagnose::catalogue::has;
use crate::diagnose::evidence::{Foretold, MOST};
use crate::diagnose::wrench::regression::joint::Joint;
use crate::diagnose::wrench::{Fitted, FittedParameter, TestedHypothesis};
use softdock_physics::model::Model;
use softdock_physics::model::load::Column;
use softdock_physics::model::load::effects::{LoadEffect, Sign};
use softdock_physics::optimise::brent;
use softdock_report::number;
use std::collections::BTreeMap;

/// A law with a sign that it cannot have.
pub(crate) struct OtherSign {
    /// Id of its effect.
    pub id: &'static str,
    /// Its amount with the unit, in words.
    pub amount: String,
    /// Share of the χ² beyond the noise that is left of the reading, which it would explain.
    pub share: f64,
}

/// The simple law that would explain most of what effects leave, with a sign that physics forbids. `None` if it explains less
/// than [`MOST`] of that, or little is left.
pub(crate) fn other_sign(joint: &Joint, accepted: &TestedHypothesis) -> Option<OtherSign> {
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
    let left = joint.remaining_chi2(alone);
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

/// A commanded load that comes after the motion that it should cause.
pub(crate) struct AfterMotion {
    /// Time by which it is late, s.
    pub late_s: f64,
    /// Share of the squared residual of the reading that this would explain.
    pub share: f64,
}

/// By how much a commanded load comes after the motion, if that would explain most ([`MOST`]) of what effects leave.
pub(crate) fn after_motion(joint: &Joint, accepted: &TestedHypothesis) -> Option<AfterMotion> {
    /// Relative precision of the delay.
    const RESOLVED: f64 = 0.01;
    let model = &joint.logs.first()?.scene.model;
    let delay = LoadEffect::all(model).find(|effect| effect.is_a_delay())?;
    let shape = delay.shapes.first()?;
    let acts = joint.logs.iter().any(|log| delay.acts(&log.scene));
    if !acts || !model.sensor.wrench.is_commanded() || accepted.effects.is_empty() {
        return None;
    }
    let left = |late_s: f64| {
        let mut with = accepted.clone();
        with.effects.push(Fitted {
            beside_remainder: 1.0,
            elsewhere: BTreeMap::new(),
            foretold: Foretold::UNKNOWN,
            id: delay.id,
            parameters: BTreeMap::from([(
                shape.name,
                FittedParameter {
                    value: -late_s,
                    sigma: 0.0,
                    unit: shape.unit,
                },
            )]),
        });
        joint.squares_left(&with)
    };
    let tried = delay.tried_values(shape, joint.pace());
    let each = tried.iter().map(|late_s| left(*late_s)).enumerate();
    let (best, _) = each.min_by(|a, b| a.1.total_cmp(&b.1))?;
    let low = best.checked_sub(1).map_or(0.0, |before| tried[before]);
    let high = tried.get(best + 1).copied().unwrap_or(tried[best]);
    let tolerance = RESOLVED * tried[best];
    let (late_s, least) = brent((low, tried[best], high), tolerance, left);
    let share = 1.0 - least / joint.squares_left(accepted);
    (share > MOST).then_some(AfterMotion { late_s, share })
}

/// Laws without a free shape that act on these logs and are not found yet, with the place of each coefficient that may stand
/// alone.
fn simple_laws(
    joint: &Joint,
    model: &Model,
    accepted: &TestedHypothesis,
) -> impl Iterator<Item = (&'static LoadEffect, usize)> {
    let is_simple = |effect: &&LoadEffect| {
        let acts = joint.logs.iter().any(|log| effect.is_tried_on(&log.scene));
        // Less of what the model has already is no wrong sign.
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
