//! `softdock qemu` as a child process on its own ports.

use super::board::segment;
use crate::process::{PATIENCE, Running, scratch, softdock_binary};
use std::io::{BufRead, BufReader, Write};
use std::net::{Ipv4Addr, SocketAddr, TcpStream};
use std::path::PathBuf;
use std::process::Command;
use std::time::Instant;

/// A running board in QEMU, the folder of its files, and its addresses.
#[derive(Debug)]
pub struct QemuBoard {
    process: Option<Running>,
    /// Folder with `board.toml`.
    pub folder: PathBuf,
    /// The robot's port (UDP).
    pub robot: SocketAddr,
    /// The sensor's port (TCP).
    pub can: SocketAddr,
    /// The port of the service (TCP).
    pub service: SocketAddr,
    /// The port of the EtherCAT segment (UDP), with `--ethercat`.
    pub ethercat: Option<SocketAddr>,
}

impl QemuBoard {
    /// Starts a board with `settings` (TOML) on free ports.
    ///
    /// # Panics
    /// If the board does not start.
    pub fn start(test: &str, settings: &str, arguments: &[&str]) -> Self {
        let folder = scratch(test);
        std::fs::write(folder.join("board.toml"), settings).expect("settings can be written");
        let any = SocketAddr::from((Ipv4Addr::LOCALHOST, 0)).to_string();
        let mut command = Command::new(softdock_binary());
        command
            .current_dir(&folder)
            .args(["qemu", "--settings", "board.toml"])
            .args(["--robot", &any, "--can", &any, "--service", &any])
            .args(arguments);
        let mut process = Running::start("QEMU board", &mut command);
        // Example: "board: robot on UDP 127.0.0.1:1, SLCAN on TCP 127.0.0.1:2, service on TCP 127.0.0.1:3".
        let line = process.wait_for("board: robot on UDP ");
        let mut addresses = line.split([' ', ',']).filter_map(|word| word.parse().ok());
        let mut address = || {
            addresses
                .next()
                .unwrap_or_else(|| panic!("expected three addresses in `{line}`"))
        };
        Self {
            folder,
            robot: address(),
            can: address(),
            service: address(),
            ethercat: segment(&line),
            process: Some(process),
        }
    }

    /// The launcher, which prints the board's log.
    ///
    /// # Panics
    /// Never: it is there until [`Self::stop`].
    pub fn process(&mut self) -> &mut Running {
        self.process.as_mut().expect("a board that was not stopped")
    }

    /// Repeats `step` until the board prints `text`; returns that line.
    ///
    /// # Panics
    /// If the board never does.
    pub fn until(&mut self, text: &str, mut step: impl FnMut()) -> String {
        let give_up = Instant::now() + PATIENCE;
        loop {
            if let Some(line) = self.process().heard(text) {
                return line;
            }
            let transcript = self.process().transcript();
            assert!(Instant::now() < give_up, "never `{text}`\n{transcript}");
            step();
        }
    }

    /// Ends the board with Ctrl-C; returns its output.
    ///
    /// # Panics
    /// If the board ends with an error, or restarted before.
    pub fn stop(self) -> String {
        let log = self.end();
        let boots = log.lines().filter(|line| line.ends_with(" ready")).count();
        assert_eq!(boots, 1, "the board started over\n{log}");
        log
    }

    /// As [`Self::stop`], but the board may have restarted.
    ///
    /// # Panics
    /// If the board ends with an error.
    pub fn end(mut self) -> String {
        let process = self.process.take().expect("a board is stopped once");
        process.interrupt();
        let (status, log) = process.finish();
        assert!(
            status.success(),
            "QEMU's launcher ended with {status}\n{log}"
        );
        log
    }
}

impl Drop for QemuBoard {
    fn drop(&mut self) {
        // A failed test must not leave QEMU running on systems where it does not end with its launcher.
        if let Some(process) = self.process.take() {
            process.interrupt();
            process.finish_or_kill();
        }
    }
}

/// The network cable of a board, controlled with QEMU's machine protocol.
#[derive(Debug)]
pub struct Cable(BufReader<TcpStream>);

impl Cable {
    /// The cable of a board with `--monitor` at this address.
    ///
    /// # Panics
    /// If QEMU does not listen.
    pub fn of(monitor: SocketAddr) -> Self {
        let stream = TcpStream::connect(monitor).expect("QEMU listens");
        stream
            .set_read_timeout(Some(PATIENCE))
            .expect("a timeout can be set");
        let mut cable = Self(BufReader::new(stream));
        cable.order(&serde_json::json!({ "execute": "qmp_capabilities" }));
        cable
    }

    /// Plugs the cable in, or unplugs it.
    ///
    /// # Panics
    /// If QEMU refuses.
    pub fn plug(&mut self, plugged: bool) {
        let arguments = serde_json::json!({ "name": "lan9118.0", "up": plugged });
        self.order(&serde_json::json!({ "execute": "set_link", "arguments": arguments }));
    }

    fn order(&mut self, order: &serde_json::Value) {
        writeln!(self.0.get_mut(), "{order}").expect("QEMU takes orders");
        loop {
            let mut line = String::new();
            let length = self.0.read_line(&mut line).expect("QEMU answers");
            assert!(
                length > 0 && !line.contains("\"error\""),
                "{order}: `{line}`"
            );
            // Besides answers, QEMU also sends events.
            if line.contains("\"return\"") {
                return;
            }
        }
    }
}
