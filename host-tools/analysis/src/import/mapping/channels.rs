//! All channels of a mapped table as signals, in SI.

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
use softdock_control::frames;
use softdock_report::number;

/// A rotation vector longer than one turn and a bit is in degrees, rad.
const MORE_THAN_A_TURN_RAD: f64 = 7.0;

/// Signals with one value per row. A group that is not mapped is None; an axis that is not mapped
/// in a group that is, is zero.
#[derive(Clone, Debug)]
pub(super) struct Channels {
    /// Numbers of the rows in their file, from 1; none of what is interpolated.
    pub(super) rows: Vec<usize>,
    /// Time, s.
    pub(super) time_s: Vec<f64>,
    /// The loop is closed.
    pub(super) running: Vec<bool>,
    /// Position of M in C, m.
    pub(super) position: Option<[Vec<f64>; 3]>,
    /// Orientation of M in C.
    pub(super) orientation: Option<Rotation>,
    /// Velocity that was sent, m/s and rad/s.
    pub(super) sent: Option<[Vec<f64>; 6]>,
    /// Velocity that was executed.
    pub(super) executed: Option<[Vec<f64>; 6]>,
    /// Velocity of the rig's model.
    pub(super) model_velocity: Option<[Vec<f64>; 6]>,
    /// Raw wrench, N and N·m.
    pub(super) wrench: Option<[Vec<f64>; 6]>,
}

/// Orientations, one per row.
#[derive(Clone, Debug)]
pub(super) enum Rotation {
    /// Turns about one axis.
    Angles(Angles),
    /// Quaternions w x y z.
    Quaternions([Vec<f64>; 4]),
}

impl Rotation {
    /// w x y z of a row.
    pub(super) fn quaternion(&self, row: usize) -> [f64; 4] {
        match self {
            Self::Quaternions(parts) => parts.each_ref().map(|part| part[row]),
            Self::Angles(Angles { axis, rad, .. }) => {
                let (sine, cosine) = (0.5 * rad[row]).sin_cos();
                let [x, y, z] = (axis * sine).into();
                [cosine, x, y, z]
            }
        }
    }

    fn signals(&self) -> &[Vec<f64>] {
        match self {
            Self::Quaternions(parts) => parts,
            Self::Angles(angles) => std::slice::from_ref(&angles.rad),
        }
    }

    fn signals_mut(&mut self) -> &mut [Vec<f64>] {
        match self {
            Self::Quaternions(parts) => parts,
            Self::Angles(angles) => std::slice::from_mut(&mut angles.rad),
        }
    }
}

/// What the axes of a velocity measure.
const TWIST: [Quantity; 6] = quantities(Quantity::Velocity, Quantity::Rate);
/// What the axes of a wrench measure.
const WRENCH: [Quantity; 6] = quantities(Quantity::Force, Quantity::Torque);

const fn quantities(linear: Quantity, angular: Quantity) -> [Quantity; 6] {
    [linear, linear, linear, angular, angular, angular]
}

impl Channels {
    /// Reads what the mapping names, in some rows.
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
    ) -> anyhow::Result<Self> {
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
        let mut channels = Self {
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

    /// Leaves rows out in which a value is not there, and says so.
    ///
    /// # Errors
    ///
    /// No row is left.
    fn leave_incomplete_out(
        &mut self,
        name: &str,
        warnings: &mut Vec<String>,
    ) -> anyhow::Result<()> {
        let mut whole: Vec<bool> = self.time_s.iter().map(|t| t.is_finite()).collect();
        for signal in self.signals_mut() {
            let both = whole.iter_mut().zip(signal.iter());
            both.for_each(|(whole, value)| *whole &= value.is_finite());
        }
        let rows = whole.len();
        let incomplete = whole.iter().filter(|whole| !**whole).count();
        ensure!(
            incomplete < rows,
            "{name}: in each of {rows} rows a cell of a column that is mapped holds no number; map columns that the \
             table has values for, or, where each row has some of the channels, say `incomplete = \"interpolate\"` in [rows]"
        );
        if incomplete > 0 {
            self.keep(|n| whole[n]);
            warnings.push(format!(
                "{name}: {incomplete} of {rows} rows are left out, in which a cell is empty or no number"
            ));
        }
        Ok(())
    }

    /// Says so where nothing that moves is mapped.
    fn lacks_motion(&self, name: &str) -> Option<String> {
        let motions = [&self.executed, &self.sent];
        let poses = self.position.is_some() || self.orientation.is_some();
        (!poses && motions.iter().all(|motion| motion.is_none())).then(|| {
            format!(
                "{name}: no motion is mapped, so nothing that depends on one can show: map [position], [orientation] or \
                 [executed_velocity], if the table has them"
            )
        })
    }

    /// Orientations of the rows if nothing counts their turns, else none.
    pub(super) fn uncounted(&self) -> Vec<UnitQuaternion<f64>> {
        let uncounted = self.orientation.as_ref().filter(|rotation| match rotation {
            Rotation::Angles(angles) => angles.begin_again,
            Rotation::Quaternions(_) => true,
        });
        let rows = |rotation: &Rotation| {
            let row = |n| frames::pose(&[0.0; 3], &rotation.quaternion(n)).rotation;
            (0..self.len()).map(row).collect()
        };
        uncounted.map(rows).unwrap_or_default()
    }

    /// Number of rows.
    pub(super) fn len(&self) -> usize {
        self.time_s.len()
    }

    /// All signals that are mapped, with their names and units, in the order of
    /// [`Self::signals_mut`].
    pub(super) fn named<'a>(&'a self) -> Vec<(String, &'static str, &'a [f64])> {
        type Group<'a> = (
            &'a str,
            &'a [&'a str],
            [&'static str; 2],
            Option<&'a [Vec<f64>]>,
        );
        fn slice<const N: usize>(signals: &Option<[Vec<f64>; N]>) -> Option<&[Vec<f64>]> {
            signals.as_ref().map(<[_; N]>::as_slice)
        }
        let (parts, unit) = match &self.orientation {
            Some(Rotation::Angles(_)) => (&["angle"][..], "rad"),
            _ => (&["qw", "qx", "qy", "qz"][..], ""),
        };
        let orientation = self.orientation.as_ref().map(Rotation::signals);
        let (speed, twist) = (["m/s", "rad/s"], &TWIST_KEYS[..]);
        let groups: [Group<'_>; 6] = [
            ("position", &POSITION_KEYS, ["m"; 2], slice(&self.position)),
            ("orientation", parts, [unit; 2], orientation),
            ("sent velocity", twist, speed, slice(&self.sent)),
            ("executed velocity", twist, speed, slice(&self.executed)),
            ("model velocity", twist, speed, slice(&self.model_velocity)),
            ("wrench", &WRENCH_KEYS, ["N", "N·m"], slice(&self.wrench)),
        ];
        let named = |(name, keys, units, signals): Group<'a>| {
            let signals = signals.into_iter().flatten().zip(keys).enumerate();
            signals.map(move |(i, (values, key))| {
                let unit = units[usize::from(i >= 3)];
                (format!("{name} {key}"), unit, values.as_slice())
            })
        };
        groups.into_iter().flat_map(named).collect()
    }

    /// All signals but time and mode.
    pub(super) fn signals_mut(&mut self) -> impl Iterator<Item = &mut Vec<f64>> {
        let six = [
            &mut self.sent,
            &mut self.executed,
            &mut self.model_velocity,
            &mut self.wrench,
        ];
        let position = self.position.iter_mut().flatten();
        let orientation = self.orientation.iter_mut();
        position
            .chain(orientation.flat_map(Rotation::signals_mut))
            .chain(six.into_iter().flatten().flatten())
    }

    /// Keeps the rows for which `wanted` holds.
    pub(super) fn keep(&mut self, wanted: impl Fn(usize) -> bool) {
        fn filter<T: Copy>(values: &mut Vec<T>, wanted: impl Fn(usize) -> bool) {
            let rows = values.iter().copied().enumerate();
            *values = rows.filter(|(n, _)| wanted(*n)).map(|(_, v)| v).collect();
        }
        self.signals_mut()
            .for_each(|values| filter(values, &wanted));
        filter(&mut self.rows, &wanted);
        filter(&mut self.time_s, &wanted);
        filter(&mut self.running, &wanted);
    }
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

/// Leaves the rows of the mapping's range in the source before anything but their time is read: what
/// is wrong in the others does not matter.
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
    // A recording's time cannot be negative. All parts of a table are moved alike, if its first row has a time.
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

/// In which rows the loop is closed: by the column, by the rows, or wherever a model ran at all.
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

/// A hint where rotations whose unit is not said reach more than a turn.
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
