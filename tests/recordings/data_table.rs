//! Tables for other programs, read by pyarrow and pandas.

use serde_json::{Value, json};
use softdock_io::data_table::{DataColumn, DataTable};
use softdock_tests::peers::python;

#[test]
fn pyarrow_and_pandas_read_what_was_written() {
    let numbers = vec![Some(0.1), None, Some(-1.5e-300)];
    let counts: Vec<u64> = vec![0, u64::from(u32::MAX) + 1, u64::MAX];
    let words = vec![Some("no robot, \"late\"".to_owned()), None, None];
    let table = DataTable {
        columns: vec![
            DataColumn::new("index", "1", "of the row", counts),
            DataColumn::new("peak_force_n", "N", "of all impacts", numbers),
            DataColumn::new("captured", "1", "", vec![Some(true), Some(false), None]),
            DataColumn::new("reason", "1", "", words),
        ],
        metadata: vec![("softdock".into(), "ü".into())],
    };
    let read = python::read_table(&table);
    let row = |index: u64, force: Value, captured: Value, reason: Value| json!({ "index": index, "peak_force_n": force, "captured": captured, "reason": reason });
    let expected = [
        row(0, 0.1.into(), true.into(), "no robot, \"late\"".into()),
        row(1 << 32, Value::Null, false.into(), Value::Null),
        row(u64::MAX, (-1.5e-300).into(), Value::Null, Value::Null),
    ];
    assert_eq!(read["rows"], json!(expected));
    let types = json!({ "index": "uint64", "peak_force_n": "double", "captured": "bool", "reason": "string" });
    assert_eq!(read["types"], types);
    assert_eq!(read["metadata"]["softdock"], "ü");
    let columns = read["metadata"]["softdock.columns"].as_str().unwrap();
    let columns: Value = serde_json::from_str(columns).unwrap();
    assert_eq!(columns[1]["unit"], "N");
}
