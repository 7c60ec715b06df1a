//! Do the values have the size that their unit suggests? Hints for the user; nothing is corrected.

use super::{CheckError, Context};
use softdock_app::record::CycleRecord;
use softdock_control::frames::Twist;
use softdock_physics::model::Axis;
use softdock_physics::model::load::pose_of;
use softdock_report::number;
use std::cmp::Ordering;
use std::f64::consts::{PI, TAU};

/// No docking rig reaches farther, m.
const FARTHEST_M: f64 = 50.0;
/// No docking rig moves faster, m/s.
const FASTEST_M_S: f64 = 20.0;
/// ... or turns faster, rad/s.
const FASTEST_RAD_S: f64 = 50.0;
/// A motor's shaft that turns alone does, to 10,000 rpm, rad/s.
const FASTEST_SHAFT_RAD_S: f64 = 1050.0;
/// No force/torque sensor of such a rig reads more, N and N·m.
const LARGEST_LOAD: f64 = 1e5;
/// A force that never exceeds this is below the resolution of any sensor of a rig, N.
const SMALLEST_FORCE_N: f64 = 1e-3;
/// Ratio of the change of position to the velocity, or its inverse, from which on only units can be the cause: degrees make a
/// factor of 57, millimetres one of 1000, and no gain or lever of a rig makes one of 10.
const OTHER_UNITS: f64 = 10.0;
/// Largest deviation of a quaternion's length from 1: what rounding to four decimals leaves.
const UNIT_LENGTH: f64 = 1e-3;

type Value = fn(&CycleRecord) -> f64;

/// Appends a warning for each value that looks wrong.
pub(super) fn check(
    cycles: &[CycleRecord],
    sample_time_s: f64,
    context: &Context<'_>,
    warnings: &mut Vec<String>,
) -> Result<(), CheckError> {
    let name = context.name;
    let mut warn = |text: String| warnings.push(format!("{name}: {text}"));
    if context.imports {
        if !are_integrals(cycles, sample_time_s) {
            positions(cycles, &mut warn);
        }
        velocities(cycles, &mut warn);
        loads(cycles, &mut warn);
        same_numbers(cycles, &mut warn);
    }
    quaternion(cycles, &mut warn);
    if context.at_rest() {
        return Ok(());
    }
    for (axis, ratio, hint) in velocities_of_positions(cycles, sample_time_s) {
        if !(1.0 / OTHER_UNITS..OTHER_UNITS).contains(&ratio.abs()) {
            let name = name.to_owned();
            return Err(CheckError::Units {
                name,
                axis,
                ratio,
                hint,
            });
        }
        if !context.imports {
            continue;
        }
        warn(format!(
            "position {axis} changes {ratio:.4} times as fast as its velocity says: {hint}"
        ));
    }
    Ok(())
}

/// Largest absolute value of a part of all rows; 0 where nothing is measured.
fn largest<'a>(cycles: &'a [CycleRecord], part: impl Fn(&'a CycleRecord) -> &'a [f64]) -> f64 {
    cycles
        .iter()
        .flat_map(part)
        .fold(0.0, |largest, v| v.abs().max(largest))
}

fn rounded(value: f64) -> String {
    number::significant(value, 4)
}

/// Whether the positions are integrals of the velocities (trapezoidal rule) and not measured: then they have no unit of their
/// own. Steps of measured positions never equal the mean velocity in every cycle.
fn are_integrals(cycles: &[CycleRecord], sample_time_s: f64) -> bool {
    /// Tolerance of a step, relative to the position.
    const ROUNDING: f64 = 1e-9;
    /// Longer steps, in sample times, are gaps: the sum goes on there and is not checked.
    const GAP: f64 = 1.5;
    let traces = cycles.iter().map(|cycle| &cycle.trace);
    let mut steps = traces.clone().zip(traces.skip(1));
    let moves = |axis: usize| {
        cycles
            .iter()
            .any(|c| c.trace.executed_velocity[axis] != 0.0)
    };
    let moving: Vec<usize> = (0..3).filter(|axis| moves(*axis)).collect();
    !moving.is_empty()
        && steps.all(|(before, after)| {
            let is_integral = |axis: &usize| {
                let (x, v) = (after.pose[*axis], after.executed_velocity[*axis]);
                let mean = 0.5 * (before.executed_velocity[*axis] + v);
                let step = x - before.pose[*axis];
                (step - sample_time_s * mean).abs() <= ROUNDING * x.abs()
            };
            after.time_s - before.time_s > GAP * sample_time_s || moving.iter().all(is_integral)
        })
}

fn positions(cycles: &[CycleRecord], warn: &mut impl FnMut(String)) {
    let position = largest(cycles, |c| &c.trace.pose[..3]);
    if position > FARTHEST_M {
        warn(format!(
            "a position of {} m: are the positions in mm? Say `unit = \"mm\"` for them in [position] of the mapping",
            rounded(position)
        ));
    }
}

fn velocities(cycles: &[CycleRecord], warn: &mut impl FnMut(String)) {
    let fastest_turn = match turns_alone(cycles) {
        true => FASTEST_SHAFT_RAD_S,
        false => FASTEST_RAD_S,
    };
    const DERIVED: [&str; 2] = [
        " or, where it is derived, `unit = \"mm\"` in [position]",
        " or, where it is derived, `unit = \"deg\"` in [orientation]",
    ];
    for (what, [or_linear, or_angular], speed, angular) in [
        (
            "executed",
            DERIVED,
            largest(cycles, |c| &c.trace.executed_velocity[..3]),
            largest(cycles, |c| &c.trace.executed_velocity[3..]),
        ),
        (
            "sent",
            [""; 2],
            largest(cycles, |c| &c.trace.sent_velocity[..3]),
            largest(cycles, |c| &c.trace.sent_velocity[3..]),
        ),
    ] {
        if speed > FASTEST_M_S {
            warn(format!(
                "a velocity {what} of {} m/s: is it in mm/s? Say `unit = \"mm/s\"` for it in [{what}_velocity] of the \
                 mapping{or_linear}",
                rounded(speed)
            ));
        }
        if angular > fastest_turn {
            warn(format!(
                "an angular velocity {what} of {} rad/s: is it in degrees per second, or in rpm? Say `unit = \"deg/s\"`, or \"rpm\", \
                 for it in [{what}_velocity] of the mapping{or_angular}",
                rounded(angular)
            ));
        }
    }
}

fn loads(cycles: &[CycleRecord], warn: &mut impl FnMut(String)) {
    let force = largest(cycles, |c| &c.inputs.sensor.wrench[..3]);
    let torque = largest(cycles, |c| &c.inputs.sensor.wrench[3..]);
    if force > LARGEST_LOAD || torque > LARGEST_LOAD {
        warn(format!(
            "a wrench of {} N and {} N·m: are these counts of the sensor, or mN? Say `unit` or `scale` for them in [wrench] \
             of the mapping",
            rounded(force),
            rounded(torque)
        ));
    }
    if force > 0.0 && force < SMALLEST_FORCE_N {
        warn(format!(
            "no force exceeds {} N: is it in kN, or is this another quantity? Say `unit = \"kN\"` or `scale` for it in \
             [wrench] of the mapping",
            rounded(force)
        ));
    }
}

/// Whether one rotation is all that moves.
fn turns_alone(cycles: &[CycleRecord]) -> bool {
    let velocities = |c: &CycleRecord| [c.trace.executed_velocity, c.trace.sent_velocity];
    let moves = |i: usize| {
        let still = |c: &CycleRecord| {
            velocities(c)
                .iter()
                .all(|v| v[i].abs().partial_cmp(&0.0) != Some(Ordering::Greater))
        };
        !cycles.iter().all(still)
    };
    let moving: Vec<usize> = (0..6).filter(|i| moves(*i)).collect();
    matches!(moving.as_slice(), [axis] if *axis >= 3)
}

fn quaternion(cycles: &[CycleRecord], warn: &mut impl FnMut(String)) {
    let length = |c: &CycleRecord| c.trace.pose[3..].iter().map(|q| q * q).sum::<f64>().sqrt();
    let off = cycles
        .iter()
        .map(length)
        .enumerate()
        .find(|(_, length)| (length - 1.0).abs() > UNIT_LENGTH);
    if let Some((n, length)) = off {
        warn(format!(
            "row {}: the quaternion has the length {length}, not 1: are its four columns the right \
             ones?",
            n + 1
        ));
    }
}

/// Warns of a force with the values of a position or velocity: one column under two names is a slip of the mapping.
fn same_numbers(cycles: &[CycleRecord], warn: &mut impl FnMut(String)) {
    let loads: [(&str, Value); 3] = [
        ("fx", |c| c.inputs.sensor.wrench[0]),
        ("fy", |c| c.inputs.sensor.wrench[1]),
        ("fz", |c| c.inputs.sensor.wrench[2]),
    ];
    let motions: [(&str, Value); 6] = [
        ("position x", |c| c.trace.pose[0]),
        ("position y", |c| c.trace.pose[1]),
        ("position z", |c| c.trace.pose[2]),
        ("executed velocity x", |c| c.trace.executed_velocity[0]),
        ("executed velocity y", |c| c.trace.executed_velocity[1]),
        ("executed velocity z", |c| c.trace.executed_velocity[2]),
    ];
    for (load_name, load) in loads {
        if cycles.iter().all(|c| load(c) == 0.0) {
            continue;
        }
        for (motion_name, motion) in &motions {
            // In m or in mm.
            for scale in [1.0, 1e3] {
                let same = |c: &CycleRecord| {
                    let (a, b) = (load(c), motion(c) * scale);
                    (a - b).abs() <= 1e-9 * a.abs().max(b.abs())
                };
                if cycles.iter().all(same) {
                    warn(format!(
                        "force {load_name} holds the numbers of {motion_name}: a column was taken \
                         twice"
                    ));
                }
            }
        }
    }
}

/// Compares steps of the pose with the velocity: a constant factor between them is a wrong unit. Returns axis, factor, what to
/// do.
fn velocities_of_positions(cycles: &[CycleRecord], sample_time_s: f64) -> Vec<(Axis, f64, String)> {
    // Products of step and step, step and velocity, velocity and velocity, for each axis.
    let mut sums = [[0.0; 3]; 6];
    for pair in cycles.windows(2) {
        let (before, after) = (&pair[0].trace, &pair[1].trace);
        let step = step(&before.pose, &after.pose);
        for (i, [dp_dp, dp_v, v_v]) in sums.iter_mut().enumerate() {
            let v =
                0.5 * sample_time_s * (after.executed_velocity[i] + before.executed_velocity[i]);
            *dp_dp += step[i] * step[i];
            *dp_v += step[i] * v;
            *v_v += v * v;
        }
    }
    let found = Axis::ALL.into_iter().zip(sums);
    let found = found.filter_map(|(axis, [dp_dp, dp_v, v_v])| {
        // The ratio counts only if the two are clearly correlated; columns that are not finite are no question of units.
        let together = dp_v * dp_v >= 0.8 * dp_dp * v_v;
        if !together || dp_dp == 0.0 || v_v == 0.0 {
            return None;
        }
        let ratio = dp_v / v_v;
        Some((axis, ratio, other_unit(axis, ratio)?))
    });
    found.collect()
}

/// How far the pose moved in C and turned in M.
fn step(before: &[f64; 7], after: &[f64; 7]) -> [f64; 6] {
    let (before, after) = (pose_of(before), pose_of(after));
    Twist {
        linear: after.translation.vector - before.translation.vector,
        angular: (before.rotation.inverse() * after.rotation).scaled_axis(),
    }
    .get()
}

/// Advice on a pose that changes `ratio` times as fast as its velocity says; None if that ratio is plausible.
fn other_unit(axis: Axis, ratio: f64) -> Option<String> {
    const DEGREES: f64 = 180.0 / PI;
    // Section, unit, the factor that it makes, and the tolerance of this factor. Units of rotation are close to each other, and
    // to the factors of levers or gears.
    type Other = (&'static str, &'static str, f64, f64);
    const OF_ROTATIONS: [Other; 5] = [
        ("orientation", "deg", DEGREES, 2.0),
        ("orientation", "turn", 1.0 / TAU, 1.05),
        (VELOCITY, "deg/s", 1.0 / DEGREES, 2.0),
        (VELOCITY, "rev/s", TAU, 1.05),
        (VELOCITY, "rpm", PI / 30.0, 1.05),
    ];
    const OF_TRANSLATIONS: [Other; 2] =
        [("position", "mm", 1e3, 2.0), (VELOCITY, "mm/s", 1e-3, 2.0)];
    const VELOCITY: &str = "executed_velocity";
    let others = match axis.is_rotation() {
        true => &OF_ROTATIONS[..],
        false => &OF_TRANSLATIONS[..],
    };
    if ratio < 0.0 {
        return Some("one of the two has the wrong sign; say `scale = -1.0` for it".to_owned());
    }
    let about = |(.., factor, off): &&Other| (1.0 / off..*off).contains(&(ratio / factor));
    if let Some((section, unit, ..)) = others.iter().find(about) {
        let what = if *section == VELOCITY {
            "velocity"
        } else {
            section
        };
        return Some(format!(
            "is the {what} in {unit}? Say `unit = \"{unit}\"` for {axis} in [{section}]"
        ));
    }
    (!(0.7..1.4).contains(&ratio)).then(|| {
        format!(
            "are their units and the sample time right? A `scale` {ratio:.4} times as large for {axis} in [{VELOCITY}] of the mapping \
             would make them agree"
        )
    })
}
