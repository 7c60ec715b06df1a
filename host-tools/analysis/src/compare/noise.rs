//! The noise that the recording itself shows, compared with the data sheet.

use super::Source;
use super::regime::quantity;
use serde::Serialize;
use softdock_physics::model::prediction::signals::VelocityMeaning;
use softdock_physics::model::{Axis, Channel};
use softdock_report::number;
use softdock_statistics::{Noise, noise_floor};

/// Range of measured / data sheet in which the data sheet is confirmed.
const RIGHT: (f64, f64) = (0.4, 1.6);
/// Steps of the measurement above this multiple of the noise are reported.
const COARSE: f64 = 2.0;
/// A measurement comes in steps if it has so many times fewer different values than values.
const REPEAT: usize = 10;
/// How well a mistake of units has to explain the ratio, as a factor.
const UNITS_WITHIN: f64 = 1.4;

/// Measured noise against the data sheet's.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum NoiseVerdict {
    /// They agree.
    AsDataSheet,
    /// The recording is much noisier.
    Noisier,
    /// The recording is much quieter: smaller errors than the data sheet's noise are not seen.
    Quieter,
    /// The measurement comes in steps that are larger than the noise.
    Coarse,
}

/// Noise of one measured axis.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct NoiseLevel {
    /// Channel.
    pub channel: Channel,
    /// Axis.
    pub axis: Axis,
    /// One standard deviation out of the measurement itself, in the channel's unit.
    pub measured: f64,
    /// One standard deviation by `[noise]` of the model.
    pub data_sheet: f64,
    /// `measured / data_sheet`.
    pub ratio: f64,
    /// Resolution of the measurement, in its unit, where it is coarser than the noise.
    pub step: Option<f64>,
    /// Conclusion from `ratio` and `step`.
    pub verdict: NoiseVerdict,
}

/// Noise of all measured axes; the model's velocity is computed and has none.
pub(super) fn of_axes(source: &Source<'_>) -> Vec<NoiseLevel> {
    let noise = &source.model.noise;
    let of_poses = source.signals.velocity == VelocityMeaning::CycleMean;
    let filter = source.model.sensor.filter;
    let filter = filter.map(|filter| filter.on_samples(source.prediction.cycle_s));
    let mut levels = Vec::new();
    for channel in [Channel::ExecutedVelocity, Channel::Wrench, Channel::Pose] {
        let values = source.prediction.channel(channel);
        let kind = if channel == Channel::ExecutedVelocity && of_poses {
            Noise::Differenced
        } else {
            Noise::White
        };
        // A wrench that drives the motion, or is zero by definition, was not measured.
        if channel == Channel::Wrench && source.model.sensor.wrench.drives() {
            continue;
        }
        for axis in source.prediction.judged(channel) {
            let i = axis.index();
            let data_sheet = match (channel, axis.is_rotation()) {
                (Channel::Pose, false) => noise.position_m,
                (Channel::Pose, true) => noise.angle_rad,
                _ => values.sigma[i],
            };
            let measured: Vec<f64> = fresh(source, channel, i);
            let step = resolution(&measured);
            if let Some(measured) = noise_floor(&measured, kind, filter) {
                let ratio = measured / data_sheet;
                let step = step.filter(|step| *step > COARSE * data_sheet);
                levels.push(NoiseLevel {
                    channel,
                    axis: *axis,
                    measured,
                    data_sheet,
                    ratio,
                    step,
                    verdict: match step {
                        Some(_) => NoiseVerdict::Coarse,
                        None => verdict(ratio),
                    },
                });
            }
        }
    }
    levels
}

/// Measured values of an axis without repeated samples.
fn fresh(source: &Source<'_>, channel: Channel, axis: usize) -> Vec<f64> {
    let sampled = |n: usize| match channel {
        Channel::Wrench => source.signals.sampled_in(n),
        _ => Some(n),
    };
    let measured = source.prediction.channel(channel).measured.iter();
    measured
        .enumerate()
        .filter(|(n, _)| sampled(*n).is_some() && (*n == 0 || sampled(*n) != sampled(n - 1)))
        .map(|(_, v)| v[axis])
        .collect()
}

/// Smallest step between different values; None if values hardly repeat, or are all equal.
fn resolution(values: &[f64]) -> Option<f64> {
    let mut sorted: Vec<f64> = values.iter().copied().filter(|v| v.is_finite()).collect();
    sorted.sort_by(f64::total_cmp);
    let range = sorted.last()? - sorted.first()?;
    // Steps that are smaller differ by the rounding of a decimal number.
    let steps: Vec<f64> = sorted
        .windows(2)
        .map(|w| w[1] - w[0])
        .filter(|step| *step > 1e-6 * range)
        .collect();
    let repeat = !steps.is_empty() && steps.len() < sorted.len() / REPEAT;
    repeat.then(|| steps.into_iter().fold(f64::INFINITY, f64::min))
}

fn verdict(ratio: f64) -> NoiseVerdict {
    if ratio < RIGHT.0 {
        NoiseVerdict::Quieter
    } else if ratio > RIGHT.1 {
        NoiseVerdict::Noisier
    } else {
        NoiseVerdict::AsDataSheet
    }
}

/// Notes on values of `[noise]` that the recording contradicts on all axes to which they apply.
pub(super) fn notes(source: &Source<'_>, levels: &[NoiseLevel]) -> Vec<String> {
    let of_poses = source.signals.velocity == VelocityMeaning::CycleMean;
    [
        (Channel::ExecutedVelocity, false, "velocity_m_s"),
        (Channel::ExecutedVelocity, true, "rate_rad_s"),
        (Channel::Wrench, false, "force_n"),
        (Channel::Wrench, true, "torque_n_m"),
        (Channel::Pose, false, "position_m"),
        (Channel::Pose, true, "angle_rad"),
    ]
    .into_iter()
    // A velocity made from poses has no noise of its own.
    .filter(|(channel, ..)| !(of_poses && *channel == Channel::ExecutedVelocity))
    .filter_map(|(channel, rotation, key)| {
        let axes: Vec<&NoiseLevel> = levels
            .iter()
            .filter(|l| l.channel == channel && l.axis.is_rotation() == rotation)
            .collect();
        if let Some((level, step)) = axes.iter().find_map(|l| Some((l, l.step?))) {
            return Some(in_steps(key, level, step));
        }
        let noisiest = axes.iter().max_by(|a, b| a.ratio.total_cmp(&b.ratio))?;
        let quietest = axes.iter().min_by(|a, b| a.ratio.total_cmp(&b.ratio))?;
        match (verdict(noisiest.ratio), verdict(quietest.ratio)) {
            (NoiseVerdict::Quieter, _) => Some(too_large(key, noisiest)),
            (_, NoiseVerdict::Noisier) => Some(too_small(key, quietest)),
            _ => None,
        }
    })
    .collect()
}

fn too_large(key: &str, level: &NoiseLevel) -> String {
    format!(
        "noise.{key} is {} in the model and about {} in the recording: errors between the two \
         are taken for noise here. Write the smaller value to see them{}.",
        number::significant(level.data_sheet, 3),
        number::significant(level.measured, 2),
        units(key, 1.0 / level.ratio)
    )
}

fn too_small(key: &str, level: &NoiseLevel) -> String {
    format!(
        "noise.{key} is {} in the model and about {} in the recording: part of the error is \
         noise that the model does not allow for. Find out why, or write the larger value{}.",
        number::significant(level.data_sheet, 3),
        number::significant(level.measured, 2),
        units(key, level.ratio)
    )
}

fn in_steps(key: &str, level: &NoiseLevel, step: f64) -> String {
    let (channel, axis) = (level.channel, level.axis);
    let unit = channel.unit(axis);
    format!(
        "{channel} {axis} comes in steps of {}, and noise.{key} is {}: the steps alone make an \
         error of {} rms.",
        quantity(step, unit),
        quantity(level.data_sheet, unit),
        quantity(step / 12.0_f64.sqrt(), unit)
    )
}

/// The confusion of units that explains a factor, in words; empty if there is none.
fn units(key: &str, factor: f64) -> String {
    let (mistake, words) = match key {
        "position_m" | "velocity_m_s" => (1e3, "millimetres for metres"),
        "torque_n_m" => (1e3, "N·mm for N·m"),
        "angle_rad" | "rate_rad_s" => (180.0 / std::f64::consts::PI, "degrees for radians"),
        _ => return String::new(),
    };
    let off = factor / mistake;
    if off < UNITS_WITHIN && off > 1.0 / UNITS_WITHIN {
        format!(" (the factor is that of {words}: check the units of the import)")
    } else {
        String::new()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn factors_of_units_are_recognised() {
        assert!(units("position_m", 1100.0).contains("millimetres"));
        assert!(units("rate_rad_s", 50.0).contains("degrees"));
        assert_eq!(units("force_n", 1000.0), "");
        assert_eq!(units("velocity_m_s", 5.0), "");
        assert_eq!(units("velocity_m_s", f64::NAN), "");
    }

    #[test]
    fn steps_are_found_and_decimals_are_none() {
        let values = |step: f64| -> Vec<f64> {
            let smooth = (0..2000).map(|n| 40.0 * (f64::from(n) * 0.377).sin());
            smooth.map(|v| (v / step).round() * step).collect()
        };
        let step = resolution(&values(3.1)).unwrap();
        assert!((step - 3.1).abs() < 1e-9, "{step}");
        assert_eq!(resolution(&values(1e-4)), None);
        assert_eq!(resolution(&[1.0; 100]), None);
        assert_eq!(resolution(&[]), None);
    }

    #[test]
    fn verdicts_follow_the_ratio() {
        let cases = [
            (1.0, NoiseVerdict::AsDataSheet),
            (3.0, NoiseVerdict::Noisier),
            (0.1, NoiseVerdict::Quieter),
            (0.0, NoiseVerdict::Quieter),
        ];
        for (ratio, expected) in cases {
            assert_eq!(verdict(ratio), expected);
        }
    }
}
