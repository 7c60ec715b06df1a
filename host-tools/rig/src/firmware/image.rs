//! A program for a board: an ELF file, read and checked.

use super::Region;
use super::thumb::Holds;
use anyhow::{Context, Result, bail, ensure};
use object::{Architecture, Object, ObjectSection, ObjectSymbol, SectionFlags, elf};
use std::path::Path;

/// A part of a program that takes memory.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Section {
    /// Name, with its dot.
    pub name: String,
    /// Where it is when the program runs.
    pub address: u64,
    /// Bytes.
    pub bytes: u64,
    /// Its contents are in the file; the others are cleared or left as they are.
    pub loaded: bool,
    /// It can be written to: what is loaded as well, is copied from flash.
    pub writable: bool,
}

/// A named place in memory.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Symbol {
    /// Name as the linker knows it.
    pub name: String,
    /// Address.
    pub address: u64,
    /// Bytes.
    pub bytes: u64,
}

/// What is needed of a program.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Elf {
    /// Where it begins.
    pub entry: u64,
    /// Parts that take memory.
    pub sections: Vec<Section>,
    /// Statics and functions.
    pub symbols: Vec<Symbol>,
    /// What of it is in flash: code and constants.
    pub(super) code: Vec<Code>,
}

/// A section of code or constants.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Code {
    pub(super) address: u64,
    pub(super) bytes: Vec<u8>,
    /// From where on it holds what, sorted by address; constants before the first mark.
    pub(super) marks: Vec<(u64, Holds)>,
}

impl Code {
    pub(super) fn contains(&self, address: u64) -> bool {
        (self.address..self.address + self.bytes.len() as u64).contains(&address)
    }

    /// Address, contents and kind of each stretch between two marks.
    pub(super) fn stretches(&self) -> impl Iterator<Item = (u64, &[u8], Holds)> {
        let first = std::iter::once((self.address, Holds::Data));
        let starts: Vec<_> = first.chain(self.marks.iter().copied()).collect();
        let end = self.address + self.bytes.len() as u64;
        let ends: Vec<u64> = starts.iter().skip(1).map(|s| s.0).chain([end]).collect();
        starts
            .into_iter()
            .zip(ends)
            .filter_map(|((from, holds), to)| {
                let part = (from - self.address) as usize..(to - self.address) as usize;
                Some((from, self.bytes.get(part)?, holds))
            })
    }
}

impl Elf {
    /// Reads a program for an ARM processor.
    pub fn open(path: &Path) -> Result<Self> {
        let read = || -> Result<Self> {
            let bytes = std::fs::read(path)?;
            let file = object::File::parse(&*bytes)
                .context("expected a program as an ELF file, as `cargo firmware` builds it")?;
            ensure!(
                file.architecture() == Architecture::Arm,
                "expected a program for an ARM processor; this one is for {:?}",
                file.architecture()
            );
            Ok(Self {
                entry: file.entry(),
                sections: file.sections().filter_map(|s| section(&s)).collect(),
                symbols: file.symbols().filter_map(|s| symbol(&s)).collect(),
                code: code(&file)?,
            })
        };
        read().with_context(|| path.display().to_string())
    }

    /// Refuses a program that does not begin in a region, that of the chip's flash.
    pub fn ensure_in(&self, flash: &Region) -> Result<()> {
        if flash.contains(self.entry) {
            return Ok(());
        }
        bail!(
            "the image is for another chip: it begins at {:#010x}; the flash of this board lies from {:#010x} to {:#010x}. \
             `cargo firmware` builds the right one",
            self.entry,
            flash.origin,
            flash.origin + flash.length
        )
    }
}

/// The sections that are in flash and stay there.
fn code(file: &object::File) -> Result<Vec<Code>> {
    let mut marks: Vec<(u64, Holds)> = file
        .symbols()
        .filter_map(|symbol| {
            let holds = match symbol.name().ok()?.get(..2)? {
                "$t" => Holds::Code,
                "$d" => Holds::Data,
                _ => return None,
            };
            Some((symbol.address(), holds))
        })
        .collect();
    marks.sort_by_key(|mark| mark.0);
    let sections = file
        .sections()
        .filter(|s| section(s).is_some_and(|s| s.loaded && !s.writable));
    sections
        .map(|section| {
            let address = section.address();
            let inside = address..address + section.size();
            Ok(Code {
                address,
                bytes: section.data()?.to_vec(),
                marks: marks
                    .iter()
                    .filter(|m| inside.contains(&m.0))
                    .copied()
                    .collect(),
            })
        })
        .collect()
}

fn section<'a>(section: &impl ObjectSection<'a>) -> Option<Section> {
    let SectionFlags::Elf { sh_flags, .. } = section.flags() else {
        return None;
    };
    let has = |flag: elf::SectionFlags| sh_flags.0 & flag.0 != 0;
    let takes_memory = has(elf::SHF_ALLOC) && section.size() > 0;
    takes_memory.then(|| Section {
        name: section.name().unwrap_or("?").to_owned(),
        address: section.address(),
        bytes: section.size(),
        loaded: section.file_range().is_some(),
        writable: has(elf::SHF_WRITE),
    })
}

fn symbol<'a>(symbol: &impl ObjectSymbol<'a>) -> Option<Symbol> {
    let name = symbol.name().ok()?;
    (symbol.size() > 0).then(|| Symbol {
        name: name.to_owned(),
        address: symbol.address(),
        bytes: symbol.size(),
    })
}
