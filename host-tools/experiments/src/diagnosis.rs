//! The built-in test for a diagnosis: a pair of a recording to fit and one that the fit has not seen.

use super::scenario::Scenario;
use anyhow::Result;
use softdock_io::input;
use softdock_physics::model::Model;
use softdock_rig::rig::Hidden;

/// The scenario, as the `run` command takes it.
pub const SCENARIO: &str = include_str!("../../scenarios/diagnosis.toml");
/// The nominal model of its rig.
pub const MODEL: &str = include_str!("../../scenarios/diagnosis.model.toml");

/// Speed of the unseen run, m/s: of another magnitude and in the other direction.
const UNSEEN_SPEED_M_S: f64 = -0.047;
/// Difference of the unseen run's seed, so that each seed of a user gives it other noise.
const UNSEEN_SEED: u64 = 0x5eed_0000;

/// One recording of the pair.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// The recording that is fitted.
    Train,
    /// The recording that the fit does not see: other initial motion, other noise.
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

/// The nominal model of the rig, without hidden effects.
///
/// # Errors
/// None: the built-in text is valid.
pub fn model() -> Result<Model> {
    Model::from_toml(MODEL, "built-in diagnosis model")
}
