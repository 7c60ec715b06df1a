//! Changing a `model.toml` and leaving everything else in it as its author wrote it.
//!
//! A change is the difference of two [`Model`]s. It is carried over to the text number by number, and the new text is parsed
//! before it is written: a file that would not give the intended model is never written.

mod merge;

use super::Model;
use anyhow::{Context, Result, bail, ensure};
use softdock_io::output::write_whole;
use std::path::{Path, PathBuf};

/// Significant digits of fitted values: a thousandth of the narrowest confidence interval that any log gives.
const DIGITS: usize = 7;
/// Unchanged lines around a change in [`Edited::difference`].
const CONTEXT_LINES: usize = 3;

/// A fitted value as written to a model file: rounded to the significant digits.
pub fn rounded(value: f64) -> f64 {
    format!("{value:.*e}", DIGITS - 1).parse().unwrap_or(value)
}

/// A model file that is to be changed.
#[derive(Clone, Debug)]
pub struct ModelFile {
    path: PathBuf,
    text: String,
    model: Model,
}

/// A model file with its new text, not written yet.
#[derive(Clone, Debug)]
pub struct Edited<'a> {
    file: &'a ModelFile,
    text: String,
}

impl ModelFile {
    /// Reads a model file.
    ///
    /// # Errors
    ///
    /// Those of [`Model::load`].
    pub fn open(path: &Path) -> Result<Self> {
        let model = Model::load(path)?;
        let text = read(path)?;
        Ok(Self {
            path: path.to_owned(),
            text,
            model,
        })
    }

    /// The model in the file.
    pub fn model(&self) -> &Model {
        &self.model
    }

    /// The file with the differences between its model and `after` carried over.
    ///
    /// # Errors
    ///
    /// A model that a file cannot hold: values out of range or not finite.
    pub fn edited(&self, after: &Model) -> Result<Edited<'_>> {
        let text = with_its_line_ends(&self.text, |text| merge::merge(text, &self.model, after))?;
        self.checked(text, after)
    }

    /// The file without an effect.
    ///
    /// # Errors
    ///
    /// An effect that is not in the file; the error names those that are.
    pub fn without_effect(&self, id: &str) -> Result<Edited<'_>> {
        let mut after = self.model.clone();
        after.effects.retain(|effect| effect.id != id);
        if after.effects.len() == self.model.effects.len() {
            let ids: Vec<&str> = after.effects.iter().map(|e| e.id.as_str()).collect();
            let there = match &ids[..] {
                [] => "it has no effects".to_owned(),
                ids => format!("its effects are {}", ids.join(", ")),
            };
            bail!("{}: `{id}` is not in it; {there}", self.path.display());
        }
        let text = with_its_line_ends(&self.text, |text| merge::without_effect(text, id))?;
        self.checked(text, &after)
    }

    /// The file with another text: one that it had before.
    ///
    /// # Errors
    ///
    /// A text that is no model.
    pub fn with_text(&self, text: String) -> Result<Edited<'_>> {
        Model::from_toml(&text, &self.path.display().to_string())?;
        Ok(Edited { file: self, text })
    }

    /// Its text.
    pub fn text(&self) -> &str {
        &self.text
    }

    fn checked(&self, text: String, after: &Model) -> Result<Edited<'_>> {
        let name = self.path.display().to_string();
        let written = Model::from_toml(&text, &name)
            .context("the change does not fit into the model file; nothing was written")?;
        ensure!(
            written == *after,
            "{name}: its text cannot take the change (is a section written in an unusual form?); \
             nothing was written"
        );
        Ok(Edited { file: self, text })
    }
}

impl Edited<'_> {
    /// The new text.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Difference to the file as a unified diff; empty if there is none.
    pub fn difference(&self) -> String {
        let name = self.file.path.display().to_string();
        similar::TextDiff::from_lines(&self.file.text, &self.text)
            .unified_diff()
            .context_radius(CONTEXT_LINES)
            .header(&name, &format!("{name} (changed)"))
            .to_string()
    }

    /// Replaces the file in one step: a reader sees the old text or the new one, never a part.
    ///
    /// # Errors
    ///
    /// The file was changed by somebody else in the meantime, or cannot be replaced.
    pub fn save(&self) -> Result<()> {
        replace(&self.file.path, &self.file.text, &self.text)
    }
}

/// Replaces the text of a file in one step, if it is still the text that was read.
///
/// # Errors
///
/// The file was changed by somebody else in the meantime, or cannot be replaced.
pub fn replace(path: &Path, before: &str, after: &str) -> Result<()> {
    if read(path)? != before {
        bail!(
            "{} was changed by another program in the meantime and is left as it is; run the \
             command again",
            path.display()
        );
    }
    write_whole(path, after)
}

fn read(path: &Path) -> Result<String> {
    std::fs::read_to_string(path).with_context(|| format!("cannot read {}", path.display()))
}

/// Edits a text with `\n` as line end, and restores the text's own line ends.
pub fn with_its_line_ends(text: &str, edit: impl FnOnce(&str) -> Result<String>) -> Result<String> {
    if !text.contains("\r\n") {
        return edit(text);
    }
    Ok(edit(&text.replace("\r\n", "\n"))?.replace('\n', "\r\n"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seven_digits_are_kept() {
        for (value, expected) in [
            (1.512_384_123_4, 1.512_384),
            (-0.000_012_345_678_9, -0.000_012_345_68),
            (4.0e9 / 3.0, 1.333_333e9),
            (0.0, 0.0),
        ] {
            assert_eq!(rounded(value), expected);
        }
        assert!(rounded(f64::NAN).is_nan());
    }
}
