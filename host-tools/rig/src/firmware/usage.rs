//! How much of a chip's memory a program takes: per region, per section, per task.

use super::image::{Section, Symbol};
use super::reach::reached;
use super::{Elf, Region};
use serde::Serialize;

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
    pub statics: Vec<Named>,
}

/// A region and what lies in it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct RegionUsage {
    /// The region.
    #[serde(flatten)]
    pub region: Region,
    /// Bytes that are taken.
    pub used: u64,
    /// By what.
    pub sections: Vec<Named>,
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
pub struct Named {
    /// Its name.
    pub name: String,
    /// Bytes.
    pub bytes: u64,
}

/// What a program takes of the regions of its chip.
pub fn usage(elf: &Elf, regions: &[Region]) -> Usage {
    let (tasks, statics): (Vec<_>, Vec<_>) = elf
        .symbols
        .iter()
        .filter(|symbol| in_ram(elf, symbol))
        .map(named)
        .partition(|named| task(&named.name).is_some());
    let mut code = reached(elf);
    let tasks = largest_first(tasks).into_iter().map(|named| {
        let name = task(&named.name).unwrap_or_default().to_owned();
        TaskUsage {
            flash: code.tasks.remove(&name).unwrap_or_default(),
            ram: named.bytes,
            name,
        }
    });
    let mut statics = largest_first(statics);
    statics.truncate(LISTED_STATICS);
    Usage {
        regions: regions.iter().map(|r| region_usage(elf, r)).collect(),
        tasks: tasks.collect(),
        shared_flash: code.shared,
        statics,
    }
}

fn region_usage(elf: &Elf, region: &Region) -> RegionUsage {
    let initial_values = |s: &&Section| s.loaded && s.writable;
    let mut sections: Vec<Named> = elf
        .sections
        .iter()
        .filter(|section| region.contains(section.address))
        .map(|section| Named {
            name: section.name.clone(),
            bytes: section.bytes,
        })
        .collect();
    // What is loaded into RAM lies in flash as well.
    if region.contains(elf.entry) {
        sections.extend(elf.sections.iter().filter(initial_values).map(|s| Named {
            name: format!("{} (initial values)", s.name),
            bytes: s.bytes,
        }));
    }
    RegionUsage {
        region: region.clone(),
        used: sections.iter().map(|section| section.bytes).sum(),
        sections,
    }
}

fn in_ram(elf: &Elf, symbol: &Symbol) -> bool {
    elf.sections
        .iter()
        .filter(|section| section.writable)
        .any(|section| (section.address..section.address + section.bytes).contains(&symbol.address))
}

fn named(symbol: &Symbol) -> Named {
    Named {
        name: format!("{:#}", rustc_demangle::demangle(&symbol.name)),
        bytes: symbol.bytes,
    }
}

/// The name of a task, of the name of the static that Embassy keeps its state in.
fn task(symbol: &str) -> Option<&str> {
    symbol.strip_suffix("::POOL")
}

fn largest_first(mut list: Vec<Named>) -> Vec<Named> {
    list.sort_by(|a, b| b.bytes.cmp(&a.bytes).then_with(|| a.name.cmp(&b.name)));
    list
}

#[cfg(test)]
mod tests {
    use super::*;

    fn section(name: &str, address: u64, bytes: u64, loaded: bool, writable: bool) -> Section {
        Section {
            name: name.to_owned(),
            address,
            bytes,
            loaded,
            writable,
        }
    }

    fn symbol(name: &str, address: u64, bytes: u64) -> Symbol {
        Symbol {
            name: name.to_owned(),
            address,
            bytes,
        }
    }

    #[test]
    fn initial_values_count_in_flash_and_in_ram() {
        let region = |name: &str, origin| Region {
            name: name.to_owned(),
            origin,
            length: 1000,
        };
        let elf = Elf {
            entry: 0x800,
            sections: vec![
                section(".text", 0x800, 300, true, false),
                section(".data", 0x2000, 20, true, true),
                section(".bss", 0x2014, 100, false, true),
            ],
            symbols: vec![
                symbol("board::robot::POOL", 0x2014, 60),
                symbol("board::SHARED", 0x2050, 30),
                symbol("board::main", 0x800, 40),
            ],
            code: Vec::new(),
        };
        let usage = usage(&elf, &[region("FLASH", 0x800), region("RAM", 0x2000)]);
        let used: Vec<u64> = usage.regions.iter().map(|region| region.used).collect();
        assert_eq!(used, [320, 120]);
        let [task] = &usage.tasks[..] else { panic!() };
        assert_eq!((task.name.as_str(), task.ram), ("board::robot", 60));
        let [shared] = &usage.statics[..] else {
            panic!()
        };
        assert_eq!((shared.name.as_str(), shared.bytes), ("board::SHARED", 30));
    }
}
