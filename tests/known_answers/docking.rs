//! Docking mechanisms in the loop: what is captured, how hard, and what is refused.

use softdock_control::delay::LawName;
use softdock_control::modes::Mode;
use softdock_experiments::check::Rig;
use softdock_experiments::run::{RunStatistics, run};
use softdock_experiments::scenario::Scenario;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

fn path(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../host-tools/scenarios")
        .join(name)
}

/// Runs a scenario: how it ended, and the last mode.
fn ended(scenario: &Scenario) -> (RunStatistics, Mode) {
    let mut mode = Mode::Idle;
    let statistics = run(scenario, &mut |record, _| {
        mode = record.trace.mode;
        ControlFlow::Continue(())
    });
    (statistics.unwrap(), mode)
}

/// What the robot worked on the mechanism is stored or lost.
fn assert_balanced(statistics: &RunStatistics, share: f64) {
    let balance = &statistics.energy;
    assert!(balance.work_j > 1.0, "{balance:?}");
    assert!(
        balance.imbalance_j().abs() < share * balance.work_j,
        "{balance:?}"
    );
}

/// A late robot presses the probe out of the drogue again; with a law against the delay the latches
/// catch it, and the board stops.
#[test]
fn a_delay_costs_the_capture_of_a_probe() {
    let scenario = Scenario::load(&path("probe-drogue.toml")).unwrap();
    let (late, mode) = ended(&scenario.clone().with_law(LawName::None));
    assert_eq!((late.captured_s, mode), (None, Mode::Running));
    let (predicted, mode) = ended(&scenario.with_law(LawName::Predictor));
    assert!(
        predicted
            .captured_s
            .is_some_and(|s| (3.0..3.4).contains(&s)),
        "{predicted:?}"
    );
    assert_eq!(mode, Mode::Hold, "the capture switch stops the board");
    for statistics in [late, predicted] {
        assert_balanced(&statistics, 0.01);
    }
}

/// From the corner of the box of the standard the ring comes home, with loads below the limits.
#[test]
fn soft_capture_succeeds_from_the_corner_of_the_box() {
    let scenario = Scenario::load(&path("soft-capture.toml")).unwrap();
    let (statistics, mode) = ended(&scenario);
    assert!(
        statistics
            .captured_s
            .is_some_and(|s| (6.0..7.5).contains(&s)),
        "{statistics:?}"
    );
    assert_eq!(mode, Mode::Hold);
    assert_balanced(&statistics, 0.01);
    let limits = scenario.rig.mechanism.docking[0].limits.unwrap().named();
    for ((name, load), (_, limit)) in statistics.loads[0].named().into_iter().zip(limits) {
        assert!(load < limit, "{name}: {load:?} of {limit:?}");
    }
}

/// Latches of 200 kN/m on 4 t bear a delay of 10 ms: a loop that stays closed on them swings up.
#[test]
fn a_loop_that_stays_closed_on_a_latched_joint_is_refused() {
    let mut scenario = Scenario::load(&path("probe-drogue.toml")).unwrap();
    assert!(Rig::of_scenario(&scenario).is_ok());
    scenario.rig.mechanism.runs_on_after_capture = true;
    let error = Rig::of_scenario(&scenario).unwrap_err().to_string();
    let expected = "a closed loop on the latched joint swings up: 200000 N/m and 2000 N·s/m on 4";
    assert!(error.starts_with(expected), "{error}");
    let soft = scenario.rig.mechanism.docking[0].kind;
    let softdock_mechanism::Kind::ProbeCone(mut cone) = soft else {
        panic!("a probe and a cone")
    };
    let socket = cone.socket.as_mut().unwrap();
    (
        socket.latch_stiffness_n_per_m,
        socket.latch_damping_n_s_per_m,
    ) = (2500.0, 500.0);
    scenario.rig.mechanism.docking[0].kind = softdock_mechanism::Kind::ProbeCone(cone);
    assert!(
        Rig::of_scenario(&scenario).is_ok(),
        "10 kN/m with 2 kN·s/m bear the robot's delay"
    );
}
