//! Executed velocity from the velocities that were sent (channel A of docs/docking-rig-log-1.md).
//!
//! A velocity, sent in cycle n, is held for a cycle and passes through the actuator of the model
//! ([`softdock_actuator`]). A sampled velocity is compared with its end value, the difference
//! of two poses with its mean. With whole cycles d of delay and the lag T this is
//! `y(n) = e y(n−1) + (1−e) u(n−1−d)`, `e = exp(−Ts/T)`, at the end of a cycle. Where an import has filtered what was measured,
//! the answer to what was sent is filtered likewise.

use super::retimed::velocity_delay_s;
use super::signals::{Signals, Step, VelocityMeaning};
use super::{ChannelPrediction, Six};
use crate::model::{Channel, Model};
use softdock_actuator::{Reading, Timing, simulate};

/// Predicts the channel; `intervals_s` are the true durations of the cycles, empty if nominal.
pub fn predict(model: &Model, signals: &Signals<'_>, intervals_s: &[f64]) -> ChannelPrediction {
    let reading = match signals.velocity {
        VelocityMeaning::CycleMean => Reading::Mean,
        VelocityMeaning::Sampled => Reading::AtEnd,
    };
    ChannelPrediction {
        channel: Channel::ExecutedVelocity,
        measured: signals
            .cycles
            .iter()
            .map(|c| c.trace.executed_velocity)
            .collect(),
        predicted: velocities(model, signals, intervals_s, reading),
        sigma: signals.velocity_sigma(model),
        expected_sigma: Vec::new(),
    }
}

/// The velocity of each cycle that follows from the commands; `None` where these are not known.
pub(super) fn velocities(
    model: &Model,
    signals: &Signals<'_>,
    intervals_s: &[f64],
    reading: Reading,
) -> Vec<Option<Six>> {
    let mut predicted: Vec<Option<Six>> = vec![None; signals.len()];
    let mut start = 0;
    let sent = |n: usize| signals.cycles[n].trace.sent_velocity;
    // A log without commands says nothing about the actuator.
    let commanded = (0..signals.len()).any(|n| sent(n).iter().any(|v| *v != 0.0));
    for n in 1..=signals.len() {
        let ends = n == signals.len() || matches!(signals.steps[n], Step::NewRun | Step::Hole);
        if ends && commanded {
            let run = start..n;
            predict_run(model, signals, intervals_s, reading, run, &mut predicted);
            start = n;
        }
    }
    predicted
}

/// A run of the robot without a hole in the recording.
fn predict_run(
    model: &Model,
    signals: &Signals<'_>,
    intervals_s: &[f64],
    reading: Reading,
    run: std::ops::Range<usize>,
    predicted: &mut [Option<Six>],
) {
    let memory = memory_cycles(model, signals.cycle_s);
    // After a hole the commands on their way are not known.
    let after_hole = signals.steps[run.start] == Step::Hole && run.start > 0;
    let filter = model.sensor.filter;
    // Neither are the samples beyond the end, which a forward and backward filter mixes in.
    let bent = filter.map_or(0, |filter| filter.settling(signals.cycle_s, run.len()));
    let unknown = if after_hole || begins_in_motion(model, signals, run.start) {
        memory + bent
    } else {
        0
    };
    let commands = Commands::of(signals, run.clone(), intervals_s, memory);
    let timing = Timing {
        cycle_s: signals.cycle_s,
        intervals_s: &commands.intervals_s,
    };
    let late_s = velocity_delay_s(model, signals);
    let axes: [Vec<f64>; 6] = std::array::from_fn(|axis| {
        let mut chain = model.chain(axis);
        chain.delay_s = (chain.delay_s + late_s).max(0.0);
        let mut rates = simulate(&chain, &commands.sent[axis], &timing, reading);
        timing.as_recorded(&mut rates, reading);
        match filter {
            Some(filter) => filter.zero_phase(signals.cycle_s, &rates),
            None => rates,
        }
    });
    for (n, index) in run.clone().zip(&commands.indices) {
        let is_known = (run.start + unknown..run.end.saturating_sub(bent)).contains(&n);
        if is_known && signals.executed(n).is_some() {
            let rates = std::array::from_fn(|axis| axes[axis][*index]);
            let turned = signals.turned(n);
            predicted[n] = Some(turned.map_or(rates, |turned| turned.velocity(&rates)));
        }
    }
}

/// Whether the robot already moves when a run begins, or may: a log that was cut out of a longer one does not contain the earlier
/// commands.
fn begins_in_motion(model: &Model, signals: &Signals<'_>, start: usize) -> bool {
    /// Ratio of velocity and noise that counts as a motion.
    const MOVES: f64 = 10.0;
    let first = &signals.cycles[start].trace;
    let cut = start == 0 && first.cycle > 0;
    if cut && first.sent_velocity.iter().any(|v| *v != 0.0) {
        return true;
    }
    let sigma = signals.velocity_sigma(model);
    // A difference of poses is known from the second cycle on.
    let velocity = signals
        .executed(start)
        .or_else(|| signals.executed(start + 1));
    velocity.is_some_and(|v| v.get().iter().zip(sigma).any(|(v, s)| v.abs() > MOVES * s))
}

/// Cycles after which an unknown past is forgotten to 1 %.
fn memory_cycles(model: &Model, cycle_s: f64) -> usize {
    let past_s = |axis| {
        let chain = model.chain(axis);
        chain.delay_s + 5.0 * (chain.lag_s + chain.extra_lag_s)
    };
    let longest_s = (0..6).map(past_s).fold(0.0, f64::max);
    (longest_s / cycle_s).ceil() as usize + 2
}

/// The commands of each of the robot's cycles, including those without an answer.
struct Commands {
    sent: [Vec<f64>; 6],
    intervals_s: Vec<f64>,
    /// Robot cycle of each recorded cycle.
    indices: Vec<usize>,
}

impl Commands {
    fn of(
        signals: &Signals<'_>,
        run: std::ops::Range<usize>,
        intervals_s: &[f64],
        memory: usize,
    ) -> Self {
        let mut commands = Self {
            sent: Default::default(),
            intervals_s: Vec::new(),
            indices: Vec::new(),
        };
        for n in run {
            if let Step::Lost(cycles) = signals.steps[n] {
                // More than the memory of the delay has no further effect.
                for _ in 0..(cycles as usize).min(memory) {
                    commands.push([0.0; 6], None);
                }
            }
            commands.indices.push(commands.sent[0].len());
            commands.push(signals.sent_rates(n), intervals_s.get(n).copied());
        }
        commands
    }

    fn push(&mut self, sent: Six, interval_s: Option<f64>) {
        for (series, value) in self.sent.iter_mut().zip(sent) {
            series.push(value);
        }
        self.intervals_s.extend(interval_s);
    }
}
