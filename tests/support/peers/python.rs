//! Peers in Python: RSIPI's robot controller, a sensor with python-can, EtherCAT MainDevices, readers of tables and of
//! recordings, MuJoCo.

use crate::process::{Running, forbidden, scratch};
use serde::Deserialize;
use softdock_io::data_table::DataTable;
use std::collections::BTreeMap;
use std::ffi::OsString;
use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Environment variable with the Python interpreter that has RSIPI, python-can, pyarrow, MuJoCo, mcap_ros2 and rosbags.
const PYTHON: &str = "SOFTDOCK_PEERS_PYTHON";

/// RSIPI binds a fixed UDP port (50000), so only one robot can run at a time.
static RSIPI_PORT: Mutex<()> = Mutex::new(());

fn python() -> OsString {
    std::env::var_os(PYTHON).unwrap_or_else(|| {
        panic!("{PYTHON} is not set; `tests/run` installs the Python peers and sets it")
    })
}

/// Runs Python text in `folder`; returns its output.
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

/// The command of a Python peer, in `folder`.
///
/// # Panics
/// If the path of Python is not given.
pub fn peer(script: &str, folder: &Path) -> Command {
    let python = python();
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR"))
        .join("peers")
        .join(script);
    let mut command = Command::new(python);
    command.current_dir(folder).arg("-u").arg(path);
    command
}

/// Starts a sensor with python-can's SLCAN client; returns after it has opened the channel.
///
/// # Panics
/// If the sensor does not start.
pub fn sensor(folder: &Path, can: SocketAddr) -> Running {
    let mut command = peer("sensor.py", folder);
    command.args(["--channel", &format!("socket://{can}")]);
    let mut running = Running::start("python-can sensor", &mut command);
    running.wait_for("ready");
    running
}

/// Starts the same sensor behind an SLCAN adapter of this kind (`tcp`, `serial`); returns also the address that opens the
/// adapter.
///
/// # Panics
/// If the adapter does not start.
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

/// What pyarrow reads from a table written as Parquet: `rows`, `types`, `metadata`. Pandas has checked that the values equal
/// those of the CSV.
///
/// # Panics
/// If they cannot read the table, or the values differ.
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

/// Starts an EtherCAT MainDevice in Python with its cable; returns also the address for the segment. None if this machine
/// does not allow such a cable.
///
/// # Panics
/// If it does not start.
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

/// Result of a docking in MuJoCo.
#[derive(Debug, Deserialize)]
pub struct Docked {
    /// Time of the first contact, s.
    pub touched: f64,
    /// Time at which the mechanism separated, s.
    pub parted: f64,
    /// Velocity of the moving spacecraft at the end, if both moved freely: linear and angular.
    #[serde(default)]
    pub k: Vec<f64>,
}

/// Docks in MuJoCo: as the robot and sensor of a board, or with two free spacecraft.
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

/// Results of RSIPI's checks.
#[derive(Debug, Deserialize)]
pub struct Verdict {
    /// Accepted answers: time stamp, and RKorr as text.
    pub accepted: Vec<(u64, BTreeMap<String, String>)>,
    /// Reasons for rejected answers.
    pub rejected: Vec<String>,
    /// Cycles without an answer in time.
    pub late: u64,
    /// RIst at the start, mm and degrees.
    pub start: BTreeMap<String, f64>,
    /// RIst at the end.
    pub end: BTreeMap<String, f64>,
}

impl RsipiRobot {
    /// Starts RSIPI with an Ethernet configuration, for `cycles` answered cycles.
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

    /// Waits for the last cycle and returns the results.
    ///
    /// # Panics
    /// If RSIPI fails, or does not print its results.
    pub fn verdict(mut self) -> Verdict {
        let line = self.process.wait_for("{\"accepted\"");
        let (status, log) = self.process.finish();
        assert!(status.success(), "RSIPI ended with {status}\n{log}");
        serde_json::from_str(&line).expect("RSIPI's verdict")
    }
}
