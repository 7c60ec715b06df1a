//! Settings as TOML.

use super::{OwnedValue, Setting, missing};
use anyhow::{Context, Result};
use softdock_io::input::{nearest, report};
use std::collections::BTreeSet;
use std::fmt::Write;
use std::ops::Range;
use std::path::Path;
use toml_edit::{Document, Item, TableLike};

/// The settings with descriptions, units and ranges as comments, for a person to change. `head` is
/// its first line.
pub fn write(settings: &[Setting], head: &str) -> String {
    let mut out = format!("# {head}\n");
    let mut sections: Vec<&str> = Vec::new();
    for setting in settings {
        let section = split(&setting.name).0;
        if !sections.contains(&section) {
            sections.push(section);
        }
    }
    for section in sections {
        // Writing to a String cannot fail.
        let _ = writeln!(out, "\n[{section}]");
        for setting in settings {
            let (inside, key) = split(&setting.name);
            if inside != section {
                continue;
            }
            for line in setting.help.lines() {
                let _ = writeln!(out, "# {line}");
            }
            let unit = match setting.unit.as_str() {
                "" => String::new(),
                unit => format!("unit {unit}; "),
            };
            let allowed = setting.allowed();
            let _ = writeln!(out, "# {unit}{allowed}; default {}", setting.default);
            let _ = writeln!(out, "{key} = {}", setting.value);
        }
    }
    out
}

/// Section and key of a name.
fn split(name: &str) -> (&str, &str) {
    name.rsplit_once('.').unwrap_or(("", name))
}

/// Settings that a file asks for. With `rest`, settings that the file does not name are to have their defaults, as everywhere;
/// without, they stay.
///
/// # Errors
/// The file cannot be read, or names something that the board does not have or does not take, with
/// its line and what was probably meant.
pub fn read(path: &Path, settings: &[Setting], rest: bool) -> Result<Vec<(String, OwnedValue)>> {
    let text =
        std::fs::read_to_string(path).with_context(|| format!("cannot read {}", path.display()))?;
    let mut wanted = parse(&text, &path.display().to_string(), settings)?;
    if rest {
        for setting in settings {
            if !wanted.iter().any(|(name, _)| *name == setting.name) {
                wanted.push((setting.name.clone(), setting.default.clone()));
            }
        }
    }
    Ok(wanted)
}

/// Settings that a text asks for; `name` is that of the text in errors.
///
/// # Errors
/// As [`read`].
pub fn parse(text: &str, name: &str, settings: &[Setting]) -> Result<Vec<(String, OwnedValue)>> {
    let document = Document::parse(text).map_err(|error| {
        let what = format!("not valid TOML: {}", error.message());
        report(text, name, error.span(), &what, "")
    })?;
    let mut reader = Reader {
        settings,
        wanted: Vec::new(),
    };
    reader
        .table(document.as_table(), "")
        .map_err(|(span, what)| report(text, name, span, &what, ""))?;
    Ok(reader.wanted)
}

/// A place in the text, and what is wrong there.
type Wrong = (Option<Range<usize>>, String);

struct Reader<'a> {
    settings: &'a [Setting],
    wanted: Vec<(String, OwnedValue)>,
}

impl Reader<'_> {
    fn table(&mut self, table: &dyn TableLike, section: &str) -> Result<(), Wrong> {
        for (key, item) in table.iter() {
            let span = table.key(key).and_then(toml_edit::Key::span);
            let path = match section {
                "" => key.to_owned(),
                section => format!("{section}.{key}"),
            };
            self.item(item, &path, span)?;
        }
        Ok(())
    }

    fn item(&mut self, item: &Item, path: &str, span: Option<Range<usize>>) -> Result<(), Wrong> {
        if let Some(setting) = self.settings.iter().find(|s| s.name == path) {
            let Some(value) = item.as_value() else {
                return Err((span, format!("`{path}` is a setting, not a section")));
            };
            let value = setting.value(value);
            let value = value.map_err(|error| (span, error.to_string()))?;
            self.wanted.push((path.to_owned(), value));
            return Ok(());
        }
        match item.as_table_like() {
            Some(table) if self.sections().contains(path) => self.table(table, path),
            Some(_) => {
                let sections = self.sections();
                let offer = nearest(path, sections.iter().map(String::as_str));
                let offer = offer.map(|near| format!("; did you mean `[{near}]`?"));
                let what = format!("the board has no settings `[{path}]`");
                Err((span, format!("{what}{}", offer.unwrap_or_default())))
            }
            None => Err((span, missing(path, self.settings).to_string())),
        }
    }

    /// All sections: beginnings of the settings' names up to a dot.
    fn sections(&self) -> BTreeSet<String> {
        let ends = |name: &str| {
            name.match_indices('.')
                .map(|(at, _)| at)
                .collect::<Vec<_>>()
        };
        self.settings
            .iter()
            .flat_map(|s| ends(&s.name).into_iter().map(|at| s.name[..at].to_owned()))
            .collect()
    }
}

#[cfg(test)]
mod tests;
