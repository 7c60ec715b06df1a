//! The guided demonstration: a rig hides an effect, its recordings are compared with a model that
//! does not know it, the effect is diagnosed, added, and the error falls.

use super::diagnosis::{self, Part};
use super::impact_table;
use super::impacts::{self, Impact};
use super::run::{RunStatistics, record};
use super::scenario::Scenario;
use super::spring_rod::{TOUCH, one_stop};
use anyhow::{Result, bail};
use serde::Serialize;
use softdock_analysis::diagnose::{Diagnosis, Estimate, Report};
use softdock_analysis::levels::Step;
use softdock_control::delay::actuator::ActuatorSettings;
use softdock_control::delay::{DelaySettings, LawName, ModelVelocity};
use softdock_control::modes::{Fault, FaultCode};
use softdock_io::recording::Recording;
use softdock_physics::effects::Group;
use softdock_physics::effects::actuator::{
    actuation_delay, actuation_lag, second_order_servo, zero_cross_pause,
};
use softdock_physics::model::{EffectModel, Model};
use softdock_report::{Cell, Column, Mark, Table};
use softdock_rig::rig::Hidden;
use softdock_rig::rig::hidden::{self, suggest};

/// Speed of the bounces, m/s: the middle of the paper's range.
pub const BOUNCE_SPEED_M_S: f64 = 0.01;
/// Effects that the settings of a delay law contain.
const LEARNED: [&str; 4] = [
    actuation_delay::EFFECT.id,
    zero_cross_pause::EFFECT.id,
    actuation_lag::EFFECT.id,
    second_order_servo::EFFECT.id,
];

/// Effects that the rig hides by default. With the 12 ms that the model knows they give the robot of the paper, which is 32
/// ms late and stands still for 16 ms when it reverses.
pub fn default_hidden() -> Vec<Hidden> {
    let one = |id: &str, parameter: &str, value: f64| Hidden {
        id: id.to_owned(),
        parameters: [(parameter.to_owned(), value)].into(),
    };
    vec![
        one(actuation_delay::EFFECT.id, "extra_delay_s", 0.020),
        one(zero_cross_pause::EFFECT.id, "pause_s", 0.016),
    ]
}

/// The effects with these ids in sizes drawn from the seed; without ids [`default_hidden`].
///
/// # Errors
/// An id that the catalogue does not have; the error offers the nearest.
pub fn hidden(ids: &[String], seed: u64) -> Result<Vec<Hidden>> {
    if ids.is_empty() {
        return Ok(default_hidden());
    }
    ids.iter().map(|id| suggest(id, seed)).collect()
}

/// A recording of the rig, and the speed of the simulation.
#[derive(Clone, Debug)]
pub struct Run {
    /// Every cycle.
    pub recording: Recording,
    /// Statistics of the simulation.
    pub statistics: RunStatistics,
}

/// Runs one part of the test.
///
/// # Errors
/// An effect that the rig cannot hide.
pub fn run(part: Part, hidden: &[Hidden], seed: u64) -> Result<Run> {
    let (recording, statistics) = record(&diagnosis::scenario(part, hidden, seed)?)?;
    Ok(Run {
        recording,
        statistics,
    })
}

/// The model file with the named effects: the user's text unchanged, then effects and history.
///
/// # Errors
/// None that the demonstration can cause: the text is checked as a model before it is returned.
pub fn model_with(report: &Report, train: &str, test: &str) -> Result<String> {
    let mut text = diagnosis::MODEL.to_owned();
    for effect in named(report) {
        text += &effect_text(effect, train);
    }
    for step in steps(&report.diagnosis) {
        text += &step_text(step, train, test);
    }
    Model::from_toml(&text, "the model with the effects added")?;
    Ok(text)
}

/// The fitted effects that the verdict names.
fn named(report: &Report) -> impl Iterator<Item = &EffectModel> {
    let names = &report.diagnosis.effects;
    let fitted = report.after.effects.iter();
    fitted.filter(|effect| names.contains(&effect.id))
}

/// Steps of the error, only those of named effects: no others are added to the model.
fn steps(diagnosis: &Diagnosis) -> impl Iterator<Item = &Step> {
    let steps = diagnosis.steps.iter().enumerate();
    let named = |place: usize, step: &Step| place == 0 || diagnosis.effects.contains(&step.effect);
    steps
        .filter(move |(place, step)| named(*place, step))
        .map(|(_, step)| step)
}

fn effect_text(effect: &EffectModel, train: &str) -> String {
    let values = effect.parameters.iter();
    let values: Vec<_> = values
        .map(|(k, v)| format!("{k} = {}", digits(*v)))
        .collect();
    let intervals = effect.interval_95.iter();
    let intervals: Vec<_> = intervals
        .map(|(k, [low, high])| format!("{k} = [{}, {}]", digits(*low), digits(*high)))
        .collect();
    format!(
        "\n[[effect]]\nid = \"{}\"\nparameters = {{ {} }}\ninterval_95 = {{ {} }}\nfitted_on = \"{train}\"\n",
        effect.id,
        values.join(", "),
        intervals.join(", "),
    )
}

fn step_text(step: &Step, train: &str, test: &str) -> String {
    let unseen = step.test_error.map_or_else(String::new, |error| {
        format!("test = \"{test}\"\ntest_error = {}\n", digits(error))
    });
    format!(
        "\n[[history]]\neffect = \"{}\"\ntrain = \"{train}\"\ntrain_error = {}\n{unseen}",
        step.effect,
        digits(step.train_error),
    )
}

/// A number with six digits, which are more than any fit determines.
fn digits(value: f64) -> String {
    let rounded: f64 = format!("{value:.5e}").parse().unwrap_or(value);
    format!("{rounded:?}")
}

/// A hidden parameter and its estimate.
#[derive(Clone, Debug, Serialize)]
pub struct Answer {
    /// The hidden effect.
    pub effect: String,
    /// Whether the verdict names it.
    pub named: bool,
    /// Name of the parameter.
    pub parameter: String,
    /// True value.
    pub hidden: f64,
    /// Estimate of the diagnosis, if there is one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub found: Option<Estimate>,
}

/// Every hidden parameter with its estimate, also where the diagnosis names an equivalent effect.
pub fn answers(hidden: &[Hidden], diagnosis: &Diagnosis) -> Vec<Answer> {
    let of_effect = |effect: &Hidden| {
        let own = diagnosis.parameters.get(&effect.id);
        let own = own.filter(|_| diagnosis.effects.contains(&effect.id));
        let same = diagnosis.equivalent.iter();
        let fitted = own.or_else(|| same.filter_map(|s| s.parameters.get(&effect.id)).next());
        let named = fitted.is_some();
        let answer = |(name, value): (&String, &f64)| Answer {
            effect: effect.id.clone(),
            named,
            parameter: name.clone(),
            hidden: *value,
            found: fitted.and_then(|fitted| fitted.get(name)).cloned(),
        };
        effect.parameters.iter().map(answer).collect::<Vec<_>>()
    };
    hidden.iter().flat_map(of_effect).collect()
}

/// Hidden values and estimates.
pub fn answer_table(answers: &[Answer]) -> Table {
    let mut table = Table::new(vec![
        Column::text("hidden effect"),
        Column::text("parameter"),
        Column::number("hidden", "SI"),
        Column::number("found", "SI"),
        Column::text("95 % interval"),
        Column::number("off by", ""),
        Column::text("named"),
    ]);
    for answer in answers {
        let unknown = || Cell::text("-");
        let (value, interval, off) = match &answer.found {
            Some(found) => (
                Cell::number(found.value, 4),
                Cell::interval(found.low, found.high, 4),
                Cell::percent(found.value / answer.hidden - 1.0),
            ),
            None => (unknown(), unknown(), unknown()),
        };
        table.push(vec![
            Cell::text(&answer.effect),
            Cell::text(&answer.parameter),
            Cell::number(answer.hidden, 4),
            value,
            interval,
            off,
            if answer.named {
                Cell::text("yes").marked(Mark::Good)
            } else {
                Cell::text("no").marked(Mark::Bad)
            },
        ]);
    }
    table
}

/// The error after each added effect.
pub fn history_table(diagnosis: &Diagnosis) -> Table {
    let mut table = Table::new(vec![
        Column::text("model"),
        Column::number("error, training", "sigma"),
        Column::number("error, unseen", "sigma"),
    ]);
    for (place, step) in steps(diagnosis).enumerate() {
        let name = if place == 0 {
            step.effect.clone()
        } else {
            format!("+ {}", step.effect)
        };
        let unseen = step
            .test_error
            .map_or_else(|| Cell::text("-"), |e| Cell::number(e, 3));
        table.push(vec![
            Cell::text(name),
            Cell::number(step.train_error, 3),
            unseen,
        ]);
    }
    table
}

/// The identified robot, for the board's settings; None if the diagnosis named nothing that a delay law can use.
pub fn identified_robot(report: &Report) -> Option<ActuatorSettings> {
    let named = &report.diagnosis.effects;
    if !named.iter().any(|id| LEARNED.contains(&id.as_str())) {
        return None;
    }
    let mut model = report.after.clone();
    model.effects.retain(|effect| named.contains(&effect.id));
    Some(model.robot_for_board())
}

/// Settings of the board's delay compensation with the identified robot.
pub fn delay_settings(law: LawName, robot: &ActuatorSettings) -> DelaySettings {
    DelaySettings {
        law,
        model_velocity: ModelVelocity::End,
        actuator: robot.clone(),
        ..DelaySettings::default()
    }
}

/// The settings of the spring-rod test's board with this delay compensation, as a file.
///
/// # Errors
/// None that the demonstration can cause.
pub fn board_text(delay: &DelaySettings) -> Result<String> {
    let mut board = Scenario::spring_rod()?.board;
    board.control.delay = delay.clone();
    Ok(toml_edit::ser::to_string_pretty(&board)?)
}

/// One bounce of the paper's spring-rod test on the demonstration's robot.
#[derive(Clone, Debug)]
pub struct Bounce {
    /// The board's delay compensation.
    pub delay: DelaySettings,
    /// Statistics of the simulation.
    pub statistics: RunStatistics,
    /// The impact, or why the board stopped before it.
    pub impact: Result<Impact, String>,
}

/// Whether the hidden effects contain one that a delay law can compensate.
pub fn is_late(hidden: &[Hidden]) -> bool {
    hidden.iter().any(|h| LEARNED.contains(&h.id.as_str()))
}

/// Bounces with a delay law.
///
/// # Errors
/// The spacecraft never reached the stop though nothing stopped it.
pub fn bounce(delay: DelaySettings, hidden: &[Hidden], seed: u64) -> Result<Bounce> {
    let known = diagnosis::scenario(Part::Train, &[], seed)?;
    let mut scenario = one_stop(delay.law, BOUNCE_SPEED_M_S, TOUCH)?;
    scenario.board.control.delay = delay.clone();
    scenario.seed = seed;
    scenario.rig.robot.actuator = known.rig.robot.actuator;
    scenario.rig.hidden = of_actuator(hidden);
    let (recording, statistics) = record(&scenario)?;
    let impact = impacts::find(&scenario, &recording).into_iter().next();
    let fault = recording.cycles.last().and_then(|cycle| cycle.trace.fault);
    Ok(Bounce {
        delay,
        statistics,
        impact: match (impact, fault) {
            (Some(impact), _) => Ok(impact),
            (None, Some(fault)) => Err(stopped(&fault)),
            (None, None) => bail!("the spacecraft never touched the stop"),
        },
    })
}

fn stopped(fault: &Fault) -> String {
    let numbers = format!("{:.4}, allowed is {:.4}", fault.received, fault.expected);
    match fault.code {
        FaultCode::ActuatorUnlike => format!(
            "refused before the stop was touched: the robot is late in another way than it was told \
             (a share of {numbers}); what was named is not all that delays it"
        ),
        code => format!("stopped before the stop was touched: {code} ({numbers})"),
    }
}

/// The hidden effects of the actuator, which another mechanism and another spacecraft have too.
fn of_actuator(hidden: &[Hidden]) -> Vec<Hidden> {
    let acts = |h: &&Hidden| hidden::effect(&h.id).is_ok_and(|e| e.group == Group::Actuator);
    hidden.iter().filter(acts).cloned().collect()
}

/// Bounces side by side.
pub fn bounce_table(bounces: &[Bounce]) -> Table {
    let law = std::iter::once(Column::text("delay law"));
    let mut table = Table::new(law.chain(impact_table::columns()).collect());
    for bounce in bounces {
        let law = std::iter::once(Cell::text(law_words(bounce.delay.law)));
        table.push(match &bounce.impact {
            Ok(impact) => law.chain(impact_table::cells(impact)).collect(),
            Err(_) => law.chain(impact_table::no_impact()).collect(),
        });
    }
    table
}

fn law_words(law: LawName) -> String {
    match law {
        LawName::None => "none".to_owned(),
        LawName::Seed => "seed (the paper's)".to_owned(),
        other => format!("{} (with what was found)", other.name()),
    }
}
