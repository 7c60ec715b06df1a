//! Reads TOML files that people write, with errors that say where, what was expected and what was probably meant. Also the
//! rule that nothing is overwritten unasked.
//!
//! ```text
//! scenario.toml:12: unknown key `stiffness_n_per_mm` in [[rig.mechanism.walls]]; did you mean `stiffness_n_per_m`?
//!   12 | stiffness_n_per_mm = 30.0
//! The unit is part of the name: convert the value too.
//! ```

mod kind;

use anyhow::{Context, Result, anyhow, bail, ensure};
use serde::de::DeserializeOwned;
use std::fmt::Write;
use std::io::ErrorKind;
use std::path::Path;
use toml_edit::{Document, Item, TableLike, Value};

/// A known name is suggested for an unknown one if their similarity (1 is equal) is at least this.
const SIMILAR: f64 = 0.6;

/// Unit suffixes of keys, longer ones before those that they end with.
const UNITS: &[&str] = &[
    "_n_s_per_mm",
    "_n_s_per_m",
    "_n_per_mm",
    "_n_per_m",
    "_n_per_s",
    "_nm_per_s",
    "_newton_metre",
    "_newton",
    "_kg_m2",
    "_rad_s2",
    "_rad_s",
    "_deg_s2",
    "_deg_s",
    "_mm_s2",
    "_m_s2",
    "_mm_s",
    "_m_s",
    "_rad",
    "_deg",
    "_mm",
    "_um",
    "_ms",
    "_us",
    "_ns",
    "_khz",
    "_hz",
    "_kn",
    "_nmm",
    "_nm",
    "_kg",
    "_g",
    "_n",
    "_m",
    "_s",
];

/// Reads a TOML file.
///
/// # Errors
/// The file cannot be read (with the nearest name in its folder, if it is missing), or what
/// [`parse`] reports.
pub fn load<T: DeserializeOwned>(path: &Path) -> Result<T> {
    let text = match std::fs::read_to_string(path) {
        Ok(text) => text,
        Err(error) if error.kind() == ErrorKind::NotFound => bail!("{}", missing_file(path)),
        Err(error) if error.kind() == ErrorKind::InvalidData => {
            let bytes = std::fs::read(path).unwrap_or_default();
            bail!("{}: {}", path.display(), kind::of_bytes(&bytes))
        }
        Err(error) => {
            return Err(error).with_context(|| format!("cannot read {}", path.display()));
        }
    };
    parse(&text, &path.display().to_string())
}

/// Reads TOML text; `name` stands for it in errors.
///
/// # Errors
/// A syntax error, an unknown or missing key, or a value of the wrong type: `name:line:`, what was
/// expected and found, then the line's text.
pub fn parse<T: DeserializeOwned>(text: &str, name: &str) -> Result<T> {
    let document = Document::parse(text).map_err(|error| {
        let what = format!("not valid TOML: {}", error.message());
        report(text, name, error.span(), &what, "")
    })?;
    toml_edit::de::from_str(text).map_err(|error| {
        let offset = error.span().map_or(0, |span| span.start);
        let location = location_of(document.as_table(), offset, "", "at the top level")
            .unwrap_or_else(|| Location {
                section: "at the top level".into(),
                key: None,
            });
        let (what, hint) = explain(error.message(), &location, document.as_table());
        report(text, name, error.span(), &what, hint)
    })
}

/// An error if something exists at `path`, unless `force` is set. An empty folder counts as free.
///
/// # Errors
/// `path` exists, or cannot be looked at.
pub fn refuse_overwrite(path: &Path, force: bool) -> Result<()> {
    if force {
        return Ok(());
    }
    match std::fs::symlink_metadata(path) {
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(()),
        Err(error) => {
            return Err(error).with_context(|| format!("cannot look at {}", path.display()));
        }
        Ok(found) if found.is_dir() && std::fs::read_dir(path)?.next().is_none() => return Ok(()),
        Ok(_) => {}
    }
    bail!(
        "{} exists already and is not overwritten: choose another name, or say --force",
        path.display()
    )
}

/// As [`refuse_overwrite`]. In addition it refuses inputs of the same command, whatever `force` says: a file would be
/// overwritten before it is read to its end, or its only copy would be replaced.
///
/// # Errors
/// As [`refuse_overwrite`]; or `path` is one of `inputs`.
pub fn refuse_overwrite_of(inputs: &[impl AsRef<Path>], path: &Path, force: bool) -> Result<()> {
    let place = |path: &Path| path.canonicalize().ok();
    if let Some(output) = place(path) {
        ensure!(
            inputs
                .iter()
                .all(|input| place(input.as_ref()).as_ref() != Some(&output)),
            "{} is read by this command and is not overwritten, not even with --force: choose another name",
            path.display()
        );
    }
    refuse_overwrite(path, force)
}

/// The member of `known` that `wrong` was probably meant to be. The same name with another unit goes before the most similar
/// name. None if no name is similar.
pub fn nearest<'a>(wrong: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let score = |name: &str| {
        let similarity = strsim::normalized_damerau_levenshtein(wrong, name);
        if differs_in_unit(wrong, name) {
            1.0 + similarity
        } else {
            similarity
        }
    };
    let scored = known.into_iter().map(|name| (score(name), name));
    let best = scored.max_by(|a, b| a.0.total_cmp(&b.0))?;
    (best.0 >= SIMILAR).then_some(best.1)
}

fn differs_in_unit(a: &str, b: &str) -> bool {
    a != b && matches!((stem(a), stem(b)), (Some(x), Some(y)) if x == y)
}

/// The name without its unit suffix; None if it has none.
fn stem(name: &str) -> Option<&str> {
    UNITS.iter().find_map(|unit| name.strip_suffix(unit))
}

fn missing_file(path: &Path) -> String {
    let folder = match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    let Ok(entries) = std::fs::read_dir(folder) else {
        return format!(
            "{}: there is no folder {}",
            path.display(),
            folder.display()
        );
    };
    let names = entries
        .flatten()
        .filter_map(|entry| entry.file_name().into_string().ok());
    let mut names: Vec<String> = names.filter(|name| name.ends_with(".toml")).collect();
    names.sort();
    let wanted = path.file_name().unwrap_or_default().to_string_lossy();
    match nearest(&wanted, names.iter().map(String::as_str)) {
        Some(name) => {
            format!(
                "{}: no such file; did you mean {}?",
                path.display(),
                folder.join(name).display()
            )
        }
        None => format!(
            "{}: no such file; give the path of an existing TOML file",
            path.display()
        ),
    }
}

/// Place of a key or table in a document.
struct Location {
    /// `[a.b]`, `[[a.b]]` or `at the top level`. The caller puts `in` before the first two.
    section: String,
    /// The key, unless it is the section itself.
    key: Option<String>,
}

impl Location {
    /// "in [a.b]" or "at the top level".
    fn within(&self) -> String {
        if self.is_top_level() {
            self.section.clone()
        } else {
            format!("in {}", self.section)
        }
    }

    fn is_top_level(&self) -> bool {
        !self.section.starts_with('[')
    }

    /// "`key` in [a.b]" or "[a.b]".
    fn subject(&self) -> String {
        match &self.key {
            Some(key) => format!("`{key}` {}", self.within()),
            None => self.section.clone(),
        }
    }
}

/// The innermost key or table at a byte offset.
fn location_of(
    table: &dyn TableLike,
    offset: usize,
    path: &str,
    section: &str,
) -> Option<Location> {
    let contains = |span: Option<std::ops::Range<usize>>| span.is_some_and(|s| s.contains(&offset));
    for (name, item) in table.iter() {
        let here = || {
            Some(Location {
                section: section.into(),
                key: Some(name.into()),
            })
        };
        if contains(table.key(name).and_then(toml_edit::Key::span)) {
            return here();
        }
        let inner = if path.is_empty() {
            name.to_string()
        } else {
            format!("{path}.{name}")
        };
        for (part, span, heading) in tables_of(item, &inner) {
            let itself = || {
                contains(span.clone()).then(|| Location {
                    section: heading.clone(),
                    key: None,
                })
            };
            if let Some(location) = location_of(part, offset, &inner, &heading).or_else(itself) {
                return Some(location);
            }
        }
        if contains(item.span()) {
            return here();
        }
    }
    None
}

/// A table inside an item, its span and its heading.
type Part<'a> = (&'a dyn TableLike, Option<std::ops::Range<usize>>, String);

/// The tables that an item consists of.
fn tables_of<'a>(item: &'a Item, path: &str) -> Vec<Part<'a>> {
    let (one, many) = (format!("[{path}]"), format!("[[{path}]]"));
    match item {
        Item::Table(table) => vec![(table, table.span(), one)],
        Item::Value(Value::InlineTable(table)) => vec![(table, table.span(), one)],
        Item::ArrayOfTables(tables) => tables
            .iter()
            .map(|t| (t as &dyn TableLike, t.span(), many.clone()))
            .collect(),
        Item::Value(Value::Array(values)) => {
            let tables = values.iter().filter_map(Value::as_inline_table);
            tables
                .map(|t| (t as &dyn TableLike, t.span(), many.clone()))
                .collect()
        }
        _ => Vec::new(),
    }
}

/// Rewords a parser's message for the person who wrote the file; the second text is a hint.
fn explain(message: &str, location: &Location, table: &dyn TableLike) -> (String, &'static str) {
    let (first, expected) = message.split_once(", expected ").unwrap_or((message, ""));
    let known = names_in(expected);
    if let Some(wrong) = quoted(first, "unknown field ") {
        return unknown_key(wrong, &known, location, table);
    }
    if let Some(wrong) = quoted(first, "unknown variant ") {
        let offer = offer(nearest(wrong, known.iter().copied()), &known);
        let what = format!("{}: unknown value `{wrong}`; {offer}", location.subject());
        return (what, "");
    }
    if let Some(key) = quoted(first, "missing field ") {
        return (format!("missing key `{key}` {}", location.within()), "");
    }
    let found = ["invalid type: ", "invalid value: "]
        .iter()
        .find_map(|p| first.strip_prefix(p));
    if let Some(found) = found {
        let found = found
            .replace("floating point", "number")
            .replace("integer", "number");
        let (subject, expected) = (location.subject(), plain(expected));
        return (format!("{subject}: expected {expected}, found {found}"), "");
    }
    (format!("{}: {message}", location.subject()), "")
}

/// The message and hint for an unknown key.
fn unknown_key(
    wrong: &str,
    known: &[&str],
    location: &Location,
    table: &dyn TableLike,
) -> (String, &'static str) {
    let near = nearest(wrong, known.iter().copied());
    let hint = if near.is_some_and(|name| differs_in_unit(wrong, name)) {
        "The unit is part of the name: convert the value too."
    } else if location.is_top_level() {
        kind::other_kind(table, known).unwrap_or_default()
    } else {
        ""
    };
    let (within, offer) = (location.within(), offer(near, known));
    (format!("unknown key `{wrong}` {within}; {offer}"), hint)
}

fn offer(near: Option<&str>, known: &[&str]) -> String {
    match near {
        Some(name) => format!("did you mean `{name}`?"),
        None if known.is_empty() => "no key is known here".into(),
        None => format!("known are: {}", known.join(", ")),
    }
}

/// The name in backticks after `prefix`; None if the text is anything else.
fn quoted<'a>(text: &'a str, prefix: &str) -> Option<&'a str> {
    text.strip_prefix(prefix)?
        .strip_prefix('`')?
        .strip_suffix('`')
}

/// All names in backticks.
fn names_in(text: &str) -> Vec<&str> {
    text.split('`').skip(1).step_by(2).collect()
}

/// Names of Rust types in plain words.
fn plain(expected: &str) -> String {
    match expected {
        "f64" | "f32" => "a number".into(),
        "u8" | "u16" | "u32" | "u64" | "usize" => "a whole number, 0 or more".into(),
        "i8" | "i16" | "i32" | "i64" | "isize" => "a whole number".into(),
        "a boolean" => "true or false".into(),
        "a sequence" => "a list [..]".into(),
        "a string" => "text in quotes".into(),
        other if other.starts_with("struct ") || other == "a map" => {
            "a section or { key = value }".into()
        }
        other => other.into(),
    }
}

/// Error message of the form `name:line: what`, with the line's text and a hint below it.
pub fn report(
    text: &str,
    name: &str,
    span: Option<std::ops::Range<usize>>,
    what: &str,
    hint: &str,
) -> anyhow::Error {
    let offset = span.map_or(0, |span| span.start).min(text.len());
    let before = text.as_bytes().get(..offset).unwrap_or_default();
    let line = 1 + before.iter().filter(|byte| **byte == b'\n').count();
    let mut message = format!("{name}:{line}: {what}");
    if let Some(content) = text
        .lines()
        .nth(line - 1)
        .filter(|content| !content.trim().is_empty())
    {
        // Writing to a String cannot fail.
        let _ = write!(message, "\n  {line} | {}", content.trim_end());
    }
    if !hint.is_empty() {
        let _ = write!(message, "\n{hint}");
    }
    anyhow!(message)
}
