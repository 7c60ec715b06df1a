//! The tables of the benchmark, for the terminal.

use super::coverage::{Coverage, FEW, ReliabilityBin};
use super::nulls::Nothing;
use super::{Bench, Row, rates};
use softdock_hidden_effects::{NoiseRange, Verdict};
use softdock_report::{Cell, Column, Table};

/// One line per case, with its diagnosis.
pub fn cases(rows: &[&Row]) -> Table {
    let mut table = of_text(&["case", "size", "hidden", "said", "right", "error gone"]);
    for row in rows {
        let said = match row.verdict {
            Verdict::Named => row.effects.join(" + "),
            Verdict::NothingMissing => "nothing missing".to_owned(),
            Verdict::Unexplained => "unexplained".to_owned(),
            Verdict::LogsDisagree => "logs disagree".to_owned(),
            Verdict::NotTestable => "not testable".to_owned(),
        };
        let hidden = match row.hidden[..] {
            [] => "nothing".to_owned(),
            _ => row.hidden.join(" + "),
        };
        let gone = row.drop_percent.map(|d| format!("{d:.0} %"));
        table.push(vec![
            Cell::text(&row.name),
            Cell::number(row.size, 3),
            Cell::text(hidden),
            Cell::text(said),
            Cell::text(if row.right { "yes" } else { "NO" }),
            Cell::text(gone.unwrap_or_default()),
        ]);
    }
    table
}

/// Number of found effects by size.
pub fn ladder(rows: &[Row]) -> Table {
    let mut sizes: Vec<f64> = rows.iter().map(|r| r.size).collect();
    sizes.sort_by(|a, b| b.total_cmp(a));
    sizes.dedup();
    let mut table = of_text(&["size of the effect", "found", "of"]);
    for size in sizes {
        let of_size = rows.iter().filter(|r| r.size == size);
        let found = of_size.clone().filter(|r| r.right).count();
        let [found, of] = [found, of_size.count()].map(count);
        table.push(vec![Cell::text(size.to_string()), found, of]);
    }
    table
}

/// The scores of a set.
pub fn summary(scored: &Bench) -> Table {
    let mut table = of_text(&["score", "right", "of"]);
    for (name, rate) in rates(&scored.scores).into_iter().filter(|r| r.1.of > 0) {
        table.push(vec![Cell::text(name), count(rate.right), count(rate.of)]);
    }
    let scores = &scored.scores;
    if let (Some(median), Some(least)) = (scores.median_drop_percent(), scores.min_drop_percent()) {
        table.push(vec![
            Cell::text("error gone, median and least"),
            Cell::text(format!("{median:.1} %")),
            Cell::text(format!("{least:.1} %")),
        ]);
    }
    table
}

/// Coverage of the 95 % intervals.
pub fn coverage(all: &[Coverage]) -> Table {
    let mut table = of_text(&[
        "95 % intervals of",
        "cases",
        "intervals",
        "with the truth",
        "share",
    ]);
    for one in all {
        let few = if one.cases < FEW { ", few cases" } else { "" };
        table.push(vec![
            Cell::text(&one.effect),
            count(one.cases),
            count(one.of),
            count(one.right),
            Cell::text(format!("{:.0} %{few}", 100.0 * one.share())),
        ]);
    }
    table
}

/// Calibration of the probabilities.
pub fn probabilities(all: &[ReliabilityBin]) -> Table {
    let mut table = of_text(&["probability that was said", "effects", "hidden"]);
    for one in all {
        let range = format!("{} to {}", one.from, one.to);
        table.push(vec![Cell::text(range), count(one.of), count(one.right)]);
    }
    table
}

/// Duration of a diagnosis, and the peak memory of all that ran in parallel.
pub fn cost(scored: &Bench, memory_mb: Option<f64>) -> Table {
    let mut table = of_text(&["a diagnosis takes", ""]);
    for (name, share) in [("median", 0.5), ("90 %", 0.9), ("longest", 1.0)] {
        if let Some(seconds) = scored.scores.seconds_of(share) {
            let cells = vec![Cell::text(name), Cell::text(format!("{seconds:.2} s"))];
            table.push(cells);
        }
    }
    if let Some(memory) = memory_mb {
        let cells = vec![
            Cell::text("memory of all at once"),
            Cell::text(format!("{memory:.0} MB")),
        ];
        table.push(cells);
    }
    table
}

/// Answers about logs with nothing hidden.
pub fn alarms(nothing: &Nothing) -> Table {
    let mut columns = vec![Column::text("noise")];
    let titles = [
        "logs",
        "an effect named",
        "something else said",
        "largest evidence",
    ];
    columns.extend(titles.map(|title| Column::number(title, "")));
    let mut table = Table::new(columns);
    for one in &nothing.alarms {
        let noise = match one.noise {
            NoiseRange::Usual => "the data sheet's, to 1.3 times, some coloured",
            NoiseRange::Wide => "1 to 1.6 times, coloured wrench",
            NoiseRange::ColouredVelocity => "1 to 1.6 times, coloured wrench and velocity",
        };
        table.push(vec![
            Cell::text(noise),
            count(one.logs),
            count(one.false_names),
            count(one.other_verdicts),
            number(one.most),
        ]);
    }
    table
}

/// Evidence in logs with nothing hidden, where the noise of the velocity is white.
pub fn evidence(nothing: &Nothing) -> Table {
    let mut columns = vec![
        Column::text("evidence, largest of a log"),
        Column::number("logs", ""),
    ];
    columns.extend(["50 %", "90 %", "99 %", "largest"].map(|title| Column::number(title, "")));
    let mut table = Table::new(columns);
    for one in &nothing.stages {
        let mut cells = vec![Cell::text(one.stage), count(one.logs)];
        let quantiles = [one.median, one.of_90_percent, one.of_99_percent, one.most];
        cells.extend(quantiles.map(number));
        table.push(cells);
    }
    table
}

/// The limit that follows from the tail, in sentences.
pub fn limits(nothing: &Nothing) -> String {
    let mut text = String::new();
    if let (Some(tail), Some(limit)) = (&nothing.tail, nothing.limit_of_1_in_1000) {
        text.push_str(&format!(
            "Where the noise of the velocity is white, the largest {} exceed {:.1} by a generalised Pareto law with scale {:.2} and shape {:.2} \
             (probability-weighted moments): one log in 1,000 reaches {limit:.1}.\n",
            tail.count, tail.above, tail.scale, tail.shape
        ));
    }
    text.push_str(&format!(
        "An effect is named from {} on.",
        nothing.limit_in_force
    ));
    text
}

fn of_text(titles: &[&str]) -> Table {
    Table::new(titles.iter().map(|title| Column::text(*title)).collect())
}

fn number(value: Option<f64>) -> Cell {
    value.map_or_else(|| Cell::text("-"), |value| Cell::number(value, 3))
}

fn count(count: usize) -> Cell {
    Cell::text(count.to_string())
}
