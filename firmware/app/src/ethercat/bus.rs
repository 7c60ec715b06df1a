//! The bus as the sensor's task sees it: one request at a time, and its answer.

use crate::board::{IoError, SensorBus};
use embassy_sync::blocking_mutex::raw::NoopRawMutex;
use embassy_sync::signal::Signal;
use softdock_link::ethercat::Exchange;

/// Connects the bus and the segment. A newer request replaces one that has not been begun.
pub(super) struct Wire {
    pub(super) request: Signal<NoopRawMutex, Exchange>,
    pub(super) answer: Signal<NoopRawMutex, Exchange>,
}

impl Wire {
    pub(super) fn new() -> Self {
        Self {
            request: Signal::new(),
            answer: Signal::new(),
        }
    }

    /// The bus's end.
    pub(super) fn bus(&self) -> Bus<'_> {
        Bus(self)
    }
}

/// The bus's end of the wire.
pub(super) struct Bus<'a>(&'a Wire);

impl SensorBus for Bus<'_> {
    type Frame = Exchange;

    async fn send(&mut self, request: &Exchange) -> Result<(), IoError> {
        self.0.request.signal(*request);
        Ok(())
    }

    async fn receive(&mut self) -> Result<Exchange, IoError> {
        Ok(self.0.answer.wait().await)
    }

    /// It never goes off: the driver asks for a start-up instead.
    async fn recover(&mut self) -> Result<(), IoError> {
        Ok(())
    }
}
