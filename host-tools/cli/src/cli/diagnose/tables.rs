//! A diagnosis for the terminal: the sentence first, then the numbers behind it.

use softdock_analysis::compare::TOLERATED_NOISE;
use softdock_analysis::diagnose::{Diagnosis, NAMED, Parameters};
use softdock_analysis::levels::{BeforeAfter, ChannelLevels};
use softdock_physics::model::Channel;
use softdock_report::{Cell, Column, Format, Mark, Table, number};

/// Significant digits of errors, and of an interval's width.
const DIGITS: usize = 3;
/// Relative change of an error from which on it is marked.
const CHANGED: f64 = 0.01;

/// Everything about a diagnosis.
pub(super) fn text(diagnosis: &Diagnosis) -> String {
    let mut parts = vec![diagnosis.sentence.clone()];
    let mut titled = |title: &str, table: Table| {
        if !table.rows.is_empty() {
            parts.push(format!("{title}\n{table}"));
        }
    };
    titled(
        "Error before and after, in units of the model file's noise",
        levels(&diagnosis.residual_rms_sigma),
    );
    titled("Effects", effects(diagnosis));
    titled("Parameters", parameters(&diagnosis.parameters));
    titled("Nominal parameters that moved", nominal(diagnosis));
    titled("Hypotheses, the likeliest first", hypotheses(diagnosis));
    titled("Where it shows", regions(diagnosis));
    parts.extend(rival(diagnosis));
    if !diagnosis.looks_like.is_empty() {
        let hints = diagnosis.looks_like.join(", ");
        parts.push(format!("It looks like, without being proven: {hints}"));
    }
    if !diagnosis.notes.is_empty() {
        parts.push(format!("Notes\n- {}", diagnosis.notes.join("\n- ")));
    }
    parts.push(format!("Diagnosed in {:.1} s.", diagnosis.seconds));
    format!("{}\n", parts.join("\n\n"))
}

/// Error per channel.
pub(in crate::cli) fn levels(both: &BeforeAfter) -> Table {
    /// Errors below this (in units of the noise) are round-off: the channel was not measured, or is computed from another
    /// one.
    const ROUND_OFF: f64 = 1e-6;
    let mut table = Table::new(vec![
        Column::text("Channel"),
        Column::number("Before", "σₙ"),
        Column::number("After", "σₙ"),
    ]);
    let of = |l: &ChannelLevels| [l.executed_velocity, l.wrench, l.model_velocity, l.pose];
    let pairs = of(&both.before).into_iter().zip(of(&both.after));
    let told = Channel::ALL.into_iter().zip(pairs);
    for (channel, (before, after)) in
        told.filter(|(_, (before, after))| before.max(*after) > ROUND_OFF)
    {
        table.push(vec![
            Cell::text(channel.name()),
            Cell::number(before, DIGITS),
            after_cell(before, after),
        ]);
    }
    let (before, after) = (both.before.rms(), both.after.rms());
    if before.max(after) <= ROUND_OFF {
        return table;
    }
    table.push(vec![
        Cell::text("all together (1 is noise)"),
        Cell::number(before, DIGITS),
        after_cell(before, after),
    ]);
    table.explained("✓ at the noise, ✗ it rose")
}

fn after_cell(before: f64, after: f64) -> Cell {
    let cell = Cell::number(after, DIGITS);
    match after / before - 1.0 {
        change if change > CHANGED => cell.marked(Mark::Bad),
        _ if after <= TOLERATED_NOISE => cell.marked(Mark::Good),
        _ => cell,
    }
}

/// What was found, with its probability.
fn effects(diagnosis: &Diagnosis) -> Table {
    let mut table = Table::new(vec![
        Column::text("Effect"),
        Column::number("Probability", ""),
    ]);
    for (id, probability) in &diagnosis.probability {
        table.push(vec![
            Cell::text(id),
            Cell::formatted(*probability, Format::Fixed(2)),
        ]);
    }
    table
}

/// Nominal parameters that are off by more than one tolerance.
fn nominal(diagnosis: &Diagnosis) -> Table {
    let mut table = Table::new(vec![
        Column::text("Parameter"),
        Column::number("Value", "SI"),
        Column::number("95 % interval", "SI"),
        Column::number("Off by", "tolerances"),
    ]);
    let moved = diagnosis
        .nominal
        .iter()
        .filter(|(_, n)| n.tolerances.abs() > 1.0);
    for (name, nominal) in moved {
        table.push(vec![
            Cell::text(name),
            Cell::number(nominal.value, DIGITS),
            Cell::interval(nominal.low, nominal.high, 2),
            Cell::number(nominal.tolerances, 2),
        ]);
    }
    table
}

/// Parameters with their intervals.
pub(in crate::cli) fn parameters(parameters: &Parameters) -> Table {
    let mut table = Table::new(vec![
        Column::text("Effect"),
        Column::text("Parameter"),
        Column::number("Value", ""),
        Column::number("95 % interval", ""),
        Column::text("Unit"),
    ]);
    for (effect, of_effect) in parameters {
        for (name, estimate) in of_effect {
            table.push(vec![
                Cell::text(effect),
                Cell::text(name),
                Cell::number(estimate.value, DIGITS + 1),
                Cell::interval(estimate.low, estimate.high, 2),
                Cell::text(&estimate.unit),
            ]);
        }
    }
    table
}

fn hypotheses(diagnosis: &Diagnosis) -> Table {
    let later = diagnosis.ranked.iter().any(|one| !one.beside.is_empty());
    let mut columns = vec![
        Column::text("Effects"),
        Column::text("Channel"),
        Column::number("χ² falls, fit", ""),
        Column::number("unseen", ""),
        Column::text("Refused because"),
    ];
    if later {
        columns.insert(1, Column::text("Beside"));
    }
    let mut table = Table::new(columns);
    for ranked in &diagnosis.ranked {
        let named = ranked.effects.iter().all(|e| diagnosis.effects.contains(e));
        let effects = Cell::text(ranked.effects.join(" + "));
        let effects = match &ranked.refused {
            Some(_) => effects.marked(Mark::Bad),
            None if named => effects.marked(Mark::Good),
            None => effects,
        };
        let mut row = vec![
            effects,
            Cell::text(ranked.channel.name()),
            Cell::formatted(ranked.gain_train, Format::Fixed(0)),
            Cell::formatted(ranked.gain_test, Format::Fixed(0)),
            Cell::text(ranked.refused.as_deref().unwrap_or_default()),
        ];
        if later {
            row.insert(1, Cell::text(ranked.beside.join(" + ")));
        }
        table.push(row);
    }
    table.explained(
        "✓ named, alone or with others; ✗ refused; what unmarked ones have more than the answer is not worth its price, unless a \
         note says otherwise",
    )
}

fn regions(diagnosis: &Diagnosis) -> Table {
    let mut table = Table::new(vec![
        Column::text("Channel"),
        Column::text("Axis"),
        Column::number("From", "s"),
        Column::number("To", "s"),
        Column::text("When"),
    ]);
    for region in &diagnosis.regions {
        table.push(vec![
            Cell::text(region.channel.name()),
            Cell::text(region.axis.to_string()),
            Cell::formatted(region.from_s, Format::Fixed(3)),
            Cell::formatted(region.to_s, Format::Fixed(3)),
            Cell::text(&region.regime),
        ]);
    }
    table
}

/// The closest rival, and how to tell it from the winner.
fn rival(diagnosis: &Diagnosis) -> Option<String> {
    let rival = diagnosis.runner_up.as_ref()?;
    let mut text = format!("Runner-up: {}; {}.", rival.in_words(), rival.compared());
    if let Some(experiment) = &diagnosis.experiment {
        text.push_str(&format!("\nTo be sure: {}", experiment.sentence));
        if let Some(then) = experiment.separation_then {
            let told = match then >= NAMED {
                true => "which tells the two apart",
                false => "which does not tell the two apart, either",
            };
            let compared = match then > 0.0 {
                true => format!("{} less", number::significant(then, DIGITS)),
                false => "no less".to_owned(),
            };
            text.push_str(&format!(
                "\nRehearsed on the simulated rig, χ² falls by {compared} with the rival there, {told}."
            ));
        }
        if !experiment.command.is_empty() {
            text.push_str(&format!("\nOn the simulated rig: {}", experiment.command));
        }
    }
    Some(text)
}
