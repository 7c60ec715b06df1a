//! `softdock history`: how the error of a model fell, step by step.

use super::findings::Telling;
use anyhow::Result;
use clap::Args;
use softdock_analysis::fit::record::Fall;
use softdock_physics::model::{HistoryStep, Model};
use softdock_report::{Bar, BarChart, Cell, Column, Format, Page, Table};
use std::path::PathBuf;

/// Cells of the longest bar.
const BAR_CELLS: f64 = 30.0;
/// Block characters that fill no to seven eighths of a cell.
const EIGHTHS: [&str; 8] = ["", "▏", "▎", "▍", "▌", "▋", "▊", "▉"];
/// Significant digits of errors.
const DIGITS: usize = 3;

/// Show how the error fell with each effect that was added to a model.
///
/// The error is that of all channels together, in units of the model file's noise: 1 is noise.
#[derive(Debug, Args)]
#[command(after_help = "Example: softdock history model.toml --report history.html")]
pub(super) struct History {
    /// Model file (TOML)
    model: PathBuf,
    #[command(flatten)]
    telling: Telling,
}

impl History {
    pub(super) fn execute(self) -> Result<()> {
        let model = Model::load(&self.model)?;
        self.telling.check(&[&self.model])?;
        let text = || match model.history.is_empty() {
            true => format!(
                "{} has no history yet; `softdock add` begins it.\n",
                self.model.display()
            ),
            false => format!("{}\n", table(&model)),
        };
        self.telling
            .give(&Fall::of(&model.history), || self.page(&model), text)
    }

    fn page(&self, model: &Model) -> Result<Page> {
        let steps = &model.history;
        let mut page = Page::new(format!("History of {}", self.model.display()));
        page.headline(&headline(steps));
        for run in runs(steps) {
            let Some(first) = run.first() else { continue };
            page.section(&format!("Fitted on {}", first.train));
            page.bars(&waterfall(run, model))?;
        }
        if !steps.is_empty() {
            page.section("All steps").table(&plain(model));
        }
        page.identity(&softdock_io::identity::text());
        Ok(page)
    }
}

/// The error on unseen data; without such data, the error on the data of the fit.
fn judged(step: &HistoryStep) -> f64 {
    step.test_error.unwrap_or(step.train_error)
}

/// Groups consecutive steps on the same recordings: only their errors can be compared.
fn runs(steps: &[HistoryStep]) -> impl Iterator<Item = &[HistoryStep]> {
    steps.chunk_by(|a, b| a.train == b.train && a.test == b.test)
}

fn headline(steps: &[HistoryStep]) -> String {
    let last = runs(steps).last().unwrap_or_default();
    match (last.first(), last.last()) {
        (Some(first), Some(end)) if last.len() > 1 => format!(
            "The error {} {} from {:.2} to {:.2} in units of the model file's noise.",
            match &end.test {
                Some(test) => format!("on {test}, which no fit has seen,"),
                None => format!("on {}", end.train),
            },
            if judged(end) < judged(first) {
                "fell"
            } else {
                "went"
            },
            judged(first),
            judged(end)
        ),
        _ => "Nothing has been added to the model yet.".to_owned(),
    }
}

fn waterfall(run: &[HistoryStep], model: &Model) -> BarChart {
    let mut chart = BarChart::waterfall(
        "Error of all channels together after each step",
        "RMS error [σₙ]",
        Format::Significant(DIGITS),
    );
    let tested = run.iter().any(|step| step.test_error.is_some());
    if tested {
        chart.names = Some(["unseen data".to_owned(), "data of the fit".to_owned()]);
        "RMS error [σₙ] | of the fit".clone_into(&mut chart.value_label);
    }
    chart.bars = run
        .iter()
        .map(|step| match step.test_error {
            Some(error) => Bar::new(label(step, model), error).with_second(step.train_error),
            None if tested => Bar::new(label(step, model), f64::NAN).with_second(step.train_error),
            None => Bar::new(label(step, model), step.train_error),
        })
        .collect();
    chart
}

/// Description of a step, and whether it was reverted.
fn label(step: &HistoryStep, model: &Model) -> String {
    match step.effect.as_str() {
        HistoryStep::NOMINAL => "model as given".to_owned(),
        HistoryStep::EDITED => "edited by hand".to_owned(),
        HistoryStep::REFIT => "all parameters fitted anew".to_owned(),
        effect if model.effects.iter().any(|now| now.id == effect) => format!("+ {effect}"),
        effect => format!("+ {effect} (taken out)"),
    }
}

/// The history as numbers without bars.
fn plain(model: &Model) -> Table {
    let mut table = Table::new(vec![
        Column::text("Step"),
        Column::number("Error, fit", "σₙ"),
        Column::number("unseen", "σₙ"),
        Column::text("Fitted on"),
        Column::text("Unseen"),
    ]);
    for step in &model.history {
        table.push(vec![
            Cell::text(label(step, model)),
            Cell::number(step.train_error, DIGITS),
            step.test_error
                .map_or_else(|| Cell::text(""), |e| Cell::number(e, DIGITS)),
            Cell::text(&step.train),
            Cell::text(step.test.as_deref().unwrap_or_default()),
        ]);
    }
    table
}

/// The history for the terminal: each group of comparable steps with its bars.
fn table(model: &Model) -> Table {
    let mut table = Table::new(vec![
        Column::text("Step"),
        Column::number("Error, fit", "σₙ"),
        Column::number("unseen", "σₙ"),
        Column::text(""),
        Column::text("Fitted on"),
    ]);
    for run in runs(&model.history) {
        let largest = run.iter().map(judged).fold(0.0, f64::max);
        for step in run {
            table.push(vec![
                Cell::text(label(step, model)),
                Cell::number(step.train_error, DIGITS),
                step.test_error
                    .map_or_else(|| Cell::text(""), |e| Cell::number(e, DIGITS)),
                Cell::text(bar(judged(step) / largest)),
                Cell::text(&step.train),
            ]);
        }
    }
    table
}

/// A bar whose length is a share of that of the longest bar.
fn bar(share: f64) -> String {
    if !share.is_finite() {
        return String::new();
    }
    let eighths = (share.clamp(0.0, 1.0) * BAR_CELLS * 8.0).round() as usize;
    format!("{}{}", "█".repeat(eighths / 8), EIGHTHS[eighths % 8])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bars_are_as_long_as_their_share() {
        assert_eq!(bar(1.0), "█".repeat(30));
        assert_eq!(bar(0.5), "█".repeat(15));
        assert_eq!(bar(1.0 / 60.0), "▌");
        assert_eq!(bar(f64::NAN), "");
    }
}
