//! Rows that are looked at apart: with and without the delay law, for instance.

use super::results::Results;
use anyhow::Result;
use softdock_io::data_table::Values;

/// Rows that belong together.
#[derive(Clone, Debug)]
pub(super) struct Split {
    /// What they have in common: a word; empty if these are all rows.
    pub(super) name: String,
    /// Whether each row belongs to it.
    pub(super) rows: Vec<bool>,
}

/// The rows by the words of the first factor that has words, or all of them.
pub(super) fn splits(results: &Results<'_>) -> Result<Vec<Split>> {
    for factor in &results.plan.factors {
        let Values::Text(words) = results.table.values(&factor.name)? else {
            continue;
        };
        let mut known: Vec<&String> = words.iter().flatten().collect();
        known.sort();
        known.dedup();
        let split = |word: &String| Split {
            name: word.clone(),
            rows: words.iter().map(|own| own.as_ref() == Some(word)).collect(),
        };
        return Ok(known.into_iter().map(split).collect());
    }
    Ok(vec![Split {
        name: String::new(),
        rows: vec![true; results.table.rows()],
    }])
}
