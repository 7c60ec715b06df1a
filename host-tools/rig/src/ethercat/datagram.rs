//! The datagrams of a frame (ETG.1000.4, 5.4).

const ETHERNET_HEADER_BYTES: usize = 14;
const ETHERTYPE: [u8; 2] = [0x88, 0xA4];
/// Length and type of the EtherCAT frame.
const HEADER_BYTES: usize = 2;
/// Command, index, address, length, interrupt.
const DATAGRAM_HEADER_BYTES: usize = 10;
const COUNTER_BYTES: usize = 2;
const LENGTH: u16 = 0x07FF;
const MORE: u16 = 0x8000;

/// A datagram, in its frame.
#[derive(Debug)]
pub(super) struct Datagram<'a> {
    pub(super) command: u8,
    /// Address of the SubDevice (2 bytes) and in it (2 bytes), or a logical address.
    pub(super) address: &'a mut [u8],
    pub(super) data: &'a mut [u8],
    counter: &'a mut [u8],
}

impl Datagram<'_> {
    /// Address of the SubDevice.
    pub(super) fn device(&self) -> u16 {
        u16::from_le_bytes([self.address[0], self.address[1]])
    }

    pub(super) fn set_device(&mut self, device: u16) {
        self.address[..2].copy_from_slice(&device.to_le_bytes());
    }

    /// Address in the SubDevice.
    pub(super) fn offset(&self) -> u16 {
        u16::from_le_bytes([self.address[2], self.address[3]])
    }

    /// Address in the process image.
    pub(super) fn logical(&self) -> u32 {
        u32::from_le_bytes([
            self.address[0],
            self.address[1],
            self.address[2],
            self.address[3],
        ])
    }

    /// Adds to the working counter.
    pub(super) fn count(&mut self, by: u16) {
        let count = u16::from_le_bytes([self.counter[0], self.counter[1]]).wrapping_add(by);
        self.counter.copy_from_slice(&count.to_le_bytes());
    }
}

impl Datagram<'_> {
    /// Replaces, with a probability of one in eight, a byte of data or working counter by another one, as a random number says.
    pub(super) fn garble(&mut self, random: u64) {
        let [value, chance, place @ ..] = random.to_le_bytes();
        if chance % 8 == 0 {
            let place = place
                .into_iter()
                .fold(0, |sum, byte| 256 * sum % 65_521 + usize::from(byte));
            let bytes = self.data.iter_mut().chain(self.counter.iter_mut());
            let bytes: Vec<&mut u8> = bytes.collect();
            let place = place % bytes.len();
            if let Some(byte) = bytes.into_iter().nth(place) {
                *byte = value;
            }
        }
    }
}

/// Hands each datagram of a frame to `process`. Returns false if it is no complete EtherCAT frame.
pub(super) fn for_each(frame: &mut [u8], mut process: impl FnMut(&mut Datagram<'_>)) -> bool {
    let Some((ethernet, payload)) = frame.split_at_mut_checked(ETHERNET_HEADER_BYTES) else {
        return false;
    };
    if !ethernet.ends_with(&ETHERTYPE) || payload.len() < HEADER_BYTES {
        return false;
    }
    let (header, payload) = payload.split_at_mut(HEADER_BYTES);
    let length = usize::from(u16::from_le_bytes([header[0], header[1]]) & LENGTH);
    let Some(mut rest) = payload.get_mut(..length) else {
        return false;
    };
    loop {
        let Some((header, behind)) = rest.split_at_mut_checked(DATAGRAM_HEADER_BYTES) else {
            return false;
        };
        let flags = u16::from_le_bytes([header[6], header[7]]);
        let Some((data, behind)) = behind.split_at_mut_checked(usize::from(flags & LENGTH)) else {
            return false;
        };
        let Some((counter, behind)) = behind.split_at_mut_checked(COUNTER_BYTES) else {
            return false;
        };
        process(&mut Datagram {
            command: header[0],
            address: &mut header[2..6],
            data,
            counter,
        });
        if flags & MORE == 0 {
            return true;
        }
        rest = behind;
    }
}
