//! `softdock firmware`: build the board's image and say what it takes.

use super::{print, print_json};
use anyhow::{Context, Result};
use clap::Args;
use serde::Serialize;
use softdock_report::{Cell, Column, Format, Table};
use softdock_rig::firmware::{
    Elf, RELEASED, SensorLink, Usage, build, nucleo_h743zi, regions, repository, usage,
};
use std::fmt::Write;
use std::path::PathBuf;

/// Build the image for the NUCLEO-H743ZI2 and say what it takes of flash and RAM.
///
/// Per region and section, per task (RAM: everything that it holds while it waits; flash: what is
/// reached from no other task, found by following calls and addresses in the machine code), and the
/// largest statics. `softdock flash` writes the image to the board.
#[derive(Debug, Args)]
#[command(after_help = "Example: softdock firmware")]
pub(super) struct Firmware {
    /// What the sensor is on
    #[arg(long, value_enum, default_value_t)]
    sensor: SensorLink,
    /// Print one JSON document
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Built {
    image: PathBuf,
    #[serde(flatten)]
    usage: Usage,
}

impl Firmware {
    pub(super) fn execute(self) -> Result<()> {
        let image = build(&nucleo_h743zi(self.sensor), RELEASED)?;
        let script = repository()?.join("memory.x");
        let regions = std::fs::read_to_string(&script)
            .map_err(anyhow::Error::from)
            .and_then(|script| regions(&script))
            .with_context(|| script.display().to_string())?;
        let usage = usage(&Elf::open(&image)?, &regions);
        if self.json {
            return print_json(&Built { image, usage });
        }
        print(&tables(&usage)?)?;
        eprintln!("image: {}", image.display());
        Ok(())
    }
}

fn tables(usage: &Usage) -> Result<String> {
    let mut out = String::new();
    let mut regions = Table::new(vec![
        Column::text("Region"),
        Column::text("Section"),
        Column::number("Used", "bytes"),
        Column::number("Of", "bytes"),
        Column::number("Share", "%"),
    ]);
    for region in &usage.regions {
        let share = 100.0 * region.used as f64 / region.region.length as f64;
        regions.push(vec![
            Cell::text(&region.region.name),
            Cell::text(""),
            bytes(region.used),
            bytes(region.region.length),
            Cell::formatted(share, Format::Fixed(1)),
        ]);
        for section in &region.sections {
            regions.push(vec![
                Cell::text(""),
                Cell::text(&section.name),
                bytes(section.bytes),
                Cell::text(""),
                Cell::text(""),
            ]);
        }
    }
    write!(out, "{regions}")?;
    write!(out, "\n{}", tasks(usage))?;
    let mut statics = Table::new(vec![Column::text("Static"), Column::number("RAM", "bytes")]);
    for named in &usage.statics {
        statics.push(vec![Cell::text(&named.name), bytes(named.bytes)]);
    }
    write!(out, "\n{statics}")?;
    Ok(out)
}

/// RAM of each task, and flash that would be free without it.
fn tasks(usage: &Usage) -> Table {
    let mut table = Table::new(vec![
        Column::text("Task"),
        Column::number("RAM", "bytes"),
        Column::number("Flash of its own", "bytes"),
    ]);
    for task in &usage.tasks {
        let cells = [Cell::text(&task.name), bytes(task.ram), bytes(task.flash)];
        table.push(cells.into());
    }
    table.push(vec![
        Cell::text("(several tasks, start, interrupts)"),
        Cell::text(""),
        bytes(usage.shared_flash),
    ]);
    table
}

fn bytes(count: u64) -> Cell {
    Cell::formatted(count as f64, Format::Fixed(0))
}
