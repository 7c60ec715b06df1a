//! What differs from the logs of the fit to those that no fit has seen, where that is most of what is left of these.
//!
//! Whether logs disagree is decided by the noise, in which what changes slowly weighs little, and by what an effect explains: a
//! constant that differs by a twentieth is a disagreement by neither, and can be most of the error on unseen data.

use super::Tested;
use super::fitted::Fitted;
use super::joint::Joint;
use super::prepared_log::PreparedLog;
use super::problem::subtract;
use crate::diagnose::evidence::MOST;
use softdock_physics::model::Model;
use softdock_physics::model::load::Column;
use softdock_physics::model::load::effects::LoadEffect;
use softdock_statistics::dot;

/// A parameter that unseen logs have another value of.
pub(crate) struct LogToLog {
    /// Id of its effect.
    pub effect: &'static str,
    /// Its name and unit.
    pub parameter: (&'static str, &'static str),
    /// Its value in the logs of the fit.
    pub fitted: f64,
    /// Its value in each log that is unseen.
    pub unseen: Vec<f64>,
    /// Error on unseen data with the first, and with the others, in units of the noise.
    pub errors: [f64; 2],
}

/// The parameter that alone, with a value of its own in each unseen log, takes most of what `all` leaves of these; `known`: what
/// the model of the logs has already.
pub(crate) fn from_log_to_log(joint: &Joint, known: &Tested, all: &Tested) -> Option<LogToLog> {
    let unseen = &joint.logs[joint.fitted..];
    let model = &unseen.first()?.scene.model;
    let rests: Vec<Column> = unseen.iter().map(|log| log.rest(known, all)).collect();
    let left: f64 = rests.iter().map(|rest| product(rest, rest)).sum();
    let with_own = |term: &Fitted| {
        let (mut taken, mut shares) = (0.0, Vec::new());
        for (log, rest) in unseen.iter().zip(&rests) {
            let part = log.column(all, term);
            let (both, own) = (product(rest, &part), product(&part, &part));
            taken += if own > 0.0 { both * both / own } else { 0.0 };
            shares.push(if own > 0.0 { both / own } else { 0.0 });
        }
        (taken, shares)
    };
    let terms = all.effects.iter().flat_map(|one| one.terms(model));
    let each = terms.filter_map(|term| Some((with_own(&term), term.amount(model)?, term.id)));
    let ((taken, shares), (name, unit, fitted), effect) =
        each.max_by(|a, b| a.0.0.total_cmp(&b.0.0))?;
    if taken < MOST * left {
        return None;
    }
    let rows: usize = unseen
        .iter()
        .map(|log| log.fresh.iter().filter(|fresh| **fresh).count())
        .sum();
    let rms = |squares: f64| (squares / rows.max(1) as f64).sqrt();
    Some(LogToLog {
        effect,
        parameter: (name, unit),
        fitted,
        unseen: shares.iter().map(|share| fitted * (1.0 + share)).collect(),
        errors: [rms(left), rms(left - taken)],
    })
}

impl Fitted {
    /// Name, unit and value of the coefficient of a term; none of what is not proportional to one: a contact, or what acts on
    /// the reading.
    fn amount(&self, model: &Model) -> Option<(&'static str, &'static str, f64)> {
        let effect = LoadEffect::find(model, self.id)?;
        let is_sum = effect.is_linear() && !effect.acts_on_reading();
        let mut given = effect
            .coefficients
            .iter()
            .filter(|_| is_sum)
            .filter_map(|c| {
                let (value, _, _) = self.parameters.get(c.name)?;
                (*value != 0.0).then_some((c.name, c.unit, *value))
            });
        given.next()
    }
}

impl PreparedLog {
    /// What effects leave of the rows that count, in units of the data sheet's noise; `known`: what the model has of them.
    fn rest(&self, known: &Tested, all: &Tested) -> Column {
        let mut rest = self.residual.clone();
        rest.add(&known.contribution(&self.scene).0);
        subtract(&mut rest, &all.contribution(&self.scene), 1.0);
        self.in_noise(rest)
    }

    /// What a term of a hypothesis does beside what acts on the whole reading, likewise.
    fn column(&self, tested: &Tested, term: &Fitted) -> Column {
        self.in_noise(tested.on_reading(&self.scene, term))
    }

    /// A column in units of the data sheet's noise, 0 in rows that do not count.
    fn in_noise(&self, mut column: Column) -> Column {
        for (series, sigma) in column.0.iter_mut().zip(self.sheet_sigma) {
            let rows = series.iter_mut().zip(&self.fresh);
            rows.for_each(|(value, counts)| *value = if *counts { *value / sigma } else { 0.0 });
        }
        column
    }
}

/// Sum of the products of two columns.
fn product(a: &Column, b: &Column) -> f64 {
    let axes = a.0.iter().zip(&b.0).filter(|(a, b)| a.len() == b.len());
    axes.map(|(a, b)| dot(a, b)).sum()
}
