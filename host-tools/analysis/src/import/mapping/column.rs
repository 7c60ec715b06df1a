//! Which column a number comes from, and how it becomes SI.

use serde::de::{MapAccess, Visitor, value::MapAccessDeserializer};
use serde::{Deserialize, Deserializer};
use std::f64::consts::{PI, TAU};
use std::fmt;

/// A physical quantity.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Quantity {
    /// Time.
    Time,
    /// Position.
    Length,
    /// Orientation.
    Angle,
    /// Velocity.
    Velocity,
    /// Angular velocity.
    Rate,
    /// Force.
    Force,
    /// Torque.
    Torque,
    /// A part of a quaternion.
    Number,
}

impl Quantity {
    fn name(self) -> &'static str {
        match self {
            Self::Time => "a time",
            Self::Length => "a length",
            Self::Angle => "an angle",
            Self::Velocity => "a velocity",
            Self::Rate => "an angular velocity",
            Self::Force => "a force",
            Self::Torque => "a torque",
            Self::Number => "a plain number",
        }
    }
}

/// Units by name: quantity, and factor to SI. Units without a quantity are those of a converter, for which the user has to give
/// the scale to SI.
const UNITS: &[(&str, Option<Quantity>, f64)] = &[
    ("s", Some(Quantity::Time), 1.0),
    ("ms", Some(Quantity::Time), 1e-3),
    ("us", Some(Quantity::Time), 1e-6),
    ("ns", Some(Quantity::Time), 1e-9),
    (DATE, Some(Quantity::Time), 1.0),
    ("m", Some(Quantity::Length), 1.0),
    ("cm", Some(Quantity::Length), 1e-2),
    ("mm", Some(Quantity::Length), 1e-3),
    ("um", Some(Quantity::Length), 1e-6),
    ("rad", Some(Quantity::Angle), 1.0),
    ("deg", Some(Quantity::Angle), PI / 180.0),
    ("turn", Some(Quantity::Angle), TAU),
    ("rev", Some(Quantity::Angle), TAU),
    ("m/s", Some(Quantity::Velocity), 1.0),
    ("mm/s", Some(Quantity::Velocity), 1e-3),
    ("rad/s", Some(Quantity::Rate), 1.0),
    ("deg/s", Some(Quantity::Rate), PI / 180.0),
    ("rev/s", Some(Quantity::Rate), TAU),
    ("rpm", Some(Quantity::Rate), PI / 30.0),
    ("N", Some(Quantity::Force), 1.0),
    ("kN", Some(Quantity::Force), 1e3),
    ("mN", Some(Quantity::Force), 1e-3),
    ("N·m", Some(Quantity::Torque), 1.0),
    ("Nm", Some(Quantity::Torque), 1.0),
    ("kN·m", Some(Quantity::Torque), 1e3),
    ("N·mm", Some(Quantity::Torque), 1e-3),
    ("Nmm", Some(Quantity::Torque), 1e-3),
    ("V", None, 1.0),
    ("mV", None, 1e-3),
    ("A", None, 1.0),
    ("mA", None, 1e-3),
    ("Pa", None, 1.0),
    ("kPa", None, 1e3),
    ("bar", None, 1e5),
    ("counts", None, 1.0),
];

/// Cells hold a date with its time, or a time of day: seconds since the first of them.
const DATE: &str = "date";

/// A unit of [`UNITS`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Unit {
    name: &'static str,
    quantity: Option<Quantity>,
    si: f64,
}

impl<'de> Deserialize<'de> for Unit {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let word = String::deserialize(deserializer)?;
        UNITS
            .iter()
            .find(|(name, ..)| *name == word)
            .map(|(name, quantity, si)| Self {
                name,
                quantity: *quantity,
                si: *si,
            })
            .ok_or_else(|| {
                let names: Vec<&str> = UNITS.iter().map(|(name, ..)| *name).collect();
                let names = names.join(", ");
                serde::de::Error::custom(format!("unknown unit `{word}`; known are {names}"))
            })
    }
}

/// Name of a column, or its number from 1.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum ColumnName {
    /// By the header.
    Name(String),
    /// From 1.
    Number(usize),
}

/// A column and its conversion to SI: `scale × number + offset` in its unit, minus the value of another column, which has the same
/// scale and unit if it states neither.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Column {
    /// Which one.
    pub(super) column: ColumnName,
    unit: Option<Unit>,
    scale: Option<f64>,
    offset: f64,
    /// Column that is subtracted, in SI.
    pub(super) minus: Option<Box<Column>>,
}

/// The long form, `{ column = "qm", unit = "mm", scale = -1.0 }`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Written {
    column: ColumnName,
    unit: Option<Unit>,
    scale: Option<f64>,
    #[serde(default)]
    offset: f64,
    minus: Option<Column>,
}

impl Column {
    /// Whether its cells hold dates.
    pub(super) fn is_date(&self) -> bool {
        self.unit.is_some_and(|unit| unit.name == DATE)
    }

    /// The same with this unit and scale if it states neither, and so what is subtracted from it.
    fn converted(self, unit: Option<Unit>, scale: Option<f64>) -> Self {
        let own = self.unit.is_some() || self.scale.is_some();
        let (unit, scale) = if own {
            (self.unit, self.scale)
        } else {
            (unit, scale)
        };
        let minus = self
            .minus
            .map(|other| Box::new(other.converted(unit, scale)));
        Self {
            unit,
            scale,
            minus,
            ..self
        }
    }

    /// Whether the mapping states the unit of its numbers.
    pub(super) fn says_unit(&self) -> bool {
        self.unit.is_some()
    }

    /// Note on a converter's unit with the scale 1 or −1: values in the SI unit `si` are then in the converter's scale. None for
    /// any other column.
    pub(super) fn unscaled(&self, si: &str) -> Option<String> {
        let converter = self.unit.filter(|unit| unit.quantity.is_none())?;
        (self.scale?.abs() == 1.0).then(|| {
            format!(
                "1 {} counts as {} {si}: amounts in {si} are those of the column at this rate, and no forces or torques",
                converter.name, converter.si
            )
        })
    }

    /// Scale and offset to SI. `place` is the column's key in the mapping, for errors.
    ///
    /// # Errors
    ///
    /// A unit of another quantity, or one that needs a scale and has none.
    pub(super) fn to_si(&self, quantity: Quantity, place: &str) -> anyhow::Result<(f64, f64)> {
        let (scale, offset) = (self.scale.unwrap_or(1.0), self.offset);
        anyhow::ensure!(
            scale.is_finite() && offset.is_finite() && scale != 0.0,
            "{place}: scale {scale} and offset {offset} are not finite, or all is scaled to zero"
        );
        let Some(unit) = self.unit else {
            return Ok((scale, offset));
        };
        match unit.quantity {
            Some(of) if of == quantity => {}
            None if self.scale.is_some() => {}
            None => anyhow::bail!(
                "{place}: `{}` is a converter's unit; say with `scale` how much SI one of it is",
                unit.name
            ),
            Some(_) => {
                let fitting: Vec<&str> = UNITS
                    .iter()
                    .filter(|(_, of, _)| *of == Some(quantity))
                    .map(|(name, ..)| *name)
                    .collect();
                anyhow::bail!(
                    "{place}: expected {} (in {}), received the unit `{}`",
                    quantity.name(),
                    fitting.join(", "),
                    unit.name
                )
            }
        }
        Ok((unit.si * scale, unit.si * offset))
    }
}

struct NameVisitor;

impl Visitor<'_> for NameVisitor {
    type Value = ColumnName;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("the name of a column, or its number from 1")
    }

    fn visit_str<E: serde::de::Error>(self, name: &str) -> Result<ColumnName, E> {
        Ok(ColumnName::Name(name.to_owned()))
    }

    fn visit_i64<E: serde::de::Error>(self, number: i64) -> Result<ColumnName, E> {
        match usize::try_from(number) {
            Ok(number) if number > 0 => Ok(ColumnName::Number(number)),
            _ => Err(E::custom(format!(
                "columns are counted from 1, found {number}"
            ))),
        }
    }
}

impl<'de> Deserialize<'de> for ColumnName {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(NameVisitor)
    }
}

struct ColumnVisitor;

impl<'de> Visitor<'de> for ColumnVisitor {
    type Value = Column;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(
            "a column: \"name\", a number from 1, or { column = .., unit = .., scale = .., offset = .., minus = .. }",
        )
    }

    fn visit_str<E: serde::de::Error>(self, name: &str) -> Result<Column, E> {
        NameVisitor.visit_str(name).map(Column::from)
    }

    fn visit_i64<E: serde::de::Error>(self, number: i64) -> Result<Column, E> {
        NameVisitor.visit_i64(number).map(Column::from)
    }

    fn visit_map<M: MapAccess<'de>>(self, map: M) -> Result<Column, M::Error> {
        let Written {
            column,
            unit,
            scale,
            offset,
            minus,
        } = Written::deserialize(MapAccessDeserializer::new(map))?;
        Ok(Column {
            column,
            unit,
            scale,
            offset,
            minus: minus.map(|other| Box::new(other.converted(unit, scale))),
        })
    }
}

impl From<ColumnName> for Column {
    fn from(column: ColumnName) -> Self {
        Self {
            column,
            unit: None,
            scale: None,
            offset: 0.0,
            minus: None,
        }
    }
}

impl<'de> Deserialize<'de> for Column {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(ColumnVisitor)
    }
}
