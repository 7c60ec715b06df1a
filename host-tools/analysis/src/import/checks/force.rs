//! Does the force belong to the motion? Sign and size of a force column, for logs of a moved axis.
//!
//! A sensor between robot and tool feels a force that resists the motion: `F = −m a − c v − d sign(v) + f(x)` with a mass, a
//! viscous and a dry friction that are not negative, and a load f that depends on the place, as that of a weight on its angle.
//! The coefficients are fitted to the log by least squares. Their standard errors count values that are correlated in time as
//! fewer.

use super::Context;
use nalgebra::{DVector, Matrix2, Matrix6, Vector2, Vector6};
use softdock_app::record::CycleRecord;
use softdock_control::modes::Mode;
use softdock_io::recording::Recording;
use softdock_physics::model::load::count_turns;
use softdock_physics::model::log::is_same_force;
use softdock_physics::model::prediction::signals::Signals;
use softdock_physics::model::{Axis, Channel, Model};
use softdock_report::number;
use softdock_statistics::{DEVIATIONS_95, correlated_cycles, normal_p};
use statrs::distribution::{ChiSquared, ContinuousCDF};
use std::f64::consts::TAU;

/// p-value below which a term counts. A wrong hint costs more than a missing one.
const LEVEL: f64 = 1e-6;
/// Terms of the wrong sign have to explain so many times the variance that those of the right sign explain.
const OUTWEIGHS: f64 = 9.0;
/// Terms are not told apart if an eigenvalue of their correlation matrix is below this.
const COLLINEAR: f64 = 1e-4;
/// Dry friction is modelled as linear in the velocity below this share of the highest speed, and constant above.
const STICKS: f64 = 0.01;
/// A mass is known better than by this factor; a wrong scale is farther off.
const FACTOR: f64 = 1.5;
/// Least share of the moving rows in either direction. Motion in one direction shows no friction that differs from a load that
/// depends on the place.
const BOTH_WAYS: f64 = 0.05;

/// Fitted terms that resist a motion.
struct Fitted {
    friction: Term,
    mass: Term,
    /// Force per acceleration and its standard error, kg.
    per_acceleration: (f64, f64),
}

/// A part of the force.
struct Term {
    /// Variance of the force that the term explains, N² or (N·m)²; negative if it resists the motion.
    drives: f64,
    /// Probability by chance.
    p: f64,
}

/// Appends a warning for each axis whose force looks wrong.
pub(super) fn check(recording: &Recording, context: &Context<'_>, warnings: &mut Vec<String>) {
    let Some(signals) = applies(recording, context) else {
        return;
    };
    for axis in Axis::ALL {
        let hint = constant(&signals, axis).filter(|_| context.imports);
        warnings.extend(hint.map(|hint| format!("{}: {hint}", context.name)));
        let Some((rows, fitted)) = fitted(&signals, axis) else {
            continue;
        };
        if !has_wrong_sign(&fitted, &rows, axis) {
            let hint = wrong_size(&fitted, axis, context.model);
            warnings.extend(hint.map(|hint| format!("{}: {hint}", context.name)));
        }
    }
}

/// What all logs of a machine, by name, say of the signs of its forces: a warning for each log in which one drives the motion, or
/// one warning where others say the opposite.
pub fn signs(logs: &[(&str, &Recording)], model: Option<&Model>) -> Vec<String> {
    let context = Context::of_model(model);
    let signals = logs
        .iter()
        .filter_map(|(name, recording)| Some((*name, applies(recording, &context)?)));
    let signals: Vec<(&str, Signals<'_>)> = signals.collect();
    let mut warnings = Vec::new();
    for axis in Axis::ALL {
        let (mut driven, mut resisted) = (Vec::new(), Vec::new());
        for (name, signals) in &signals {
            match fitted(signals, axis) {
                Some((rows, fitted)) if has_wrong_sign(&fitted, &rows, axis) => driven.push(*name),
                Some((rows, fitted)) if resists_everywhere(&fitted, &rows, axis) => {
                    resisted.push(*name)
                }
                _ => {}
            }
        }
        if driven.is_empty() || resisted.is_empty() {
            warnings.extend(
                driven
                    .iter()
                    .map(|name| format!("{name}: {}", wrong_sign(axis))),
            );
        } else {
            warnings.push(contradiction(
                axis,
                &driven.join(", "),
                &resisted.join(", "),
            ));
        }
    }
    warnings
}

/// The rows of an axis, and what was fitted to them. `None` if they are too few, or M is turned against C so that velocity and force
/// are not along the same axis.
fn fitted(signals: &Signals<'_>, axis: Axis) -> Option<(Vec<Row>, Fitted)> {
    let mut cycles = signals.cycles.iter();
    let is_along = cycles.all(|c| is_parallel(&c.trace.pose[3..], axis));
    let rows = rows(signals, axis).filter(|_| is_along)?;
    let fitted = fit(&rows)?;
    Some((rows, fitted))
}

/// What is said first of logs in each of which a force of the same axis drives the motion, as the beginning of a sentence.
pub(crate) fn said_first(model: &Model, recordings: &[&Recording]) -> Option<String> {
    let context = Context::of_model(Some(model));
    let drives = |recording: &Recording, axis: Axis| -> Option<bool> {
        let (rows, fitted) = fitted(&applies(recording, &context)?, axis)?;
        Some(has_wrong_sign(&fitted, &rows, axis))
    };
    let in_all = |axis: &&Axis| {
        let mut all = recordings.iter();
        !recordings.is_empty() && all.all(|recording| drives(recording, **axis) == Some(true))
    };
    let axis = model.rig.active_axes.iter().find(in_all)?;
    let (what, key) = named(*axis);
    Some(format!(
        "First see to the sign of {what} {key}, which drives the motion instead of resisting it"
    ))
}

/// The signals of a log in which nothing but the load of the motion is on the sensor: the loop is
/// open (a closed one moves with the force) and nothing is touched.
pub(super) fn applies<'a>(recording: &'a Recording, context: &Context<'_>) -> Option<Signals<'a>> {
    let model_applies = |model: &Model| {
        let contact = &model.contact;
        let touches = !contact.walls.is_empty() || contact.guide.is_some();
        !touches && is_parallel(&model.sensor.orientation_wxyz, Axis::X)
    };
    let foreign = recording.header.settings_toml.trim().is_empty();
    let cycles = &recording.cycles;
    let open = cycles.iter().all(|c| c.trace.mode != Mode::Running);
    let wanted = foreign && open && !context.at_rest() && context.model.is_none_or(model_applies);
    Signals::new(recording).ok().filter(|_| wanted)
}

/// A load that never changes, of an axis that moves.
fn constant(signals: &Signals<'_>, axis: Axis) -> Option<String> {
    let i = axis.index();
    let cycles = &signals.cycles;
    let value = cycles.first()?.inputs.sensor.wrench[i];
    let same = |c: &CycleRecord| is_same_force(value, c.inputs.sensor.wrench[i]);
    let moves = cycles.iter().any(|c| c.trace.executed_velocity[i] != 0.0);
    let ((what, key), unit) = (named(axis), Channel::Wrench.unit(axis));
    (value != 0.0 && moves && cycles.iter().all(same)).then(|| {
        format!(
            "{what} {key} is {} {unit} in every row: what resists the motion shows in the acceleration alone, and its noise \
             counts as error; a log in which the load changes shows more",
            number::significant(value, 3)
        )
    })
}

/// What is measured on an axis, and its key in a mapping.
fn named(axis: Axis) -> (&'static str, String) {
    match axis.is_rotation() {
        true => ("torque", format!("{axis}").replace('r', "t")),
        false => ("force", format!("f{axis}")),
    }
}

/// Whether an orientation is the identity, as far as a component of the wrench depends on it: for a force entirely; for a torque
/// up to a rotation about its axis.
fn is_parallel(wxyz: &[f64], axis: Axis) -> bool {
    /// Cosine of half of the angle between both.
    const NEARLY: f64 = 0.9999;
    let about = |i: usize| if axis.is_rotation() { wxyz[i - 2] } else { 0.0 };
    wxyz[0].hypot(about(axis.index())) > NEARLY
}

/// Place of the axis in each cycle, m, or rad with whole turns; NaN where it is not known.
fn places(signals: &Signals<'_>, axis: Axis) -> Vec<f64> {
    let i = axis.index();
    let place = |n: usize| {
        let pose = signals.pose(n)?;
        Some(match axis.is_rotation() {
            true => pose.rotation.scaled_axis()[i - 3],
            false => pose.translation.vector[i],
        })
    };
    let mut places: Vec<f64> = (0..signals.len())
        .map(|n| place(n).unwrap_or(f64::NAN))
        .collect();
    if axis.is_rotation() {
        let ahead = |n: usize| signals.turned_by_velocity(n)[i - 3];
        count_turns(places.iter_mut().zip((0..).map(ahead)));
    }
    places
}

/// One row of the regression.
#[derive(Clone, Copy)]
struct Row {
    /// Regressors: two functions of the place, velocity, its sign, acceleration, 1.
    terms: Vector6<f64>,
    /// The force, N or N·m.
    force: f64,
    /// The place, m, or rad with whole turns.
    at: f64,
}

// Indices of the regressors.
const VELOCITY: usize = 2;
const DRY: usize = 3;
const ACCELERATION: usize = 4;
const CONSTANT: usize = 5;

/// Rows of the regression for an axis. None if there are too few, or nearly all move in one direction.
fn rows(signals: &Signals<'_>, axis: Axis) -> Option<Vec<Row>> {
    let i = axis.index();
    let highest = (0..signals.len())
        .filter_map(|n| Some(signals.velocity_at_pose(n)?.get()[i].abs()))
        .fold(0.0, f64::max);
    let places = places(signals, axis);
    let known = places.iter().filter(|at| at.is_finite());
    let middle = known.clone().sum::<f64>() / known.count().max(1) as f64;
    let row = |n: usize| -> Option<Row> {
        let at = places[n];
        let from_middle = at - middle;
        let [sloped, bent] = match axis.is_rotation() {
            true => [from_middle.sin(), from_middle.cos()],
            false => [from_middle, from_middle * from_middle],
        };
        let v = signals.velocity_at_pose(n)?.get()[i];
        let dry = (v / (STICKS * highest)).clamp(-1.0, 1.0);
        let a = signals.acceleration_at_pose(n).get()[i];
        let force = signals.cycles[n].inputs.sensor.wrench[i];
        let terms = Vector6::new(sloped, bent, v, dry, a, 1.0);
        (force.is_finite() && at.is_finite()).then_some(Row { terms, force, at })
    };
    let own = (0..signals.len()).filter(|n| signals.has_own_acceleration(*n));
    let rows: Vec<Row> = own.filter_map(row).collect();
    let [back, forth] = [-1.0, 1.0].map(|sign| {
        let moves = rows.iter().filter(|row| sign * row.terms[DRY] >= 1.0);
        moves.count() as f64
    });
    let one_way = back.min(forth) < BOTH_WAYS * (back + forth);
    let too_few = rows.len() < 10 * Vector6::<f64>::zeros().len();
    (highest != 0.0 && !one_way && !too_few).then_some(rows)
}

/// Scales regressors to mean zero and variance one; the constant stays as it is.
struct Standard {
    mean: Vector6<f64>,
    scale: Vector6<f64>,
}

impl Standard {
    /// None if a term is the same in all rows.
    fn new(rows: &[Row]) -> Option<Self> {
        let count = rows.len() as f64;
        let sum_of = |of: &dyn Fn(&Vector6<f64>) -> Vector6<f64>| {
            rows.iter()
                .fold(Vector6::zeros(), |sum, row| sum + of(&row.terms))
        };
        let mut mean = sum_of(&|t| *t) / count;
        let squares = sum_of(&|t| (t - mean).component_mul(&(t - mean)));
        let mut scale = (squares / count).map(f64::sqrt);
        (mean[CONSTANT], scale[CONSTANT]) = (0.0, 1.0);
        (!scale.iter().any(|s| *s <= 0.0)).then_some(Self { mean, scale })
    }

    fn of(&self, terms: &Vector6<f64>) -> Vector6<f64> {
        (terms - self.mean).component_div(&self.scale)
    }
}

/// Rows that are not near an end of the travel. Something that turns by more than a turn has no end: all rows.
fn inner(rows: &[Row], axis: Axis) -> Vec<Row> {
    /// Share of the travel at either end.
    const END: f64 = 0.1;
    let range = |(low, high): (f64, f64), row: &Row| (low.min(row.at), high.max(row.at));
    let (low, high) = rows.iter().fold((f64::INFINITY, f64::NEG_INFINITY), range);
    if axis.is_rotation() && high - low > TAU {
        return rows.to_vec();
    }
    let away = END * (high - low);
    let is_inner = |row: &&Row| row.at > low + away && row.at < high - away;
    rows.iter().filter(is_inner).copied().collect()
}

/// Least squares along one axis; None where terms are missing or cannot be told apart.
fn fit(rows: &[Row]) -> Option<Fitted> {
    let standard = Standard::new(rows)?;
    let count = rows.len() as f64;
    let (mut matrix, mut right) = (Matrix6::zeros(), Vector6::zeros());
    for row in rows {
        let terms = standard.of(&row.terms);
        matrix += terms * terms.transpose();
        right += terms * row.force;
    }
    if (matrix / count).symmetric_eigenvalues().min() < COLLINEAR {
        return None;
    }
    let inverse = matrix.try_inverse()?;
    let coefficients = inverse * right;
    let left = rows
        .iter()
        .map(|row| row.force - standard.of(&row.terms).dot(&coefficients));
    let left = DVector::from_iterator(rows.len(), left);
    let parameters = coefficients.len() as f64;
    let variance = left.norm_squared() / (count - parameters) * correlated_cycles(left.as_slice());
    let covariance = inverse * variance;
    let error = covariance[(ACCELERATION, ACCELERATION)].sqrt();
    let mass = coefficients[ACCELERATION];
    let scale = standard.scale[ACCELERATION];
    Some(Fitted {
        friction: friction(&coefficients, &covariance, &(matrix / count))?,
        mass: Term {
            drives: mass.signum() * mass * mass,
            p: normal_p(mass / error.max(f64::MIN_POSITIVE)),
        },
        per_acceleration: (mass / scale, error / scale),
    })
}

/// Viscous and dry friction as one term. Where the speed varies little from stroke to stroke the two cannot be told apart, but
/// together they differ from zero. The term drives if its force has the sign of the velocity on average.
fn friction(
    coefficients: &Vector6<f64>,
    covariance: &Matrix6<f64>,
    correlations: &Matrix6<f64>,
) -> Option<Term> {
    let both = |of: &Matrix6<f64>| -> Matrix2<f64> {
        of.fixed_view::<2, 2>(VELOCITY, VELOCITY).into_owned()
    };
    let amounts = Vector2::new(coefficients[VELOCITY], coefficients[DRY]);
    let correlated = both(correlations) * amounts;
    let squares = amounts.dot(&(both(covariance).try_inverse()? * amounts));
    Some(Term {
        drives: correlated[0].signum() * amounts.dot(&correlated),
        p: ChiSquared::new(2.0).ok()?.sf(squares),
    })
}

/// Whether friction or mass would be negative. A collision with an end stop brakes more than was measured, so that this has to show
/// away from the ends as well.
fn has_wrong_sign(fitted: &Fitted, rows: &[Row], axis: Axis) -> bool {
    drives(fitted) && fit(&inner(rows, axis)).is_some_and(|fitted| drives(&fitted))
}

/// The opposite of [`has_wrong_sign`].
fn resists_everywhere(fitted: &Fitted, rows: &[Row], axis: Axis) -> bool {
    resists(fitted) && fit(&inner(rows, axis)).is_some_and(|fitted| resists(&fitted))
}

/// Whether terms that drive the motion explain far more than those that resist it.
fn drives(fitted: &Fitted) -> bool {
    let (wrong, right) = explained(fitted);
    wrong > OUTWEIGHS * right
}

/// The opposite of [`drives`].
fn resists(fitted: &Fitted) -> bool {
    let (wrong, right) = explained(fitted);
    right > OUTWEIGHS * wrong
}

/// Variances that significant terms which drive the motion explain, and those which resist it.
fn explained(fitted: &Fitted) -> (f64, f64) {
    let told = [&fitted.friction, &fitted.mass]
        .into_iter()
        .filter(|term| term.p < LEVEL);
    let (drive, resist): (Vec<f64>, Vec<f64>) = told
        .map(|term| term.drives)
        .partition(|drives| *drives > 0.0);
    (drive.iter().sum::<f64>(), -resist.iter().sum::<f64>())
}

/// The warning of a wrong sign.
fn wrong_sign(axis: Axis) -> String {
    let (what, key) = named(axis);
    format!(
        "{what} {key} drives the motion instead of resisting it: mass and friction would be negative \
         (p < {LEVEL:e}). A sensor between robot and tool feels the opposite, and so does softdock of a drive; \
         reverse the sign of its `scale` in [wrench] of the mapping (`{key} = {{ column = .., scale = -1.0 }}` if it has none)"
    )
}

/// The warning of logs that contradict each other.
fn contradiction(axis: Axis, driven: &str, resisted: &str) -> String {
    let (what, key) = named(axis);
    format!(
        "{what} {key} resists the motion in {resisted}; it drives it in {driven}: mass and friction would be negative there (p < {LEVEL:e}). \
         Either its sign is not the same in these logs, or something else moved the machine where it drives, such as a hand: then leave \
         those rows out, with [rows] of the mapping"
    )
}

/// A warning if the force is much larger or smaller than the model's mass needs.
fn wrong_size(fitted: &Fitted, axis: Axis, model: Option<&Model>) -> Option<String> {
    let tool = &model?.tool;
    if axis.is_rotation()
        || !tool.dynamic_compensation
        || tool.mass_kg <= 0.0
        || fitted.mass.p > LEVEL
    {
        return None;
    }
    let (factor, half) = (
        -fitted.per_acceleration.0 / tool.mass_kg,
        DEVIATIONS_95 * fitted.per_acceleration.1 / tool.mass_kg,
    );
    let far = factor - half > FACTOR || factor + half < 1.0 / FACTOR;
    // On a slow slide the corners of the friction look like a mass of any sign; only a positive one hints at wrong units.
    (far && factor > 0.0).then(|| {
        let word = |value: f64| number::significant(value, 3);
        format!(
            "force f{axis} is {} times what the model's {} kg need for the acceleration (95 %: {} to {}): \
             are these other units? A `scale` {} times as large for f{axis} in [wrench] of the mapping would make \
             them agree, as another `mass_kg` in [tool] of the model or, of the position, another `unit` would",
            word(factor),
            tool.mass_kg,
            word(factor - half),
            word(factor + half),
            word(1.0 / factor)
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Strokes of nearly one speed: each friction alone is 2.5 deviations from zero, but both together are not zero.
    #[test]
    fn frictions_that_are_not_told_apart_are_told_from_nothing() {
        const SPREAD: f64 = 0.1;
        let coefficients = Vector6::new(0.0, 0.0, 0.25, 0.25, 0.0, 0.0);
        let (mut covariance, mut correlations) = (Matrix6::identity(), Matrix6::identity());
        let both = Matrix2::new(1.0, -0.95, -0.95, 1.0) * (SPREAD * SPREAD);
        covariance
            .fixed_view_mut::<2, 2>(VELOCITY, VELOCITY)
            .copy_from(&both);
        correlations[(VELOCITY, DRY)] = 0.95;
        correlations[(DRY, VELOCITY)] = 0.95;
        let alone = normal_p(coefficients[DRY] / SPREAD);
        let driving = friction(&coefficients, &covariance, &correlations).unwrap();
        assert!(alone > 0.01 && driving.p < LEVEL && driving.drives > 0.2);
        let resisting = friction(&-coefficients, &covariance, &correlations).unwrap();
        assert!(resisting.p < LEVEL && resisting.drives < -0.2);
    }
}
