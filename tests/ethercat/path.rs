//! The closed loop over EtherCAT behind real sockets, with the rig in lock step: on the host and in QEMU.

use softdock_app::settings::BoardSettings;
use softdock_control::delay::LawName;
use softdock_experiments::impacts;
use softdock_experiments::run::record;
use softdock_experiments::scenario::Scenario;
use softdock_tests::peers::{Board, LockStepRig, Motion, QemuBoard, patient, without_noise};
use toml_edit::ser::to_string_pretty;

const ANY: &str = "127.0.0.1:0";
/// The spacecraft flies with 5 mm/s, touches after 1 s, is turned around and flies back: 2 s.
const CYCLES: usize = 500;
/// One unit of a correction, m (10⁻⁴ mm).
const COUNT_M: f64 = 1e-7;
/// What a force that is rounded to 1e-6 N may do to a way of 7 mm.
const TOLERANCE_M: f64 = 1e-6;

fn spring_rod(ethercat: bool) -> (Scenario, BoardSettings) {
    let scenario = Scenario::spring_rod().unwrap();
    let mut scenario = without_noise(scenario.with_law(LawName::Seed));
    scenario.board = patient(&scenario.board);
    scenario.board.ethercat.enabled = ethercat;
    let settings = scenario.actual_board().unwrap();
    (scenario, settings)
}

/// Position along x after each cycle, in units of a correction.
fn path(motion: &[[i64; 6]]) -> Vec<i64> {
    motion
        .iter()
        .scan(0, |at, step| {
            *at += step[0];
            Some(*at)
        })
        .collect()
}

/// The path of the same test over CAN in virtual time; the bounce is in it.
fn over_can() -> Vec<i64> {
    let (scenario, _) = spring_rod(false);
    let (recording, _) = record(&scenario).unwrap();
    let impacts = impacts::find(&scenario, &recording);
    assert_eq!(impacts.len(), 1, "{impacts:?}");
    let corrections: Vec<_> = recording
        .cycles
        .iter()
        .map(|c| c.output.correction)
        .collect();
    path(&corrections[..CYCLES])
}

fn assert_same_path(motion: &Motion) {
    let off = |(can, ethercat): (&i64, &i64)| (can - ethercat).abs();
    let worst = over_can().iter().zip(&path(motion)).map(off).max().unwrap();
    println!(
        "the paths differ by {:.2e} m at most",
        worst as f64 * COUNT_M
    );
    assert!(worst as f64 * COUNT_M < TOLERANCE_M, "{worst} units");
}

#[test]
fn the_process_follows_the_same_path_as_over_can() {
    let (scenario, settings) = spring_rod(true);
    let toml = to_string_pretty(&settings).unwrap();
    let board = Board::start("ethercat_rig", &toml, &["--start", "--ethercat", ANY]);
    let ethercat = board.ethercat.expect("a port");
    let mut rig = LockStepRig::connect_ethercat(&scenario, &settings, board.robot, ethercat);
    rig.wait_for_sensor();
    let motion = rig.run(CYCLES);
    drop(rig);
    board.stop();
    assert_same_path(&motion);
}

/// The EtherCAT stack and the driver of the Ethernet controller as they would be flashed, beside RSI.
#[test]
fn the_cortex_m7_follows_the_same_path_as_over_can() {
    let (scenario, settings) = spring_rod(true);
    let toml = to_string_pretty(&settings).unwrap();
    let arguments = ["--start", "--ethercat", ANY];
    let mut board = QemuBoard::start("ethercat_qemu", &toml, &arguments);
    let ethercat = board.ethercat.expect("a port");
    let mut rig = LockStepRig::connect_ethercat(&scenario, &settings, board.robot, ethercat);
    board.process().wait_for("sensor Running");
    let motion = rig.run(CYCLES);
    drop(rig);
    board.stop();
    assert_same_path(&motion);
}
