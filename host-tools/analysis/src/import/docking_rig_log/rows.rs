//! The rows of a docking-rig-log/1 log as cycles.

use crate::import::table::{Dialect, Table};
use softdock_app::record::CycleRecord;
use softdock_control::modes::Mode;
use softdock_io::recording::{Header, Recording};

/// Columns in the order in which they are read.
const COLUMNS: [&str; 33] = [
    "t", "mode", "fx", "fy", "fz", "tx", "ty", "tz", "vcx", "vcy", "vcz", "wcx", "wcy", "wcz",
    "vex", "vey", "vez", "wex", "wey", "wez", "px", "py", "pz", "qw", "qx", "qy", "qz", "vmx",
    "vmy", "vmz", "wmx", "wmy", "wmz",
];

/// Reads a log; `file` stands for it in errors.
///
/// # Errors
///
/// A column that is missing, a cell that is no number, a row that is too short or too long.
pub(super) fn rows(file: &str, text: &str, sample_time_s: f64) -> anyhow::Result<Recording> {
    let table = Table::read(file, text, &Dialect::default())?;
    let columns = table
        .column_indices(&COLUMNS)?
        .into_iter()
        .map(|place| table.numbers(place))
        .collect::<Result<Vec<_>, _>>()?;
    let mut cycles: Vec<CycleRecord> = (0..table.len()).map(|n| cycle(n, &columns)).collect();
    nominal_times(&mut cycles, sample_time_s);
    Ok(Recording {
        header: Header::default(),
        cycles,
        ..Recording::default()
    })
}

fn cycle(n: usize, columns: &[Vec<f64>]) -> CycleRecord {
    // The columns are read in the order of COLUMNS, all of the same length.
    let number = |i: usize| columns.get(i).and_then(|c| c.get(n)).copied();
    let from = |first: usize| move |i: usize| number(first + i).unwrap_or(f64::NAN);
    let mut cycle = CycleRecord::default();
    cycle.inputs.sensor.wrench = std::array::from_fn(from(2));
    let trace = &mut cycle.trace;
    trace.cycle = n as u64;
    trace.time_s = from(0)(0);
    trace.mode = if from(1)(0) == 0.0 {
        Mode::Hold
    } else {
        Mode::Running
    };
    trace.sent_velocity = std::array::from_fn(from(8));
    trace.executed_velocity = std::array::from_fn(from(14));
    trace.pose = std::array::from_fn(from(20));
    trace.model_velocity = std::array::from_fn(from(27));
    cycle
}

/// Printed times are rounded. If all of them are within half a sample of the tick count times the sample time, these exact
/// products replace them.
fn nominal_times(cycles: &mut [CycleRecord], sample_time_s: f64) {
    let first = cycles.first().map_or(0.0, |c| c.trace.time_s);
    let nominal = |n: usize| first + n as f64 * sample_time_s;
    let rounded = cycles
        .iter()
        .enumerate()
        .all(|(n, c)| (c.trace.time_s - nominal(n)).abs() < 0.5 * sample_time_s);
    if rounded {
        for (n, cycle) in cycles.iter_mut().enumerate() {
            cycle.trace.time_s = nominal(n);
        }
    }
}
