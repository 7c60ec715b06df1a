//! A board as a process in real time: RSI on a UDP socket, CAN through SLCAN (for a client on a TCP
//! socket, or with a real adapter) or the frames of an EtherCAT segment on a UDP socket, the service on a TCP socket or a pseudo-terminal, the operator on standard input.
//!
//! Each of the firmware's tasks has a thread, where it sleeps until it is woken; on a microcontroller
//! they have priorities instead. Each blocking source has a thread that fills a queue and wakes the
//! task that waits for it.
//!
//! When settings are committed the board starts over as a microcontroller does: everything that was built from the old settings
//! ends, and a new `session` begins with the contents of its flash. The line of the service stays open, as a serial line does.

use anyhow::{Context, Result};
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use softdock_app::service::End;
use softdock_app::settings::BoardSettings;
use softdock_app::store::{Boot, Origin, Store};
use softdock_io::identity;
use softdock_io::say;
use std::net::{SocketAddr, UdpSocket};
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};

mod can_bus;
mod clock;
mod line;
mod mailbox;
mod operator;
mod recorders;
mod segment_port;
mod service;
mod session;
mod slcan_client;
mod slcan_server;
mod telemetry;
mod udp;

pub use can_bus::CanAddress;
pub(super) use clock::RealClock;
pub use line::ServiceAddress;
pub use recorders::Record;
pub use slcan_client::AdapterPort;

use super::block_on::block_on;
use super::flash::FileFlash;
use can_bus::CanPort;
use line::Line;
use session::{BoardSession, Io};

/// The operator, the onlooker and the service have threads of their own.
type Shared = softdock_app::shared::Shared<CriticalSectionRawMutex>;

/// Where a board listens and what it does by itself.
#[derive(Clone, Debug)]
pub struct Process {
    /// Settings for a flash without any.
    pub settings: Option<BoardSettings>,
    /// File that is the board's flash; without one the flash is lost at the end.
    pub flash: Option<PathBuf>,
    /// UDP address for the robot's telegrams.
    pub robot: SocketAddr,
    /// Where the sensor's SLCAN client comes to, or its adapter is.
    pub can: Option<CanAddress>,
    /// UDP address for the sensor's EtherCAT segment.
    pub ethercat: Option<SocketAddr>,
    /// The line of the service.
    pub service: Option<ServiceAddress>,
    /// UDP address of the recorder that gets each cycle, in place of that of the settings.
    pub telemetry: Option<SocketAddr>,
    /// Arm and start, once, as soon as robot and sensor are healthy.
    pub start: bool,
}

/// A board whose addresses are taken.
pub struct Listening {
    udp: UdpSocket,
    can: Option<CanPort>,
    ethercat: Option<UdpSocket>,
    line: Option<Line>,
    store: Store<FileFlash>,
    telemetry: Option<SocketAddr>,
    identity: String,
    start: bool,
}

impl Process {
    /// Opens the flash and takes the addresses, so that what can go wrong has gone wrong before
    /// anything is written.
    pub fn listen(self, stop: &Arc<AtomicBool>) -> Result<Listening> {
        let udp = UdpSocket::bind(self.robot).with_context(|| in_use("robot (UDP)", self.robot))?;
        let can = self.can.map(CanPort::prepare).transpose()?;
        let bind = |address| {
            UdpSocket::bind(address).with_context(|| in_use("EtherCAT sensor (UDP)", address))
        };
        let ethercat = self.ethercat.map(bind).transpose()?;
        let line = self
            .service
            .map(|address| Line::open(address, stop))
            .transpose()?;
        let mut flash = FileFlash::open(self.flash.as_deref())?;
        if let Some(settings) = self.settings
            && !flash.put_if_empty(settings)?
            && let Some(path) = &self.flash
        {
            say!(
                "board: settings come from {}, which holds some already; --settings is not used",
                path.display()
            );
        }
        let service = line
            .as_ref()
            .map(|line| format!(", service on {}", line.place()))
            .unwrap_or_default();
        let mut sensor = String::new();
        if let Some(can) = &can {
            sensor += &format!(", {can}");
        }
        if let Some(ethercat) = &ethercat {
            sensor += &format!(", EtherCAT on UDP {}", ethercat.local_addr()?);
        }
        say!("board: robot on UDP {}{sensor}{service}", udp.local_addr()?);
        Ok(Listening {
            udp,
            can,
            ethercat,
            line,
            store: Store::new(flash),
            telemetry: self.telemetry,
            identity: identity::of_board_process(self.flash.is_some(), self.telemetry),
            start: self.start,
        })
    }
}

impl Listening {
    /// Runs the board until `stop` is raised. At each start `record` is called for the receiver of the records of its cycles.
    pub fn run(
        mut self,
        stop: &Arc<AtomicBool>,
        mut record: impl FnMut(&BoardSettings) -> Result<Record>,
    ) -> Result<()> {
        let current = Arc::new(Mutex::new(Arc::new(Shared::new())));
        operator::start_operator(current.clone());
        let mut block = Box::new([0; _]);
        let mut trial = None;
        loop {
            let boot = block_on(self.store.boot(trial, &mut block));
            report(&boot);
            let io = Io {
                udp: self.udp.try_clone()?,
                can: self.can.as_ref().map(CanPort::try_clone).transpose()?,
                ethercat: self
                    .ethercat
                    .as_ref()
                    .map(UdpSocket::try_clone)
                    .transpose()?,
                line: self.line.clone(),
                telemetry: self.telemetry,
                identity: self.identity.clone(),
            };
            // After a change of settings the operator starts by hand.
            let start = std::mem::take(&mut self.start);
            let session = BoardSession::prepare(boot, io, start)?;
            let record = record(session.settings())?;
            match session.run(stop, &current, &mut self.store, &mut block, record)? {
                End::Restart(next) if !stop.load(Ordering::Relaxed) => trial = next,
                // A process has no watchdog that would restart it: it starts over by itself.
                End::Hang if !stop.load(Ordering::Relaxed) => trial = None,
                _ => return Ok(()),
            }
            say!("board: starts over");
        }
    }
}

fn in_use(what: &str, address: SocketAddr) -> String {
    format!(
        "cannot listen for the {what} on {address}; is another board running, or is this not an address of this computer?"
    )
}

fn report(boot: &Boot) {
    match boot.origin {
        Origin::Flash { sequence, .. } => say!("board: settings {sequence}"),
        Origin::Trial(trial) => say!(
            "board: settings {} on trial for {} s",
            trial.sequence,
            trial.confirm_within_s
        ),
        Origin::Defaults(error) => say!("board: DEFAULT SETTINGS, not to be armed: {error}"),
    }
}
