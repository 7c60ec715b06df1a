//! Two tests of each residual: is it white, and is it independent of the inputs?

use super::Source;
use super::motion::Motion;
use super::series::Series;
use serde::Serialize;
use softdock_physics::model::{Axis, Channel};
use softdock_statistics::{dependence, whiteness};

/// Probability of any false alarm in all tests of one kind. It is small: with a right model at most one recording in a thousand
/// is doubted.
const LEVEL: f64 = 0.001;

/// What an error may depend on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Input {
    /// Velocity that was sent.
    SentVelocity,
    /// Load that the model expects on the sensor.
    Force,
    /// Position, or rotation from the first pose.
    Position,
}

impl Input {
    /// Name in tables.
    pub(super) fn words(self) -> &'static str {
        match self {
            Self::SentVelocity => "sent velocity",
            Self::Force => "expected load",
            Self::Position => "position",
        }
    }
}

/// Test of an error against noise that is correlated over no more than two cycles, as differences
/// and the filter of a sensor make it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct WhitenessTest {
    /// Box and Pierce's sum over 25 lags, whose expectation for noise is 25.
    pub statistic: f64,
    /// Probability of at least this statistic for noise.
    pub p: f64,
    /// The residual is noise, at 0.1 % over all axes together.
    pub white: bool,
}

/// Test of an error against an input on the same axis.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct IndependenceTest {
    /// Input.
    pub input: Input,
    /// Regression coefficient over its standard error, at the lag where it is largest.
    pub statistic: f64,
    /// This lag, s: the residual follows the input by so much.
    pub lag_s: f64,
    /// Probability of at least this statistic without a dependence.
    pub p: f64,
    /// No dependence, at 0.1 % over all axes and inputs together.
    pub independent: bool,
}

/// The tests of one axis of a channel.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ResidualTests {
    /// Channel.
    pub channel: Channel,
    /// Axis.
    pub axis: Axis,
    /// Test of the residual against its own past.
    pub whiteness: WhitenessTest,
    /// Tests against the inputs; inputs that do not change are left out.
    pub independence: Vec<IndependenceTest>,
}

/// The tests of all axes.
pub(super) fn of_axes(
    source: &Source<'_>,
    motion: &Motion,
    series: &[Series],
) -> Vec<ResidualTests> {
    let mut tests: Vec<ResidualTests> = series
        .iter()
        .map(|series| of_axis(source, motion, series))
        .collect();
    let of_whiteness = LEVEL / tests.len().max(1) as f64;
    let inputs: usize = tests.iter().map(|t| t.independence.len()).sum();
    let of_independence = LEVEL / inputs.max(1) as f64;
    for test in &mut tests {
        test.whiteness.white = test.whiteness.p >= of_whiteness;
        for input in &mut test.independence {
            input.independent = input.p >= of_independence;
        }
    }
    tests
}

fn of_axis(source: &Source<'_>, motion: &Motion, series: &Series) -> ResidualTests {
    let fresh = series.fresh(source);
    let tested = series.is_there();
    let found = tested
        .then(|| whiteness(&fresh, series.noise.len()))
        .flatten();
    let whiteness = found.map_or((0.0, 1.0), |w| (w.statistic, w.p));
    let mut independence = Vec::new();
    if tested {
        for (input, values) in inputs(source, motion, series.axis) {
            if let Some(found) = dependence(&fresh, &values) {
                independence.push(IndependenceTest {
                    input,
                    statistic: found.statistic,
                    lag_s: found.lag as f64 * source.signals.cycle_s,
                    p: found.p,
                    independent: true,
                });
            }
        }
    }
    ResidualTests {
        channel: series.channel,
        axis: series.axis,
        whiteness: WhitenessTest {
            statistic: whiteness.0,
            p: whiteness.1,
            white: true,
        },
        independence,
    }
}

fn inputs(source: &Source<'_>, motion: &Motion, axis: Axis) -> Vec<(Input, Vec<f64>)> {
    let i = axis.index();
    let sent = source
        .signals
        .cycles
        .iter()
        .map(|c| c.trace.sent_velocity[i]);
    let mut inputs = vec![
        (Input::SentVelocity, sent.collect()),
        (Input::Force, motion.load.iter().map(|w| w[i]).collect()),
    ];
    if motion.moves[i] {
        inputs.push((
            Input::Position,
            motion.position.iter().map(|p| p[i]).collect(),
        ));
    }
    inputs
}
