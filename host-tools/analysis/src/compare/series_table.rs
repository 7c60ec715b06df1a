//! The curves of a comparison as numbers: what was measured, what was predicted, their difference and its noise.

use super::{ChannelPrediction, Comparison};
use anyhow::{Result, bail};
use serde::Serialize;
use softdock_io::data_table::{DataColumn, DataTable, Values};
use softdock_io::recording::Recording;
use softdock_physics::model::{Axis, Channel};
use std::path::Path;

/// A file of series that was written.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct SeriesFile {
    /// Its path.
    pub file: String,
    /// Rows: cycles of the recording.
    pub rows: usize,
    /// Names of its columns.
    pub columns: Vec<String>,
}

impl Comparison {
    /// Table with a row for each cycle: time, then measured, predicted, residual and sigma of each axis of each channel. Sigma is
    /// the expected noise of the residual. Values that could not be predicted are empty.
    pub fn series_table(&self) -> DataTable {
        let prediction = &self.detail.prediction;
        let time = prediction.time_s.clone();
        let time = DataColumn::new(
            "time_s",
            "s",
            "time of the cycle, as in the recording",
            time,
        );
        let mut columns = vec![time];
        for channel in Channel::ALL {
            for axis in Axis::ALL {
                columns.extend(of_axis(prediction.channel(channel), axis));
            }
        }
        let metadata = vec![
            ("made_by".to_owned(), softdock_io::identity::text()),
            ("recorded_by".to_owned(), self.detail.identity.clone()),
            ("where".to_owned(), self.sentence.clone()),
        ];
        DataTable { columns, metadata }
    }

    /// Writes [`Self::series_table`] as CSV, Parquet or MCAP, by the ending of `path`. MCAP has the compared recording beside it,
    /// as [`Recording::write_ros2`] writes it.
    ///
    /// # Errors
    /// Another ending, or a file that cannot be written.
    pub fn write_series(&self, recording: &Recording, path: &Path) -> Result<SeriesFile> {
        let table = self.series_table();
        match path.extension().and_then(|ending| ending.to_str()) {
            Some("csv" | "parquet") => table.write(path)?,
            Some("mcap") => recording.write_ros2(Some(&table), path)?,
            _ => bail!(
                "{}: series are written as .csv, .parquet or .mcap; choose one of these endings",
                path.display()
            ),
        }
        Ok(SeriesFile {
            file: path.display().to_string(),
            rows: table.rows(),
            columns: table.columns.into_iter().map(|c| c.name).collect(),
        })
    }
}

fn of_axis(values: &ChannelPrediction, axis: Axis) -> [DataColumn; 4] {
    let (channel, unit) = (values.channel, values.channel.unit(axis));
    let suffix = unit.replace(['/', '·'], "_").to_lowercase();
    let column = |what: &str, meaning: &str, value: &dyn Fn(usize) -> Option<f64>| {
        let numbers = (0..values.measured.len()).map(|n| value(n).filter(|v| v.is_finite()));
        let numbers: Vec<Option<f64>> = numbers.collect();
        let name = format!("{channel}_{axis}_{what}_{suffix}");
        DataColumn::new(name, unit, meaning, Values::from(numbers))
    };
    let i = axis.index();
    [
        column("measured", "what was recorded", &|n| {
            Some(values.measured[n][i])
        }),
        column("predicted", "what the model says", &|n| {
            values.predicted.get(n).copied().flatten().map(|six| six[i])
        }),
        column("residual", "measured minus predicted", &|n| {
            values.residual(n, axis)
        }),
        column(
            "sigma",
            "noise to expect of the residual, one sigma",
            &|n| Some(values.expected_sigma(n, axis)),
        ),
    ]
}
