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
///
/// # Errors
/// There is none, or a number of one is wrong.
pub fn regions(script: &str) -> Result<Vec<Region>> {
    let found: Vec<Region> = script
        .lines()
        .filter_map(|line| {
            let (name, rest) = line.split_once(':')?;
            let rest = rest.trim().strip_prefix("ORIGIN = ")?;
            Some((name.trim(), rest.split_once(", LENGTH = ")?))
        })
        .map(|(name, (origin, length))| {
            let number = |text| number(text).with_context(|| format!("the region {name}"));
            Ok(Region {
                name: name.to_owned(),
                origin: number(origin)?,
                length: number(length)?,
            })
        })
        .collect::<Result<_>>()?;
    ensure!(
        !found.is_empty(),
        "there is no line like `FLASH : ORIGIN = 0x08000000, LENGTH = 1024K`"
    );
    Ok(found)
}

/// A number as linkers read it: decimal or 0x.., with K for 1024 and M for 1024².
fn number(text: &str) -> Result<u64> {
    let (digits, unit) = match (text.strip_suffix('K'), text.strip_suffix('M')) {
        (Some(digits), _) => (digits, 1 << 10),
        (_, Some(digits)) => (digits, 1 << 20),
        _ => (text, 1),
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
        // A sector can be erased only while the processor reads from the other bank.
        const BANK: u64 = 1 << 20;
        assert!(flash.length <= BANK && settings.origin >= flash.origin + BANK);
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
