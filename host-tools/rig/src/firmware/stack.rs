//! Worst-case depth of the stack: over the call graph of the machine code, by executor and interrupt.
//!
//! All contexts of the firmware share one stack. The deepest that it can get is while `main` sleeps in
//! its outermost frame and each executor is interrupted at its deepest by the next higher one, and the
//! highest by a device; or once at boot, when `main` starts everything with interrupts off.
//!
//! Calls through a pointer are not in the call graph. There are two kinds. An executor polls its tasks: they are given here by
//! name. Formatting of the log calls functions whose address was taken: the deepest of these is added once to each executor, and
//! to the start.

use super::Elf;
use super::call_graph::{CallGraph, Way};
use anyhow::{Result, bail, ensure};
use serde::Serialize;

/// Largest share of the stack that may ever be taken.
pub const STACK_BUDGET: f64 = 0.8;
/// What the processor saves at an interrupt: 8 words, 18 of the floating-point unit, and one to align
/// them (Armv7-M Architecture Reference Manual, B1.5.6).
const EXCEPTION_FRAME: u64 = 4 * (8 + 18 + 1);
/// The function with which the processor begins.
const START: &str = "Reset";
/// Handlers that take the whole stack for themselves, see the crate `softdock-crash`.
const NEVER_COME_BACK: [&str; 4] = ["HardFault", "MemoryManagement", "BusFault", "UsageFault"];

/// An executor of a board: the interrupt that it runs in, and its tasks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Executor {
    /// Name.
    pub name: &'static str,
    /// The handler of its interrupt.
    pub handler: &'static str,
    /// The last parts of the names of its tasks.
    pub tasks: &'static [&'static str],
}

/// The stack of a program, bytes.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct StackUsage {
    /// Size of the stack.
    pub available: u64,
    /// `main` while it starts everything, alone.
    pub boot: Context,
    /// Sum of all contexts that can interrupt each other.
    pub nested: u64,
    /// The contexts that nest, outermost first.
    pub contexts: Vec<Context>,
}

/// A context of execution: between two interrupts.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Context {
    /// Executor, or the deepest of the interrupts of devices.
    pub name: String,
    /// Its stack, including the frame that the processor saves before it, bytes.
    pub bytes: u64,
    /// The functions on the deepest path, with the frame of each, bytes.
    pub path: Vec<(String, u64)>,
}

impl Context {
    /// The function with the largest frame on the way.
    pub fn largest(&self) -> &str {
        let largest = self.path.iter().max_by_key(|(_, bytes)| *bytes);
        largest.map_or("", |(name, _)| name)
    }
}

impl Executor {
    fn runs(&self, task: &str) -> bool {
        self.tasks.iter().any(|name| task.ends_with(name))
    }
}

impl StackUsage {
    /// Worst-case depth, bytes.
    pub fn deepest(&self) -> u64 {
        self.boot.bytes.max(self.nested)
    }

    /// Worst-case share of the stack.
    pub fn share(&self) -> f64 {
        self.deepest() as f64 / self.available as f64
    }

    /// Refuses a program that may take more than [`STACK_BUDGET`].
    ///
    /// # Errors
    /// It may.
    pub fn ensure_fits(&self) -> Result<()> {
        ensure!(
            self.share() <= STACK_BUDGET,
            "the stack may get {} bytes deep, {:.0} % of the {} that there are; {:.0} % are allowed, for what the call graph does not show. \
             The table says which executor takes most; --json names the functions on its way",
            self.deepest(),
            100.0 * self.share(),
            self.available,
            100.0 * STACK_BUDGET
        );
        Ok(())
    }
}

/// How deep the stack of `available` bytes gets in a program with these executors, lowest priority first.
///
/// # Errors
/// The program has a task that belongs to no given executor, or lacks a symbol.
pub fn stack(elf: &Elf, executors: &[Executor], available: u64) -> Result<StackUsage> {
    let graph = CallGraph::of(elf);
    let (tasks, vectors) = (graph.tasks(), graph.named_as_address(true));
    let by_pointer = graph.named_as_address(false).into_iter();
    let by_pointer =
        graph.deepest(by_pointer.filter(|node| tasks.iter().all(|(task, _)| task != node)));
    let start = graph.named(START)?;

    let asleep = Way {
        bytes: graph.frame(start),
        path: Vec::new(),
    };
    let mut contexts = vec![context("main, asleep", 0, [asleep])];
    let (mut untold, mut devices) = (tasks, vectors);
    for executor in executors {
        let handler = graph.named(executor.handler)?;
        devices.retain(|node| *node != handler);
        let (mine, others) = untold
            .into_iter()
            .partition::<Vec<_>, _>(|(_, task)| executor.runs(task));
        untold = others;
        let task = graph.deepest(mine.into_iter().map(|(node, _)| node));
        let ways = [graph.deepest([handler]), task, by_pointer.clone()];
        contexts.push(context(executor.name, EXCEPTION_FRAME, ways));
    }
    if let Some((_, task)) = untold.first() {
        bail!(
            "no executor is said to run the task {task}: say it beside the image of the board, in host-tools/rig/src/firmware"
        );
    }
    devices.retain(|node| *node != start && !NEVER_COME_BACK.contains(&graph.name(*node)));
    let device = graph.deepest(devices);
    contexts.push(context("interrupts of devices", EXCEPTION_FRAME, [device]));
    let boot = context("main, at boot", 0, [graph.deepest([start]), by_pointer]);
    Ok(StackUsage {
        available,
        nested: contexts.iter().map(|context| context.bytes).sum(),
        boot,
        contexts,
    })
}

fn context<const N: usize>(name: &str, before: u64, ways: [Way; N]) -> Context {
    Context {
        name: name.to_owned(),
        bytes: ways.iter().fold(before, |sum, way| sum + way.bytes),
        path: ways.into_iter().flat_map(|way| way.path).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::super::image::{Mention, Piece};
    use super::*;

    const EXECUTORS: [Executor; 1] = [Executor {
        name: "control",
        handler: "UART4",
        tasks: &["::blink"],
    }];

    fn poll(task: &str) -> String {
        let future = format!("board::__{task}_task::__{task}_task_inner_function::{{closure#0}}");
        format!("<embassy_executor::raw::TaskStorage<{future}>>::poll")
    }

    /// Functions of 4 bytes from 0x100 on, behind the vector table, with their frames.
    fn program(functions: &[(&str, u64)], mentions: &[(u64, u64, bool)]) -> Elf {
        let piece = |name: &str, address, bytes| Piece {
            name: name.to_owned(),
            address,
            bytes,
            loaded: true,
            writable: false,
        };
        let functions = || (0x100..).step_by(4).zip(functions);
        let mention = |(at, to, call): &(u64, u64, bool)| Mention {
            at: *at,
            to: *to,
            call: *call,
        };
        Elf {
            entry: 0x100,
            sections: vec![
                piece(".vector_table", 0, 0x80),
                piece(".text", 0x100, 0x100),
            ],
            symbols: functions()
                .map(|(at, (name, _))| piece(name, at, 4))
                .collect(),
            frames: functions().map(|(at, (_, frame))| (at, *frame)).collect(),
            mentions: mentions.iter().map(mention).collect(),
        }
    }

    fn board() -> Elf {
        program(
            &[
                ("Reset", 8),          // 0x100
                ("start", 1000),       // 0x104
                ("UART4", 16),         // 0x108
                (&poll("blink"), 100), // 0x10c
                ("deep", 50),          // 0x110, calls itself
                ("TIM5", 30),          // 0x114
                ("HardFault", 5000),   // 0x118
                ("format", 7),         // 0x11c, called through a pointer
            ],
            &[
                (0x4, 0x100, false),
                (0xc, 0x118, false),
                (0x40, 0x108, false),
                (0x44, 0x114, false),
                (0x100, 0x104, true),
                (0x104, 0x10c, false), // spawns the task
                (0x10c, 0x110, true),
                (0x110, 0x110, true),
                (0x110, 0x11c, false),
            ],
        )
    }

    #[test]
    fn what_can_nest_is_added_up() {
        let stack = stack(&board(), &EXECUTORS, 2000).unwrap();
        let bytes: Vec<u64> = stack.contexts.iter().map(|context| context.bytes).collect();
        let executor = EXCEPTION_FRAME + 16 + 100 + 50 + 7;
        assert_eq!(bytes, [8, executor, EXCEPTION_FRAME + 30]);
        assert_eq!(stack.nested, bytes.iter().sum::<u64>());
        assert_eq!(stack.boot.bytes, 8 + 1000 + 7);
        assert!(stack.contexts[1].largest().contains("blink"));
    }

    #[test]
    fn more_than_the_budget_is_refused_with_both_numbers() {
        let fits = |available| {
            stack(&board(), &EXECUTORS, available)
                .unwrap()
                .ensure_fits()
        };
        assert!(fits(1269).is_ok());
        let error = fits(1268).unwrap_err().to_string();
        assert!(
            error.contains("1015 bytes") && error.contains("1268"),
            "{error}"
        );
    }

    #[test]
    fn a_task_that_nobody_is_said_to_run_is_named() {
        let error = stack(&board(), &[], 2000).unwrap_err().to_string();
        assert!(error.contains("the task board::blink"), "{error}");
    }
}
