//! The Ethernet of the board, for the robot's network or for the EtherCAT segment of the sensor: the MAC, its buffers,
//! and the LAN8742, by RMII.
#![allow(unsafe_code, reason = "buffers in a section of their own")]

use core::mem::MaybeUninit;
use core::ptr::addr_of_mut;
use embassy_stm32::eth::{self, Ethernet, GenericPhy, PacketQueue, Sma};
use embassy_stm32::peripherals::{ETH, ETH_SMA, PA1, PA2, PA7, PB13, PC1, PC4, PC5, PG11, PG13};
use embassy_stm32::{Peri, bind_interrupts, uid};

bind_interrupts!(struct Irqs {
    ETH => eth::InterruptHandler;
});

/// Packets that wait to be sent, and that wait to be looked at: the robot sends one per cycle, the
/// rest is for other hosts' broadcasts and for telemetry.
const TX_PACKETS: usize = 4;
const RX_PACKETS: usize = 8;

/// The driver.
pub(crate) type Driver = Ethernet<'static, ETH, GenericPhy<Sma<'static, ETH_SMA>>>;

/// Descriptors and packets, where the DMA reaches them.
#[unsafe(link_section = ".ethernet")]
static mut QUEUE: MaybeUninit<PacketQueue<TX_PACKETS, RX_PACKETS>> = MaybeUninit::uninit();

/// Port and pins, as they are wired on the board (UM2407, Ethernet).
pub(crate) struct Pins {
    pub(crate) eth: Peri<'static, ETH>,
    pub(crate) sma: Peri<'static, ETH_SMA>,
    pub(crate) ref_clk: Peri<'static, PA1>,
    pub(crate) mdio: Peri<'static, PA2>,
    pub(crate) crs: Peri<'static, PA7>,
    pub(crate) tx_d1: Peri<'static, PB13>,
    pub(crate) mdc: Peri<'static, PC1>,
    pub(crate) rx_d0: Peri<'static, PC4>,
    pub(crate) rx_d1: Peri<'static, PC5>,
    pub(crate) tx_en: Peri<'static, PG11>,
    pub(crate) tx_d0: Peri<'static, PG13>,
}

/// Starts the MAC. To be called once.
pub(crate) fn start(pins: Pins) -> Driver {
    // SAFETY: this is the only reference, since `Pins` exists once.
    let queue = unsafe { &mut *addr_of_mut!(QUEUE) };
    PacketQueue::init(queue);
    // SAFETY: `init` has written every byte.
    let queue = unsafe { queue.assume_init_mut() };
    Ethernet::new(
        queue,
        pins.eth,
        Irqs,
        pins.ref_clk,
        pins.crs,
        pins.rx_d0,
        pins.rx_d1,
        pins.tx_d0,
        pins.tx_d1,
        pins.tx_en,
        mac_address(),
        pins.sma,
        pins.mdio,
        pins.mdc,
    )
}

/// A locally administered address made of the chip's unique number, so that two boards on one
/// network differ.
pub(crate) fn mac_address() -> [u8; 6] {
    // Numbers of one wafer differ in a few bytes only: all of them count.
    let [a, b, c, d, e, f, g, h, i, j, k, l] = uid::uid();
    [0x02, a ^ g, b ^ h, c ^ i, d ^ j, e ^ k ^ f ^ l]
}
