//! Reads the columns that a mapping names.

use super::channels::{Channels, Rotation};
use super::column::{Column, Quantity};
use super::file::{
    Incomplete, Mapping, Mode, Order, Orientation, POSITION_KEYS, ROTATION_KEYS, Span, TWIST_KEYS,
    Turns, WRENCH_KEYS,
};
use super::source::Source;
use super::stamps;
use crate::import::turns::Angles;
use anyhow::{Context, bail, ensure};
use nalgebra::{UnitQuaternion, Vector3};
use softdock_report::number;

/// A rotation vector longer than one turn and a bit is in degrees, rad.
const MORE_THAN_A_TURN_RAD: f64 = 7.0;

/// What the axes of a velocity measure.
const TWIST: [Quantity; 6] = quantities(Quantity::Velocity, Quantity::Rate);
/// What the axes of a wrench measure.
const WRENCH: [Quantity; 6] = quantities(Quantity::Force, Quantity::Torque);

const fn quantities(linear: Quantity, angular: Quantity) -> [Quantity; 6] {
    [linear, linear, linear, angular, angular, angular]
}

/// Reads the columns that the mapping names, in a range of rows.
///
/// # Errors
///
/// A column that does not exist, a cell that is no number, a unit that does not fit, or no
/// time at all.
pub(super) fn read(
    mapping: &Mapping,
    rows: Span,
    mut source: Source,
    warnings: &mut Vec<String>,
) -> anyhow::Result<Channels> {
    let s = &mut source;
    let time_s = select(mapping, rows, s)?;
    let twist =
        |s: &mut Source, section: &str, columns| group(s, section, columns, TWIST_KEYS, TWIST);
    let model_velocity = twist(s, "model_velocity", mapping.model_velocity.columns())?;
    let position = group(
        s,
        "position",
        mapping.position.columns(),
        POSITION_KEYS,
        [Quantity::Length; 3],
    )?;
    let orientation = mapping.orientation.as_ref();
    let orientation = orientation.map(|columns| rotation(columns, s, warnings));
    let mut channels = Channels {
        rows: s.numbers_of_rows().map(|n| n + 1).collect(),
        time_s,
        running: running(&mapping.mode, s, model_velocity.is_some())?,
        position,
        orientation: orientation.transpose()?,
        sent: twist(s, "sent_velocity", mapping.sent_velocity.columns())?,
        executed: twist(s, "executed_velocity", mapping.executed_velocity.columns())?,
        model_velocity,
        wrench: group(s, "wrench", mapping.wrench.columns(), WRENCH_KEYS, WRENCH)?,
    };
    let name = source.name();
    source.finish()?;
    if mapping.rows.incomplete == Incomplete::Interpolate {
        let resamples = mapping.time.resample_hz.is_some();
        stamps::fill_in(&mut channels, resamples, &name, warnings)?;
    }
    channels.leave_incomplete_out(&name, warnings)?;
    warnings.extend(channels.lacks_motion(&name));
    Ok(channels)
}

/// Signals of a group; None if no column of it is mapped.
fn group<const N: usize>(
    source: &mut Source,
    section: &str,
    columns: [Option<&Column>; N],
    keys: [&str; N],
    quantities: [Quantity; N],
) -> anyhow::Result<Option<[Vec<f64>; N]>> {
    if columns.iter().all(Option::is_none) {
        return Ok(None);
    }
    let mut signals = [const { Vec::new() }; N];
    let parts = columns.into_iter().zip(keys).zip(quantities);
    for (signal, ((column, key), quantity)) in signals.iter_mut().zip(parts) {
        *signal = match column {
            Some(column) => source.numbers(column, quantity, &format!("[{section}] {key}"))?,
            None => vec![0.0; source.rows()],
        };
    }
    Ok(Some(signals))
}

/// Keeps the rows of the mapping's range in the source and returns their times, s. It runs before any column but the time is
/// read, so that errors in other rows do not matter.
fn select(mapping: &Mapping, span: Span, source: &mut Source) -> anyhow::Result<Vec<f64>> {
    let Span {
        first,
        last,
        from_s,
        to_s,
    } = span;
    let rows = source.rows();
    source.keep(|n| first.is_none_or(|first| n + 1 >= first) && last.is_none_or(|last| n < last));
    let times = times(mapping, source)?;
    let wanted = |n: usize| {
        from_s.is_none_or(|from| times[n] >= from) && to_s.is_none_or(|to| times[n] <= to)
    };
    source.keep(wanted);
    if source.rows() == 0 && !source.lacks_columns() {
        bail!(
            "[rows] leaves nothing: the table has {rows} rows, and those from `first` to `last` are from \
             {} s to {} s",
            times.first().copied().unwrap_or(0.0),
            times.last().copied().unwrap_or(0.0)
        );
    }
    source.check()?;
    let kept: Vec<f64> = (0..times.len())
        .filter(|n| wanted(*n))
        .map(|n| times[n])
        .collect();
    // Times of a recording cannot be negative, so they are shifted. All parts of a table are shifted alike, if its first row has
    // a time.
    let begins = self::times(mapping, &mut source.beginning()).ok();
    let begins = begins.and_then(|times| times.first().copied().filter(|time| time.is_finite()));
    let start = begins
        .into_iter()
        .chain(kept.first().copied())
        .fold(0.0, f64::min);
    Ok(kept.into_iter().map(|t| t - start).collect())
}

fn times(mapping: &Mapping, source: &mut Source) -> anyhow::Result<Vec<f64>> {
    if let Some(column) = &mapping.time.column {
        return source.numbers(column, Quantity::Time, "[time] column");
    }
    let step = mapping
        .time
        .sample_time_s
        .context("the mapping needs [time] `column`, or `sample_time_s` if no column has it")?;
    ensure!(
        step.is_finite() && step > 0.0,
        "[time] `sample_time_s` is {step}; expected a time above 0"
    );
    Ok(source.numbers_of_rows().map(|n| n as f64 * step).collect())
}

/// Whether the loop is closed, for each row: by the mapped column, by the given range of rows, or, without either, in all rows of
/// a log that has the velocity of a model.
fn running(mode: &Mode, source: &mut Source, has_model: bool) -> anyhow::Result<Vec<bool>> {
    if let Some(column) = &mode.column {
        ensure!(
            mode.running_rows.is_none(),
            "[mode] has both `column` and `running_rows`; one of them can be right"
        );
        let says_running = |word: &&str| match mode.running.as_slice() {
            [] => word.parse::<f64>().is_ok_and(|number| number != 0.0),
            words => words.iter().any(|w| w == word),
        };
        let words = source.words(column, "[mode] column")?;
        return Ok(words.iter().map(says_running).collect());
    }
    ensure!(
        mode.running.is_empty(),
        "[mode] `running` says what stands in a column; say `column`, too"
    );
    Ok(match mode.running_rows {
        Some([first, last]) => {
            let rows = source.numbers_of_rows();
            rows.map(|n| n + 1 >= first && n < last).collect()
        }
        None => vec![has_model; source.rows()],
    })
}

/// Orientation of M in C.
fn rotation(
    orientation: &Orientation,
    source: &mut Source,
    warnings: &mut Vec<String>,
) -> anyhow::Result<Rotation> {
    let columns = group(
        source,
        "orientation",
        orientation.rotation_columns(),
        ROTATION_KEYS,
        [Quantity::Angle; 3],
    )?;
    match (&orientation.quaternion, columns) {
        (Some(columns), None) if orientation.euler.is_none() => {
            let mut parts = [const { Vec::new() }; 4];
            for (part, column) in parts.iter_mut().zip(columns) {
                let column = Column::from(column.clone());
                let place = "[orientation] quaternion";
                *part = source.numbers(&column, Quantity::Number, place)?;
            }
            if orientation.order == Order::Xyzw {
                parts.rotate_right(1);
            }
            Ok(Rotation::Quaternions(parts))
        }
        (None, Some(columns)) => {
            let [x, y, z] = &columns;
            let rows = x.iter().zip(y).zip(z);
            let vectors: Vec<Vector3<f64>> =
                rows.map(|((x, y), z)| Vector3::new(*x, *y, *z)).collect();
            warnings.extend(more_than_a_turn(orientation, &vectors, source));
            let angles = Angles::of_columns(&columns).map(Rotation::Angles);
            Ok(
                angles
                    .unwrap_or_else(|| Rotation::Quaternions(turned(orientation.euler, &vectors))),
            )
        }
        _ => anyhow::bail!(
            "[orientation] needs either `quaternion` with four columns, or `rx`, `ry`, `rz`, which with `euler` are angles of \
             turns one after the other"
        ),
    }
}

/// A warning if rotations without a stated unit exceed a turn.
fn more_than_a_turn(
    orientation: &Orientation,
    vectors: &[Vector3<f64>],
    source: &Source,
) -> Option<String> {
    let largest = vectors.iter().map(Vector3::norm).fold(0.0, f64::max);
    let unsaid = |column: &&Column| !column.says_unit();
    let columns = orientation.rotation_columns();
    (largest > MORE_THAN_A_TURN_RAD && columns.iter().flatten().any(unsaid)).then(|| {
        format!(
            "{}: the orientation reaches {} rad, more than a turn: is it in degrees? Say `unit = \"deg\"`, or \"rad\"",
            source.name(),
            number::significant(largest, 4)
        )
    })
}

/// Quaternions w x y z of rotation vectors, or of angles of turns one after the other, rad.
fn turned(euler: Option<Turns>, vectors: &[Vector3<f64>]) -> [Vec<f64>; 4] {
    let turned = |v: &Vector3<f64>| match euler {
        None => UnitQuaternion::from_scaled_axis(*v),
        Some(Turns(axes)) => axes.iter().fold(UnitQuaternion::identity(), |q, axis| {
            q * UnitQuaternion::from_axis_angle(&Vector3::ith_axis(*axis), v[*axis])
        }),
    };
    let mut parts = [const { Vec::new() }; 4];
    for q in vectors.iter().map(turned) {
        for (part, value) in parts.iter_mut().zip([q.w, q.i, q.j, q.k]) {
            part.push(value);
        }
    }
    parts
}
