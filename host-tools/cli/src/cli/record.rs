//! `softdock record`: telemetry of a board into recordings.

use super::answer;
use super::live::raised_by_ctrl_c;
use super::outputs::mcap_file;
use super::piece_args::PieceArgs;
use super::progress::spinner;
use anyhow::{Result, bail, ensure};
use clap::Args;
use indicatif::ProgressBar;
use softdock_io::address::address;
use softdock_io::input::refuse_overwrite;
use softdock_io::say;
use softdock_io::telemetry::{Listener, Progress, Recorder, Summary};
use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Record every cycle that a board sends, with its settings, until Ctrl-C.
///
/// The board sends to the address in its settings (`network.recorder`), or to that of `softdock
/// board --telemetry`. Start the recorder before the robot: a recording that begins with the
/// board's first cycle can be replayed. If the board boots again in mid-run, its settings change, or
/// a file has its size, the next cycles go into a file of their own: RUN-2.mcap, RUN-3.mcap ..
/// Before the disk is full you are warned twice.
#[derive(Debug, Args)]
#[command(after_help = "Example: softdock record --listen 0.0.0.0:49200 -o run.mcap")]
pub(super) struct Record {
    /// UDP address to listen on for the board
    #[arg(long, value_name = "UDP_ADDR", value_parser = address)]
    listen: SocketAddr,
    /// Recording to write (MCAP)
    #[arg(short, long, value_name = "RUN.mcap", value_parser = mcap_file)]
    output: PathBuf,
    #[command(flatten)]
    pieces: PieceArgs,
    /// Give up if no board is heard for so long, s
    #[arg(long, value_name = "S", default_value_t = 60.0)]
    timeout: f64,
    /// Overwrite an existing recording
    #[arg(long)]
    force: bool,
    /// Print one JSON document
    #[arg(long)]
    json: bool,
}

/// If no datagram comes for so long, the recorder gives up those that are missing: none is delayed by so much.
const GIVE_UP_AFTER: Duration = Duration::from_millis(100);
/// How often the progress is shown.
const SHOW_PERIOD: Duration = Duration::from_millis(250);

impl Record {
    pub(super) fn execute(self) -> Result<()> {
        ensure!(
            self.timeout > 0.0 && self.timeout <= 1e6,
            "--timeout is {} s; expected is more than 0, at most 1000000",
            self.timeout
        );
        let bounds = self.pieces.bounds()?;
        check_output(&self.output, self.force)?;
        let stop = raised_by_ctrl_c()?;
        let listener = Listener::bind(self.listen)?;
        say!("record: listening on UDP {}", listener.address());

        let mut recorder = Recorder::within(&self.output, bounds);
        let recorded = self.record(&listener, &mut recorder, &stop);
        let drained = recorded.and_then(|()| {
            listener
                .close()
                .try_for_each(|(datagram, from)| recorder.accept(&datagram, from))
        });
        for note in recorder.take_notes() {
            say!("record: {note}");
        }
        let progress = recorder.progress();
        let (summary, finished) = recorder.finish();
        if !summary.recordings.is_empty() {
            answer(self.json, &summary, || text(&summary))?;
        }
        drained.and(finished)?;
        verdict(&summary, &progress)
    }

    /// Records until Ctrl-C.
    fn record(
        &self,
        listener: &Listener,
        recorder: &mut Recorder,
        stop: &AtomicBool,
    ) -> Result<()> {
        let began = Instant::now();
        let mut display = Display::new();
        while !stop.load(Ordering::Relaxed) {
            match listener.receive(GIVE_UP_AFTER) {
                Some((datagram, from)) => recorder.accept(&datagram, from)?,
                None => recorder.give_up_missing()?,
            }
            for note in recorder.take_notes() {
                display.say(&note);
            }
            if !display.is_due() {
                continue;
            }
            let progress = recorder.progress();
            if progress.boots == 0 && began.elapsed().as_secs_f64() > self.timeout {
                bail!(nobody(listener.address(), self.timeout, &progress));
            }
            display.show(&progress);
        }
        Ok(())
    }
}

/// Checks that the recording can be written, before the board is waited for.
fn check_output(path: &Path, force: bool) -> Result<()> {
    refuse_overwrite(path, force)?;
    let folder = path
        .parent()
        .filter(|folder| !folder.as_os_str().is_empty());
    let folder = folder.unwrap_or(Path::new("."));
    ensure!(
        folder.is_dir(),
        "{} is not a folder: make it first, or choose another place for the recording",
        folder.display()
    );
    Ok(())
}

fn nobody(address: SocketAddr, timeout_s: f64, progress: &Progress) -> String {
    let others = match progress.foreign {
        (count, Some(from)) => {
            format!(" ({count} datagrams were not a board's; the last one came from {from})")
        }
        _ => String::new(),
    };
    format!(
        "no board was heard on UDP {address} for {timeout_s} s{others}: is the board running, does \
         it send here (`network.recorder` in its settings, or `softdock board --telemetry`), and \
         does the firewall let it through? --timeout waits longer"
    )
}

fn text(summary: &Summary) -> String {
    let lines = summary.recordings.iter().map(|part| format!("{part}\n"));
    let mut text: String = lines.collect();
    let Summary {
        foreign_datagrams: foreign,
        damaged_datagrams: damaged,
        repeated_datagrams: repeated,
        dropped_cycles: dropped,
        ..
    } = summary;
    if *dropped > 0 {
        text += &format!(
            "DROPPED: {dropped} cycles of further boots or settings; too many were heard, and some may be made up.\n"
        );
    }
    if foreign + damaged + repeated > 0 {
        text += &format!(
            "Ignored datagrams: {foreign} not of softdock, {damaged} damaged, {repeated} twice or \
             too late.\n"
        );
    }
    text
}

/// An error if data that came is not in a file together with its settings.
fn verdict(summary: &Summary, progress: &Progress) -> Result<()> {
    if let Some(refused) = summary.refused.first() {
        bail!("{refused}");
    }
    if let Some(part) = summary.recordings.iter().find(|part| !part.settings) {
        bail!(
            "the board's settings never came: the cycles in {} cannot be replayed or compared",
            part.path.display()
        );
    }
    match &progress.identity {
        _ if !summary.recordings.is_empty() => Ok(()),
        Some(identity) => bail!(
            "nothing was written: `{identity}` is there, but it has run no cycle; does the robot \
             send its telegrams to it?"
        ),
        None => bail!("nothing was written: no board was heard"),
    }
}

/// The progress on standard error; nothing where nobody watches.
struct Display {
    bar: ProgressBar,
    shown: Instant,
    /// Time of the last determination of the rate, number of cycles then, and rate in cycles per second.
    rate: (Instant, u64, f64),
}

impl Display {
    fn new() -> Self {
        let now = Instant::now();
        Self {
            bar: spinner(),
            shown: now,
            rate: (now, 0, 0.0),
        }
    }

    fn say(&self, note: &str) {
        self.bar.suspend(|| say!("record: {note}"));
    }

    fn is_due(&mut self) -> bool {
        let due = self.shown.elapsed() >= SHOW_PERIOD;
        if due {
            self.shown = Instant::now();
        }
        due
    }

    fn show(&mut self, progress: &Progress) {
        let (since, cycles, _) = self.rate;
        let elapsed_s = since.elapsed().as_secs_f64();
        if elapsed_s >= 1.0 {
            let rate = progress.cycles.saturating_sub(cycles) as f64 / elapsed_s;
            self.rate = (Instant::now(), progress.cycles, rate);
        }
        self.bar.tick();
        self.bar.set_message(match progress {
            Progress { boots: 0, .. } => "waiting for a board".to_owned(),
            Progress { cycles: 0, .. } => "a board is there; waiting for its robot".to_owned(),
            Progress {
                cycles,
                lost_cycles,
                ..
            } => format!(
                "{cycles} cycles, {:.0} per second, {lost_cycles} lost; Ctrl-C ends the recording",
                self.rate.2
            ),
        });
    }
}

impl Drop for Display {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}
