//! How deep the firmware's stack gets in QEMU, which has the NUCLEO's 128 kB: it is painted at reset, and
//! the board tells what is left of the paint.

use super::faults::moving;
use softdock_control::delay::LawName;
use softdock_experiments::scenario::Scenario;
use softdock_rig::firmware::{RELEASED, STACK_BUDGET, emulated_profile};
use softdock_tests::peers::{LockStepRig, Motion, QemuBoard, params, patient};
use std::net::{SocketAddrV4, UdpSocket};
use toml_edit::ser::to_string_pretty;

/// The spacecraft flies, touches, and flies back.
const CYCLES: usize = 500;
/// The DTCM of the NUCLEO, bytes.
const AVAILABLE: u64 = 128 << 10;

fn ask(board: &QemuBoard, arguments: &[&str]) -> serde_json::Value {
    let port = format!("tcp:{}", board.service);
    let run = params(&board.folder, &port, &[arguments, &["--json"]].concat());
    run.succeeded().json()
}

/// What the board says when it has looked at its stack, which it does each second.
fn deepest(board: &mut QemuBoard, when: &str) -> u64 {
    std::thread::sleep(std::time::Duration::from_millis(1200));
    let status = ask(board, &["status"]);
    let stack = &status["machine"]["stack"];
    assert_eq!(stack["available"], AVAILABLE, "{status}");
    let deepest = stack["deepest"].as_u64().unwrap();
    println!(
        "{when}: {deepest} bytes, {:.0} %",
        100.0 * deepest as f64 / AVAILABLE as f64
    );
    // Without optimisation frames are larger; what goes to a board never is without.
    let budget = match emulated_profile().as_str() {
        RELEASED => STACK_BUDGET,
        _ => 1.0,
    };
    assert!(
        (deepest as f64) < budget * AVAILABLE as f64,
        "{when}: {deepest} bytes"
    );
    assert!(
        deepest > AVAILABLE / 10,
        "{when}: {deepest} bytes, nothing was painted"
    );
    deepest
}

/// The spacecraft came and went: there was a contact in between.
fn assert_bounced(motion: &Motion) {
    let way = |cycles: &[[i64; 6]]| cycles.iter().map(|step| step[0]).sum::<i64>();
    let (came, went) = (way(&motion[150..200]), way(&motion[CYCLES - 50..]));
    assert!(came * went < 0, "{came} before, {went} behind");
}

#[test]
fn the_stack_has_room_whatever_the_board_does() {
    // Nobody reads what comes to it.
    let recorder = UdpSocket::bind("127.0.0.1:0").unwrap();
    let address: SocketAddrV4 = recorder.local_addr().unwrap().to_string().parse().unwrap();
    let mut scenario = Scenario::spring_rod().unwrap().with_law(LawName::Predictor);
    scenario.board = patient(&scenario.board);
    let mut settings = scenario.actual_board().unwrap();

    let toml = to_string_pretty(&settings).unwrap();
    let mut board = QemuBoard::start("qemu_stack_alone", &toml, &[]);
    board.process().wait_for("sensor Starting");
    let boot = deepest(&mut board, "boot without a recorder");
    board.stop();

    settings.network.recorder = address.to_string().as_str().try_into().unwrap();
    let toml = to_string_pretty(&settings).unwrap();
    let mut board = QemuBoard::start("qemu_stack", &toml, &["--start"]);
    let mut rig = LockStepRig::connect(&scenario, &settings, board.robot, board.can);
    board.process().wait_for("sensor Running");
    let mut motion = rig.run(CYCLES / 2);
    board.process().wait_for("mode Running");
    // The service is at work with its largest answers while the loop is closed.
    let list = ask(&board, &["list"]);
    assert!(list["settings"].as_array().unwrap().len() > 90);
    motion.extend(rig.run(CYCLES / 2));
    assert_bounced(&motion);
    deepest(
        &mut board,
        "the loop closed, with a contact, service and telemetry",
    );
    drop(rig);
    board.process().wait_for("robot silent");
    // It might come back at once.
    while ask(&board, &["status"])["status"]["moves"] == true {}
    ask(&board, &["set", "control.sensor.tool_mass_kg", "0.25"]);
    let again = deepest(&mut board, "started over with other settings");
    assert!(again.abs_diff(boot) < AVAILABLE / 4, "{boot} and {again}");
    board.end();
}

/// ethercrab brings the SubDevice up, then the loop is closed over it.
#[test]
fn ethercat_leaves_room_on_the_stack() {
    let mut scenario = Scenario::spring_rod().unwrap().with_law(LawName::Predictor);
    scenario.board = patient(&scenario.board);
    scenario.board.ethercat.enabled = true;
    let settings = scenario.actual_board().unwrap();
    let toml = to_string_pretty(&settings).unwrap();
    let arguments = ["--start", "--ethercat", "127.0.0.1:0"];
    let mut board = QemuBoard::start("qemu_stack_ethercat", &toml, &arguments);
    let segment = board.ethercat.expect("a port");
    let mut rig = LockStepRig::connect_ethercat(&scenario, &settings, board.robot, segment);
    board.process().wait_for("sensor Running");
    assert_bounced(&rig.run(CYCLES));
    deepest(&mut board, "the loop closed over EtherCAT, with a contact");
    drop(rig);
    board.stop();
}

#[test]
fn a_latched_fault_leaves_room_on_the_stack() {
    let (mut board, mut robot, sensor) = moving("qemu_stack_fault", &[]);
    sensor.be_silent(true);
    board.until("fault SensorStale", || {
        robot.cycle();
    });
    for _ in 0..50 {
        assert!(robot.cycle().is_zero());
    }
    deepest(&mut board, "a latched fault");
    board.stop();
}
