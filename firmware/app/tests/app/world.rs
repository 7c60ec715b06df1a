//! Bus, socket, clock and recorder in virtual time, and the executor that runs the tasks on them.
//!
//! A task is polled only if it was woken, so a missing wake-up is noticed. All events of one time happen before any task is
//! polled.

use crate::sensor::Sensor;
use softdock_app::board::{Clock, DatagramSocket, IoError, Recorder, SensorBus};
use softdock_app::record::CycleRecord;
use softdock_link::can::Frame;
use std::cell::RefCell;
use std::collections::{BTreeMap, VecDeque};
use std::future::{Future, pending, poll_fn};
use std::net::SocketAddr;
use std::pin::Pin;
use std::rc::Rc;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::task::{Context, Poll, Wake, Waker};

/// An event outside of the board.
#[derive(Clone, Debug)]
pub(crate) enum Event {
    Frame(Result<Frame, IoError>),
    Datagram(Vec<u8>, SocketAddr),
    /// Socket and bus are closed.
    Close,
}

/// An answer of the board.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Sent {
    pub(crate) at_us: u64,
    pub(crate) bytes: Vec<u8>,
    pub(crate) to: SocketAddr,
}

/// Items that wait for a task, and the waker of that task.
#[derive(Debug)]
struct Inbox<T> {
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
    fn push(&mut self, item: T) {
        self.items.push_back(item);
        self.wake();
    }

    fn wake(&mut self) {
        if let Some(waker) = self.waker.take() {
            waker.wake();
        }
    }
}

#[derive(Debug, Default)]
pub(crate) struct World {
    pub(crate) now_us: u64,
    events: BTreeMap<(u64, usize), Event>,
    event_count: usize,
    alarms: Vec<(u64, Waker)>,
    frames: Inbox<Result<Frame, IoError>>,
    datagrams: Inbox<(Vec<u8>, SocketAddr)>,
    arrivals: Vec<(SocketAddr, u64)>,
    closed: bool,
    pub(crate) sensor: Sensor,
    /// Frames sent by the board, with their times.
    pub(crate) requests: Vec<(u64, Frame)>,
    pub(crate) answers: Vec<Sent>,
    pub(crate) records: Vec<CycleRecord>,
    /// The controller is bus-off until its recovery.
    pub(crate) bus_off: bool,
    /// The bus fails again after each recovery.
    pub(crate) cable_broken: bool,
    /// The transmit queue is full and stays so.
    pub(crate) transmit_full: bool,
    pub(crate) recoveries_us: Vec<u64>,
}

impl World {
    fn happen(&mut self, event: Event) {
        match event {
            Event::Frame(frame) => self.frames.push(frame),
            Event::Datagram(bytes, from) => {
                self.arrivals.push((from, self.now_us));
                self.datagrams.push((bytes, from));
            }
            Event::Close => {
                self.closed = true;
                self.frames.wake();
                self.datagrams.wake();
            }
        }
    }

    pub(crate) fn schedule(&mut self, at_us: u64, event: Event) {
        self.events.insert((at_us, self.event_count), event);
        self.event_count += 1;
    }

    /// Makes the bus fail for the task that waits for a frame.
    pub(crate) fn go_bus_off(&mut self) {
        self.bus_off = true;
        self.frames.wake();
    }

    /// Advances the clock to the next time at which something happens, unless that is later than `until_us`.
    fn advance(&mut self, until_us: u64) -> bool {
        let alarm = self.alarms.iter().map(|(at, _)| *at).min();
        let event = self.events.keys().next().map(|(at, _)| *at);
        let next = alarm.into_iter().chain(event).min().unwrap_or(u64::MAX);
        if next > until_us {
            self.now_us = until_us;
            return false;
        }
        self.now_us = next.max(self.now_us);
        let now_us = self.now_us;
        for (_, waker) in self.alarms.extract_if(.., |(at, _)| *at <= now_us) {
            waker.wake();
        }
        while let Some(first) = self.events.first_entry().filter(|e| e.key().0 <= now_us) {
            let event = first.remove();
            self.happen(event);
        }
        true
    }
}

/// A task's handle on the world.
#[derive(Clone, Debug, Default)]
pub(crate) struct Handle(pub(crate) Rc<RefCell<World>>);

impl SensorBus for Handle {
    type Frame = Frame;

    async fn send(&mut self, frame: &Frame) -> Result<(), IoError> {
        if self.0.borrow().transmit_full {
            return pending().await;
        }
        let world = &mut *self.0.borrow_mut();
        if world.bus_off {
            return Err(IoError::BusOff);
        }
        world.requests.push((world.now_us, *frame));
        for (delay_us, frame) in world.sensor.answer(frame) {
            world.schedule(world.now_us + delay_us, Event::Frame(Ok(frame)));
        }
        Ok(())
    }

    async fn receive(&mut self) -> Result<Frame, IoError> {
        poll_fn(|context| {
            let world = &mut *self.0.borrow_mut();
            if world.closed {
                return Poll::Ready(Err(IoError::Closed));
            }
            if world.bus_off {
                return Poll::Ready(Err(IoError::BusOff));
            }
            take(&mut world.frames, context)
        })
        .await
    }

    async fn recover(&mut self) -> Result<(), IoError> {
        let world = &mut *self.0.borrow_mut();
        world.recoveries_us.push(world.now_us);
        world.bus_off = world.cable_broken;
        Ok(())
    }
}

impl DatagramSocket for Handle {
    async fn receive(&mut self, buffer: &mut [u8]) -> Result<(usize, SocketAddr), IoError> {
        let (bytes, from) = poll_fn(|context| {
            let world = &mut *self.0.borrow_mut();
            if world.closed {
                return Poll::Ready(Err(IoError::Closed));
            }
            take(&mut world.datagrams, context).map(Ok)
        })
        .await?;
        Ok((copy(&bytes, buffer), from))
    }

    fn try_receive(&mut self, buffer: &mut [u8]) -> Option<(usize, SocketAddr)> {
        let (bytes, from) = self.0.borrow_mut().datagrams.items.pop_front()?;
        Some((copy(&bytes, buffer), from))
    }

    fn came_us(&self, sender: SocketAddr) -> Option<u64> {
        let world = self.0.borrow();
        let newest = world.arrivals.iter().rfind(|(from, _)| *from == sender);
        newest.map(|(_, at_us)| *at_us)
    }

    async fn send(&mut self, datagram: &[u8], to: SocketAddr) -> Result<(), IoError> {
        let world = &mut *self.0.borrow_mut();
        if world.closed {
            return Err(IoError::Closed);
        }
        world.answers.push(Sent {
            at_us: world.now_us,
            bytes: datagram.to_vec(),
            to,
        });
        Ok(())
    }
}

impl Clock for Handle {
    fn now_us(&self) -> u64 {
        self.0.borrow().now_us
    }

    async fn wait_until(&self, at_us: u64) {
        poll_fn(|context| {
            let world = &mut *self.0.borrow_mut();
            if world.now_us >= at_us {
                return Poll::Ready(());
            }
            if at_us != u64::MAX {
                world.alarms.push((at_us, context.waker().clone()));
            }
            Poll::Pending
        })
        .await;
    }
}

impl Recorder for Handle {
    fn record(&mut self, record: &CycleRecord) {
        self.0.borrow_mut().records.push(*record);
    }
}

fn take<T>(inbox: &mut Inbox<T>, context: &Context<'_>) -> Poll<T> {
    match inbox.items.pop_front() {
        Some(item) => Poll::Ready(item),
        None => {
            inbox.waker = Some(context.waker().clone());
            Poll::Pending
        }
    }
}

fn copy(bytes: &[u8], buffer: &mut [u8]) -> usize {
    let length = bytes.len().min(buffer.len());
    buffer[..length].copy_from_slice(&bytes[..length]);
    length
}

/// Whether a task was woken.
#[derive(Debug)]
struct Woken(AtomicBool);

impl Wake for Woken {
    fn wake(self: Arc<Self>) {
        self.0.store(true, Ordering::Relaxed);
    }
}

/// A task of the board.
pub(crate) struct Task {
    future: Option<Pin<Box<dyn Future<Output = ()>>>>,
    woken: Arc<Woken>,
}

impl Task {
    pub(crate) fn new(future: impl Future<Output = ()> + 'static) -> Self {
        Self {
            future: Some(Box::pin(future)),
            woken: Arc::new(Woken(AtomicBool::new(true))),
        }
    }

    pub(crate) fn has_ended(&self) -> bool {
        self.future.is_none()
    }

    /// Polls the task if it was woken.
    fn turn(&mut self) -> bool {
        if !self.woken.0.swap(false, Ordering::Relaxed) {
            return false;
        }
        let waker = Waker::from(self.woken.clone());
        if let Some(future) = &mut self.future
            && future
                .as_mut()
                .poll(&mut Context::from_waker(&waker))
                .is_ready()
        {
            self.future = None;
        }
        true
    }
}

/// Runs the tasks until a time; at that time they are all waiting.
pub(crate) fn run(world: &Handle, tasks: &mut [Task], until_us: u64) {
    loop {
        let mut turns = 0;
        while tasks.iter_mut().fold(false, |any, task| any | task.turn()) {
            turns += 1;
            assert!(turns < 10_000, "the tasks do not come to rest");
        }
        if !world.0.borrow_mut().advance(until_us) {
            return;
        }
    }
}
