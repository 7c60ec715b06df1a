//! Which addresses a piece of Thumb-2 code mentions: calls, jumps to other functions, and constants
//! that are loaded (ARMv7-M Architecture Reference Manual, A7.7).
//!
//! This is no disassembler: only the instructions that compilers use to name another function or a
//! static are understood, and all others are stepped over.

/// What a stretch of memory holds, by the linker's mapping symbols `$t` and `$d`
/// (ELF for the Arm architecture, 5.5.5).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Holds {
    /// Thumb instructions.
    Code,
    /// Constants.
    Data,
}

/// Addresses that a stretch of memory at `address` mentions. Those of functions have bit 0 set where
/// the code says that they are Thumb, which is to be ignored.
pub(super) fn mentioned(address: u64, bytes: &[u8], holds: Holds) -> Vec<u64> {
    match holds {
        Holds::Code => by_code(address, bytes),
        Holds::Data => by_data(address, bytes),
    }
}

/// Every aligned word may be an address.
fn by_data(address: u64, bytes: &[u8]) -> Vec<u64> {
    let unaligned = (address.wrapping_neg() & 3) as usize;
    let words = bytes.get(unaligned..).unwrap_or_default().chunks_exact(4);
    words
        .map(|word| word.iter().rev().fold(0, |sum, &b| sum << 8 | u64::from(b)))
        .collect()
}

fn by_code(address: u64, bytes: &[u8]) -> Vec<u64> {
    let halves: Vec<u32> = bytes
        .chunks_exact(2)
        .map(|half| u32::from(half[0]) | u32::from(half[1]) << 8)
        .collect();
    // The lower half of the constant that each register is being loaded with.
    let mut lower = [0; 16];
    let mut found = Vec::new();
    let mut at = 0;
    while let Some(&first) = halves.get(at) {
        let is_wide = first >> 11 > 0b11100;
        if let (true, Some(&second)) = (is_wide, halves.get(at + 1)) {
            let here = address + 2 * at as u64;
            found.extend(jump(here, first, second));
            found.extend(constant(&mut lower, first, second));
        }
        at += if is_wide { 2 } else { 1 };
    }
    found
}

/// BL (T1) and B (T4): 25 bits, relative to the instruction after the next halfword.
fn jump(here: u64, first: u32, second: u32) -> Option<u64> {
    let is_jump = first >> 11 == 0b11110 && matches!(second >> 12 & 0b1101, 0b1101 | 0b1001);
    let sign = first >> 10 & 1;
    let i1 = 1 ^ (second >> 13 & 1) ^ sign;
    let i2 = 1 ^ (second >> 11 & 1) ^ sign;
    let high = sign << 24 | i1 << 23 | i2 << 22;
    let offset = high | (first & 0x3ff) << 12 | (second & 0x7ff) << 1;
    let offset = i64::from((offset << 7) as i32 >> 7);
    is_jump.then(|| (here + 4).wrapping_add_signed(offset))
}

/// MOVW (T3) and MOVT (T1): the two halves of a constant, in this order.
fn constant(lower: &mut [u64; 16], first: u32, second: u32) -> Option<u64> {
    let opcode = first & 0xfbf0;
    if !matches!(opcode, 0xf240 | 0xf2c0) || second >> 15 != 0 {
        return None;
    }
    let value =
        (first & 0xf) << 12 | (first >> 10 & 1) << 11 | (second >> 12 & 7) << 8 | second & 0xff;
    let register = &mut lower[(second >> 8 & 0xf) as usize];
    if opcode == 0xf240 {
        *register = u64::from(value);
        return None;
    }
    Some(u64::from(value) << 16 | *register)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Encodings as `llvm-mc --arch=thumb --mcpu=cortex-m7 --show-encoding` gives them.
    #[test]
    fn calls_jumps_and_constants_are_found() {
        let code = [
            0x00, 0xbf, // nop
            0x00, 0xf0, 0x03, 0xf8, // bl   +6
            0xff, 0xf7, 0xfb, 0xbf, // b.w  -10
            0x45, 0xf2, 0x78, 0x60, // movw r0, #0x5678
            0xc1, 0xf2, 0x34, 0x20, // movt r0, #0x1234
            0x4f, 0xf0, 0x00, 0x01, // mov.w r1, #0
        ];
        assert_eq!(
            mentioned(0x1000, &code, Holds::Code),
            [0x1002 + 4 + 6, 0x1006 + 4 - 10, 0x1234_5678]
        );
    }

    #[test]
    fn words_of_data_are_taken_where_they_are_aligned() {
        let bytes = [9, 9, 0x01, 0x02, 0x00, 0x08, 7];
        assert_eq!(mentioned(0x2002, &bytes, Holds::Data), [0x0800_0201]);
    }
}
