//! A scenario: a board with its settings, a simulated rig, and how long they run.

use anyhow::{Context, Result, bail};
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};
use softdock_app::settings::BoardSettings;
use softdock_control::delay::LawName;
use softdock_io::input;
use softdock_rig::rig::check_start_pose;
use softdock_rig::rig::hidden::spacecraft;
use softdock_rig::rig::settings::RigSettings;
use std::path::Path;

/// The scenario of the paper's spring-rod test, as the `run` command takes it.
pub const SPRING_ROD: &str = include_str!("../../scenarios/spring-rod.toml");

/// Content of a scenario file.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Scenario {
    /// What is tested, for reports.
    pub title: String,
    /// Length of the run, s.
    pub duration_s: f64,
    /// Seed of all random numbers.
    pub seed: u64,
    /// Position of M in C at the start, m.
    pub start_position_m: [f64; 3],
    /// Orientation of M in C at the start: A, B, C, rad.
    pub start_abc_rad: [f64; 3],
    /// Whether the board stays in hold and moves nothing: a recording of a pose at rest.
    pub hold: bool,
    /// The board's settings; the same text as in a settings file.
    pub board: BoardSettings,
    /// The simulated rig.
    pub rig: RigSettings,
}

impl Scenario {
    /// Reads and checks a scenario file.
    pub fn load(path: &Path) -> Result<Self> {
        let scenario: Self = input::load(path)?;
        scenario
            .validate()
            .with_context(|| format!("in {}", path.display()))?;
        Ok(scenario)
    }

    /// The built-in spring-rod scenario.
    pub fn spring_rod() -> Result<Self> {
        input::parse(SPRING_ROD, "built-in spring-rod scenario")
    }

    /// Checks every value.
    pub fn validate(&self) -> Result<()> {
        if !(self.duration_s > 0.0 && self.duration_s <= 86_400.0) {
            bail!(
                "`duration_s` is {}; allowed is more than 0 to 86400",
                self.duration_s
            );
        }
        self.board.validate().context("[board]")?;
        self.rig.validate().context("[rig]")?;
        check_start_pose(&self.start_pose())?;
        self.actual_board()?;
        let (sensor, frozen) = (
            &self.rig.sensor,
            self.board.control.sensor.frozen_after_cycles,
        );
        if frozen > 0 && sensor.noise_force_n <= 0.0 && sensor.noise_torque_nm <= 0.0 {
            bail!(
                "the simulated sensor has no noise, and the board takes readings that repeat for a frozen sensor: give `rig.sensor.noise_force_n` and `noise_torque_nm`, or say that there is none with `board.control.sensor.frozen_after_cycles = 0`"
            );
        }
        let (board, rig) = (self.board.control.robot.cycle_s, self.rig.cycle_s());
        if (board - rig).abs() > 1e-9 {
            bail!(
                "`board.control.robot.cycle_s` is {board} but `rig.cycle_us` makes {rig} s; they must be the same"
            );
        }
        Ok(())
    }

    /// The board as it really runs: hidden errors of the spacecraft are applied to its settings.
    ///
    /// # Errors
    /// With the hidden errors the settings of the spacecraft are not valid.
    pub fn actual_board(&self) -> Result<BoardSettings> {
        let mut board = self.board.clone();
        spacecraft::apply(&self.rig.hidden, &mut board.control)?;
        board
            .validate()
            .context("[board] with the hidden errors of the spacecraft")?;
        Ok(board)
    }

    /// The scenario with this delay law.
    pub fn with_law(mut self, law: LawName) -> Self {
        self.board.control.delay.law = law;
        self
    }

    /// The scenario with another initial speed of K, in the same direction.
    pub fn with_speed(mut self, speed_m_s: f64) -> Result<Self> {
        let body = &mut self.board.control.body_k;
        let velocity = Vector3::from(body.velocity_m_s);
        let Some(direction) = velocity.try_normalize(1e-12) else {
            bail!(
                "the scenario's `board.control.body_k.velocity_m_s` is zero, so a speed has no direction; give it one"
            );
        };
        body.velocity_m_s = (direction * speed_m_s).into();
        Ok(self)
    }

    /// X Y Z (m) and A B C (rad) of M at the start.
    pub fn start_pose(&self) -> [f64; 6] {
        let ([x, y, z], [a, b, c]) = (self.start_position_m, self.start_abc_rad);
        [x, y, z, a, b, c]
    }

    /// Number of cycles of a run.
    pub fn cycles(&self) -> usize {
        (self.duration_s / self.board.control.robot.cycle_s).ceil() as usize
    }

    /// The text of the scenario with all defaults written out.
    pub fn to_toml(&self) -> Result<String> {
        Ok(toml_edit::ser::to_string_pretty(self)?)
    }
}
