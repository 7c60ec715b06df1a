//! A parameter that differs between the logs of the fit and the unseen ones, where that is most of the error that is left.
//!
//! Whether logs disagree is decided by likelihood, which gives slow changes little weight, and relative to what an effect
//! explains. By neither is a constant that differs by a twentieth a disagreement, but it can be most of the error on unseen data.

use crate::compare::TOLERATED_NOISE;
use crate::diagnose::evidence::MOST;
use crate::diagnose::logs::Logs;
use crate::diagnose::named::NamedEffect;
use softdock_io::recording::Recording;
use softdock_physics::model::load::effects::{LoadEffect, Sign};
use softdock_physics::model::prediction::{Prediction, predict};
use softdock_physics::model::{Axis, Channel, Model};
use softdock_statistics::dot;

/// A parameter with another value in each unseen log.
pub(crate) struct LogToLog {
    /// Id of its effect.
    pub effect: String,
    /// Name and unit of the parameter.
    pub parameter: (&'static str, &'static str),
    /// Its value in the logs of the fit.
    pub fitted: f64,
    /// The value that fits each unseen log.
    pub unseen: Vec<f64>,
    /// Error of the wrench on unseen data, in units of the noise: with the fitted value, and with the own values.
    pub errors: [f64; 2],
}

/// The parameter that would remove most of the unseen error of the wrench if it had a value of its own in each unseen log.
/// `after` are the predictions of `model`. `None` where only noise is left, or no parameter would remove more than [`MOST`].
pub(crate) fn from_log_to_log(
    model: &Model,
    recordings: &Logs<&Recording>,
    after: &Logs<Prediction>,
    named: &[&NamedEffect],
) -> Option<LogToLog> {
    let logs = after.fitted..after.all.len();
    let unseen = Unseen {
        model,
        rests: after.all[logs.clone()].iter().map(rest).collect(),
        recordings: &recordings.all[logs],
    };
    let left: f64 = unseen.rests.iter().map(|rest| dot(rest, rest)).sum();
    let count = unseen.rests.iter().map(Vec::len).sum::<usize>().max(1) as f64;
    let rms = |squares: f64| (squares.max(0.0) / count).sqrt();
    if rms(left) <= TOLERATED_NOISE {
        return None;
    }
    let coefficients = named.iter().flat_map(|one| {
        let id = one.effect.id.as_str();
        // Effects that move or scale the whole reading, and contacts, are not proportional to their parameters.
        let effect = LoadEffect::find(model, id).filter(|e| e.is_linear() && !e.acts_on_reading());
        let coefficients = effect.into_iter().flat_map(|effect| &effect.coefficients);
        coefficients.map(move |coefficient| (one, coefficient))
    });
    let each = coefficients.filter_map(|(one, coefficient)| {
        let fitted = *one.effect.parameters.get(coefficient.name)?;
        let (taken, own) = unseen.with_own(&one.effect.id, coefficient.name, fitted)?;
        let is_possible = coefficient.sign != Sign::Positive || own.iter().all(|v| *v >= 0.0);
        (is_possible && taken > MOST * left).then(|| LogToLog {
            effect: one.effect.id.clone(),
            parameter: (coefficient.name, coefficient.unit),
            fitted,
            unseen: own,
            errors: [rms(left), rms(left - taken)],
        })
    });
    each.min_by(|a, b| a.errors[1].total_cmp(&b.errors[1]))
}

/// The unseen logs, and the whitened residuals of the wrench of each.
struct Unseen<'a> {
    model: &'a Model,
    recordings: &'a [&'a Recording],
    rests: Vec<Vec<f64>>,
}

impl Unseen<'_> {
    /// By how much χ² falls with a value of its own in each log, and these values. `value` is that of the model. `None` if the
    /// parameter does nothing on a log.
    fn with_own(&self, effect: &str, name: &str, value: f64) -> Option<(f64, Vec<f64>)> {
        /// Relative change of the value for the derivative; the contribution is proportional to it.
        const CHANGE: f64 = 0.01;
        let mut changed = self.model.clone();
        let one = changed.effects.iter_mut().find(|one| one.id == effect)?;
        *one.parameters.get_mut(name)? *= 1.0 + CHANGE;
        let (mut taken, mut values) = (0.0, Vec::new());
        for (recording, before) in self.recordings.iter().zip(&self.rests) {
            let after = rest(&predict(&changed, recording).ok()?);
            let both = before.iter().zip(&after);
            let part: Vec<f64> = both.map(|(b, a)| (b - a) / CHANGE).collect();
            let (both, own) = (dot(before, &part), dot(&part, &part));
            if before.len() != after.len() || own <= 0.0 {
                return None;
            }
            taken += both * both / own;
            values.push(value * (1.0 + both / own));
        }
        Some((taken, values))
    }
}

/// What is left of the wrench, in units of the noise.
fn rest(prediction: &Prediction) -> Vec<f64> {
    let channel = prediction.channel(Channel::Wrench);
    let of_axis = |axis: &Axis| {
        let (axis, sigma) = (*axis, channel.sigma[axis.index()]);
        let rows = 0..prediction.time_s.len();
        rows.filter_map(move |n| Some(channel.residual(n, axis)? / sigma))
    };
    prediction
        .judged(Channel::Wrench)
        .iter()
        .flat_map(of_axis)
        .collect()
}
