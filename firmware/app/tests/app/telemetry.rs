//! From the cycle to the recorder's datagrams, in virtual time.

use crate::bench::{Bench, flying};
use crate::world::{Handle, Task, run};
use embassy_sync::blocking_mutex::raw::NoopRawMutex;
use embassy_sync::zerocopy_channel::Channel;
use softdock_app::board::{DatagramSink, IoError, Recorder};
use softdock_app::record::CycleRecord;
use softdock_app::telemetry::{
    ANNOUNCE_PERIOD_US, Announcement, Datagram, Kind, MessagePart, RecordQueue, Slot, Stream,
    encode, read_record, schema, transmit,
};
use softdock_link::service::Machine;
use std::cell::{Cell, RefCell};
use std::future::poll_fn;
use std::net::SocketAddr;
use std::rc::Rc;
use std::task::{Poll, Waker};

const BOOT: u32 = 0xb007;
const ANNOUNCEMENT: Announcement<'_> = Announcement {
    image: &[7; 3000],
    identity: "softdock 0.1.0 (test)",
};
/// Slots of the bench, and datagrams between its tasks.
const SLOTS: usize = 8;
const DATAGRAMS: usize = 4;

fn recorder() -> SocketAddr {
    "192.168.1.5:49200".parse().unwrap()
}

/// A network that can be blocked.
#[derive(Clone, Default)]
struct Network {
    sent: Rc<RefCell<Vec<Vec<u8>>>>,
    jammed: Rc<Cell<bool>>,
    waker: Rc<RefCell<Option<Waker>>>,
    closed: bool,
}

impl Network {
    fn jam(&self, jammed: bool) {
        self.jammed.set(jammed);
        if let Some(waker) = self.waker.take() {
            waker.wake();
        }
    }
}

impl DatagramSink for Network {
    async fn send(&mut self, datagram: &[u8], to: SocketAddr) -> Result<(), IoError> {
        assert_eq!(to, recorder());
        if self.closed {
            return Err(IoError::Closed);
        }
        poll_fn(|context| match self.jammed.get() {
            true => {
                self.waker.replace(Some(context.waker().clone()));
                Poll::Pending
            }
            false => Poll::Ready(()),
        })
        .await;
        self.sent.borrow_mut().push(datagram.to_vec());
        // Every third is lost, which shows only in the sequence numbers.
        match self.sent.borrow().len() % 3 {
            0 => Err(IoError::Lost),
            _ => Ok(()),
        }
    }
}

/// Both tasks between a queue and a network.
struct Telemetry {
    queue: RecordQueue<'static, NoopRawMutex>,
    network: Network,
    world: Handle,
    tasks: Vec<Task>,
    now_us: u64,
}

impl Telemetry {
    fn new(network: Network) -> Self {
        let slots = Box::leak(Box::new([Slot::default(); SLOTS]));
        let slots = Box::leak(Box::new(Channel::<NoopRawMutex, Slot>::new(slots)));
        let datagrams = Vec::leak(vec![Datagram::new(); DATAGRAMS]);
        let datagrams = Box::leak(Box::new(Channel::<NoopRawMutex, Datagram>::new(datagrams)));
        let (records, taken) = slots.split();
        let (made, waiting) = datagrams.split();
        let world = Handle::default();
        let (clock, mut sink) = (world.clone(), network.clone());
        let tasks = vec![
            Task::new(async move {
                encode(
                    taken,
                    made,
                    &clock,
                    Stream::new(BOOT),
                    &ANNOUNCEMENT,
                    Machine::default,
                )
                .await;
            }),
            Task::new(async move { transmit(waiting, &mut sink, recorder()).await }),
        ];
        Self {
            queue: RecordQueue::new(records),
            network,
            world,
            tasks,
            now_us: 0,
        }
    }

    fn run_for(&mut self, us: u64) {
        self.now_us += us;
        run(&self.world, &mut self.tasks, self.now_us);
    }

    /// Kind, part number, sequence number, number of lost records, and the cycle of a record.
    fn sent(&self) -> Vec<(Kind, u8, u32, u32, Option<u64>)> {
        let sent = self.network.sent.borrow();
        let read = |datagram: &Vec<u8>| {
            let part = MessagePart::read(datagram).unwrap();
            assert_eq!((part.boot, part.schema), (BOOT, schema()));
            let record = (part.kind == Kind::Record).then(|| read_record(part.payload).unwrap());
            let cycle = record.map(|record| record.trace.cycle);
            (part.kind, part.part, part.sequence, part.lost, cycle)
        };
        sent.iter().map(read).collect()
    }

    fn cycles(&self) -> Vec<u64> {
        self.sent().iter().filter_map(|sent| sent.4).collect()
    }
}

fn record(cycle: u64) -> CycleRecord {
    let mut record = CycleRecord::default();
    record.trace.cycle = cycle;
    record
}

#[test]
fn the_board_is_announced_at_boot_and_in_every_period() {
    let mut telemetry = Telemetry::new(Network::default());
    telemetry.run_for(0);
    let parts = |first| {
        let announced = (0..3).map(move |part| (Kind::Announcement, part, first + u32::from(part)));
        announced.chain([(Kind::Machine, 0, first + 3)])
    };
    let head = |sent: Vec<(Kind, u8, u32, u32, Option<u64>)>| -> Vec<(Kind, u8, u32)> {
        sent.into_iter()
            .map(|(kind, part, sequence, ..)| (kind, part, sequence))
            .collect()
    };
    assert_eq!(head(telemetry.sent()), parts(0).collect::<Vec<_>>());
    telemetry.run_for(ANNOUNCE_PERIOD_US - 1);
    assert_eq!(telemetry.sent().len(), 4);
    telemetry.run_for(1);
    let twice: Vec<_> = parts(0).chain(parts(4)).collect();
    assert_eq!(head(telemetry.sent()), twice);
}

#[test]
fn every_cycle_of_a_board_is_sent_once_with_all_its_numbers() {
    let mut bench = Bench::new(&flying(), true);
    bench.cycles(40);
    let records = bench.world().records.clone();
    let mut telemetry = Telemetry::new(Network::default());
    for record in &records {
        telemetry.queue.record(record);
        telemetry.run_for(4_000);
    }
    let sent = telemetry.network.sent.borrow();
    let parts = sent
        .iter()
        .map(|datagram| MessagePart::read(datagram).unwrap());
    let received: Vec<CycleRecord> = parts
        .filter(|part| part.kind == Kind::Record)
        .map(|part| read_record(part.payload).unwrap())
        .collect();
    assert_eq!(received, records);
}

/// The cycle goes on whatever the network does; the number of dropped records comes with the next record.
#[test]
fn a_jammed_network_costs_records_and_no_cycle() {
    let mut telemetry = Telemetry::new(Network::default());
    telemetry.run_for(0);
    telemetry.network.jam(true);
    for cycle in 0..50 {
        telemetry.queue.record(&record(cycle));
        telemetry.run_for(4_000);
    }
    // One waits in the socket, which occupies the last datagram's place until it is sent; another is in the encoder, and its
    // slot is already free.
    let kept = DATAGRAMS + 1 + SLOTS;
    telemetry.network.jam(false);
    telemetry.run_for(4_000);
    telemetry.queue.record(&record(50));
    telemetry.run_for(4_000);
    let expected: Vec<u64> = (0..kept as u64).chain([50]).collect();
    assert_eq!(telemetry.cycles(), expected);
    let sent = telemetry.sent();
    let lost = sent.last().map(|last| last.3);
    assert_eq!(lost, Some(50 - kept as u32));
    // After the queue, nothing was lost.
    let sequences = sent.iter().map(|sent| sent.2);
    assert!(sequences.eq(0..sent.len() as u32));
}

#[test]
fn closing_sends_what_waits_and_ends_the_tasks() {
    let Telemetry {
        mut queue,
        network,
        world,
        mut tasks,
        ..
    } = Telemetry::new(Network::default());
    for cycle in 0..SLOTS as u64 + 3 {
        queue.record(&record(cycle));
    }
    tasks.push(Task::new(queue.close()));
    run(&world, &mut tasks, 0);
    assert!(tasks.iter().all(Task::has_ended));
    let sent = network.sent.borrow();
    let parts: Vec<MessagePart<'_>> = sent
        .iter()
        .map(|sent| MessagePart::read(sent).unwrap())
        .collect();
    let records = parts.iter().filter(|part| part.kind == Kind::Record);
    assert_eq!(records.count(), SLOTS);
    let last = parts.last().unwrap();
    assert_eq!((last.kind, last.lost), (Kind::Announcement, 3));
}

#[test]
fn a_socket_that_is_closed_ends_its_task_and_no_cycle_waits() {
    let network = Network {
        closed: true,
        ..Network::default()
    };
    let mut telemetry = Telemetry::new(network);
    for cycle in 0..100 {
        telemetry.queue.record(&record(cycle));
        telemetry.run_for(4_000);
    }
    let ended: Vec<bool> = telemetry.tasks.iter().map(Task::has_ended).collect();
    assert_eq!(ended, [false, true]);
    assert_eq!(telemetry.network.sent.borrow().len(), 0);
}
