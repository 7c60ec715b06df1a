//! The sensor on EtherCAT, which shares the only Ethernet controller of the board with RSI.
//!
//! Frames are distinguished by their EtherType. This is for tests only: on real cables the two must not share a port, because
//! a switch would carry EtherCAT into the robot's network.

use crate::lan9118::{FRAME_BYTES, Lan9118, transmit};
use core::cell::RefCell;
use core::task::{Context, Poll, Waker};
use embassy_executor::Spawner;
use embassy_net_driver::{Capabilities, Driver, HardwareAddress, LinkState, RxToken, TxToken};
use heapless::{Deque, Vec};
use softdock_app::board::{EthernetPort, IoError};
use softdock_app::ethercat::{self, Frames};
use softdock_app::micro::SHARED;
use softdock_app::micro::clock::UptimeClock;
use softdock_app::micro::start::spawn;
use softdock_app::sensor;
use softdock_app::settings::{BoardSettings, EtherCatSettings};
use softdock_link::ethercat::ETHERTYPE;
use static_cell::StaticCell;

/// Frames that may wait in either queue.
const QUEUE: usize = 8;

type Frame = Vec<u8, FRAME_BYTES>;

/// Frames that wait for a task, and the waker of that task.
#[derive(Default)]
struct Queue {
    frames: Deque<Frame, QUEUE>,
    waker: Option<Waker>,
}

/// The controller and the received frames of both protocols. Both tasks run on the same executor.
struct Controller {
    ethernet: Lan9118,
    ip: Queue,
    ethercat: Queue,
}

impl Controller {
    /// Takes all frames out of the controller, whichever task is polled: it wakes only the task that registered last.
    fn sort(&mut self, context: &mut Context<'_>) {
        while let Some((frame, _)) = self.ethernet.receive(context) {
            frame.consume(|bytes| {
                let side = match bytes.get(12..14) == Some(&ETHERTYPE) {
                    true => &mut self.ethercat,
                    false => &mut self.ip,
                };
                // A frame without room in the queue is lost, as on any network.
                if let Ok(frame) = Frame::from_slice(bytes) {
                    let _ = side.frames.push_back(frame);
                }
                if let Some(waker) = side.waker.take() {
                    waker.wake();
                }
            });
        }
    }
}

/// The part of the controller that the robot's network uses.
pub(crate) struct Network {
    controller: &'static RefCell<Controller>,
    address: HardwareAddress,
    capabilities: Capabilities,
    to_send: [u8; FRAME_BYTES],
}

/// Starts the sensor's task; returns the driver of the robot's network.
pub(crate) fn start(spawner: &Spawner, settings: &BoardSettings, ethernet: Lan9118) -> Network {
    static CONTROLLER: StaticCell<RefCell<Controller>> = StaticCell::new();
    let (address, capabilities) = (ethernet.hardware_address(), ethernet.capabilities());
    let controller = CONTROLLER.init_with(|| {
        RefCell::new(Controller {
            ethernet,
            ip: Queue::default(),
            ethercat: Queue::default(),
        })
    });
    match settings.ethercat.enabled {
        true => spawn(
            spawner,
            sensor_task(settings.ethercat.clone(), Segment(controller)),
        ),
        false => sensor::refuse(&SHARED),
    }
    Network {
        controller,
        address,
        capabilities,
        to_send: [0; FRAME_BYTES],
    }
}

#[embassy_executor::task]
async fn sensor_task(settings: EtherCatSettings, port: Segment) {
    static FRAMES: Frames = Frames::new();
    ethercat::run(&SHARED, &settings, &FRAMES, port, &UptimeClock).await;
}

/// The part of the controller that the EtherCAT segment uses.
struct Segment(&'static RefCell<Controller>);

impl EthernetPort for Segment {
    fn poll_receive(
        &mut self,
        context: &mut Context<'_>,
        buffer: &mut [u8],
    ) -> Poll<Result<usize, IoError>> {
        let controller = &mut *self.0.borrow_mut();
        controller.ethercat.waker = Some(context.waker().clone());
        controller.sort(context);
        let Some(frame) = controller.ethercat.frames.pop_front() else {
            return Poll::Pending;
        };
        let room = buffer.get_mut(..frame.len()).ok_or(IoError::Lost);
        Poll::Ready(room.map(|room| {
            room.copy_from_slice(&frame);
            frame.len()
        }))
    }

    fn poll_send(&mut self, _context: &mut Context<'_>, frame: &[u8]) -> Poll<()> {
        transmit(frame);
        Poll::Ready(())
    }
}

/// A received frame.
pub(crate) struct Received(Frame);

impl RxToken for Received {
    fn consume<R, F: FnOnce(&mut [u8]) -> R>(mut self, read: F) -> R {
        read(&mut self.0)
    }
}

/// Room for a frame.
pub(crate) struct ToSend<'a>(&'a mut [u8; FRAME_BYTES]);

impl TxToken for ToSend<'_> {
    fn consume<R, F: FnOnce(&mut [u8]) -> R>(self, length: usize, write: F) -> R {
        // The network stack stays within `max_transmission_unit`.
        let (frame, _) = self.0.split_at_mut(length.min(FRAME_BYTES));
        let result = write(frame);
        transmit(frame);
        result
    }
}

impl Driver for Network {
    type RxToken<'a> = Received;
    type TxToken<'a> = ToSend<'a>;

    fn receive(&mut self, context: &mut Context<'_>) -> Option<(Received, ToSend<'_>)> {
        let controller = &mut *self.controller.borrow_mut();
        controller.ip.waker = Some(context.waker().clone());
        controller.sort(context);
        let frame = controller.ip.frames.pop_front()?;
        Some((Received(frame), ToSend(&mut self.to_send)))
    }

    fn transmit(&mut self, _context: &mut Context<'_>) -> Option<ToSend<'_>> {
        Some(ToSend(&mut self.to_send))
    }

    fn link_state(&mut self, context: &mut Context<'_>) -> LinkState {
        self.controller.borrow_mut().ethernet.link_state(context)
    }

    fn capabilities(&self) -> Capabilities {
        self.capabilities.clone()
    }

    fn hardware_address(&self) -> HardwareAddress {
        self.address
    }
}
