//! Sums of squared errors, per axis and phase.

use super::{ChannelError, Phase};
use softdock_physics::model::prediction::Prediction;
use softdock_physics::model::{Axis, Channel};

/// An error counts if its root mean square exceeds this multiple of the expected noise (data sheets are not more exact) ...
pub const TOLERATED_NOISE: f64 = 1.25;
/// ... and if the sum of squares exceeds that of noise by so many standard deviations. The sum of n squares of white Gaussian
/// noise is n ± √(2n); that of differences scatters somewhat more.
const SIGNIFICANT: f64 = 6.0;

/// Sum of squares of `error / expected noise`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Sum {
    pub(super) squares: f64,
    pub(super) count: usize,
}

impl Sum {
    pub(super) fn total(parts: impl Iterator<Item = Self>) -> Self {
        parts.fold(Self::default(), |sum, part| Self {
            squares: sum.squares + part.squares,
            count: sum.count + part.count,
        })
    }

    /// Root mean square; 0 of nothing.
    pub(super) fn rms(&self) -> f64 {
        (self.squares / self.count.max(1) as f64).sqrt()
    }

    /// Excess of the sum over that of noise; 0 if it may be chance.
    pub(super) fn excess(&self) -> f64 {
        let n = self.count as f64;
        let excess = self.squares - n;
        let significant = self.rms() > TOLERATED_NOISE && excess > SIGNIFICANT * (2.0 * n).sqrt();
        if significant { excess } else { 0.0 }
    }
}

/// Errors of one axis of a channel.
#[derive(Clone, Debug)]
pub(super) struct AxisError {
    pub(super) channel: Channel,
    pub(super) axis: Axis,
    /// Root mean square over all cycles, in its unit.
    rms: f64,
    /// Sum of squares relative to the data sheet's noise.
    pub(super) data_sheet_squares: f64,
    rms_sigma: f64,
    by_phase: [Sum; Phase::ALL.len()],
}

impl AxisError {
    pub(super) fn in_phase(&self, phase: Phase) -> Sum {
        self.by_phase[phase as usize]
    }

    /// Sum over all phases of what exceeds the noise.
    pub(super) fn excess(&self) -> f64 {
        self.by_phase.iter().map(Sum::excess).sum()
    }

    pub(super) fn overall(&self) -> Sum {
        Sum::total(self.by_phase.iter().copied())
    }

    pub(super) fn summary(&self) -> ChannelError {
        ChannelError {
            name: self.channel,
            axis: self.axis,
            unit: self.channel.unit(self.axis),
            rms: self.rms,
            rms_sigma: self.rms_sigma,
            rms_expected_sigma: self.overall().rms(),
        }
    }
}

/// Errors of all judged axes of all channels.
pub(super) fn of_axes(prediction: &Prediction, phases: &[Phase]) -> Vec<AxisError> {
    Channel::ALL
        .into_iter()
        .flat_map(|channel| {
            prediction
                .judged(channel)
                .iter()
                .map(move |axis| (channel, *axis))
        })
        .map(|(channel, axis)| of_axis(prediction, phases, channel, axis))
        .collect()
}

fn of_axis(prediction: &Prediction, phases: &[Phase], channel: Channel, axis: Axis) -> AxisError {
    let values = prediction.channel(channel);
    let mut by_phase = [Sum::default(); Phase::ALL.len()];
    let mut squares = 0.0;
    for (n, phase) in phases.iter().enumerate() {
        let Some(error) = values.residual(n, axis) else {
            continue;
        };
        let relative = error / values.expected_sigma(n, axis);
        let sum = &mut by_phase[*phase as usize];
        sum.squares += relative * relative;
        sum.count += 1;
        squares += error * error;
    }
    let rms = (squares / values.rows_that_count().max(1) as f64).sqrt();
    let sigma = values.sigma[axis.index()];
    AxisError {
        channel,
        axis,
        rms,
        data_sheet_squares: squares / (sigma * sigma),
        rms_sigma: rms / sigma,
        by_phase,
    }
}
