//! MuJoCo as the plant, robot and sensor of a board process. Its physics are not this project's: the
//! stiffness is that of joints, the friction that of its own solver, the cone is 24 plates.
//!
//! The spring rod is the gate: a plant that misses its duration or restitution by more than 0.5 % is
//! not believed. Then a probe meets a cone off its axis, with both spacecraft free, on MuJoCo's rig and
//! on this one.

use serde_json::{Value, json};
use softdock_experiments::scenario::Scenario;
use softdock_io::input;
use softdock_io::recording::Recording;
use softdock_mechanism::Kind;
use softdock_tests::peers::python::mujoco;
use softdock_tests::peers::{Board, LockStepRig, patient};

/// What the gate lets through.
const GATE: f64 = 0.005;
/// Mass of the probe's head, which the plant needs, kg.
const HEAD_KG: f64 = 0.3;

/// A robot without delay, a sensor without noise that stands at the probe's head, and room to move.
const COMMON: &str = "
start_position_m = [1.2, 0.1, 0.9]
[board.control]
delay = { law = 'none' }
limits = { box_m = [0.5, 0.5, 0.5] }
[board.control.body_k]
mass_kg = 500.0
inertia_kg_m2 = [[180.0, 0.0, 0.0], [0.0, 220.0, 0.0], [0.0, 0.0, 210.0]]
[rig]
substep_us = 250
[rig.robot]
actuator = { delay_s = 0.0, pause_s = 0.0 }
correction_limit = { lower_m = [-0.6, -0.6, -0.6], upper_m = [0.6, 0.6, 0.6], max_rotation_rad = 0.5 }
correction_monitor = { max_translation_m = 1.0, max_rotation_rad = 0.6 }
[rig.sensor]
tool_mass_kg = 0.0
noise_force_n = 0.0
noise_torque_nm = 0.0
counts_per_newton = 50.0
counts_per_newton_metre = 50.0
calibration = [[1.0, 0.0, 0.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0, 0.0, 0.0],
               [0.0, 0.0, 0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 0.0, 0.0, 1.0]]
";

const ROD: &str = "
duration_s = 1.6
board.control.body_k.velocity_m_s = [0.005, 0.0, 0.0]
board.control.body_q.fixed = true
board.control.sensor.frozen_after_cycles = 0
[[rig.mechanism.walls]]
point_m = [1.204, 0.1, 0.9]
normal = [-1.0, 0.0, 0.0]
stiffness_n_per_m = 220500.0
";

/// The head is 1 m ahead of the flange and comes 60 mm beside the axis.
const CONE: &str = "
duration_s = 3.0
[board.control.sensor]
frozen_after_cycles = 0
position_m = [1.0, 0.0, 0.0]
[board.control.body_k]
velocity_m_s = [0.05, 0.0, 0.0]
[board.control.body_q]
mass_kg = 2000.0
inertia_kg_m2 = [[900.0, 0.0, 0.0], [0.0, 1100.0, 0.0], [0.0, 0.0, 1000.0]]
position_m = [2.3, -0.06, 0.0]
[[rig.mechanism.docking]]
position_m = [2.3, 0.04, 0.9]
tip_m = [1.0, 0.0, 0.0]
[rig.mechanism.docking.kind.probe_cone]
half_angle_rad = 0.8
mouth_radius_m = 0.3
head_radius_m = 0.05
surface = { stiffness_n_per_m = 20000.0, friction_coefficient = 0.15 }
";

/// The common part with one of the two.
fn scenario(own: &str) -> Scenario {
    let mut scenario: Scenario = input::parse(COMMON, "common").unwrap();
    let own: Scenario = input::parse(own, "scene").unwrap();
    scenario.duration_s = own.duration_s;
    scenario.rig.mechanism = own.rig.mechanism;
    scenario.rig.sensor.position_m = own.board.control.sensor.position_m;
    scenario.board.control.sensor = own.board.control.sensor;
    scenario.board.control.body_k.velocity_m_s = own.board.control.body_k.velocity_m_s;
    scenario.board.control.body_q = own.board.control.body_q;
    scenario
}

/// What MuJoCo is told of a scenario.
fn scene(scenario: &Scenario) -> Value {
    let (k, q) = (
        &scenario.board.control.body_k,
        &scenario.board.control.body_q,
    );
    let body = |b: &softdock_control::settings::BodySettings, head_kg: f64| {
        json!({
            "mass_kg": b.mass_kg - head_kg,
            "inertia_kg_m2": [b.inertia_kg_m2[0][0], b.inertia_kg_m2[1][1], b.inertia_kg_m2[2][2]],
            "velocity_m_s": b.velocity_m_s,
            "position_m": b.position_m,
        })
    };
    let head = |radius_m: f64, stiffness_n_per_m: f64| json!({"mass_kg": HEAD_KG, "radius_m": radius_m, "stiffness_n_per_m": stiffness_n_per_m});
    let mut scene = json!({
        "start": scenario.start_position_m,
        "cycles": scenario.cycles(),
        "bodies": {"k": body(k, HEAD_KG), "q": if q.fixed { Value::Null } else { body(q, 0.0) }},
    });
    if let Some(wall) = scenario.rig.mechanism.walls.first() {
        let radius_m = 0.03;
        scene["tip"] = json!(wall.tip_m);
        scene["friction"] = json!(0.0);
        scene["head"] = head(radius_m, wall.stiffness_n_per_m);
        scene["wall_x"] = json!(wall.point_m[0] + radius_m);
    }
    if let Some(docking) = scenario.rig.mechanism.docking.first() {
        let Kind::ProbeCone(cone) = docking.kind else {
            panic!("MuJoCo's plant knows a wall and a cone")
        };
        scene["tip"] = json!(docking.tip_m);
        scene["friction"] = json!(cone.surface.friction_coefficient);
        scene["head"] = head(cone.head_radius_m, cone.surface.stiffness_n_per_m);
        scene["cone"] = json!({
            "seat": docking.position_m,
            "half_angle_rad": cone.half_angle_rad,
            "mouth_radius_m": cone.mouth_radius_m,
        });
    }
    scene
}

/// A board that starts by itself, and its scenario with its settings.
fn board(test: &str, own: &str) -> (Board, Scenario) {
    let mut scenario = scenario(own);
    scenario.board = patient(&scenario.board);
    let settings = toml_edit::ser::to_string(&scenario.board).unwrap();
    (Board::start(test, &settings, &["--start"]), scenario)
}

fn recorded(board: Board) -> Recording {
    Recording::open(&board.stop().0).unwrap()
}

/// The board docks against MuJoCo.
fn outside(test: &str, own: &str) -> Recording {
    let (board, scenario) = board(&format!("mujoco_{test}"), own);
    mujoco(
        &board.folder,
        &scene(&scenario),
        Some((board.robot, board.can)),
    );
    recorded(board)
}

/// The same board docks against this project's rig, in the same lock step.
fn inside(test: &str, own: &str) -> Recording {
    let (board, scenario) = board(&format!("own_{test}"), own);
    let mut rig = LockStepRig::connect(&scenario, &scenario.board, board.robot, board.can);
    rig.run(scenario.cycles());
    drop(rig);
    recorded(board)
}

/// Velocity of K before Q at the end: linear, m/s, and angular, rad/s.
fn twist(recording: &Recording) -> [f64; 6] {
    recording.cycles.last().unwrap().trace.model_velocity
}

/// Duration of a push, s, as that of a half sine with the same peak and the same area: it does not
/// depend on where a sample falls at touch and parting. What the head swings afterwards is no push.
fn duration_s(recording: &Recording) -> f64 {
    let forces = recording
        .cycles
        .iter()
        .map(|c| c.inputs.sensor.wrench[0].abs());
    let peak = forces.clone().fold(0.0, f64::max);
    let sum: f64 = forces.filter(|force| *force > 0.03 * peak).sum();
    std::f64::consts::FRAC_PI_2 * 0.004 * sum / peak
}

fn assert_close(what: &str, found: f64, expected: f64, share: f64) {
    println!(
        "{what}: {found:.6}, expected {expected:.6}, off by {:.2} %",
        1e2 * (found / expected - 1.0)
    );
    assert!(
        (found / expected - 1.0).abs() < share,
        "{what}: {found}, expected {expected}"
    );
}

/// Duration π/ω and restitution 1 in MuJoCo alone; in the loop, where the cycle adds some energy, those
/// of this project's rig.
#[test]
fn the_spring_rod_is_the_gate() {
    let rod = scenario(ROD);
    let folder = softdock_tests::process::scratch("mujoco_free_rod");
    let alone = mujoco(&folder, &scene(&rod), None);
    assert_close("restitution alone", -alone.k[0] / 0.005, 1.0, GATE);
    assert_close(
        "duration alone",
        alone.parted - alone.touched,
        std::f64::consts::PI / 21.0,
        GATE,
    );

    let (outside, inside) = (outside("rod", ROD), inside("rod", ROD));
    assert_close(
        "restitution",
        -twist(&outside)[0] / 0.005,
        -twist(&inside)[0] / 0.005,
        GATE,
    );
    assert_close("duration", duration_s(&outside), duration_s(&inside), GATE);
}

/// All six components of the twist after the contact, measured by its largest ones.
#[test]
fn a_probe_leaves_a_cone_as_on_our_own_rig() {
    let (outside, inside) = (twist(&outside("cone", CONE)), twist(&inside("cone", CONE)));
    let largest = |part: &[f64]| part.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
    let scales = [largest(&inside[..3]), largest(&inside[3..])];
    assert!(
        scales[0] > 0.01 && scales[1] > 0.01,
        "it bounced: {inside:?}"
    );
    for (i, (found, expected)) in outside.iter().zip(inside).enumerate() {
        let off = (found - expected).abs() / scales[i / 3];
        println!(
            "component {i}: {found:.6} on MuJoCo's rig, {expected:.6} on ours, off by {:.2} %",
            1e2 * off
        );
        assert!(off < 0.03, "component {i}: {found}, expected {expected}");
    }
}
