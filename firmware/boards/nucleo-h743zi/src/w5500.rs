//! The robot's network in the image with EtherCAT: a WIZnet W5500 on SPI1, on the Arduino connectors CN7.
#![allow(unsafe_code, reason = "a buffer in a section of its own")]

use crate::ethernet::mac_address;
use core::ptr::addr_of_mut;
use embassy_net_wiznet::chip::W5500;
use embassy_net_wiznet::{Device, State};
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
use embassy_time::Delay;
use embedded_hal_async::spi::{ErrorType, SpiBus};
use embedded_hal_bus::spi::ExclusiveDevice;
use static_cell::StaticCell;

/// Clock of the bus. The chip takes 33 MHz (data sheet, 5.5.4); from SPI1's 80 MHz that leaves 20.
const CLOCK: Hertz = Hertz::mhz(20);
/// Packets that wait to be looked at, and that wait to be sent.
const RX_PACKETS: usize = 8;
const TX_PACKETS: usize = 4;

/// Bytes that the DMA moves at once.
const BUFFER_BYTES: usize = 512;

/// What the DMA reads and writes: it reaches neither the stack nor what only a cache holds, so it gets memory of the
/// section that is made for the Ethernet's.
#[unsafe(link_section = ".ethernet")]
static mut BUFFER: [u8; BUFFER_BYTES] = [0; BUFFER_BYTES];

type Bus = ExclusiveDevice<BufferedSpi, Output<'static>, Delay>;

/// The network driver.
pub(crate) type Driver = Device<'static>;
/// What moves packets between chip and driver.
pub(crate) type Runner =
    embassy_net_wiznet::Runner<'static, W5500, Bus, ExtiInput<'static, Async>, Output<'static>>;

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
    /// D11, with the solder bridge as delivered: PB5. PA7 is the Ethernet's.
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

/// Resets the chip and starts it; once. None if it does not answer.
pub(crate) async fn start(pins: Pins) -> Option<(Driver, Runner)> {
    static STATE: StaticCell<State<RX_PACKETS, TX_PACKETS>> = StaticCell::new();
    let mut config = spi::Config::default();
    config.frequency = CLOCK;
    let bus = Spi::new(
        pins.spi, pins.sck, pins.mosi, pins.miso, pins.tx, pins.rx, Irqs, config,
    );
    let select = Output::new(pins.select, Level::High, Speed::VeryHigh);
    let bus = BufferedSpi {
        spi: bus,
        // SAFETY: this is the only reference, since `Pins` exists once; any bytes are valid.
        buffer: unsafe { &mut *addr_of_mut!(BUFFER) },
    };
    let Ok(device) = ExclusiveDevice::new(bus, select, Delay);
    let interrupt = ExtiInput::new(pins.interrupt, pins.exti, Pull::Up, Irqs);
    let reset = Output::new(pins.reset, Level::Low, Speed::Low);
    let state = STATE.try_init_with(State::new)?;
    let started = embassy_net_wiznet::new(mac_address(), state, device, interrupt, reset).await;
    match started {
        Ok(started) => Some(started),
        Err(error) => {
            defmt::error!(
                "the W5500 does not answer ({}): look at its supply and at the wires of CN7",
                defmt::Debug2Format(&error)
            );
            None
        }
    }
}

/// The bus, by way of [`BUFFER`].
pub(crate) struct BufferedSpi {
    spi: Spi<'static, Async, Master>,
    buffer: &'static mut [u8; BUFFER_BYTES],
}

impl ErrorType for BufferedSpi {
    type Error = spi::Error;
}

impl SpiBus for BufferedSpi {
    async fn read(&mut self, words: &mut [u8]) -> Result<(), spi::Error> {
        for part in words.chunks_mut(BUFFER_BYTES) {
            let (room, _) = self.buffer.split_at_mut(part.len());
            self.spi.read(room).await?;
            part.copy_from_slice(room);
        }
        Ok(())
    }

    async fn write(&mut self, words: &[u8]) -> Result<(), spi::Error> {
        for part in words.chunks(BUFFER_BYTES) {
            let (room, _) = self.buffer.split_at_mut(part.len());
            room.copy_from_slice(part);
            self.spi.write(room).await?;
        }
        Ok(())
    }

    /// What is written beyond what is read, and the other way round, is exchanged for nothing.
    async fn transfer(&mut self, read: &mut [u8], write: &[u8]) -> Result<(), spi::Error> {
        let both = read.len().min(write.len());
        let (read, read_on) = read.split_at_mut(both);
        let (write, write_on) = write.split_at(both);
        read.copy_from_slice(write);
        self.transfer_in_place(read).await?;
        self.read(read_on).await?;
        self.write(write_on).await
    }

    async fn transfer_in_place(&mut self, words: &mut [u8]) -> Result<(), spi::Error> {
        for part in words.chunks_mut(BUFFER_BYTES) {
            let (room, _) = self.buffer.split_at_mut(part.len());
            room.copy_from_slice(part);
            self.spi.transfer_in_place(room).await?;
            part.copy_from_slice(room);
        }
        Ok(())
    }

    async fn flush(&mut self) -> Result<(), spi::Error> {
        Ok(())
    }
}
