//! All parts of a campaign as one table, row by row.

use super::place::Place;
use super::plan::Plan;
use super::shard::Shard;
use super::status::{indices, parts};
use anyhow::{Result, bail, ensure};
use softdock_io::data_table::{DataColumn, DataTable, Values};
use softdock_io::shell::quoted;

/// Merges the parts of a campaign. The table does not depend on how the rows were divided.
///
/// # Errors
/// A row is missing or is in two parts, or a part is of another plan or program.
pub fn merge(plan: &Plan, place: &Place) -> Result<DataTable> {
    let parts = parts(plan, place)?;
    let order = order(plan, place, &parts)?;
    let Some((_, first)) = parts.first() else {
        bail!(
            "{place} has no parts; `softdock campaign run {}` makes them",
            quoted(place)
        );
    };
    let columns = first.columns.iter().enumerate().map(|(number, column)| {
        let same = |(_, part): &(Shard, DataTable)| {
            part.columns
                .get(number)
                .is_some_and(|other| other.name == column.name)
        };
        ensure!(
            parts.iter().all(same),
            "the parts have different columns at `{}`",
            column.name
        );
        let values: Vec<&Values> = parts
            .iter()
            .map(|(_, part)| &part.columns[number].values)
            .collect();
        Ok(DataColumn {
            values: gathered(&values, &order)?,
            ..column.clone()
        })
    });
    Ok(DataTable {
        columns: columns.collect::<Result<_>>()?,
        metadata: first.metadata.clone(),
    })
}

/// For each row of the campaign, the number of its part and its row in that part.
fn order(plan: &Plan, place: &Place, parts: &[(Shard, DataTable)]) -> Result<Vec<(usize, usize)>> {
    let mut order: Vec<Option<(usize, usize)>> = vec![None; plan.rows() as usize];
    for (number, (shard, part)) in parts.iter().enumerate() {
        for (row, index) in indices(part)?.into_iter().enumerate() {
            let rows = plan.rows();
            let Some(slot) = order.get_mut(index as usize) else {
                bail!("part {shard} has row {index}; the plan has {rows} rows");
            };
            if let Some((other, _)) = slot.replace((number, row)) {
                bail!(
                    "row {index} stands in part {} and in part {shard}: move the parts of one division away",
                    parts[other].0
                );
            }
        }
    }
    let missing = order.iter().filter(|slot| slot.is_none()).count();
    if missing > 0 {
        let first = order.iter().position(Option::is_none).unwrap_or_default();
        bail!(
            "{missing} of {} rows are missing, the first is row {first}; `softdock campaign status {}` names their shards",
            plan.rows(),
            quoted(place)
        );
    }
    Ok(order.into_iter().flatten().collect())
}

/// Values of one column, in the order of the campaign's rows.
fn gathered(parts: &[&Values], order: &[(usize, usize)]) -> Result<Values> {
    macro_rules! gather {
        ($variant:ident) => {{
            let value = |&(part, place): &(usize, usize)| match parts.get(part)? {
                Values::$variant(values) => values.get(place).cloned(),
                _ => None,
            };
            order
                .iter()
                .map(value)
                .collect::<Option<Vec<_>>>()
                .map(Values::$variant)
        }};
    }
    let gathered = match parts.first() {
        Some(Values::Number(_)) => gather!(Number),
        Some(Values::Count(_)) => gather!(Count),
        Some(Values::Flag(_)) => gather!(Flag),
        Some(Values::Text(_)) => gather!(Text),
        None => None,
    };
    match gathered {
        Some(values) => Ok(values),
        None => bail!("the parts hold different kinds of values in one column"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Otherwise values of the next part could be taken for those of this one.
    #[test]
    fn a_part_of_another_kind_is_refused() {
        let numbers = |values: &[f64]| Values::Number(values.iter().copied().map(Some).collect());
        let (one, two) = (numbers(&[1.0]), numbers(&[2.0, 3.0]));
        let words = Values::Text(vec![None]);
        let merged = gathered(&[&one, &two], &[(1, 1), (0, 0)]).unwrap();
        assert_eq!(merged, numbers(&[3.0, 1.0]));
        assert!(gathered(&[&one, &words, &two], &[(0, 0), (1, 0)]).is_err());
    }
}
