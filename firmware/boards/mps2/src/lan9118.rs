//! The LAN9118 Ethernet controller for `embassy-net`.
//!
//! Sources: SMSC LAN9118 data sheet, and QEMU's hw/net/lan9118.c, which aborts on access to a register that it does not know.
#![allow(unsafe_code, reason = "addresses of registers")]

use crate::chip;
use crate::interrupts::{self, Interrupt, Interrupt as interrupt};
use crate::register::Register;
use core::task::Context;
use embassy_net_driver::{Capabilities, Driver, HardwareAddress, LinkState};
use embassy_sync::waitqueue::AtomicWaker;
use softdock_app::micro::ethernet_link::EthernetLink;
use softdock_app::phy::Management;

/// Longest frame without its checksum, bytes: header and payload.
pub(crate) const FRAME_BYTES: usize = 1514;
/// Longest frame with its checksum of 4 bytes, which the controller passes on too, in whole words.
const BUFFER_BYTES: usize = 1520;
const CHECKSUM_BYTES: usize = 4;

const RX_DATA: Register = register(0x00);
const TX_DATA: Register = register(0x20);
const RX_STATUS: Register = register(0x40);
const IRQ_CFG: Register = register(0x54);
const INT_STS: Register = register(0x58);
const INT_EN: Register = register(0x5C);
const FIFO_INT: Register = register(0x68);
const TX_CFG: Register = register(0x70);
const HW_CFG: Register = register(0x74);
const RX_FIFO_INF: Register = register(0x7C);
const MAC_COMMAND: Register = register(0xA4);
const MAC_DATA: Register = register(0xA8);

/// Registers that are accessed through `MAC_COMMAND`.
const MAC_CR: u32 = 1;
const MAC_ADDRH: u32 = 2;
const MAC_ADDRL: u32 = 3;
const MAC_MII_ACCESS: u32 = 6;
const MAC_MII_DATA: u32 = 7;
const MAC_BUSY: u32 = 1 << 31;
const MAC_READ: u32 = 1 << 30;
/// Full duplex, transmitter and receiver on; frames for other addresses are filtered out.
const MAC_ON: u32 = 1 << 20 | 1 << 3 | 1 << 2;
/// Level of the receive status FIFO exceeded: a frame has arrived.
const RSFL: u32 = 1 << 3;
/// Error flag in the status of a frame.
const RX_ERROR: u32 = 1 << 15;

/// Wakes the task of the network.
static WAKER: AtomicWaker = AtomicWaker::new();

const fn register(offset: usize) -> Register {
    // SAFETY: the offsets above are those of the controller's registers.
    unsafe { Register::at(chip::ETHERNET + offset) }
}

/// The controller.
pub(crate) struct Lan9118 {
    address: [u8; 6],
    received: [u8; BUFFER_BYTES],
    to_send: [u8; FRAME_BYTES],
    link: EthernetLink<Phy>,
}

impl Lan9118 {
    /// Resets the controller and switches it on with hardware address `address`.
    pub(crate) fn start(address: [u8; 6]) -> Self {
        const SOFT_RESET: u32 = 1;
        HW_CFG.write(SOFT_RESET);
        // Store and forward, 5 kB of FIFO for sending.
        HW_CFG.write(0x0005_0000);
        // Transmitter on; the status of sent frames is discarded.
        TX_CFG.write(1 << 1 | 1 << 2);
        let [a0, a1, a2, a3, a4, a5] = address;
        mac_write(MAC_ADDRL, u32::from_le_bytes([a0, a1, a2, a3]));
        mac_write(MAC_ADDRH, u32::from_le_bytes([a4, a5, 0, 0]));
        mac_write(MAC_CR, MAC_ON);
        // An interrupt at the first frame.
        FIFO_INT.write(0x4800_0000);
        INT_STS.write(u32::MAX);
        INT_EN.write(RSFL);
        // Active high and push-pull, enabled. Before this the line is active low, so one interrupt is pending at boot.
        IRQ_CFG.write(0x111);
        interrupts::unmask(Interrupt::ETHERNET);
        let mut link = EthernetLink::new(Phy, true);
        link.reset();
        Self {
            address,
            received: [0; BUFFER_BYTES],
            to_send: [0; FRAME_BYTES],
            link,
        }
    }

    /// Takes the next good frame out of the FIFO; returns its length without checksum.
    fn next_frame(&mut self) -> Option<usize> {
        while RX_FIFO_INF.read() >> 16 & 0xFF != 0 {
            let status = RX_STATUS.read();
            let with_checksum = (status >> 16 & 0x3FFF) as usize;
            let mut words = self.received.chunks_exact_mut(4);
            for _ in 0..with_checksum.div_ceil(4) {
                let word = RX_DATA.read().to_le_bytes();
                if let Some(place) = words.next() {
                    place.copy_from_slice(&word);
                }
            }
            let length = with_checksum.saturating_sub(CHECKSUM_BYTES);
            if status & RX_ERROR == 0 && (1..=FRAME_BYTES).contains(&length) {
                return Some(length);
            }
        }
        None
    }
}

fn mac_write(index: u32, value: u32) {
    MAC_DATA.write(value);
    MAC_COMMAND.write(MAC_BUSY | index);
}

fn mac_read(index: u32) -> u32 {
    MAC_COMMAND.write(MAC_BUSY | MAC_READ | index);
    MAC_DATA.read()
}

/// The PHY inside of the controller, accessed through the MAC.
struct Phy;

impl Phy {
    /// Starts an access to a register; the emulated access is complete at once.
    fn access(register: u8, direction: u32) {
        const ADDRESS: u32 = 1 << 11;
        const BUSY: u32 = 1;
        mac_write(
            MAC_MII_ACCESS,
            ADDRESS | u32::from(register) << 6 | direction | BUSY,
        );
    }
}

impl Management for Phy {
    fn read(&mut self, register: u8) -> u16 {
        const ADVERTISEMENT: u8 = 4;
        /// 100 Mbit/s, half duplex: the emulated PHY always offers it.
        const ALWAYS_OFFERED: u32 = 1 << 7;
        Self::access(register, 0);
        let value = match register {
            ADVERTISEMENT => mac_read(MAC_MII_DATA) & !ALWAYS_OFFERED,
            _ => mac_read(MAC_MII_DATA),
        };
        // The register has 16 bits.
        value as u16
    }

    fn write(&mut self, register: u8, value: u16) {
        const WRITE: u32 = 1 << 1;
        mac_write(MAC_MII_DATA, value.into());
        Self::access(register, WRITE);
    }
}

/// Passes a frame to the controller, which sends it when its last word is written.
pub(crate) fn transmit(frame: &[u8]) {
    const FIRST_AND_LAST: u32 = 1 << 13 | 1 << 12;
    // At most 1514.
    let length = frame.len() as u32;
    TX_DATA.write(FIRST_AND_LAST | length);
    TX_DATA.write(length);
    for chunk in frame.chunks(4) {
        let mut word = [0; 4];
        for (byte, value) in word.iter_mut().zip(chunk) {
            *byte = *value;
        }
        TX_DATA.write(u32::from_le_bytes(word));
    }
}

/// A received frame.
pub(crate) struct RxToken<'a>(&'a mut [u8]);

impl embassy_net_driver::RxToken for RxToken<'_> {
    fn consume<R, F: FnOnce(&mut [u8]) -> R>(self, read: F) -> R {
        read(self.0)
    }
}

/// Room for a frame.
pub(crate) struct TxToken<'a>(&'a mut [u8; FRAME_BYTES]);

impl embassy_net_driver::TxToken for TxToken<'_> {
    fn consume<R, F: FnOnce(&mut [u8]) -> R>(self, length: usize, write: F) -> R {
        // The network stack stays within `max_transmission_unit`.
        let length = length.min(FRAME_BYTES);
        let (frame, _) = self.0.split_at_mut(length);
        let result = write(frame);
        transmit(frame);
        result
    }
}

impl Driver for Lan9118 {
    type RxToken<'a> = RxToken<'a>;
    type TxToken<'a> = TxToken<'a>;

    fn receive(&mut self, context: &mut Context<'_>) -> Option<(RxToken<'_>, TxToken<'_>)> {
        // Register the waker before the check, so that a frame that arrives in between wakes the task.
        WAKER.register(context.waker());
        let length = self.next_frame()?;
        let frame = self.received.get_mut(..length)?;
        Some((RxToken(frame), TxToken(&mut self.to_send)))
    }

    fn transmit(&mut self, _context: &mut Context<'_>) -> Option<TxToken<'_>> {
        Some(TxToken(&mut self.to_send))
    }

    fn link_state(&mut self, context: &mut Context<'_>) -> LinkState {
        match self.link.is_up(context) {
            true => LinkState::Up,
            false => LinkState::Down,
        }
    }

    fn capabilities(&self) -> Capabilities {
        let mut capabilities = Capabilities::default();
        capabilities.max_transmission_unit = FRAME_BYTES;
        capabilities
    }

    fn hardware_address(&self) -> HardwareAddress {
        HardwareAddress::Ethernet(self.address)
    }
}

#[cortex_m_rt::interrupt]
fn ETHERNET() {
    // A frame raises the interrupt when it arrives, not while it waits: clear first, then take all frames.
    INT_STS.write(u32::MAX);
    WAKER.wake();
}
