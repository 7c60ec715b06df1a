//! Settings of a board that were measured: as a file of their own, or written into existing settings, whose comments and order
//! stay.

use anyhow::{Context, Result};
use softdock_app::settings::BoardSettings;
use softdock_io::input;
use softdock_io::output::write_whole;
use softdock_physics::model::edit::{replace, rounded, with_its_line_ends};
use softdock_report::number;
use std::fmt::Write;
use std::path::Path;
use toml_edit::{Array, DocumentMut, Item, RawString, Table, TableLike, Value};

/// Digits of the width of an interval in a remark.
const INTERVAL_DIGITS: usize = 2;
/// Unchanged lines around a change.
const CONTEXT_LINES: usize = 2;

/// Beginnings of remarks that measurements write; other remarks are the user's.
const OWN_REMARKS: [&str; 8] = [
    "95 %",
    "found; 95 %",
    "as given",
    "about the centre of mass; acts",
    "held by tool_com_m",
    "none",
    "by the force of the tool",
    "not told from the delay",
];

/// A setting that was measured.
#[derive(Clone, Debug)]
pub struct Setting {
    /// Its key.
    pub key: &'static str,
    /// Its value.
    pub value: Value,
    /// How well it is known, as a comment behind the value.
    pub remark: String,
}

impl Setting {
    /// A number with the interval in which it lies.
    pub fn number(key: &'static str, value: f64, [low, high]: [f64; 2]) -> Self {
        Self {
            key,
            value: float(value),
            remark: format!("95 %: {}", number::interval(low, high, INTERVAL_DIGITS)),
        }
    }

    /// A list of numbers with what is known about them.
    pub fn list(key: &'static str, values: &[f64], remark: impl Into<String>) -> Self {
        let array: Array = values.iter().map(|v| float(*v)).collect();
        Self {
            key,
            value: Value::Array(array),
            remark: remark.into(),
        }
    }
}

/// Half widths of intervals in a row, for the remark of a list.
pub fn half_widths(intervals: &[[f64; 2]]) -> String {
    let half = |[low, high]: &[f64; 2]| number::significant(0.5 * (high - low), 2);
    let all: Vec<String> = intervals.iter().map(half).collect();
    format!("95 %: ± {}", all.join(", "))
}

/// A number rounded to its significant digits, with an exponent in place of many zeros.
fn float(value: f64) -> Value {
    let text = format!("{:?}", rounded(value));
    text.parse().unwrap_or_else(|_| Value::from(value))
}

/// Settings of one section that were measured together.
#[derive(Clone, Debug)]
pub struct Fragment {
    /// The section: `["control", "sensor"]`.
    pub section: &'static [&'static str],
    /// Where they come from; lines of a comment.
    pub origin: Vec<String>,
    /// The settings.
    pub settings: Vec<Setting>,
}

impl Fragment {
    /// As a file of its own.
    pub fn text(&self) -> String {
        let mut text = String::new();
        for line in &self.origin {
            // Writing to a String cannot fail.
            let _ = writeln!(text, "# {line}");
        }
        let _ = writeln!(text, "[{}]", self.section.join("."));
        for setting in &self.settings {
            let value = setting.value.to_string();
            let _ = writeln!(
                text,
                "{} = {}  # {}",
                setting.key,
                value.trim(),
                setting.remark
            );
        }
        text
    }

    /// Writes the file of its own.
    ///
    /// # Errors
    ///
    /// The file is there already, or cannot be written.
    pub fn write(&self, path: &Path, force: bool) -> Result<()> {
        input::refuse_overwrite(path, force)?;
        write_whole(path, self.text())
    }

    /// Changes the settings file `path`, in one step, and returns what was changed as a unified
    /// difference.
    ///
    /// # Errors
    ///
    /// A file that is no settings file, or would be none with these values; then it is left as it
    /// is.
    pub fn write_into(&self, path: &Path) -> Result<String> {
        let name = path.display().to_string();
        let before: BoardSettings = input::load(path)?;
        before.validate().with_context(|| name.clone())?;
        let text = std::fs::read_to_string(path).with_context(|| format!("cannot read {name}"))?;
        let changed = with_its_line_ends(&text, |text| self.merged(text))?;
        let refused =
            || format!("{name} is left as it is: it would not be valid with what was found");
        let after: BoardSettings = input::parse(&changed, &name).with_context(refused)?;
        after.validate().with_context(refused)?;
        replace(path, &text, &changed)?;
        Ok(similar::TextDiff::from_lines(&text, &changed)
            .unified_diff()
            .context_radius(CONTEXT_LINES)
            .header(&name, &format!("{name} (changed)"))
            .to_string())
    }

    /// Settings text with these values.
    fn merged(&self, text: &str) -> Result<String> {
        let mut document: DocumentMut = text.parse().context("the settings are not TOML")?;
        let section = open(document.as_table_mut(), self.section)
            .with_context(|| format!("[{}] is not a section", self.section.join(".")))?;
        for setting in &self.settings {
            match section.get_mut(setting.key).and_then(Item::as_value_mut) {
                Some(value) => {
                    let mut decor = value.decor().clone();
                    let suffix = decor.suffix().and_then(RawString::as_str);
                    // The interval of another run does not belong to this value; a user's own remark stays.
                    if suffix.is_some_and(is_own) {
                        decor.set_suffix(format!("  # {}", setting.remark));
                    }
                    *value = setting.value.clone();
                    *value.decor_mut() = decor;
                }
                None => {
                    let remark = format!("  # {}", setting.remark);
                    let value = setting.value.clone().decorated(" ", remark);
                    section.insert(setting.key, Item::Value(value));
                }
            }
        }
        Ok(document.to_string())
    }
}

/// Whether the remark behind a value was written by a measurement.
fn is_own(suffix: &str) -> bool {
    let text = suffix.trim_start().trim_start_matches('#').trim_start();
    OWN_REMARKS.iter().any(|begin| text.starts_with(begin))
}

/// The section of a path, made if it is not there; None if something else has its name.
fn open<'a>(table: &'a mut dyn TableLike, path: &[&str]) -> Option<&'a mut dyn TableLike> {
    let Some((first, rest)) = path.split_first() else {
        return Some(table);
    };
    let mut fresh = Table::new();
    // A section that only holds others needs no heading of its own.
    fresh.set_implicit(true);
    let item = table.entry(first).or_insert(Item::Table(fresh));
    open(item.as_table_like_mut()?, rest)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fragment() -> Fragment {
        Fragment {
            section: &["control", "sensor"],
            origin: vec!["Calibrated.".to_owned()],
            settings: vec![
                Setting::number("tool_mass_kg", 1.812_345_678, [1.8, 1.82]),
                Setting::list("tool_com_m", &[0.001, 0.0, 0.06], "95 %: ± 1e-4"),
            ],
        }
    }

    #[test]
    fn comments_and_order_stay() {
        let text = "# mine\n[control.sensor]\ntool_mass_kg = 1.0  # scales in the lab\n\n[can]\nbase_id = 3\n";
        let changed = fragment().merged(text).unwrap();
        assert_eq!(
            changed,
            "# mine\n[control.sensor]\ntool_mass_kg = 1.812346  # scales in the lab\n\
             tool_com_m = [0.001, 0.0, 0.06]  # 95 %: ± 1e-4\n\n[can]\nbase_id = 3\n"
        );
    }

    #[test]
    fn a_second_measurement_takes_its_intervals_with_it() {
        let first = fragment().merged("[can]\nbase_id = 3\n").unwrap();
        let mut second = fragment();
        second.settings[0] = Setting::number("tool_mass_kg", 1.9, [1.88, 1.92]);
        let changed = second.merged(&first).unwrap();
        let expected = format!("tool_mass_kg = 1.9  # {}\n", second.settings[0].remark);
        assert!(changed.contains(&expected), "{changed}");
    }

    #[test]
    fn a_section_that_is_not_there_is_made() {
        for text in ["", "[can]\nbase_id = 3\n", "[control]\n"] {
            let changed = fragment().merged(text).unwrap();
            let settings: BoardSettings = input::parse(&changed, "test").unwrap();
            assert_eq!(settings.control.sensor.tool_mass_kg, 1.812_346);
        }
    }

    #[test]
    fn the_fragment_alone_is_a_settings_file() {
        let settings: BoardSettings = input::parse(&fragment().text(), "fragment").unwrap();
        assert_eq!(settings.control.sensor.tool_com_m, [0.001, 0.0, 0.06]);
        settings.validate().unwrap();
    }

    #[test]
    fn what_would_not_be_valid_is_not_written() {
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), "[can]\nbase_id = 3\n").unwrap();
        let mut heavy = fragment();
        heavy.settings[0].value = float(-5.0);
        let error = format!("{:#}", heavy.write_into(file.path()).unwrap_err());
        assert!(
            error.contains("is left as it is") && error.contains("tool_mass_kg"),
            "{error}"
        );
        assert_eq!(
            std::fs::read_to_string(file.path()).unwrap(),
            "[can]\nbase_id = 3\n"
        );
        let difference = fragment().write_into(file.path()).unwrap();
        assert!(
            difference.contains("+tool_mass_kg = 1.812346"),
            "{difference}"
        );
    }
}
