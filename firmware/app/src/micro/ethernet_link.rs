//! The link of an Ethernet controller, for the network stack and for the shared state.

use super::SHARED;
use crate::phy::{Management, PhyMonitor};
use core::future::Future;
use core::pin::pin;
use core::task::Context;
use embassy_time::{Instant, Timer};
use softdock_link::service::EthernetHealth;

/// A PHY that is polled at intervals.
pub struct EthernetLink<B> {
    phy: B,
    monitor: PhyMonitor,
    told: bool,
}

impl<B: Management> EthernetLink<B> {
    /// The PHY on a management bus; `told`: its state is published, as it is that of the robot's network.
    pub fn new(phy: B, told: bool) -> Self {
        Self {
            phy,
            monitor: PhyMonitor::default(),
            told,
        }
    }

    /// Begins to reset the PHY.
    pub fn reset(&mut self) {
        self.monitor.reset(&mut self.phy);
    }

    /// Whether there is a link. Wakes the task of `context` for the next check.
    pub fn is_up(&mut self, context: &mut Context<'_>) -> bool {
        let before = self.monitor;
        let up = self
            .monitor
            .is_up(&mut self.phy, Instant::now().as_micros());
        // The woken task calls this again; the timer only has to fire.
        let next = Instant::from_micros(self.monitor.next_us());
        let _ = pin!(Timer::at(next)).poll(context);
        if self.told && self.monitor != before {
            let losses = self.monitor.losses();
            tell(|ethernet| (ethernet.link, ethernet.losses) = (up, losses));
        }
        up
    }
}

/// Publishes a change of the Ethernet's health.
pub fn tell(change: impl FnOnce(&mut EthernetHealth)) {
    SHARED.update_machine(|machine| {
        change(machine.ethernet.get_or_insert_default());
    });
}
