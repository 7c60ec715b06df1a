//! Flash that each task needs: the code and constants that are reached from the task alone.
//!
//! A link-time optimised program knows no tasks any more, but it still calls. From each task's poll
//! function everything is followed that it mentions, directly or through constants such as the
//! tables of methods. What is reached from one task only would go away with it; what several reach,
//! or the start and the interrupts, is shared.

use super::Elf;
use super::image::Symbol;
use super::thumb::mentioned;
use std::collections::{BTreeMap, BTreeSet};

/// Flash of a program by who needs it, bytes.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Reached {
    /// By the task's name: what no other task reaches.
    pub(super) tasks: BTreeMap<String, u64>,
    /// What more than one task reaches, or the start and the interrupts.
    pub(super) shared: u64,
}

/// Follows the program from each task, and from all else that nobody calls.
pub(super) fn reached(elf: &Elf) -> Reached {
    let graph = Graph::new(elf);
    let tasks: BTreeMap<usize, String> = graph
        .symbols
        .iter()
        .enumerate()
        .filter_map(|(node, symbol)| Some((node, task_of_poll(&symbol.name)?)))
        .collect();
    let own: Vec<(&str, BTreeSet<usize>)> = tasks
        .iter()
        .map(|(&node, name)| (name.as_str(), graph.from([node], &tasks)))
        .collect();
    let roots = graph.uncalled().filter(|node| !tasks.contains_key(node));
    let elsewhere = graph.from(roots, &tasks);
    let mut found = Reached::default();
    for (node, symbol) in graph.symbols.iter().enumerate() {
        let mut users = own.iter().filter(|(_, nodes)| nodes.contains(&node));
        match (users.next(), users.next(), elsewhere.contains(&node)) {
            (Some((task, _)), None, false) => {
                *found.tasks.entry((*task).to_owned()).or_default() += symbol.bytes;
            }
            _ => found.shared += symbol.bytes,
        }
    }
    found
}

/// The name of a task, of its poll function:
/// `<embassy_executor::raw::TaskStorage<board::__blink_task::__blink_task_inner_function::{closure#0}>>::poll`
/// is that of `board::blink`.
fn task_of_poll(symbol: &str) -> Option<String> {
    let name = format!("{:#}", rustc_demangle::demangle(symbol));
    let future = name
        .strip_prefix("<embassy_executor::raw::TaskStorage<")?
        .strip_suffix(">>::poll")?;
    let (module, rest) = future.split_once("::__")?;
    Some(format!("{module}::{}", rest.split_once("_task::")?.0))
}

/// Functions and constants in flash, and which of them mention which.
struct Graph<'a> {
    /// Sorted by address.
    symbols: Vec<&'a Symbol>,
    mentions: Vec<Vec<usize>>,
}

impl<'a> Graph<'a> {
    fn new(elf: &'a Elf) -> Self {
        let mut symbols: Vec<&Symbol> = elf
            .symbols
            .iter()
            .filter(|s| elf.code.iter().any(|code| code.contains(s.address)))
            .collect();
        // Functions with equal code are one piece of flash with several names.
        symbols.sort_by_key(|s| (s.address & !1, std::cmp::Reverse(s.bytes)));
        symbols.dedup_by_key(|s| s.address & !1);
        let mut mentions = vec![Vec::new(); symbols.len()];
        for code in &elf.code {
            for (address, bytes, holds) in code.stretches() {
                let mut rest = bytes;
                let mut at = address;
                while let Some(stop) = (!rest.is_empty()).then(|| end_within(&symbols, at, rest)) {
                    let (part, after) = rest.split_at(stop);
                    if let Some(node) = holder(&symbols, at) {
                        let found = mentioned(at, part, holds).into_iter();
                        mentions[node].extend(found.filter_map(|a| holder(&symbols, a)));
                    }
                    at += stop as u64;
                    rest = after;
                }
            }
        }
        Self { symbols, mentions }
    }

    /// What is mentioned from the roots, and by what is mentioned; not through a task, which runs for
    /// itself.
    fn from(
        &self,
        roots: impl IntoIterator<Item = usize>,
        tasks: &BTreeMap<usize, String>,
    ) -> BTreeSet<usize> {
        let mut open: Vec<usize> = roots.into_iter().collect();
        let mut seen: BTreeSet<usize> = open.iter().copied().collect();
        while let Some(node) = open.pop() {
            for &next in &self.mentions[node] {
                if !tasks.contains_key(&next) && seen.insert(next) {
                    open.push(next);
                }
            }
        }
        seen
    }

    /// What no other symbol mentions: the vector table above all.
    fn uncalled(&self) -> impl Iterator<Item = usize> {
        let mut called = vec![false; self.symbols.len()];
        for (node, mentions) in self.mentions.iter().enumerate() {
            for &next in mentions {
                called[next] |= next != node;
            }
        }
        (0..called.len()).filter(move |&node| !called[node])
    }
}

/// The symbol that an address lies in.
fn holder(symbols: &[&Symbol], address: u64) -> Option<usize> {
    let after = symbols.partition_point(|s| s.address & !1 <= address);
    let node = after.checked_sub(1)?;
    let symbol = symbols[node];
    (address < (symbol.address & !1) + symbol.bytes).then_some(node)
}

/// Bytes up to the end of the symbol at `at`, or to the next symbol if there is none.
fn end_within(symbols: &[&Symbol], at: u64, rest: &[u8]) -> usize {
    let end = match holder(symbols, at) {
        Some(node) => (symbols[node].address & !1) + symbols[node].bytes,
        None => {
            let next = symbols.partition_point(|s| s.address & !1 <= at);
            symbols.get(next).map_or(u64::MAX, |s| s.address & !1)
        }
    };
    usize::try_from(end - at)
        .unwrap_or(usize::MAX)
        .min(rest.len())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::firmware::image::Code;
    use crate::firmware::thumb::Holds;

    const BLINK: &str = "<embassy_executor::raw::TaskStorage<board::__blink_task::__blink_task_inner_function::{closure#0}>>::poll";
    const SERVE: &str = "<embassy_executor::raw::TaskStorage<board::__serve_task::__serve_task_inner_function::{closure#0}>>::poll";

    /// Words that are addresses: symbols of 4 bytes at 0x100, 0x104 ..
    fn program(symbols: &[(&str, u64)]) -> Elf {
        let words = symbols
            .iter()
            .flat_map(|(_, to)| (*to as u32).to_le_bytes());
        let symbols = symbols.iter().enumerate().map(|(n, (name, _))| Symbol {
            name: (*name).to_owned(),
            address: 0x100 + 4 * n as u64,
            bytes: 4,
        });
        Elf {
            entry: 0x100,
            sections: Vec::new(),
            symbols: symbols.collect(),
            code: vec![Code {
                address: 0x100,
                bytes: words.collect(),
                marks: vec![(0x100, Holds::Data)],
            }],
        }
    }

    #[test]
    fn what_one_task_reaches_is_that_tasks_and_the_rest_is_shared() {
        let elf = program(&[
            ("vectors", 0x104), // starts the first task
            (BLINK, 0x109),     // a Thumb function
            ("only_blink", 0x114),
            (SERVE, 0x110),
            ("only_serve", 0x114),
            ("both", 0),
        ]);
        let found = reached(&elf);
        let task = |name: &str, bytes| (name.to_owned(), bytes);
        let tasks = [task("board::blink", 8), task("board::serve", 8)];
        assert_eq!(found.tasks, tasks.into());
        assert_eq!(found.shared, 8);
    }

    #[test]
    fn other_names_are_no_tasks() {
        assert_eq!(task_of_poll(BLINK).as_deref(), Some("board::blink"));
        assert_eq!(task_of_poll("board::blink"), None);
    }
}
