//! The firmware in QEMU closes the loop with the simulated rig over real sockets, and computes what
//! the board on the host computes.

use softdock_app::settings::BoardSettings;
use softdock_control::delay::LawName;
use softdock_experiments::impacts;
use softdock_experiments::run::record;
use softdock_experiments::scenario::Scenario;
use softdock_tests::peers::{LockStepRig, Motion, QemuBoard, patient, without_noise};
use toml_edit::ser::to_string_pretty;

/// The spacecraft flies with 5 mm/s, touches after 1 s, is turned around and flies back: 2 s.
const CYCLES: usize = 500;
/// One unit of a correction, m (10⁻⁴ mm).
const COUNT_M: f64 = 1e-7;

/// The paper's spring-rod test with its law, and a board that has patience with a busy computer.
fn spring_rod() -> (Scenario, BoardSettings) {
    let scenario = Scenario::spring_rod().unwrap();
    let mut scenario = without_noise(scenario.with_law(LawName::Seed));
    scenario.board = patient(&scenario.board);
    let settings = scenario.actual_board().unwrap();
    (scenario, settings)
}

/// The same on the host, in virtual time; the bounce is in it.
fn on_host() -> Motion {
    let (scenario, _) = spring_rod();
    let (recording, _) = record(&scenario).unwrap();
    let impacts = impacts::find(&scenario, &recording);
    assert_eq!(impacts.len(), 1, "{impacts:?}");
    let corrections = recording.cycles.iter().map(|c| c.output.correction);
    corrections.take(CYCLES).collect()
}

fn in_qemu(test: &str, chip: &str) -> Motion {
    let (scenario, settings) = spring_rod();
    let toml = to_string_pretty(&settings).unwrap();
    let mut board = QemuBoard::start(test, &toml, &["--start", "--chip", chip]);
    let mut rig = LockStepRig::connect(&scenario, &settings, board.robot, board.can);
    board.process().wait_for("sensor Running");
    let motion = rig.run(CYCLES);
    board.process().wait_for("mode Running");
    drop(rig);
    board.stop();
    motion
}

/// Position along x after each cycle, in units of a correction.
fn path(motion: &Motion) -> Vec<i64> {
    motion
        .iter()
        .scan(0, |at, step| {
            *at += step[0];
            Some(*at)
        })
        .collect()
}

#[test]
fn the_cortex_m7_sends_every_correction_as_the_host_does() {
    let host = on_host();
    let qemu = in_qemu("qemu_rig_an500", "an500");
    for (cycle, (host, qemu)) in host.iter().zip(&qemu).enumerate() {
        assert_eq!(host, qemu, "cycle {cycle}");
    }
}

/// 64-bit fixed point resolves 2.3e-10 in SI units: a velocity of 5 mm/s to eight digits, but the
/// cubic terms of the paper's law to three. The spacecraft may come back 0.3 % faster or slower, which
/// is 20 µm on its way of 7 mm.
#[test]
fn the_cortex_m3_in_fixed_point_follows_the_same_path() {
    const TOLERANCE_M: f64 = 2e-5;
    let host = path(&on_host());
    let motion = in_qemu("qemu_rig_an385", "an385");
    let off = |(host, qemu): (&i64, &i64)| (host - qemu).abs();
    let worst = host.iter().zip(&path(&motion)).map(off).max().unwrap();
    println!(
        "the paths differ by {:.2e} m at most",
        worst as f64 * COUNT_M
    );
    assert!(
        worst as f64 * COUNT_M < TOLERANCE_M,
        "the paths differ by {worst} units"
    );
}
