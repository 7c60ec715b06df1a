//! An axis whose velocity follows its command, with no sensor beside it.

use super::joint::named;
use softdock_analysis::diagnose::{Report, Verdict, diagnose};
use softdock_io::recording::Recording;
use softdock_physics::model::Model;
use softdock_statistics::RandomStream;
use softdock_tests::one_axis::OneAxis;

const MODEL: &str =
    "[rig]\nactive_axes = [\"x\"]\n[noise]\nvelocity_m_s = 5e-5\nposition_m = 1e-7\n";

/// Steps of two sizes, m/s.
fn steps(t: f64) -> f64 {
    0.02 * (0.9 * t).sin().signum() + 0.015 * (0.37 * t).cos().signum()
}

/// An axis whose motion is written into its log afterwards.
fn at_rest(cycle_s: f64) -> OneAxis {
    OneAxis {
        cycle_s,
        turns: false,
        swings: [(0.0, 1.0); 3],
        noise: (0.0, 0.0),
        late_s: 0.0,
    }
}

/// A damped second order behind a delay.
#[derive(Clone, Copy)]
struct Servo {
    late_s: f64,
    /// rad/s, and damping ratio.
    response: (f64, f64),
    gain: f64,
    /// Part of the velocity that follows the position, of which the catalogue knows nothing.
    ripple: f64,
}

impl Servo {
    /// What it does with [`steps`] from a time on: poses, and velocities that are their differences.
    fn follows(self, seconds: f64, from_s: f64) -> Recording {
        const CUTS: u8 = 40;
        let rig = at_rest(0.004);
        let mut recording = rig.record(seconds, 0.0, 1, |_| 0.0);
        let step_s = rig.cycle_s / f64::from(CUTS);
        let (rate, damping) = self.response;
        let [mut x, mut y, mut slope, mut executed] = [0.0; 4];
        for (n, cycle) in recording.cycles.iter_mut().enumerate() {
            let t = rig.cycle_s * n as f64 + from_s;
            cycle.trace.sent_velocity[0] = steps(t);
            // Where it is when a velocity is sent, and how it came there.
            cycle.trace.executed_velocity[0] = executed;
            cycle.trace.pose = [x, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0];
            // Without a sensor there is no error of it.
            cycle.inputs.sensor.wrench = [f64::NAN; 6];
            // It rests until the first command has come.
            let came = t - self.late_s >= from_s;
            let sent = if came {
                self.gain * steps(t - self.late_s)
            } else {
                0.0
            };
            let before = x;
            for _ in 0..CUTS {
                slope += step_s * (rate.powi(2) * (sent - y) - 2.0 * damping * rate * slope);
                y += step_s * slope;
                x += step_s * y * (1.0 + self.ripple * (300.0 * x).sin());
            }
            executed = (x - before) / rig.cycle_s;
        }
        recording
    }

    fn logs(self, seconds: f64) -> [Recording; 2] {
        [
            self.follows(seconds, 0.0),
            self.follows(0.7 * seconds, 31.0),
        ]
    }
}

fn diagnosed(model: &Model, [train, test]: &[Recording; 2]) -> Report {
    diagnose(model, &[train], &[test], &|_, _| {}).unwrap()
}

/// A delay and limits together leave more, with more parameters.
#[test]
#[ignore = "long: one more machine to diagnose"]
fn a_servo_is_not_taken_apart_where_more_is_left_than_noise() {
    let model = Model::from_toml(MODEL, "model.toml").unwrap();
    for (ripple, is_left) in [(0.02, 0.0), (0.1, 0.02)] {
        let servo = Servo {
            late_s: 0.0,
            response: (8.6, 0.89),
            gain: 1.0,
            ripple,
        };
        let logs = servo.logs(12.0);
        let found = diagnosed(&model, &logs);
        let (found, after) = (found.diagnosis, found.after);
        assert_eq!(found.effects, ["second_order_servo"], "{}", found.sentence);
        assert!(!found.sentence.contains("NaN"), "{}", found.sentence);
        let hz = &found.parameters["second_order_servo"]["frequency_hz"];
        assert!((hz.value / 1.369 - 1.0).abs() < 0.05, "{hz:?}");
        assert!(found.remainder.share >= is_left, "{}", found.sentence);
        let again = diagnosed(&after, &logs).diagnosis;
        assert_eq!(again.verdict, Verdict::NothingMissing, "{}", again.sentence);
    }
}

/// A hoist: its mode is damped less than any servo, and alone it would be told by neither of the two.
#[test]
#[ignore = "long: one more machine to diagnose"]
fn a_mode_that_rings_behind_a_delay_is_no_servo_at_the_end_of_its_range() {
    let hoist = Servo {
        late_s: 0.072,
        response: (22.5, 0.11),
        gain: 1.0,
        ripple: 0.005,
    };
    let model = Model::from_toml(MODEL, "model.toml").unwrap();
    let found = diagnosed(&model, &hoist.logs(12.0)).diagnosis;
    let ids = ["actuation_delay", "structural_resonance"];
    assert_eq!(named(&found), ids, "{}", found.sentence);
    for (id, name, truth) in [
        ("actuation_delay", "extra_delay_s", hoist.late_s),
        ("structural_resonance", "frequency_hz", 3.581),
        ("structural_resonance", "damping_ratio", hoist.response.1),
    ] {
        let said = &found.parameters[id][name];
        assert!((said.value / truth - 1.0).abs() < 0.05, "{id}: {said:?}");
    }
}

/// Where positions alone were measured, what is too small may be a gain or a clock: a gain is the plainer.
#[test]
#[ignore = "long: one more machine to diagnose"]
fn a_gain_is_no_clock_where_nothing_is_felt() {
    let small = Servo {
        late_s: 0.0,
        response: (60.0, 0.9),
        gain: 0.959,
        ripple: 0.03,
    };
    let model = Model::from_toml(MODEL, "model.toml").unwrap();
    let found = diagnosed(&model, &small.logs(8.0)).diagnosis;
    let gain = &found.parameters["velocity_gain"]["gain_error"];
    assert!((gain.value + 0.041).abs() < 0.004, "{gain:?}");
    assert!(
        !found.parameters.contains_key("clock_rate"),
        "{}",
        found.sentence
    );
}

/// Of what no law describes something is left in any case; beside it one log moves twice as far as the other.
#[test]
fn logs_of_two_gains_disagree_beside_what_no_law_describes() {
    let with = |gain: f64| Servo {
        late_s: 0.02,
        response: (60.0, 0.9),
        gain,
        ripple: 0.15,
    };
    let logs = [with(0.5).follows(8.0, 0.0), with(1.0).follows(6.0, 31.0)];
    let model = Model::from_toml(MODEL, "model.toml").unwrap();
    let found = diagnosed(&model, &logs).diagnosis;
    assert_eq!(found.verdict, Verdict::LogsDisagree, "{}", found.sentence);
    let of_each = |note: &String| note.contains("each log alone: those of the fit");
    assert!(found.notes.iter().any(of_each), "{:?}", found.notes);
}

/// A motor behind a bridge that does not answer small duties, one step each: 14 ms late, with a time constant of 26 ms and a gain
/// of 1.1 beyond ±0.006 m/s, which its poles modulate by 2 %, of which the catalogue knows nothing.
fn step(size: f64) -> Recording {
    const LATE_S: f64 = 0.014;
    let rig = at_rest(0.002);
    let mut recording = rig.record(1.0, 0.0, 1, |_| 0.0);
    let [mut x, mut v, mut executed] = [0.0; 3];
    for (n, cycle) in recording.cycles.iter_mut().enumerate() {
        let t = rig.cycle_s * n as f64;
        let told = |t: f64| if t < 0.3 { 0.0 } else { size };
        cycle.trace.sent_velocity[0] = told(t);
        cycle.trace.executed_velocity[0] = executed;
        cycle.trace.pose = [x, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0];
        cycle.inputs.sensor.wrench = [f64::NAN; 6];
        let came = told(t - LATE_S);
        let beyond = came.signum() * (came.abs() - 0.006).max(0.0);
        v += (1.0 - (-rig.cycle_s / 0.026).exp()) * (1.1 * beyond - v);
        executed = v * (1.0 + 0.02 * (900.0 * x).sin());
        x += rig.cycle_s * executed;
    }
    recording
}

/// A log with one step in one direction tells neither the width of a dead zone from a gain nor one of both directions from the other: in
/// all logs together these amounts are common.
#[test]
fn single_steps_of_one_motor_do_not_disagree() {
    let sizes = [0.01, -0.01, 0.013, -0.013, 0.016, -0.016, 0.02, -0.02];
    let train: Vec<Recording> = sizes.into_iter().map(step).collect();
    let unseen: Vec<Recording> = [0.011, -0.015, 0.018].into_iter().map(step).collect();
    let [train, unseen] = [&train, &unseen].map(|logs| logs.iter().collect::<Vec<_>>());
    let model = Model::from_toml(MODEL, "model.toml").unwrap();
    let found = diagnose(&model, &train, &unseen, &|_, _| {})
        .unwrap()
        .diagnosis;
    assert_eq!(found.verdict, Verdict::Named, "{}", found.sentence);
    for (id, name, truth) in [
        ("actuation_delay", "extra_delay_s", 0.014),
        ("actuation_lag", "extra_lag_s", 0.026),
        ("command_deadzone", "width_m_s", 0.012),
    ] {
        let said = &found.parameters[id][name];
        assert!((said.value / truth - 1.0).abs() < 0.2, "{id}: {said:?}");
    }
}

/// A motor that is switched on and off: on it is there in 10 ms, off it coasts down for 80 ms. Two values of a command lie on a
/// straight line: of what it does with small ones they say nothing.
#[test]
fn a_command_of_two_values_shows_no_dead_zone() {
    let rig = at_rest(0.004);
    let switched = |seconds: f64, seed: u64| {
        let mut random = RandomStream::new(seed, 0);
        let mut recording = rig.record(seconds, 0.0, seed, |_| 0.0);
        let [mut x, mut v, mut sent] = [0.0; 3];
        for (n, cycle) in recording.cycles.iter_mut().enumerate() {
            cycle.trace.sent_velocity[0] = sent;
            cycle.trace.executed_velocity[0] = v;
            cycle.trace.pose = [x, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0];
            cycle.inputs.sensor.wrench = [f64::NAN; 6];
            let time_constant_s = if sent > v { 0.01 } else { 0.08 };
            v += (1.0 - (-rig.cycle_s / time_constant_s).exp()) * (sent - v);
            x += rig.cycle_s * v;
            if n % 5 == 4 {
                sent = if random.normal() > 0.0 { 0.02 } else { 0.0 };
            }
        }
        recording
    };
    let model = Model::from_toml(MODEL, "model.toml").unwrap();
    let found = diagnosed(&model, &[switched(12.0, 1), switched(8.0, 2)]).diagnosis;
    let mut tried = found.ranked.iter().flat_map(|one| &one.effects);
    let bends = tried.find(|id| ["command_deadzone", "gain_by_direction"].contains(&id.as_str()));
    assert_eq!(bends, None, "{}", found.sentence);
}
