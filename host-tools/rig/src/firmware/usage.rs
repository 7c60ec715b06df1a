//! Memory of a chip that a program takes: by region, section and task.
//!
//! A link-time optimised program knows no tasks any more, but it still calls. From each task's poll
//! function everything is followed that it mentions. What is reached from one task only would go
//! away with it; what several reach, or the start and the interrupts, is shared.

use super::image::{Piece, holder};
use super::{Elf, Region};
use serde::Serialize;
use std::cmp::Reverse;
use std::collections::BTreeMap;

/// Statics that are listed, the largest ones.
const LISTED_STATICS: usize = 8;

/// Memory that a program takes.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Usage {
    /// Each region of the chip.
    pub regions: Vec<RegionUsage>,
    /// What each task takes, those with most RAM first.
    pub tasks: Vec<TaskUsage>,
    /// Code and constants of several tasks, or of the start and the interrupts, bytes.
    pub shared_flash: u64,
    /// The largest other statics in RAM.
    pub statics: Vec<NamedSize>,
}

/// A region and what lies in it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct RegionUsage {
    /// The region.
    #[serde(flatten)]
    pub region: Region,
    /// Bytes that are taken.
    pub used: u64,
    /// Its sections, with their sizes.
    pub sections: Vec<NamedSize>,
}

/// A task and what it takes, bytes.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct TaskUsage {
    /// Its name.
    pub name: String,
    /// State, with all futures in it.
    pub ram: u64,
    /// Code and constants that nothing else reaches.
    pub flash: u64,
}

/// Something that takes memory.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct NamedSize {
    /// Its name.
    pub name: String,
    /// Bytes.
    pub bytes: u64,
}

/// Memory of a chip's regions that a program takes.
pub fn usage(elf: &Elf, regions: &[Region]) -> Usage {
    let (mut flash, shared_flash) = reached(elf);
    let mut tasks = Vec::new();
    let mut statics = Vec::new();
    let mut in_ram: Vec<&Piece> = elf.symbols.iter().filter(|s| s.writable).collect();
    in_ram.sort_by_key(|symbol| (Reverse(symbol.bytes), &symbol.name));
    for symbol in in_ram {
        // Embassy keeps a task's state in a static of this name.
        match symbol.name.strip_suffix("::POOL") {
            Some(task) => tasks.push(TaskUsage {
                name: task.to_owned(),
                ram: symbol.bytes,
                flash: flash.remove(task).unwrap_or_default(),
            }),
            None => statics.push(named(symbol, "")),
        }
    }
    statics.truncate(LISTED_STATICS);
    Usage {
        regions: regions.iter().map(|r| region_usage(elf, r)).collect(),
        tasks,
        shared_flash,
        statics,
    }
}

fn named(piece: &Piece, suffix: &str) -> NamedSize {
    NamedSize {
        name: format!("{}{suffix}", piece.name),
        bytes: piece.bytes,
    }
}

fn region_usage(elf: &Elf, region: &Region) -> RegionUsage {
    let inside = elf.sections.iter().filter(|s| region.contains(s.address));
    let mut sections: Vec<NamedSize> = inside.map(|section| named(section, "")).collect();
    // What is loaded into RAM lies in flash as well.
    if region.contains(elf.entry) {
        let copied = elf.sections.iter().filter(|s| s.loaded && s.writable);
        sections.extend(copied.map(|section| named(section, " (initial values)")));
    }
    RegionUsage {
        region: region.clone(),
        used: sections.iter().map(|section| section.bytes).sum(),
        sections,
    }
}

/// Bytes of flash that each task alone reaches, by its name, and all the rest.
fn reached(elf: &Elf) -> (BTreeMap<String, u64>, u64) {
    let symbols = &elf.symbols;
    let mut mentions = vec![Vec::new(); symbols.len()];
    let mut called = vec![false; symbols.len()];
    for mention in &elf.mentions {
        let places = (holder(symbols, mention.at), holder(symbols, mention.to));
        if let (Some(from), Some(to)) = places {
            mentions[from].push(to);
            called[to] |= from != to;
        }
    }
    let task: Vec<Option<String>> = symbols.iter().map(|s| task_of_poll(&s.name)).collect();
    // What is mentioned, directly or not, but not through a task, which runs for itself.
    let reach = |mut open: Vec<usize>| {
        let mut seen = vec![false; symbols.len()];
        while let Some(node) = open.pop() {
            if !std::mem::replace(&mut seen[node], true) {
                open.extend(mentions[node].iter().filter(|next| task[**next].is_none()));
            }
        }
        seen
    };
    let nodes = 0..symbols.len();
    let own: Vec<_> = nodes
        .clone()
        .filter_map(|n| Some((task[n].as_ref()?, reach(vec![n]))))
        .collect();
    // Symbols that are not called: the vector table above all.
    let elsewhere = reach(
        nodes
            .clone()
            .filter(|n| !called[*n] && task[*n].is_none())
            .collect(),
    );
    let mut shared = 0;
    let mut tasks = BTreeMap::new();
    for node in nodes.filter(|node| !symbols[*node].writable) {
        let mut users = own.iter().filter(|(_, seen)| seen[node]);
        match (users.next(), users.next(), elsewhere[node]) {
            (Some((task, _)), None, false) => {
                *tasks.entry((*task).clone()).or_default() += symbols[node].bytes;
            }
            _ => shared += symbols[node].bytes,
        }
    }
    (tasks, shared)
}

/// The name of a task, of its poll function:
/// `<embassy_executor::raw::TaskStorage<board::__blink_task::__blink_task_inner_function::{closure#0}>>::poll`
/// is that of `board::blink`.
pub(super) fn task_of_poll(symbol: &str) -> Option<String> {
    let future = symbol.strip_prefix("<embassy_executor::raw::TaskStorage<")?;
    let (module, rest) = future.strip_suffix(">>::poll")?.split_once("::__")?;
    Some(format!("{module}::{}", rest.split_once("_task::")?.0))
}

#[cfg(test)]
mod tests {
    use super::super::image::Mention;
    use super::*;

    fn piece(name: &str, address: u64, bytes: u64, loaded: bool, writable: bool) -> Piece {
        Piece {
            name: name.to_owned(),
            address,
            bytes,
            loaded,
            writable,
        }
    }

    #[test]
    fn each_byte_of_flash_is_a_tasks_own_or_shared_and_initial_values_count_twice() {
        let poll = |task: &str| {
            let future =
                format!("board::__{task}_task::__{task}_task_inner_function::{{closure#0}}");
            format!("<embassy_executor::raw::TaskStorage<{future}>>::poll")
        };
        let in_flash = |name: &str, address| piece(name, address, 4, true, false);
        let region = |name: &str, origin| Region {
            name: name.to_owned(),
            origin,
            length: 1000,
        };
        let elf = Elf {
            entry: 0x100,
            sections: vec![
                piece(".text", 0x100, 300, true, false),
                piece(".data", 0x2000, 20, true, true),
                piece(".bss", 0x2014, 100, false, true),
            ],
            symbols: vec![
                in_flash("vectors", 0x100),
                in_flash(&poll("blink"), 0x104),
                in_flash("only_blink", 0x108),
                in_flash(&poll("serve"), 0x10c),
                in_flash("only_serve", 0x110),
                in_flash("both", 0x114),
                piece("board::SHARED", 0x2000, 20, true, true),
                piece("board::blink::POOL", 0x2014, 60, false, true),
            ],
            mentions: [
                (0x100, 0x104), // starts the first task
                (0x104, 0x108),
                (0x108, 0x114),
                (0x10c, 0x110),
                (0x110, 0x114),
            ]
            .map(|(at, to)| Mention { at, to, call: true })
            .to_vec(),
            ..Elf::default()
        };
        let usage = usage(&elf, &[region("FLASH", 0x100), region("RAM", 0x2000)]);
        let used: Vec<u64> = usage.regions.iter().map(|region| region.used).collect();
        assert_eq!(used, [320, 120]);
        let [task] = &usage.tasks[..] else { panic!() };
        assert_eq!(
            (task.name.as_str(), task.ram, task.flash),
            ("board::blink", 60, 8)
        );
        assert_eq!(usage.shared_flash, 8, "vectors, and what both reach");
        assert_eq!(usage.statics[0].name, "board::SHARED");
    }
}
