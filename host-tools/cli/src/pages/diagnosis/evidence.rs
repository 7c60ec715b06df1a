//! The evidence: how the error falls, which hypotheses were tried, and the closest rival.

use super::{Source, words};
use softdock_analysis::compare::ROUND_OFF_SIGMA;
use softdock_analysis::diagnose::{Ranked, Verdict};
use softdock_analysis::levels::{BeforeAfter, ChannelLevels};
use softdock_physics::model::Channel;
use softdock_report::{Bar, BarChart, Cell, Column, Format, Hue, Mark, Page, Table};

/// Number of hypotheses that are listed; the number of the others is printed.
const SHOWN: usize = 10;
/// Format of gains of χ²: a fraction of 1 has no meaning.
const GAIN: Format = Format::Fixed(0);

impl Source<'_> {
    /// Section on how large the error is, and how it falls.
    pub(super) fn error(&self, page: &mut Page) -> anyhow::Result<()> {
        let diagnosis = self.diagnosis;
        let falls = self.after.is_some() && diagnosis.steps.len() > 1;
        page.section(if falls {
            "How the error falls"
        } else {
            "How large the error is"
        });
        if falls {
            page.bars(&self.error_waterfall())?;
        }
        page.table(&level_table(
            &diagnosis.residual_rms_sigma,
            self.after.is_some(),
        ));
        page.paragraph(&format!(
            "RMS of measured minus predicted over all axes of a channel on {}, in units of the model file's \
             noise (σₙ, its standard deviation).",
            self.identity.judged()
        ));
        Ok(())
    }

    fn error_waterfall(&self) -> BarChart {
        let steps = &self.diagnosis.steps;
        let mut chart = BarChart::waterfall(
            "Error of all channels together after each effect",
            "RMS error [σₙ]",
            Format::Significant(3),
        );
        let tested = steps.iter().any(|step| step.test_error.is_some());
        if tested {
            let unseen = words::unseen(self.diagnosis).to_owned();
            chart.names = Some([unseen, "data of the fit".to_owned()]);
            "RMS error [σₙ] | of the fit".clone_into(&mut chart.value_label);
        }
        chart.bars = steps
            .iter()
            .enumerate()
            .map(|(index, step)| {
                let label = match index {
                    0 => "model as given".to_owned(),
                    _ => format!("+ {}", step.effect),
                };
                match step.test_error {
                    Some(test) => Bar::new(label, test).with_second(step.train_error),
                    None if tested => Bar::new(label, f64::NAN).with_second(step.train_error),
                    None => Bar::new(label, step.train_error),
                }
            })
            .collect();
        chart
    }

    /// All hypotheses with their evidence.
    pub(super) fn ranking(&self, page: &mut Page) -> anyhow::Result<()> {
        let ranked = &self.diagnosis.ranked;
        if ranked.is_empty() {
            return Ok(());
        }
        page.section("Hypotheses");
        page.paragraph(&format!(
            "By how much χ², the sum of squared errors relative to the noise, falls with each of them: \
             fitted on {}, then judged with the same parameters on {}. A hypothesis without merit gains \
             about as much as it has parameters where it was fitted, and loses elsewhere.",
            self.identity.train,
            words::unseen(self.diagnosis),
        ));
        page.bars(&self.gains())?;
        page.table(&self.ranking_table());
        let shown = ranked.iter().take(SHOWN);
        let refused: Vec<String> = shown.filter_map(refusal).collect();
        if !refused.is_empty() {
            page.paragraph("Why hypotheses are refused:");
            page.list(&refused);
        }
        if ranked.len() > SHOWN {
            page.paragraph(&format!(
                "{} less likely hypotheses are not listed.",
                ranked.len() - SHOWN
            ));
        }
        Ok(())
    }

    fn gains(&self) -> BarChart {
        let mut chart = BarChart::new("Fall of χ² with each hypothesis", "fall of χ²", GAIN);
        let unseen = words::unseen(self.diagnosis).to_owned();
        chart.names = Some([unseen, "data of the fit".to_owned()]);
        let shown = self.diagnosis.ranked.iter().take(SHOWN);
        chart.bars = shown
            .map(|ranked| {
                let label = words::hypothesis(&ranked.effects);
                let hue = match self.standing(ranked) {
                    Standing::Named | Standing::Part => Hue::Blue,
                    Standing::Refused => Hue::Amber,
                    Standing::Behind => Hue::Grey,
                };
                let bar = Bar::new(label, ranked.gain_test).colored(hue);
                bar.with_second(ranked.gain_train)
            })
            .collect();
        chart
    }

    fn ranking_table(&self) -> Table {
        let mut table = Table::new(vec![
            Column::text("Hypothesis"),
            Column::text("Channel"),
            Column::number("Parameters", ""),
            Column::number("Fall of χ², fit", ""),
            Column::number("unseen", ""),
            Column::text("Judgement"),
        ]);
        for ranked in self.diagnosis.ranked.iter().take(SHOWN) {
            let judgement = match self.standing(ranked) {
                Standing::Named => Cell::text("named").marked(Mark::Good),
                Standing::Part => Cell::text("part of it").marked(Mark::Neutral),
                Standing::Refused => Cell::text("refused").marked(Mark::Bad),
                Standing::Behind => Cell::text("behind").marked(Mark::Neutral),
            };
            table.push(vec![
                Cell::text(words::hypothesis(&ranked.effects)),
                Cell::text(words::channel(ranked.channel)),
                Cell::text(ranked.parameters.to_string()),
                Cell::formatted(ranked.gain_train, GAIN),
                Cell::formatted(ranked.gain_test, GAIN),
                judgement,
            ]);
        }
        table
    }

    fn standing(&self, ranked: &Ranked) -> Standing {
        let named = |hypothesis: &Ranked| {
            let effects = &hypothesis.effects;
            hypothesis.refused.is_none()
                && !effects.is_empty()
                && effects.iter().all(|e| self.diagnosis.effects.contains(e))
        };
        let holds_it = |other: &Ranked| {
            other.effects.len() > ranked.effects.len()
                && ranked.effects.iter().all(|e| other.effects.contains(e))
        };
        let mut all = self.diagnosis.ranked.iter();
        if ranked.refused.is_some() {
            Standing::Refused
        } else if !named(ranked) {
            Standing::Behind
        } else if all.any(|other| named(other) && holds_it(other)) {
            Standing::Part
        } else {
            Standing::Named
        }
    }

    /// Section on the closest rival, and the experiment that would decide.
    pub(super) fn rival(&self, page: &mut Page) -> anyhow::Result<()> {
        let diagnosis = self.diagnosis;
        if diagnosis.runner_up.is_none() && diagnosis.experiment.is_none() {
            return Ok(());
        }
        page.section(if diagnosis.runner_up.is_some() {
            "The runner-up, and how to be sure"
        } else {
            "The experiment that would tell more"
        });
        if let Some(rival) = &diagnosis.runner_up {
            page.paragraph(&format!(
                "The closest rival is {}: {}.",
                rival.in_words(),
                rival.compared()
            ));
        }
        if let Some(experiment) = &diagnosis.experiment {
            page.paragraph(&experiment.sentence);
            if let Some(then) = experiment.separation_then {
                page.bars(&separations(experiment.separation_now, then))?;
            }
            if !experiment.command.is_empty() {
                page.paragraph("On the simulated rig, at once:");
                page.code(&experiment.command);
            }
        }
        Ok(())
    }

    /// Section on curves that resemble the error but have no name.
    pub(super) fn hints(&self, page: &mut Page) {
        if self.diagnosis.looks_like.is_empty() {
            return;
        }
        page.section("What it looks like");
        page.paragraph(match self.diagnosis.verdict {
            Verdict::Unexplained => "Partial matches, none good enough for a name:",
            _ => "Partial matches; hints, not names:",
        });
        page.list(&self.diagnosis.looks_like);
    }
}

/// Why a hypothesis is not named although it fits.
fn refusal(ranked: &Ranked) -> Option<String> {
    let reason = ranked.refused.as_ref()?;
    Some(format!("{}: {reason}", words::hypothesis(&ranked.effects)))
}

/// Rank of a hypothesis in relation to the answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Standing {
    /// It is the answer, or the answer for its channel.
    Named,
    /// It is part of a larger hypothesis that is the answer.
    Part,
    Refused,
    Behind,
}

/// Error per channel.
fn level_table(levels: &BeforeAfter, two: bool) -> Table {
    let mut columns = vec![
        Column::text("Channel"),
        Column::number(if two { "Before" } else { "RMS error" }, "σₙ"),
    ];
    if two {
        columns.push(Column::number("After", "σₙ"));
        columns.push(Column::number("Change", ""));
    }
    let mut table = Table::new(columns);
    let values = |levels: &ChannelLevels| {
        [
            levels.executed_velocity,
            levels.wrench,
            levels.model_velocity,
            levels.pose,
        ]
        .map(|value| if value < ROUND_OFF_SIGMA { 0.0 } else { value })
    };
    let pairs = values(&levels.before)
        .into_iter()
        .zip(values(&levels.after));
    for (channel, (before, after)) in Channel::ALL.into_iter().zip(pairs) {
        let mut row = vec![Cell::text(words::channel(channel)), Cell::number(before, 3)];
        if two {
            row.push(Cell::number(after, 3));
            row.push(change(before, after));
        }
        table.push(row);
    }
    table
}

/// Relative change, judged where it is more than a percent.
fn change(before: f64, after: f64) -> Cell {
    let change = (after - before) / before;
    if !change.is_finite() {
        return Cell::text("");
    }
    match change {
        _ if change < -0.01 => Cell::formatted(change, Format::Percent(0)).marked(Mark::Good),
        _ if change > 0.01 => Cell::formatted(change, Format::Percent(0)).marked(Mark::Bad),
        _ => Cell::text("same").marked(Mark::Neutral),
    }
}

fn separations(now: f64, then: f64) -> BarChart {
    let mut chart = BarChart::new(
        "How clearly the two can be told apart",
        "2 Δ log L",
        Format::Significant(3),
    );
    chart.bars = vec![
        Bar::new("this log", now).colored(Hue::Grey),
        Bar::new("the experiment on the simulated rig", then),
    ];
    chart
}
