//! The link of an Ethernet controller, for the network's stack and for onlookers.

use super::SHARED;
use crate::phy::{Management, PhyMonitor};
use core::future::Future;
use core::pin::pin;
use core::task::Context;
use embassy_time::{Instant, Timer};
use softdock_link::service::EthernetHealth;

/// A PHY, which is looked at when it is time to.
pub struct EthernetLink<B> {
    phy: B,
    monitor: PhyMonitor,
    told: bool,
}

impl<B: Management> EthernetLink<B> {
    /// The PHY on a management bus; onlookers are told if it is that of the robot's network.
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

    /// Whether there is a link. The task of `context` is woken for the next look.
    pub fn is_up(&mut self, context: &mut Context<'_>) -> bool {
        let before = self.monitor;
        let up = self
            .monitor
            .is_up(&mut self.phy, Instant::now().as_micros());
        // Who is woken asks again; the timer only has to ring.
        let next = Instant::from_micros(self.monitor.next_us());
        let _ = pin!(Timer::at(next)).poll(context);
        if self.told && self.monitor != before {
            let losses = self.monitor.losses();
            tell(|ethernet| (ethernet.link, ethernet.losses) = (up, losses));
        }
        up
    }
}

/// Tells the onlookers.
pub fn tell(change: impl FnOnce(&mut EthernetHealth)) {
    SHARED.update_machine(|machine| {
        change(machine.ethernet.get_or_insert_default());
    });
}
