//! A board as a process in real time: RSI on a UDP socket, CAN through SLCAN on a TCP socket, the
//! operator on standard input.
//!
//! The firmware's tasks run on Embassy's executor in the calling thread. Each blocking source has
//! a thread of its own that fills a queue and wakes the task that waits for it.

use super::tasks;
use anyhow::{Context, Result, anyhow};
use embassy_executor::Executor;
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use softdock_app::board::Recorder;
use softdock_app::robot_link::RobotLink;
use softdock_app::settings::BoardSettings;
use softdock_app::shared::{LinkCounters, Status};
use softdock_control::io::CycleRecord;
use softdock_control::modes::Command;
use std::io::BufRead;
use std::net::{SocketAddr, TcpListener, UdpSocket};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::{SyncSender, TrySendError, sync_channel};
use std::thread;
use std::time::Duration;

mod clock;
mod mailbox;
mod slcan_server;
mod telemetry;
mod udp;

use clock::RealClock;
use slcan_server::SlcanBus;
use telemetry::Telemetry;
use udp::UdpPort;

/// The operator and the onlooker have threads of their own.
type Shared = softdock_app::shared::Shared<CriticalSectionRawMutex>;

/// Records that wait for the recorder: 4 s of cycles, for a disk that takes its time.
const RECORD_QUEUE: usize = 1000;
/// How often the onlooker looks for changes of mode and for faults.
const WATCH_PERIOD: Duration = Duration::from_millis(50);

/// Where a board listens and what it does by itself.
#[derive(Clone, Debug)]
pub struct Process {
    /// Settings of the board.
    pub settings: BoardSettings,
    /// UDP address for the robot's telegrams.
    pub robot: SocketAddr,
    /// TCP address for the sensor's SLCAN client.
    pub can: SocketAddr,
    /// UDP address of the recorder that gets each cycle, in place of that of the settings.
    pub telemetry: Option<SocketAddr>,
    /// Arm and start as soon as robot and sensor are healthy.
    pub start: bool,
}

/// A board whose addresses are taken.
pub struct Listening {
    process: Process,
    link: RobotLink<f64>,
    udp: UdpSocket,
    tcp: TcpListener,
    telemetry: Option<Telemetry>,
}

impl Process {
    /// Checks the settings and takes the addresses, so that what can go wrong has gone wrong before
    /// anything is written.
    pub fn listen(self) -> Result<Listening> {
        let link = RobotLink::<f64>::new(&self.settings)?;
        let in_use = |what: &str, address: SocketAddr| {
            format!(
                "cannot listen for the {what} on {address}; is another board running, or is this not an address of this computer?"
            )
        };
        let udp = UdpSocket::bind(self.robot).with_context(|| in_use("robot (UDP)", self.robot))?;
        let tcp = TcpListener::bind(self.can).with_context(|| in_use("sensor (TCP)", self.can))?;
        eprintln!(
            "board: robot on UDP {}, SLCAN on TCP {}",
            udp.local_addr()?,
            tcp.local_addr()?
        );
        let recorder = match self.telemetry {
            Some(recorder) => Some(recorder),
            None => self.settings.network.recorder()?.map(SocketAddr::V4),
        };
        let telemetry = recorder
            .map(|recorder| Telemetry::new(&self.settings, recorder))
            .transpose()?;
        Ok(Listening {
            process: self,
            link,
            udp,
            tcp,
            telemetry,
        })
    }
}

impl Listening {
    /// Runs the board until `stop` is raised. `record` gets the records as they come, on a thread
    /// of its own.
    pub fn run(
        self,
        stop: &Arc<AtomicBool>,
        record: impl FnOnce(&mut dyn Iterator<Item = CycleRecord>) -> Result<()> + Send + 'static,
    ) -> Result<()> {
        let Process {
            settings, start, ..
        } = self.process;
        let shared = Arc::new(Shared::new());
        let clock = RealClock::start();
        let port = UdpPort::start(self.udp, stop.clone())?;
        let bus = SlcanBus::start(self.tcp, stop.clone())?;
        let (file, writer) = start_recorder(record);
        let (telemetry, sender) = self
            .telemetry
            .map(|telemetry| telemetry.start(clock.clone()))
            .unzip();
        let recorders = Recorders { file, telemetry };
        start_operator(shared.clone());
        let watch = start_watch(shared.clone(), stop.clone());

        let wait = settings.can.sample_wait_us();
        let running = Arc::new(AtomicUsize::new(2));
        let io = (bus, clock.clone());
        let sensor = sensor_task(shared.clone(), settings, io, running.clone());
        let io = (port, clock, recorders);
        let robot = robot_task(shared.clone(), self.link, start, wait, io, running.clone());
        let (Ok(sensor), Ok(robot)) = (sensor, robot) else {
            return Err(anyhow!("only one board can run in a process"));
        };
        // The executor lives as long as the process, as on a microcontroller.
        let executor: &'static mut Executor = Box::leak(Box::new(Executor::new()));
        executor.run_until(
            |spawner| {
                spawner.spawn(sensor);
                spawner.spawn(robot);
            },
            || running.load(Ordering::Acquire) == 0,
        );
        let _ = watch.join();
        print_counters(&shared.status().link);
        if let Some(sender) = sender {
            sender
                .join()
                .map_err(|_| anyhow!("the telemetry's thread ended unexpectedly"))?;
        }
        writer
            .join()
            .map_err(|_| anyhow!("the recorder's thread ended unexpectedly"))?
    }
}

fn print_counters(link: &LinkCounters) {
    eprintln!(
        "board: {} cycles, {} lost, {} twice, {} overtaken, {} malformed, {} foreign",
        link.cycles, link.lost, link.duplicates, link.overtaken, link.malformed, link.foreign
    );
}

#[embassy_executor::task]
async fn sensor_task(
    shared: Arc<Shared>,
    settings: BoardSettings,
    io: (SlcanBus, RealClock),
    running: Arc<AtomicUsize>,
) {
    tasks::sensor(&shared, settings, io.0, io.1).await;
    running.fetch_sub(1, Ordering::Release);
}

#[embassy_executor::task]
async fn robot_task(
    shared: Arc<Shared>,
    link: RobotLink<f64>,
    start: bool,
    sample_wait_us: u64,
    io: (UdpPort, RealClock, Recorders),
    running: Arc<AtomicUsize>,
) {
    let (port, clock, mut recorders) = io;
    let io = (port, clock);
    tasks::robot(&shared, link, start, sample_wait_us, io, &mut recorders).await;
    if let Some(telemetry) = recorders.telemetry {
        telemetry.close().await;
    }
    running.fetch_sub(1, Ordering::Release);
}

/// Those who get the record of each cycle.
struct Recorders {
    file: QueueRecorder,
    telemetry: Option<telemetry::Queue>,
}

impl Recorder for Recorders {
    fn record(&mut self, record: &CycleRecord) {
        self.file.record(record);
        if let Some(telemetry) = &mut self.telemetry {
            telemetry.record(record);
        }
    }
}

/// Hands records to the recorder's thread; a full queue loses the record, never the cycle.
struct QueueRecorder {
    queue: SyncSender<CycleRecord>,
    lost: u64,
}

impl Recorder for QueueRecorder {
    fn record(&mut self, record: &CycleRecord) {
        if let Err(TrySendError::Full(_)) = self.queue.try_send(*record) {
            self.lost += 1;
        }
    }
}

impl Drop for QueueRecorder {
    fn drop(&mut self) {
        if self.lost > 0 {
            eprintln!(
                "board: {} records were lost: the recorder was too slow",
                self.lost
            );
        }
    }
}

/// A thread that writes records until the queue's sender is gone. An error of the recorder stops
/// the recording, not the board.
fn start_recorder(
    record: impl FnOnce(&mut dyn Iterator<Item = CycleRecord>) -> Result<()> + Send + 'static,
) -> (QueueRecorder, thread::JoinHandle<Result<()>>) {
    let (queue, records) = sync_channel(RECORD_QUEUE);
    let writer = thread::spawn(move || {
        let mut records = records.into_iter();
        let outcome = record(&mut records);
        if let Err(error) = &outcome {
            eprintln!("board: the recording ends here, the board goes on: {error:#}");
        }
        records.for_each(drop);
        outcome
    });
    (QueueRecorder { queue, lost: 0 }, writer)
}

/// A thread that reads the operator's commands. It ends with standard input.
fn start_operator(shared: Arc<Shared>) {
    thread::spawn(move || {
        // Bytes that are no text are no command either, and no reason to stop listening.
        for line in std::io::stdin().lock().split(b'\n') {
            let Ok(line) = line else { return };
            let line = String::from_utf8_lossy(&line);
            let word = line.trim();
            match Command::from_word(word) {
                Some(command) => {
                    if shared.commands.try_send(command).is_err() {
                        eprintln!("board: `{word}` is lost: too many commands wait already");
                    } else if !shared.status().connected {
                        eprintln!(
                            "board: `{word}` waits: the robot is silent (a new RSI run drops it)"
                        );
                    }
                }
                None if word.is_empty() => {}
                None => {
                    let known: Vec<&str> = Command::WORDS.iter().map(|(word, _)| *word).collect();
                    eprintln!(
                        "board: `{word}` is no command; expected one of {}",
                        known.join(", ")
                    );
                }
            }
        }
    });
}

/// A thread that reports changes of mode, faults and refused commands.
fn start_watch(shared: Arc<Shared>, stop: Arc<AtomicBool>) -> thread::JoinHandle<()> {
    thread::spawn(move || {
        // From the state at boot on: a quick start is a change as well.
        let mut last = Status::default();
        while !stop.load(Ordering::Relaxed) {
            thread::sleep(WATCH_PERIOD);
            let now = shared.status();
            if now.mode != last.mode {
                eprintln!("board: mode {:?}", now.mode);
            }
            if let Some(fault) = now.fault.filter(|_| now.fault != last.fault) {
                let softdock_control::modes::Fault {
                    code,
                    expected,
                    received,
                } = fault;
                eprintln!(
                    "board: fault {code:?}: expected {expected}, received {received}; `reset` when it is mended"
                );
            }
            if let Some((command, refusal)) = now.refusal.filter(|_| now.refusal != last.refusal) {
                eprintln!("board: {command:?} refused: {refusal:?}");
            }
            if let Some(sensor) = now.sensor.filter(|_| now.sensor != last.sensor) {
                eprintln!("board: sensor {sensor:?}");
            }
            last = now;
        }
    })
}
