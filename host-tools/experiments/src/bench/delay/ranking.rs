//! Which law is best: one line per law, the best first.

use super::marks::{ADDED, BAD, HEADLINE, MARKS, mark_of_error, mark_of_momentum};
use super::measure::Ending;
use super::row::Row;
use softdock_control::delay::LawName;
use softdock_report::{Cell, Column, Format, Table};

/// A law over all rows that were asked for.
#[derive(Clone, Copy, Debug)]
pub struct Standing<'a> {
    /// The law.
    pub law: LawName,
    /// Number of right rows (see `is_right`), among those that the law did not refuse.
    pub right: usize,
    /// Number of rows that the law did not refuse.
    pub of: usize,
    /// Rows with a run that ran away, stuck, or missed an impact.
    pub failed: usize,
    /// The row with the largest error of the restitution.
    pub worst: Option<&'a Row>,
    /// Largest share of the rebound's momentum that no measured force accounts for.
    pub added: f64,
}

impl<'a> Standing<'a> {
    fn of(law: LawName, rows: &[&'a Row]) -> Self {
        let mine = || {
            let of_law = rows.iter().copied().filter(move |row| row.law == law);
            of_law.filter(|row| row.ending != Ending::Refused)
        };
        let by_error = |a: &&Row, b: &&Row| a.error().total_cmp(&b.error());
        let momentum = mine().map(|row| row.impulse_unaccounted.abs());
        Self {
            law,
            right: mine().filter(|row| is_right(row)).count(),
            of: mine().count(),
            failed: mine().filter(|row| row.failed > 0).count(),
            worst: mine().max_by(by_error),
            added: momentum.fold(0.0, f64::max),
        }
    }

    fn wrong_share(&self) -> f64 {
        1.0 - self.right as f64 / self.of.max(1) as f64
    }

    fn error(&self) -> f64 {
        self.worst.map_or(0.0, Row::error)
    }

    /// `right` of `of`, in words.
    fn right_of(&self) -> String {
        format!("{} of {}", self.right, self.of)
    }
}

/// Whether the rebound is near the ideal one, and measured force accounts for its momentum.
fn is_right(row: &Row) -> bool {
    row.failed == 0 && row.error() <= BAD && row.impulse_unaccounted.abs() <= ADDED
}

/// The laws, the best first: ordered by the share of rows that are not right, then by the error.
pub fn standings<'a>(rows: &[&'a Row], laws: &[LawName]) -> Vec<Standing<'a>> {
    let mut all: Vec<Standing<'_>> = laws.iter().map(|law| Standing::of(*law, rows)).collect();
    all.sort_by(|a, b| {
        let share = a.wrong_share().total_cmp(&b.wrong_share());
        share.then(a.error().total_cmp(&b.error()))
    });
    all
}

/// The ranking in a sentence.
pub fn sentence(standings: &[Standing<'_>]) -> String {
    let right = format!(
        "within {:.0} % of the ideal rebound, and at most {:.0} % of its momentum is not from measured force",
        100.0 * BAD,
        100.0 * ADDED
    );
    match standings {
        [] => "No law was asked for.".to_owned(),
        [only] => format!(
            "{} is right in {} rows: {right}; off by {:.2} % at most.",
            only.law.name(),
            only.right_of(),
            100.0 * only.error()
        ),
        [best, next, ..] => format!(
            "{} is best: right in {} rows ({right}), off by {:.2} % at most. Next is {}, right in {}.",
            best.law.name(),
            best.right_of(),
            100.0 * best.error(),
            next.law.name(),
            next.right_of()
        ),
    }
}

/// One line per law, the best first.
pub fn table(standings: &[Standing<'_>]) -> Table {
    let mut table = Table::new(vec![
        Column::text("law"),
        Column::number("right", ""),
        Column::number("restitution off by", ""),
        Column::text("worst on"),
        Column::number("momentum not measured", ""),
        Column::number("failed", ""),
    ]);
    for standing in standings {
        table.push(vec![
            Cell::text(standing.law.name()),
            Cell::text(standing.right_of()),
            Cell::formatted(standing.error(), Format::Percent(2))
                .marked(mark_of_error(standing.error())),
            Cell::text(standing.worst.map_or(String::new(), place)),
            Cell::formatted(standing.added, Format::Percent(1))
                .marked(mark_of_momentum(standing.added)),
            Cell::text(standing.failed.to_string()),
        ]);
    }
    table.explained(MARKS)
}

/// Name of a row's case; for the headline, where everything is known, the robot.
fn place(row: &Row) -> String {
    let case = if row.sweep == HEADLINE {
        row.actuator
    } else {
        &row.case
    };
    format!("{case}, {} mm/s", row.speed_mm_s)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bench::delay::{cases, run::run};

    #[test]
    fn the_best_law_stands_first_and_in_the_sentence() {
        let mut cases = cases::quick();
        cases.retain(|case| case.is_called(HEADLINE));
        cases.truncate(2);
        let laws = [LawName::None, LawName::Predictor];
        let rows = run(&cases, &laws, 1, &|| ()).unwrap();
        let rows: Vec<&Row> = rows.iter().collect();
        let standings = standings(&rows, &laws);
        let order: Vec<LawName> = standings.iter().map(|standing| standing.law).collect();
        assert_eq!(order, [LawName::Predictor, LawName::None]);
        assert_eq!(standings[0].right, standings[0].of);
        let told = sentence(&standings);
        assert!(told.starts_with("predictor is best: right in "), "{told}");
        assert!(told.contains("Next is none, right in 0 of "), "{told}");
    }
}
