//! `softdock run`: a scenario on the simulated rig.

use super::outputs::mcap_file;
use super::piece_args::PieceArgs;
use super::{answer, law_names, three_numbers};
use crate::cli::progress::Progress;
use anyhow::{Context, Result, bail};
use clap::Args;
use serde::Serialize;
use softdock_control::delay::LawName;
use softdock_control::io::Trace;
use softdock_control::settings::CorrectionMode;
use softdock_experiments::check;
use softdock_experiments::impact_table;
use softdock_experiments::impacts::{Impact, ImpactFinder};
use softdock_experiments::record_file::record_file;
use softdock_experiments::run::RunStatistics;
use softdock_experiments::scenario::Scenario;
use softdock_io::input::{self, refuse_overwrite_of};
use softdock_io::say;
use softdock_io::telemetry::{FileSeries, Time};
use softdock_mechanism::{EnergyBalance, Loads};
use softdock_report::{Cell, Column, Table};
use softdock_rig::rig::{self, hidden::suggest};
use softdock_workbench::Simulation;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

/// Run a scenario on the simulated rig and record every cycle.
///
/// The firmware's own tasks run in virtual time against a simulated robot, mechanism and sensor,
/// with real RSI telegrams and CAN frames in between.
#[derive(Debug, Args)]
#[command(after_help = "\
Example: softdock run scenario.toml -o run.mcap --law seed --speed-mm-s 5

softdock run scenario.toml --settings board.toml -o docking.mcap
(the same rig with the settings that a board has, as `softdock params dump` wrote them)

softdock run scenario.toml --settings board.toml --hold --abc-deg 0,0,180 -o pose-1.mcap
(a pose at rest, for `softdock calibrate sensor`)

`softdock init` writes these files to start from.")]
pub(super) struct Run {
    /// Scenario file (TOML)
    scenario: PathBuf,
    /// Recording to write (MCAP)
    #[arg(short, long, value_name = "RUN.mcap", value_parser = mcap_file)]
    output: PathBuf,
    #[command(flatten)]
    pieces: PieceArgs,
    /// Settings of the board, instead of the scenario's
    #[arg(long, value_name = "BOARD.toml")]
    settings: Option<PathBuf>,
    /// Leave the board in hold: the robot rests where the scenario starts
    #[arg(long)]
    hold: bool,
    /// A, B, C of the flange at the start, degrees, instead of the scenario's
    #[arg(
        long,
        value_name = "A,B,C",
        value_parser = three_numbers,
        allow_hyphen_values = true
    )]
    abc_deg: Option<[f64; 3]>,
    /// Length of the run, s, instead of the scenario's
    #[arg(long, value_name = "S")]
    duration_s: Option<f64>,
    /// Delay law, instead of the scenario's
    #[arg(long, value_name = "NAME", value_parser = law_names())]
    law: Option<LawName>,
    /// Initial speed of the moving spacecraft, instead of the scenario's
    #[arg(long, value_name = "V", allow_negative_numbers = true)]
    speed_mm_s: Option<f64>,
    /// Effect of the catalogue for the rig to hide, in a size drawn from the seed; may be repeated
    #[arg(long, value_name = "ID")]
    effect: Vec<String>,
    /// Seed of all random numbers, instead of the scenario's
    #[arg(long)]
    seed: Option<u64>,
    /// Overwrite an existing recording
    #[arg(long)]
    force: bool,
    /// Print one JSON document
    #[arg(long)]
    json: bool,
}

/// What a run says when it is over.
#[derive(Serialize)]
pub(super) struct Summary {
    recording: String,
    /// All files of the recording, if there are several.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pieces: Vec<String>,
    cycles: u64,
    simulated_s: f64,
    real_time_factor: f64,
    cycles_per_processor_second: f64,
    final_mode: String,
    fault: Option<String>,
    captured: bool,
    captured_s: Option<f64>,
    energy: EnergyBalance,
    loads: Vec<DockingLoads>,
    impacts: Vec<Impact>,
    /// Smallest damping that the predictor tells from none at this noise, N·s/m; only where the law has flagged a contact in
    /// which noise may hide a damping.
    #[serde(skip_serializing_if = "Option::is_none")]
    damping_in_noise_n_s_per_m: Option<f64>,
    /// Remarks on the numbers above.
    warnings: Vec<String>,
}

/// Loads of one docking mechanism.
#[derive(Serialize)]
struct DockingLoads {
    largest: Loads,
    limits: Loads,
}

impl DockingLoads {
    /// Loads of each docking mechanism of a scenario.
    fn all(scenario: &Scenario, largest: &[Loads]) -> Vec<Self> {
        let dockings = scenario.rig.mechanism.docking.iter();
        let pairs = dockings.zip(largest).map(|(docking, largest)| Self {
            largest: *largest,
            limits: docking.limits.unwrap_or_default(),
        });
        pairs.collect()
    }
}

impl Run {
    pub(super) fn execute(self) -> Result<()> {
        let progress = Progress::new();
        let summary = self.carry_out(&|share| {
            progress.show(share, "simulating");
            ControlFlow::Continue(())
        })?;
        drop(progress);
        for warning in &summary.warnings {
            say!("warning: {warning}");
        }
        answer(self.json, &summary, || text(&summary))?;
        // The recording is complete, but a script that continues expects a test that was not stopped by a fault.
        if let Some(fault) = summary.fault {
            bail!("the run ended in a latched fault: {fault}");
        }
        Ok(())
    }

    /// A run that a page of the workbench asks for.
    ///
    /// # Errors
    ///
    /// A delay law that does not exist.
    pub(super) fn of(wanted: &Simulation) -> Result<Self> {
        let named = |name: &String| {
            LawName::named(name).with_context(|| {
                let known = LawName::ALL.map(LawName::name).join(", ");
                format!("there is no delay law `{name}`; expected one of {known}")
            })
        };
        Ok(Self {
            scenario: wanted.scenario.clone(),
            output: wanted.output.clone(),
            pieces: PieceArgs::default(),
            settings: wanted.settings.clone(),
            hold: wanted.hold,
            abc_deg: None,
            duration_s: wanted.duration_s,
            law: wanted.law.as_ref().map(named).transpose()?,
            speed_mm_s: wanted.speed_mm_s,
            effect: wanted.effect.clone(),
            seed: wanted.seed,
            force: false,
            json: true,
        })
    }

    /// Runs the scenario and records it. After each percent `goes_on` is asked; a run that it stops leaves no recording.
    pub(super) fn carry_out(&self, goes_on: &dyn Fn(f64) -> ControlFlow<()>) -> Result<Summary> {
        let scenario = self.scenario()?;
        let settings = self.settings.as_deref();
        let inputs: Vec<&Path> = settings
            .into_iter()
            .chain([self.scenario.as_path()])
            .collect();
        refuse_overwrite_of(&inputs, &self.output, self.force)?;
        let mut finder = ImpactFinder::new(&scenario);
        let mut series = FileSeries::new(&self.output, self.pieces.bounds()?, Time::Virtual);
        let ran = record(&scenario, &mut series, &mut finder, goes_on)?;
        let Some((statistics, last)) = ran else {
            for path in series.paths() {
                std::fs::remove_file(path)
                    .with_context(|| format!("cannot remove {}", path.display()))?;
            }
            bail!("ended on request");
        };
        let impacts = finder.finish();
        let mut summary = Summary {
            recording: self.output.display().to_string(),
            pieces: pieces_of(series.paths()),
            cycles: statistics.cycles,
            simulated_s: statistics.simulated_s,
            real_time_factor: statistics.real_time_factor(),
            cycles_per_processor_second: statistics.cycles_per_processor_second(),
            final_mode: format!("{:?}", last.mode),
            fault: last.fault.map(|f| {
                format!(
                    "{}: expected {}, received {}",
                    f.code, f.expected, f.received
                )
            }),
            captured: statistics.captured_s.is_some(),
            captured_s: statistics.captured_s,
            energy: statistics.energy,
            loads: DockingLoads::all(&scenario, &statistics.loads),
            damping_in_noise_n_s_per_m: damping_in_noise(&scenario, &impacts),
            impacts,
            warnings: Vec::new(),
        };
        summary.warnings = warnings(&scenario, &summary);
        Ok(summary)
    }

    fn scenario(&self) -> Result<Scenario> {
        let mut scenario = Scenario::load(&self.scenario)?;
        if let Some(path) = &self.settings {
            scenario.board = input::load(path)?;
        }
        if let Some(abc_deg) = self.abc_deg {
            scenario.start_abc_rad = abc_deg.map(f64::to_radians);
        }
        scenario.hold |= self.hold;
        scenario.duration_s = self.duration_s.unwrap_or(scenario.duration_s);
        if let Some(law) = self.law {
            scenario = scenario.with_law(law);
        }
        if let Some(speed) = self.speed_mm_s {
            scenario = scenario.with_speed(speed * 1e-3)?;
        }
        scenario.seed = self.seed.unwrap_or(scenario.seed);
        for id in &self.effect {
            let hidden = suggest(id, scenario.seed)?;
            scenario.rig.hidden.push(hidden);
        }
        scenario.validate()?;
        Ok(scenario)
    }
}

/// Runs the scenario and records it. Returns the trace of the last cycle, or None if `goes_on` stopped the run.
fn record(
    scenario: &Scenario,
    series: &mut FileSeries,
    finder: &mut ImpactFinder<'_>,
    goes_on: &dyn Fn(f64) -> ControlFlow<()>,
) -> Result<Option<(RunStatistics, Trace)>> {
    let cycles = scenario.cycles();
    let percent = (cycles / 100).max(1);
    let (mut last, mut done, mut ended) = (Trace::default(), 0, false);
    let statistics = record_file(scenario, series, &mut |record, truth| {
        finder.push(record, truth);
        last = record.trace;
        done += 1;
        if done % percent != 0 {
            return ControlFlow::Continue(());
        }
        let answer = goes_on(done as f64 / cycles as f64);
        ended |= answer.is_break();
        answer
    })?;
    Ok((!ended).then_some((statistics, last)))
}

/// The files of a recording; empty if there is only one.
fn pieces_of(paths: &[PathBuf]) -> Vec<String> {
    match paths {
        [_] => Vec::new(),
        paths => paths
            .iter()
            .map(|path| path.display().to_string())
            .collect(),
    }
}

/// Damping of the wall that noise may hide, N·s/m; None unless the law has flagged an impact so.
fn damping_in_noise(scenario: &Scenario, impacts: &[Impact]) -> Option<f64> {
    let rig = check::Rig::of_scenario(scenario).ok()?;
    let hidden = rig.damping_in_noise(scenario.board.control.robot.cycle_s);
    hidden.filter(|_| impacts.iter().any(|impact| impact.damping_in_noise))
}

/// Remarks on the numbers of a run.
fn warnings(scenario: &Scenario, summary: &Summary) -> Vec<String> {
    let mut warnings = Vec::new();
    let docks = !scenario.rig.mechanism.docking.is_empty();
    if summary.impacts.is_empty() && !scenario.hold && !docks {
        warnings.push("no whole impact took place".to_owned());
    }
    let board = scenario.board.control.robot.correction_mode;
    let robot = &scenario.rig.robot;
    let absolute = board == CorrectionMode::Absolute;
    if absolute != (robot.correction == rig::settings::CorrectionMode::Absolute) {
        warnings.push(
            "`board.control.robot.correction_mode` and `rig.robot.correction` differ: the robot \
             takes the corrections for something else"
                .to_owned(),
        );
    }
    if scenario.rig.mechanism.runs_on_after_capture {
        warnings.push(
            "`rig.mechanism.runs_on_after_capture`: the loop stays closed on latched joints; `softdock check` \
             says whether they bear this robot's delay"
                .to_owned(),
        );
    }
    if robot.hold_on != absolute {
        warnings.push(format!(
            "`rig.robot.hold_on` is {}: a lost answer moves the robot; {} is right for this \
             correction mode",
            robot.hold_on, absolute
        ));
    }
    warnings
}

fn text(summary: &Summary) -> String {
    let time = std::iter::once(Column::number("time", "s"));
    let mut table = Table::new(time.chain(impact_table::columns()).collect());
    for impact in &summary.impacts {
        let time = std::iter::once(Cell::number(impact.time_s, 4));
        table.push(time.chain(impact_table::cells(impact)).collect());
    }
    let fault = summary
        .fault
        .as_ref()
        .map(|f| format!("FAULT {f}\n"))
        .unwrap_or_default();
    // Without an impact there is no table.
    let table = match summary.impacts.as_slice() {
        [] => String::new(),
        _ => format!("{table} {}\n\n", impact_table::LEGEND),
    };
    let taken = "the predictor took a contact for an undamped one; noise may hide a damping of it";
    let hidden = match summary.damping_in_noise_n_s_per_m {
        Some(least) => format!("{taken}: {least:.1} N·s/m, or somewhat more\n"),
        None if summary.impacts.iter().any(|impact| impact.damping_in_noise) => {
            format!("{taken}\n")
        }
        None => String::new(),
    };
    let docked = docked(summary);
    let files = match summary.pieces.as_slice() {
        [] => summary.recording.clone(),
        [first, .., last] => format!(
            "{} files, {first} to {last}, which are replayed together",
            summary.pieces.len()
        ),
        [only] => only.clone(),
    };
    format!(
        "{table}{hidden}{docked}{fault}{} cycles ({:.1} s) in {files}, {:.0} times real time, {:.0} cycles per processor second, \
         mode at the end {}\n",
        summary.cycles,
        summary.simulated_s,
        summary.real_time_factor,
        summary.cycles_per_processor_second,
        summary.final_mode,
    )
}

/// Result of the docking mechanisms as text; empty without any.
fn docked(summary: &Summary) -> String {
    if summary.loads.is_empty() {
        return String::new();
    }
    let columns = [
        Column::text("largest load"),
        Column::number("value", ""),
        Column::number("limit", ""),
    ];
    let mut table = Table::new(columns.into());
    for docking in &summary.loads {
        for ((name, value), (_, limit)) in docking
            .largest
            .named()
            .into_iter()
            .zip(docking.limits.named())
        {
            let cell = |load: Option<f64>| {
                load.map_or_else(|| Cell::text("-"), |load| Cell::number(load, 4))
            };
            table.push(vec![Cell::text(name), cell(value), cell(limit)]);
        }
    }
    let captured = match summary.captured_s {
        Some(captured_s) => format!("captured at {captured_s:.3} s"),
        None => "not captured".to_owned(),
    };
    let EnergyBalance {
        work_j,
        stored_j,
        dissipated_j,
    } = summary.energy;
    format!(
        "{table}\n{captured}; the mechanism took {work_j:.3} J, stores {stored_j:.3} J, turned {dissipated_j:.3} J into heat\n"
    )
}
