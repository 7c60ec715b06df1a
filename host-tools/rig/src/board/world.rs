//! Bus, socket and clock of a board in virtual time: queues between the firmware's tasks and the
//! simulation, and the alarms that the tasks wait for.
//!
//! Everything lives on one thread. `activity` is increased whenever a task touches anything here: when it stays the same, the
//! simulation knows that all tasks are at rest.

use super::time_driver::TimeSource;
use softdock_app::board::{Clock, DatagramSocket, EthernetPort, IoError, Recorder, SensorBus};
use softdock_app::record::CycleRecord;
use softdock_link::can::Frame;
use std::cell::RefCell;
use std::collections::VecDeque;
use std::future::poll_fn;
use std::net::{Ipv4Addr, SocketAddr};
use std::rc::Rc;
use std::task::{Context, Poll, Waker};

/// The simulated robot's address; it never leaves the process.
const ROBOT: SocketAddr = SocketAddr::new(std::net::IpAddr::V4(Ipv4Addr::LOCALHOST), 49_152);

/// A queue towards a task, with the task that waits for it.
#[derive(Debug)]
pub(super) struct Inbox<T> {
    items: VecDeque<T>,
    waker: Option<Waker>,
}

impl<T> Default for Inbox<T> {
    fn default() -> Self {
        Self {
            items: VecDeque::new(),
            waker: None,
        }
    }
}

impl<T> Inbox<T> {
    pub(super) fn push(&mut self, item: T) {
        self.items.push_back(item);
        if let Some(waker) = self.waker.take() {
            waker.wake();
        }
    }
}

/// What the simulation and the tasks share.
#[derive(Debug, Default)]
pub(super) struct World {
    pub(super) now_us: u64,
    pub(super) activity: u64,
    pub(super) alarms: Vec<Alarm>,
    alarm_count: u64,
    pub(super) frames_to_board: Inbox<Frame>,
    pub(super) frames_from_board: VecDeque<Frame>,
    /// Frames of the EtherCAT segment.
    pub(super) ethernet_to_board: Inbox<Vec<u8>>,
    pub(super) ethernet_from_board: VecDeque<Vec<u8>>,
    pub(super) telegrams: Inbox<Vec<u8>>,
    pub(super) answers: VecDeque<Vec<u8>>,
    pub(super) records: Vec<CycleRecord>,
}

/// Time at which a task is woken.
#[derive(Debug)]
pub(super) struct Alarm {
    pub(super) at_us: u64,
    pub(super) waker: Waker,
    number: u64,
}

impl World {
    /// Sets an alarm. Returns its number.
    fn set_alarm(&mut self, at_us: u64, waker: &Waker) -> u64 {
        let number = self.alarm_count;
        self.alarm_count += 1;
        let waker = waker.clone();
        self.alarms.push(Alarm {
            at_us,
            waker,
            number,
        });
        number
    }
}

/// A task's handle on the world.
#[derive(Clone, Debug, Default)]
pub(super) struct Handle(pub(super) Rc<RefCell<World>>);

impl Handle {
    fn touch<R>(&self, op: impl FnOnce(&mut World) -> R) -> R {
        let mut world = self.0.borrow_mut();
        world.activity += 1;
        op(&mut world)
    }

    /// The next item of an inbox.
    async fn take<T>(&self, inbox: impl Fn(&mut World) -> &mut Inbox<T>) -> T {
        poll_fn(|context| {
            self.touch(|world| {
                let inbox = inbox(world);
                match inbox.items.pop_front() {
                    Some(item) => Poll::Ready(item),
                    None => {
                        inbox.waker = Some(context.waker().clone());
                        Poll::Pending
                    }
                }
            })
        })
        .await
    }
}

impl SensorBus for Handle {
    type Frame = Frame;

    async fn send(&mut self, frame: &Frame) -> Result<(), IoError> {
        self.touch(|world| world.frames_from_board.push_back(*frame));
        Ok(())
    }
    async fn receive(&mut self) -> Result<Frame, IoError> {
        Ok(self.take(|world| &mut world.frames_to_board).await)
    }
    async fn recover(&mut self) -> Result<(), IoError> {
        Ok(())
    }
}

impl DatagramSocket for Handle {
    async fn receive(&mut self, buffer: &mut [u8]) -> Result<(usize, SocketAddr), IoError> {
        let telegram = self.take(|world| &mut world.telegrams).await;
        let length = telegram.len().min(buffer.len());
        buffer[..length].copy_from_slice(&telegram[..length]);
        Ok((length, ROBOT))
    }
    fn try_receive(&mut self, _buffer: &mut [u8]) -> Option<(usize, SocketAddr)> {
        // The simulated robot waits for its answer before it sends again.
        None
    }
    async fn send(&mut self, datagram: &[u8], _to: SocketAddr) -> Result<(), IoError> {
        self.touch(|world| world.answers.push_back(datagram.to_vec()));
        Ok(())
    }
}

impl Clock for Handle {
    fn now_us(&self) -> u64 {
        self.0.borrow().now_us
    }
    async fn wait_until(&self, at_us: u64) {
        let mut waiting = Waiting {
            handle: self,
            alarm: None,
        };
        poll_fn(|context| {
            self.touch(|world| {
                if world.now_us >= at_us {
                    return Poll::Ready(());
                }
                if waiting.alarm.is_none() {
                    waiting.alarm = Some(world.set_alarm(at_us, context.waker()));
                }
                Poll::Pending
            })
        })
        .await;
    }
}

/// Takes an alarm back when the task no longer waits for it: an alarm that rings for nothing costs
/// a turn of the executor.
struct Waiting<'a> {
    handle: &'a Handle,
    alarm: Option<u64>,
}

impl Drop for Waiting<'_> {
    fn drop(&mut self) {
        if let Some(number) = self.alarm {
            let mut world = self.handle.0.borrow_mut();
            world.alarms.retain(|alarm| alarm.number != number);
        }
    }
}

impl EthernetPort for Handle {
    fn poll_receive(
        &mut self,
        context: &mut Context<'_>,
        buffer: &mut [u8],
    ) -> Poll<Result<usize, IoError>> {
        self.touch(|world| {
            let Some(frame) = world.ethernet_to_board.items.pop_front() else {
                world.ethernet_to_board.waker = Some(context.waker().clone());
                return Poll::Pending;
            };
            let Some(room) = buffer.get_mut(..frame.len()) else {
                return Poll::Ready(Err(IoError::Lost));
            };
            room.copy_from_slice(&frame);
            Poll::Ready(Ok(frame.len()))
        })
    }

    fn poll_send(&mut self, _context: &mut Context<'_>, frame: &[u8]) -> Poll<()> {
        self.touch(|world| world.ethernet_from_board.push_back(frame.to_vec()));
        Poll::Ready(())
    }
}

impl TimeSource for Handle {
    fn now_us(&self) -> u64 {
        Clock::now_us(self)
    }

    fn wake_at(&self, at_us: u64, waker: &Waker) {
        self.touch(|world| {
            world.set_alarm(at_us, waker);
        });
    }
}

impl Recorder for Handle {
    fn record(&mut self, record: &CycleRecord) {
        self.touch(|world| world.records.push(*record));
    }
}
