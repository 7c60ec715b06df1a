//! Runs a scenario and collects its recording.

use super::scenario::Scenario;
use anyhow::{Context, Result};
use cpu_time::ProcessTime;
use softdock_app::record::CycleRecord;
use softdock_control::modes::Command;
use softdock_io::identity;
use softdock_io::recording::{Header, Recording, TruthRecord};
use softdock_mechanism::{EnergyBalance, Loads};
use softdock_rig::board::virtual_time::{Simulation, simulate};
use softdock_rig::rig::Rig;
use std::ops::ControlFlow;
use std::time::{Duration, Instant};

/// Statistics of a run.
#[derive(Clone, Debug)]
pub struct RunStatistics {
    /// Cycles that were run.
    pub cycles: u64,
    /// Simulated time, s.
    pub simulated_s: f64,
    /// Wall-clock time of the run.
    pub elapsed: Duration,
    /// Processor time of all threads of the program.
    pub processor: Duration,
    /// Time at which the mechanism's latches caught the spacecraft, s; None if they did not.
    pub captured_s: Option<f64>,
    /// Work of the robot on the mechanism, and the balance of energy.
    pub energy: EnergyBalance,
    /// The largest loads of each docking mechanism.
    pub loads: Vec<Loads>,
}

impl RunStatistics {
    /// Simulated time divided by wall-clock time.
    pub fn real_time_factor(&self) -> f64 {
        self.simulated_s / self.elapsed.as_secs_f64().max(1e-9)
    }

    /// Cycles per second of processor time: independent of other load on the machine.
    pub fn cycles_per_processor_second(&self) -> f64 {
        self.cycles as f64 / self.processor.as_secs_f64().max(1e-9)
    }
}

/// Header of a recording of this scenario. Its settings are those that the board really runs with, as a real board reports
/// them.
pub fn header(scenario: &Scenario) -> Result<Header> {
    Ok(Header {
        identity: identity::text(),
        settings_toml: toml_edit::ser::to_string_pretty(&scenario.actual_board()?)?,
        scenario_toml: Some(scenario.to_toml()?),
        ..Header::default()
    })
}

/// Runs a scenario; `on_cycle` gets each cycle as it happens.
pub fn run(
    scenario: &Scenario,
    on_cycle: &mut dyn FnMut(&CycleRecord, &TruthRecord) -> ControlFlow<()>,
) -> Result<RunStatistics> {
    scenario.validate()?;
    let rig = Rig::new(&scenario.rig, scenario.start_pose(), scenario.seed).context("[rig]")?;
    let board = scenario.actual_board()?;
    let simulation = Simulation {
        board: &board,
        rig,
        calibration: scenario.rig.sensor.calibration(),
        duration_s: scenario.duration_s,
        commands: if scenario.hold {
            // The first telegram begins a new run, which drops waiting commands.
            vec![(1, Command::Hold)]
        } else {
            Vec::new()
        },
    };
    let (start, begin) = (Instant::now(), ProcessTime::now());
    let mut cycles = 0;
    let rig = simulate(simulation, &mut |record, truth| {
        cycles += 1;
        on_cycle(record, truth)
    })?;
    let simulated_s = cycles as f64 * scenario.board.control.robot.cycle_s;
    Ok(RunStatistics {
        cycles,
        simulated_s,
        elapsed: start.elapsed(),
        processor: begin.elapsed(),
        captured_s: rig.captured_s(),
        energy: rig.energy(),
        loads: rig.loads().collect(),
    })
}

/// Runs a scenario into a recording in memory.
pub fn record(scenario: &Scenario) -> Result<(Recording, RunStatistics)> {
    let mut recording = Recording {
        header: header(scenario)?,
        ..Recording::default()
    };
    let statistics = run(scenario, &mut |record, truth| {
        recording.cycles.push(*record);
        recording.truth.push(*truth);
        ControlFlow::Continue(())
    })?;
    Ok((recording, statistics))
}
