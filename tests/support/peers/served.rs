//! `softdock board` with a service, and `softdock params` on it.

use super::{Board, QemuBoard};
use crate::process::{Finished, softdock};
use std::net::SocketAddr;
use std::path::{Path, PathBuf};

/// Where the service of a board is, from what it said at its start.
#[derive(Debug)]
pub struct Served<B = Board> {
    /// The board.
    pub board: B,
    /// Folder of its files.
    pub folder: PathBuf,
    /// What `--port` takes.
    pub port: String,
}

/// Starts a board with `settings` (TOML) and a service on a free TCP port.
///
/// # Panics
/// If it does not come up.
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

/// Likewise in QEMU.
///
/// # Panics
/// If it does not come up.
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
    /// If it is none.
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

    /// What it prints.
    ///
    /// # Panics
    /// If it fails.
    pub fn done(&self, arguments: &[&str]) -> String {
        self.params(arguments).succeeded().stdout
    }

    /// Why it fails.
    ///
    /// # Panics
    /// If it does not.
    pub fn refused(&self, arguments: &[&str]) -> String {
        let run = self.params(arguments);
        assert_eq!(run.code, Some(1), "{arguments:?}: {}", run.stdout);
        run.stderr
    }

    /// Until the board hears its robot.
    ///
    /// # Panics
    /// If it never does.
    pub fn hears_its_robot(&self) {
        /// Questions; each takes some milliseconds.
        const MOST: usize = 500;
        let hears = |_| self.json(&["status"])["status"]["robot"] == true;
        assert!((0..MOST).any(hears), "no telegram has arrived");
    }

    /// What it prints with `--json`.
    ///
    /// # Panics
    /// If it fails, or that is no JSON.
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
