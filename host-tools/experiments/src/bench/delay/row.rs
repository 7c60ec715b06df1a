//! A row of the benchmark: one law on one case at one speed, over all instants of the touch.

use super::case::Case;
use super::limits::Limits;
use super::measure::{Ending, Numbers};
use serde::Serialize;
use softdock_control::delay::LawName;

/// One law on one case at one speed. Each number is that of the worst touch: the farthest from its ideal value.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// The case.
    pub case: String,
    /// The sweep that it belongs to.
    pub sweep: &'static str,
    /// The law.
    pub law: LawName,
    /// Structure of the robot.
    pub actuator: &'static str,
    /// Speed of the approach, mm/s.
    pub speed_mm_s: f64,
    /// Speed after over speed before, along the normal; after an even number of impacts, along the first approach. Where the
    /// normal changes, the root of the ratio of energies.
    pub restitution: f64,
    /// Restitution of the robot by its executed motion: a law may report a good rebound of the model and lead the robot
    /// elsewhere. None where the normal changes.
    pub robot_restitution: Option<f64>,
    /// Restitution of the ideal test.
    pub expected_restitution: f64,
    /// Kinetic energy after over before, less the ideal ratio.
    pub energy_error: f64,
    /// Largest true force over the ideal one, less 1.
    pub peak_force_error: f64,
    /// Time in contact over the ideal one, less 1.
    pub contact_time_error: f64,
    /// (∫ measured force dt − m Δv of the model) / (2 m v0): momentum of the model that no measured force accounts for.
    pub impulse_unaccounted: f64,
    /// Error of a spacecraft's velocity over the speed of approach, rotations at 0.3 m.
    pub velocity_error: f64,
    /// Mean restitution over the touches.
    pub restitution_mean: f64,
    /// Standard deviation of the restitution over the touches.
    pub restitution_sd: f64,
    /// Error of the executed position: RMS over the ideal RMS.
    pub tracking_nrms: Option<f64>,
    /// Largest error of the executed position over v0/ω.
    pub tracking_peak: Option<f64>,
    /// Largest command over the speed of approach.
    pub command_peak: f64,
    /// Number of instants of the touch within a cycle.
    pub touches: usize,
    /// Runs that ran away, stuck, or missed an impact.
    pub failed: usize,
    /// The worst ending.
    pub ending: Ending,
    /// Limits that hold for every law.
    pub limits: Option<Limits>,
}

/// The runs of all touches.
struct Runs<'a>(&'a [Numbers]);

impl Runs<'_> {
    /// The value that is farthest from `from`; without any run `from`.
    fn worst(&self, pick: fn(&Numbers) -> f64, from: f64) -> f64 {
        let farther = |a: f64, b: f64| {
            if (b - from).abs() > (a - from).abs() {
                b
            } else {
                a
            }
        };
        let values = self.0.iter().map(pick);
        values.reduce(farther).unwrap_or(from)
    }

    /// The robot's restitution that is farthest from the expected one; None where no run has one.
    fn robot_restitution(&self, expected: f64) -> Option<f64> {
        let robots = self.0.iter().filter_map(|r| r.robot_restitution);
        robots.max_by(|a, b| (a - expected).abs().total_cmp(&(b - expected).abs()))
    }

    fn restitution_mean_and_sd(&self) -> (f64, f64) {
        let restitutions = || self.0.iter().map(|r| r.restitution);
        let count = self.0.len().max(1) as f64;
        let mean = restitutions().sum::<f64>() / count;
        let squares: f64 = restitutions().map(|e| (e - mean).powi(2)).sum();
        (mean, (squares / count).sqrt())
    }

    /// The largest tracking error; None unless the bounce has a closed form.
    fn tracking(&self, pick: fn((f64, f64)) -> f64) -> Option<f64> {
        let values = self.0.iter().filter_map(|r| r.tracking.map(pick));
        values.reduce(f64::max)
    }

    fn failed(&self) -> usize {
        let failed = self.0.iter().filter(|r| r.ending != Ending::Ended);
        failed.count()
    }

    /// The worst ending.
    fn ending(&self) -> Ending {
        let endings = self.0.iter().map(|r| r.ending);
        endings.max().unwrap_or(Ending::NoContact)
    }
}

impl Row {
    /// Summarises the runs of all touches.
    pub fn new(
        case: &Case,
        law: LawName,
        speed_mm_s: f64,
        expected: f64,
        limits: Option<Limits>,
        runs: &[Numbers],
    ) -> Self {
        let runs = Runs(runs);
        let (restitution_mean, restitution_sd) = runs.restitution_mean_and_sd();
        Self {
            case: case.name.clone(),
            sweep: case.sweep,
            law,
            actuator: case.robot.name,
            speed_mm_s,
            restitution: runs.worst(|r| r.restitution, expected),
            robot_restitution: runs.robot_restitution(expected),
            expected_restitution: expected,
            energy_error: runs.worst(|r| r.energy_error, 0.0),
            peak_force_error: runs.worst(|r| r.peak_force_error, 0.0),
            contact_time_error: runs.worst(|r| r.contact_time_error, 0.0),
            impulse_unaccounted: runs.worst(|r| r.impulse_unaccounted, 0.0),
            velocity_error: runs.worst(|r| r.velocity_error, 0.0),
            restitution_mean,
            restitution_sd,
            tracking_nrms: runs.tracking(|t| t.0),
            tracking_peak: runs.tracking(|t| t.1),
            command_peak: runs.worst(|r| r.command_peak, 0.0),
            touches: runs.0.len(),
            failed: runs.failed(),
            ending: runs.ending(),
            limits,
        }
    }

    /// How far the worst restitution is from the ideal one.
    pub fn restitution_error(&self) -> f64 {
        self.restitution - self.expected_restitution
    }

    /// Magnitude of that error.
    pub fn error(&self) -> f64 {
        self.restitution_error().abs()
    }

    /// The same error of the robot's restitution; 0 where there is none.
    pub fn robot_restitution_error(&self) -> f64 {
        self.robot_restitution
            .map_or(0.0, |e| e - self.expected_restitution)
    }
}
