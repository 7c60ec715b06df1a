//! The guided demonstration: run a docking test, see where the model fails, switch the paper's
//! delay compensation on, and see what changes.

use super::impact_table;
use super::impacts::{self, Impact};
use super::run::{RunStatistics, record};
use super::scenario::Scenario;
use crate::compare::{Comparison, compare};
use crate::identity;
use crate::model::Model;
use crate::recording::Recording;
use crate::report::{Band, Cell, Column, Page, Plot, Series, Table};
use anyhow::{Context, Result};
use softdock_control::delay::LawName;
use softdock_control::io::CycleRecord;

/// The model that believes in a robot without delay.
pub const MODEL_TOML: &str = include_str!("../../scenarios/spring-rod.model.toml");
/// Speed of the demonstration, m/s: the middle of the paper's range.
pub const SPEED_M_S: f64 = 0.01;

/// One run of the demonstration and what was found in it.
#[derive(Clone, Debug)]
pub struct Step {
    /// Delay law of the run.
    pub law: LawName,
    /// What the step shows.
    pub title: &'static str,
    /// Every cycle.
    pub recording: Recording,
    /// How fast it ran.
    pub statistics: RunStatistics,
    /// The impact.
    pub impact: Impact,
    /// The model held against the recording.
    pub comparison: Comparison,
}

/// The rig of the demonstration: the spring rod, with the noise of a good laboratory.
fn scenario(law: LawName, seed: u64) -> Result<Scenario> {
    let mut scenario = Scenario::spring_rod()?
        .with_law(law)
        .with_speed(SPEED_M_S)?;
    scenario.seed = seed;
    scenario.rig.sensor.noise_force_n = 0.2;
    scenario.rig.sensor.noise_torque_nm = 0.01;
    scenario.rig.robot.position_noise_m = 1e-6;
    scenario.rig.robot.rotation_noise_rad = 2e-6;
    Ok(scenario)
}

/// Runs one step.
pub fn step(law: LawName, title: &'static str, seed: u64) -> Result<Step> {
    let scenario = scenario(law, seed)?;
    let model = Model::from_toml(MODEL_TOML, "built-in spring-rod model")?;
    let (recording, statistics) = record(&scenario)?;
    let impact = impacts::find(&scenario, &recording).into_iter().next();
    let impact = impact.context("the craft never touched the stop")?;
    let comparison = compare(&model, &recording)?;
    Ok(Step {
        law,
        title,
        recording,
        statistics,
        impact,
        comparison,
    })
}

/// The steps side by side.
pub fn table(steps: &[Step]) -> Table {
    let run = std::iter::once(Column::text("run"));
    let mut table = Table::new(run.chain(impact_table::columns()).collect());
    for step in steps {
        let title = std::iter::once(Cell::text(step.title));
        table.push(title.chain(impact_table::cells(&step.impact)).collect());
    }
    table
}

/// The page that shows all steps.
pub fn page(steps: &[Step]) -> Result<Page> {
    let mut page = Page::new("softdock demo");
    if let (Some(first), Some(last)) = (steps.first(), steps.last()) {
        page.headline(&format!(
            "An elastic stop gives the craft back {:.1} times its speed, because the robot is late; \
             with the paper's compensation it is {:.2} times.",
            first.impact.restitution, last.impact.restitution
        ));
    }
    page.paragraph("All of this is simulated: the rig, its robot and its sensor. The controller is the firmware, and RSI telegrams and CAN frames are real.");
    page.section("Before and after");
    page.table(&table(steps));
    page.columns(&steps.iter().map(velocity_plot).collect::<Vec<_>>())?;
    page.columns(&steps.iter().map(force_plot).collect::<Vec<_>>())?;
    for step in steps {
        page.section(step.title);
        page.paragraph(&format!(
            "Where the model fails: {}",
            step.comparison.sentence
        ));
        for table in step.comparison.tables() {
            page.table(&table);
        }
    }
    page.identity(&identity::text());
    Ok(page)
}

fn curve(step: &Step, value: impl Fn(&CycleRecord) -> f64) -> Vec<(f64, f64)> {
    step.recording
        .cycles
        .iter()
        .map(|cycle| (cycle.trace.time_s, value(cycle)))
        .collect()
}

fn velocity_plot(step: &Step) -> Plot {
    let mut plot = Plot::new(step.title, "time [s]", "velocity x [mm/s]");
    plot.series = vec![
        Series::line("model", curve(step, |c| c.trace.model_velocity[0] * 1e3)),
        Series::line(
            "executed",
            curve(step, |c| c.trace.executed_velocity[0] * 1e3),
        ),
        Series::dashed("command", curve(step, |c| c.trace.sent_velocity[0] * 1e3)),
    ];
    around_impact(plot, step)
}

/// Leaves of a plot what lies around the impact.
fn around_impact(mut plot: Plot, step: &Step) -> Plot {
    let (from, to) = (
        step.impact.time_s,
        step.impact.time_s + step.impact.contact_time_s,
    );
    for series in &mut plot.series {
        series
            .points
            .retain(|(t, _)| (from - 0.15..=to + 0.25).contains(t));
    }
    plot.shaded = vec![Band {
        from,
        to,
        label: "contact".to_owned(),
    }];
    plot
}

fn force_plot(step: &Step) -> Plot {
    let mut plot = Plot::new(step.title, "time [s]", "contact force x [N]");
    plot.series = vec![Series::line(
        "measured",
        curve(step, |c| c.trace.wrench_at_m[0]),
    )];
    plot
}
