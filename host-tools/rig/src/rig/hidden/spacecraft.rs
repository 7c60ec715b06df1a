//! Hidden errors of the simulated spacecraft: the board computes another spacecraft than the model says.

use super::{Hidden, find};
use crate::rig::checks::prefixed;
use anyhow::Result;
use softdock_control::manipulator::ManipulatorResistance;
use softdock_control::settings::Settings;
use softdock_physics::effects::body::sc_inertia_error::InertiaError;
use softdock_physics::effects::body::sc_mass_error::MassError;

/// Whether an effect is one of the spacecraft, which the board computes and no rig can hide.
pub fn concerns(hidden: &Hidden) -> bool {
    let nominal = Settings::default();
    let mut changed = nominal.clone();
    let applied = apply(std::slice::from_ref(hidden), &mut changed);
    applied.is_err() || changed != nominal
}

/// Changes the settings of spacecraft K, the one that the robot moves, as hidden effects say.
///
/// # Errors
/// The spacecraft would have no positive mass or inertia, or a resistance that pushes.
pub fn apply(hidden: &[Hidden], settings: &mut Settings) -> Result<()> {
    let body = &mut settings.body_k;
    if let Some(resistance) = find(hidden, "manipulator_resistance") {
        let [stiffness, damping] = resistance.values(["stiffness_n_per_m", "damping_n_s_per_m"]);
        let built = ManipulatorResistance::<f64>::new(stiffness, damping);
        prefixed("rig.hidden manipulator_resistance.", built)?;
        body.arm_stiffness_n_per_m += stiffness;
        body.arm_damping_n_s_per_m += damping;
    }
    if let Some(error) = find(hidden, "sc_mass_error") {
        let error_kg = error.value("mass_error_kg");
        let built = MassError::new(body.mass_kg, error_kg);
        prefixed("rig.hidden sc_mass_error.", built)?;
        body.mass_kg += error_kg;
    }
    if let Some(error) = find(hidden, "sc_inertia_error") {
        let errors = error.values(["ixx_kg_m2", "iyy_kg_m2", "izz_kg_m2"]);
        let built = InertiaError::new(&body.inertia_kg_m2, &errors);
        prefixed("rig.hidden sc_inertia_error.", built)?;
        for (axis, error_kg_m2) in errors.into_iter().enumerate() {
            body.inertia_kg_m2[axis][axis] += error_kg_m2;
        }
    }
    Ok(())
}
