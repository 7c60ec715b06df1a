//! The Ethernet of the board, for the robot's network or for the EtherCAT segment of the sensor: the MAC, its buffers, and
//! the LAN8742, connected by RMII.
//!
//! [`watch`] supervises the DMA and the link, see [`softdock_app::ethernet_dma`] and [`softdock_app::phy`].
#![allow(unsafe_code, reason = "buffers in a section of their own")]

use core::mem::MaybeUninit;
use core::ptr::addr_of_mut;
use core::sync::atomic::{AtomicU32, Ordering};
use core::task::Context;
use embassy_net_driver::{Capabilities, Driver as NetworkDriver, HardwareAddress, LinkState};
use embassy_stm32::eth::{self, Ethernet, PacketQueue, Phy, Sma, StationManagement};
use embassy_stm32::pac::ETH as REGISTERS;
use embassy_stm32::peripherals::{ETH, ETH_SMA, PA1, PA2, PA7, PB13, PC1, PC4, PC5, PG11, PG13};
use embassy_stm32::{Peri, bind_interrupts, uid};
use embassy_time::{Duration, Ticker, Timer};
use softdock_app::ethernet_dma::{self, Channel, Cure, DmaMonitor};
use softdock_app::micro::ethernet_link::{EthernetLink, tell};
use softdock_app::phy::Management;

bind_interrupts!(struct Irqs {
    ETH => eth::InterruptHandler;
});

/// Packets that may wait to be sent, and received packets that may wait: the robot sends one per cycle, the others are for
/// broadcasts of other hosts and for telemetry.
const TX_PACKETS: usize = 4;
const RX_PACKETS: usize = 8;

/// The PHY's address on its management bus (UM2407, Ethernet: PHYAD0 is low).
const PHY_ADDRESS: u8 = 0;

/// Whether the state of the link is reported as that of the robot's network. For a sensor, the sensor's state reports it.
const TOLD: bool = !cfg!(feature = "ethercat");

/// Received frames, for [`watch`]; wraps.
static FRAMES: AtomicU32 = AtomicU32::new(0);

/// Descriptors and packets, in memory that the DMA can access.
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
    let bus = Bus(Sma::new(pins.sma, pins.mdio, pins.mdc));
    let phy = Lan8742(EthernetLink::new(bus, TOLD));
    Driver(Ethernet::new_with_phy(
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
        phy,
    ))
}

/// The network driver of this board. Another protocol on the same port would wrap it and take its frames before the network
/// stack gets them.
pub(crate) struct Driver(Ethernet<'static, ETH, Lan8742>);

impl NetworkDriver for Driver {
    type RxToken<'a> = eth::RxToken<'a, 'static>;
    type TxToken<'a> = eth::TxToken<'a, 'static>;

    fn receive(&mut self, cx: &mut Context<'_>) -> Option<(Self::RxToken<'_>, Self::TxToken<'_>)> {
        let tokens = self.0.receive(cx)?;
        let frames = FRAMES.load(Ordering::Relaxed);
        FRAMES.store(frames.wrapping_add(1), Ordering::Relaxed);
        Some(tokens)
    }

    fn transmit(&mut self, cx: &mut Context<'_>) -> Option<Self::TxToken<'_>> {
        self.0.transmit(cx)
    }

    fn link_state(&mut self, cx: &mut Context<'_>) -> LinkState {
        self.0.link_state(cx)
    }

    fn capabilities(&self) -> Capabilities {
        self.0.capabilities()
    }

    fn hardware_address(&self) -> HardwareAddress {
        self.0.hardware_address()
    }
}

/// The PHY. Embassy's own driver reads it over the slow management bus whenever the network is polled, several times in a
/// cycle.
pub(crate) struct Lan8742(EthernetLink<Bus>);

/// Management bus of the PHY.
struct Bus(Sma<'static, ETH_SMA>);

impl Management for Bus {
    fn read(&mut self, register: u8) -> u16 {
        self.0.smi_read(PHY_ADDRESS, register)
    }

    fn write(&mut self, register: u8, value: u16) {
        self.0.smi_write(PHY_ADDRESS, register, value);
    }
}

impl Phy for Lan8742 {
    fn phy_reset(&mut self) {
        self.0.reset();
    }

    /// [`EthernetLink::is_up`] configures the offered modes after the reset of the PHY.
    fn phy_init(&mut self) {}

    fn poll_link(&mut self, cx: &mut Context<'_>) -> bool {
        self.0.is_up(cx)
    }
}

/// Supervises the DMA forever; for the executor of the network.
#[embassy_executor::task]
pub(crate) async fn watch() -> ! {
    let mut monitor = DmaMonitor::default();
    let mut ticker = Ticker::every(Duration::from_micros(ethernet_dma::PERIOD_US));
    loop {
        ticker.next().await;
        let (receive, transmit) = channels();
        let cure = monitor.look(receive, transmit, FRAMES.load(Ordering::Relaxed));
        if TOLD {
            tell(|ethernet| ethernet.overruns = monitor.overruns());
        }
        match cure {
            None => {}
            Some(Cure::Resume) => resume(),
            Some(Cure::Restart) => restart().await,
            Some(Cure::StartOver) => {
                softdock_crash::give_up("the Ethernet's DMA does not start again")
            }
        }
    }
}

/// State of both channels from the DMA's debug status register (RM0433, 58.11.2, ETH_DMADSR: TPS0 and RPS0).
fn channels() -> (Channel, Channel) {
    let status = REGISTERS.ethernet_dma().dmadsr().read();
    let channel = |state: u8, suspended: u8| match state {
        0 => Channel::Stopped,
        state if state == suspended => Channel::Suspended,
        _ => Channel::Running,
    };
    (channel(status.rps0(), 0b100), channel(status.tps0(), 0b110))
}

/// Writes the tail pointer, which makes the DMA read its descriptors again.
fn resume() {
    let tail = REGISTERS.ethernet_dma().dmacrx_dtpr();
    tail.write(|w| w.0 = tail.read().0);
}

/// Stops and starts both directions, without a change of the rings.
async fn restart() {
    let dma = REGISTERS.ethernet_dma();
    dma.dmacrx_cr().modify(|w| w.set_sr(false));
    dma.dmactx_cr().modify(|w| w.set_st(false));
    // Wait for the end of a frame in progress: 1518 bytes at 100 Mbit/s are 122 µs.
    Timer::after_micros(200).await;
    dma.dmactx_cr().modify(|w| w.set_st(true));
    dma.dmacrx_cr().modify(|w| w.set_sr(true));
    resume();
}

/// A locally administered address made of the chip's unique number, so that two boards on one
/// network differ.
pub(crate) fn mac_address() -> [u8; 6] {
    // The unique numbers of one wafer differ in a few bytes only, so all bytes are used.
    let [a, b, c, d, e, f, g, h, i, j, k, l] = uid::uid();
    [0x02, a ^ g, b ^ h, c ^ i, d ^ j, e ^ k ^ f ^ l]
}
