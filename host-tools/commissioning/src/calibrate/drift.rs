//! A zero that wanders while the poses are taken: no tool explains it, and the intervals do not include it.

use super::equations::Unknowns;
use super::least_squares::{Drift, Solution, drifts};
use super::observation::Group;
use softdock_report::number;
use softdock_statistics::autocorrelation;

/// Residual of one observation.
#[derive(Clone, Debug, PartialEq)]
pub struct Residual {
    /// Time, s.
    pub time_s: f64,
    /// Number of the pose, if it is one.
    pub pose: Option<usize>,
    /// Whether it was used.
    pub used: bool,
    /// Three forces (N), three torques (N·m).
    pub wrench: [f64; 6],
}

/// Least number of poses with which a zero that wanders in any way is told from chance. A straight drift is told with any number
/// that suffices for a calibration.
const FEWEST: usize = 12;
/// p-value of a straight drift below which it is reported: by chance once in 5,000 calibrations.
const LEVEL: f64 = 1e-4;
/// Autocorrelation of neighbouring poses, in its standard deviations, from which on the zero wanders: by chance once in 30,000
/// axes.
const AGREE: f64 = 4.0;
/// The wandering zero is averaged over the number of poses divided by this.
const WINDOW: usize = 8;
const NAMES: [&str; 6] = [
    "force x", "force y", "force z", "torque x", "torque y", "torque z",
];

/// A sentence for each axis whose zero wanders, or, if none does, for those that drift. It applies to poses at rest only: they
/// are in order of time, and their readings have no motion in common.
pub(super) fn notes(
    residuals: &[Residual],
    used: &[&Group],
    unknowns: &Unknowns,
    fit: &Solution,
) -> Vec<String> {
    let poses: Vec<&Residual> = residuals
        .iter()
        .filter(|r| r.used && r.pose.is_some())
        .collect();
    let of_axis = |axis: usize| {
        let series: Vec<f64> = poses.iter().map(|r| r.wrench[axis]).collect();
        wanders(&series).map(|range| sentence(axis, range))
    };
    let wandering: Vec<String> = (0..6)
        .filter(|_| poses.len() >= FEWEST)
        .filter_map(of_axis)
        .collect();
    if poses.is_empty() || !wandering.is_empty() {
        return wandering;
    }
    let both = drifts(used, unknowns, fit).into_iter().flatten();
    let told = both.zip([("forces", "N"), ("torques", "N·m")]);
    told.filter_map(|(drift, of)| Some((drift.filter(|drift| drift.p < LEVEL)?, of)))
        .map(|(drift, (what, unit))| straight(&drift, what, unit))
        .collect()
}

/// Range of the averaged series; None unless neighbours are correlated more than by chance.
fn wanders(series: &[f64]) -> Option<f64> {
    let neighbours = autocorrelation(series, 1).get(1).copied()?;
    if neighbours * (series.len() as f64).sqrt() < AGREE {
        return None;
    }
    let window = (series.len() / WINDOW).max(3);
    let means: Vec<f64> = series
        .windows(window)
        .map(|w| w.iter().sum::<f64>() / w.len() as f64)
        .collect();
    let (low, high) = means
        .iter()
        .fold((f64::MAX, f64::MIN), |(l, h), m| (l.min(*m), h.max(*m)));
    Some(high - low)
}

/// What to do about a zero that does not stay.
const ADVICE: &str = "Its interval does not know of it. Let the sensor warm up, go through the poses in another order, and take \
                      the zero (`zero`) before each test.";

fn sentence(axis: usize, range: f64) -> String {
    let unit = if axis < 3 { "N" } else { "N·m" };
    format!(
        "What is left of {} wanders by {} {unit} from pose to pose: a drift of the zero, or poses \
         that went one way. {ADVICE}",
        NAMES[axis],
        number::significant(range, 2)
    )
}

fn straight(drift: &Drift, what: &str, unit: &str) -> String {
    let [x, y, z] = drift.over.map(|over| number::significant(over, 2));
    format!(
        "The zero of the {what} drifts by ({x}, {y}, {z}) {unit} from the first pose to the last, beside what the tool explains. \
         {ADVICE}"
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use softdock_statistics::RandomStream;

    #[test]
    fn a_drift_is_told_and_noise_is_not() {
        let mut noise = RandomStream::new(1, 0);
        let mut false_alarms = 0;
        for _ in 0..300 {
            let quiet: Vec<f64> = (0..40).map(|_| noise.normal()).collect();
            false_alarms += u32::from(wanders(&quiet).is_some());
            let drifting: Vec<f64> = (0..40)
                .map(|n| f64::from(n) * 0.1 + noise.normal())
                .collect();
            let range = wanders(&drifting).unwrap();
            assert!((2.0..5.5).contains(&range), "{range}");
        }
        assert_eq!(false_alarms, 0);
    }
}
