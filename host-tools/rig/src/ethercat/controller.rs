//! The SubDevice controller: registers, memory, FMMUs and SyncManagers (ETG.1000.4, 6).

use super::datagram::Datagram;
use super::states::{AlState, Configured, Refused};

/// Registers, then memory.
const MEMORY_BYTES: usize = 0x2000;
const STATION: usize = 0x0010;
const DL_STATUS: usize = 0x0110;
const AL_CONTROL: usize = 0x0120;
const AL_STATUS: usize = 0x0130;
const AL_STATUS_CODE: usize = 0x0134;
const AL_END: usize = 0x0136;
const SII_CONTROL: usize = 0x0502;
const SII_ADDRESS: usize = 0x0504;
const SII_DATA: usize = 0x0508;
const FMMU: usize = 0x0600;
const FMMU_BYTES: usize = 16;
const FMMUS: usize = 3;
const SYNC_MANAGER: usize = 0x0800;
const SYNC_MANAGER_BYTES: usize = 8;
const SYNC_MANAGERS: usize = 4;

/// In `AL_CONTROL`: acknowledge an error. In `AL_STATUS`: an error has occurred.
const AL_ERROR: u8 = 0x10;
/// In the second byte of `SII_CONTROL`.
const SII_READ: u8 = 0x01;
/// In a SyncManager's status.
const MAILBOX_FULL: u8 = 0x08;

/// The SyncManagers by their use.
pub(super) const MAILBOX_IN: usize = 0;
pub(super) const MAILBOX_OUT: usize = 1;
const OUTPUTS: usize = 2;
const INPUTS: usize = 3;

/// An area of the memory that a SyncManager guards.
#[derive(Clone, Copy, Debug)]
struct Area {
    start: usize,
    length: usize,
    enabled: bool,
}

/// Registers and memory.
#[derive(Clone, Debug)]
pub(super) struct Controller {
    memory: Vec<u8>,
    sii: Vec<u8>,
    /// Lengths of outputs and inputs of the application, bytes.
    process_data: [usize; 2],
    /// A request that has come into the mailbox.
    pub(super) request: Option<Vec<u8>>,
}

impl Controller {
    /// As after power-up.
    pub(super) fn new(sii: Vec<u8>, process_data: [usize; 2]) -> Self {
        let mut memory = vec![0; MEMORY_BYTES];
        // Type, revision, build, FMMUs, SyncManagers, kB of memory, two MII ports.
        let about = [0x11, 0, 0, 0, FMMUS as u8, SYNC_MANAGERS as u8, 4, 0x0F];
        memory[..about.len()].copy_from_slice(&about);
        memory[AL_STATUS] = AlState::Init as u8;
        Self {
            memory,
            sii,
            process_data,
            request: None,
        }
    }

    /// Replaces a byte of the EEPROM.
    pub(super) fn spoil_sii(&mut self, at: usize, by: u8) {
        let at = at % self.sii.len();
        self.sii[at] = by;
    }

    /// Which ports have a link: the one towards the MainDevice, and perhaps one onwards. The others are closed.
    pub(super) fn set_links(&mut self, onwards: bool) {
        const OPERATIONAL: u16 = 0x0003;
        let open = |port: u16| 1 << (4 + port) | 1 << (9 + 2 * port);
        let closed = |port: u16| 1 << (8 + 2 * port);
        let second = if onwards { open(1) } else { closed(1) };
        let status: u16 = OPERATIONAL | open(0) | second | closed(2) | closed(3);
        self.memory[DL_STATUS..][..2].copy_from_slice(&status.to_le_bytes());
    }

    pub(super) fn state(&self) -> AlState {
        AlState::from_number(self.memory[AL_STATUS] & 0xF).unwrap_or(AlState::Init)
    }

    /// Goes into a state by itself, with an error.
    pub(super) fn fall(&mut self, state: AlState, code: u16) {
        self.memory[AL_STATUS] = state as u8 | AL_ERROR;
        self.memory[AL_STATUS_CODE..][..2].copy_from_slice(&code.to_le_bytes());
    }

    /// The outputs as they were written last.
    pub(super) fn outputs(&self) -> &[u8] {
        let area = self.area(OUTPUTS);
        self.memory
            .get(area.start..area.start + self.process_data[0])
            .unwrap_or_default()
    }

    /// Sets what the MainDevice reads next.
    pub(super) fn set_inputs(&mut self, inputs: &[u8]) {
        let start = self.area(INPUTS).start;
        if let Some(place) = self.memory.get_mut(start..start + inputs.len()) {
            place.copy_from_slice(inputs);
        }
    }

    /// Puts an answer into the mailbox, if it is empty.
    pub(super) fn answer(&mut self, message: &[u8]) -> bool {
        let area = self.area(MAILBOX_OUT);
        let empty = self.memory[status(MAILBOX_OUT)] & MAILBOX_FULL == 0;
        if !(area.enabled && empty && message.len() <= area.length) {
            return false;
        }
        let place = &mut self.memory[area.start..area.start + area.length];
        place.fill(0);
        place[..message.len()].copy_from_slice(message);
        self.memory[status(MAILBOX_OUT)] |= MAILBOX_FULL;
        true
    }

    /// Carries out a datagram as it passes.
    pub(super) fn process(&mut self, datagram: &mut Datagram<'_>) {
        // Commands come in threes: read, write, both (ETG.1000.4, table 13).
        let (addressing, access) = match datagram.command {
            1..=12 => ((datagram.command - 1) / 3, (datagram.command - 1) % 3),
            // Read, multiple write: this one reads, the others are written.
            13 | 14 => return self.read_multiple_write(datagram),
            _ => return,
        };
        let addressed = match addressing {
            0 => {
                let position = datagram.device();
                datagram.set_device(position.wrapping_add(1));
                position == 0
            }
            1 => datagram.device() == self.station(),
            2 => {
                let passed = datagram.device();
                datagram.set_device(passed.wrapping_add(1));
                true
            }
            _ => return self.logical(datagram, access != 1, access != 0),
        };
        if addressed {
            self.physical(datagram, (access != 1, access != 0), addressing == 2);
        }
    }

    fn read_multiple_write(&mut self, datagram: &mut Datagram<'_>) {
        let addressed = match datagram.command {
            13 => {
                let position = datagram.device();
                datagram.set_device(position.wrapping_add(1));
                position == 0
            }
            _ => datagram.device() == self.station(),
        };
        self.physical(datagram, (addressed, !addressed), false);
    }

    fn physical(&mut self, datagram: &mut Datagram<'_>, (read, write): (bool, bool), or: bool) {
        let offset = usize::from(datagram.offset());
        let written = datagram.data.to_vec();
        if read && self.read(offset, datagram.data, or) {
            datagram.count(1);
        }
        if write && self.write(offset, &written) {
            datagram.count(if read { 2 } else { 1 });
        }
    }

    fn station(&self) -> u16 {
        self.word(STATION)
    }

    fn word(&self, at: usize) -> u16 {
        u16::from_le_bytes([self.memory[at], self.memory[at + 1]])
    }

    fn area(&self, manager: usize) -> Area {
        let at = SYNC_MANAGER + manager * SYNC_MANAGER_BYTES;
        let start = usize::from(self.word(at));
        let length = usize::from(self.word(at + 2));
        Area {
            start,
            length,
            enabled: self.memory[at + 6] & 1 != 0 && start + length <= MEMORY_BYTES,
        }
    }

    /// Reads memory, combining it with the data by OR if `or`. Returns whether the data were read.
    fn read(&mut self, offset: usize, data: &mut [u8], or: bool) -> bool {
        let Some(found) = self.memory.get(offset..offset + data.len()) else {
            return false;
        };
        let mailbox = self.area(MAILBOX_OUT);
        let ends_mailbox = mailbox.enabled && offset + data.len() == mailbox.start + mailbox.length;
        if mailbox.enabled && offset == mailbox.start {
            if self.memory[status(MAILBOX_OUT)] & MAILBOX_FULL == 0 {
                return false;
            }
            if ends_mailbox {
                data.copy_from_slice(found);
                self.memory[status(MAILBOX_OUT)] &= !MAILBOX_FULL;
                return true;
            }
        }
        for (to, from) in data.iter_mut().zip(found) {
            *to = if or { *to | from } else { *from };
        }
        true
    }

    /// Writes memory. Returns whether the data were written.
    fn write(&mut self, offset: usize, data: &[u8]) -> bool {
        if offset + data.len() > MEMORY_BYTES {
            return false;
        }
        let mailbox = self.area(MAILBOX_IN);
        if mailbox.enabled && offset == mailbox.start {
            if self.request.is_some() {
                return false;
            }
            if data.len() == mailbox.length {
                self.request = Some(data.to_vec());
            }
            return true;
        }
        match offset {
            AL_CONTROL => self.control(data.first().copied().unwrap_or_default()),
            // Only the SubDevice itself writes its status.
            AL_STATUS..AL_END => return false,
            _ => {
                self.memory[offset..offset + data.len()].copy_from_slice(data);
                self.access_sii(offset, data);
            }
        }
        true
    }

    fn control(&mut self, word: u8) {
        if word & AL_ERROR != 0 {
            self.memory[AL_STATUS] &= !AL_ERROR;
            self.memory[AL_STATUS_CODE..][..2].fill(0);
        }
        let area = |manager| {
            let area = self.area(manager);
            (area.enabled, area.length)
        };
        let configured = Configured {
            mailbox: area(MAILBOX_IN).0 && area(MAILBOX_OUT).0,
            outputs: area(OUTPUTS) == (true, self.process_data[0]),
            inputs: area(INPUTS) == (true, self.process_data[1]),
        };
        match self.state().request(word & 0xF, configured) {
            Ok(state) => self.memory[AL_STATUS] = state as u8,
            Err(refused) => self.refuse(refused),
        }
    }

    fn refuse(&mut self, refused: Refused) {
        let state = self.state();
        self.fall(state, refused as u16);
    }

    fn access_sii(&mut self, offset: usize, data: &[u8]) {
        let commanded = (offset..offset + data.len()).contains(&(SII_CONTROL + 1));
        if commanded && self.memory[SII_CONTROL + 1] & SII_READ != 0 {
            let at = 2 * usize::from(self.word(SII_ADDRESS));
            for (n, byte) in self.memory[SII_DATA..SII_DATA + 4].iter_mut().enumerate() {
                *byte = self.sii.get(at + n).copied().unwrap_or(0xFF);
            }
        }
        if commanded {
            // It is done at once: neither busy nor an error.
            self.memory[SII_CONTROL..][..2].fill(0);
        }
    }

    /// Exchanges what the FMMUs map (ETG.1000.4, 6.6).
    fn logical(&mut self, datagram: &mut Datagram<'_>, read: bool, write: bool) {
        let begin = u64::from(datagram.logical());
        let (mut has_read, mut has_written) = (false, false);
        for number in 0..FMMUS {
            let at = FMMU + number * FMMU_BYTES;
            let mapped = u32::from(self.word(at)) | u32::from(self.word(at + 2)) << 16;
            let length = usize::from(self.word(at + 4));
            let physical = usize::from(self.word(at + 8));
            let (direction, enabled) = (self.memory[at + 11], self.memory[at + 12]);
            let Some(first) = u64::from(mapped)
                .checked_sub(begin)
                .and_then(|n| usize::try_from(n).ok())
            else {
                continue;
            };
            let (Some(data), Some(memory)) = (
                datagram.data.get_mut(first..first + length),
                self.memory.get_mut(physical..physical + length),
            ) else {
                continue;
            };
            let exchanging = enabled & 1 != 0 && length > 0;
            if exchanging && read && direction & 1 != 0 {
                data.copy_from_slice(memory);
                has_read = true;
            }
            if exchanging && write && direction & 2 != 0 {
                memory.copy_from_slice(data);
                has_written = true;
            }
        }
        let operating = self.state() >= AlState::SafeOp;
        if has_read && operating {
            datagram.count(1);
        }
        if has_written && operating {
            datagram.count(if read { 2 } else { 1 });
        }
    }
}

/// Address of the status of a SyncManager.
const fn status(manager: usize) -> usize {
    SYNC_MANAGER + manager * SYNC_MANAGER_BYTES + 5
}
