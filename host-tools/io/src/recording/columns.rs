//! Recorded quantities as series of numbers, for plots.

use super::Recording;
use super::field::{EachNumber, Number};
use super::schema::fields;
use super::table::changing;
use super::topics::{Row, Topic};
use serde::Serialize;

/// A quantity that each cycle has, with the name of its CSV column.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Column {
    /// Name, with its unit: `wrench_force_x_n`.
    pub name: String,
    /// Unit as printed; `1` if it has none.
    pub unit: &'static str,
    /// Meaning of the quantity.
    pub about: &'static str,
}

impl Recording {
    /// All quantities that are not constant.
    pub fn columns(&self) -> Vec<Column> {
        let described = self.topics().iter().flat_map(|topic| {
            fields(*topic).into_iter().flat_map(move |described| {
                let field = described.field;
                let names = field.columns(&topic.prefix()).into_iter();
                names.map(move |name| Column {
                    name,
                    unit: field.unit.symbol,
                    about: field.about,
                })
            })
        });
        let changing = changing(&self.cycles, &self.truth);
        let changing = described.filter(|column| changing.contains(&column.name));
        changing.collect()
    }

    /// The series of the quantities with these names, in the order of `names`; `None` for an unknown name. A word is given as
    /// its index in the list of the schema.
    pub fn series(&self, names: &[&str]) -> Vec<Option<Vec<f64>>> {
        let topics = self.topics().iter();
        let all: Vec<String> = topics.flat_map(|t| super::text::columns(*t)).collect();
        let place = |name: &&str| all.iter().position(|one| one == name);
        let places: Vec<Option<usize>> = names.iter().map(place).collect();
        let mut found: Vec<Option<Vec<f64>>> = places
            .iter()
            .map(|place| place.map(|_| Vec::with_capacity(self.cycles.len())))
            .collect();
        self.each_row(|row| {
            for (series, place) in found.iter_mut().zip(&places) {
                if let (Some(series), Some(place)) = (series, place) {
                    series.push(row.get(*place).copied().unwrap_or(f64::NAN));
                }
            }
        });
        found
    }

    fn topics(&self) -> &'static [Topic] {
        Topic::all(!self.truth.is_empty())
    }

    /// Calls `each` with the numbers of each cycle, in the order of the columns.
    fn each_row(&self, mut each: impl FnMut(&[f64])) {
        let mut numbers = Numbers::default();
        for (n, cycle) in self.cycles.iter().enumerate() {
            let truth = self.truth.get(n).copied().unwrap_or_default();
            let mut row = Row {
                cycle: *cycle,
                truth,
                ..Row::default()
            };
            numbers.0.clear();
            for topic in self.topics() {
                let Ok(()) = topic.visit(&mut numbers, &mut row);
            }
            each(&numbers.0);
        }
    }
}

/// Collects each number.
#[derive(Default)]
struct Numbers(Vec<f64>);

impl EachNumber for Numbers {
    fn number<T: Number>(&mut self, value: T) {
        self.0.push(value.as_f64());
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use softdock_app::record::CycleRecord;

    #[test]
    fn what_changes_is_listed_and_read_by_its_name() {
        let mut recording = Recording {
            cycles: vec![CycleRecord::default(); 3],
            ..Recording::default()
        };
        for (n, cycle) in recording.cycles.iter_mut().enumerate() {
            cycle.trace.wrench_at_m[2] = n as f64;
        }
        let columns = recording.columns();
        let names: Vec<&str> = columns.iter().map(|c| c.name.as_str()).collect();
        assert_eq!(names, ["wrench_force_z_n"]);
        assert_eq!(columns[0].unit, "N");
        assert_eq!(
            recording.series(&["wrench_force_z_n", "nothing"]),
            [Some(vec![0.0, 1.0, 2.0]), None]
        );
    }
}
