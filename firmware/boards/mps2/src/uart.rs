//! CMSDK UARTs, with a ring buffer for each direction that the interrupts fill and empty.
//!
//! Source: Cortex-M System Design Kit, technical reference manual, 4.3.
#![allow(unsafe_code, reason = "addresses of registers")]

use crate::chip;
use crate::interrupts::{self, Interrupt, Interrupt as interrupt};
use crate::register::Register;
use core::sync::atomic::{AtomicBool, Ordering};
use cortex_m::peripheral::NVIC;
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::pipe::Pipe;
use embedded_io_async::{ErrorKind, ErrorType, Read, Write};

/// Received bytes that may wait for a task: 30 ms at the 33 kB/s that QEMU reaches.
const RECEIVE_BYTES: usize = 1024;
/// Bytes that may wait to be sent.
const SEND_BYTES: usize = 4096;

const TX_FULL: u32 = 1;
const RX_FULL: u32 = 1 << 1;
/// Enables transmitter, receiver and the receiver's interrupt.
const ENABLE: u32 = 0b1011;
/// Enables the transmitter's interrupt, in CTRL.
const TX_INTERRUPT: u32 = 1 << 2;
/// Clears the transmitter's interrupt, in INTCLEAR.
const CLEAR_TX: u32 = 1;
/// Clears the receiver's interrupt, in INTCLEAR.
const CLEAR_RX: u32 = 1 << 1;
/// 115,200 bit/s. QEMU ignores the rate, but sends nothing if the divisor is less than 16.
const BAUD_DIVISOR: u32 = chip::CLOCK_HZ / 115_200;

/// The sensor's line.
pub(crate) static CAN: Uart = Uart::new(chip::UARTS[0], Interrupt::UARTRX0, Interrupt::UARTTX0);
/// The log's line. It receives nothing, so the transmitter's interrupt is given for both.
pub(crate) static LOG: Uart = Uart::new(chip::UARTS[1], Interrupt::UARTTX1, Interrupt::UARTTX1);
/// The line of the service.
pub(crate) static SERVICE: Uart = Uart::new(chip::UARTS[2], Interrupt::UARTRX2, Interrupt::UARTTX2);

/// A UART with its ring buffers.
pub(crate) struct Uart {
    base: usize,
    receive: Interrupt,
    transmit: Interrupt,
    received: Pipe<CriticalSectionRawMutex, RECEIVE_BYTES>,
    to_send: Pipe<CriticalSectionRawMutex, SEND_BYTES>,
    overrun: AtomicBool,
}

impl Uart {
    const fn new(base: usize, receive: Interrupt, transmit: Interrupt) -> Self {
        Self {
            base,
            receive,
            transmit,
            received: Pipe::new(),
            to_send: Pipe::new(),
            overrun: AtomicBool::new(false),
        }
    }

    fn register(&self, offset: usize) -> Register {
        // SAFETY: `base` is that of a UART, and offsets are those of its five registers.
        unsafe { Register::at(self.base + offset) }
    }
    fn data(&self) -> Register {
        self.register(0x0)
    }
    fn state(&self) -> Register {
        self.register(0x4)
    }
    fn ctrl(&self) -> Register {
        self.register(0x8)
    }
    fn int_clear(&self) -> Register {
        self.register(0xC)
    }
    fn baud_divisor(&self) -> Register {
        self.register(0x10)
    }

    /// Switches the UART on.
    pub(crate) fn open(&'static self) -> (UartReader, UartWriter) {
        self.baud_divisor().write(BAUD_DIVISOR);
        self.ctrl().write(ENABLE);
        interrupts::unmask(self.receive);
        interrupts::unmask(self.transmit);
        (UartReader(self), UartWriter(self))
    }

    /// Takes as many bytes to send as there is room for, without waiting.
    pub(crate) fn try_write(&self, mut bytes: &[u8]) {
        while let Ok(length @ 1..) = self.to_send.try_write(bytes) {
            bytes = bytes.get(length..).unwrap_or_default();
        }
    }

    /// Makes the interrupt send the waiting bytes.
    pub(crate) fn kick(&self) {
        NVIC::pend(self.transmit);
    }

    fn on_receive(&self) {
        self.int_clear().write(CLEAR_RX);
        while self.state().read() & RX_FULL != 0 {
            let byte = self.data().read() as u8;
            if self.received.try_write(&[byte]).is_err() {
                self.overrun.store(true, Ordering::Relaxed);
            }
        }
    }

    fn on_transmit(&self) {
        self.int_clear().write(CLEAR_TX);
        let mut byte = [0];
        while self.state().read() & TX_FULL == 0 {
            if self.to_send.try_read(&mut byte).is_err() {
                self.ctrl().write(ENABLE);
                return;
            }
            self.data().write(u32::from(byte[0]));
        }
        // The host accepts no more bytes at the moment; the interrupt continues when it does. The byte may have left before
        // the interrupt was enabled, so check once more.
        self.ctrl().write(ENABLE | TX_INTERRUPT);
        if self.state().read() & TX_FULL == 0 {
            self.kick();
        }
    }
}

/// The receiving half. If its `read` is dropped, no bytes are lost.
pub(crate) struct UartReader(&'static Uart);

impl ErrorType for UartReader {
    type Error = ErrorKind;
}

impl Read for UartReader {
    /// [`ErrorKind::Other`]: bytes were lost before the next ones.
    async fn read(&mut self, buffer: &mut [u8]) -> Result<usize, ErrorKind> {
        if self.0.overrun.swap(false, Ordering::Relaxed) {
            return Err(ErrorKind::Other);
        }
        Ok(self.0.received.read(buffer).await)
    }
}

/// The sending half. Its `write` takes bytes at once; if it is dropped before, it takes none.
pub(crate) struct UartWriter(&'static Uart);

impl ErrorType for UartWriter {
    type Error = ErrorKind;
}

impl Write for UartWriter {
    async fn write(&mut self, bytes: &[u8]) -> Result<usize, ErrorKind> {
        let length = self.0.to_send.write(bytes).await;
        self.0.kick();
        Ok(length)
    }

    async fn flush(&mut self) -> Result<(), ErrorKind> {
        Ok(())
    }
}

#[cortex_m_rt::interrupt]
fn UARTRX0() {
    CAN.on_receive();
}

#[cortex_m_rt::interrupt]
fn UARTTX0() {
    CAN.on_transmit();
}

#[cortex_m_rt::interrupt]
fn UARTTX1() {
    LOG.on_transmit();
}

#[cortex_m_rt::interrupt]
fn UARTRX2() {
    SERVICE.on_receive();
}

#[cortex_m_rt::interrupt]
fn UARTTX2() {
    SERVICE.on_transmit();
}
