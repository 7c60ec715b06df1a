//! Does the acceleration follow from the motion, or from its noise?

use super::Context;
use super::force::applies;
use crate::diagnose::evidence::DROWNED;
use softdock_io::recording::Recording;
use softdock_physics::model::prediction::signals::Signals;
use softdock_physics::model::{Axis, Model};
use softdock_report::number;
use softdock_statistics::{NoiseBand, incoherent_band, noise_band};

/// Share of noise in the square of an acceleration from which a warning says so: the noise then makes a tenth of the inertial force,
/// as much as a model of a real machine usually leaves. An inertia is found too small by the share itself (errors in variables).
const SHARE: f64 = 0.01;

/// The acceleration of an axis, as far as it is noise.
struct Noisy {
    axis: Axis,
    /// The log holds a force or torque that changes; otherwise the noise is known by its spectrum alone.
    driven: bool,
    from_hz: f64,
    /// See [`NoiseBand::share`].
    share: f64,
}

/// A warning if the acceleration of some of the logs of an import, by name, is noise: of the log with most of it.
pub fn noise(logs: &[(&str, &Recording)], model: Option<&Model>) -> Option<String> {
    let context = Context::of_model(model);
    let of = |(name, recording): &(&'_ str, &Recording)| {
        let noisy = Noisy::worst(&applies(recording, &context)?, &Axis::ALL)?;
        (noisy.share > SHARE).then(|| (name.to_string(), noisy))
    };
    let each = logs.iter().filter_map(of);
    let (name, worst) = each.max_by(|(_, a), (_, b)| a.share.total_cmp(&b.share))?;
    Some(format!(
        "{name}: {}: such noise hides an inertia, or makes it look like a delay. [filter] of the mapping with `cutoff_hz = {}` \
         cuts it off",
        worst.said(),
        worst.cutoff_hz()
    ))
}

/// What is said first of logs in each of which the acceleration of an axis is [mostly](DROWNED) noise, as the beginning of a
/// sentence.
pub(crate) fn said_first(model: &Model, recordings: &[&Recording]) -> Option<String> {
    let context = Context::of_model(Some(model));
    let of = |recording: &&Recording| {
        let noisy = Noisy::worst(&applies(recording, &context)?, &model.rig.active_axes)?;
        (noisy.share > DROWNED).then_some(noisy)
    };
    let all = recordings.iter().map(of).collect::<Option<Vec<_>>>()?;
    let worst = all.iter().max_by(|a, b| a.share.total_cmp(&b.share))?;
    Some(format!(
        "First filter the motion: {}. With `cutoff_hz = {}` in [filter] of an import the answer may be another",
        worst.said(),
        worst.cutoff_hz()
    ))
}

impl Noisy {
    /// Of the axis with the largest share of noise in its acceleration.
    fn worst(signals: &Signals<'_>, axes: &[Axis]) -> Option<Self> {
        let each = axes.iter().filter_map(|axis| Self::of(signals, *axis));
        each.max_by(|a, b| a.share.total_cmp(&b.share))
    }

    /// Of the longest part of a log without gaps. `None` also of the motion of a drive that only follows a velocity.
    fn of(signals: &Signals<'_>, axis: Axis) -> Option<Self> {
        let i = axis.index();
        let row = |n: usize| {
            let motion = signals
                .motion(n)
                .filter(|_| signals.has_own_acceleration(n))?;
            Some([
                motion.acceleration.get()[i],
                signals.cycles[n].inputs.sensor.wrench[i],
            ])
        };
        let rows: Vec<Option<[f64; 2]>> = (0..signals.len()).map(row).collect();
        let parts = rows.split(Option::is_none);
        let longest: Vec<[f64; 2]> = parts
            .max_by_key(|part| part.len())?
            .iter()
            .flatten()
            .copied()
            .collect();
        let [acceleration, force] =
            [0, 1].map(|of| longest.iter().map(|row| row[of]).collect::<Vec<f64>>());
        let driven = force.iter().any(|f| (f - force[0]).abs() > 0.0);
        let band = match driven {
            true => incoherent_band(&acceleration, &force),
            false if signals.commanded => None,
            false => noise_band(&acceleration, signals.noise_of_acceleration()),
        };
        let NoiseBand { from, share } = band?;
        Some(Self {
            axis,
            driven,
            from_hz: from / signals.cycle_s,
            share,
        })
    }

    fn cutoff_hz(&self) -> String {
        number::significant(self.from_hz, 2)
    }

    fn said(&self) -> String {
        let (along, force) = match self.axis.is_rotation() {
            true => ("about", "torque"),
            false => ("along", "force"),
        };
        let why = match self.driven {
            true => format!("where it does not follow the {force}"),
            false => "where it is noise".to_owned(),
        };
        format!(
            "{:.0} % of the square of the acceleration {along} {} is above {} Hz, {why}",
            100.0 * self.share,
            ["x", "y", "z"][self.axis.index() % 3],
            self.cutoff_hz(),
        )
    }
}
