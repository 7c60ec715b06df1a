//! All channels of a mapped table as signals, in SI.

use super::file::{POSITION_KEYS, TWIST_KEYS, WRENCH_KEYS};
use crate::import::turns::Angles;
use anyhow::ensure;
use nalgebra::UnitQuaternion;
use softdock_control::frames;

/// Signals with one value per row. A group that is not mapped is None; an axis that is not mapped
/// in a group that is, is zero.
#[derive(Clone, Debug)]
pub(super) struct Channels {
    /// Numbers of the rows in their file, from 1; empty after resampling.
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

impl Channels {
    /// Drops rows in which a value is missing, with a warning.
    ///
    /// # Errors
    ///
    /// No row is left.
    pub(super) fn leave_incomplete_out(
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

    /// A warning if no motion is mapped.
    pub(super) fn lacks_motion(&self, name: &str) -> Option<String> {
        let motions = [&self.executed, &self.sent];
        let poses = self.position.is_some() || self.orientation.is_some();
        (!poses && motions.iter().all(|motion| motion.is_none())).then(|| {
            format!(
                "{name}: no motion is mapped, so nothing that depends on one can show: map [position], [orientation] or \
                 [executed_velocity], if the table has them"
            )
        })
    }

    /// Orientations of all rows if nothing counts their whole turns; otherwise empty.
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
