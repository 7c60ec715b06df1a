//! Call graph of a program, and the path with the deepest stack from a function.

use super::Elf;
use super::image::holder;
use super::usage::task_of_poll;
use anyhow::{Context, Result};
use std::cell::RefCell;

/// Call graph; functions are indices of a program's symbols.
pub(super) struct CallGraph<'a> {
    elf: &'a Elf,
    calls: Vec<Vec<usize>>,
    /// Deepest path from each function, once it has been computed.
    ways: RefCell<Vec<Seen>>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Seen {
    Not,
    /// Being computed: a call to it from here is a recursion.
    Open,
    /// Stack of the deepest path, bytes, and the next function on it.
    Done(u64, Option<usize>),
}

/// A path through the call graph.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Way {
    pub(super) bytes: u64,
    /// Functions on the path, with their frames, bytes.
    pub(super) path: Vec<(String, u64)>,
}

impl<'a> CallGraph<'a> {
    pub(super) fn of(elf: &'a Elf) -> Self {
        let mut calls = vec![Vec::new(); elf.symbols.len()];
        for mention in elf.mentions.iter().filter(|mention| mention.call) {
            let (from, to) = (
                holder(&elf.symbols, mention.at),
                holder(&elf.symbols, mention.to),
            );
            if let (Some(from), Some(to)) = (from, to) {
                calls[from].push(to);
            }
        }
        Self {
            elf,
            ways: RefCell::new(vec![Seen::Not; calls.len()]),
            calls,
        }
    }

    /// The function of a name; one that is not mangled.
    pub(super) fn named(&self, name: &str) -> Result<usize> {
        let found = self
            .elf
            .symbols
            .iter()
            .position(|symbol| symbol.name == name);
        found.with_context(|| format!("the program has no function {name}"))
    }

    /// The poll functions of tasks, with the names of the tasks.
    pub(super) fn tasks(&self) -> Vec<(usize, String)> {
        let symbols = self.elf.symbols.iter().enumerate();
        symbols
            .filter_map(|(node, symbol)| Some((node, task_of_poll(&symbol.name)?)))
            .collect()
    }

    /// Functions whose address is mentioned other than by a call, either in the section `.vector_table` or everywhere else.
    pub(super) fn named_as_address(&self, in_vectors: bool) -> Vec<usize> {
        let vectors = self.elf.sections.iter().find(|s| s.name == ".vector_table");
        let is_vector =
            |at: u64| vectors.is_some_and(|v| (v.address..v.address + v.bytes).contains(&at));
        let symbols = &self.elf.symbols;
        let mut found: Vec<usize> = self
            .elf
            .mentions
            .iter()
            .filter(|mention| !mention.call && is_vector(mention.at) == in_vectors)
            .filter_map(|mention| {
                holder(symbols, mention.to).filter(|to| symbols[*to].address == mention.to)
            })
            .filter(|node| self.elf.frames.contains_key(&symbols[*node].address))
            .collect();
        found.sort_unstable();
        found.dedup();
        found
    }

    /// The name of a function.
    pub(super) fn name(&self, node: usize) -> &str {
        &self.elf.symbols[node].name
    }

    /// Stack frame of a function, bytes.
    pub(super) fn frame(&self, node: usize) -> u64 {
        let address = self.elf.symbols[node].address;
        self.elf.frames.get(&address).copied().unwrap_or_default()
    }

    /// Deepest path that begins with one of some functions. A recursion counts once.
    pub(super) fn deepest(&self, from: impl IntoIterator<Item = usize>) -> Way {
        let best = from.into_iter().max_by_key(|node| self.depth(*node));
        let mut way = Way::default();
        let mut next = best;
        while let Some(node) = next {
            way.bytes += self.frame(node);
            way.path
                .push((self.name(node).to_owned(), self.frame(node)));
            next = match self.ways.borrow()[node] {
                Seen::Done(_, next) => next,
                Seen::Not | Seen::Open => None,
            };
        }
        way
    }

    fn depth(&self, node: usize) -> u64 {
        match self.ways.borrow()[node] {
            Seen::Done(bytes, _) => return bytes,
            Seen::Open => return 0,
            Seen::Not => {}
        }
        self.ways.borrow_mut()[node] = Seen::Open;
        let below = self.calls[node]
            .iter()
            .map(|to| (self.depth(*to), *to))
            .max();
        let below = below.filter(|(_, to)| self.ways.borrow()[*to] != Seen::Open);
        let bytes = self.frame(node) + below.map_or(0, |(bytes, _)| bytes);
        self.ways.borrow_mut()[node] = Seen::Done(bytes, below.map(|(_, to)| to));
        bytes
    }
}
