//! The answer of a calibration.

use super::drift::{self, Residual};
use super::equations::{AT_REST, BIAS, INERTIA, MASS, MOMENT, Unknowns};
use super::least_squares::Solution;
use super::observation::{Group, Observation};
use super::source::{Mounting, Reading};
use super::standstill;
use anyhow::{Result, bail};
use nalgebra::{DMatrix, DVector, Matrix3, Vector3};
use serde::Serialize;
use softdock_control::frames::{Twist, components, pose_components};
use softdock_control::settings::SensorSettings;
use softdock_control::wrench::{Compensation, Motion};
use softdock_report::number;
use softdock_statistics::rms;

/// Two-sided 95 %.
const CONFIDENCE: f64 = 0.975;

/// What the sensor carries and reads at rest. SI units; numbers of the sensor in its axes S.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Calibration {
    /// Mass of everything beyond the sensor, kg.
    pub mass_kg: f64,
    /// Its centre of mass in S, m.
    pub com_m: [f64; 3],
    /// Zero-load reading: three forces (N), three torques (N·m).
    pub bias: [f64; 6],
    /// Inertia tensor about the centre of mass, kg·m²; None if it was not asked for.
    pub inertia_kg_m2: Option<[[f64; 3]; 3]>,
    /// Gravity in C, m/s², as given or found.
    pub gravity_m_s2: [f64; 3],
    /// By how much the measured pose is older than the wrench, s; None of poses at rest.
    pub pose_age_s: Option<f64>,
    /// 95 % intervals.
    pub intervals: Intervals,
    /// Root mean square of what is left of a force, N: of poses that the fit has not seen, if some
    /// were kept back.
    pub residual_rms_n: f64,
    /// The same of a torque, N·m.
    pub residual_rms_n_m: f64,
    /// The same by axis: three forces, three torques.
    pub residual_rms_per_axis: [f64; 6],
    /// Root mean square of the residuals of the poses of the fit, by axis.
    pub fit_rms_per_axis: [f64; 6],
    /// Poses that were kept back.
    pub unseen: usize,
    /// Ratio of the largest to the smallest singular value of the problem, its rows in units of
    /// the noise, its columns of one length: 1 is best.
    pub condition: f64,
    /// Poses, or parts of a motion, that were used.
    pub used: usize,
    /// Those that contradict the others.
    pub left_out: Vec<LeftOut>,
    /// What the user should know.
    pub notes: Vec<String>,
    /// The sensor's place, as it was taken.
    #[serde(skip)]
    pub mounting: Mounting,
    /// What is left of every observation, left-out ones included.
    #[serde(skip)]
    pub residuals: Vec<Residual>,
}

/// 95 % intervals, low and high.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Intervals {
    /// Of the mass.
    pub mass_kg: [f64; 2],
    /// Of the centre of mass.
    pub com_m: [[f64; 2]; 3],
    /// Of the zero.
    pub bias: [[f64; 2]; 6],
    /// Of the inertia.
    pub inertia_kg_m2: Option<[[[f64; 2]; 3]; 3]>,
    /// Half of the interval of the direction of gravity, rad, about two axes across it.
    pub gravity_rad: Option<[f64; 2]>,
}

/// A part of the recording that contradicts the others.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LeftOut {
    /// Number of the pose, from 1, if it is one.
    pub pose: Option<usize>,
    /// From, s.
    pub from_s: f64,
    /// To, s.
    pub to_s: f64,
    /// What is left of its force, root mean square of its length, N.
    pub force_n: f64,
    /// Residual torque, N·m.
    pub torque_n_m: f64,
}

impl LeftOut {
    /// In words.
    pub fn sentence(&self) -> String {
        let place = match self.pose {
            Some(pose) => format!("pose {pose} at {:.1} s", self.from_s),
            None => format!("{:.1} s to {:.1} s", self.from_s, self.to_s),
        };
        format!(
            "{place} contradicts the others by {} N and {} N·m and was left out",
            number::significant(self.force_n, 2),
            number::significant(self.torque_n_m, 2)
        )
    }
}

impl Calibration {
    pub(super) fn new(
        fit: &Solution,
        groups: &[Group],
        kept: &[usize],
        mounting: &Mounting,
        unknowns: &Unknowns,
    ) -> Self {
        let load = Load::new(&fit.values, unknowns);
        let residuals = residuals(fit, groups, kept, unknowns);
        let per_axis = rms_per_axis(&residuals);
        let used: Vec<&Group> = kept.iter().map(|n| &groups[*n]).collect();
        let notes = drift::notes(&residuals, &used, unknowns, fit);
        let left_out = (0..groups.len())
            .filter(|n| !kept.contains(n))
            .map(|n| left_out(fit, &groups[n], unknowns));
        Self {
            mass_kg: load.mass,
            com_m: components(&load.com),
            bias: fit.bias(),
            inertia_kg_m2: load.inertia.map(|i| rows_of(&i)),
            gravity_m_s2: components(&fit.gravity.vector),
            pose_age_s: None,
            intervals: intervals(fit, unknowns),
            residual_rms_n: rms(&per_axis[..3]),
            residual_rms_n_m: rms(&per_axis[3..]),
            residual_rms_per_axis: per_axis,
            fit_rms_per_axis: per_axis,
            unseen: 0,
            condition: fit.condition,
            used: kept.len(),
            left_out: left_out.collect(),
            notes,
            mounting: *mounting,
            residuals,
        }
    }

    /// The settings of the board's compensation that follow, as far as they are known.
    pub fn settings(&self) -> SensorSettings {
        let [x, y, z, qw, qx, qy, qz] = pose_components(&self.mounting.m_from_s);
        SensorSettings {
            position_m: [x, y, z],
            orientation_wxyz: [qw, qx, qy, qz],
            bias: self.bias,
            gravity_m_s2: self.gravity_m_s2,
            tool_mass_kg: self.mass_kg,
            tool_com_m: self.com_m,
            tool_inertia_kg_m2: self.inertia_kg_m2.unwrap_or_default(),
            ..SensorSettings::default()
        }
    }

    /// Judges the answer by poses at rest that it has not seen, with the board's own code. An
    /// outlier counts here.
    ///
    /// # Errors
    ///
    /// There is no pose at rest.
    pub fn judge(&mut self, readings: &[Reading], at_rest: bool) -> Result<()> {
        let compensation = Compensation::<f64>::new(&self.settings());
        let still = Motion {
            velocity: Twist::zero(),
            acceleration: Twist::zero(),
        };
        let groups = standstill::groups(readings, &self.mounting, at_rest)?;
        let left = |observation: &Observation| {
            let c_from_m = observation.c_from_s * self.mounting.m_from_s.rotation.inverse();
            let left = compensation.compensate(&observation.wrench, &c_from_m, &still);
            left.contact_in_s.get()
        };
        let all: Vec<[f64; 6]> = groups
            .iter()
            .flat_map(|g| g.observations.iter().map(left))
            .collect();
        let of_axis = |axis: usize| rms(&all.iter().map(|w| w[axis]).collect::<Vec<_>>());
        let per_axis: [f64; 6] = std::array::from_fn(of_axis);
        self.residual_rms_n = rms(&per_axis[..3]);
        self.residual_rms_n_m = rms(&per_axis[3..]);
        self.residual_rms_per_axis = per_axis;
        self.unseen = all.len();
        Ok(())
    }

    /// Refuses an answer that no tool can have.
    pub(super) fn check(&self) -> Result<()> {
        let [low, high] = self.intervals.mass_kg;
        if high < 0.0 {
            bail!(
                "the mass comes out as {} kg: the weight points up. Is the sign of gravity right \
                 (--gravity), or does the sensor read what the robot exerts on the tool?",
                number::significant(self.mass_kg, 3)
            );
        }
        if low <= 0.0 {
            bail!(
                "the mass comes out as {} kg, which could be nothing at all ({}): no weight turns \
                 with the poses. Are pose and wrench of the same robot and the same time?",
                number::significant(self.mass_kg, 2),
                number::interval(low, high, 2)
            );
        }
        Ok(())
    }
}

/// The load that the unknowns describe.
struct Load {
    mass: f64,
    com: Vector3<f64>,
    inertia: Option<Matrix3<f64>>,
}

impl Load {
    fn new(values: &DVector<f64>, unknowns: &Unknowns) -> Self {
        let mass = values[MASS];
        let moment = Vector3::new(values[MOMENT], values[MOMENT + 1], values[MOMENT + 2]);
        let com = moment / mass;
        let inertia = unknowns.inertia.then(|| {
            let mut about_sensor = Matrix3::zeros();
            for (k, (i, j)) in INERTIA.into_iter().enumerate() {
                about_sensor[(i, j)] = values[AT_REST + k];
                about_sensor[(j, i)] = values[AT_REST + k];
            }
            // Parallel axes: J = I + m (c² 1 − c cᵀ) = I − m [c]×².
            let arm = com.cross_matrix();
            about_sensor + arm * arm * mass
        });
        Self { mass, com, inertia }
    }

    /// Mass, centre of mass and inertia as one list.
    fn in_a_row(&self) -> Vec<f64> {
        let mut all = vec![self.mass, self.com.x, self.com.y, self.com.z];
        if let Some(inertia) = &self.inertia {
            all.extend(INERTIA.map(|at| inertia[at]));
        }
        all
    }
}

fn rows_of(matrix: &Matrix3<f64>) -> [[f64; 3]; 3] {
    std::array::from_fn(|i| std::array::from_fn(|k| matrix[(i, k)]))
}

fn intervals(fit: &Solution, unknowns: &Unknowns) -> Intervals {
    let of_force = student(fit.freedom[0]);
    let of_torque = student(fit.freedom[1]);
    // Where forces and torques both contribute, the smaller number of degrees of freedom counts.
    let of_both = of_force.max(of_torque);
    let values = Load::new(&fit.values, unknowns).in_a_row();
    let spread = spread(fit, unknowns);
    let around =
        |value: f64, sigma: f64, times: f64| [value - times * sigma, value + times * sigma];
    let physical: Vec<[f64; 2]> = values
        .iter()
        .zip(&spread)
        .enumerate()
        .map(|(k, (value, sigma))| around(*value, *sigma, if k == 0 { of_force } else { of_both }))
        .collect();
    let sigma = |k: usize| fit.covariance[(k, k)].max(0.0).sqrt();
    let inertia = unknowns.inertia.then(|| {
        let mut all = [[[0.0; 2]; 3]; 3];
        for (k, (i, j)) in INERTIA.into_iter().enumerate() {
            all[i][j] = physical[4 + k];
            all[j][i] = physical[4 + k];
        }
        all
    });
    let tilt = unknowns.tilt_at();
    Intervals {
        mass_kg: physical[0],
        com_m: [physical[1], physical[2], physical[3]],
        bias: std::array::from_fn(|k| {
            let times = if k < 3 { of_force } else { of_torque };
            around(fit.values[BIAS + k], sigma(BIAS + k), times)
        }),
        inertia_kg_m2: inertia,
        gravity_rad: unknowns
            .tilt
            .then(|| [of_force * sigma(tilt), of_force * sigma(tilt + 1)]),
    }
}

/// Standard deviations of mass, centre of mass and inertia, by their derivatives.
fn spread(fit: &Solution, unknowns: &Unknowns) -> Vec<f64> {
    let centre = Load::new(&fit.values, unknowns).in_a_row();
    let count = unknowns.count();
    let mut slopes = DMatrix::zeros(centre.len(), count);
    for k in 0..count {
        let sigma = fit.covariance[(k, k)].max(0.0).sqrt();
        // A step well inside of the noise, and above round-off.
        let step = (0.01 * sigma).max(1e-7 * fit.values[k].abs()).max(1e-12);
        let mut moved = fit.values.clone();
        moved[k] += step;
        let other = Load::new(&moved, unknowns).in_a_row();
        for (row, (a, b)) in other.iter().zip(&centre).enumerate() {
            slopes[(row, k)] = (a - b) / step;
        }
    }
    let covariance = &slopes * &fit.covariance * slopes.transpose();
    covariance
        .diagonal()
        .iter()
        .map(|v| v.max(0.0).sqrt())
        .collect()
}

/// Student's factor of a 95 % interval.
fn student(freedom: f64) -> f64 {
    use statrs::distribution::{ContinuousCDF, StudentsT};
    StudentsT::new(0.0, 1.0, freedom.max(1.0)).map_or(f64::INFINITY, |t| t.inverse_cdf(CONFIDENCE))
}

fn residuals(
    fit: &Solution,
    groups: &[Group],
    kept: &[usize],
    unknowns: &Unknowns,
) -> Vec<Residual> {
    let mut all = Vec::new();
    for (n, group) in groups.iter().enumerate() {
        let count = group.observations.len();
        let [from, to] = group.time_s;
        for (k, observation) in group.observations.iter().enumerate() {
            let error = fit.error(observation, unknowns);
            all.push(Residual {
                time_s: from + (to - from) * k as f64 / count.saturating_sub(1).max(1) as f64,
                pose: group.pose,
                used: kept.contains(&n),
                wrench: std::array::from_fn(|i| error[i]),
            });
        }
    }
    all
}

fn rms_per_axis(residuals: &[Residual]) -> [f64; 6] {
    let used: Vec<&Residual> = residuals.iter().filter(|r| r.used).collect();
    std::array::from_fn(|axis| rms(&used.iter().map(|r| r.wrench[axis]).collect::<Vec<_>>()))
}

fn left_out(fit: &Solution, group: &Group, unknowns: &Unknowns) -> LeftOut {
    let errors: Vec<DVector<f64>> = group
        .observations
        .iter()
        .map(|o| fit.error(o, unknowns))
        .collect();
    let length = |from: usize| {
        let squares: f64 = errors.iter().map(|e| e.rows(from, 3).norm_squared()).sum();
        (squares / errors.len().max(1) as f64).sqrt()
    };
    LeftOut {
        pose: group.pose,
        from_s: group.time_s[0],
        to_s: group.time_s[1],
        force_n: length(0),
        torque_n_m: length(3),
    }
}
