//! New settings for the board.

use super::{Board, Confirm, File, show};
use crate::cli::agree::agree;
use crate::cli::{print, print_json};
use anyhow::{Context, Result, ensure};
use serde::Serialize;
use softdock_commissioning::parameters::{Difference, Setting, missing};
use softdock_io::say;
use softdock_link::service::{Form, Origin};

/// Result of a change of the board's settings.
#[derive(Serialize)]
struct Changed<'a> {
    changed: &'a [Difference],
    /// Sequence number of the settings in use; None if they are the defaults.
    sequence: Option<u32>,
}

impl Board {
    pub(super) fn set(&mut self, name: &str, value: &str, confirm: &Confirm) -> Result<()> {
        let settings = self.settings()?;
        let setting = settings.iter().find(|setting| setting.name == name);
        let setting = setting.ok_or_else(|| missing(name, &settings))?;
        let wanted = setting.value(&value_of(setting, value))?;
        let difference = Difference {
            name: setting.name.clone(),
            board: setting.value.clone(),
            wanted,
            unit: setting.unit.clone(),
        };
        match difference.board == difference.wanted {
            true => self.finish(&[]),
            false => self.change(&[difference], confirm),
        }
    }

    pub(super) fn upload(&mut self, file: &File, yes: bool, confirm: &Confirm) -> Result<()> {
        let differences = self.differences(file)?;
        if differences.is_empty() {
            return self.finish(&[]);
        }
        if !self.json {
            print(&show::table(&differences, "File"))?;
        }
        if !yes {
            ensure!(
                !self.json,
                "--json asks nobody: say --yes to write {} settings",
                differences.len()
            );
            let question = format!("Write {} settings to the board?", differences.len());
            agree(
                &question,
                "not written: the board's settings are as they were",
            )?;
        }
        self.change(&differences, confirm)
    }

    pub(super) fn roll_back(&mut self, confirm: &Confirm) -> Result<()> {
        let before = self.settings()?;
        self.client
            .roll_back(confirm.confirm_within, &mut tell)
            .with_context(|| self.port.clone())?;
        let after = self.settings()?;
        let changed: Vec<Difference> = before
            .iter()
            .zip(after)
            .filter(|(before, after)| before.value != after.value)
            .map(|(before, after)| Difference {
                name: after.name,
                board: before.value.clone(),
                wanted: after.value,
                unit: after.unit,
            })
            .collect();
        if !self.json && !changed.is_empty() {
            print(&show::table(&changed, "Now"))?;
        }
        self.finish(&changed)
    }

    fn change(&mut self, differences: &[Difference], confirm: &Confirm) -> Result<()> {
        self.client
            .change(differences, confirm.confirm_within, &mut tell)
            .with_context(|| self.port.clone())?;
        self.finish(differences)
    }

    /// Reports which settings the board uses now.
    fn finish(&mut self, changed: &[Difference]) -> Result<()> {
        let sequence = match self.client.status()?.origin {
            Origin::Flash { sequence } | Origin::Trial { sequence, .. } => Some(sequence),
            Origin::Defaults { .. } => None,
        };
        if self.json {
            return print_json(&Changed { changed, sequence });
        }
        match (changed.len(), sequence) {
            (0, _) => say!("nothing to change: the board has these settings"),
            (count, Some(sequence)) => {
                say!("{count} changed, confirmed and read back: settings {sequence}");
            }
            (count, None) => say!("{count} changed: the board has no settings of its own"),
        }
        Ok(())
    }
}

fn tell(step: &str) {
    say!("{step} ..");
}

/// A value as a person types it: quotes are not needed.
fn value_of(setting: &Setting, text: &str) -> toml_edit::Value {
    let words = matches!(setting.form, Form::Text | Form::Word);
    match text.parse::<toml_edit::Value>() {
        Ok(value) if !words || value.is_str() => value,
        _ => text.into(),
    }
}
