//! What the reader should know beside the numbers.

use super::contact::{Contacts, noise_of_steps};
use crate::model::prediction::Prediction;
use crate::model::prediction::signals::{Signals, Step, VelocityMeaning};
use crate::model::{Axis, Channel, Model};
use crate::recording::Recording;
use crate::report::number;

/// The model's noise is called too large if the recording shows less than this share of it.
const MUCH_SMALLER: f64 = 0.4;

/// What is special about the recording.
pub(super) fn of_recording(
    recording: &Recording,
    signals: &Signals<'_>,
    contacts: &Contacts,
) -> Vec<String> {
    let mut notes = Vec::new();
    let end_s = signals.cycles.last().map_or(0.0, |c| c.trace.time_s);
    if let Some(why) = &recording.cut {
        notes.push(format!(
            "The recording was cut off ({why}); what is here, up to {end_s:.3} s, is compared."
        ));
    }
    let holes = signals
        .steps
        .iter()
        .skip(1)
        .filter(|s| **s == Step::Hole)
        .count();
    if holes > 0 {
        notes.push(format!(
            "Cycles are missing in {holes} place(s); nothing is predicted there until the past \
             no longer counts."
        ));
    }
    if contacts.list.is_empty() {
        let (threshold_n, peak_n) = (contacts.threshold_n, contacts.peak_n);
        notes.push(format!(
            "No contact was found: the force stays at or below {peak_n:.3} N, and a contact begins \
             at {threshold_n:.3} N, which is well above its noise."
        ));
    }
    notes
}

/// Values of `[noise]` behind which errors hide, because the recording is much quieter.
pub(super) fn too_much_noise(
    model: &Model,
    signals: &Signals<'_>,
    prediction: &Prediction,
) -> Vec<String> {
    let noise = &model.noise;
    let motion = match signals.velocity {
        VelocityMeaning::CycleMean => [
            ("position_m", noise.position_m),
            ("angle_rad", noise.angle_rad),
        ],
        VelocityMeaning::Sampled => [
            ("velocity_m_s", noise.velocity_m_s),
            ("rate_rad_s", noise.rate_rad_s),
        ],
    };
    let load = [("force_n", noise.force_n), ("torque_n_m", noise.torque_n_m)];
    [(Channel::ExecutedVelocity, motion), (Channel::Wrench, load)]
        .into_iter()
        .flat_map(|(channel, keys)| {
            let [linear, angular] = keys;
            [(channel, false, linear), (channel, true, angular)]
        })
        .filter_map(|(channel, rotation, (key, value))| {
            let share = shown_share(prediction, channel, rotation)?;
            (share < MUCH_SMALLER).then(|| {
                format!(
                    "noise.{key} is {} in the model and about {} in the recording: errors between \
                     the two are taken for noise here. Write the smaller value to see them.",
                    number::significant(value, 3),
                    number::significant(value * share, 2)
                )
            })
        })
        .collect()
}

/// Noise that a channel shows, as a share of what is expected: that of the noisiest axis.
fn shown_share(prediction: &Prediction, channel: Channel, rotation: bool) -> Option<f64> {
    let values = prediction.channel(channel);
    let axes = prediction.judged(channel).iter();
    axes.filter(|axis| axis.is_rotation() == rotation)
        .filter_map(|axis: &Axis| {
            let relative: Vec<f64> = (0..values.predicted.len())
                .filter_map(|n| Some(values.residual(n, *axis)? / values.expected_sigma(n, *axis)))
                .collect();
            (relative.len() > 1).then(|| noise_of_steps(relative.into_iter()))
        })
        .max_by(f64::total_cmp)
}
