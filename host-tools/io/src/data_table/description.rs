//! Units and meanings of a table's columns.

use super::{DataColumn, Values};
use anyhow::{Result, bail};
use serde::{Deserialize, Serialize};

/// Description of a column, as it is stored beside the values of any table that softdock writes.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Description {
    /// Name of the column.
    pub name: String,
    /// Unit as printed, `1` for none.
    pub unit: String,
    /// Type of the values, by its name in ROS 2.
    #[serde(rename = "type")]
    pub kind: String,
    /// The words that the column may contain; empty unless it holds words.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub words: Vec<String>,
    /// Meaning of the column.
    pub meaning: String,
}

impl Description {
    pub(super) fn of(column: &DataColumn) -> Self {
        let kind = match column.values {
            Values::Number(_) => "float64",
            Values::Count(_) => "uint64",
            Values::Flag(_) => "bool",
            Values::Text(_) => "string",
        };
        Self {
            name: column.name.clone(),
            unit: column.unit.clone(),
            kind: kind.to_owned(),
            words: Vec::new(),
            meaning: column.meaning.clone(),
        }
    }

    /// An empty column of this description. An error if the type is unknown.
    pub(super) fn column(&self) -> Result<DataColumn> {
        let Self { name, kind, .. } = self;
        let values = match kind.as_str() {
            "float64" => Values::Number(Vec::new()),
            "uint64" => Values::Count(Vec::new()),
            "bool" => Values::Flag(Vec::new()),
            "string" => Values::Text(Vec::new()),
            other => {
                bail!("column `{name}` holds `{other}`; expected float64, uint64, bool or string")
            }
        };
        Ok(DataColumn {
            name: name.clone(),
            unit: self.unit.clone(),
            meaning: self.meaning.clone(),
            values,
        })
    }
}
