//! The mailbox: SDOs of CoE (ETG.1000.6, 5.6). Values are short enough for one message.

use super::dictionary::{Abort, Dictionary};

/// Length, address, channel, protocol and counter.
const HEADER_BYTES: usize = 6;
/// Protocol CoE; services of its messages.
const COE: u8 = 3;
const SDO_REQUEST: u8 = 2;
const SDO_ANSWER: u8 = 3;
const EMERGENCY: u8 = 1;
/// Command, index, sub-index, four bytes of data or their length.
const SDO_BYTES: usize = 8;
/// Commands of an SDO, in its upper bits.
const DOWNLOAD: u8 = 1;
const UPLOAD: u8 = 2;
const ABORT: u8 = 0x80;
const DOWNLOADED: u8 = 0x60;
/// Bits of a command: length given, data in the header, all sub-indices at once.
const SIZED: u8 = 0x01;
const EXPEDITED: u8 = 0x02;
const COMPLETE: u8 = 0x10;

/// The answer to a message; none to what is no SDO.
pub(super) fn answer(message: &[u8], objects: &mut Dictionary) -> Option<Vec<u8>> {
    let (header, body) = message.split_at_checked(HEADER_BYTES)?;
    let length = usize::from(u16::from_le_bytes([header[0], header[1]]));
    let counter = header[5] & 0x70;
    let (coe, sdo) = body.get(..length)?.split_at_checked(2)?;
    if header[5] & 0xF != COE || coe[1] >> 4 != SDO_REQUEST || sdo.len() < SDO_BYTES {
        return None;
    }
    let (command, index, sub_index) = (sdo[0], u16::from_le_bytes([sdo[1], sdo[2]]), sdo[3]);
    let outcome = match command >> 5 {
        _ if command & COMPLETE != 0 => Err(Abort::Unsupported),
        UPLOAD => objects.read(index, sub_index).map(uploaded),
        DOWNLOAD => downloaded(command, sdo)
            .and_then(|value| objects.write(index, sub_index, value))
            .map(|()| (DOWNLOADED, vec![0; 4])),
        _ => Err(Abort::Unsupported),
    };
    // An abort is a request of its own (ETG.1000.6, table 40).
    let (service, (command, data)) = match outcome {
        Ok(answer) => (SDO_ANSWER, answer),
        Err(abort) => (SDO_REQUEST, (ABORT, (abort as u32).to_le_bytes().to_vec())),
    };
    let [i0, i1] = index.to_le_bytes();
    let mut body = vec![command, i0, i1, sub_index];
    body.extend(data);
    Some(coe_message(counter, service, &body))
}

/// An unsolicited emergency message with error code 0xFF00.
pub(super) fn emergency() -> Vec<u8> {
    coe_message(0x10, EMERGENCY, &[0x00, 0xFF, 0x80, 0, 0, 0, 0, 0])
}

fn coe_message(counter: u8, service: u8, body: &[u8]) -> Vec<u8> {
    let mut message = ((body.len() + 2) as u16).to_le_bytes().to_vec();
    message.extend_from_slice(&[0, 0, 0, COE | counter, 0, service << 4]);
    message.extend_from_slice(body);
    message
}

/// Command and data of an upload's answer.
fn uploaded(value: &[u8]) -> (u8, Vec<u8>) {
    if value.len() > 4 {
        let mut data = (value.len() as u32).to_le_bytes().to_vec();
        data.extend_from_slice(value);
        return (UPLOAD << 5 | SIZED, data);
    }
    let unused = 4 - value.len() as u8;
    let mut data = value.to_vec();
    data.resize(4, 0);
    (UPLOAD << 5 | unused << 2 | EXPEDITED | SIZED, data)
}

/// The value that a download brings.
fn downloaded(command: u8, sdo: &[u8]) -> Result<&[u8], Abort> {
    let length = match (command & EXPEDITED != 0, command & SIZED != 0) {
        (true, true) => 4 - usize::from(command >> 2 & 3),
        (true, false) => 4,
        (false, _) => return Err(Abort::Unsupported),
    };
    sdo.get(4..4 + length).ok_or(Abort::Length)
}
