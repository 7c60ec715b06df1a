//! Bars, waterfalls and tables of any data.

use super::{elements, of};
use crate::{Bar, BarChart, Cell, Column, Format, Mark, Table};
use proptest::prelude::*;

#[test]
fn bars_and_waterfalls_show_every_row() {
    let mut bars = BarChart::new(
        "Where the error is",
        "share of the squared error",
        Format::Percent(1),
    );
    bars.bars = vec![
        Bar::new("zero crossing", 0.62),
        Bar::new("free flight", -0.01),
        Bar::new("unknown", f64::NAN),
    ];
    let svg = bars.to_svg().unwrap();
    elements(&svg);
    for text in [
        "zero crossing",
        "62.0 %",
        "free flight",
        "−1.0 %",
        "unknown",
        "n/a",
    ] {
        assert!(svg.contains(text), "{text} is missing");
    }
    let mut fall = BarChart::waterfall("The error falls", "RMS [N]", Format::Significant(3));
    fall.bars = vec![
        Bar::new("as built", 12.0),
        Bar::new("delay", 3.0),
        Bar::new("wrong", 4.5),
    ];
    let svg = fall.to_svg().unwrap();
    assert!(svg.contains("3.00 (−75 %)") && svg.contains("4.50 (+50 %)"));
    assert!(svg.contains("var(--good") && svg.contains("var(--bad"));
    fall.bars.clear();
    assert!(fall.to_svg().unwrap().contains("no data"));
}

#[test]
fn a_second_value_is_drawn_below_the_first_and_said() {
    let names = Some(["unseen data".to_owned(), "data of the fit".to_owned()]);
    let mut fall = BarChart::waterfall("The error falls", "RMS [N]", Format::Significant(3));
    fall.bars = vec![Bar::new("as built", 12.0), Bar::new("delay", 3.0)];
    let rectangles = |fall: &BarChart| of(&elements(&fall.to_svg().unwrap()), "rect");
    let alone = rectangles(&fall);
    fall.bars[0].second = Some(11.0);
    fall.bars[1].second = Some(f64::NAN);
    assert_eq!(rectangles(&fall), alone + 1, "what is no number has no bar");
    fall.names = names.clone();
    let svg = fall.to_svg().unwrap();
    for text in [
        "unseen data",
        "data of the fit",
        "12.0 | 11.0",
        "3.00 (−75 %) | n/a",
    ] {
        assert!(svg.contains(text), "{text} is missing");
    }
    let mut bars = BarChart::new("Gains", "fall of χ²", Format::Fixed(0));
    bars.names = names;
    bars.bars = vec![Bar::new("delay", 1234.4).with_second(-1.0)];
    assert!(bars.to_svg().unwrap().contains("1234"));
}

#[test]
fn page_and_terminal_show_the_same_cells() {
    let mut table = Table::new(vec![
        Column::text("Channel"),
        Column::number("RMS", "mm/s"),
        Column::number("Share", ""),
    ]);
    table.push(vec![
        Cell::text("velocity <z>"),
        Cell::number(-0.000_012_3, 2).marked(Mark::Good),
        Cell::percent(0.5).marked(Mark::Bad),
    ]);
    table.push(vec![Cell::text("pose"), Cell::number(1.0, 3)]);
    table.push(vec![
        Cell::text("a"),
        Cell::text("b"),
        Cell::text("c"),
        Cell::text("surplus"),
    ]);
    let terminal = table.to_string();
    let html = table.to_html();
    elements(&html);
    for shown in ["RMS [mm/s]", "✓ -12e-6", "✗ 50.0 %", "1.00", "surplus"] {
        assert!(
            terminal.contains(shown) && html.contains(shown),
            "{shown} is missing in\n{terminal}\n{html}"
        );
    }
    assert!(terminal.contains("velocity <z>") && html.contains("velocity &lt;z&gt;"));
    let lines: Vec<&str> = terminal.lines().collect();
    assert_eq!(lines.len(), 5, "{terminal}");
    assert!(lines.iter().all(|line| *line == line.trim_end()));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn any_bars_are_drawn_and_well_formed(
        bars in proptest::collection::vec((".*", proptest::num::f64::ANY, proptest::option::of(proptest::num::f64::ANY)), 0..6),
        waterfall in any::<bool>(),
    ) {
        let mut chart = BarChart::new("any", "any", Format::Significant(3));
        let bar = |(label, value, second)| Bar { second, ..Bar::new(label, value) };
        chart.bars = bars.into_iter().map(bar).collect();
        chart.waterfall = waterfall;
        elements(&chart.to_svg().unwrap());
    }

    #[test]
    fn any_table_has_the_same_rows_for_both_readers(texts in proptest::collection::vec(proptest::collection::vec(".*", 1..4), 0..5)) {
        let mut table = Table::new(vec![Column::text("any")]);
        table.rows = texts.iter().map(|row| row.iter().map(Cell::text).collect()).collect();
        prop_assert_eq!(of(&elements(&table.to_html()), "tr"), texts.len() + 1);
        prop_assert_eq!(table.to_string().lines().count(), texts.len() + 2);
    }
}
