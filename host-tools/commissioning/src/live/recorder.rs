//! Records what a board sends, while something else is done with it.

use anyhow::{Context, Result, bail, ensure};
use softdock_app::record::CycleRecord;
use softdock_io::recording::Recording;
use softdock_io::telemetry::{Listener, Recorder, Summary};
use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Longest time from one cycle of the board to the next.
const TIMEOUT: Duration = Duration::from_secs(5);
/// Longest wait for a datagram: nothing that is missing comes later.
const REST: Duration = Duration::from_millis(20);

/// A recorder that listens.
pub struct LiveRecorder {
    listener: Listener,
    recorder: Recorder,
    cycles: u64,
    /// When the last cycle came.
    heard: Instant,
    /// Temporary folder of the recording, deleted with this value; None if the recording is kept.
    folder: Option<tempfile::TempDir>,
}

impl LiveRecorder {
    /// Listens on `address` and records into `keep`, or into a file that goes away.
    ///
    /// # Errors
    /// The address is taken, by another recorder perhaps.
    pub fn open(address: SocketAddr, keep: Option<&Path>) -> Result<Self> {
        let (path, folder): (PathBuf, _) = match keep {
            Some(path) => (path.to_path_buf(), None),
            None => {
                let folder = tempfile::tempdir().context("no room for a recording")?;
                (folder.path().join("live.mcap"), Some(folder))
            }
        };
        Ok(Self {
            listener: Listener::bind(address)?,
            recorder: Recorder::new(&path),
            cycles: 0,
            heard: Instant::now(),
            folder,
        })
    }

    /// Takes what has come, and waits a little if nothing has. `see` is shown every new cycle.
    ///
    /// # Errors
    /// The file cannot be written, the board speaks another version, or no cycle has come for long.
    pub fn listen(&mut self, mut see: impl FnMut(&CycleRecord)) -> Result<()> {
        let until = Instant::now() + REST;
        loop {
            match self.listener.receive(until.duration_since(Instant::now())) {
                Some((datagram, from)) => self.recorder.accept(&datagram, from)?,
                None => self.recorder.give_up_missing()?,
            }
            let cycles = self.recorder.progress().cycles;
            if cycles != self.cycles {
                (self.cycles, self.heard) = (cycles, Instant::now());
                self.recorder.newest().into_iter().for_each(&mut see);
            }
            if Instant::now() >= until {
                break;
            }
        }
        ensure!(
            self.heard.elapsed() < TIMEOUT,
            "no cycle of the board came to UDP {} for {} s: does it send there (`network.recorder` of its \
             settings, or `softdock board --telemetry`), does the robot send its telegrams, does the \
             firewall let it through?",
            self.listener.address(),
            TIMEOUT.as_secs()
        );
        Ok(())
    }

    /// Cycles that were recorded.
    pub fn cycles(&self) -> u64 {
        self.cycles
    }

    /// Ends the recording, and reads it. The notes say what a person should know.
    ///
    /// # Errors
    /// It cannot be written or read, the board's settings never came, or it started over.
    pub fn finish(self) -> Result<(Recording, Vec<String>)> {
        // The file is read before its folder goes.
        let (summary, _folder) = self.finish_all()?;
        let [part] = summary.recordings.as_slice() else {
            bail!(
                "the board started over, or a second one sends to this address: {} recordings came of it",
                summary.recordings.len()
            );
        };
        ensure!(
            part.settings,
            "the board's settings never came, without which its cycles mean nothing: try again"
        );
        let mut notes = Vec::new();
        if part.lost_cycles > 0 {
            notes.push(format!(
                "{} of {} cycles were lost on the network; of the rest, the longest stretch counts",
                part.lost_cycles,
                part.lost_cycles + part.cycles
            ));
        }
        Ok((Recording::open(&part.path)?, notes))
    }

    /// Ends the recording of a measurement that was broken off. Returns a sentence on what is kept of it.
    pub fn interrupted(self) -> String {
        if self.folder.is_some() {
            return "no recording is kept (--keep names a file for one)".to_owned();
        }
        match self.finish_all() {
            Ok((summary, _)) if summary.recordings.is_empty() => {
                "no cycle was recorded: no file is kept".to_owned()
            }
            Ok((summary, _)) => {
                let files = summary.recordings.iter().map(ToString::to_string);
                format!("kept so far: {}", files.collect::<Vec<_>>().join("; "))
            }
            Err(error) => format!("the recording may lack its end: {error:#}"),
        }
    }

    /// Writes what has come, and ends every file. They go away with the folder, if there is one.
    fn finish_all(mut self) -> Result<(Summary, Option<tempfile::TempDir>)> {
        let mut drained = self.listener.close();
        let came = drained.try_for_each(|(datagram, from)| self.recorder.accept(&datagram, from));
        let came = came.and_then(|()| self.recorder.give_up_missing());
        let (summary, finished) = self.recorder.finish();
        came.and(finished)?;
        Ok((summary, self.folder))
    }
}
