//! Parameters of the named effects with their intervals.

use super::Source;
use softdock_analysis::diagnose::Estimate;
use softdock_report::{Cell, Column, Interval, IntervalChart, Page, Table};

/// Significant digits of an interval's width.
const INTERVAL_DIGITS: usize = 2;
/// Significant digits of a value whose interval has no width or no end.
const UNJUSTIFIED_DIGITS: usize = 3;

impl Source<'_> {
    /// The section.
    pub(super) fn parameters(&self, page: &mut Page) -> anyhow::Result<()> {
        let parameters = self.diagnosis.parameters.iter();
        let mut all: Vec<(&String, &String, &Estimate)> = parameters
            .flat_map(|(effect, of_effect)| of_effect.iter().map(move |(n, e)| (effect, n, e)))
            .collect();
        // The most important effect first, as in the sentence.
        let rank = |effect: &String| self.diagnosis.effects.iter().position(|e| e == effect);
        all.sort_by_key(|(effect, ..)| rank(effect).unwrap_or(usize::MAX));
        if all.is_empty() {
            return Ok(());
        }
        page.section("Parameters");
        let mut table = Table::new(vec![
            Column::text("Effect"),
            Column::text("Parameter"),
            Column::number("Value", ""),
            Column::number("95 % interval", ""),
            Column::text("Unit"),
        ]);
        for (effect, name, estimate) in &all {
            table.push(vec![
                Cell::text(effect),
                Cell::text(name),
                Cell::number(estimate.value, digits(estimate)),
                Cell::interval(estimate.low, estimate.high, INTERVAL_DIGITS),
                Cell::text(&estimate.unit),
            ]);
        }
        page.table(&table);
        let intervals = all.iter().map(|(effect, name, estimate)| Interval {
            label: format!("{effect}.{name}"),
            value: estimate.value,
            low: estimate.low,
            high: estimate.high,
        });
        page.intervals(&IntervalChart::new(
            "How well the data determine each parameter (95 % intervals)",
            intervals.collect(),
        ))?;
        Ok(())
    }
}

/// Significant digits of a value that its interval justifies: down to a tenth of the width.
fn digits(estimate: &Estimate) -> usize {
    let orders = (estimate.value.abs() / (estimate.high - estimate.low).abs()).log10();
    if orders.is_finite() {
        (orders.floor() + 3.0).clamp(2.0, 7.0) as usize
    } else {
        UNJUSTIFIED_DIGITS
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_value_has_the_digits_that_its_interval_justifies() {
        let of = |value, low, high| {
            digits(&Estimate {
                value,
                unit: "s".to_owned(),
                low,
                high,
            })
        };
        assert_eq!(of(0.032_14, 0.0319, 0.0324), 4);
        assert_eq!(of(1.0, 0.1, 2.5), 2);
        assert_eq!(of(1.0, 1.0, 1.0), UNJUSTIFIED_DIGITS);
        assert_eq!(of(0.0, -1.0, 1.0), UNJUSTIFIED_DIGITS);
    }
}
