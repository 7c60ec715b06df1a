//! An axis of which only the drive's current is recorded, scaled by a guess.

use softdock_analysis::diagnose::{Verdict, diagnose};
use softdock_app::record::CycleRecord;
use softdock_io::recording::{Header, Recording};
use softdock_physics::model::Model;
use softdock_statistics::RandomStream;

const TS: f64 = 0.002;
/// Mass, kg, and spring, N/m: known.
const KNOWN: (f64, f64) = (20.0, 1500.0);
/// Dry and viscous friction, N and N·s/m.
const FRICTION: (f64, f64) = (6.0, 40.0);
/// The motor gives 16 N/A where the mapping's scale says 25.
const SURPLUS: f64 = 25.0 / 16.0 - 1.0;

const MODEL: &str = r#"
[rig]
active_axes = ["x"]
[tool]
mass_kg = 20.0
dynamic_compensation = true
[sensor]
wrench = "unscaled"
gravity_m_s2 = [0.0, 0.0, 0.0]
[noise]
force_n = 0.5
position_m = 1e-8
[[effect]]
id = "cable_stiffness"
parameters = { stiffness_n_per_m = 1500.0 }
"#;

/// Position, velocity and acceleration: three swings that do not repeat.
fn motion(t: f64, phase: f64) -> [f64; 3] {
    let swings = [(0.05, 1.7), (0.02, 4.1), (0.005, 11.0)];
    swings.iter().fold([0.0; 3], |[x, v, a], (size, rate)| {
        let (sin, cos) = (rate * t + phase * rate).sin_cos();
        [
            x + size * sin,
            v + size * rate * cos,
            a - size * rate * rate * sin,
        ]
    })
}

fn log(seconds: f64, phase: f64, seed: u64) -> Recording {
    let mut random = RandomStream::new(seed, 0);
    let mut last = None;
    let record = |n: usize| {
        let t = n as f64 * TS;
        let [x, v, a] = motion(t, phase);
        let friction = FRICTION.0 * v.signum() + FRICTION.1 * v;
        let force = KNOWN.0 * a + KNOWN.1 * x + friction;
        let position = x + 1e-8 * random.normal();
        let before = last.replace(position).unwrap_or(position - v * TS);
        let mut cycle = CycleRecord::default();
        cycle.trace.cycle = n as u64;
        cycle.trace.time_s = t;
        cycle.trace.pose = [position, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0];
        cycle.trace.executed_velocity[0] = (position - before) / TS;
        cycle.inputs.sensor.wrench = [0.0; 6];
        cycle.inputs.sensor.wrench[0] = -(1.0 + SURPLUS) * force + 0.5 * random.normal();
        cycle
    };
    Recording {
        header: Header {
            identity: "imported from a test".to_owned(),
            settings_toml: String::new(),
            scenario_toml: None,
        },
        cycles: (0..(seconds / TS) as usize).map(record).collect(),
        ..Recording::default()
    }
}

/// Friction is what it is in newtons, not what it is on the wrong scale.
#[test]
fn a_guessed_scale_of_the_current_is_found_beside_friction() {
    let model = Model::from_toml(MODEL, "model.toml").unwrap();
    let (train, test) = (log(12.0, 0.0, 1), log(8.0, 2.0, 2));
    let found = diagnose(&model, &[&train], &[&test], &|_, _| {}).unwrap();
    let found = found.diagnosis;
    assert_eq!(found.verdict, Verdict::Named, "{}", found.sentence);
    let mut named = found.effects.clone();
    named.sort();
    let expected = ["guide_coulomb", "guide_viscous", "input_gain"];
    assert_eq!(named, expected, "{}", found.sentence);
    for (effect, parameter, truth) in [
        ("input_gain", "surplus", SURPLUS),
        ("guide_coulomb", "force_n", FRICTION.0),
        ("guide_viscous", "damping_n_s_per_m", FRICTION.1),
    ] {
        let said = &found.parameters[effect][parameter];
        assert!(
            (said.value - truth).abs() < 0.01 * truth,
            "{parameter}: {said:?}"
        );
    }
}
