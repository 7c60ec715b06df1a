//! Outcome of a run, computed while it runs: nothing is recorded.

use crate::impacts::{Impact, ImpactFinder};
use crate::run::RunStatistics;
use crate::scenario::Scenario;
use nalgebra::{ComplexField, Quaternion, UnitQuaternion, Vector3};
use serde::{Deserialize, Serialize};
use softdock_app::record::CycleRecord;
use softdock_control::io::Trace;
use softdock_io::recording::TruthRecord;
use softdock_mechanism::Loads;

/// Whether a row has outcomes, or why not.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Status {
    /// The run went to its end, or until the robot stopped waiting for answers.
    #[default]
    Completed,
    /// The factors give settings that are not valid.
    Refused,
    /// The run failed with an error.
    Failed,
    /// The run panicked: the program has a defect.
    Panicked,
}

impl Status {
    /// The word for this status in tables.
    pub fn word(self) -> &'static str {
        match self {
            Self::Completed => "completed",
            Self::Refused => "refused",
            Self::Failed => "failed",
            Self::Panicked => "panicked",
        }
    }
}

/// Outcome of a row. Errors are those of the first impact, relative to the analytic bounce.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Outcome {
    /// Whether the row has the outcomes below.
    pub status: Status,
    /// Why the row has no outcomes; None if it has.
    pub reason: Option<String>,
    /// Cycles that were run.
    pub cycles: u64,
    /// Number of complete impacts.
    pub impacts: u64,
    /// Whether the mechanism captured; None if the rig has none that can capture.
    pub captured: Option<bool>,
    /// Time of the capture, s from the start of the run.
    pub captured_s: Option<f64>,
    /// Largest force that pushed the docking planes apart, N; this and the next four are None without a docking mechanism.
    pub compression_n: Option<f64>,
    /// Largest force that pulled the docking planes together, N.
    pub tension_n: Option<f64>,
    /// Largest force across the docking axis, N.
    pub shear_n: Option<f64>,
    /// Largest torque about the docking axis, N·m.
    pub torsion_n_m: Option<f64>,
    /// Largest torque across the docking axis, N·m.
    pub bending_n_m: Option<f64>,
    /// Closing speed before the first impact, m/s.
    pub speed_in_m_s: Option<f64>,
    /// Separating speed after it, m/s.
    pub speed_out_m_s: Option<f64>,
    /// Speed out over speed in.
    pub restitution: Option<f64>,
    /// Restitution of the analytic bounce.
    pub expected_restitution: Option<f64>,
    /// e² − e_expected².
    pub energy_error: Option<f64>,
    /// Relative error of the largest force.
    pub peak_force_error: Option<f64>,
    /// Relative error of the time in contact.
    pub contact_time_error: Option<f64>,
    /// Momentum of the model that no measured force accounts for, over 2 m v.
    pub impulse_unaccounted: Option<f64>,
    /// Largest true contact force of the run, N.
    pub peak_force_n: Option<f64>,
    /// Largest true contact torque at M, N·m.
    pub peak_torque_n_m: Option<f64>,
    /// Time with contact force, s.
    pub contact_time_s: Option<f64>,
    /// Largest angle of M from its orientation at the start, rad.
    pub max_misalignment_rad: Option<f64>,
    /// Last misfit of the delay law's model, as a share of the signal.
    pub law_misfit: Option<f64>,
    /// The latched fault at the end.
    pub fault: Option<String>,
    /// Mode at the end.
    pub final_mode: Option<String>,
    /// Effects that were hidden; this and the following are None except in a benchmark of the diagnosis.
    pub hidden: Option<String>,
    /// Verdict of the diagnosis, and the effects that it named.
    pub said: Option<String>,
    /// Whether both are right.
    pub right: Option<bool>,
    /// Share of the removable error that is left on unseen data, %.
    pub error_left_percent: Option<f64>,
}

/// A numeric outcome, which limits, quantiles and plots can use.
pub struct Number {
    /// Name of the outcome, which ends with its unit.
    pub name: &'static str,
    /// Meaning of the outcome.
    pub meaning: &'static str,
    /// Reads the value from an outcome.
    pub value: fn(&Outcome) -> Option<f64>,
}

/// All numeric outcomes, in the order of the columns.
pub const NUMBERS: &[Number] = &[
    Number {
        name: "speed_in_m_s",
        meaning: "closing speed before the first impact",
        value: |o| o.speed_in_m_s,
    },
    Number {
        name: "speed_out_m_s",
        meaning: "separating speed after it",
        value: |o| o.speed_out_m_s,
    },
    Number {
        name: "restitution",
        meaning: "speed out over speed in",
        value: |o| o.restitution,
    },
    Number {
        name: "expected_restitution",
        meaning: "of the analytic bounce",
        value: |o| o.expected_restitution,
    },
    Number {
        name: "energy_error",
        meaning: "restitution squared less the expected one squared",
        value: |o| o.energy_error,
    },
    Number {
        name: "peak_force_error",
        meaning: "largest force over the analytic one, less 1",
        value: |o| o.peak_force_error,
    },
    Number {
        name: "contact_time_error",
        meaning: "time in contact over the analytic one, less 1",
        value: |o| o.contact_time_error,
    },
    Number {
        name: "impulse_unaccounted",
        meaning: "momentum that the delay law gave without a measured force, over 2 m v",
        value: |o| o.impulse_unaccounted,
    },
    Number {
        name: "peak_force_n",
        meaning: "largest true contact force of the run",
        value: |o| o.peak_force_n,
    },
    Number {
        name: "peak_torque_n_m",
        meaning: "largest true contact torque of the run, at M",
        value: |o| o.peak_torque_n_m,
    },
    Number {
        name: "contact_time_s",
        meaning: "time with contact force",
        value: |o| o.contact_time_s,
    },
    Number {
        name: "max_misalignment_rad",
        meaning: "largest angle of M from its start",
        value: |o| o.max_misalignment_rad,
    },
    Number {
        name: "captured_s",
        meaning: "when the mechanism captured, from the start of the run",
        value: |o| o.captured_s,
    },
    Number {
        name: "compression_n",
        meaning: "largest force between the docking planes that pushes them apart",
        value: |o| o.compression_n,
    },
    Number {
        name: "tension_n",
        meaning: "largest force that pulls them together",
        value: |o| o.tension_n,
    },
    Number {
        name: "shear_n",
        meaning: "largest force across the docking axis",
        value: |o| o.shear_n,
    },
    Number {
        name: "torsion_n_m",
        meaning: "largest torque about the docking axis",
        value: |o| o.torsion_n_m,
    },
    Number {
        name: "bending_n_m",
        meaning: "largest torque across the docking axis",
        value: |o| o.bending_n_m,
    },
    Number {
        name: "law_misfit",
        meaning: "misfit that the delay law saw last, as a part of the signal",
        value: |o| o.law_misfit,
    },
    Number {
        name: "error_left_percent",
        meaning: "share of the removable error that a diagnosis leaves on unseen data",
        value: |o| o.error_left_percent,
    },
];

impl Outcome {
    /// Outcome of a row without a completed run.
    pub fn failure(status: Status, reason: String) -> Self {
        Self {
            status,
            reason: Some(reason),
            ..Self::default()
        }
    }

    /// The numeric outcome with this name; None if there is no such outcome or the row has no value.
    pub fn number(&self, name: &str) -> Option<f64> {
        let number = NUMBERS.iter().find(|number| number.name == name)?;
        (number.value)(self)
    }
}

/// Computes the outcome of a run while it runs.
pub struct Observer<'a> {
    finder: ImpactFinder<'a>,
    cycle_s: f64,
    /// Whether the rig has a mechanism that may capture.
    docks: bool,
    start: Option<UnitQuaternion<f64>>,
    cycles: u64,
    contact_cycles: u64,
    peak_force_n: f64,
    peak_torque_n_m: f64,
    max_misalignment_rad: f64,
    last: Trace,
}

impl<'a> Observer<'a> {
    /// An observer that has seen no cycle yet.
    pub fn new(scenario: &'a Scenario) -> Self {
        Self {
            finder: ImpactFinder::new(scenario),
            cycle_s: scenario.board.control.robot.cycle_s,
            docks: !scenario.rig.mechanism.docking.is_empty(),
            start: None,
            cycles: 0,
            contact_cycles: 0,
            peak_force_n: 0.0,
            peak_torque_n_m: 0.0,
            max_misalignment_rad: 0.0,
            last: Trace::default(),
        }
    }

    /// Takes the next cycle.
    pub fn push(&mut self, record: &CycleRecord, truth: &TruthRecord) {
        self.finder.push(record, truth);
        self.cycles += 1;
        self.last = record.trace;
        let [x, y, z, a, b, c] = truth.contact_wrench;
        let (force, torque) = (Vector3::new(x, y, z).norm(), Vector3::new(a, b, c).norm());
        self.peak_force_n = self.peak_force_n.max(force);
        self.peak_torque_n_m = self.peak_torque_n_m.max(torque);
        self.contact_cycles += u64::from(force > 0.0);
        let [.., w, i, j, k] = truth.pose;
        let now = UnitQuaternion::new_normalize(Quaternion::new(w, i, j, k));
        let start = *self.start.get_or_insert(now);
        // The vector part of the quaternion is sin(angle/2), accurate for small angles, where acos near 1 is not.
        let vector = (start.inverse() * now).imag().norm().min(1.0);
        self.max_misalignment_rad = self
            .max_misalignment_rad
            .max(2.0 * ComplexField::asin(vector));
    }

    /// The outcome of the run; `statistics` has what the rig reports of its mechanism.
    pub fn finish(self, statistics: &RunStatistics) -> Outcome {
        let impacts = self.finder.finish();
        let first = impacts.first();
        let of = |value: fn(&Impact) -> f64| first.map(value);
        let each = statistics.loads.iter();
        let loads = each.fold(Loads::default(), |all, one| all.largest(one));
        Outcome {
            status: Status::Completed,
            reason: None,
            cycles: self.cycles,
            impacts: impacts.len() as u64,
            captured: self.docks.then_some(statistics.captured_s.is_some()),
            captured_s: statistics.captured_s,
            compression_n: loads.compression_n,
            tension_n: loads.tension_n,
            shear_n: loads.shear_n,
            torsion_n_m: loads.torsion_nm,
            bending_n_m: loads.bending_nm,
            speed_in_m_s: of(|i| i.speed_in_mm_s * 1e-3),
            speed_out_m_s: of(|i| i.speed_out_mm_s * 1e-3),
            restitution: of(|i| i.restitution),
            expected_restitution: of(|i| i.expected_restitution),
            energy_error: of(|i| i.energy_error),
            peak_force_error: of(|i| i.peak_force_error),
            contact_time_error: of(|i| i.contact_time_error),
            impulse_unaccounted: of(|i| i.impulse_unaccounted),
            peak_force_n: Some(self.peak_force_n),
            peak_torque_n_m: Some(self.peak_torque_n_m),
            contact_time_s: Some(self.contact_cycles as f64 * self.cycle_s),
            max_misalignment_rad: Some(self.max_misalignment_rad),
            law_misfit: Some(self.last.law_status.misfit),
            fault: self.last.fault.map(|fault| format!("{:?}", fault.code)),
            final_mode: Some(format!("{:?}", self.last.mode)),
            ..Outcome::default()
        }
    }
}
