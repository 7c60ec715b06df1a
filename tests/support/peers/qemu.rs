//! `softdock qemu` as a child process on ports of its own.

use super::board::segment;
use crate::process::{PATIENCE, Running, scratch, softdock_binary};
use std::io::{BufRead, BufReader, Write};
use std::net::{Ipv4Addr, SocketAddr, TcpStream};
use std::path::PathBuf;
use std::process::Command;
use std::time::Instant;

/// A running board in QEMU, the folder of its files, and where it listens.
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
    /// If it does not come up.
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
        // board: robot on UDP 127.0.0.1:1, SLCAN on TCP 127.0.0.1:2, service on TCP 127.0.0.1:3
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

    /// Does `step` again and again until the board says `text`; that line.
    ///
    /// # Panics
    /// If it never does.
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

    /// Ends it with Ctrl-C: what it said.
    ///
    /// # Panics
    /// If it does not end well, or the board started over in between.
    pub fn stop(self) -> String {
        let log = self.end();
        let boots = log.lines().filter(|line| line.ends_with(" ready")).count();
        assert_eq!(boots, 1, "the board started over\n{log}");
        log
    }

    /// Likewise if it may have started over.
    ///
    /// # Panics
    /// If it does not end well.
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
        // A failed test must not leave QEMU behind where nothing ends it with its launcher.
        if let Some(process) = self.process.take() {
            process.interrupt();
            process.finish_or_kill();
        }
    }
}

/// The cable of a board's network, by QEMU's machine protocol.
#[derive(Debug)]
pub struct Cable(BufReader<TcpStream>);

impl Cable {
    /// That of a board with `--monitor` on this address.
    ///
    /// # Panics
    /// If QEMU is not there.
    pub fn of(monitor: SocketAddr) -> Self {
        let stream = TcpStream::connect(monitor).expect("QEMU listens");
        stream
            .set_read_timeout(Some(PATIENCE))
            .expect("a timeout can be set");
        let mut cable = Self(BufReader::new(stream));
        cable.order(&serde_json::json!({ "execute": "qmp_capabilities" }));
        cable
    }

    /// Plugs it in, or pulls it.
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
            // Beside answers it tells what happens.
            if line.contains("\"return\"") {
                return;
            }
        }
    }
}
