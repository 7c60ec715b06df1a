"""Reads a table of softdock with pyarrow, and the same as CSV with pandas; prints what pyarrow found."""

import json
import sys

import pandas
import pyarrow.parquet

table = pyarrow.parquet.read_table(sys.argv[1])
csv = pandas.read_csv(sys.argv[2])
assert list(csv.columns) == table.column_names
for name in table.column_names:
    column = table[name].to_pandas()
    assert (column.isna() == csv[name].isna()).all(), name
    assert (column.dropna() == csv[name].dropna()).all(), name
print(
    json.dumps(
        {
            "rows": table.to_pylist(),
            "types": {field.name: str(field.type) for field in table.schema},
            "metadata": {
                key.decode(): value.decode() for key, value in table.schema.metadata.items()
            },
        }
    )
)
