//! The firmware in QEMU sends each cycle to a recorder, and the host recomputes the recording bit
//! for bit.

use softdock_control::delay::LawName;
use softdock_experiments::scenario::Scenario;
use softdock_tests::peers::{LockStepRig, QemuBoard, patient};
use softdock_tests::process::{Running, json, scratch, softdock_binary};
use std::net::SocketAddrV4;
use std::process::Command;
use toml_edit::ser::to_string_pretty;

/// The spacecraft flies, touches, and flies back.
const CYCLES: usize = 500;

#[test]
fn a_recording_from_qemu_replays_bit_for_bit() {
    let folder = scratch("qemu_telemetry_recorder");
    let mut command = Command::new(softdock_binary());
    let arguments = [
        "record",
        "--listen",
        "127.0.0.1:0",
        "-o",
        "run.mcap",
        "--json",
        // The image may still have to be built.
        "--timeout",
        "600",
    ];
    let mut recorder = Running::start("recorder", command.current_dir(&folder).args(arguments));
    let line = recorder.wait_for("listening on UDP ");
    let address = line.split(' ').find_map(|word| word.parse().ok());
    let address: SocketAddrV4 = address.expect("the recorder's address");

    let mut scenario = Scenario::spring_rod().unwrap().with_law(LawName::Seed);
    scenario.board = patient(&scenario.board);
    let settings = &mut scenario.board;
    settings.network.recorder = address.to_string().as_str().try_into().unwrap();
    let settings = scenario.actual_board().unwrap();
    let toml = to_string_pretty(&settings).unwrap();
    let mut board = QemuBoard::start("qemu_telemetry", &toml, &["--start"]);
    let mut rig = LockStepRig::connect(&scenario, &settings, board.robot, board.can);
    board.process().wait_for("sensor Running");
    rig.run(CYCLES);
    board.process().wait_for("mode Running");
    drop(rig);
    // A silent robot is announced once more, with the last count of losses.
    board.process().wait_for("robot silent");
    board.stop();
    recorder.interrupt();
    let (status, log) = recorder.finish();
    assert!(status.success(), "{log}");
    let summary = log
        .find('{')
        .map(|at| serde_json::Deserializer::from_str(&log[at..]));
    let summary: serde_json::Value =
        serde::Deserialize::deserialize(&mut summary.unwrap()).unwrap();
    let machine = &summary["recordings"][0]["machine"];
    let answers = machine["answers"]["histogram"].as_array().unwrap();
    assert!(
        answers.iter().filter_map(|n| n.as_u64()).sum::<u64>() > 0,
        "{summary}"
    );
    assert_eq!(machine["stack"]["available"], 128 << 10, "{summary}");

    let replay = json(&folder, &["replay", "run.mcap"]);
    assert_eq!(replay["identical"], true, "{replay}");
    let cycles = replay["cycles"].as_u64().unwrap();
    assert!(cycles as usize >= CYCLES - 10, "{replay}");
}
