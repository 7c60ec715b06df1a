//! The sensor's bus: FDCAN1 on PD0 and PD1, classic CAN at 1 Mbit/s.

use embassy_stm32::can::config::{FdCanConfig, FrameTransmissionConfig, TxBufferMode};
use embassy_stm32::can::enums::BusErrorMode;
use embassy_stm32::can::frame::{Frame as FdcanFrame, Header};
use embassy_stm32::can::{self, Can, CanConfigurator, OperatingMode};
use embassy_stm32::peripherals::{FDCAN1, PD0, PD1};
use embassy_stm32::{Peri, bind_interrupts, pac};
use softdock_app::board::{IoError, SensorBus};
use softdock_link::can::{Frame, Id};

/// Bits per second; the rate of both supported sensors.
const BITRATE: u32 = 1_000_000;

bind_interrupts!(struct Irqs {
    FDCAN1_IT0 => can::IT0InterruptHandler<FDCAN1>;
    FDCAN1_IT1 => can::IT1InterruptHandler<FDCAN1>;
});

/// FDCAN1.
pub(crate) struct Bus(Can<'static>);

impl Bus {
    /// Starts the controller.
    pub(crate) fn start(
        fdcan: Peri<'static, FDCAN1>,
        rx: Peri<'static, PD0>,
        tx: Peri<'static, PD1>,
    ) -> Self {
        let mut can = CanConfigurator::new(fdcan, rx, tx, Irqs);
        can.set_config(
            FdCanConfig::default()
                .set_frame_transmit(FrameTransmissionConfig::ClassicCanOnly)
                // Requests leave in the order in which they were made.
                .set_tx_buffer_mode(TxBufferMode::Fifo)
                // The sensor task decides when, and how often.
                .set_automatic_bus_off_recovery(false),
        );
        can.set_bitrate(BITRATE);
        Self(can.start(OperatingMode::NormalOperationMode))
    }

    fn check(&self) -> Result<(), IoError> {
        match self.0.properties().bus_error_mode() {
            BusErrorMode::BusOff => Err(IoError::BusOff),
            BusErrorMode::ErrorActive | BusErrorMode::ErrorPassive => Ok(()),
        }
    }
}

impl SensorBus for Bus {
    type Frame = Frame;

    async fn send(&mut self, frame: &Frame) -> Result<(), IoError> {
        self.check()?;
        let frame = to_fdcan(frame).ok_or(IoError::Lost)?;
        // A FIFO gives no frame back.
        let _ = self.0.write(&frame).await;
        Ok(())
    }

    async fn receive(&mut self) -> Result<Frame, IoError> {
        self.check()?;
        let envelope = self.0.read().await;
        // The controller reports an error of the line together with its state.
        let envelope = envelope.map_err(|_| self.check().err().unwrap_or(IoError::Lost))?;
        from_fdcan(&envelope.frame).ok_or(IoError::Lost)
    }

    async fn recover(&mut self) -> Result<(), IoError> {
        // Leaving the initialisation begins the recovery: 129 times 11 recessive bits, 1.4 ms.
        pac::FDCAN1.cccr().modify(|w| w.set_init(false));
        Ok(())
    }
}

fn to_fdcan(frame: &Frame) -> Option<FdcanFrame> {
    let id: embedded_can::Id = match frame.id() {
        Id::Standard(id) => embedded_can::StandardId::new(id)?.into(),
        Id::Extended(id) => embedded_can::ExtendedId::new(id)?.into(),
    };
    let length = u8::try_from(frame.dlc()).ok()?;
    FdcanFrame::new(Header::new(id, length, frame.is_remote()), frame.data()).ok()
}

fn from_fdcan(frame: &FdcanFrame) -> Option<Frame> {
    let header = frame.header();
    let id = match *header.id() {
        embedded_can::Id::Standard(id) => Id::Standard(id.as_raw()),
        embedded_can::Id::Extended(id) => Id::Extended(id.as_raw()),
    };
    if header.rtr() {
        return Frame::new_remote(id, header.len().into()).ok();
    }
    let data = frame.data().get(..header.len().into())?;
    Frame::new(id, data).ok()
}
