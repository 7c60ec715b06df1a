//! Settings as a board lists them.

use anyhow::{Result, anyhow};
use serde::{Serialize, Serializer};
use softdock_io::input::nearest;
use softdock_link::service::{Entry, Form, Value};
use std::fmt;

/// A value.
#[derive(Clone, Debug, PartialEq)]
pub enum OwnedValue {
    /// Yes or no.
    Flag(bool),
    /// A whole number.
    Whole(i64),
    /// A real number.
    Real(f64),
    /// A word or a text.
    Text(String),
    /// Numbers in rows.
    Array(Vec<Vec<f64>>),
}

impl OwnedValue {
    /// A value as the board tells it.
    pub fn new(value: &Value<'_>, form: Form) -> Self {
        match value {
            Value::Flag(flag) => Self::Flag(*flag),
            Value::Whole(number) => Self::Whole(*number),
            Value::Real(number) => Self::Real(*number),
            Value::Text(text) => Self::Text((*text).to_owned()),
            Value::Array(numbers) => {
                let columns = match form {
                    Form::Array { columns, .. } => columns.into(),
                    _ => numbers.len(),
                };
                let rows = numbers.chunks(columns.max(1));
                Self::Array(rows.map(<[f64]>::to_vec).collect())
            }
        }
    }

    /// As it goes to the board.
    pub fn for_board(&self) -> Value<'_> {
        match self {
            Self::Flag(flag) => Value::Flag(*flag),
            Self::Whole(number) => Value::Whole(*number),
            Self::Real(number) => Value::Real(*number),
            Self::Text(text) => Value::Text(text),
            Self::Array(rows) => Value::Array(rows.iter().flatten().copied().collect()),
        }
    }

    fn toml(&self) -> toml_edit::Value {
        match self {
            Self::Flag(flag) => (*flag).into(),
            Self::Whole(number) => (*number).into(),
            Self::Real(number) => (*number).into(),
            Self::Text(text) => text.into(),
            Self::Array(rows) => match &rows[..] {
                [row] => row.iter().copied().collect::<toml_edit::Array>().into(),
                rows => rows
                    .iter()
                    .map(|row| row.iter().copied().collect::<toml_edit::Array>())
                    .collect::<toml_edit::Array>()
                    .into(),
            },
        }
    }
}

/// As in a TOML file.
impl fmt::Display for OwnedValue {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.toml())
    }
}

impl Serialize for OwnedValue {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Flag(flag) => flag.serialize(serializer),
            Self::Whole(number) => number.serialize(serializer),
            Self::Real(number) => number.serialize(serializer),
            Self::Text(text) => text.serialize(serializer),
            Self::Array(rows) => match &rows[..] {
                [row] => row.serialize(serializer),
                rows => rows.serialize(serializer),
            },
        }
    }
}

/// A setting of a board.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Setting {
    /// Its path.
    pub name: String,
    /// The value in use.
    pub value: OwnedValue,
    /// Unit; empty: none.
    pub unit: String,
    /// The firmware's default.
    pub default: OwnedValue,
    /// Smallest and largest number, beside the other settings in use.
    pub range: Option<(f64, f64)>,
    /// The words that it may be.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub words: Vec<String>,
    /// What it means.
    pub help: String,
    /// Which values it takes.
    #[serde(skip)]
    pub form: Form,
}

impl From<Entry<'_>> for Setting {
    fn from(entry: Entry<'_>) -> Self {
        let lines: Vec<&str> = entry.help.lines().map(str::trim).collect();
        Self {
            name: entry.path.into(),
            value: OwnedValue::new(&entry.value, entry.form),
            unit: entry.unit.into(),
            default: OwnedValue::new(&entry.default, entry.form),
            range: entry.range,
            words: entry.words.iter().map(|word| (*word).into()).collect(),
            help: lines.join("\n"),
            form: entry.form,
        }
    }
}

impl Setting {
    /// "0.001 to 0.02", "one of ati, sri", "true or false".
    pub fn allowed(&self) -> String {
        match (self.form, self.range) {
            (_, Some((low, high))) => format!("{low} to {high}"),
            (Form::Word, _) => format!("one of {}", self.words.join(", ")),
            (Form::Flag, _) => "true or false".into(),
            (Form::Text, _) => "text".into(),
            _ => String::new(),
        }
    }

    /// What it means, in one sentence without a full stop.
    pub fn meaning(&self) -> String {
        first_sentence(&self.help)
    }

    /// A value for this setting.
    ///
    /// # Errors
    /// It takes other values; says which, and which word was probably meant.
    pub fn value(&self, given: &toml_edit::Value) -> Result<OwnedValue> {
        let number = |value: &toml_edit::Value| {
            let whole = value.as_integer().map(|number| number as f64);
            value.as_float().or(whole)
        };
        let row = |value: &toml_edit::Value| -> Option<Vec<f64>> {
            value.as_array()?.iter().map(number).collect()
        };
        let found = match self.form {
            Form::Flag => given.as_bool().map(OwnedValue::Flag),
            Form::Whole => given.as_integer().map(OwnedValue::Whole),
            Form::Real => number(given).map(OwnedValue::Real),
            Form::Text => given.as_str().map(|text| OwnedValue::Text(text.into())),
            Form::Word => match given.as_str() {
                Some(word) => return self.word(word),
                None => None,
            },
            Form::Array { rows, columns } => {
                let rows_of = || match rows {
                    1 => row(given).map(|row| vec![row]),
                    _ => given.as_array()?.iter().map(row).collect(),
                };
                let (rows, columns) = (usize::from(rows), usize::from(columns));
                let fits = |found: &Vec<Vec<f64>>| {
                    found.len() == rows && found.iter().all(|row| row.len() == columns)
                };
                rows_of().filter(fits).map(OwnedValue::Array)
            }
        };
        found.ok_or_else(|| {
            let given = given.to_string();
            anyhow!(
                "`{}` takes {}; found {}",
                self.name,
                self.takes(),
                given.trim()
            )
        })
    }

    fn word(&self, word: &str) -> Result<OwnedValue> {
        if self.words.iter().any(|known| known == word) {
            return Ok(OwnedValue::Text(word.into()));
        }
        let offer = match nearest(word, self.words.iter().map(String::as_str)) {
            Some(near) => format!("did you mean `{near}`?"),
            None => format!("it is {}", self.allowed()),
        };
        Err(anyhow!("`{}` does not know `{word}`; {offer}", self.name))
    }

    /// In words which values it takes.
    fn takes(&self) -> String {
        match self.form {
            Form::Flag => "true or false".into(),
            Form::Whole => format!("a whole number, {}", self.allowed()),
            Form::Real => format!("a number, {}", self.allowed()),
            Form::Text => "text in quotes".into(),
            Form::Word => self.allowed(),
            Form::Array { rows: 1, columns } => format!("a list of {columns} numbers"),
            Form::Array { rows, columns } => {
                format!("a list of {rows} lists of {columns} numbers")
            }
        }
    }
}

/// The error for a name that a board does not have.
pub fn missing<'a>(name: &str, settings: impl IntoIterator<Item = &'a Setting>) -> anyhow::Error {
    let names: Vec<&str> = settings.into_iter().map(|s| s.name.as_str()).collect();
    // The last part alone is often right.
    let end = format!(".{name}");
    let by_end = names.iter().find(|known| known.ends_with(&end)).copied();
    match by_end.or_else(|| nearest(name, names.iter().copied())) {
        Some(near) => anyhow!("the board has no setting `{name}`; did you mean `{near}`?"),
        None => anyhow!("the board has no setting `{name}`; `softdock params list` shows all"),
    }
}

/// The first sentence of a text of several lines, without its full stop.
fn first_sentence(text: &str) -> String {
    let lines = text.lines().take_while(|line| !line.is_empty());
    let paragraph = lines.collect::<Vec<_>>().join(" ");
    let begins = |at: &usize| paragraph[at + 2..].starts_with(char::is_uppercase);
    let mut stops = paragraph.match_indices(". ").map(|(at, _)| at);
    let end = stops.find(begins).unwrap_or(paragraph.len());
    paragraph[..end].trim_end_matches('.').to_owned()
}

#[cfg(test)]
mod tests {
    use super::first_sentence;

    #[test]
    fn a_sentence_goes_over_lines() {
        let help = "Speed above which a motion\nis cut, 0.5 m/s.\nThe robot has a limit of its own.\n\nSee 3.2.";
        assert_eq!(
            first_sentence(help),
            "Speed above which a motion is cut, 0.5 m/s"
        );
        assert_eq!(first_sentence("Mass.\n\nOf K."), "Mass");
        assert_eq!(first_sentence(""), "");
    }
}
