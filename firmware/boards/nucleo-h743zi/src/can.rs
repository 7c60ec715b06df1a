//! The sensor's bus: FDCAN1 on PD0 and PD1, classic CAN at 1 Mbit/s.

use crate::can_fifo;
use core::num::{NonZeroU8, NonZeroU16};
use core::task::Poll;
use embassy_futures::poll_once;
use embassy_stm32::can::config::{
    FdCanConfig, FrameTransmissionConfig, NominalBitTiming, TxBufferMode,
};
use embassy_stm32::can::enums::BusErrorMode;
use embassy_stm32::can::frame::{Frame as FdcanFrame, Header};
use embassy_stm32::can::{self, BufferedCan, CanConfigurator, OperatingMode, RxBuf, TxBuf};
use embassy_stm32::interrupt::{self, InterruptExt};
use embassy_stm32::pac::FDCAN1 as REGISTERS;
use embassy_stm32::peripherals::{FDCAN1, PD0, PD1};
use embassy_stm32::{Peri, bind_interrupts, rcc};
use embassy_time::Timer;
use softdock_app::board::{IoError, SensorBus};
use softdock_app::can_queue::Handed;
use softdock_app::loop_back::loop_back;
use softdock_app::micro::clock::UptimeClock;
use softdock_link::can::{BitTiming, Frame, Id};
use softdock_link::sensor::SensorFault;
use softdock_link::service::LoopBack;
use static_cell::ConstStaticCell;

/// Bits per second; the rate of both supported sensors.
const BITRATE: u32 = 1_000_000;
/// Clock of the controller (`clocks.rs`), Hz.
const CLOCK_HZ: u32 = 80_000_000;
/// Twenty quanta of 50 ns, sampled after 17 of them: 85 %. Embassy would choose 90 %.
const PRESCALER: NonZeroU16 = NonZeroU16::new(4).unwrap();
const SEG1: NonZeroU8 = NonZeroU8::new(16).unwrap();
const SEG2: NonZeroU8 = NonZeroU8::new(3).unwrap();
const CHOSEN: BitTiming = BitTiming {
    prescaler: PRESCALER.get(),
    seg1: SEG1.get(),
    seg2: SEG2.get(),
    jump: SEG2.get(),
};
const _: () = assert!(CHOSEN.is_as_expected(CLOCK_HZ, BITRATE));

/// Frames that may wait for the sensor's task: the controller's own queue holds three, and a full bus brings at most one in
/// 47 µs. A frame without room is reported as lost.
const RECEIVED: usize = 32;
/// Frames that may wait to be sent, besides the controller's three. More would only be sent late.
const TO_SEND: usize = 1;
/// 129 times 11 recessive bits take 1.4 ms; if the bus is quiet for 20 ms, the fault of the cable is gone.
const RECOVERY_MS: u32 = 20;

bind_interrupts!(struct Irqs {
    FDCAN1_IT0 => can_fifo::Before, can::IT0InterruptHandler<FDCAN1>, can_fifo::Behind;
    FDCAN1_IT1 => can::IT1InterruptHandler<FDCAN1>;
});

/// The controller and its pins.
pub(crate) struct Pins {
    pub(crate) fdcan: Peri<'static, FDCAN1>,
    pub(crate) rx: Peri<'static, PD0>,
    pub(crate) tx: Peri<'static, PD1>,
}

/// FDCAN1, and a count of the frames that it has handed over.
pub(crate) struct Bus(BufferedCan<'static, TO_SEND, RECEIVED>, Handed);

impl Bus {
    /// Starts the controller.
    ///
    /// # Errors
    /// [`SensorFault::BitTiming`] if the registers or the clock give another timing: better no bus than one whose bits
    /// other nodes sometimes misread.
    pub(crate) fn start(pins: Pins) -> Result<Self, SensorFault> {
        static TX: ConstStaticCell<TxBuf<TO_SEND>> = ConstStaticCell::new(TxBuf::new());
        static RX: ConstStaticCell<RxBuf<RECEIVED>> = ConstStaticCell::new(RxBuf::new());
        let mut can = CanConfigurator::new(pins.fdcan, pins.rx, pins.tx, Irqs);
        can.set_config(
            FdCanConfig::default()
                .set_frame_transmit(FrameTransmissionConfig::ClassicCanOnly)
                // Frames are sent in the order of the requests.
                .set_tx_buffer_mode(TxBufferMode::Fifo)
                // The sensor task decides when and how often to recover.
                .set_automatic_bus_off_recovery(false)
                .set_nominal_bit_timing(NominalBitTiming {
                    prescaler: PRESCALER,
                    seg1: SEG1,
                    seg2: SEG2,
                    sync_jump_width: SEG2,
                }),
        );
        let can = can.start(OperatingMode::NormalOperationMode);
        BitTiming::from_nbtp(REGISTERS.nbtp().read().0)
            .check(rcc::frequency::<FDCAN1>().0, BITRATE)?;
        Ok(Self(can.buffered(TX.take(), RX.take()), Handed::default()))
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
        self.0.write(frame).await;
        Ok(())
    }

    async fn receive(&mut self) -> Result<Frame, IoError> {
        self.check()?;
        // The controller's queue was full, and a frame was lost.
        if REGISTERS.ir().read().rfl(0) {
            REGISTERS.ir().write(|w| w.set_rfl(0, true));
            return Err(IoError::Lost);
        }
        let taken = can_fifo::frames_taken();
        let envelope = match poll_once(self.0.read()) {
            Poll::Ready(envelope) => envelope,
            // A frame was taken out of the controller but has not reached the driver's queue.
            Poll::Pending if self.1.misses(taken) => return Err(IoError::Lost),
            Poll::Pending => self.0.read().await,
        };
        if envelope.is_ok() {
            self.1.count();
        }
        // The controller reports a line error together with its state.
        let envelope = envelope.map_err(|_| self.check().err().unwrap_or(IoError::Lost))?;
        from_fdcan(&envelope.frame).ok_or(IoError::Lost)
    }

    async fn recover(&mut self) -> Result<(), IoError> {
        // Leaving the initialisation mode begins the recovery.
        REGISTERS.cccr().modify(|w| w.set_init(false));
        for _ in 0..RECOVERY_MS {
            Timer::after_millis(1).await;
            if self.check().is_ok() {
                return Ok(());
            }
        }
        Err(IoError::BusOff)
    }

    async fn loop_back(&mut self) -> Option<LoopBack> {
        hear_itself(true).await;
        let outcome = loop_back(self, &UptimeClock).await;
        hear_itself(false).await;
        Some(outcome)
    }
}

/// Connects output and input inside of the controller, separate from the pins, or back to the pins (RM0433, FDCAN test
/// modes). Frames that wait to be sent are dropped.
async fn hear_itself(on: bool) {
    REGISTERS.cccr().modify(|w| w.set_init(true));
    // The mode changes at the end of the frame that is being sent.
    Timer::after_millis(1).await;
    REGISTERS.cccr().modify(|w| w.set_cce(true));
    REGISTERS.cccr().modify(|w| {
        w.set_test(true);
        w.set_mon(on);
    });
    REGISTERS.test().modify(|w| w.set_lbck(on));
    REGISTERS.cccr().modify(|w| w.set_test(on));
    // Leaving the initialisation mode protects the configuration again.
    REGISTERS.cccr().modify(|w| w.set_init(false));
    // The driver checks for room in its interrupt, and the one that it waited for will not come any more.
    interrupt::FDCAN1_IT0.pend();
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
