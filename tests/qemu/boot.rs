//! How the firmware in QEMU starts, and what its launcher says when it cannot.

use softdock_tests::peers::QemuBoard;
use softdock_tests::process::{scratch, softdock_binary};
use std::net::{TcpListener, UdpSocket};
use std::path::Path;
use std::process::Command;

/// What the board says from its first line until it waits for its sensor.
const BOOT: &str = "\
<time> info  softdock <version> (<git>) on QEMU mps2-an500, Cortex-M7, f64
<time> info  reset by: unknown
<time> info  settings 1 from flash
<time> info  address 10.0.2.15/24, robot on UDP port 49200, from 10.0.2.2
<time> info  ready
robot on UDP <address>, SLCAN on TCP <address>, service on TCP <address>
<time> info  sensor Starting";

/// A line without what differs from build to build and from run to run.
fn masked(line: &str) -> String {
    let line = line.trim_start_matches("board:").trim();
    let mut words: Vec<String> = line.split(' ').map(str::to_owned).collect();
    for word in &mut words {
        let bare = word.trim_end_matches(',');
        if bare.parse::<f64>().is_ok() && bare.contains('.') {
            "<time>".clone_into(word);
        } else if bare.parse::<std::net::SocketAddr>().is_ok() {
            *word = word.replace(bare, "<address>");
        }
    }
    let line = words
        .join(" ")
        .replace(env!("CARGO_PKG_VERSION"), "<version>");
    match (line.find('('), line.find(')')) {
        (Some(from), Some(to)) => format!("{}(<git>){}", &line[..from], &line[to + 1..]),
        _ => line,
    }
}

#[test]
fn the_boot_log_says_who_it_is_with_which_settings() {
    let settings = "[rsi]\nrobot_ip = \"127.0.0.1\"\n[network]\nrsi_port = 49200\n";
    let mut board = QemuBoard::start("qemu_boot", settings, &[]);
    board.process().wait_for("sensor Starting");
    let log = board.stop();
    let boot: Vec<String> = log
        .lines()
        .filter(|line| line.starts_with("board: "))
        .take(BOOT.lines().count())
        .map(masked)
        .collect();
    assert_eq!(boot.join("\n"), BOOT, "{log}");
}

/// `softdock qemu` on ports that are free unless `arguments` say otherwise; it is to fail at once.
fn launch(folder: &Path, arguments: &[&str], path: Option<&str>) -> String {
    let any = "127.0.0.1:0";
    let mut command = Command::new(softdock_binary());
    command.current_dir(folder).arg("qemu");
    for (name, free) in [("--robot", any), ("--can", any), ("--service", any)] {
        if !arguments.contains(&name) {
            command.args([name, free]);
        }
    }
    if !arguments.contains(&"--settings") {
        std::fs::write(folder.join("board.toml"), "").unwrap();
        command.args(["--settings", "board.toml"]);
    }
    if let Some(path) = path {
        command.env("PATH", path);
    }
    let output = command.args(arguments).output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(!said.contains("panicked"), "{said}");
    said
}

#[test]
fn a_port_in_use_is_named_before_anything_is_built() {
    let folder = scratch("qemu_ports");
    let udp = UdpSocket::bind("127.0.0.1:0").unwrap();
    let tcp = TcpListener::bind("127.0.0.1:0").unwrap();
    let robot = udp.local_addr().unwrap().to_string();
    let line = tcp.local_addr().unwrap().to_string();
    for (option, address, what) in [
        ("--robot", &robot, "robot (UDP)"),
        ("--can", &line, "sensor (TCP)"),
        ("--service", &line, "service (TCP)"),
    ] {
        let said = launch(&folder, &[option, address], None);
        assert!(said.contains(&format!("{what} on {address}")), "{said}");
        assert!(said.contains("is another board running"), "{said}");
        assert!(!said.contains("cargo build"), "{said}");
    }
}

#[test]
fn a_missing_qemu_is_named_with_its_package() {
    let folder = scratch("qemu_missing");
    let empty = folder.join("no-programs-here");
    let said = launch(&folder, &[], empty.to_str());
    assert!(said.contains("qemu-system-arm is missing"), "{said}");
    assert!(said.contains("apt-get install qemu-system-arm"), "{said}");
}

#[test]
fn settings_that_may_not_be_used_are_named() {
    let folder = scratch("qemu_settings");
    let file = folder.join("bad.toml");
    std::fs::write(&file, "[network]\naddress = \"nowhere\"\n").unwrap();
    let said = launch(&folder, &["--settings", "bad.toml"], None);
    assert!(
        said.contains("bad.toml") && said.contains("network.address"),
        "{said}"
    );
}
