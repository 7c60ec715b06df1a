//! An image for a board, an ELF file: read and checked.

use super::Region;
use super::frame::frame;
use anyhow::{Context, Result, bail, ensure};
use object::{Architecture, Object, ObjectSection, ObjectSymbol, RelocationFlags};
use object::{RelocationTarget, SectionFlags, SectionKind, elf};
use std::cmp::Reverse;
use std::collections::BTreeMap;
use std::path::Path;

/// A section or symbol of a program.
#[derive(Clone, Debug)]
pub(super) struct Piece {
    pub(super) name: String,
    pub(super) address: u64,
    pub(super) bytes: u64,
    /// Its contents are in the file.
    pub(super) loaded: bool,
    /// Whether it is in RAM; if it is loaded as well, it is copied from flash.
    pub(super) writable: bool,
}

/// The parts of a program that are needed here.
#[derive(Clone, Debug, Default)]
pub struct Elf {
    pub(super) entry: u64,
    /// Sections that take memory, sorted by address.
    pub(super) sections: Vec<Piece>,
    /// Functions, constants and statics, sorted by address.
    pub(super) symbols: Vec<Piece>,
    /// Stack frame of each function, bytes, by its address.
    pub(super) frames: BTreeMap<u64, u64>,
    /// Addresses that code and constants mention.
    pub(super) mentions: Vec<Mention>,
}

/// A place in flash that names an address.
#[derive(Clone, Copy, Debug)]
pub(super) struct Mention {
    pub(super) at: u64,
    pub(super) to: u64,
    /// Whether it is a call.
    pub(super) call: bool,
}

impl Elf {
    /// Reads a program for an ARM processor.
    ///
    /// # Errors
    /// The file cannot be read, or is something else.
    pub fn open(path: &Path) -> Result<Self> {
        let read = || {
            let bytes = std::fs::read(path)?;
            let file = object::File::parse(&*bytes)
                .context("expected a program as an ELF file, as `cargo firmware` builds it")?;
            ensure!(
                file.architecture() == Architecture::Arm,
                "expected a program for an ARM processor; this one is for {:?}",
                file.architecture()
            );
            let mut sections: Vec<Piece> = file.sections().filter_map(|s| section(&s)).collect();
            sections.sort_by_key(|section| section.address);
            let symbols = symbols(&file, &sections);
            Ok(Self {
                entry: file.entry(),
                frames: frames(&file, &symbols)?,
                mentions: mentions(&file)?,
                symbols,
                sections,
            })
        };
        read().with_context(|| path.display().to_string())
    }

    /// Refuses a program that does not begin in a region, that of the chip's flash.
    ///
    /// # Errors
    /// It does not.
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

fn section<'a>(section: &impl ObjectSection<'a>) -> Option<Piece> {
    let SectionFlags::Elf { sh_flags, .. } = section.flags() else {
        return None;
    };
    let has = |flag: elf::SectionFlags| sh_flags.0 & flag.0 != 0;
    (has(elf::SHF_ALLOC) && section.size() > 0).then(|| Piece {
        name: section.name().unwrap_or("?").to_owned(),
        address: section.address(),
        bytes: section.size(),
        loaded: section.file_range().is_some(),
        writable: has(elf::SHF_WRITE),
    })
}

/// Symbols that have a name and a size; functions with equal code are one piece with several names.
fn symbols(file: &object::File, sections: &[Piece]) -> Vec<Piece> {
    let named = file.symbols().filter(|symbol| symbol.size() > 0);
    let mut found: Vec<Piece> = named
        .filter_map(|symbol| {
            // Bit 0 of the address marks a Thumb function.
            let address = symbol.address() & !1;
            let holder = &sections[holder(sections, address)?];
            let name = symbol.name().ok()?;
            Some(Piece {
                name: format!("{:#}", rustc_demangle::demangle(name)),
                address,
                bytes: symbol.size(),
                ..holder.clone()
            })
        })
        .collect();
    found.sort_by_key(|symbol| (symbol.address, Reverse(symbol.bytes)));
    found.dedup_by_key(|symbol| symbol.address);
    found
}

/// Stack that each function takes for itself. Data between instructions is left out, by the mapping
/// symbols (ELF for the Arm architecture, 5.5.5).
fn frames(file: &object::File, symbols: &[Piece]) -> Result<BTreeMap<u64, u64>> {
    let is_code: BTreeMap<u64, bool> = file
        .symbols()
        .filter_map(|symbol| match symbol.name().ok()?.get(..2)? {
            "$t" => Some((symbol.address(), true)),
            "$d" => Some((symbol.address(), false)),
            _ => None,
        })
        .collect();
    let mut found = BTreeMap::new();
    for section in file.sections().filter(|s| s.kind() == SectionKind::Text) {
        let (data, start) = (section.data()?, section.address());
        let code = |from: u64, to: u64| data.get((from - start) as usize..(to - start) as usize);
        let inside = |symbol: &&Piece| (start..start + section.size()).contains(&symbol.address);
        for symbol in symbols.iter().filter(inside) {
            let end = symbol.address + symbol.bytes;
            let (mut from, mut runs, mut sum) = (symbol.address, true, 0);
            let marks = is_code.range(symbol.address..end);
            for (mark, code_follows) in marks.chain(std::iter::once((&end, &false))) {
                if runs {
                    sum += frame(code(from, *mark).context("a function leaves its section")?);
                }
                (from, runs) = (*mark, *code_follows);
            }
            found.insert(symbol.address, sum);
        }
    }
    Ok(found)
}

/// What code and constants mention, by the relocations that the linker keeps for it (`--emit-relocs`
/// in the board's build script; ELF for the Arm architecture, 5.6.1).
fn mentions(file: &object::File) -> Result<Vec<Mention>> {
    let mut found = Vec::new();
    for section in file.sections() {
        if self::section(&section).is_none_or(|piece| piece.writable || !piece.loaded) {
            continue;
        }
        let data = section.data()?;
        // The lower half of the address that each register is being loaded with.
        let mut lower = [0; 16];
        for (at, relocation) in section.relocations() {
            let offset = (at - section.address()) as usize;
            let Some(bytes) = data.get(offset..).and_then(<[u8]>::first_chunk::<4>) else {
                continue;
            };
            let word = u32::from_le_bytes(*bytes);
            let register = &mut lower[(word >> 24 & 0xf) as usize];
            let RelocationFlags::Elf { r_type } = relocation.flags() else {
                continue;
            };
            let to = match (r_type, relocation.target()) {
                (elf::R_ARM_THM_PC22 | elf::R_ARM_THM_JUMP24, RelocationTarget::Symbol(to)) => {
                    file.symbol_by_index(to)?.address()
                }
                (elf::R_ARM_ABS32, _) => word.into(),
                (elf::R_ARM_THM_MOVW_ABS_NC, _) => {
                    *register = immediate(word);
                    continue;
                }
                (elf::R_ARM_THM_MOVT_ABS, _) => immediate(word) << 16 | *register,
                _ => continue,
            };
            let call = matches!(r_type, elf::R_ARM_THM_PC22 | elf::R_ARM_THM_JUMP24);
            let to = to & !1;
            found.push(Mention { at, to, call });
        }
    }
    Ok(found)
}

/// The 16 bits that MOVW (T3) and MOVT (T1) load (Armv7-M Architecture Reference Manual, A7.7.76).
fn immediate(word: u32) -> u64 {
    let (first, second) = (word & 0xffff, word >> 16);
    let value = (first & 0xf) << 12 | (first >> 10 & 1) << 11 | (second >> 12 & 7) << 8;
    u64::from(value | second & 0xff)
}

/// Index of the piece that contains an address.
pub(super) fn holder(pieces: &[Piece], address: u64) -> Option<usize> {
    let after = pieces.partition_point(|piece| piece.address <= address);
    let last = after.checked_sub(1)?;
    (address < pieces[last].address + pieces[last].bytes).then_some(last)
}
