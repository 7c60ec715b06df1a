//! Names of the columns and of the metadata of a table of rows.

use super::outcome::NUMBERS;

/// Name of the column with the index.
pub const INDEX: &str = "index";
/// Name of the column that says whether a run is a success.
pub const SUCCESS: &str = "success";
/// Metadata key of the plan's hash.
pub const PLAN: &str = "softdock.plan";
/// Metadata key of the program.
pub const BINARY: &str = "softdock.binary";

/// Columns beside factors and numeric outcomes.
const OTHERS: [&str; 13] = [
    INDEX,
    "seed",
    "status",
    "reason",
    SUCCESS,
    "captured",
    "impacts",
    "cycles",
    "fault",
    "final_mode",
    "hidden",
    "said",
    "right",
];

/// Column names that no factor may have.
pub(super) fn own_columns() -> impl Iterator<Item = &'static str> {
    OTHERS
        .into_iter()
        .chain(NUMBERS.iter().map(|number| number.name))
}
