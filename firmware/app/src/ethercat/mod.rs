//! The sensor on EtherCAT: MainDevice of a segment with one SubDevice, over ethercrab.
//!
//! Three things run side by side, in one task: the sensor's task, which asks for exchanges; the segment, which carries
//! them out; and the pump between ethercrab and the Ethernet port. No wait in ethercrab is left unbounded: a start-up
//! has an end, and so has each exchange.
//!
//! | file | |
//! |---|---|
//! | `bus` | the bus as the sensor's task sees it |
//! | `segment` | start-up and exchanges |
//! | `pump` | frames between ethercrab and the port |
//! | `port` | the port of a microcontroller |
//!
//! There are no distributed clocks: the sensor runs free, and the robot's telegram asks for an exchange.

mod bus;
pub mod port;
mod pump;
mod segment;

use crate::board::{Clock, EthernetPort};
use crate::sensor;
use crate::settings::EtherCatSettings;
use crate::shared::Shared;
use bus::Wire;
use embassy_futures::select::select3;
use embassy_sync::blocking_mutex::raw::RawMutex;
use ethercrab::{MainDevice, PduStorage};

/// Frames that may be on their way, each with room for a mailbox of 1 kB.
const FRAMES: usize = 4;
const FRAME_BYTES: usize = PduStorage::element_size(1024);

/// Memory for frames; each run takes one of its own.
pub type Frames = PduStorage<FRAMES, FRAME_BYTES>;

/// Runs the sensor until the port is closed.
pub async fn run<M: RawMutex>(
    shared: &Shared<M>,
    settings: &EtherCatSettings,
    frames: &Frames,
    port: impl EthernetPort,
    clock: &impl Clock,
) {
    let Ok((transmitter, receiver, pdu_loop)) = frames.try_split() else {
        // They are in use, which a caller must not do.
        return;
    };
    let main_device = MainDevice::new(pdu_loop, segment::TIMEOUTS, segment::CONFIG);
    let wire = Wire::new();
    let mut bus = wire.bus();
    let driver = settings.driver();
    let sensor = sensor::run(shared, &mut bus, clock, driver);
    let timeout_us = settings.answer_timeout_us();
    let segment = segment::serve(&wire, &main_device, clock, timeout_us);
    select3(sensor, segment, pump::run(port, transmitter, receiver)).await;
}
