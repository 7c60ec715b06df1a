//! `softdock compare`: predicted against measured, how large the error is, and where it stands.
//!
//! The error of a cycle is measured minus predicted ([`softdock_physics::model::prediction`]). It is given
//! in its unit and relative to the noise: `rms_sigma` divides by the data sheet's noise, as
//! docking-rig-log/1 defines it; what decides whether the model fails is the noise to expect of
//! the difference, which includes what the prediction inherits from noisy measurements.

mod contact;
mod crossing;
mod errors;
mod explain;
mod failure;
pub(crate) mod free_simulation;
mod motion;
mod noise;
mod notes;
pub mod phases;
mod regime;
mod residual_tests;
pub(crate) mod sentence;
mod series;
mod series_table;
mod swing;
mod tables;
#[cfg(test)]
mod tests;

use contact::Contacts;
use errors::AxisError;
pub use errors::TOLERATED_NOISE;
pub use explain::{Estimate, Explanation};
pub use failure::{Failure, PhaseShare};
pub use free_simulation::FreeSimulation;
use motion::Motion;
pub use noise::{NoiseLevel, NoiseVerdict};
pub use phases::Phase;
use regime::Regimes;
pub use regime::{Bin, Dependence, Interval, Quantity, Regime, Spectrum};
pub use residual_tests::{IndependenceTest, Input, ResidualTests, WhitenessTest};
use serde::Serialize;
pub use series::{ROUND_OFF_SIGMA, Series};
pub use series_table::SeriesFile;
use softdock_io::recording::Recording;
use softdock_physics::model::prediction::signals::Signals;
pub use softdock_physics::model::prediction::{ChannelPrediction, Prediction};
use softdock_physics::model::{Axis, Channel, Model, prediction};

/// Error of one axis of a channel over the whole recording.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ChannelError {
    /// Channel.
    pub name: Channel,
    /// Axis.
    pub axis: Axis,
    /// SI unit of `rms`.
    pub unit: &'static str,
    /// Root mean square of measured minus predicted over all cycles; a cycle without prediction
    /// counts as zero.
    pub rms: f64,
    /// The same in units of the data sheet's noise.
    pub rms_sigma: f64,
    /// The same in units of the noise to expect of the difference, and over the cycles with a
    /// prediction: 1 if the model is right.
    pub rms_expected_sigma: f64,
}

/// Error of a channel over its judged axes, as docking-rig-log/1 sums it up.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ChannelTotal {
    /// Channel.
    pub name: Channel,
    /// Root mean square of all cycles and axes in units of the data sheet's noise.
    pub rms_sigma: f64,
}

/// A stretch of time.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Window {
    /// Time of the first cycle, s.
    pub from_s: f64,
    /// Time of the last cycle, s.
    pub to_s: f64,
}

/// Error of one phase of the test.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PhaseError {
    /// Phase.
    pub name: Phase,
    /// Its part of the sum of squared errors of all channels, each relative to the noise that is
    /// expected of it; 0 to 1.
    pub share: f64,
    /// Its part of what exceeds the noise significantly; 0 to 1, and 0 everywhere if nothing does.
    pub share_beyond_noise: f64,
    /// Root mean square relative to the expected noise, over the axes that have noise: 1 if the model is right.
    pub rms_sigma: f64,
    /// Number of cycles.
    pub cycles: usize,
    /// Stretches of time in this phase.
    pub windows: Vec<Window>,
}

/// What a comparison finds.
#[derive(Clone, Debug, Serialize)]
pub struct Comparison {
    /// Where the model fails, in a sentence.
    #[serde(rename = "where")]
    pub sentence: String,
    /// Nothing exceeds the noise.
    pub at_noise: bool,
    /// Errors per channel and axis.
    pub channels: Vec<ChannelError>,
    /// Errors per channel.
    pub totals: Vec<ChannelTotal>,
    /// Errors per phase, all phases.
    pub phases: Vec<PhaseError>,
    /// Channels and axes in which the model fails, worst first.
    pub failures: Vec<Failure>,
    /// Errors sorted by velocity, position, load, time and frequency: all regimes of each axis in which the model fails, the one
    /// that explains most first.
    pub regimes: Vec<Regime>,
    /// Tests of each axis against noise.
    pub tests: Vec<ResidualTests>,
    /// Noise that the recording shows, against the data sheet.
    pub noise: Vec<NoiseLevel>,
    /// The motion simulated forward from the force alone, where a recorded force drives a single axis.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub free_simulation: Option<FreeSimulation>,
    /// What the reader should know about the recording.
    pub notes: Vec<String>,
    /// Number of contacts.
    pub contacts: usize,
    /// Number of cycles.
    pub cycles: usize,
    /// Values for the plots.
    #[serde(skip)]
    pub detail: Detail,
}

/// Everything that the report draws.
#[derive(Clone, Debug)]
pub struct Detail {
    /// Every channel, measured and predicted.
    pub prediction: Prediction,
    /// Phase of each cycle.
    pub phases: Vec<Phase>,
    /// Error of each axis.
    pub series: Vec<Series>,
    /// Firmware or program that made the recording.
    pub identity: String,
    /// Settings of the board.
    pub settings_toml: String,
    /// Scenario of a simulated rig.
    pub scenario_toml: Option<String>,
    /// The model.
    pub model_toml: String,
}

/// Input of the functions that explain errors.
struct Source<'a> {
    model: &'a Model,
    signals: &'a Signals<'a>,
    prediction: &'a Prediction,
    phases: &'a [Phase],
}

impl Source<'_> {
    /// Whether errors of a channel are differences of recorded positions and recorded velocities: of a machine that is no rig, neither
    /// is predicted.
    fn is_within_motion(&self, channel: Channel) -> bool {
        channel == Channel::Pose && !self.signals.is_of_a_rig()
    }
}

/// Compares a recording with a model.
///
/// # Errors
///
/// A recording that cannot be predicted at all: fewer than two cycles, unreadable settings or
/// no rising time. A recording without contact, or one that was cut off, is compared.
pub fn compare(model: &Model, recording: &Recording) -> anyhow::Result<Comparison> {
    let signals = Signals::new(recording)?;
    let prediction = prediction::predict_signals(model, &signals);
    let contacts = contact::find(model, &signals);
    let phases = phases::of_cycles(model, &signals, &contacts);
    let errors = errors::of_axes(&prediction, &phases);
    let source = Source {
        model,
        signals: &signals,
        prediction: &prediction,
        phases: &phases,
    };
    let series = series::of_axes(&source);
    let motion = Motion::new(&source);
    let regimes = regimes(&source, &motion, &contacts, &errors, &series);
    let tests = residual_tests::of_axes(&source, &motion, &series);
    let noise = noise::of_axes(&source);
    let mut failures = failure::find(&source, &errors, &regimes);
    for failure in &mut failures {
        failure.sentence = sentence::of_failure(&source, &errors, failure, &noise);
    }
    let mut notes = notes::of_recording(recording, &signals, &contacts);
    notes.extend(prediction.notes.iter().cloned());
    notes.extend(noise::notes(&source, &noise));
    let simulated = free_simulation::simulate(model, &signals).transpose();
    let strays = match &simulated {
        Ok(free) => free.is_some_and(|free| free.strays()),
        Err(none) => none.runs_away,
    };
    notes.extend(simulated.as_ref().err().map(|none| none.why.clone()));
    let simulated = simulated.ok().flatten();
    Ok(Comparison {
        sentence: sentence::whole(&errors, &failures, strays),
        at_noise: failures.is_empty(),
        channels: errors.iter().map(AxisError::summary).collect(),
        totals: totals(&prediction, &errors),
        phases: phase_errors(&prediction, &phases, &errors),
        failures,
        regimes,
        tests,
        noise,
        free_simulation: simulated,
        notes,
        contacts: contacts.list.len(),
        cycles: signals.len(),
        detail: Detail {
            prediction,
            phases,
            series,
            identity: recording.header.identity.clone(),
            settings_toml: recording.header.settings_toml.clone(),
            scenario_toml: recording.header.scenario_toml.clone(),
            model_toml: model.to_toml(),
        },
    })
}

/// Phase of each cycle of a recording.
///
/// # Errors
///
/// Those of [`compare`].
pub fn phases_of(model: &Model, recording: &Recording) -> anyhow::Result<Vec<Phase>> {
    let signals = Signals::new(recording)?;
    let contacts = contact::find(model, &signals);
    Ok(phases::of_cycles(model, &signals, &contacts))
}

/// Errors by regime of the axes in which the model fails.
fn regimes(
    source: &Source<'_>,
    motion: &Motion,
    contacts: &Contacts,
    errors: &[AxisError],
    series: &[Series],
) -> Vec<Regime> {
    let touching: Vec<_> = contacts.list.iter().map(|c| c.from..c.to).collect();
    let fails = |s: &&Series| {
        let of = |e: &&AxisError| e.channel == s.channel && e.axis == s.axis;
        errors.iter().find(of).is_some_and(|e| e.excess() > 0.0)
    };
    let failing: Vec<&Series> = series.iter().filter(fails).collect();
    let regimes = Regimes::new(source, motion, &touching, failing.len());
    failing
        .into_iter()
        .flat_map(|series| regimes.of(series))
        .collect()
}

fn totals(prediction: &Prediction, errors: &[AxisError]) -> Vec<ChannelTotal> {
    let total = |channel: Channel| {
        // Angles of the pose are judged, but docking-rig-log/1 sums its translations only.
        let axes = errors.iter().filter(|e| {
            e.channel == channel && !(channel == Channel::Pose && e.axis.is_rotation())
        });
        let (sum, count) = axes.fold((0.0, 0), |(sum, count), e| {
            (sum + e.data_sheet_squares, count + prediction.time_s.len())
        });
        ChannelTotal {
            name: channel,
            rms_sigma: (sum / count.max(1) as f64).sqrt(),
        }
    };
    Channel::ALL.map(total).to_vec()
}

fn phase_errors(
    prediction: &Prediction,
    phases: &[Phase],
    errors: &[AxisError],
) -> Vec<PhaseError> {
    let sum_of = |phase: Phase| errors::Sum::total(errors.iter().map(|e| e.in_phase(phase)));
    let excess_of =
        |phase: Phase| -> f64 { errors.iter().map(|e| e.in_phase(phase).excess()).sum() };
    let all: f64 = Phase::ALL.map(|p| sum_of(p).squares).iter().sum();
    let all_excess: f64 = Phase::ALL.map(excess_of).iter().sum();
    let part = |value: f64, all: f64| if all > 0.0 { value / all } else { 0.0 };
    // A channel that is computed twice from the same numbers has no noise: its axes would lower the mean.
    let noisy = |e: &&AxisError| e.overall().rms() >= ROUND_OFF_SIGMA;
    let rms_of = |phase: Phase| {
        let sums = errors.iter().filter(noisy).map(|e| e.in_phase(phase));
        errors::Sum::total(sums).rms()
    };
    Phase::ALL
        .into_iter()
        .map(|name| PhaseError {
            name,
            share: part(sum_of(name).squares, all),
            share_beyond_noise: part(excess_of(name), all_excess),
            rms_sigma: rms_of(name),
            cycles: phases.iter().filter(|p| **p == name).count(),
            windows: windows(prediction, phases, |p| p == name)
                .into_iter()
                .map(|cycles| window(prediction, &cycles))
                .collect(),
        })
        .collect()
}

/// Stretches of cycles in phases that `wanted` accepts.
pub fn windows(
    prediction: &Prediction,
    phases: &[Phase],
    wanted: impl Fn(Phase) -> bool,
) -> Vec<std::ops::Range<usize>> {
    let mut found: Vec<std::ops::Range<usize>> = Vec::new();
    let cycles = phases.iter().take(prediction.time_s.len()).enumerate();
    for (n, _) in cycles.filter(|(_, phase)| wanted(**phase)) {
        match found.last_mut() {
            Some(last) if last.end == n => last.end = n + 1,
            _ => found.push(n..n + 1),
        }
    }
    found
}

fn window(prediction: &Prediction, cycles: &std::ops::Range<usize>) -> Window {
    let at = |n: usize| prediction.time_s.get(n).copied().unwrap_or(0.0);
    Window {
        from_s: at(cycles.start),
        to_s: at(cycles.end.saturating_sub(1)),
    }
}
