//! The robot's network in the image with EtherCAT: a WIZnet W5500 on SPI1, on the Arduino connectors CN7.
#![allow(unsafe_code, reason = "a buffer in a section of its own")]

use crate::ethernet::mac_address;
use core::convert::Infallible;
use core::ptr::addr_of_mut;
use embassy_net_driver::HardwareAddress;
use embassy_net_driver_channel::{self as channel, Device, State};
use embassy_stm32::exti::{self, ExtiInput};
use embassy_stm32::gpio::{Level, Output, Pull, Speed};
use embassy_stm32::mode::Async;
use embassy_stm32::peripherals::{
    DMA1_CH0, DMA1_CH1, EXTI15, PA5, PA6, PB5, PD14, PD15, PF12, SPI1,
};
use embassy_stm32::spi::mode::Master;
use embassy_stm32::spi::{self, Spi};
use embassy_stm32::time::Hertz;
use embassy_stm32::{Peri, bind_interrupts, dma, interrupt};
use embassy_time::{Delay, Timer};
use embedded_hal_bus::spi::ExclusiveDevice;
use softdock_app::micro::clock::UptimeClock;
use softdock_app::micro::ethernet_link::tell;
use softdock_app::w5500::{Buffer, Chip, FRAME_BYTES, Health, run};
use static_cell::StaticCell;

/// Clock of the bus. The chip allows 33 MHz (data sheet, 5.5.4); from SPI1's 80 MHz, 20 MHz is the nearest below.
const CLOCK: Hertz = Hertz::mhz(20);
/// Received packets that may wait, and packets that may wait to be sent.
const RX_PACKETS: usize = 8;
const TX_PACKETS: usize = 4;

/// Time for the chip's own clock to start, ms.
const RESET_MS: u64 = 100;

/// Buffer of the DMA, which can access neither the stack nor data that is only in a cache. So it lies in the section for the
/// Ethernet.
#[unsafe(link_section = ".ethernet")]
static mut BUFFER: Buffer = [0; size_of::<Buffer>()];

type Bus = ExclusiveDevice<Spi<'static, Async, Master>, Output<'static>, Delay>;

/// The network driver.
pub(crate) type Driver = Device<'static, FRAME_BYTES>;

bind_interrupts!(struct Irqs {
    DMA1_STREAM0 => dma::InterruptHandler<DMA1_CH0>;
    DMA1_STREAM1 => dma::InterruptHandler<DMA1_CH1>;
    EXTI15_10 => exti::InterruptHandler<interrupt::typelevel::EXTI15_10>;
});

/// Bus and pins (UM2407, Arduino connectors).
pub(crate) struct Pins {
    pub(crate) spi: Peri<'static, SPI1>,
    /// D13.
    pub(crate) sck: Peri<'static, PA5>,
    /// D11, with the solder bridge as delivered: PB5. PA7 belongs to the Ethernet.
    pub(crate) mosi: Peri<'static, PB5>,
    /// D12.
    pub(crate) miso: Peri<'static, PA6>,
    pub(crate) tx: Peri<'static, DMA1_CH0>,
    pub(crate) rx: Peri<'static, DMA1_CH1>,
    /// D10.
    pub(crate) select: Peri<'static, PD14>,
    /// D9.
    pub(crate) interrupt: Peri<'static, PD15>,
    pub(crate) exti: Peri<'static, EXTI15>,
    /// D8.
    pub(crate) reset: Peri<'static, PF12>,
}

/// Resets the chip; returns the network driver and the task that moves packets between both. None if it was started before.
pub(crate) async fn start(pins: Pins) -> Option<(Driver, Runner)> {
    static STATE: StaticCell<State<FRAME_BYTES, RX_PACKETS, TX_PACKETS>> = StaticCell::new();
    let state = STATE.try_init_with(State::new)?;
    let mut config = spi::Config::default();
    config.frequency = CLOCK;
    let bus = Spi::new(
        pins.spi, pins.sck, pins.mosi, pins.miso, pins.tx, pins.rx, Irqs, config,
    );
    let select = Output::new(pins.select, Level::High, Speed::VeryHigh);
    let Ok(device) = ExclusiveDevice::new(bus, select, Delay);
    let interrupt = ExtiInput::new(pins.interrupt, pins.exti, Pull::Up, Irqs);
    // Data sheet, 5.5.1: half a millisecond of reset, and one until the chip's clock has started.
    let mut reset = Output::new(pins.reset, Level::Low, Speed::Low);
    Timer::after_millis(1).await;
    reset.set_high();
    Timer::after_millis(RESET_MS).await;
    let address = mac_address();
    // SAFETY: this is the only reference, since `Pins` exists once; any bytes are valid.
    let buffer = unsafe { &mut *addr_of_mut!(BUFFER) };
    let (frames, driver) = channel::new(state, HardwareAddress::Ethernet(address));
    let runner = Runner {
        chip: Chip::new(device, buffer, address),
        interrupt,
        frames,
        _reset: reset,
    };
    Some((driver, runner))
}

/// Moves packets between chip and driver.
pub(crate) struct Runner {
    chip: Chip<'static, Bus>,
    interrupt: ExtiInput<'static, Async>,
    frames: channel::Runner<'static, FRAME_BYTES>,
    /// Kept, because dropping it would release the pin.
    _reset: Output<'static>,
}

impl Runner {
    /// Runs forever.
    pub(crate) async fn run(mut self) -> Infallible {
        let mut answered = true;
        let low = async || self.interrupt.wait_for_low().await;
        let onlookers = |health: &Health| {
            tell(|ethernet| *ethernet = health.ethernet);
            if answered && !health.answers {
                defmt::error!(
                    "the W5500 does not answer: look at its supply and at the wires of CN7"
                );
            }
            answered = health.answers;
        };
        run(self.chip, low, self.frames, &UptimeClock, onlookers).await
    }
}
