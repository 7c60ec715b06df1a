//! Known answers of the one-step predictions, above all their alignment in time.

use super::*;
use crate::model::{BodyModel, GuideModel, WallModel};
use softdock_app::record::CycleRecord;
use softdock_control::io::Sequence;
use softdock_control::modes::Mode;
use softdock_io::recording::Recording;

const TS: f64 = 0.004;

/// A foreign log: no telegrams, no settings.
fn log(cycles: usize, fill: impl Fn(usize, &mut CycleRecord)) -> Recording {
    let cycles = (0..cycles)
        .map(|n| {
            let mut cycle = CycleRecord::default();
            cycle.trace.cycle = n as u64;
            cycle.trace.time_s = n as f64 * TS;
            cycle.trace.pose[3] = 1.0;
            fill(n, &mut cycle);
            cycle
        })
        .collect();
    Recording {
        cycles,
        ..Recording::default()
    }
}

/// The same with telegrams, as a board records them.
fn telegrams(recording: &mut Recording) {
    for (n, cycle) in recording.cycles.iter_mut().enumerate() {
        cycle.inputs.robot.counter = 4 * n as u64 + 4;
        cycle.inputs.robot.pose = Some([0.0; 6]);
        cycle.inputs.robot.sequence = if n == 0 {
            Sequence::NewRun
        } else {
            Sequence::Next
        };
    }
}

/// A velocity along x that is sent from cycle 5 on.
fn step_of_x(n: usize, cycle: &mut CycleRecord) {
    if n >= 5 {
        cycle.trace.sent_velocity[0] = 1.0;
    }
}

fn predicted_x(model: &Model, recording: &Recording, channel: Channel) -> Vec<f64> {
    let prediction = predict(model, recording).unwrap();
    let values = prediction.channel(channel).predicted.iter();
    values.map(|p| p.map_or(f64::NAN, |p| p[0])).collect()
}

#[test]
fn without_delay_a_correction_moves_the_robot_until_the_next_cycle() {
    let mut recording = log(10, step_of_x);
    telegrams(&mut recording);
    let x = predicted_x(&Model::default(), &recording, Channel::ExecutedVelocity);
    assert_eq!(x[1..], [0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0]);
    assert!(x[0].is_nan(), "the first cycle has no velocity");
}

#[test]
fn a_delay_between_two_cycles_shares_the_mean() {
    let mut model = Model::default();
    model.actuator.transport_delay_s = 2.25 * TS;
    let mut recording = log(12, step_of_x);
    telegrams(&mut recording);
    let x = predicted_x(&model, &recording, Channel::ExecutedVelocity);
    assert_eq!(x[6..], [0.0, 0.0, 0.75, 1.0, 1.0, 1.0]);
}

#[test]
fn sampled_velocities_follow_the_equation_of_the_log_format() {
    let mut model = Model::default();
    model.actuator.transport_delay_s = 2.0 * TS;
    model.actuator.lag_s = 0.004;
    let sent = |n: usize| (n as f64 * 0.7).sin();
    let recording = log(50, |n, cycle| {
        cycle.trace.sent_velocity[0] = sent(n);
        // A velocity that is not the difference of the poses.
        cycle.trace.executed_velocity[0] = n as f64;
        let steps: f64 = (0..n).map(|k| 0.5 + k as f64).sum();
        cycle.trace.pose[0] = TS * steps;
    });
    let x = predicted_x(&model, &recording, Channel::ExecutedVelocity);
    let e = (-TS / 0.004_f64).exp();
    let mut y = 0.0;
    for (n, x) in x.iter().enumerate() {
        if n > 0 {
            y = e * y + (1.0 - e) * if n >= 3 { sent(n - 3) } else { 0.0 };
        }
        assert!((x - y).abs() < 1e-12, "{n}: {x} {y}");
    }
    let prediction = predict(&model, &recording).unwrap();
    for n in 1..50 {
        let left = prediction
            .channel(Channel::Pose)
            .residual(n, Axis::X)
            .unwrap();
        assert!(
            left.abs() < 1e-12,
            "trapezoid of sampled velocities: {left}"
        );
    }
}

#[test]
fn the_mean_over_a_cycle_with_lag_is_the_integral() {
    let mut model = Model::default();
    model.actuator.lag_s = 0.01;
    let mut recording = log(60, step_of_x);
    telegrams(&mut recording);
    let x = predicted_x(&model, &recording, Channel::ExecutedVelocity);
    // A lag loses its time constant's worth of displacement after a unit step.
    let displacement: f64 = x[6..].iter().sum::<f64>() * TS;
    assert!(
        (displacement - (54.0 * TS - 0.01)).abs() < 1e-9,
        "{displacement}"
    );
}

#[test]
fn lost_telegrams_told_the_robot_nothing() {
    let mut model = Model::default();
    model.actuator.transport_delay_s = 2.0 * TS;
    let mut recording = log(12, step_of_x);
    telegrams(&mut recording);
    recording.cycles[8].inputs.robot.sequence = Sequence::Gap(1);
    let x = predicted_x(&model, &recording, Channel::ExecutedVelocity);
    assert!(x[8].is_nan(), "a velocity across a gap is none");
    // What was sent in cycles 5 to 7 is executed, then nothing for one cycle.
    assert_eq!(x[9..], [1.0, 0.0, 1.0]);
}

/// Poses of an accelerated mass with a row missing: no acceleration is known at the ends of both stretches. If velocities are
/// measured or sent, each row has one.
#[test]
fn a_motion_has_no_acceleration_of_its_own_at_its_ends() {
    let mut model = Model::default();
    model.tool.mass_kg = 1.0;
    model.tool.dynamic_compensation = true;
    let place = |n: usize| 0.5 * (n as f64 * TS).powi(2);
    let log = |sent: f64, sampled: f64| {
        let mut log = log(12, |n, cycle| {
            cycle.trace.pose[0] = place(n);
            let mean = (place(n) - place(n.max(1) - 1)) / TS;
            cycle.trace.executed_velocity[0] = mean + 0.5 * TS * sampled;
            cycle.trace.sent_velocity[0] = sent * n as f64;
        });
        log.cycles.remove(6);
        log
    };
    let known = |log: &Recording| {
        let x = predicted_x(&model, log, Channel::Wrench);
        x.into_iter().map(f64::is_finite).collect::<Vec<_>>()
    };
    let inside = [1, 2, 3, 4, 7, 8, 9];
    let expected: Vec<bool> = (0..11).map(|n| inside.contains(&n)).collect();
    assert_eq!(known(&log(0.0, 0.0)), expected);
    assert_eq!(known(&log(0.0, 1.0)), [true; 11]);
    assert!(known(&log(1e-3, 0.0))[10]);
}

#[test]
fn a_held_sample_is_compared_with_its_own_instant() {
    let mut model = Model::default();
    model.contact.walls.push(WallModel {
        point_m: [0.0; 3],
        normal: [-1.0, 0.0, 0.0],
        stiffness_n_per_m: 1000.0,
        damping_n_s_per_m: 0.0,
        damping_depth_m: 0.0,
        tip_m: [0.0; 3],
    });
    let mut recording = log(7, |n, cycle| {
        cycle.trace.pose[0] = n as f64 * 1e-3;
        cycle.trace.executed_velocity[0] = 0.25;
    });
    telegrams(&mut recording);
    for cycle in &mut recording.cycles {
        cycle.inputs.sensor.counter = 1;
    }
    recording.cycles[4].trace.sensor_age = 1;
    let x = predicted_x(&model, &recording, Channel::Wrench);
    for (n, expected) in [(2, -2.0), (3, -3.0), (4, -3.0), (5, -5.0)] {
        assert!((x[n] - expected).abs() < 1e-9, "{n}: {}", x[n]);
    }
    assert!(x[6].is_nan(), "at the end no pose has an acceleration");
}

#[test]
fn a_wall_damps_by_depth_and_never_pulls_and_a_guide_leaves_its_axis_free() {
    let mut model = Model::default();
    let tip_m = [0.4, 0.0, 0.0];
    model.contact.walls.push(WallModel {
        point_m: [0.4, 0.0, 0.0],
        normal: [-2.0, 0.0, 0.0],
        stiffness_n_per_m: 1000.0,
        damping_n_s_per_m: 100.0,
        damping_depth_m: 0.004,
        tip_m,
    });
    model.contact.guide = Some(GuideModel {
        axis: [1.0, 0.0, 0.0],
        point_m: [0.0; 3],
        tip_m,
        stiffness_n_per_m: 500.0,
        damping_n_s_per_m: 10.0,
    });
    // Half of the damping at half of its depth; the guide's levers are those of the tip about M.
    for (x, speed, force) in [(0.002, 0.1, -7.0), (0.002, -1.0, 0.0), (0.01, 0.1, -20.0)] {
        let recording = log(3, |_, cycle| {
            cycle.trace.pose[0] = x;
            cycle.trace.pose[1] = 0.01;
            cycle.trace.executed_velocity[0] = speed;
            cycle.trace.executed_velocity[2] = 0.02;
        });
        let prediction = predict(&model, &recording).unwrap();
        let got = prediction.channel(Channel::Wrench).predicted[1].unwrap();
        let expected = [force, -5.0, -0.2, 0.0, 0.08, -2.0];
        let near = got.iter().zip(expected).all(|(g, e)| (g - e).abs() < 1e-9);
        assert!(near, "{got:?} {expected:?}");
    }
}

#[test]
fn a_log_without_bodies_integrates_its_own_wrench() {
    let mut model = Model::default();
    model.bodies.k = BodyModel {
        mass_kg: Some(500.0),
        inertia_kg_m2: Some([[100.0, 0.0, 0.0], [0.0, 100.0, 0.0], [0.0, 0.0, 100.0]]),
        ..BodyModel::default()
    };
    model.sensor.bias[0] = 7.0;
    let force = |n: usize| 50.0 + 10.0 * n as f64;
    // v(n) − v(n−1) = Ts/2 (a(n) + a(n−1))
    let velocity = |n: usize| -> f64 {
        (1..=n)
            .map(|k| 0.5 * TS * (force(k) + force(k - 1)) / 500.0)
            .sum()
    };
    let recording = log(20, |n, cycle| {
        cycle.trace.mode = if n >= 4 { Mode::Running } else { Mode::Hold };
        cycle.inputs.sensor.wrench[0] = force(n) + 7.0;
        cycle.trace.model_velocity[0] = velocity(n);
    });
    let prediction = predict(&model, &recording).unwrap();
    let channel = prediction.channel(Channel::ModelVelocity);
    assert!(channel.predicted[..6].iter().all(Option::is_none));
    for n in 6..20 {
        let left = channel.residual(n, Axis::X).unwrap();
        assert!(left.abs() < 1e-15, "{n}: {left}");
    }
    // An axis that is held has no predicted motion and is not judged; neither is one without a sensor.
    model.rig.active_axes = vec![Axis::Y];
    let prediction = predict(&model, &recording).unwrap();
    assert_eq!(prediction.judged(Channel::ModelVelocity), [Axis::Y]);
    assert_eq!(prediction.judged(Channel::Wrench), [Axis::X]);
}

/// A mass on a spring, 5 Hz, its velocity sampled: the difference over the last cycle would show
/// −m ω² Ts/2 = −20 N·s/m.
#[test]
fn an_oscillation_without_damping_shows_none() {
    let (mass, omega) = (10.0, 10.0 * std::f64::consts::PI);
    let mut model = Model::default();
    model.tool.mass_kg = mass;
    model.tool.dynamic_compensation = true;
    model.sensor.gravity_m_s2 = [0.0; 3];
    let recording = log(1000, |n, cycle| {
        let (sin, cos) = (omega * n as f64 * TS).sin_cos();
        cycle.trace.pose[0] = 0.01 * sin;
        cycle.trace.executed_velocity[0] = 0.01 * omega * cos;
        cycle.inputs.sensor.wrench[0] = mass * 0.01 * omega * omega * sin;
    });
    let prediction = predict(&model, &recording).unwrap();
    let channel = prediction.channel(Channel::Wrench);
    // The ends have a neighbour on one side only.
    let pairs = (1..999).map(|n| {
        let speed = recording.cycles[n].trace.executed_velocity[0];
        (speed, channel.residual(n, Axis::X).unwrap())
    });
    let (both, squares) = pairs.fold((0.0, 0.0), |(both, squares), (v, r)| {
        (both + v * r, squares + v * v)
    });
    let damping = both / squares;
    assert!(damping.abs() < 0.01, "{damping} N·s/m");
}
