//! Stack frame of a function, read from its machine code.
//!
//! The compiler lowers the stack pointer at the beginning of a function, once, for all that it needs;
//! nothing else in Rust's code moves it down. So the frame is the sum of what the instructions of a
//! function take off the stack pointer. DWARF does not tell: with frame pointers, which Thumb targets
//! always have, it describes the registers that were pushed and no more.
//!
//! Encodings: Armv7-M Architecture Reference Manual, A5 and A7.

/// Stack frame of a piece of Thumb code, bytes.
pub(super) fn frame(code: &[u8]) -> u64 {
    let mut halfwords = code
        .as_chunks::<2>()
        .0
        .iter()
        .map(|bytes| u16::from_le_bytes(*bytes));
    let mut sum = 0;
    while let Some(first) = halfwords.next() {
        sum += match is_wide(first) {
            true => wide(first, halfwords.next().unwrap_or_default()),
            false => narrow(first),
        };
    }
    sum
}

/// Whether an instruction has a second half (A5.1).
fn is_wide(first: u16) -> bool {
    first >> 11 >= 0b11101
}

fn narrow(instruction: u16) -> u64 {
    match instruction {
        // PUSH (T1): eight low registers and LR.
        0xb400..=0xb5ff => 4 * u64::from((instruction & 0x1ff).count_ones()),
        // SUB SP, SP, #imm7 (T1).
        0xb080..=0xb0ff => 4 * u64::from(instruction & 0x7f),
        _ => 0,
    }
}

fn wide(first: u16, second: u16) -> u64 {
    let low = u64::from(second & 0xff);
    let to_sp = second & 0x8f00 == 0x0d00;
    match first {
        // STMDB SP!, PUSH (T2).
        0xe92d => 4 * u64::from(second.count_ones()),
        // STR Rt, [SP, #-imm8]! (T4), PUSH of one register (T3).
        0xf84d if second & 0x0f00 == 0x0d00 => low,
        // STRD Rt, Rt2, [SP, #-imm8]! (T1).
        0xe96d => 4 * low,
        // VPUSH: D selects registers, imm8 counts words in both forms.
        0xed2d | 0xed6d if second & 0x0e00 == 0x0a00 => 4 * low,
        // SUB{S}.W SP, SP, #const (T2).
        _ if first & 0xfbef == 0xf1ad && to_sp => expanded(immediate(first, second)),
        // SUBW SP, SP, #imm12 (T3).
        _ if first & 0xfbff == 0xf2ad && to_sp => immediate(first, second).into(),
        _ => 0,
    }
}

/// i:imm3:imm8.
fn immediate(first: u16, second: u16) -> u32 {
    u32::from(first >> 10 & 1) << 11 | u32::from(second >> 12 & 7) << 8 | u32::from(second & 0xff)
}

/// A modified immediate constant (A5.3.2).
fn expanded(immediate: u32) -> u64 {
    let byte = immediate & 0xff;
    let value = match immediate >> 8 {
        0 => byte,
        1 => byte << 16 | byte,
        2 => byte << 24 | byte << 8,
        3 => byte << 24 | byte << 16 | byte << 8 | byte,
        _ => (0x80 | byte & 0x7f).rotate_right(immediate >> 7),
    };
    value.into()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// As an assembler encodes them (llvm-mc -triple=thumbv7em -show-encoding).
    #[test]
    fn each_way_down_is_known_and_nothing_else() {
        for (text, code, bytes) in [
            ("push {r4, r5, r6, r7, lr}", &[0xf0, 0xb5][..], 20),
            ("sub sp, #508", &[0xff, 0xb0], 508),
            ("push.w {r8, r9, r10, r11}", &[0x2d, 0xe9, 0x00, 0x0f], 16),
            ("str r8, [sp, #-4]!", &[0x4d, 0xf8, 0x04, 0x8d], 4),
            ("strd r2, r3, [sp, #-16]!", &[0x6d, 0xe9, 0x04, 0x23], 16),
            ("vpush {d8, d9, d10}", &[0x2d, 0xed, 0x06, 0x8b], 24),
            ("vpush {s17}", &[0x6d, 0xed, 0x01, 0x8a], 4),
            ("sub.w sp, sp, #102400", &[0xad, 0xf5, 0xc8, 0x3d], 102_400),
            ("subw sp, sp, #4092", &[0xad, 0xf6, 0xfc, 0x7d], 4092),
            ("add sp, #508", &[0x7f, 0xb0], 0),
            ("pop {r4, pc}", &[0x10, 0xbd], 0),
            ("str r0, [sp, #4]", &[0x01, 0x90], 0),
            ("str.w r8, [sp, #4]", &[0xcd, 0xf8, 0x04, 0x80], 0),
            ("sub.w r4, sp, #1024", &[0xad, 0xf5, 0x80, 0x64], 0),
            // Its second half looks like a PUSH.
            ("ldr.w r11, [r0, #1280]", &[0xd0, 0xf8, 0x00, 0xb5], 0),
        ] {
            assert_eq!(frame(code), bytes, "{text}");
        }
    }

    #[test]
    fn the_frame_is_the_sum() {
        // push {r7, lr}; sub.w sp, sp, #102400; sub sp, #320; add sp, #320
        let code = [0x80, 0xb5, 0xad, 0xf5, 0xc8, 0x3d, 0xd0, 0xb0, 0x50, 0xb0];
        assert_eq!(frame(&code), 8 + 102_720);
    }
}
