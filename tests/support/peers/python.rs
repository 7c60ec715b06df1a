//! The peers in Python: RSIPI's robot controller, a sensor on python-can, MainDevices of EtherCAT, readers of tables
//! and of recordings, MuJoCo.

use crate::process::{Running, forbidden, scratch};
use serde::Deserialize;
use softdock_io::data_table::DataTable;
use std::collections::BTreeMap;
use std::ffi::OsString;
use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Names the Python interpreter that has RSIPI, python-can, pyarrow, MuJoCo, mcap_ros2 and rosbags.
const PYTHON: &str = "SOFTDOCK_PEERS_PYTHON";

/// RSIPI binds a fixed UDP port (50000), so one robot runs at a time.
static RSIPI_PORT: Mutex<()> = Mutex::new(());

fn python() -> OsString {
    std::env::var_os(PYTHON).unwrap_or_else(|| {
        panic!("{PYTHON} is not set; `tests/run` installs the Python peers and sets it")
    })
}

/// Runs Python text in `folder`: what it says.
///
/// # Panics
/// If it fails.
pub fn run(folder: &Path, text: &str) -> String {
    let script = folder.join("script.py");
    std::fs::write(&script, text).expect("a script can be written");
    let mut command = Command::new(python());
    let process = Running::start("python", command.current_dir(folder).arg(&script));
    let (status, log) = process.finish();
    assert!(status.success(), "{log}");
    log
}

/// A Python peer, in `folder`.
///
/// # Panics
/// If nobody says where Python is.
pub fn peer(script: &str, folder: &Path) -> Command {
    let python = python();
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR"))
        .join("peers")
        .join(script);
    let mut command = Command::new(python);
    command.current_dir(folder).arg("-u").arg(path);
    command
}

/// A sensor on python-can's SLCAN client, once it has opened the channel.
///
/// # Panics
/// If it does not come up.
pub fn sensor(folder: &Path, can: SocketAddr) -> Running {
    let mut command = peer("sensor.py", folder);
    command.args(["--channel", &format!("socket://{can}")]);
    let mut running = Running::start("python-can sensor", &mut command);
    running.wait_for("ready");
    running
}

/// The same sensor behind an SLCAN adapter of that kind (`tcp`, `serial`), and what opens the adapter.
///
/// # Panics
/// If it does not come up.
pub fn adapter(folder: &Path, kind: &str) -> (Running, String) {
    let mut command = peer("sensor.py", folder);
    command.args(["--adapter", kind]);
    let mut running = Running::start("SLCAN adapter", &mut command);
    let line = running.wait_for("adapter ");
    let place = line
        .split_once("adapter ")
        .map(|(_, place)| place.to_owned());
    (running, place.unwrap_or_else(|| panic!("no place: {line}")))
}

/// What pyarrow finds in a table that was written as Parquet: `rows`, `types`, `metadata`. Pandas has found the same
/// values in it as in the CSV.
///
/// # Panics
/// If they cannot read it, or disagree.
pub fn read_table(table: &DataTable) -> serde_json::Value {
    let folder = scratch("read_table");
    let files = ["table.parquet", "table.csv"].map(|name| folder.join(name));
    for file in &files {
        table.write(file).expect("a table that can be written");
    }
    let mut reader = Running::start("pyarrow", peer("read_table.py", &folder).args(&files));
    let found = reader.wait_for("{\"rows\"");
    let (status, log) = reader.finish();
    assert!(status.success(), "pyarrow ended with {status}\n{log}");
    serde_json::from_str(&found).expect("JSON")
}

/// An EtherCAT MainDevice in Python with its cable, and where the segment is to be plugged in; none if this machine
/// does not allow such a cable.
///
/// # Panics
/// If it does not come up.
pub fn on_cable(script: &str) -> Option<(Running, SocketAddr)> {
    let mut running = Running::start(script, &mut peer(script, &scratch(script)));
    let line = running.wait_for("");
    if let Some(what) = line.split_once("FORBIDDEN ").map(|(_, what)| what) {
        forbidden(what);
        running.finish_or_kill();
        return None;
    }
    let cable = line
        .split_once("cable ")
        .and_then(|(_, at)| at.parse().ok());
    Some((running, cable.unwrap_or_else(|| panic!("no cable: {line}"))))
}

/// What became of a docking in MuJoCo.
#[derive(Debug, Deserialize)]
pub struct Docked {
    /// Time of the first touch, s.
    pub touched: f64,
    /// Time at which the mechanism let go, s.
    pub parted: f64,
    /// Velocity of the moving spacecraft at the end, if both flew freely: linear and angular.
    #[serde(default)]
    pub k: Vec<f64>,
}

/// Docks in MuJoCo: as the robot and sensor of a board, or both spacecraft by themselves.
///
/// # Panics
/// If it fails.
pub fn mujoco(
    folder: &Path,
    scene: &serde_json::Value,
    board: Option<(SocketAddr, SocketAddr)>,
) -> Docked {
    let mut command = peer("mujoco_plant.py", folder);
    if let Some((robot, can)) = board {
        command.args(["--robot", &robot.to_string()]);
        command.args(["--can", &format!("socket://{can}")]);
    }
    let mut running = Running::start("MuJoCo", &mut command);
    running.say(&scene.to_string());
    let line = running.wait_for("{\"touched\"");
    let (status, log) = running.finish();
    assert!(status.success(), "MuJoCo ended with {status}\n{log}");
    serde_json::from_str(&line).expect("MuJoCo's document")
}

/// RSIPI's robot controller.
#[derive(Debug)]
pub struct RsipiRobot {
    /// The process.
    pub process: Running,
    _port: MutexGuard<'static, ()>,
}

/// What RSIPI decided.
#[derive(Debug, Deserialize)]
pub struct Verdict {
    /// Accepted answers: time stamp, and RKorr as text.
    pub accepted: Vec<(u64, BTreeMap<String, String>)>,
    /// Reasons of answers that were wrong.
    pub rejected: Vec<String>,
    /// Cycles without an answer in time.
    pub late: u64,
    /// RIst at the start, mm and degrees.
    pub start: BTreeMap<String, f64>,
    /// RIst at the end.
    pub end: BTreeMap<String, f64>,
}

impl RsipiRobot {
    /// Starts it with an Ethernet configuration for so many answered cycles.
    ///
    /// # Panics
    /// If Python cannot be started.
    pub fn start(folder: &Path, config: &str, cycles: usize) -> Self {
        let port = RSIPI_PORT.lock().unwrap_or_else(PoisonError::into_inner);
        let mut command = peer("rsipi_robot.py", folder);
        command.args(["--config", config, "--mode", "relative", "--delay", "4"]);
        command.args(["--cycles", &cycles.to_string()]);
        Self {
            process: Running::start("RSIPI", &mut command),
            _port: port,
        }
    }

    /// Waits for its last cycle.
    ///
    /// # Panics
    /// If it fails, or does not say what it found.
    pub fn verdict(mut self) -> Verdict {
        let line = self.process.wait_for("{\"accepted\"");
        let (status, log) = self.process.finish();
        assert!(status.success(), "RSIPI ended with {status}\n{log}");
        serde_json::from_str(&line).expect("RSIPI's verdict")
    }
}
