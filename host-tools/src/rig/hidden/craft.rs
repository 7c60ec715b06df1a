//! Hidden errors of the simulated craft: the board computes another craft than the model says.

use super::{Hidden, find};
use crate::rig::checks::prefixed;
use anyhow::{Result, ensure};
use nalgebra::Vector3;
use softdock_control::effects::body::sc_inertia_error::InertiaError;
use softdock_control::effects::body::sc_mass_error::MassError;
use softdock_control::effects::mechanism::manipulator_resistance::ManipulatorResistance;
use softdock_control::settings::{BodySettings, Settings};

/// Changes the settings of craft K, the one that the robot moves, as hidden effects say.
///
/// # Errors
/// The craft would have no positive mass or inertia, or the board cannot compute the effect.
pub fn apply(hidden: &[Hidden], settings: &mut Settings) -> Result<()> {
    let body = &mut settings.body_k;
    if let Some(resistance) = find(hidden, "manipulator_resistance") {
        resist(resistance, body)?;
    }
    if let Some(error) = find(hidden, "sc_mass_error") {
        let error_kg = error.value("mass_error_kg");
        let built = MassError::<f64>::new(body.mass_kg, error_kg);
        prefixed("rig.hidden sc_mass_error.", built)?;
        body.mass_kg += error_kg;
    }
    if let Some(error) = find(hidden, "sc_inertia_error") {
        let errors = error.values(["ixx_kg_m2", "iyy_kg_m2", "izz_kg_m2"]);
        let built = InertiaError::<f64>::new(&body.inertia_kg_m2, &errors);
        prefixed("rig.hidden sc_inertia_error.", built)?;
        for (axis, error_kg_m2) in errors.into_iter().enumerate() {
            body.inertia_kg_m2[axis][axis] += error_kg_m2;
        }
    }
    Ok(())
}

/// The board knows the manipulator as a constant acceleration a_ARM only: the resistance at the
/// start, where the spring is relaxed and the craft has its initial velocity.
fn resist(resistance: &Hidden, body: &mut BodySettings) -> Result<()> {
    let [stiffness, damping] = resistance.values(["stiffness_n_per_m", "damping_n_s_per_m"]);
    let built = ManipulatorResistance::<f64>::new(stiffness, damping);
    let law = prefixed("rig.hidden manipulator_resistance.", built)?;
    let start = Vector3::from(body.velocity_m_s);
    let force = start.map(|speed| law.force(0.0, speed));
    ensure!(
        force != Vector3::zeros(),
        "`manipulator_resistance` does nothing: the board knows it as a constant acceleration only, \
         which is the damping at the initial velocity; give `damping_n_s_per_m` and \
         `board.control.body_k.velocity_m_s`"
    );
    for (axis, acceleration) in body.arm_acceleration_m_s2.iter_mut().enumerate() {
        *acceleration += force[axis] / body.mass_kg;
    }
    Ok(())
}
