//! Does the acceleration follow the force, or is it noise?

use super::Context;
use super::force::applies;
use crate::diagnose::evidence::DROWNED;
use softdock_io::recording::Recording;
use softdock_physics::model::prediction::signals::Signals;
use softdock_physics::model::{Axis, Model};
use softdock_report::number;
use softdock_statistics::{NoiseBand, incoherent_band, noise_band, rms};

/// Share of noise in the square of an acceleration from which a warning says so: the noise then makes a tenth of the inertial force,
/// as much as a model of a real machine usually leaves. An inertia is found too small by the share itself (errors in variables).
const SHARE: f64 = 0.01;

/// An axis whose signal has less than this share of the largest one of its kind does not move: it shakes.
const MOVES: f64 = 0.01;
/// Of several logs, those with at least this share of the noise of the worst one have a say in the cutoff.
const HAS_A_SAY: f64 = 0.5;

/// An acceleration, as far as it is noise.
struct NoisyAxis {
    axis: Axis,
    /// The log holds a force or torque that changes; otherwise the noise is known by its spectrum alone.
    driven: bool,
    from_hz: f64,
    /// See [`NoiseBand::share`].
    share: f64,
    /// Mean square of the rest, (m/s²)² or (rad/s²)².
    signal: f64,
}

/// A warning if the acceleration of some of the logs of an import, by name, is noise.
pub fn filter_needed(logs: &[(&str, &Recording)], model: Option<&Model>) -> Option<String> {
    let context = Context::of_model(model);
    let noisy = logs.iter().filter_map(|(name, recording)| {
        let worst = NoisyAxis::worst(&applies(recording, &context)?, &Axis::ALL)?;
        Some((*name, worst)).filter(|(_, worst)| worst.share > SHARE)
    });
    let (name, noisy) = deciding(noisy.collect())?;
    Some(format!(
        "{name}: {}: noise there, of the motion or of the {}, hides an inertia, or makes it look like a delay. [filter] of the mapping \
         with `cutoff_hz = {}` cuts it off",
        noisy.in_words(),
        noisy.force(),
        noisy.cutoff_hz()
    ))
}

/// What is said first of logs in each of which the acceleration of an axis is [mostly](DROWNED) noise, as the beginning of a
/// sentence.
pub(crate) fn said_first(model: &Model, recordings: &[&Recording]) -> Option<String> {
    let context = Context::of_model(Some(model));
    let mostly_noise = |recording: &&Recording| {
        let worst = NoisyAxis::worst(&applies(recording, &context)?, &model.rig.active_axes)?;
        Some(("", worst)).filter(|(_, worst)| worst.share > DROWNED)
    };
    let all = recordings.iter().map(mostly_noise).collect::<Option<_>>()?;
    let (_, noisy) = deciding(all)?;
    Some(format!(
        "First filter the log: {}. Behind `cutoff_hz = {}` in [filter] of an import the answer may change",
        noisy.in_words(),
        noisy.cutoff_hz()
    ))
}

/// Of several logs with much noise the one that needs the highest cutoff.
fn deciding(all: Vec<(&str, NoisyAxis)>) -> Option<(&str, NoisyAxis)> {
    let worst = all.iter().map(|(_, noisy)| noisy.share).fold(0.0, f64::max);
    let have_a_say = all
        .into_iter()
        .filter(|(_, noisy)| noisy.share >= HAS_A_SAY * worst);
    have_a_say.max_by(|(_, a), (_, b)| a.from_hz.total_cmp(&b.from_hz))
}

impl NoisyAxis {
    /// The axis with the largest share of noise in its acceleration, of those that move.
    fn worst(signals: &Signals<'_>, axes: &[Axis]) -> Option<Self> {
        let all: Vec<Self> = axes
            .iter()
            .filter_map(|axis| Self::of(signals, *axis))
            .collect();
        let largest = |rotation: bool| {
            let alike = all.iter().filter(|one| one.axis.is_rotation() == rotation);
            alike.map(|one| one.signal).fold(0.0, f64::max)
        };
        let largest = [false, true].map(largest);
        let moves = |one: &Self| one.signal >= MOVES * largest[usize::from(one.axis.is_rotation())];
        let moving = all.into_iter().filter(moves);
        moving.max_by(|a, b| a.share.total_cmp(&b.share))
    }

    /// Of the longest part of a log without gaps. `None` also of the motion of a drive that only follows a velocity.
    fn of(signals: &Signals<'_>, axis: Axis) -> Option<Self> {
        let i = axis.index();
        let force = |n: usize| signals.cycles[n].inputs.sensor.wrench[i];
        let has_force = (0..signals.len()).any(|n| force(n).is_finite());
        let row = |n: usize| {
            let motion = signals
                .motion(n)
                .filter(|_| signals.has_own_acceleration(n))?;
            let known = force(n).is_finite() || !has_force;
            known.then(|| [motion.acceleration.get()[i], force(n)])
        };
        let rows: Vec<Option<[f64; 2]>> = (0..signals.len()).map(row).collect();
        let longest = rows.split(Option::is_none).max_by_key(|part| part.len())?;
        let column = |k: usize| {
            longest
                .iter()
                .flatten()
                .map(|row| row[k])
                .collect::<Vec<f64>>()
        };
        let [acceleration, force] = [0, 1].map(column);
        let driven = force.windows(2).any(|pair| (pair[1] - pair[0]).abs() > 0.0);
        let band = match driven {
            true => incoherent_band(&acceleration, &force),
            false if signals.is_commanded() => None,
            false => noise_band(&acceleration, signals.noise_of_acceleration()),
        };
        let NoiseBand { from, share } = band?;
        Some(Self {
            axis,
            driven,
            from_hz: from / signals.cycle_s,
            share,
            signal: (1.0 - share) * rms(&acceleration).powi(2),
        })
    }

    fn cutoff_hz(&self) -> String {
        number::significant(self.from_hz, 2)
    }

    /// What moves the axis.
    fn force(&self) -> &'static str {
        match self.axis.is_rotation() {
            true => "torque",
            false => "force",
        }
    }

    fn in_words(&self) -> String {
        let along = match self.axis.is_rotation() {
            true => "about",
            false => "along",
        };
        let why = match self.driven {
            true => format!("where it does not follow the {}", self.force()),
            false => "where it is noise".to_owned(),
        };
        format!(
            "{} of the mean square of the acceleration {along} {} is above {} Hz, {why}",
            number::percent(self.share, 0),
            ["x", "y", "z"][self.axis.index() % 3],
            self.cutoff_hz(),
        )
    }
}
