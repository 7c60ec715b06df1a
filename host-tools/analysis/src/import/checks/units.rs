//! Are the numbers of the size that their unit says? Hints for the user, no corrections.

use super::{CheckError, Context};
use softdock_app::record::CycleRecord;
use softdock_physics::model::Axis;
use softdock_report::number;

/// No docking rig reaches farther, m.
const FARTHEST_M: f64 = 50.0;
/// No docking rig moves faster, m/s.
const FASTEST_M_S: f64 = 20.0;
/// ... or turns faster, rad/s.
const FASTEST_RAD_S: f64 = 50.0;
/// No force/torque sensor of such a rig reads more, N and N·m.
const LARGEST_LOAD: f64 = 1e5;
/// A force that never exceeds this is below the resolution of any sensor of a rig, N.
const SMALLEST_FORCE_N: f64 = 1e-3;
/// Position over velocity, or the other way, from which on it is a matter of units: degrees make a factor of 57,
/// millimetres one of 1000, and no gain or lever of a rig one of 10.
const OTHER_UNITS: f64 = 10.0;
/// How far a quaternion's length may be from 1: what four decimals leave.
const UNIT_LENGTH: f64 = 1e-3;

type Value = fn(&CycleRecord) -> f64;

/// Appends what looks wrong.
pub(super) fn check(
    cycles: &[CycleRecord],
    sample_time_s: f64,
    context: &Context<'_>,
    warnings: &mut Vec<String>,
) -> Result<(), CheckError> {
    let name = context.name;
    let mut warn = |text: String| warnings.push(format!("{name}: {text}"));
    sizes(cycles, &mut warn);
    quaternion(cycles, &mut warn);
    same_numbers(cycles, &mut warn);
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

fn sizes(cycles: &[CycleRecord], warn: &mut impl FnMut(String)) {
    let position = largest(cycles, |c| &c.trace.pose[..3]);
    if position > FARTHEST_M {
        warn(format!(
            "a position of {} m: are the positions in mm?",
            rounded(position)
        ));
    }
    for (what, speed, angular) in [
        (
            "executed",
            largest(cycles, |c| &c.trace.executed_velocity[..3]),
            largest(cycles, |c| &c.trace.executed_velocity[3..]),
        ),
        (
            "sent",
            largest(cycles, |c| &c.trace.sent_velocity[..3]),
            largest(cycles, |c| &c.trace.sent_velocity[3..]),
        ),
    ] {
        if speed > FASTEST_M_S {
            warn(format!(
                "a velocity {what} of {} m/s: are the velocities in mm/s?",
                rounded(speed)
            ));
        }
        if angular > FASTEST_RAD_S {
            warn(format!(
                "an angular velocity {what} of {} rad/s: is it in degrees per second?",
                rounded(angular)
            ));
        }
    }
    let force = largest(cycles, |c| &c.inputs.sensor.wrench[..3]);
    let torque = largest(cycles, |c| &c.inputs.sensor.wrench[3..]);
    if force > LARGEST_LOAD || torque > LARGEST_LOAD {
        warn(format!(
            "a wrench of {} N and {} N·m: are these counts of the sensor, or mN?",
            rounded(force),
            rounded(torque)
        ));
    }
    if force > 0.0 && force < SMALLEST_FORCE_N {
        warn(format!(
            "no force exceeds {} N: is it in kN, or is this another quantity?",
            rounded(force)
        ));
    }
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

/// Force and position, force and velocity: one column under two names is a slip of the mapping.
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

/// Steps of the position against the velocity: a factor between the two is a wrong unit. Axis, factor, what to do.
fn velocities_of_positions(cycles: &[CycleRecord], sample_time_s: f64) -> Vec<(Axis, f64, String)> {
    let mut found = Vec::new();
    for axis in [Axis::X, Axis::Y, Axis::Z] {
        let i = axis.index();
        let (mut dp_dp, mut dp_v, mut v_v) = (0.0, 0.0, 0.0);
        for pair in cycles.windows(2) {
            let dp = pair[1].trace.pose[i] - pair[0].trace.pose[i];
            let v = 0.5
                * sample_time_s
                * (pair[1].trace.executed_velocity[i] + pair[0].trace.executed_velocity[i]);
            dp_dp += dp * dp;
            dp_v += dp * v;
            v_v += v * v;
        }
        // Only where the two clearly belong together is their ratio worth a word; what is no number is none of the units'.
        let together = dp_v * dp_v >= 0.8 * dp_dp * v_v;
        if !together || dp_dp == 0.0 {
            continue;
        }
        let ratio = dp_v / v_v;
        let hint = match ratio {
            r if r < 0.0 => {
                "one of the two has the wrong sign; say `scale = -1.0` for it".to_owned()
            }
            r if (500.0..2000.0).contains(&r) => {
                format!("is the position in mm? Say `unit = \"mm\"` for {axis} in [position]")
            }
            r if (5e-4..2e-3).contains(&r) => {
                format!(
                    "is the velocity in mm/s? Say `unit = \"mm/s\"` for {axis} in [executed_velocity]"
                )
            }
            r if !(0.7..1.4).contains(&r) => format!(
                "are their units and the sample time right? `scale = {ratio:.4}` for {axis} in \
                 [executed_velocity] of the mapping would make them agree"
            ),
            _ => continue,
        };
        found.push((axis, ratio, hint));
    }
    found
}
