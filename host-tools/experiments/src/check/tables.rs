//! The result of the check as text.

use super::{Check, LawRow};
use softdock_report::{Cell, Column, Table};
use std::fmt::{self, Display, Formatter};

impl Display for Check {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}\n", self.sentence())?;
        writeln!(f, "{}\n", self.contact_table())?;
        writeln!(f, "{}\n", self.law_table())?;
        for advice in &self.advice {
            writeln!(f, "- {advice}")?;
        }
        Ok(())
    }
}

impl Check {
    /// The result of the chosen law in a sentence.
    pub fn sentence(&self) -> String {
        let Some(row) = self.chosen() else {
            return String::new();
        };
        let stable = if row.stable { "stable" } else { "NOT STABLE" };
        let rebound = match row.expected_restitution {
            Some(e) if row.flies_on => format!(
                "the spacecraft is let go while it still flies towards the wall ({e:.3} of the approach, {:.3} is right)",
                self.ideal_restitution
            ),
            Some(e) => format!(
                "rebound {e:.3} of the approach, {:.3} is right",
                self.ideal_restitution
            ),
            None => "the spacecraft does not come back".into(),
        };
        format!("Law `{}` on this contact: {stable}, {rebound}.", row.law)
    }

    fn contact_table(&self) -> Table {
        let columns = vec![
            Column::text("contact"),
            Column::number("here", ""),
            Column::number("critical without compensation", ""),
        ];
        let mut table = Table::new(columns);
        let mut row = |name: &str, here: f64, critical: Option<f64>| {
            let critical = critical.map_or_else(|| Cell::text("none"), |v| Cell::number(v, 4));
            table.push(vec![Cell::text(name), Cell::number(here, 4), critical]);
        };
        row(
            "loop delay, ms",
            1e3 * self.delay_s,
            Some(1e3 * self.critical_delay_s),
        );
        row(
            "stiffness, N/m",
            self.stiffness_n_per_m,
            self.critical_stiffness_n_per_m,
        );
        row("mass, kg", self.effective_mass_kg, self.critical_mass_kg);
        row(
            "damping, N·s/m",
            self.damping_n_s_per_m,
            self.critical_damping_n_s_per_m,
        );
        row(
            "phase of the delay, φ",
            self.limits.phi,
            Some(std::f64::consts::SQRT_2),
        );
        table
    }

    fn law_table(&self) -> Table {
        let mut table = Table::new(vec![
            Column::text("law"),
            Column::text("stable"),
            Column::number("rebound", ""),
            Column::number("from … to", ""),
            Column::number("peak force", "%"),
            Column::number("contact time", "%"),
            Column::number("impulse not measured", ""),
        ]);
        for row in &self.laws {
            table.push(cells(row));
        }
        table.explained("* needs position feedback")
    }
}

fn cells(row: &LawRow) -> Vec<Cell> {
    let number = |value: Option<f64>, digits| {
        value.map_or_else(|| Cell::text("none"), |v| Cell::number(v, digits))
    };
    let range = row.range.map_or_else(
        || "none".into(),
        |(low, high)| format!("{low:.3} … {high:.3}"),
    );
    vec![
        Cell::text(if row.needs_position {
            format!("{}*", row.law)
        } else {
            row.law.to_string()
        }),
        Cell::text(match (row.stable, row.flies_on) {
            (true, _) => "yes",
            (false, true) => "no, flies on",
            (false, false) => "no",
        }),
        number(row.expected_restitution, 4),
        Cell::text(range),
        Cell::number(1e2 * row.peak_force_error, 3),
        number(row.contact_time_error.map(|error| 1e2 * error), 3),
        Cell::number(row.impulse_unaccounted, 3),
    ]
}
