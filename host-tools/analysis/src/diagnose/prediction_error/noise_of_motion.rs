//! What noise of the acceleration does to a mass or an inertia that follows from it.
//!
//! A regression on a noisy quantity finds too small a factor: where a share λ of the squared acceleration is noise, it finds 1 − λ of
//! what moves (errors in variables; Fuller 1987, Measurement Error Models, section 1.1).

use super::error_reduction::{SubsetPredictions, without};
use super::foresight::off_by;
use crate::diagnose::evidence::{DROWNED, RUNS_OFF, STAYS};
use crate::diagnose::named::{NamedEffect, with_effects};
use softdock_io::recording::Recording;
use softdock_physics::effects::by_id;
use softdock_physics::model::prediction::Prediction;
use softdock_physics::model::prediction::signals::Signals;
use softdock_physics::model::{Axis, Channel, EffectModel, Model};

/// Why a mass or an inertia is not named.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Drowned {
    /// Share of noise in the squared acceleration.
    Noise(f64),
    /// How far the simulated motion is off without and with it, relative to the motion.
    RunsOff([f64; 2]),
}

impl SubsetPredictions<'_> {
    /// Removes a mass or an inertia that follows from an acceleration which is mostly noise: by the noise of the model file, or by
    /// what noise of another kind leads to, so little mass that the simulated motion [runs off](RUNS_OFF) and is [closer](STAYS)
    /// without the effect.
    pub(super) fn without_drowned(
        &mut self,
        effects: &mut Vec<usize>,
    ) -> anyhow::Result<Vec<(String, Drowned)>> {
        let mut gone = Vec::new();
        for k in effects.clone() {
            if MovedInertia::of(self.model, &self.all[k].effect).is_none() {
                continue;
            }
            let others = without(effects, k);
            let share = self.share_of_noise(effects, k)?;
            let off = [&others, &*effects].map(|effects| {
                let model = with_effects(self.model, effects.iter().map(|k| &self.all[*k]));
                off_by(&model, self.recordings.test())
            });
            let drowned = match off {
                _ if share > DROWNED => Drowned::Noise(share),
                [Some(less), Some(with)] if with > RUNS_OFF && with > STAYS * less => {
                    Drowned::RunsOff([less, with])
                }
                _ => continue,
            };
            gone.push((self.all[k].effect.id.clone(), drowned));
            *effects = others;
            self.refit(effects)?;
        }
        Ok(gone)
    }

    /// Widens the intervals of what follows from the acceleration by what noise takes of it. Returns ids with the share of noise.
    pub(super) fn widened_by_noise(
        &mut self,
        effects: &[usize],
    ) -> anyhow::Result<Vec<(String, f64)>> {
        let mut widened = Vec::new();
        for &k in effects {
            let share = self.share_of_noise(effects, k)?;
            if let Some(moved) = MovedInertia::of(self.model, &self.all[k].effect) {
                moved.widen(&mut self.all[k], share);
                widened.push((self.all[k].effect.id.clone(), share));
            }
        }
        Ok(widened)
    }

    /// See [`MovedInertia::share_of_noise`]; 0 for an effect that is no mass and no inertia.
    fn share_of_noise(&mut self, effects: &[usize], k: usize) -> anyhow::Result<f64> {
        let Some(moved) = MovedInertia::of(self.model, &self.all[k].effect) else {
            return Ok(0.0);
        };
        let model = with_effects(self.model, effects.iter().map(|k| &self.all[*k]));
        let predictions = self.predicted(effects)?;
        moved.share_of_noise(&model, self.recordings.train(), predictions.train())
    }
}

/// Mass that moves along a single axis, kg, or moment of inertia about it, kg·m², by a model and an effect that corrects it.
pub(super) struct MovedInertia {
    axis: Axis,
    /// The parameter of the effect.
    name: &'static str,
    nominal: f64,
    /// Nominal value and correction.
    whole: f64,
}

impl MovedInertia {
    /// `None` if several axes move, or the effect is no correction of what moves.
    pub(super) fn of(model: &Model, effect: &EffectModel) -> Option<Self> {
        let [axis] = model.rig.active_axes[..] else {
            return None;
        };
        let (nominal, unit) = match axis.is_rotation() {
            true => (model.inertia_about_bearing(), "kg·m²"),
            false => (model.tool.mass_kg, "kg"),
        };
        let mut parameters = by_id(&effect.id)?.parameters.iter();
        // Only a correction of a nominal value may be negative.
        let correction = parameters.find(|p| p.of_the_tool < 0.0 && p.unit == unit)?;
        let correction_of = effect.parameters.get(correction.name)?;
        Some(Self {
            axis,
            name: correction.name,
            nominal,
            whole: nominal + correction_of,
        })
    }

    /// Share of noise in the squared acceleration of some logs, from 0 to 1. The noise is that of the model file, through the
    /// differences and the filter of the log; of noise that is less there than at higher frequencies this is too much, and what
    /// the predictions leave of the wrench bounds it: they leave at least the noise times what moves.
    fn share_of_noise(
        &self,
        model: &Model,
        recordings: &[&Recording],
        predictions: &[Prediction],
    ) -> anyhow::Result<f64> {
        let axis = self.axis.index();
        let (mut noise, mut all, mut left) = (0.0, 0.0, 0.0);
        for (recording, prediction) in recordings.iter().zip(predictions) {
            let signals = Signals::new(recording)?;
            let (_, sigma) = signals.motion_sigma(model);
            let wrench = prediction.channel(Channel::Wrench);
            for n in 0..signals.len() {
                let motion = signals.motion(n).zip(wrench.residual(n, self.axis));
                let Some((motion, residual)) = motion else {
                    continue;
                };
                noise += sigma[axis].powi(2);
                all += motion.acceleration.get()[axis].powi(2);
                left += residual.powi(2);
            }
        }
        let at_most = left / self.whole.powi(2);
        match all > 0.0 {
            true => Ok((noise.min(at_most) / all).min(1.0)),
            false => Ok(0.0),
        }
    }

    /// Widens the interval of the correction so that it holds what moves if the noise has taken its share. Of a share above
    /// [`DROWNED`] the log bounds nothing.
    fn widen(&self, named: &mut NamedEffect, share: f64) {
        let estimate = named.estimates.get(self.name).cloned();
        let Some(estimate) = estimate.filter(|_| share <= DROWNED) else {
            return;
        };
        let most = (self.nominal + estimate.high) / (1.0 - share) - self.nominal;
        let ends = [estimate.low, estimate.high.max(most)];
        *named = named
            .clone()
            .within(self.name, estimate.value, ends, &estimate.unit);
    }
}
