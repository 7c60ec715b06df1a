//! A sensor of fewer than six axes.

use super::tables::{imported, table};
use softdock_analysis::diagnose::{Verdict, diagnose};
use softdock_analysis::import::starter::starter;
use softdock_physics::model::Model;
use softdock_statistics::RandomStream;

/// A load cell of one axis is tilted with a tool of 2 g: the weight is named, to 0.1 mN, and the zero beside it, as what loads the
/// other axes is not read.
#[test]
fn a_load_cell_of_one_axis_weighs_its_tool() {
    const WEIGHT_N: f64 = 0.002 * 9.80665;
    let log = |begin: f64| {
        let mut noise = RandomStream::new(11, begin.to_bits());
        let noise: Vec<f64> = (0..1500).map(|_| 1e-4 * noise.normal()).collect();
        table("t,roll,pitch,f", 1500, |n| {
            let t = 0.02 * n;
            let (roll, pitch) = ((0.9 * t + begin).sin(), 0.6 * (0.4 * t).sin());
            // Gravity along the sensor's y.
            let weight = -WEIGHT_N * roll.sin() * pitch.cos();
            format!("{t},{roll},{pitch},{}", 0.014 + weight + noise[n as usize])
        })
    };
    let mapping = r#"
        files = { train = "a.csv", test = "b.csv" }
        time = { column = "t" }
        wrench = { fy = "f" }
        [orientation]
        euler = "zyx"
        rx = { column = "roll", unit = "rad" }
        ry = { column = "pitch", unit = "rad" }
    "#;
    let files = [("a.csv", log(0.0)), ("b.csv", log(1.0))];
    let logs = imported("load_cell", mapping, &files).unwrap();
    let text = starter(&logs.train, None).unwrap().text;
    let model = Model::from_toml(&text, "model.toml").unwrap();
    let found = diagnose(&model, &[&logs.train[0]], &[&logs.test[0]], &|_, _| {});
    let found = found.unwrap().diagnosis;
    assert_eq!(found.verdict, Verdict::Named, "{}", found.sentence);
    let mut effects = found.effects.clone();
    effects.sort_unstable();
    assert_eq!(effects, ["ft_bias", "tool_mass_error"]);
    for (effect, parameter, expected) in [
        ("tool_mass_error", "mass_error_kg", 0.002),
        ("ft_bias", "fy_n", 0.014),
    ] {
        let value = found.parameters[effect][parameter].value;
        assert!((value / expected - 1.0).abs() < 0.01, "{effect}: {value}");
    }
    let wrench = found.residual_rms_sigma.after.wrench;
    assert!((0.9..1.1).contains(&wrench), "{wrench}");
}
