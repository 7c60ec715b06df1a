//! `softdock board` with a service, and `softdock params` connected to it.

use super::{Board, QemuBoard};
use crate::process::{Finished, softdock};
use std::net::SocketAddr;
use std::path::{Path, PathBuf};

/// A board and the address of its service, from its output at the start.
#[derive(Debug)]
pub struct Served<B = Board> {
    /// The board.
    pub board: B,
    /// Folder of its files.
    pub folder: PathBuf,
    /// Value for `--port`.
    pub port: String,
}

/// Starts a board with `settings` (TOML) and a service on a free TCP port.
///
/// # Panics
/// If the board does not start.
pub fn serve(test: &str, settings: &str, arguments: &[&str]) -> Served {
    let arguments = [&["--service", "127.0.0.1:0"], arguments].concat();
    let board = Board::start(test, settings, &arguments);
    let port = format!("tcp:{}", board.service.as_deref().expect("a service"));
    Served {
        folder: board.folder.clone(),
        board,
        port,
    }
}

/// As [`serve()`], in QEMU.
///
/// # Panics
/// If the board does not start.
pub fn serve_emulated(test: &str, settings: &str, arguments: &[&str]) -> Served<QemuBoard> {
    let board = QemuBoard::start(test, settings, arguments);
    Served {
        folder: board.folder.clone(),
        port: format!("tcp:{}", board.service),
        board,
    }
}

impl<B> Served<B> {
    /// The TCP address of its service.
    ///
    /// # Panics
    /// If the port is not TCP.
    pub fn address(&self) -> SocketAddr {
        self.port
            .trim_start_matches("tcp:")
            .parse()
            .expect("an address")
    }

    /// Runs `softdock params`.
    pub fn params(&self, arguments: &[&str]) -> Finished {
        params(&self.folder, &self.port, arguments)
    }

    /// Runs `softdock params`; returns its output.
    ///
    /// # Panics
    /// If the command fails.
    pub fn done(&self, arguments: &[&str]) -> String {
        self.params(arguments).succeeded().stdout
    }

    /// Runs `softdock params`, which must fail; returns its error.
    ///
    /// # Panics
    /// If the command succeeds.
    pub fn refused(&self, arguments: &[&str]) -> String {
        let run = self.params(arguments);
        assert_eq!(run.code, Some(1), "{arguments:?}: {}", run.stdout);
        run.stderr
    }

    /// Waits until the board receives telegrams of its robot.
    ///
    /// # Panics
    /// If that never happens.
    pub fn hears_its_robot(&self) {
        /// Largest number of requests; each takes some milliseconds.
        const MOST: usize = 500;
        let hears = |_| self.json(&["status"])["status"]["robot"] == true;
        assert!((0..MOST).any(hears), "no telegram has arrived");
    }

    /// Runs `softdock params` with `--json`; returns its output.
    ///
    /// # Panics
    /// If the command fails, or the output is not JSON.
    pub fn json(&self, arguments: &[&str]) -> serde_json::Value {
        let run = self.params(&[arguments, &["--json"]].concat());
        run.succeeded().json()
    }
}

/// Runs `softdock params` on a port.
pub fn params(folder: &Path, port: &str, arguments: &[&str]) -> Finished {
    softdock(
        folder,
        &[&["params"], arguments, &["--port", port]].concat(),
    )
}
