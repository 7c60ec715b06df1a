//! Mass, centre of mass and inertia of the tool and the sensor's zero, from readings in several
//! poses.
//!
//! - `source` delivers readings: pose and raw wrench.
//! - `standstill` finds the poses at rest in them, `motion` takes all of them with the motion;
//!   either makes groups of observations that are judged together.
//! - `equations` is what the sensor should read, linear in the unknowns; `least_squares` solves it,
//!   with intervals and the condition of the problem.
//! - `outliers` leaves out groups in which somebody leaned on the tool.
//! - `advice` says which pose is missing, `plan` which poses to take, `live` which comes next while
//!   the robot is there.
//! - `outcome` is the answer, `tables` and `settings` write it down.
//!
//! The signs are those of the board's own compensation: [`Calibration::settings`] in
//! [`softdock_control::wrench::Compensation`] leaves nothing of readings without noise.
//!
//! Source: Kubus, Kröger, Wahl, IROS 2008 (joint least squares of the ten parameters of a rigid
//! load and the sensor's zero); Atkeson, An, Hollerbach, IJRR 5(3), 1986 (its linear form).

mod advice;
mod drift;
mod equations;
mod gravity;
mod least_squares;
pub mod live;
mod motion;
mod observation;
mod outcome;
mod outliers;
pub mod plan;
mod settings;
pub mod source;
mod standstill;
mod tables;
#[cfg(test)]
mod tests;

pub use drift::Residual;
pub use outcome::{Calibration, Intervals, LeftOut};
pub use standstill::rests;

use anyhow::{Result, bail, ensure};
use equations::Unknowns;
use gravity::Gravity;
use least_squares::{Solution, solve};
use motion::Stretch;
use nalgebra::Vector3;
use observation::Group;
use softdock_physics::optimise::lowest_valley;
use source::{Mounting, Reading};

/// Condition beyond which a set of poses is refused: the noise of a hundredth of the weight would
/// be half of the answer.
pub const WORST_CONDITION: f64 = 50.0;

/// Steps of the search for the age of the pose.
const AGES: u32 = 10;
/// How closely the best is found, in these steps.
const TOLERANCE: f64 = 0.005;

/// What a calibration is to find, and under which assumptions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ask {
    /// Gravity in C, m/s².
    pub gravity_m_s2: [f64; 3],
    /// Only its length is known; the direction is to be found.
    pub estimate_gravity: bool,
    /// Every reading is a pose at rest.
    pub at_rest: bool,
    /// The tool's inertia is to be found from its motion.
    pub inertia: bool,
}

/// Calibrates from readings.
///
/// # Errors
///
/// Too few poses, poses that do not determine the answer (the error says which pose to add), or
/// readings that no tool explains.
pub fn calibrate(readings: &[Reading], mounting: &Mounting, ask: &Ask) -> Result<Calibration> {
    let length = Vector3::from(ask.gravity_m_s2).norm();
    ensure!(
        (1.0..=20.0).contains(&length),
        "gravity is {length:.3} m/s² long; expected about 9.81 (a direction alone is not enough)"
    );
    let problem = Problem {
        unknowns: Unknowns {
            inertia: ask.inertia,
            tilt: ask.estimate_gravity,
        },
        gravity: Gravity::new(ask.gravity_m_s2),
        mounting,
    };
    if !ask.inertia {
        let mut calibration =
            problem.solved(&standstill::groups(readings, mounting, ask.at_rest)?)?;
        if !ask.at_rest {
            calibration.notes.extend(standstill::unused(readings));
        }
        return Ok(calibration);
    }
    let stretches = motion::stretches(readings, mounting)?;
    let age_s = problem.age_s(&stretches)?;
    let mut calibration = problem.solved(&motion::groups(&stretches, age_s))?;
    calibration.pose_age_s = Some(age_s);
    Ok(calibration)
}

/// Unknowns and known quantities of a calibration.
struct Problem<'a> {
    unknowns: Unknowns,
    gravity: Gravity,
    mounting: &'a Mounting,
}

impl Problem<'_> {
    fn solved(&self, groups: &[Group]) -> Result<Calibration> {
        let gravity = self.start(groups)?;
        advice::enough(groups, &self.unknowns, &gravity)?;
        let (fit, kept) = outliers::robust(groups, &self.unknowns, &gravity)?;
        let used: Vec<Group> = kept.iter().map(|n| groups[*n].clone()).collect();
        advice::enough(&used, &self.unknowns, &fit.gravity)?;
        self.check_condition(&fit, &used)?;
        let calibration = Calibration::new(&fit, groups, &kept, self.mounting, &self.unknowns);
        calibration.check()?;
        Ok(calibration)
    }

    /// Gravity to begin with.
    fn start(&self, groups: &[Group]) -> Result<Gravity> {
        if !self.unknowns.tilt {
            return Ok(self.gravity);
        }
        advice::both_tilts(groups)?;
        Ok(self.gravity.found_in(groups))
    }

    /// By how much the measured pose is older than the wrench, s: the age that leaves the least noise.
    fn age_s(&self, stretches: &[Stretch<'_>]) -> Result<f64> {
        let now = motion::groups(stretches, 0.0);
        let gravity = self.start(&now)?;
        advice::enough(&now, &self.unknowns, &gravity)?;
        let noise = |age_s: f64| {
            let groups = motion::groups(stretches, age_s);
            let [force, torque] = solve(&groups, &self.unknowns, &gravity).sigma;
            force.ln() + torque.ln()
        };
        let (age_s, _) = lowest_valley((0.0, motion::OLDEST_S), AGES, TOLERANCE, noise);
        Ok(age_s)
    }

    /// Refuses poses for which the answer would be noise.
    fn check_condition(&self, fit: &Solution, groups: &[Group]) -> Result<()> {
        if fit.condition <= WORST_CONDITION {
            return Ok(());
        }
        bail!(
            "the poses hardly differ for what is asked: the condition number of the problem is {:.0}, at \
             most {WORST_CONDITION:.0} is accepted; {}. {}",
            fit.condition,
            fit.weakest.sentence(),
            advice::best_addition(groups, &self.unknowns, &fit.gravity)
        )
    }
}
