//! `softdock firmware`: build the board's image and say what it takes.

use super::{print, print_json};
use anyhow::{Context, Result};
use clap::Args;
use serde::Serialize;
use softdock_io::say;
use softdock_report::{Cell, Column, Format, Table};
use softdock_rig::firmware::{
    Elf, RELEASED, SensorLink, StackUsage, Usage, build, nucleo_executors, nucleo_h743zi, regions,
    repository, stack, usage,
};
use std::fmt::Write;
use std::path::PathBuf;

/// Build the image for the NUCLEO-H743ZI2 and say what it takes of flash and RAM.
///
/// Per region and section, per task (RAM: everything that it holds while it waits; flash: what is
/// reached from no other task, found by following calls and addresses in the machine code), and the
/// largest statics. Then the stack: how deep each executor and the interrupts can get by the call graph,
/// and what that comes to when each interrupts the one below at its deepest; above 80 % of what there
/// is, the command fails. `softdock flash` writes the image to the board.
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
    stack: StackUsage,
}

impl Firmware {
    pub(super) fn execute(self) -> Result<()> {
        let image = build(&nucleo_h743zi(self.sensor), RELEASED)?;
        let script = repository()?.join("memory.x");
        let regions = std::fs::read_to_string(&script)
            .map_err(anyhow::Error::from)
            .and_then(|script| regions(&script))
            .with_context(|| script.display().to_string())?;
        let elf = Elf::open(&image)?;
        let available = regions.iter().find(|region| region.name == "STACK");
        let available = available.context("memory.x has no region STACK")?.length;
        let built = Built {
            usage: usage(&elf, &regions),
            stack: stack(&elf, &nucleo_executors(self.sensor), available)?,
            image,
        };
        if self.json {
            print_json(&built)?;
        } else {
            print(&tables(&built.usage)?)?;
            print(&format!("\n{}", stack_table(&built.stack)))?;
            say!("image: {}", built.image.display());
        }
        built.stack.ensure_fits()
    }
}

/// Stack of each executor and interrupt level, and their sum when they nest at their deepest.
fn stack_table(stack: &StackUsage) -> Table {
    let mut table = Table::new(vec![
        Column::text("Stack"),
        Column::text("Most of it for"),
        Column::number("Deepest", "bytes"),
        Column::number("Share", "%"),
    ]);
    let mut row = |name: &str, most: &str, deep: u64| {
        let share = 100.0 * deep as f64 / stack.available as f64;
        table.push(vec![
            Cell::text(name),
            Cell::text(most),
            bytes(deep),
            Cell::formatted(share, Format::Fixed(1)),
        ]);
    };
    for context in stack.contexts.iter().chain([&stack.boot]) {
        row(&context.name, context.largest(), context.bytes);
    }
    row("all nested, without boot", "", stack.nested);
    table
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

/// RAM of each task, and the flash that no other task uses.
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
