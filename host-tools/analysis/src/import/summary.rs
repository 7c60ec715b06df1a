//! What an import read: rows, time, and each channel with its range.

use super::turns::{OFF, turned};
use serde::Serialize;
use softdock_app::record::CycleRecord;
use softdock_io::recording::Recording;
use softdock_physics::model::Axis;
use softdock_physics::model::load::pose_of;
use softdock_report::{Cell, Column, Table, number};
use softdock_statistics::sample_time;

/// One recording.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Summary {
    /// Its file.
    pub name: String,
    /// Identity of the recording; of an import the names of its tables.
    pub identity: String,
    /// Number of rows.
    pub rows: usize,
    /// Time from the first to the last, s.
    pub seconds: f64,
    /// Median time from row to row, s.
    pub cycle_s: f64,
    /// Channels that hold something.
    pub channels: Vec<Channel>,
    /// Groups of channels of which every value is zero or missing.
    pub missing: Vec<&'static str>,
}

/// One axis of a group.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Channel {
    /// `wrench fx`.
    pub name: String,
    /// SI unit.
    pub unit: &'static str,
    /// Smallest value.
    pub low: f64,
    /// Largest value.
    pub high: f64,
    /// `measured`, or from what it was made.
    pub from: &'static str,
}

/// Name of a group, units of its linear and angular axes, its values in each cycle.
type Group = (
    &'static str,
    [&'static str; 2],
    fn(&Recording) -> Vec<[f64; 6]>,
);

const GROUPS: [Group; 5] = [
    ("pose", ["m", "rad"], poses),
    ("sent velocity", ["m/s", "rad/s"], |r| {
        r.cycles.iter().map(|c| c.trace.sent_velocity).collect()
    }),
    (EXECUTED, ["m/s", "rad/s"], |r| {
        r.cycles.iter().map(|c| c.trace.executed_velocity).collect()
    }),
    ("model velocity", ["m/s", "rad/s"], |r| {
        r.cycles.iter().map(|c| c.trace.model_velocity).collect()
    }),
    ("wrench", ["N", "N·m"], |r| {
        r.cycles.iter().map(|c| c.inputs.sensor.wrench).collect()
    }),
];

/// Positions and rotation vectors. If all rotation is about one axis, angles with whole turns.
fn poses(recording: &Recording) -> Vec<[f64; 6]> {
    let vector = |c: &CycleRecord| {
        let pose = pose_of(&c.trace.pose);
        let (p, r) = (pose.translation.vector, pose.rotation.scaled_axis());
        [p.x, p.y, p.z, r.x, r.y, r.z]
    };
    let mut values: Vec<[f64; 6]> = recording.cycles.iter().map(vector).collect();
    let (axis, angles) = turned(&recording.cycles, recording.header.whole_turns);
    let alone = |value: &[f64; 6]| (3..6).all(|i| i == axis + 3 || value[i].abs() < OFF);
    if values.iter().all(alone) {
        let both = values.iter_mut().zip(angles);
        both.for_each(|(value, angle)| value[axis + 3] = angle);
    }
    values
}

/// Name of the velocity that may be derived.
pub const EXECUTED: &str = "executed velocity";

impl Summary {
    /// Summary of a recording. `derived`: groups that were computed, and from what.
    pub fn of(name: &str, recording: &Recording, derived: &[(&'static str, &'static str)]) -> Self {
        let times: Vec<f64> = recording.cycles.iter().map(|c| c.trace.time_s).collect();
        let (mut channels, mut missing) = (Vec::new(), Vec::new());
        for (group, units, axes) in GROUPS {
            let from = derived.iter().find(|(name, _)| *name == group);
            let before = channels.len();
            let rows = axes(recording);
            for axis in Axis::ALL {
                let values = rows.iter().map(|row| row[axis.index()]);
                let (low, high) = values
                    .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| {
                        (low.min(v), high.max(v))
                    });
                // An axis that is not measured is zero, or NaN where a whole sensor is missing.
                if high > low || (low.is_finite() && low != 0.0) {
                    channels.push(Channel {
                        name: format!("{group} {axis}"),
                        unit: units[usize::from(axis.is_rotation())],
                        low,
                        high,
                        from: from.map_or("measured", |(_, from)| *from),
                    });
                }
            }
            if channels.len() == before {
                missing.push(group);
            }
        }
        Self {
            name: name.to_owned(),
            identity: recording.header.identity.clone(),
            rows: times.len(),
            seconds: times.last().unwrap_or(&0.0) - times.first().unwrap_or(&0.0),
            cycle_s: sample_time(times.iter().copied()).unwrap_or(0.0),
            channels,
            missing,
        }
    }

    /// For the terminal.
    pub fn text(&self) -> String {
        let mut table = Table::new(vec![
            Column::text("Channel"),
            Column::text("Unit"),
            Column::number("From", ""),
            Column::number("To", ""),
            Column::text("Origin"),
        ]);
        for channel in &self.channels {
            table.push(vec![
                Cell::text(&channel.name),
                Cell::text(channel.unit),
                Cell::number(channel.low, 4),
                Cell::number(channel.high, 4),
                Cell::text(channel.from),
            ]);
        }
        let missing = match self.missing.as_slice() {
            [] => String::new(),
            missing => format!(
                "Not in the log, or zero throughout: {}.\n",
                missing.join(", ")
            ),
        };
        let identity = match self.identity.as_str() {
            "" => String::new(),
            identity => format!(", {identity}"),
        };
        format!(
            "{}: {} rows, {} s, a cycle of {} s{identity}\n{table}\n{missing}",
            self.name,
            self.rows,
            number::significant(self.seconds, 4),
            number::significant(self.cycle_s, 4)
        )
    }
}
