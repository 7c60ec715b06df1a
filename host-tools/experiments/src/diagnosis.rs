//! The test that a diagnosis learns from: the built-in scenario, as a pair of a recording to fit
//! and one that the fit has not seen.

use super::scenario::Scenario;
use anyhow::Result;
use softdock_io::input;
use softdock_physics::model::Model;
use softdock_rig::rig::Hidden;

/// The scenario, as the `run` command takes it.
pub const SCENARIO: &str = include_str!("../../scenarios/diagnosis.toml");
/// What is known of its rig.
pub const MODEL: &str = include_str!("../../scenarios/diagnosis.model.toml");

/// Speed of the unseen run, m/s: another one, in the other direction.
const UNSEEN_SPEED_M_S: f64 = -0.047;
/// What its seed differs by: noise of its own for each seed of a user.
const UNSEEN_SEED: u64 = 0x5eed_0000;

/// Which recording of the pair.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// The one that is fitted.
    Train,
    /// The one that the fit does not see: other initial motion, other noise.
    Test,
}

/// The scenario with a rig that hides these effects.
///
/// # Errors
/// An effect that does not exist or that the rig cannot hide.
pub fn scenario(part: Part, hidden: &[Hidden], seed: u64) -> Result<Scenario> {
    let mut scenario: Scenario = input::parse(SCENARIO, "built-in diagnosis scenario")?;
    scenario.seed = seed;
    if part == Part::Test {
        scenario = scenario.with_speed(UNSEEN_SPEED_M_S)?;
        scenario.seed = seed.wrapping_add(UNSEEN_SEED);
        let rate = &mut scenario.board.control.body_k.angular_velocity_rad_s;
        *rate = rate.map(|component| -0.8 * component);
    }
    scenario.rig.hidden.extend_from_slice(hidden);
    scenario.validate()?;
    Ok(scenario)
}

/// The model of its rig without what it hides.
///
/// # Errors
/// None, as long as the built-in text is a model.
pub fn model() -> Result<Model> {
    Model::from_toml(MODEL, "built-in diagnosis model")
}
