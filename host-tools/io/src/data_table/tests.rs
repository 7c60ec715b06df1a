use super::{DataColumn, DataTable};
use proptest::prelude::*;

fn column<T>(name: &str, values: Vec<T>) -> DataColumn
where
    Vec<T>: Into<super::Values>,
{
    DataColumn::new(name, "1", "", values)
}

fn table(rows: usize) -> DataTable {
    let count = |row: usize| row as u64;
    let third = |row: &usize| row.is_multiple_of(3);
    let all = || 0..rows;
    DataTable {
        columns: vec![
            column("index", all().map(count).collect::<Vec<u64>>()),
            DataColumn::new(
                "force_n",
                "N",
                "largest, of all impacts",
                all()
                    .map(|row| (!third(&row)).then_some(row as f64 / 7.0))
                    .collect::<Vec<_>>(),
            ),
            column(
                "captured",
                all().map(|row| Some(third(&row))).collect::<Vec<_>>(),
            ),
            column(
                "why",
                all()
                    .map(|row| third(&row).then(|| "late, \"twice\"\n".to_owned()))
                    .collect::<Vec<_>>(),
            ),
        ],
        metadata: vec![("plan".into(), "[factor]\nµ = 0.3".into())],
    }
}

/// The table after it was written to a file and read back.
fn read_again(table: &DataTable) -> DataTable {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("table.parquet");
    table.write(&path).unwrap();
    DataTable::read_parquet(&path).unwrap()
}

proptest! {
    #[test]
    fn every_number_comes_back_bit_by_bit(
        numbers in prop::collection::vec(prop::option::of(any::<u64>().prop_map(f64::from_bits)), 0..50),
    ) {
        let table = DataTable { columns: vec![column("x", numbers)], metadata: vec![] };
        let bits = |table: &DataTable| match &table.columns[0].values {
            super::Values::Number(values) => values.iter().map(|v| v.map(f64::to_bits)).collect::<Vec<_>>(),
            other => panic!("{other:?}"),
        };
        prop_assert_eq!(bits(&read_again(&table)), bits(&table));
    }
}

#[test]
fn tables_of_any_length_come_back() {
    for rows in [0, 1, 100, 65_536, 65_537, 140_000] {
        assert!(read_again(&table(rows)) == table(rows), "{rows} rows");
    }
}

#[test]
fn the_same_table_is_the_same_file() {
    assert_eq!(
        table(70_000).to_parquet().unwrap(),
        table(70_000).to_parquet().unwrap()
    );
    assert_ne!(
        table(3).to_parquet().unwrap(),
        table(4).to_parquet().unwrap()
    );
}

#[test]
fn as_csv_it_has_a_description_beside_it() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("table.csv");
    table(3).write(&path).unwrap();
    let text = std::fs::read_to_string(&path).unwrap();
    let expected = "index,force_n,captured,why\n\
                    0,,true,\"late, \"\"twice\"\"\n\"\n\
                    1,0.14285714285714285,false,\n\
                    2,0.2857142857142857,false,\n";
    assert_eq!(text, expected);
    let json = std::fs::read_to_string(path.with_extension("json")).unwrap();
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!(json["columns"][1]["unit"], "N");
    assert_eq!(json["columns"][1]["type"], "float64");
    assert_eq!(json["metadata"]["plan"], "[factor]\nµ = 0.3");
}

#[test]
fn what_is_no_table_is_refused() {
    let refused = |columns: Vec<DataColumn>| {
        let metadata = Vec::new();
        let error = DataTable { columns, metadata }.to_parquet().unwrap_err();
        error.to_string()
    };
    let twice = refused(vec![column("a", vec![1.0]), column("a", vec![2.0])]);
    assert!(twice.contains("`a` stands twice"), "{twice}");
    let ragged = refused(vec![column("a", vec![1.0]), column("b", vec![1.0, 2.0])]);
    assert!(ragged.contains("2 rows, expected 1"), "{ragged}");

    let folder = tempfile::tempdir().unwrap();
    let error = table(1).write(&folder.path().join("table.xlsx"));
    let error = error.unwrap_err().to_string();
    assert!(error.contains(".parquet or .csv"), "{error}");
}

#[test]
fn a_file_cut_off_anywhere_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("table.parquet");
    let whole = table(20).to_parquet().unwrap();
    for length in 0..whole.len() {
        std::fs::write(&path, &whole[..length]).unwrap();
        let error = DataTable::read_parquet(&path).unwrap_err();
        assert!(
            error.to_string().contains("is not a whole table"),
            "{error}"
        );
    }
}

/// A decoder would read wrong values from a damaged file, or panic.
#[test]
fn a_bit_that_flips_is_noticed_or_changes_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("table.parquet");
    let whole = table(20).to_parquet().unwrap();
    for place in 0..whole.len() {
        let mut damaged = whole.clone();
        damaged[place] ^= 1 << (place % 8);
        std::fs::write(&path, &damaged).unwrap();
        if let Ok(read) = DataTable::read_parquet(&path) {
            assert!(read == table(20), "byte {place} of {}", whole.len());
        }
    }
}

#[test]
fn another_column_than_there_is_names_those_there_are() {
    let error = table(1).values("forces").unwrap_err().to_string();
    assert!(error.contains("index, force_n, captured, why"), "{error}");
}
