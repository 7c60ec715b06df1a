//! The EEPROM of a SubDevice (ETG.2010, ETG.1000.6 table 16 on).

use super::description::Description;

/// Where the areas of the SyncManagers begin and how long they are; 0 is the mailbox in, 1 out.
pub(super) const MAILBOX_BYTES: u16 = 128;
const MAILBOX_IN: u16 = 0x1000;
const MAILBOX_OUT: u16 = 0x1080;
const OUTPUTS: u16 = 0x1100;
const INPUTS: u16 = 0x1400;

/// Categories.
const STRINGS: u16 = 10;
const GENERAL: u16 = 30;
const FMMU: u16 = 40;
const SYNC_MANAGER: u16 = 41;
const TX_PDO: u16 = 50;
const RX_PDO: u16 = 51;
const END: u16 = 0xFFFF;

/// Word at which the categories begin.
const CATEGORIES: usize = 0x40;
/// Size of the EEPROM, bytes: 16 kbit.
const SIZE_BYTES: u16 = 2048;
/// CoE in the mailbox's protocols.
const COE: u16 = 0x0004;

/// The content of the EEPROM.
pub(super) fn content(about: &Description) -> Vec<u8> {
    let mut words = [0_u16; CATEGORIES];
    let mut double = |at: usize, value: u32| {
        words[at] = value as u16;
        words[at + 1] = (value >> 16) as u16;
    };
    double(0x08, about.vendor);
    double(0x0A, about.product);
    double(0x0C, about.revision);
    double(0x0E, about.serial);
    words[0x18..0x1D].copy_from_slice(&[
        MAILBOX_IN,
        MAILBOX_BYTES,
        MAILBOX_OUT,
        MAILBOX_BYTES,
        COE,
    ]);
    words[0x3E] = SIZE_BYTES / 128 - 1;
    words[0x3F] = 1;
    let mut bytes: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).collect();
    bytes[14] = checksum(&bytes[..14]);

    let name = about.name.as_bytes();
    let mut strings = vec![1, name.len() as u8];
    strings.extend_from_slice(name);
    category(&mut bytes, STRINGS, strings);
    let mut general = vec![0; 32];
    // Order and name are the first string; SDOs, no information service, no complete access.
    (general[2], general[3], general[5]) = (1, 1, 1);
    category(&mut bytes, GENERAL, general);
    category(&mut bytes, FMMU, vec![1, 2]);
    category(&mut bytes, SYNC_MANAGER, sync_managers(about));
    category(&mut bytes, TX_PDO, pdo(0x1A00, 3, &about.inputs));
    category(&mut bytes, RX_PDO, pdo(0x1601, 2, &about.outputs));
    bytes.extend_from_slice(&END.to_le_bytes());
    bytes
}

fn category(bytes: &mut Vec<u8>, number: u16, mut content: Vec<u8>) {
    if content.len() % 2 == 1 {
        content.push(0);
    }
    bytes.extend_from_slice(&number.to_le_bytes());
    bytes.extend_from_slice(&((content.len() / 2) as u16).to_le_bytes());
    bytes.extend(content);
}

/// Start, length, control, status, enabled, use.
fn sync_managers(about: &Description) -> Vec<u8> {
    [
        (MAILBOX_IN, MAILBOX_BYTES, 0x26, 1),
        (MAILBOX_OUT, MAILBOX_BYTES, 0x22, 2),
        (OUTPUTS, bits(&about.outputs) / 8, 0x64, 3),
        (INPUTS, bits(&about.inputs) / 8, 0x20, 4),
    ]
    .into_iter()
    .flat_map(|(start, length, control, kind): (u16, u16, u8, u8)| {
        let [s0, s1] = start.to_le_bytes();
        let [l0, l1] = length.to_le_bytes();
        [s0, s1, l0, l1, control, 0, 1, kind]
    })
    .collect()
}

/// Bits of all entries of a mapping.
pub(super) fn bits(mapping: &[u32]) -> u16 {
    mapping
        .iter()
        .map(|entry| *entry as u8)
        .map(u16::from)
        .sum()
}

/// A PDO with its entries, each of them index, sub-index and bits as in its mapping object.
fn pdo(index: u16, manager: u8, mapping: &[u32]) -> Vec<u8> {
    let [i0, i1] = index.to_le_bytes();
    let mut bytes = vec![i0, i1, mapping.len() as u8, manager, 0, 0, 0, 0];
    for entry in mapping {
        let [length, sub_index, e0, e1] = entry.to_le_bytes();
        // The data type is always DINT: it is not evaluated.
        bytes.extend_from_slice(&[e0, e1, sub_index, 0, 0x04, length, 0, 0]);
    }
    bytes
}

/// CRC-8 with polynomial 0x07 from 0xFF, over the first 14 bytes (ETG.1000.6, table 16).
fn checksum(bytes: &[u8]) -> u8 {
    bytes.iter().fold(0xFF, |mut crc: u8, byte| {
        crc ^= byte;
        for _ in 0..8 {
            crc = crc << 1 ^ if crc & 0x80 != 0 { 0x07 } else { 0 };
        }
        crc
    })
}
