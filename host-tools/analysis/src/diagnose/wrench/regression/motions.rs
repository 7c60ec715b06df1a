//! The motion of a log without the noise of its measurement.
//!
//! A wrench that is predicted from measured velocities inherits their noise, and a regression on
//! noisy regressors is biased (it finds negative tool masses where nothing is missing). The
//! simulated velocity has no noise; the pose is its integral, kept at the measured pose by a short
//! moving average of the difference.

use crate::diagnose::actuator::{Cost, Term};
use nalgebra::{UnitQuaternion, Vector3};
use softdock_actuator::{Reading, Timing, simulate};
use softdock_control::frames::{self, Pose, Twist};
use softdock_control::wrench::Motion;
use softdock_physics::model::Model;
use softdock_physics::model::load::Scene;
use softdock_physics::model::load::loaded::{LoadOfEach, add_known};
use softdock_physics::model::log::Log;
use softdock_physics::model::prediction::differences::{
    acceleration_of_means, acceleration_of_samples, velocity_of_means,
};

/// Cycles on either side over which the moving average of the pose difference extends.
const POSE_REACH: usize = 6;
/// The same for velocities, where the simulated actuator is not trusted.
const VELOCITY_REACH: usize = 2;

/// Motion and nominal reading of a log. `trusted`: the actuator terms explain the executed velocity, and it is not corrected.
pub(crate) fn scene(
    model: &Model,
    log: &Log,
    cost: &Cost<'_>,
    terms: &[Term],
    trusted: bool,
    intervals_s: &[f64],
) -> Scene {
    let timing = Timing {
        cycle_s: log.cycle_s,
        intervals_s,
    };
    let (pose, motion) = if model.sensor.at_rest || log.rests(&model.noise) {
        (log.pose.clone(), vec![still(); log.cycle_count()])
    } else if log.is_commanded() {
        simulated(log, cost, terms, trusted, &timing)
    } else {
        (log.pose.clone(), measured(log))
    };
    let scene = Scene::new(model, log.cycle_s, log.time_s.clone(), pose, motion);
    let turned = |n: usize| log.turned_by_velocity(n);
    let scene = scene.of_log(
        log.of_a_rig,
        log.whole_turns,
        turned,
        log.wrench_changes,
        &log.began,
    );
    let mut scene = scene.with_sensor(log.measured());
    // Effects that the model has already are part of the nominal reading.
    add_known(&mut scene, &model.effects, &LoadOfEach::default());
    scene
}

fn still() -> Motion<f64> {
    Motion {
        velocity: Twist::zero(),
        acceleration: Twist::zero(),
    }
}

/// The motion from the recorded velocities, differentiated as the prediction does it. The first row of a stretch holds no mean
/// velocity and is not used.
fn measured(log: &Log) -> Vec<Motion<f64>> {
    let first = usize::from(log.reading == Reading::Mean);
    let executed = |n: usize| {
        let rates = log.executed.each_ref().map(|series| series[n]);
        Twist::of(&log.velocity(n, rates))
    };
    (0..log.cycle_count())
        .map(|n| {
            let beside = |offset: isize| {
                let at = n.checked_add_signed(offset)?;
                (first..log.cycle_count())
                    .contains(&at)
                    .then(|| executed(at))
            };
            let (velocity, change) = match log.reading {
                Reading::AtEnd => (beside(0), acceleration_of_samples(beside)),
                Reading::Mean => (velocity_of_means(beside), acceleration_of_means(beside)),
            };
            Motion {
                velocity: velocity.unwrap_or(Twist::zero()),
                acceleration: change.unwrap_or(Twist::zero()) * (1.0 / log.cycle_s),
            }
        })
        .collect()
}

fn simulated(
    log: &Log,
    cost: &Cost<'_>,
    terms: &[Term],
    trusted: bool,
    timing: &Timing<'_>,
) -> (Vec<Pose<f64>>, Vec<Motion<f64>>) {
    let series = |reading: Reading| -> [Vec<f64>; 6] {
        std::array::from_fn(|axis| {
            if !cost.active[axis] {
                return vec![0.0; log.cycle_count()];
            }
            let chain = cost.chain(terms, axis);
            let mut velocity = log.as_imported(simulate(&chain, &log.sent[axis], timing, reading));
            if !trusted {
                let error: Vec<f64> = log.executed[axis]
                    .iter()
                    .zip(&velocity)
                    .map(|(e, v)| e - v)
                    .collect();
                let smooth = moving_average(&error, VELOCITY_REACH);
                velocity.iter_mut().zip(smooth).for_each(|(v, s)| *v += s);
            }
            velocity
        })
    };
    let (at_end, mean) = (
        turned(log, series(Reading::AtEnd)),
        turned(log, series(Reading::Mean)),
    );
    let motion = (0..log.cycle_count())
        .map(|n| {
            let velocity = std::array::from_fn(|axis| at_end[axis][n]);
            // A held command is a staircase whose edges a real drive smooths: the inertial load is that
            // of the mean acceleration over the last cycle, here, in the rig and in imported logs.
            let acceleration = std::array::from_fn(|axis| match n {
                0 => 0.0,
                _ => (at_end[axis][n] - at_end[axis][n - 1]) / timing.interval(n),
            });
            Motion {
                velocity: Twist::of(&velocity),
                acceleration: Twist::of(&acceleration),
            }
        })
        .collect();
    (integrated(log, &mean, timing), motion)
}

/// Turns rates of the robot's axes into velocities.
fn turned(log: &Log, rates: [Vec<f64>; 6]) -> [Vec<f64>; 6] {
    let mut velocities = rates;
    for n in 0..log.cycle_count() {
        let velocity = log.velocity(n, velocities.each_ref().map(|series| series[n]));
        for (series, value) in velocities.iter_mut().zip(velocity) {
            series[n] = value;
        }
    }
    velocities
}

/// Poses as the integral of a velocity, kept at the measured pose by a moving average of the difference.
fn integrated(log: &Log, mean: &[Vec<f64>; 6], timing: &Timing<'_>) -> Vec<Pose<f64>> {
    let mut path: Vec<Pose<f64>> = Vec::with_capacity(log.cycle_count());
    let mut now = log.pose[0];
    path.push(now);
    for n in 1..log.cycle_count() {
        let h = timing.interval(n);
        let [x, y, z, rx, ry, rz] = mean.each_ref().map(|series| series[n] * h);
        let (way, turn) = (Vector3::new(x, y, z), Vector3::new(rx, ry, rz));
        now = Pose::from_parts(
            (now.translation.vector + way).into(),
            now.rotation * UnitQuaternion::from_scaled_axis(turn),
        );
        path.push(now);
    }
    let errors: [Vec<f64>; 6] = {
        let rows: Vec<[f64; 6]> = (0..log.cycle_count())
            .map(|n| {
                let moved = log.position(n) - path[n].translation.vector;
                let turned = (path[n].rotation.inverse() * log.rotation(n)).scaled_axis();
                [moved.x, moved.y, moved.z, turned.x, turned.y, turned.z]
            })
            .collect();
        std::array::from_fn(|axis| rows.iter().map(|row| row[axis]).collect())
    };
    let smooth = errors.map(|series| moving_average(&series, POSE_REACH));
    (0..log.cycle_count())
        .map(|n| {
            let shift = Vector3::from_fn(|i, _| smooth[i][n]);
            let turn = Vector3::from_fn(|i, _| smooth[i + 3][n]);
            let rotation = path[n].rotation * UnitQuaternion::from_scaled_axis(turn);
            let place = path[n].translation.vector + shift;
            frames::pose(
                &[place.x, place.y, place.z],
                &[rotation.w, rotation.i, rotation.j, rotation.k],
            )
        })
        .collect()
}

/// Mean over `reach` values on either side, as many as there are.
fn moving_average(values: &[f64], reach: usize) -> Vec<f64> {
    let mut sums = Vec::with_capacity(values.len() + 1);
    sums.push(0.0);
    let mut sum = 0.0;
    for value in values {
        sum += value;
        sums.push(sum);
    }
    (0..values.len())
        .map(|n| {
            // Both sides equally, so that a slope is not bent at the ends.
            let reach = reach.min(n).min(values.len() - 1 - n);
            let (from, to) = (n - reach, n + reach + 1);
            (sums[to] - sums[from]) / (to - from) as f64
        })
        .collect()
}
