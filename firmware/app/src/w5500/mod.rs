//! The robot's network on a WIZnet W5500, for `embassy-net`.
//!
//! Drivers of this chip are known to fall silent, for two reasons. It raises its interrupt when a frame comes, not while one
//! waits, so that taking one frame per interrupt piles them up until its memory is full and nothing comes any more (embassy
//! #6456, Zephyr #119018). And an impossible length is taken for a valid one (embassy #5706, Zephyr #46684), which is why
//! `embassy-net-wiznet` 0.3 is not used. Here all waiting frames are taken, an answer is sent between any two received frames,
//! and every [`PERIOD_US`] the configuration of the chip is checked and restored if necessary.
//! #119018); and a length that cannot be is taken for one (embassy #5706, Zephyr #46684), which is why
//! `embassy-net-wiznet` 0.3 is not used. Here all that waits is taken, an answer goes out between any two frames that come in,
//! and every [`PERIOD_US`] it is looked whether the chip is still as it was told to be. What is wrong is told to it again.

mod chip;
#[cfg(test)]
mod tests;

use crate::board::Clock;
use chip::{Look, Received, Trouble};
use core::future::poll_fn;
use embassy_futures::select::{Either3, select, select3};
use embassy_net_driver_channel::driver::LinkState;
use embassy_net_driver_channel::{Runner, RxRunner, StateRunner, TxRunner};
use embedded_hal_async::spi::SpiDevice;
use softdock_link::service::EthernetHealth;

pub use chip::{Buffer, Chip};

/// Longest frame without its checksum, bytes: header and payload.
pub const FRAME_BYTES: usize = 1514;
/// Period of the check, µs: the robot is answered again within 10 cycles of 4 ms.
pub const PERIOD_US: u64 = 10_000;

/// State of the chip.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Health {
    /// It answers on its bus, and accepted its configuration.
    pub answers: bool,
    /// Its link, and how often it had to be brought back.
    pub ethernet: EthernetHealth,
}

/// Moves frames between chip and network forever. `interrupt` waits until its pin is low, `tell` is called when its health has
/// changed.
pub async fn run<S: SpiDevice>(
    chip: Chip<'_, S>,
    mut interrupt: impl AsyncFnMut(),
    frames: Runner<'_, FRAME_BYTES>,
    clock: &impl Clock,
    mut tell: impl FnMut(&Health),
) -> ! {
    let (link, mut received, mut to_send) = frames.split();
    let mut port = Port::new(chip);
    let mut told = None;
    let mut look_us = 0;
    loop {
        if clock.now_us() >= look_us {
            look_us = clock.now_us() + PERIOD_US;
            port.look(&link).await;
        }
        port.send_one(&mut to_send).await;
        let room = port.receive_one(&mut received).await;
        if told != Some(port.health) {
            tell(&port.health);
            told = Some(port.health);
        }
        if port.waits && room {
            continue;
        }
        let answer = poll_fn(|context| to_send.poll_tx_buf(context).map(drop));
        let look = clock.wait_until(look_us);
        // While frames wait for room in the network, or the chip does not answer, an interrupt gives no new information.
        match (port.waits, port.health.answers) {
            (true, _) => {
                let room = poll_fn(|context| received.poll_rx_buf(context).map(drop));
                select3(room, answer, look).await;
            }
            (false, false) => {
                select(answer, look).await;
            }
            (false, true) => {
                if let Either3::First(_) = select3(interrupt(), answer, look).await {
                    port.begin_to_receive().await;
                }
            }
        }
    }
}

/// The chip, and its known state.
struct Port<'b, S> {
    chip: Chip<'b, S>,
    health: Health,
    /// Link state as reported to the network.
    told_link: bool,
    /// Frames may wait in it.
    waits: bool,
    /// Address of the first frame that was not sent at the last check.
    unsent: Option<u16>,
}

impl<'b, S: SpiDevice> Port<'b, S> {
    fn new(chip: Chip<'b, S>) -> Self {
        Self {
            chip,
            health: Health::default(),
            told_link: false,
            waits: false,
            unsent: None,
        }
    }

    /// Checks link and configuration. Frames that waited for a link, in either direction, are dropped as too old.
    async fn look(&mut self, state: &StateRunner<'_>) {
        match self.chip.look().await {
            Err(_) => self.has_gone(),
            Ok(look) => {
                let came = look.link && !self.health.ethernet.link;
                self.health.ethernet.link = look.link;
                let wrong = self.is_wrong(&look);
                self.unsent = look.unsent;
                if wrong {
                    self.bring_back().await;
                } else if came || !self.health.answers {
                    self.open().await;
                }
            }
        }
        self.tell_network(state);
        // An edge of the interrupt may have been missed.
        self.waits = self.health.answers;
    }

    fn tell_network(&mut self, state: &StateRunner<'_>) {
        let ethernet = &mut self.health.ethernet;
        let lost = self.told_link && !ethernet.link;
        ethernet.losses = ethernet.losses.saturating_add(u32::from(lost));
        if self.told_link != ethernet.link {
            state.set_link_state(match ethernet.link {
                true => LinkState::Up,
                false => LinkState::Down,
            });
        }
        self.told_link = ethernet.link;
    }

    /// Whether the chip has to be configured again. With a link, a frame is sent within 0.12 ms.
    fn is_wrong(&self, look: &Look) -> bool {
        let stuck = look.link && look.unsent.is_some() && look.unsent == self.unsent;
        self.health.answers && (!look.open || stuck)
    }

    async fn open(&mut self) {
        self.unsent = None;
        match self.chip.open().await {
            Ok(()) => self.health.answers = true,
            Err(_) => self.has_gone(),
        }
    }

    async fn bring_back(&mut self) {
        let overruns = &mut self.health.ethernet.overruns;
        *overruns = overruns.saturating_add(1);
        self.open().await;
    }

    fn has_gone(&mut self) {
        self.health.answers = false;
        self.health.ethernet.link = false;
        self.waits = false;
    }

    async fn begin_to_receive(&mut self) {
        let cleared = self.chip.clear_interrupt().await;
        self.mind(cleared).await;
        self.waits = self.health.answers;
    }

    async fn send_one(&mut self, to_send: &mut TxRunner<'_, FRAME_BYTES>) {
        let Some(frame) = to_send.try_tx_buf() else {
            return;
        };
        // Without a link it would be sent when it is useless.
        if self.health.answers && self.health.ethernet.link {
            let sent = self.chip.send(frame).await;
            self.mind(sent).await;
        }
        to_send.tx_done();
    }

    /// Takes one frame, if any waits. `false`: the network has no room for it.
    async fn receive_one(&mut self, received: &mut RxRunner<'_, FRAME_BYTES>) -> bool {
        if !self.waits {
            return true;
        }
        let Some(frame) = received.try_rx_buf() else {
            return false;
        };
        match self.chip.receive(frame).await {
            Ok(Received::Frame(length)) => received.rx_done(length),
            Ok(Received::Nothing) => self.waits = false,
            Ok(Received::Flood) => self.bring_back().await,
            Err(trouble) => self.mind(Err(trouble)).await,
        }
        true
    }

    async fn mind(&mut self, outcome: Result<(), Trouble>) {
        match outcome {
            Ok(()) => {}
            Err(Trouble::OutOfStep) => self.bring_back().await,
            Err(Trouble::NoAnswer) => self.has_gone(),
        }
    }
}
