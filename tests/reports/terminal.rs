//! Tables on a terminal.

use softdock_report::{Cell, Column, Table};

#[test]
fn a_table_fits_the_terminal_and_loses_no_word() {
    let meaning = "cycles without a fresh sample after which the sensor counts as stale";
    let columns = [
        Column::text("Name"),
        Column::number("Value", "s"),
        Column::text("Meaning"),
    ];
    let mut table = Table::new(columns.to_vec());
    table.push(vec![
        Cell::text("control.sensor.stale_after_cycles"),
        Cell::number(3.0, 1),
        Cell::text(meaning),
    ]);
    let wide = table.to_string();
    assert!(wide.lines().any(|line| line.chars().count() > 80), "{wide}");
    assert_eq!(table.fitted(200), wide);
    let fitted = table.fitted(70);
    assert!(
        fitted.lines().all(|line| line.chars().count() <= 70),
        "{fitted}"
    );
    for word in meaning.split(' ') {
        assert!(fitted.contains(word), "`{word}`:\n{fitted}");
    }
}
