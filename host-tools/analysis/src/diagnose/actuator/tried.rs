//! The ranges and grids in which a search looks for the parameters of a stage.

use softdock_physics::effects::actuator::backlash;
use softdock_physics::model::stage::Stage;

/// A parameter of a stage, with its range and grid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Spec {
    /// Name with unit, as in the catalogue.
    pub name: &'static str,
    /// SI unit.
    pub unit: &'static str,
    /// Smallest value that is tried.
    pub low: f64,
    /// Largest value that is tried.
    pub high: f64,
    /// The grid is geometric in the distance from this value; `None` for an even grid.
    pub ratio_from: Option<f64>,
    /// Number of values on the first grid.
    pub grid: usize,
}

const fn spec(name: &'static str, unit: &'static str, low: f64, high: f64, grid: usize) -> Spec {
    Spec {
        name,
        unit,
        low,
        high,
        ratio_from: Some(0.0),
        grid,
    }
}

fn acceleration(steepest: f64) -> Vec<Spec> {
    let (low, high) = (0.02 * steepest, 0.99 * steepest);
    vec![spec("max_acceleration_m_s2", "m/s^2", low, high, 24)]
}

fn jerk(fastest: f64, largest: f64) -> Vec<Spec> {
    /// Duration of the slowest approach that is tried, s: 2 √(v/j) from rest to the largest velocity.
    const APPROACH_S: f64 = 0.5;
    let low = 4.0 * fastest / (APPROACH_S * APPROACH_S);
    let high = (0.99 * largest).max(2.0 * low);
    vec![spec("max_jerk_m_s3", "m/s^3", low, high, 12)]
}

fn velocity(fastest: f64) -> Vec<Spec> {
    let (low, high) = (0.1 * fastest, 0.999 * fastest);
    vec![spec("max_velocity_m_s", "m/s", low, high, 12)]
}

/// Ranges and grids of the parameters of a stage; those of limits are scaled by the motion in the log.
pub(crate) fn specs(stage: Stage, scale: &Scale) -> Vec<Spec> {
    match stage {
        Stage::Delay => {
            let [low, high] = [2e-5, SLOWEST_S].map(|s| s * scale.slower);
            vec![spec("extra_delay_s", "s", low, high, 14)]
        }
        Stage::Lag => {
            let [low, high] = [5e-5, SLOWEST_S].map(|s| s * scale.slower);
            vec![spec("extra_lag_s", "s", low, high, 12)]
        }
        Stage::Resonance => vec![
            spec(
                "frequency_hz",
                "Hz",
                2.5 / scale.slower,
                scale.nyquist_hz,
                22,
            ),
            spec("damping_ratio", "-", 0.008, 0.3, 4),
        ],
        Stage::Servo | Stage::ServoForLag => vec![
            spec(
                "frequency_hz",
                "Hz",
                1.0 / scale.slower,
                scale.nyquist_hz,
                10,
            ),
            spec("damping_ratio", "-", 0.3, 0.99, 3),
        ],
        Stage::Pause(..) => vec![spec("pause_s", "s", 3e-4, 0.1, 16)],
        Stage::DriveAcceleration => acceleration(scale.acceleration),
        // A loop asks for most at the begin of a cycle, of which the log shows the mean.
        Stage::LoopAcceleration => acceleration(2.0 * scale.acceleration),
        Stage::PlannerAcceleration => acceleration(scale.sent_acceleration),
        Stage::DriveJerk => jerk(scale.velocity, scale.jerk),
        Stage::PlannerJerk => jerk(scale.sent_velocity, scale.sent_jerk),
        Stage::DriveVelocity => velocity(scale.velocity),
        Stage::PlannerVelocity => velocity(scale.sent_velocity),
        // A scale that was guessed may be far off, so the grid is even in the ratio of gains.
        Stage::Gain => vec![Spec {
            ratio_from: Some(-1.0),
            ..spec("gain_error", "-", -0.95, 20.0, 25)
        }],
        Stage::Direction => vec![Spec {
            ratio_from: None,
            ..spec("asymmetry", "-", -0.95, 0.95, 13)
        }],
        Stage::DeadZone => {
            let fastest = scale.sent_velocity;
            let centre = spec("centre_m_s", "m/s", -0.9 * fastest, 0.9 * fastest, 7);
            vec![
                spec("width_m_s", "m/s", 5e-3 * fastest, 1.8 * fastest, 8),
                Spec {
                    ratio_from: None,
                    ..centre
                },
            ]
        }
        Stage::Backlash => {
            let known = backlash::EFFECT.parameters.first();
            let [_, widest] = known.map_or([0.0; 2], |width| width.range(scale.rotates));
            let grid = if scale.rotates { 36 } else { 26 };
            vec![spec("width_m", "m", 1e-6, widest, grid)]
        }
        Stage::CommandStep => vec![spec(
            "step_m_s",
            "m/s",
            1e-3 * scale.velocity,
            0.2 * scale.velocity,
            8,
        )],
    }
}

/// Whether a value stands at the lower and at the upper end of its range, so that the true one may lie beyond. Never for the step
/// of a command, whose search is not limited to this range.
pub(super) fn at_an_end(stage: Stage, spec: &Spec, value: f64) -> [bool; 2] {
    /// Share of the range, at its end, that counts as the end.
    const END: f64 = 0.01;
    let reach = match spec.ratio_from {
        Some(from) => [END * (spec.low - from), END * (spec.high - from)],
        None => [END * (spec.high - spec.low); 2],
    };
    let is_sought = stage != Stage::CommandStep;
    [
        is_sought && value <= spec.low + reach[0],
        is_sought && value >= spec.high - reach[1],
    ]
}

/// Spacing of values at which the plateaus of a piecewise constant χ² are scanned: a pause or a play changes χ² only by the
/// cycles that it holds still. `None` where χ² is smooth.
pub(super) fn plateau_step(stage: Stage, value: f64, cycle_s: f64) -> Option<f64> {
    /// Values per cycle, for a pause.
    const OF_CYCLE: f64 = 40.0;
    /// Values per width, for a play.
    const OF_WIDTH: f64 = 100.0;
    match stage {
        Stage::Pause(..) => Some(cycle_s / OF_CYCLE),
        Stage::Backlash => Some(value / OF_WIDTH),
        _ => None,
    }
}

/// Size of the motions in the logs, for some axes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Scale {
    /// Largest nominal velocity of the axes in question, in their unit.
    pub velocity: f64,
    /// Largest change of the nominal velocity per second.
    pub acceleration: f64,
    /// Largest change of that acceleration per second.
    pub jerk: f64,
    /// Largest sent velocity, which a planner limits.
    pub sent_velocity: f64,
    /// Largest change of the sent velocity per second.
    pub sent_acceleration: f64,
    /// Largest change of that acceleration per second.
    pub sent_jerk: f64,
    /// Half of the cycle rate, Hz.
    pub nyquist_hz: f64,
    /// The axes are rotations.
    pub rotates: bool,
    /// By how much slower than the slowest drive of a docking rig the drive of this log may be, 1 or more: a machine that is
    /// logged at a lower rate is slower ([`slower`]).
    pub slower: f64,
}

/// Delay or lag of the slowest drive that is looked for on a docking rig, in its cycles of 4 ms. Set by hand.
const SLOWEST_CYCLES: f64 = 30.0;
/// The same in s.
const SLOWEST_S: f64 = 0.12;

/// By how much slower than the slowest drive of a docking rig the drive may be in a log with this sampling period, s.
pub(super) fn slower(cycle_s: f64) -> f64 {
    (cycle_s * SLOWEST_CYCLES / SLOWEST_S).max(1.0)
}

impl Scale {
    /// From pairs of sent and nominally executed velocity.
    pub(crate) fn of<'s>(
        series: impl Iterator<Item = (&'s [f64], &'s [f64])>,
        cycle_s: f64,
        rotates: bool,
    ) -> Self {
        let mut scale = Self {
            rotates,
            velocity: 0.0,
            acceleration: 0.0,
            jerk: 0.0,
            sent_velocity: 0.0,
            sent_acceleration: 0.0,
            sent_jerk: 0.0,
            nyquist_hz: 0.5 / cycle_s,
            slower: slower(cycle_s),
        };
        for (sent, nominal) in series {
            let [velocity, acceleration, jerk] = largest(nominal, cycle_s);
            scale.velocity = scale.velocity.max(velocity);
            scale.acceleration = scale.acceleration.max(acceleration);
            scale.jerk = scale.jerk.max(jerk);
            let [velocity, acceleration, jerk] = largest(sent, cycle_s);
            scale.sent_velocity = scale.sent_velocity.max(velocity);
            scale.sent_acceleration = scale.sent_acceleration.max(acceleration);
            scale.sent_jerk = scale.sent_jerk.max(jerk);
        }
        scale
    }
}

/// Largest velocity, acceleration and jerk of a series.
fn largest(series: &[f64], cycle_s: f64) -> [f64; 3] {
    let velocity = series.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    let steps = series.windows(2).map(|w| (w[1] - w[0]).abs());
    let bends = series.windows(3).map(|w| (w[2] - 2.0 * w[1] + w[0]).abs());
    [
        velocity,
        steps.fold(0.0, f64::max) / cycle_s,
        bends.fold(0.0, f64::max) / (cycle_s * cycle_s),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_value_at_the_end_of_its_search_is_none() {
        let [delay] = specs(Stage::Delay, &Scale::of(std::iter::empty(), 0.004, false))[..] else {
            panic!("one parameter");
        };
        let at = |value: f64| at_an_end(Stage::Delay, &delay, value);
        assert_eq!(at(0.12), [false, true]);
        assert_eq!(at(0.118), [false, false]);
        assert_eq!(at(2e-5), [true, false]);
    }

    /// A gear has more play in radians than a guide in metres.
    #[test]
    fn play_is_looked_for_as_far_as_the_catalogue_goes() {
        let widest = |rotates| {
            let scale = Scale::of(std::iter::empty(), 0.004, rotates);
            specs(Stage::Backlash, &scale)[0].high
        };
        assert_eq!([false, true].map(widest), [0.02, 1.0]);
    }

    #[test]
    fn a_slow_log_is_asked_for_slow_drives() {
        let latest = |cycle_s: f64| {
            let scale = Scale::of(std::iter::empty(), cycle_s, false);
            [Stage::Delay, Stage::Lag].map(|stage| specs(stage, &scale)[0].high)
        };
        // A docking rig, one that is faster, and a vehicle of 20 Hz.
        for (cycle_s, expected) in [(0.004, 0.12), (0.001, 0.12), (0.05, 1.5)] {
            for high in latest(cycle_s) {
                assert!((high - expected).abs() < 1e-12, "{cycle_s} s: {high}");
            }
        }
    }
}
