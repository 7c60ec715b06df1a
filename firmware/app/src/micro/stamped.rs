//! A network driver that records when the robot's telegrams leave it.

use super::clock::UptimeClock;
use crate::arrivals::{Arrivals, udp_sender};
use crate::board::Clock;
use core::task::Context;
use embassy_net::driver::{Capabilities, Driver, HardwareAddress, LinkState, RxToken};
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;

/// Times of the robot's telegrams.
pub(super) static ARRIVALS: Arrivals<CriticalSectionRawMutex> = Arrivals::new();

/// A driver, and the robot's UDP port.
pub struct Stamped<D> {
    driver: D,
    port: u16,
}

impl<D: Driver> Stamped<D> {
    pub(super) const fn new(driver: D, port: u16) -> Self {
        Self { driver, port }
    }
}

/// A frame, and when it left the driver.
pub struct StampedFrame<T> {
    frame: T,
    port: u16,
    at_us: u64,
}

impl<T: RxToken> RxToken for StampedFrame<T> {
    fn consume<R, F: FnOnce(&mut [u8]) -> R>(self, read: F) -> R {
        self.frame.consume(|bytes| {
            if let Some(sender) = udp_sender(bytes, self.port) {
                ARRIVALS.note(sender, self.at_us);
            }
            read(bytes)
        })
    }
}

impl<D: Driver> Driver for Stamped<D> {
    type RxToken<'a>
        = StampedFrame<D::RxToken<'a>>
    where
        Self: 'a;
    type TxToken<'a>
        = D::TxToken<'a>
    where
        Self: 'a;

    fn receive(
        &mut self,
        context: &mut Context<'_>,
    ) -> Option<(Self::RxToken<'_>, Self::TxToken<'_>)> {
        let port = self.port;
        let (frame, answer) = self.driver.receive(context)?;
        let at_us = UptimeClock.now_us();
        Some((StampedFrame { frame, port, at_us }, answer))
    }

    fn transmit(&mut self, context: &mut Context<'_>) -> Option<Self::TxToken<'_>> {
        self.driver.transmit(context)
    }

    fn link_state(&mut self, context: &mut Context<'_>) -> LinkState {
        self.driver.link_state(context)
    }

    fn capabilities(&self) -> Capabilities {
        self.driver.capabilities()
    }

    fn hardware_address(&self) -> HardwareAddress {
        self.driver.hardware_address()
    }
}
