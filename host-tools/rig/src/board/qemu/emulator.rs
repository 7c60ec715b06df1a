//! QEMU as a child process.

use super::chip::Chip;
use super::flash::BOARD;
use super::ports::Ports;
use super::segment::Relay;
use anyhow::{Context, Result, ensure};
use softdock_app::emulated_flash::FLASH_BYTES;
use std::ffi::{OsStr, OsString};
use std::io::ErrorKind;
use std::net::SocketAddr;
use std::path::Path;
use std::process::{Child, ChildStdout, Command, ExitStatus, Stdio};

const PROGRAM: &str = "qemu-system-arm";

/// Checks that QEMU is installed.
///
/// # Errors
/// It is not.
pub(super) fn find() -> Result<()> {
    let version = Command::new(PROGRAM)
        .arg("--version")
        .stdin(Stdio::null())
        .output();
    let output = match version {
        Err(error) if error.kind() == ErrorKind::NotFound => {
            anyhow::bail!(
                "{PROGRAM} is missing; on Debian and Ubuntu: apt-get install qemu-system-arm"
            )
        }
        other => other.with_context(|| format!("cannot run {PROGRAM}"))?,
    };
    ensure!(
        output.status.success(),
        "{PROGRAM} --version fails ({}); install it anew, on Debian and Ubuntu: apt-get install --reinstall qemu-system-arm",
        output.status
    );
    Ok(())
}

/// Addresses at which the board is connected.
pub(super) struct Wires<'a> {
    pub(super) ports: &'a Ports,
    /// The way to the EtherCAT segment, if the sensor is on one.
    pub(super) relay: Option<&'a Relay>,
    /// The firmware's UDP port for the robot.
    pub(super) rsi_port: u16,
    /// For QEMU's machine protocol.
    pub(super) monitor: Option<SocketAddr>,
}

/// A running QEMU. It is ended when this value is dropped.
#[derive(Debug)]
pub(super) struct Emulator {
    child: Child,
}

impl Emulator {
    /// Starts the firmware `elf` with `flash` as emulated flash.
    ///
    /// # Errors
    /// QEMU cannot be started.
    pub(super) fn start(chip: Chip, elf: &Path, flash: &Path, wires: &Wires<'_>) -> Result<Self> {
        let mut command = bound_to_this_process();
        command.args(["-nodefaults", "-display", "none", "-monitor", "none"]);
        // The board's PSRAM is the file.
        let machine = format!("{},memory-backend=psram", chip.machine());
        let mut memory = OsString::from(format!(
            "memory-backend-file,id=psram,size={FLASH_BYTES},share=on,mem-path="
        ));
        memory.push(escaped(flash));
        command.arg("-machine").arg(machine);
        command.arg("-object").arg(memory);
        command.arg("-kernel").arg(elf);
        // UART 0 is the sensor's line, 1 the log, 2 the service.
        let line = |port: Option<SocketAddr>| port.map_or_else(|| "null".to_owned(), tcp);
        command.args(["-serial", &line(wires.ports.can)]);
        command.args(["-serial", "stdio"]);
        command.args(["-serial", &line(wires.ports.service)]);
        if let Some(monitor) = wires.monitor {
            command.args(["-qmp", &tcp(monitor)]);
        }
        command.args(network(wires));
        let child = command
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .spawn()
            .with_context(|| format!("cannot start {PROGRAM}"))?;
        Ok(Self { child })
    }

    /// The firmware's log, as it comes out of the board.
    ///
    /// # Errors
    /// It was taken already.
    pub(super) fn log(&mut self) -> Result<ChildStdout> {
        self.child.stdout.take().context("the log was taken twice")
    }

    /// How QEMU ended, if it has.
    ///
    /// # Errors
    /// The system does not tell.
    pub(super) fn exit_status(&mut self) -> Result<Option<ExitStatus>> {
        self.child.try_wait().context("cannot look after QEMU")
    }
}

impl Drop for Emulator {
    fn drop(&mut self) {
        // QEMU holds nothing that it would have to save. An error says that it has ended already.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// Network options: the robot's network, and with EtherCAT a hub to the segment's relay.
fn network(wires: &Wires<'_>) -> Vec<String> {
    let Wires {
        ports,
        relay,
        rsi_port,
        ..
    } = wires;
    let robot = format!(
        "hostfwd=udp:{}:{}-{BOARD}:{rsi_port}",
        ports.robot.ip(),
        ports.robot.port()
    );
    let Some(relay) = relay else {
        return vec!["-nic".into(), format!("user,model=lan9118,{robot}")];
    };
    let address = |side: &str, address: SocketAddr| {
        let (host, port) = (address.ip(), address.port());
        format!("{side}.type=inet,{side}.host={host},{side}.port={port}")
    };
    let (local, remote) = (
        address("local", relay.board),
        address("remote", relay.segment),
    );
    let netdevs = [
        format!("user,id=robot,{robot}"),
        format!("dgram,id=segment,{local},{remote}"),
        "hubport,id=robot-port,hubid=0,netdev=robot".into(),
        "hubport,id=segment-port,hubid=0,netdev=segment".into(),
        "hubport,id=board-port,hubid=0".into(),
    ];
    let netdevs = netdevs
        .into_iter()
        .flat_map(|netdev| ["-netdev".into(), netdev]);
    let board = ["-net".into(), "nic,model=lan9118,netdev=board-port".into()];
    netdevs.chain(board).collect()
}

fn tcp(address: SocketAddr) -> String {
    format!("tcp:{address},server=on,wait=off,nodelay=on")
}

/// In QEMU's options a comma inside of a value is written twice.
fn escaped(path: &Path) -> OsString {
    match path.to_str() {
        Some(path) => path.replace(',', ",,").into(),
        None => path.into(),
    }
}

/// QEMU, so that it ends when this process does, even if that is killed; and in a process group of
/// its own, so that Ctrl-C in a terminal reaches this process alone.
fn bound_to_this_process() -> Command {
    const BINDER: &str = "setpriv";
    let found = |folders: OsString| {
        std::env::split_paths(&folders).any(|folder| folder.join(BINDER).is_file())
    };
    let binder = cfg!(target_os = "linux") && std::env::var_os("PATH").is_some_and(found);
    let mut command = match binder {
        true => {
            let mut command = Command::new(BINDER);
            command.args(["--pdeathsig", "KILL", "--"].map(OsStr::new));
            command.arg(PROGRAM);
            command
        }
        false => Command::new(PROGRAM),
    };
    #[cfg(unix)]
    std::os::unix::process::CommandExt::process_group(&mut command, 0);
    command
}
