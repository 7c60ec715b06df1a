//! One run of the board's firmware: from its start until it starts over or ends.

use super::can_bus::{CanBus, CanPort};
use super::clock::RealClock;
use super::line::Line;
use super::operator::start_watch;
use super::recorders::{Record, Recorders};
use super::segment_port::SegmentPort;
use super::telemetry::Telemetry;
use super::udp::UdpPort;
use super::{Shared, service};
use crate::board::block_on::block_on;
use crate::board::flash::FileFlash;
use crate::board::tasks;
use anyhow::{Result, anyhow};
use softdock_app::robot_link::{Prepared, RobotLink};
use softdock_app::service::End;
use softdock_app::settings::BoardSettings;
use softdock_app::shared::LinkCounters;
use softdock_app::store::{Block, Boot, Origin, Store};
use softdock_io::say;
use std::net::{SocketAddr, UdpSocket};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;

/// The ports of a board.
pub(super) struct Io {
    pub(super) udp: UdpSocket,
    pub(super) can: Option<CanPort>,
    pub(super) ethercat: Option<UdpSocket>,
    pub(super) line: Option<Line>,
    /// Address of the recorder, in place of that in the settings.
    pub(super) telemetry: Option<SocketAddr>,
    /// Identity of the board.
    pub(super) identity: String,
}

/// The links of a board, each with threads of its own.
struct Links {
    robot: UdpPort,
    bus: Option<CanBus>,
    segment: Option<SegmentPort>,
}

impl Links {
    /// They end when `ended` is raised.
    fn start(
        (robot, can, ethercat): (UdpSocket, Option<CanPort>, Option<UdpSocket>),
        ended: &Arc<AtomicBool>,
    ) -> Result<Self> {
        let segment = |socket| SegmentPort::start(socket, ended.clone());
        Ok(Self {
            robot: UdpPort::start(robot, ended.clone())?,
            bus: can.map(|port| port.start(ended.clone())).transpose()?,
            segment: ethercat.map(segment).transpose()?,
        })
    }
}

/// A board that is ready to run.
pub(super) struct BoardSession {
    boot: Boot,
    io: Io,
    link: RobotLink<f64>,
    telemetry: Option<Telemetry>,
    start: bool,
}

impl BoardSession {
    /// Builds what the settings ask for. A board without settings does not start by itself.
    pub(super) fn prepare(boot: Boot, io: Io, start: bool) -> Result<Self> {
        let settings = &boot.settings;
        let recorder = match io.telemetry {
            Some(recorder) => Some(recorder),
            None => settings.network.recorder()?.map(SocketAddr::V4),
        };
        let telemetry = recorder
            .map(|recorder| Telemetry::new(settings, recorder))
            .transpose()?;
        Ok(Self {
            link: RobotLink::new(Prepared::new(settings)?),
            telemetry,
            start: start && !matches!(boot.origin, Origin::Defaults(_)),
            boot,
            io,
        })
    }

    pub(super) fn settings(&self) -> &BoardSettings {
        &self.boot.settings
    }

    /// Runs until `stop` is raised or the service has the board start over.
    pub(super) fn run(
        self,
        stop: &Arc<AtomicBool>,
        current: &Mutex<Arc<Shared>>,
        store: &mut Store<FileFlash>,
        block: &mut Block,
        record: Record,
    ) -> Result<End> {
        let Self { boot, io, .. } = self;
        let ended = Arc::new(AtomicBool::new(false));
        let shared = Arc::new(Shared::new());
        *current.lock().unwrap_or_else(PoisonError::into_inner) = shared.clone();
        let clock = RealClock::start();
        let links = Links::start((io.udp, io.can, io.ethercat), &ended)?;
        let (recorders, writers) = Recorders::start(record, self.telemetry, &clock, &shared);
        let watch = start_watch(shared.clone(), stop.clone(), ended.clone());
        let settings = boot.settings.clone();
        let wait_us = settings.sample_wait_us();
        let (link, start) = (self.link, self.start);
        let end = thread::scope(|scope| {
            let (shared, ended, clock, boot) = (&*shared, &ended, &clock, &boot);
            let service = io.line.map(|line| {
                scope.spawn(move || {
                    let end = service::run(shared, boot, line, clock, store, block, &io.identity);
                    ended.store(true, Ordering::Relaxed);
                    end
                })
            });
            let (bus, segment) = (links.bus, links.segment);
            scope.spawn(|| block_on(tasks::sensor(shared, settings, bus, segment, clock.clone())));
            let io = (links.robot, clock.clone());
            let mut recorders = recorders;
            block_on(async {
                tasks::robot(shared, link, start, wait_us, io, &mut recorders).await;
                recorders.close().await;
            });
            // Without a service nothing but `stop` ends the tasks.
            service.map_or(Ok(End::Closed), thread::ScopedJoinHandle::join)
        });
        let end = end.map_err(|_| anyhow!("the service's thread ended unexpectedly"))?;
        let _ = watch.join();
        print_counters(&shared.status().link);
        writers.join()?;
        Ok(end)
    }
}

fn print_counters(link: &LinkCounters) {
    say!(
        "board: {} cycles, {} lost, {} twice, {} overtaken, {} malformed, {} foreign",
        link.cycles,
        link.lost,
        link.duplicates,
        link.overtaken,
        link.malformed,
        link.foreign
    );
}
