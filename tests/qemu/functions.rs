//! What micromath costs beside libm, on both processors: it is for numbers that people look at, its root is
//! up to 6 % off (`softdock_app::meter`).

use softdock_lockstep::{FUNCTIONS, LIBRARIES};
use softdock_report::{Cell, Column, Format, Table};
use softdock_rig::board::qemu::Chip;
use softdock_rig::firmware::{RELEASED, emulated_profile};
use softdock_tests::lockstep::function_costs;

#[test]
#[ignore = "long: counted with the real profile"]
fn micromath_costs_less_than_libm() {
    assert_eq!(emulated_profile(), RELEASED, "instructions that ship");
    for (test, chip, name) in [
        ("functions_m7", Chip::An500, "Cortex-M7"),
        ("functions_m3", Chip::An385, "Cortex-M3"),
    ] {
        let costs = function_costs(test, chip);
        let columns = LIBRARIES.map(|library| Column::number(library, "instructions"));
        let mut table = Table::new([Column::text(name)].into_iter().chain(columns).collect());
        for (function, row) in FUNCTIONS.iter().zip(&costs) {
            let cells = row.map(|count| Cell::formatted(count, Format::Fixed(0)));
            table.push([Cell::text(*function)].into_iter().chain(cells).collect());
        }
        println!("{table}");
        for (function, [micro, _, cycle]) in FUNCTIONS.iter().zip(costs) {
            assert!(micro > 1.0, "{name}, {function}: {micro} is not counted");
            assert!(micro < cycle, "{name}, {function}: {micro}, libm {cycle}");
        }
    }
}
