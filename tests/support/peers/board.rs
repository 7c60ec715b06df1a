//! `softdock board` as a child process on its own ports.

use crate::process::{PATIENCE, Running, scratch, softdock_binary};
use std::net::{Ipv4Addr, SocketAddr};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

use super::{Answer, Robot};

/// A free port of this computer.
const ANY: &str = "127.0.0.1:0";

/// A running board, the folder of its files, and its addresses.
#[derive(Debug)]
pub struct Board {
    /// The process.
    pub process: Running,
    /// Folder with `board.toml` and `run.mcap`.
    pub folder: PathBuf,
    /// The robot's port (UDP).
    pub robot: SocketAddr,
    /// The sensor's port (TCP); port 0 if the board opens an adapter instead.
    pub can: SocketAddr,
    /// The port of the EtherCAT segment (UDP), with `--ethercat`.
    pub ethercat: Option<SocketAddr>,
    /// Address of the service, with `--service`: a TCP address or the path of a pseudo-terminal.
    pub service: Option<String>,
}

impl Board {
    /// Starts a board with `settings` (TOML) on free ports; it records into `run.mcap`.
    ///
    /// # Panics
    /// If the board does not start.
    pub fn start(test: &str, settings: &str, arguments: &[&str]) -> Self {
        Self::start_with_can(test, settings, ANY, arguments)
    }

    /// As [`Self::start`], with the sensor at `can`.
    ///
    /// # Panics
    /// If the board does not start.
    pub fn start_with_can(test: &str, settings: &str, can: &str, arguments: &[&str]) -> Self {
        let folder = scratch(test);
        std::fs::write(folder.join("board.toml"), settings).expect("settings can be written");
        let mut command = Command::new(softdock_binary());
        command
            .current_dir(&folder)
            .args(["board", "--settings", "board.toml", "-o", "run.mcap"]);
        command.args(["--robot", ANY, "--can", can]).args(arguments);
        let mut process = Running::start("board", &mut command);
        // Example: "board: robot on UDP 127.0.0.1:1, SLCAN on TCP 127.0.0.1:2".
        let line = process.wait_for("board: robot on UDP ");
        let mut addresses = line.split([' ', ',']).filter_map(|word| word.parse().ok());
        let Some(robot) = addresses.next() else {
            panic!("expected an address in `{line}`");
        };
        let can = addresses
            .next()
            .unwrap_or(SocketAddr::from((Ipv4Addr::LOCALHOST, 0)));
        let service = line.split_once(", service on ").map(|(_, place)| place);
        let service = service.and_then(|place| place.split(' ').nth(1));
        Self {
            ethercat: segment(&line),
            service: service.map(str::to_owned),
            process,
            folder,
            robot,
            can,
        }
    }

    /// The recording's path.
    pub fn recording(&self) -> PathBuf {
        self.folder.join("run.mcap")
    }

    /// Runs cycles of `robot`, one per ms, until the board prints `text`; returns the last answer.
    ///
    /// # Panics
    /// If the board never does, or a cycle is not answered.
    pub fn cycles_until(&mut self, robot: &mut Robot, text: &str) -> Answer {
        let give_up = Instant::now() + PATIENCE;
        loop {
            let answer = robot.cycle();
            if self.process.heard(text).is_some() {
                return answer;
            }
            assert!(
                Instant::now() < give_up,
                "never `{text}`\n{}",
                self.process.transcript()
            );
            std::thread::sleep(std::time::Duration::from_millis(1));
        }
    }

    /// Ends the board with Ctrl-C; returns the path of its recording, and its output.
    ///
    /// # Panics
    /// If the board ends with an error.
    pub fn stop(self) -> (PathBuf, String) {
        let recording = self.recording();
        self.process.interrupt();
        let (status, log) = self.process.finish();
        assert!(status.success(), "the board ended with {status}\n{log}");
        (recording, log)
    }
}

/// Address of a board's EtherCAT port, from the line that prints it.
pub(super) fn segment(line: &str) -> Option<SocketAddr> {
    let (_, behind) = line.split_once("EtherCAT on UDP ")?;
    behind.split(',').next()?.trim().parse().ok()
}

/// The number before `word` in the board's last line: `5 cycles, 0 lost, ..`.
///
/// # Panics
/// If the board has not printed it.
pub fn counted(log: &str, word: &str) -> u64 {
    let line = log
        .lines()
        .find(|line| line.contains(" cycles, "))
        .expect("the board's last line");
    let words: Vec<&str> = line.split([' ', ',']).filter(|w| !w.is_empty()).collect();
    let at = words
        .iter()
        .position(|w| *w == word)
        .expect("a counter's name");
    words
        .get(at - 1)
        .and_then(|w| w.parse().ok())
        .expect("a counter")
}

/// A path as text for a command line.
///
/// # Panics
/// If it is not UTF-8.
pub fn text(path: &Path) -> &str {
    path.to_str().expect("a path in UTF-8")
}
