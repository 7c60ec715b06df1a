//! Mutates the corpus as coverage-guided fuzzers do, but without coverage.

use super::{Target, corpus};
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::time::{Duration, Instant};

/// Longest input, bytes, unless one of the corpus is longer.
const LONGEST: usize = 4096;
/// Most mutations of an input.
const MUTATIONS: u64 = 8;
/// Bytes that often cause errors in parsers.
const CURIOUS: [u8; 12] = [
    0, 1, 0x7f, 0x80, 0xff, b'0', b'9', b'-', b'.', b'"', b'<', b'\r',
];

/// Unusual numbers for texts.
const CURIOUS_NUMBERS: [&str; 10] = [
    "0",
    "-1",
    "1",
    "1e300",
    "-1e-300",
    "nan",
    "-inf",
    "9223372036854775807",
    "true",
    "[]",
];

/// Pseudo-random numbers.
struct Dice(u64);

impl Dice {
    fn roll(&mut self, sides: u64) -> u64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) % sides.max(1)
    }
}

/// Runs a target on its corpus, then on mutations of it while `more` returns true for the number of inputs so far and the
/// time. Returns the number of inputs. A seed always gives the same mutations. An input that fails is saved in a file for the
/// corpus.
///
/// # Panics
/// If the target panics.
pub fn fuzz(target: Target, seed: u64, more: impl Fn(u64, Duration) -> bool) -> u64 {
    let corpus = inputs(target.name);
    let longest = corpus.iter().map(Vec::len).fold(LONGEST, usize::max);
    corpus.iter().for_each(|input| run(target, input));
    let (began, mut dice, mut runs) = (Instant::now(), Dice(seed), corpus.len() as u64);
    while more(runs, began.elapsed()) {
        let mut input = corpus[dice.roll(corpus.len() as u64) as usize].clone();
        for _ in 0..=dice.roll(MUTATIONS) {
            let other = &corpus[dice.roll(corpus.len() as u64) as usize];
            mutate(&mut input, other, &mut dice);
        }
        input.truncate(longest);
        run(target, &input);
        runs += 1;
    }
    runs
}

fn run(target: Target, input: &[u8]) {
    if let Err(panic) = catch_unwind(AssertUnwindSafe(|| (target.run)(input))) {
        let path = std::env::temp_dir().join(format!("softdock-fuzz-{}", target.name));
        std::fs::write(&path, input).unwrap();
        eprintln!("{} fails; the input is in {}", target.name, path.display());
        resume_unwind(panic);
    }
}

/// The files of a target in order, and the empty input.
fn inputs(name: &str) -> Vec<Vec<u8>> {
    let folder = corpus(name);
    let mut files: Vec<_> = std::fs::read_dir(&folder)
        .unwrap_or_else(|error| panic!("{}: {error}", folder.display()))
        .map(|entry| entry.unwrap().path())
        .collect();
    files.sort();
    let inputs = files.iter().map(|path| std::fs::read(path).unwrap());
    std::iter::once(Vec::new()).chain(inputs).collect()
}

/// Makes one change.
fn mutate(input: &mut Vec<u8>, other: &[u8], dice: &mut Dice) {
    let at = dice.roll(input.len() as u64 + 1) as usize;
    let length = dice.roll(16) as usize + 1;
    let end = (at + length).min(input.len());
    match dice.roll(9) {
        0 if at < input.len() => input[at] ^= 1 << dice.roll(8),
        1 if at < input.len() => input[at] = CURIOUS[dice.roll(CURIOUS.len() as u64) as usize],
        2 if at < input.len() => input[at] = dice.roll(256) as u8,
        3 => drop(input.drain(at.min(end)..end)),
        4 => {
            let piece = input[at.min(end)..end].to_vec();
            input.splice(at..at, piece);
        }
        5 => {
            let from = dice.roll(other.len() as u64 + 1) as usize;
            let piece = other[from..(from + 4 * length).min(other.len())].to_vec();
            input.splice(at..at, piece);
        }
        6 | 7 => replace_number(input, at, dice),
        _ => input.insert(at, dice.roll(256) as u8),
    }
}

/// Replaces the next number of a text by an unusual one.
fn replace_number(input: &mut Vec<u8>, from: usize, dice: &mut Dice) {
    let is_part = |byte: &u8| byte.is_ascii_digit() || b".+-".contains(byte);
    let Some(start) = input.iter().skip(from).position(u8::is_ascii_digit) else {
        return;
    };
    let start = from + start;
    let length = input[start..]
        .iter()
        .take_while(|byte| is_part(byte))
        .count();
    let number = CURIOUS_NUMBERS[dice.roll(CURIOUS_NUMBERS.len() as u64) as usize];
    input.splice(start..start + length, number.bytes());
}
