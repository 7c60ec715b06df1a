//! A W5500 by its data sheet, as far as the driver may use it, in the worst case: its interrupt is raised by a frame that comes,
//! never by one that waits; frames sent without a link leave when there is one; frames without room are lost.

use super::world::Time;
use crate::w5500::chip::MEMORY_BYTES;
use embedded_hal_async::spi::{ErrorType, Operation, SpiDevice};
use std::cell::RefCell;
use std::convert::Infallible;
use std::future::poll_fn;
use std::rc::Rc;
use std::task::{Poll, Waker};

/// Time of a bit on the bus, and of each transaction in addition: select, DMA, interrupt, wake-up.
const BIT_NS: u64 = 50;
const TRANSACTION_NS: u64 = 5_000;
/// Time of a byte on the wire.
const BYTE_NS: u64 = 80;

const COMMON: u8 = 0;
const SOCKET: u8 = 1;
const TO_SEND: u8 = 2;
const RECEIVED: u8 = 3;

#[derive(Debug)]
pub(super) struct Emulated {
    /// It is supplied, and its bus is whole.
    pub(super) present: bool,
    pub(super) link: bool,
    /// No frame is sent.
    pub(super) jammed: bool,
    /// Frames on the wire, and when, ns.
    pub(super) sent: Vec<(u64, Vec<u8>)>,
    /// Number of transactions on the bus.
    pub(super) transactions: u64,
    common: [u8; 256],
    socket: [u8; 256],
    received: Vec<u8>,
    received_write: u16,
    received_read: u16,
    to_send: Vec<u8>,
    sent_until: u16,
    to_send_until: u16,
    /// The frame that is being sent: its address, and the end of sending, ns.
    leaving: (u16, u64),
    waker: Option<Waker>,
}

impl Emulated {
    pub(super) fn new(link: bool) -> Self {
        let memory = || vec![0; MEMORY_BYTES.into()];
        let mut chip = Self {
            present: true,
            link,
            jammed: false,
            sent: Vec::new(),
            transactions: 0,
            common: [0; 256],
            socket: [0; 256],
            received: memory(),
            received_write: 0,
            received_read: 0,
            to_send: memory(),
            sent_until: 0,
            to_send_until: 0,
            leaving: (0, 0),
            waker: None,
        };
        chip.forget();
        chip
    }

    /// Loses its configuration, as after a dip of its supply.
    pub(super) fn forget(&mut self) {
        self.common = [0; 256];
        self.socket = [0; 256];
        self.common[0x39] = 4;
        self.close();
    }

    /// Writes an impossible length where the next frame is.
    pub(super) fn spoil(&mut self, length: u16) {
        for (n, byte) in (0..).zip(length.to_be_bytes()) {
            let at = self.received_read.wrapping_add(n) % MEMORY_BYTES;
            self.received[usize::from(at)] = byte;
        }
    }

    pub(super) fn waits(&self) -> bool {
        self.received_write != self.received_read
    }

    pub(super) fn plug(&mut self, link: bool, now_ns: u64) {
        self.link = link;
        self.leave(now_ns);
    }

    /// A frame comes from the network.
    pub(super) fn arrive(&mut self, frame: &[u8]) {
        let used = self.received_write.wrapping_sub(self.received_read);
        let length = frame.len() as u16 + 2;
        let to_it = frame[0] & 1 == 1 || frame[..6] == self.common[0x09..0x0F];
        let has_room = MEMORY_BYTES - used >= length;
        if !self.link || self.socket[3] != 0x42 || !to_it || !has_room {
            return;
        }
        for byte in length.to_be_bytes().iter().chain(frame) {
            self.received[usize::from(self.received_write % MEMORY_BYTES)] = *byte;
            self.received_write = self.received_write.wrapping_add(1);
        }
        self.socket[2] |= 4;
        self.interrupt();
    }

    fn interrupts(&self) -> bool {
        self.present && self.socket[2] & self.socket[0x2C] != 0 && self.common[0x18] & 1 == 1
    }

    fn interrupt(&mut self) {
        if let Some(waker) = self.waker.take().filter(|_| self.interrupts()) {
            waker.wake();
        }
    }

    fn close(&mut self) {
        self.socket[3] = 0;
        (self.received_write, self.received_read) = (0, 0);
        (self.sent_until, self.to_send_until) = (0, 0);
        self.leaving = (0, 0);
        self.socket[0x24..0x26].fill(0);
        self.socket[0x28..0x2A].fill(0);
    }

    fn command(&mut self, command: u8, now_ns: u64) {
        let word = |at: usize| u16::from_be_bytes([self.socket[at], self.socket[at + 1]]);
        match command {
            0x01 if self.socket[0] == 0x84 && self.socket[0x1E] == 16 => self.socket[3] = 0x42,
            0x10 => self.close(),
            0x20 => {
                self.to_send_until = word(0x24);
                self.leave(now_ns);
            }
            0x40 => self.received_read = word(0x28),
            other => panic!("command {other}"),
        }
    }

    fn leave(&mut self, now_ns: u64) {
        let length = self.to_send_until.wrapping_sub(self.sent_until);
        if !self.link || self.jammed || length == 0 {
            return;
        }
        let at = |n| usize::from(self.sent_until.wrapping_add(n) % MEMORY_BYTES);
        let frame = (0..length).map(|n| self.to_send[at(n)]).collect();
        self.sent.push((now_ns, frame));
        let until_ns = now_ns + BYTE_NS * u64::from(length);
        self.leaving = (self.sent_until, until_ns);
        self.sent_until = self.to_send_until;
    }

    fn transact(&mut self, bytes: &mut [u8], now_ns: u64) {
        self.transactions += 1;
        if !self.present {
            bytes.fill(0);
            return;
        }
        let (header, data) = bytes.split_at_mut(3);
        let at = u16::from_be_bytes([header[0], header[1]]);
        let (block, writes) = (header[2] >> 3, header[2] & 4 != 0);
        self.count(now_ns);
        for (n, byte) in (0..).zip(data) {
            let at = at.wrapping_add(n);
            let (memory, at) = match block {
                COMMON => (&mut self.common[..], at),
                SOCKET => (&mut self.socket[..], at),
                TO_SEND => (&mut self.to_send[..], at % MEMORY_BYTES),
                RECEIVED => (&mut self.received[..], at % MEMORY_BYTES),
                // The other sockets have no memory.
                _ => continue,
            };
            let place = &mut memory[usize::from(at)];
            match (writes, (block, at)) {
                (false, _) => *byte = *place,
                (true, (SOCKET, 1)) => self.command(*byte, now_ns),
                // Writing ones clears bits.
                (true, (SOCKET, 2)) => *place &= !*byte,
                (true, _) => *place = *byte,
            }
        }
    }

    /// Registers that count.
    fn count(&mut self, now_ns: u64) {
        self.common[0x2E] = 0xB8 | u8::from(self.link);
        let waiting = self.received_write.wrapping_sub(self.received_read);
        let sent_until = match self.leaving {
            (from, until_ns) if now_ns < until_ns => from,
            _ => self.sent_until,
        };
        let free = MEMORY_BYTES - self.to_send_until.wrapping_sub(sent_until);
        self.socket[0x22..0x24].copy_from_slice(&sent_until.to_be_bytes());
        self.socket[0x20..0x22].copy_from_slice(&free.to_be_bytes());
        self.socket[0x26..0x28].copy_from_slice(&waiting.to_be_bytes());
    }
}

/// The bus of the chip.
pub(super) struct Bus(pub(super) Rc<RefCell<Emulated>>, pub(super) Rc<Time>);

impl ErrorType for Bus {
    type Error = Infallible;
}

impl SpiDevice for Bus {
    async fn transaction(
        &mut self,
        operations: &mut [Operation<'_, u8>],
    ) -> Result<(), Infallible> {
        let [Operation::TransferInPlace(bytes)] = operations else {
            panic!("{} operations", operations.len());
        };
        let takes_ns = TRANSACTION_NS + 8 * BIT_NS * bytes.len() as u64;
        self.1.wait_until_ns(self.1.now_ns() + takes_ns).await;
        self.0.borrow_mut().transact(bytes, self.1.now_ns());
        Ok(())
    }
}

/// Waits until its interrupt pin is low.
pub(super) async fn interrupt(chip: &RefCell<Emulated>) {
    poll_fn(|context| {
        let mut chip = chip.borrow_mut();
        if chip.interrupts() {
            return Poll::Ready(());
        }
        chip.waker = Some(context.waker().clone());
        Poll::Pending
    })
    .await;
}
