//! Result of a campaign for people: tables for terminal and page, plots for the page.

use super::columns::{BINARY, PLAN};
use super::file::Limit;
use super::limit_results::{LimitResults, Split, splits};
use super::results::Results;
use super::setting::unit;
use super::statistics::Estimate;
use super::summary::{Sensitivity, Summary};
use anyhow::Result;
use softdock_io::data_table::Values;
use softdock_report::{
    Band, Bar, BarChart, Cell, Column, Format, Hue, Mark, Page, Plot, Series, Style, Table,
};

/// Digits of outcomes.
const DIGITS: usize = 4;
/// Share of successes that the lower end of the interval has to reach for the mark "kept"; below 1 less this share the mark
/// is "not kept".
const GOOD: f64 = 0.99;

/// The headline in a sentence.
pub fn headline(summary: &Summary) -> String {
    let kept = summary
        .success
        .map_or("none".to_owned(), |share| percent(&share));
    let failed = summary.rows - summary.completed;
    let failed = match failed {
        0 => String::new(),
        count => format!("; {count} were not carried out"),
    };
    let captured = summary
        .captured
        .map(|share| format!("; captured: {}", percent(&share)));
    let all = summary.limits.len();
    let read = summary.limits.iter().filter(|l| l.limit.source_read);
    let unread = match all - read.count() {
        0 => String::new(),
        unread => format!(" Limits without a source that somebody has read: {unread} of {all}."),
    };
    let draws = match summary.draws {
        draws if draws == 1 || draws == summary.rows => String::new(),
        draws => format!(" of {draws} draws"),
    };
    format!(
        "Of {} runs{draws}, {kept} are successes{}{failed}.{unread}",
        summary.rows,
        captured.unwrap_or_default()
    )
}

/// All tables with their titles.
pub fn tables(summary: &Summary) -> Vec<(&'static str, Table)> {
    let all = [
        ("Not carried out", failures(summary)),
        ("Limits", limits(&summary.limits)),
        ("Success by value", groups(summary)),
        ("Outcomes: quantiles with bounds", outcomes(summary)),
        (
            "Which factor matters: rank correlation",
            sensitivity(summary),
        ),
        ("Sobol' indices", sobol(summary)),
        ("Worst rows", worst(summary)),
    ];
    all.into_iter()
        .filter(|(_, table)| !table.rows.is_empty())
        .collect()
}

fn percent(share: &Estimate) -> String {
    let number = |share: f64| format!("{:.1}", share * 100.0);
    let value = number(share.value);
    match (share.low, share.high) {
        (Some(low), Some(high)) => format!("{value} % ({} to {} %)", number(low), number(high)),
        _ => format!("{value} %"),
    }
}

fn failures(summary: &Summary) -> Table {
    let mut table = Table::new(vec![Column::text("reason"), Column::number("rows", "")]);
    for (reason, count) in &summary.failures {
        table.push(vec![Cell::text(reason), Cell::text(count.to_string())]);
    }
    table
}

/// Each limit with the outcomes of the runs. The source of a limit is given in its first row.
fn limits(limits: &[LimitResults]) -> Table {
    let mut table = Table::new(vec![
        Column::text("outcome"),
        Column::number("limit", ""),
        Column::text("unit"),
        Column::text("runs with"),
        Column::number("median", ""),
        Column::number("worst", ""),
        Column::number("kept by", ""),
        Column::text("source of the limit"),
    ]);
    for LimitResults {
        limit,
        unit,
        results,
    } in limits
    {
        let number = |value: Option<f64>| {
            value.map_or_else(|| Cell::text(""), |value| Cell::number(value, DIGITS))
        };
        for (place, result) in results.iter().enumerate() {
            table.push(vec![
                Cell::text(&limit.outcome),
                Cell::text(limit.bounds()),
                Cell::text(unit.replace('1', "")),
                Cell::text(if result.group.is_empty() {
                    "all"
                } else {
                    &result.group
                }),
                number(result.median.map(|median| median.value)),
                number(result.worst),
                Cell::text(
                    result
                        .share_within
                        .as_ref()
                        .map(percent)
                        .unwrap_or_default(),
                ),
                match place {
                    0 => source(limit),
                    _ => Cell::text(""),
                },
            ]);
        }
    }
    let unread = limits.iter().any(|one| !one.limit.source_read);
    table.explained(if unread {
        "✗ no source of this limit that somebody has read: check the number before use"
    } else {
        ""
    })
}

/// Source of a limit, marked if nobody has read it.
fn source(limit: &Limit) -> Cell {
    let said = Cell::text(limit.source.as_deref().unwrap_or("none given"));
    if limit.source_read {
        said
    } else {
        said.marked(Mark::Bad)
    }
}

fn groups(summary: &Summary) -> Table {
    let median = format!("median {}", summary.worst_by);
    let mut table = Table::new(vec![
        Column::text("factor"),
        Column::text("value"),
        Column::number("success", ""),
        Column::number(median, unit(&summary.worst_by).replace('1', "")),
    ]);
    for group in &summary.groups {
        let success = group
            .success
            .map(|share| percent(&share))
            .unwrap_or_default();
        table.push(vec![
            Cell::text(&group.factor),
            Cell::text(&group.value),
            Cell::text(success),
            group
                .median
                .map_or_else(|| Cell::text(""), |m| Cell::number(m.value, DIGITS)),
        ]);
    }
    table
}

fn outcomes(summary: &Summary) -> Table {
    let heads = ["outcome", "unit"].map(Column::text).into_iter();
    let numbers = ["runs", "5 %", "median", "between", "95 %", "between"];
    let mut table = Table::new(
        heads
            .chain(numbers.map(|n| Column::number(n, "")))
            .collect(),
    );
    for outcome in &summary.outcomes {
        let value = |q: usize| match outcome.quantiles[q] {
            Some(estimate) => Cell::number(estimate.value, DIGITS),
            None => Cell::text(""),
        };
        let between = |q: usize| match outcome.quantiles[q] {
            Some(Estimate {
                low: Some(low),
                high: Some(high),
                ..
            }) => Cell::interval(low, high, 2),
            _ => Cell::text("too few draws"),
        };
        table.push(vec![
            Cell::text(outcome.name),
            Cell::text(outcome.unit),
            Cell::text(outcome.count.to_string()),
            value(0),
            value(1),
            between(1),
            value(2),
            between(2),
        ]);
    }
    table
}

/// A table with a row for each outcome and a column for each factor.
fn by_factor(summary: &Summary, value: impl Fn(&Sensitivity) -> Option<String>) -> Table {
    let mut factors: Vec<&str> = Vec::new();
    for entry in &summary.sensitivity {
        if !factors.contains(&entry.factor.as_str()) {
            factors.push(&entry.factor);
        }
    }
    let heads = factors.iter().map(|factor| Column::number(*factor, ""));
    let mut table = Table::new(
        std::iter::once(Column::text("outcome"))
            .chain(heads)
            .collect(),
    );
    for own in summary.sensitivity.chunk_by(|a, b| a.outcome == b.outcome) {
        let values: Vec<Option<String>> = own.iter().map(&value).collect();
        if values.iter().any(Option::is_some) {
            let cells = values
                .into_iter()
                .map(|value| Cell::text(value.unwrap_or_default()));
            table.push(
                std::iter::once(Cell::text(own[0].outcome))
                    .chain(cells)
                    .collect(),
            );
        }
    }
    table
}

fn sensitivity(summary: &Summary) -> Table {
    by_factor(summary, |entry| {
        entry.rank_correlation.map(|r| format!("{r:+.2}"))
    })
}

fn sobol(summary: &Summary) -> Table {
    by_factor(summary, |entry| {
        entry
            .sobol
            .map(|index| format!("{:.2}, total {:.2}", index.first, index.total))
    })
}

fn worst(summary: &Summary) -> Table {
    let mut table = Table::new(vec![
        Column::number("row", ""),
        Column::number(&summary.worst_by, unit(&summary.worst_by).replace('1', "")),
        Column::text("see it"),
    ]);
    for row in &summary.worst {
        table.push(vec![
            Cell::text(row.index.to_string()),
            Cell::number(row.value, DIGITS),
            Cell::text(&row.rerun),
        ]);
    }
    table
}

/// The report.
///
/// # Errors
/// A plot cannot be drawn.
pub fn page(results: &Results<'_>, summary: &Summary) -> Result<Page> {
    let title = match summary.title.as_str() {
        "" => "Campaign",
        title => title,
    };
    let mut page = Page::new(title);
    let (mark, badge, why) = judgement(summary);
    let sentence = format!("{} {why}", headline(summary));
    page.verdict(mark, badge, sentence.trim_end());
    page.section("What was varied").list(&varied(results));
    for (title, table) in tables(summary) {
        page.section(title).table(&table);
    }
    let splits = splits(results)?;
    page.section("Pictures").bars(&influence(summary))?;
    page.columns(&maps(results, summary, &splits)?)?;
    page.columns(&distributions(results, &splits)?)?;
    for (title, text) in ["Campaign file", "Scenario, with all defaults"]
        .iter()
        .zip(&results.plan.texts)
        .filter(|(_, text)| !text.is_empty())
    {
        page.details(title, text);
    }
    let metadata = |name| results.table.metadata(name).unwrap_or_default();
    page.identity(&format!("{}, plan {}", metadata(BINARY), metadata(PLAN)));
    Ok(page)
}

/// Mark, word and reason of the verdict on the limits. Few draws cannot show 99 %, however well they went.
fn judgement(summary: &Summary) -> (Mark, &'static str, String) {
    let Some(share) = summary.success else {
        return (Mark::Neutral, "no runs", String::new());
    };
    let shown = match share.low {
        None if !summary.exhaustive => 0.0,
        low => low.unwrap_or(share.value),
    };
    let (good, draws) = (GOOD * 100.0, summary.draws);
    match share.value {
        _ if shown >= GOOD => {
            let why = match share.low {
                Some(_) => format!("The interval begins at {good} % or above."),
                None => "Every combination was run once, each with one noise.".to_owned(),
            };
            (Mark::Good, "kept", why)
        }
        value if value >= GOOD => {
            let why = format!("{draws} draw(s) are too few to show {good} %.");
            (Mark::Neutral, "too few draws", why)
        }
        value if value < 1.0 - GOOD => (Mark::Bad, "not kept", String::new()),
        _ => (Mark::Neutral, "partly kept", String::new()),
    }
}

/// One sentence per factor.
fn varied(results: &Results<'_>) -> Vec<String> {
    let factors = results.plan.factors.iter().map(|factor| {
        let unit = unit(&factor.settings[0]).replace('1', "");
        format!(
            "{}: {} {unit} ({})",
            factor.name,
            factor.distribution.text(),
            factor.settings.join(", ")
        )
    });
    factors.collect()
}

/// Chart of how strongly each factor correlates with the outcome that ranks rows.
fn influence(summary: &Summary) -> BarChart {
    let mut chart = BarChart::new(
        format!("Which factor matters for {}", summary.worst_by),
        "rank correlation, magnitude",
        Format::Significant(2),
    );
    chart.bars = strongest(summary)
        .into_iter()
        .map(|(factor, r)| Bar::new(factor, r))
        .collect();
    chart
}

/// Factors, ordered by their correlation with the outcome that ranks rows.
fn strongest(summary: &Summary) -> Vec<(&str, f64)> {
    let own = summary
        .sensitivity
        .iter()
        .filter(|entry| entry.outcome == summary.worst_by);
    let mut factors: Vec<(&str, f64)> = own
        .filter_map(|entry| Some((entry.factor.as_str(), entry.rank_correlation?.abs())))
        .collect();
    factors.sort_by(|a, b| b.1.total_cmp(&a.1));
    factors
}

/// Maps of success over the two numeric factors that matter most.
fn maps(results: &Results<'_>, summary: &Summary, splits: &[Split]) -> Result<Vec<Plot>> {
    let numeric = |name: &&str| matches!(results.table.values(name), Ok(Values::Number(_)));
    let names = strongest(summary).into_iter().map(|(name, _)| name);
    let mut names: Vec<&str> = names.filter(numeric).collect();
    if names.len() == 1 {
        names.push(&summary.worst_by);
    }
    let &[x, y, ..] = names.as_slice() else {
        return Ok(Vec::new());
    };
    let label = |name: &str| {
        let factor = results
            .plan
            .factors
            .iter()
            .find(|factor| factor.name == name);
        with_unit(name, factor.map_or(name, |factor| &factor.settings[0]))
    };
    let success = results.successes()?;
    let (xs, ys) = (results.numbers(x)?, results.numbers(y)?);
    let title = |split: &Split| match split.name.as_str() {
        "" => "Where it succeeds".to_owned(),
        name => format!("Where it succeeds: {name}"),
    };
    let map = |split: &Split| {
        let mut plot = Plot::new(title(split), label(x), label(y));
        for (name, kept, hue) in [
            ("success", true, Hue::Blue),
            ("no success", false, Hue::Vermilion),
        ] {
            let own = (0..success.len()).filter(|row| split.rows[*row] && success[*row] == kept);
            let points = own.filter_map(|row| Some((xs[row]?, ys[row]?))).collect();
            plot.series
                .push(Series::new(name, Style::Points, points).colored(hue));
        }
        plot
    };
    Ok(splits.iter().map(map).collect())
}

/// Distribution of each outcome, with its limit.
fn distributions(results: &Results<'_>, splits: &[Split]) -> Result<Vec<Plot>> {
    let mut plots = Vec::new();
    for number in results.shown_numbers() {
        let all = results.numbers(number.name)?;
        let values = |split: &Split| {
            let own = all.iter().zip(&split.rows).filter(|(_, own)| **own);
            let finite = own.filter_map(|(value, _)| value.filter(|value| value.is_finite()));
            let mut values: Vec<f64> = finite.collect();
            values.sort_by(f64::total_cmp);
            values
        };
        let mut plot = Plot::new(
            number.name,
            with_unit(number.name, number.name),
            "share below",
        );
        let (mut first, mut last) = (f64::INFINITY, f64::NEG_INFINITY);
        for split in splits {
            let values = values(split);
            first = values.first().map_or(first, |value| first.min(*value));
            last = values.last().map_or(last, |value| last.max(*value));
            let share = |place: usize| (place + 1) as f64 / values.len() as f64;
            let points = values
                .iter()
                .enumerate()
                .map(|(place, value)| (*value, share(place)));
            plot.series
                .push(Series::new(&split.name, Style::Step, points.collect()));
        }
        // A constant outcome has no distribution to show.
        if first >= last {
            continue;
        }
        let limits = results.plan.campaign.limits.iter();
        plot.shaded = limits
            .filter(|limit| limit.outcome == number.name)
            .map(|limit| Band {
                from: limit.low.unwrap_or(first),
                to: limit.high.unwrap_or(last),
                label: "within the limit".to_owned(),
                hue: None,
            })
            .collect();
        plots.push(plot);
    }
    Ok(plots)
}

/// A name, with its unit in brackets if it has one.
fn with_unit(name: &str, unit_of: &str) -> String {
    match unit(unit_of) {
        "1" => name.to_owned(),
        unit => format!("{name} [{unit}]"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::campaign::statistics::share;

    #[test]
    fn few_draws_show_no_99_percent() {
        for (success, exhaustive, badge) in [
            (share(400, 400, 400), false, "kept"),
            (share(8, 8, 1), true, "kept"),
            (share(8, 8, 1), false, "too few draws"),
            (share(400, 400, 100), false, "too few draws"),
            (share(3, 3, 3), false, "too few draws"),
            (share(2, 3, 3), false, "partly kept"),
            (share(0, 3, 3), false, "not kept"),
        ] {
            let summary = Summary {
                success,
                exhaustive,
                ..Summary::default()
            };
            assert_eq!(judgement(&summary).1, badge, "{success:?}");
        }
    }
}
