//! The memory of a chip, as the linker's `memory.x` names it.

use anyhow::{Context, Result, ensure};
use serde::Serialize;

/// A region of memory.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Region {
    /// Name in `memory.x`.
    pub name: String,
    /// First address.
    pub origin: u64,
    /// Bytes.
    pub length: u64,
}

impl Region {
    /// Whether an address lies in the region.
    pub fn contains(&self, address: u64) -> bool {
        address
            .checked_sub(self.origin)
            .is_some_and(|offset| offset < self.length)
    }
}

/// The regions of a linker script: its lines `NAME : ORIGIN = .., LENGTH = ..`.
pub fn regions(script: &str) -> Result<Vec<Region>> {
    let found: Vec<Region> = script
        .lines()
        .filter_map(|line| {
            let (name, rest) = line.split_once(':')?;
            let rest = rest.trim().strip_prefix("ORIGIN")?.trim_start();
            Some((name.trim(), rest.strip_prefix('=')?))
        })
        .map(|(name, rest)| region(name, rest).with_context(|| format!("the region {name}")))
        .collect::<Result<_>>()?;
    ensure!(
        !found.is_empty(),
        "there is no line like `FLASH : ORIGIN = 0x08000000, LENGTH = 1024K`"
    );
    Ok(found)
}

fn region(name: &str, rest: &str) -> Result<Region> {
    let (origin, length) = rest
        .split_once(',')
        .context("expected ORIGIN and LENGTH, separated by a comma")?;
    let length = length
        .split_once('=')
        .filter(|(word, _)| word.trim() == "LENGTH")
        .context("expected LENGTH = .. after the comma")?
        .1;
    Ok(Region {
        name: name.to_owned(),
        origin: number(origin)?,
        length: number(length)?,
    })
}

/// A number as linkers read it: decimal or 0x.., with K for 1024 and M for 1024².
fn number(text: &str) -> Result<u64> {
    let text = text.trim();
    let (digits, unit) = match text.strip_suffix(['K', 'M']) {
        Some(digits) if text.ends_with('K') => (digits, 1 << 10),
        Some(digits) => (digits, 1 << 20),
        None => (text, 1),
    };
    let value = match digits.strip_prefix("0x") {
        Some(hex) => u64::from_str_radix(hex, 16),
        None => digits.parse(),
    };
    let value = value.with_context(|| format!("`{text}` is not a number"))?;
    value.checked_mul(unit).context("too large")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_script_of_the_board_is_understood() {
        let regions = regions(include_str!("../../../../memory.x")).unwrap();
        let flash = &regions[0];
        assert_eq!((flash.name.as_str(), flash.origin), ("FLASH", 0x0800_0000));
        assert!(flash.contains(0x0800_0000) && !flash.contains(0x0800_0000 + flash.length));
        let settings = regions.iter().find(|r| r.name == "SETTINGS").unwrap();
        assert_eq!(settings.origin, flash.origin + flash.length);
        // Data behind the stack, so that what overflows it overwrites nothing.
        let place = |name| regions.iter().find(|r| r.name == name).unwrap().origin;
        assert!(place("STACK") < place("RAM"));
    }

    #[test]
    fn a_wrong_number_is_named() {
        let error = regions("RAM : ORIGIN = 0x20000000, LENGTH = 12Q").unwrap_err();
        assert_eq!(
            format!("{error:#}").lines().next(),
            Some("the region RAM: `12Q` is not a number: invalid digit found in string")
        );
        assert!(regions("nothing").is_err());
    }
}
