//! The tables of the benchmark, for the terminal and the page.

use super::marks::{ADDED, HEADLINE, mark_of_error, mark_of_momentum};
use super::measure::Ending;
use super::ranking::{self, sentence, standings};
use super::row::Row;
use softdock_control::delay::LawName;
use softdock_report::{Cell, Column, Format, Mark, Table};

/// Meaning of the star.
pub const STAR: &str = "* the law moved the model by more than measured force: over 1 % of 2 m v0";
/// Sweeps of which mean and spread are shown.
const SPREAD: [&str; 3] = ["noise", "jitter", "perturbed"];
/// The verdict and the tables for the terminal, the best law first.
pub fn terminal(rows: &[Row], laws: &[LawName]) -> String {
    let all: Vec<&Row> = rows.iter().collect();
    let standings = standings(&all, laws);
    let best_first: Vec<LawName> = standings.iter().map(|standing| standing.law).collect();
    let mut text = format!("{}\n\n{}", sentence(&standings), ranking::table(&standings));
    let (headline, others): (Vec<&Row>, Vec<&Row>) = rows.iter().partition(|r| r.sweep == HEADLINE);
    if !headline.is_empty() {
        text.push_str(&format!(
            "\nLargest error of the restitution, by robot\n{}",
            robots(&headline, &best_first)
        ));
    }
    if !others.is_empty() {
        text.push_str(&format!(
            "\nRestitution, worst touch\n{}",
            cases(&others, laws, &best_first)
        ));
        let spread = spread(&others, laws, &best_first);
        if !spread.rows.is_empty() {
            text.push_str(&format!("\nMean and standard deviation\n{spread}"));
        }
    }
    text
}

/// One line per law, one column per robot: the largest error over all speeds.
pub fn robots(rows: &[&Row], laws: &[LawName]) -> Table {
    let mut robots: Vec<&str> = rows.iter().map(|r| r.actuator).collect();
    robots.dedup();
    let columns = robots.iter().map(|robot| Column::number(*robot, ""));
    let mut table = Table::new(
        std::iter::once(Column::text("law"))
            .chain(columns)
            .collect(),
    );
    for law in laws {
        let worst = |robot: &&str| {
            let of = rows
                .iter()
                .filter(|r| r.actuator == *robot && r.law == *law);
            let error = of.map(|row| row.error()).fold(0.0, f64::max);
            Cell::formatted(error, Format::Percent(2)).marked(mark_of_error(error))
        };
        let mut cells = vec![Cell::text(law.name())];
        cells.extend(robots.iter().map(worst));
        table.push(cells);
    }
    table
}

/// One line per robot and speed, one column per law.
pub fn speeds(rows: &[&Row], laws: &[LawName], best_first: &[LawName]) -> Table {
    let mut columns = vec![
        Column::text("robot"),
        Column::number("speed", "mm/s"),
        Column::number("ideal", ""),
    ];
    columns.extend(best_first.iter().map(|law| Column::number(law.name(), "")));
    let mut table = Table::new(columns);
    for group in groups(rows, laws) {
        let mut cells = vec![
            Cell::text(group[0].actuator),
            Cell::number(group[0].speed_mm_s, 3),
            Cell::formatted(group[0].expected_restitution, Format::Fixed(3)),
        ];
        let of = |law: &LawName| group.iter().find(|row| row.law == *law);
        cells.extend(best_first.iter().filter_map(of).map(|row| restitution(row)));
        table.push(cells);
    }
    table
}

/// One line per robot and law: the worst of every number over all speeds.
pub fn worst(rows: &[&Row], laws: &[LawName]) -> Table {
    let mut table = Table::new(vec![
        Column::text("robot"),
        Column::text("law"),
        Column::number("restitution error", ""),
        Column::number("of the robot", ""),
        Column::number("energy error", ""),
        Column::number("peak force error", ""),
        Column::number("contact time error", ""),
        Column::number("way RMS", ""),
        Column::number("way peak", ""),
        Column::number("impulse unaccounted", ""),
        Column::number("command", "v0"),
    ]);
    let mut robots: Vec<&str> = rows.iter().map(|r| r.actuator).collect();
    robots.dedup();
    for robot in robots {
        for law in laws {
            let of: Vec<&Row> = rows
                .iter()
                .copied()
                .filter(|r| r.actuator == robot && r.law == *law)
                .collect();
            table.push(worst_cells(robot, *law, &of));
        }
    }
    table
}

fn worst_cells(robot: &str, law: LawName, rows: &[&Row]) -> Vec<Cell> {
    let largest = |pick: fn(&Row) -> f64| rows.iter().map(|r| pick(r).abs()).fold(0.0, f64::max);
    let error = largest(Row::restitution_error);
    let added = largest(|r| r.impulse_unaccounted);
    let percent = |value: f64| Cell::formatted(value, Format::Percent(1));
    vec![
        Cell::text(robot),
        Cell::text(law.name()),
        Cell::formatted(error, Format::Percent(2)).marked(mark_of_error(error)),
        percent(largest(Row::robot_restitution_error)),
        percent(largest(|r| r.energy_error)),
        percent(largest(|r| r.peak_force_error)),
        percent(largest(|r| r.contact_time_error)),
        percent(largest(|r| r.tracking_nrms.unwrap_or(0.0))),
        percent(largest(|r| r.tracking_peak.unwrap_or(0.0))),
        Cell::formatted(added, Format::Percent(1)).marked(mark_of_momentum(added)),
        Cell::number(largest(|r| r.command_peak), 2),
    ]
}

/// One line per case and speed, one column per law. If all lines have the same robot or speed, it is named below the table.
pub fn cases(rows: &[&Row], laws: &[LawName], best_first: &[LawName]) -> Table {
    let robot = rows.first().map(|row| row.actuator);
    let robot = robot.filter(|robot| rows.iter().all(|row| row.actuator == *robot));
    let speed = rows.first().map(|row| row.speed_mm_s);
    let speed = speed.filter(|speed| rows.iter().all(|row| row.speed_mm_s == *speed));
    let mut columns = vec![Column::text("case")];
    columns.extend(robot.is_none().then(|| Column::text("robot")));
    columns.extend(speed.is_none().then(|| Column::number("speed", "mm/s")));
    columns.extend([Column::number("ideal", ""), Column::number("at least", "")]);
    columns.extend(best_first.iter().map(|law| Column::number(law.name(), "")));
    let mut table = Table::new(columns);
    for group in groups(rows, laws) {
        let row = group[0];
        let fixed = |value| Cell::formatted(value, Format::Fixed(3));
        let least = row.limits.map(|limits| limits.least_restitution);
        let mut cells = vec![Cell::text(&row.case)];
        cells.extend(robot.is_none().then(|| Cell::text(row.actuator)));
        cells.extend(speed.is_none().then(|| Cell::number(row.speed_mm_s, 3)));
        cells.push(fixed(row.expected_restitution));
        cells.push(least.map_or_else(|| Cell::text(""), fixed));
        let of = |law: &LawName| group.iter().find(|row| row.law == *law);
        cells.extend(best_first.iter().filter_map(of).map(|row| restitution(row)));
        table.push(cells);
    }
    let robot = robot.map(|robot| format!("robot: {robot}"));
    let speed = speed.map(|speed| format!("{speed} mm/s"));
    let below: Vec<String> = robot
        .into_iter()
        .chain(speed)
        .chain([STAR.to_owned()])
        .collect();
    table.explained(below.join("; "))
}

/// Mean and standard deviation of cases with random noise, jitter or plants: one line per case, one column per law.
pub fn spread(rows: &[&Row], laws: &[LawName], best_first: &[LawName]) -> Table {
    let drawn = |row: &&&Row| SPREAD.contains(&row.sweep);
    let rows: Vec<&Row> = rows.iter().filter(drawn).copied().collect();
    let columns = best_first.iter().map(|law| Column::number(law.name(), ""));
    let mut table = Table::new(
        std::iter::once(Column::text("case"))
            .chain(columns)
            .collect(),
    );
    for group in groups(&rows, laws) {
        let mut cells = vec![Cell::text(&group[0].case)];
        let of = |law: &LawName| group.iter().find(|row| row.law == *law);
        cells.extend(best_first.iter().filter_map(of).map(|row| {
            let (mean, deviation) = (row.restitution_mean, row.restitution_sd);
            Cell::text(format!("{mean:.3} ± {deviation:.3}"))
        }));
        table.push(cells);
    }
    table
}

/// Limits that hold for every law, case by case, where the theory holds.
pub fn limits(rows: &[Row]) -> Table {
    let mut table = Table::new(vec![
        Column::text("case"),
        Column::number("φ = ω τ", ""),
        Column::number("ideal restitution", ""),
        Column::number("at least", ""),
        Column::number("peak force error at least", ""),
        Column::number("without impulse matching", ""),
    ]);
    let mut seen = Vec::new();
    for row in rows {
        let Some(limits) = row.limits.filter(|_| !seen.contains(&&row.case)) else {
            continue;
        };
        seen.push(&row.case);
        let feasible = limits.least_restitution <= row.expected_restitution;
        let mark = if feasible { Mark::Good } else { Mark::Bad };
        let fixed = |value| Cell::formatted(value, Format::Fixed(3));
        table.push(vec![
            Cell::text(&row.case),
            fixed(limits.phi),
            fixed(row.expected_restitution),
            fixed(limits.least_restitution).marked(mark),
            Cell::percent(limits.least_peak_force_error),
            fixed(limits.without_balance),
        ]);
    }
    table
}

/// Rows of one case and speed, one per law.
fn groups<'a>(rows: &'a [&'a Row], laws: &[LawName]) -> impl Iterator<Item = &'a [&'a Row]> {
    rows.chunks(laws.len().max(1))
}

/// The worst restitution, with a star where the law added momentum.
fn restitution(row: &Row) -> Cell {
    let added = row.impulse_unaccounted.abs() > ADDED;
    let star = if added { "*" } else { "" };
    let text = match row.ending {
        Ending::RanAway => "runs away".to_owned(),
        Ending::NoContact => "no contact".to_owned(),
        Ending::Refused => "refused".to_owned(),
        Ending::ImpactsMissing => "misses".to_owned(),
        Ending::Stuck => format!("{:.3}{star} sticks", row.restitution),
        Ending::Ended => format!("{:.3}{star}", row.restitution),
    };
    let mark = if row.ending == Ending::Refused {
        Mark::Neutral
    } else if row.failed > 0 {
        Mark::Bad
    } else {
        mark_of_error(row.restitution_error().abs())
    };
    Cell::text(text).marked(mark)
}
