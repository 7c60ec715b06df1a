//! Reads the board's settings without changing them.

use super::{Board, File};
use crate::cli::{answer, print, print_json};
use anyhow::Result;
use serde::Serialize;
use softdock_commissioning::parameters::{self, Difference, Setting, differences, missing};
use softdock_io::input::refuse_overwrite;
use softdock_io::output::write_whole;
use softdock_io::port::serial_ports;
use softdock_io::say;
use softdock_report::{Cell, Column, Table};
use std::path::Path;

/// The ports of this computer.
pub(super) fn ports(json: bool) -> Result<()> {
    let ports = serial_ports()?;
    if json {
        return print_json(&serde_json::json!({ "ports": ports }));
    }
    if ports.is_empty() {
        say!("no serial port: is the board plugged in (CN1, ST-Link)?");
        return Ok(());
    }
    let mut table = Table::new(vec![Column::text("Port"), Column::text("Device")]);
    for found in &ports {
        table.push(vec![Cell::text(&found.port), Cell::text(&found.device)]);
    }
    print(&table.to_string())
}

/// The answer of `get`.
#[derive(Serialize)]
struct Got<'a> {
    name: &'a str,
    value: &'a parameters::OwnedValue,
    unit: &'a str,
}

impl Board {
    pub(super) fn print_list(&mut self) -> Result<()> {
        let settings = self.settings()?;
        let mut table = Table::new(vec![
            Column::text("Name"),
            Column::text("Value"),
            Column::text("Unit"),
            Column::text("Allowed"),
            Column::text("Meaning"),
        ]);
        for setting in &settings {
            table.push(vec![
                Cell::text(&setting.name),
                Cell::text(setting.value.to_string()),
                Cell::text(&setting.unit),
                Cell::text(setting.allowed()),
                Cell::text(setting.meaning()),
            ]);
        }
        let document = serde_json::json!({ "settings": settings });
        answer(self.json, &document, || table.to_string())
    }

    pub(super) fn get(&mut self, name: &str) -> Result<()> {
        let settings = self.settings()?;
        let setting = settings.iter().find(|setting| setting.name == name);
        let setting = setting.ok_or_else(|| missing(name, &settings))?;
        let Setting {
            name, value, unit, ..
        } = setting;
        answer(self.json, &Got { name, value, unit }, || {
            format!("{}\n", format!("{value} {unit}").trim_end())
        })
    }

    pub(super) fn dump(&mut self, output: Option<&Path>, force: bool) -> Result<()> {
        if let Some(path) = output {
            refuse_overwrite(path, force)?;
        }
        let settings = self.settings()?;
        let identity = self.client.identity();
        let head = format!(
            "Settings of {} (schema {:08x})",
            identity.text, identity.schema
        );
        let text = parameters::write(&settings, &head);
        if let Some(path) = output {
            write_whole(path, &text)?;
            say!("{} settings in {}", settings.len(), path.display());
        }
        match (self.json, output) {
            (true, _) => print_json(&serde_json::json!({ "settings": settings })),
            (false, None) => print(&text),
            (false, Some(_)) => Ok(()),
        }
    }

    pub(super) fn diff(&mut self, file: &File) -> Result<()> {
        let found = self.differences(file)?;
        if self.json {
            return print_json(&serde_json::json!({ "differences": found }));
        }
        if found.is_empty() {
            say!("no difference");
            return Ok(());
        }
        print(&table(&found, "File"))
    }

    /// Settings that a file would change.
    pub(super) fn differences(&mut self, file: &File) -> Result<Vec<Difference>> {
        let settings = self.settings()?;
        let wanted = parameters::read(&file.file, &settings, !file.keep)?;
        differences(&settings, &wanted)
    }
}

/// Table of the differences for the terminal.
pub(super) fn table(differences: &[Difference], wanted: &str) -> String {
    let mut table = Table::new(vec![
        Column::text("Name"),
        Column::text("Board"),
        Column::text(wanted),
        Column::text("Unit"),
    ]);
    for difference in differences {
        table.push(vec![
            Cell::text(&difference.name),
            Cell::text(difference.board.to_string()),
            Cell::text(difference.wanted.to_string()),
            Cell::text(&difference.unit),
        ]);
    }
    table.to_string()
}
