//! Files to start from: a scenario with its board, its rig and its model, each as the commands take it.

use super::diagnosis::{MODEL, SCENARIO};
use anyhow::{Context, Result};
use softdock_app::settings::BoardSettings;
use softdock_io::input;
use toml_edit::DocumentMut;

use super::scenario::Scenario;

/// Settings that a board on this computer needs in addition to those of the scenario.
const CONNECTIONS: &str = "
[can]                            # a desktop takes longer for a reading than a bus, and is no lost sensor
sample_wait_s = 0.002
answer_timeout_s = 0.5

[rsi]
robot_ip = \"any\"                 # better its address; any: the first sender of a valid telegram is the robot

[network]
recorder = \"127.0.0.1:49200\"     # who gets each cycle: softdock record --listen 127.0.0.1:49200 -o run.mcap
";

/// Name and text of a file.
pub type File = (&'static str, String);

/// The files, in the order in which they are needed.
///
/// # Errors
/// None: the built-in scenario is valid.
pub fn files() -> Result<[File; 4]> {
    let named = |text: &str| {
        let text = text.replace("host-tools/scenarios/diagnosis.model.toml", "model.toml");
        let text = text.replace("host-tools/scenarios/diagnosis.toml", "scenario.toml");
        text.replace("diagnosis.toml", "scenario.toml")
    };
    Ok([
        ("scenario.toml", named(SCENARIO)),
        ("board.toml", board()?),
        ("rig.toml", rig()?),
        ("model.toml", named(MODEL)),
    ])
}

/// The scenario's board as a file of its own, with its comments.
fn board() -> Result<String> {
    let mut document: DocumentMut = SCENARIO.parse()?;
    let board = document.remove("board").context("[board] is missing")?;
    let mut own = DocumentMut::new();
    *own.as_table_mut() = board.into_table().ok().context("[board] is no table")?;
    let sections = own.to_string();
    let text = format!(
        "# Settings of the board, the same as [board] in scenario.toml. What is left out has its default.\n#\n\
         #   softdock board --settings board.toml --robot 127.0.0.1:49152 --can 127.0.0.1:29536\n#   \
         softdock run scenario.toml --settings board.toml -o run.mcap\n\n{}\n{CONNECTIONS}",
        sections
            .split_once("[control")
            .map_or(sections.trim(), |(before, _)| sections[before.len()..]
                .trim())
    );
    input::parse::<BoardSettings>(&text, "board.toml")?;
    Ok(text)
}

/// The rig of the scenario as far as it is known before a contact.
fn rig() -> Result<String> {
    let scenario: Scenario = input::parse(SCENARIO, "built-in scenario")?;
    let actuator = &scenario.rig.robot.actuator;
    let wall = scenario.rig.mechanism.walls.first();
    let wall = wall.context("the scenario has no wall")?;
    Ok(format!(
        "# The rig as `softdock check` takes it: what is known or assumed of it before a contact.\n#\n\
         #   softdock check board.toml rig.toml\n\n\
         [actuator]                       # the robot\n\
         delay_s = {:?}                  # from a command to its execution\n\
         lag_s = {:?}                    # first-order lag behind it\n\
         pause_s = {:?}                    # standstill at a reversal\n\n\
         [contact]\n\
         stiffness_n_per_m = {:?}\n\
         damping_n_s_per_m = {:?}\n",
        actuator.delay_s,
        actuator.lag_s,
        actuator.pause_s,
        wall.stiffness_n_per_m,
        wall.damping_n_s_per_m
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_board_is_that_of_the_scenario() {
        let scenario: Scenario = input::parse(SCENARIO, "scenario").unwrap();
        let mut board: BoardSettings = input::parse(&board().unwrap(), "board.toml").unwrap();
        board.validate().unwrap();
        board.can = scenario.board.can.clone();
        board.rsi = scenario.board.rsi.clone();
        board.network = scenario.board.network.clone();
        assert_eq!(board, scenario.board);
    }

    #[test]
    fn no_file_speaks_of_places_that_a_user_does_not_have() {
        for (name, text) in files().unwrap() {
            assert!(!text.contains("host-tools"), "{name}");
            assert!(text.contains("softdock "), "{name}");
        }
    }
}
