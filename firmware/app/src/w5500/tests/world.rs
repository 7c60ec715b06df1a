//! Virtual time, the robot and others on the network, and a board that answers each telegram at once.

use super::emulated::{Bus, Emulated, interrupt};
use crate::board::Clock;
use crate::w5500::{Buffer, Chip, FRAME_BYTES, Health, run};
use embassy_net_driver::{Driver, HardwareAddress, LinkState, RxToken, TxToken};
use embassy_net_driver_channel::{Device, State, new};
use std::cell::{Cell, RefCell};
use std::future::{Future, poll_fn};
use std::pin::Pin;
use std::rc::Rc;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::task::{Context, Poll, Wake, Waker};

pub(super) const CYCLE_NS: u64 = 4_000_000;
const BOARD: [u8; 6] = [2, 0, 0, 0, 0, 1];
/// Frame types, and the offset of a telegram's number.
const TELEGRAM: [u8; 2] = [0x88, 0xB5];
const OTHER: [u8; 2] = [0x88, 0xB6];
const NUMBER: usize = 14;
/// Lengths of a telegram and of its answer.
const TELEGRAM_BYTES: usize = 550;
const ANSWER_BYTES: usize = 250;

#[derive(Default)]
pub(super) struct Time {
    now_ns: Cell<u64>,
    alarms: RefCell<Vec<(u64, Waker)>>,
}

impl Time {
    pub(super) fn now_ns(&self) -> u64 {
        self.now_ns.get()
    }

    pub(super) async fn wait_until_ns(&self, at_ns: u64) {
        poll_fn(|context| {
            if self.now_ns() >= at_ns {
                return Poll::Ready(());
            }
            let alarm = (at_ns, context.waker().clone());
            self.alarms.borrow_mut().push(alarm);
            Poll::Pending
        })
        .await;
    }

    fn next_ns(&self) -> u64 {
        let alarms = self.alarms.borrow();
        alarms.iter().map(|(at, _)| *at).min().unwrap_or(u64::MAX)
    }

    fn advance(&self, to_ns: u64) {
        self.now_ns.set(to_ns);
        let mut alarms = self.alarms.borrow_mut();
        alarms.retain(|(at_ns, waker)| {
            let due = *at_ns <= to_ns;
            if due {
                waker.wake_by_ref();
            }
            !due
        });
    }
}

impl Clock for Time {
    fn now_us(&self) -> u64 {
        self.now_ns() / 1000
    }

    async fn wait_until(&self, at_us: u64) {
        self.wait_until_ns(at_us.saturating_mul(1000)).await;
    }
}

/// Frames of others, one each `period_ns`.
#[derive(Clone)]
pub(super) struct Flood {
    pub(super) period_ns: u64,
    pub(super) bytes: usize,
}

#[derive(Default)]
struct Flag(AtomicBool);

impl Wake for Flag {
    fn wake(self: Arc<Self>) {
        self.0.store(true, Ordering::Relaxed);
    }
}

pub(super) struct World {
    pub(super) chip: Rc<RefCell<Emulated>>,
    pub(super) flood: Option<Flood>,
    /// The last state that the driver reported.
    pub(super) health: Rc<Cell<Health>>,
    /// Telegrams that the robot has sent.
    pub(super) cycles: u64,
    time: Rc<Time>,
    driver: Pin<Box<dyn Future<Output = ()>>>,
    board: Device<'static, FRAME_BYTES>,
    flooded_ns: u64,
}

impl World {
    pub(super) fn new(link: bool) -> Self {
        let time = Rc::<Time>::default();
        let chip = Rc::new(RefCell::new(Emulated::new(link)));
        let state: &'static mut State<FRAME_BYTES, 8, 4> = Box::leak(Box::new(State::new()));
        let (runner, board) = new(state, HardwareAddress::Ethernet(BOARD));
        let health = Rc::<Cell<Health>>::default();
        let driver = {
            let (bus, pin) = (Bus(chip.clone(), time.clone()), chip.clone());
            let (time, health) = (time.clone(), health.clone());
            async move {
                let mut buffer: Buffer = [0; size_of::<Buffer>()];
                let chip = Chip::new(bus, &mut buffer, BOARD);
                let low = async || interrupt(&pin).await;
                run(chip, low, runner, &*time, |now| health.set(*now)).await;
            }
        };
        Self {
            chip,
            flood: None,
            health,
            cycles: 0,
            time,
            driver: Box::pin(driver),
            board,
            flooded_ns: 0,
        }
    }

    pub(super) fn plug(&self, link: bool) {
        self.chip.borrow_mut().plug(link, self.time.now_ns());
    }

    /// Sends telegrams of the robot; returns which of them were answered within their cycle.
    pub(super) fn cycles(&mut self, count: u64) -> Vec<bool> {
        let first = self.cycles;
        for _ in 0..count {
            let telegram = frame(TELEGRAM, self.cycles, TELEGRAM_BYTES);
            self.chip.borrow_mut().arrive(&telegram);
            self.cycles += 1;
            self.run_until(self.cycles * CYCLE_NS);
        }
        let chip = self.chip.borrow();
        let in_time = |n: u64| {
            let from = n * CYCLE_NS..(n + 1) * CYCLE_NS;
            let is_it = |frame: &Vec<u8>| frame[NUMBER..NUMBER + 8] == n.to_be_bytes();
            chip.sent
                .iter()
                .any(|(at, frame)| from.contains(at) && is_it(frame))
        };
        (first..self.cycles).map(in_time).collect()
    }

    /// Frames are sent again.
    pub(super) fn release(&self) {
        self.chip.borrow_mut().jammed = false;
        self.plug(true);
    }

    /// Some cycles in which nobody sends.
    pub(super) fn quiet(&mut self, cycles: u64) {
        self.cycles += cycles;
        self.run_until(self.cycles * CYCLE_NS);
    }

    /// Whether the network was told of a link.
    pub(super) fn is_up(&mut self) -> bool {
        let context = &mut Context::from_waker(Waker::noop());
        self.board.link_state(context) == LinkState::Up
    }

    /// Other frames, one behind the other.
    pub(super) fn burst(&mut self, count: usize, bytes: usize) {
        for _ in 0..count {
            self.chip.borrow_mut().arrive(&frame(OTHER, 0, bytes));
        }
    }

    fn run_until(&mut self, end_ns: u64) {
        while self.time.now_ns() < end_ns {
            self.poll();
            let flood = self.flood.clone();
            let next_flood = flood.as_ref().map_or(u64::MAX, |flood| {
                self.flooded_ns.max(self.time.now_ns()) + flood.period_ns
            });
            let now = self.time.next_ns().min(next_flood).min(end_ns);
            self.time.advance(now);
            if let Some(flood) = flood.filter(|_| now == next_flood) {
                self.flooded_ns = now;
                self.burst(1, flood.bytes);
            }
        }
        self.poll();
    }

    /// Polls driver and board until both wait.
    fn poll(&mut self) {
        let flag = Arc::new(Flag::default());
        let waker = Waker::from(flag.clone());
        let context = &mut Context::from_waker(&waker);
        loop {
            flag.0.store(false, Ordering::Relaxed);
            assert!(self.driver.as_mut().poll(context).is_pending());
            while let Some((frame, room)) = self.board.receive(context) {
                answer(frame, room);
            }
            if !flag.0.load(Ordering::Relaxed) {
                return;
            }
        }
    }
}

fn answer(frame: impl RxToken, room: impl TxToken) {
    let number = frame.consume(|frame| match frame[12..14] == TELEGRAM {
        true => frame[NUMBER..].first_chunk().copied(),
        false => None,
    });
    if let Some(number) = number {
        let bytes = self::frame(TELEGRAM, u64::from_be_bytes(number), ANSWER_BYTES);
        room.consume(bytes.len(), |room| room.copy_from_slice(&bytes));
    }
}

fn frame(kind: [u8; 2], number: u64, length: usize) -> Vec<u8> {
    let mut frame = BOARD.to_vec();
    frame.extend([2, 0, 0, 0, 0, 9]);
    frame.extend(kind);
    frame.extend(number.to_be_bytes());
    frame.resize(length, 0);
    frame
}
