//! What a recording cannot show, by whatever method.

use anyhow::bail;
use softdock_app::record::CycleRecord;
use softdock_control::frames::{Twist, Wrench};
use softdock_io::recording::Recording;
use softdock_physics::model::Model;
use softdock_physics::model::load::{Docked, Wall};
use softdock_physics::model::prediction::signals::Signals;

/// A name for one of the quantities of a cycle, and its six values.
type Quantity = (&'static str, fn(&CycleRecord) -> &[f64]);

const QUANTITIES: [Quantity; 4] = [
    ("velocity sent", |c| &c.trace.sent_velocity),
    ("executed velocity", |c| &c.trace.executed_velocity),
    ("pose", |c| &c.trace.pose),
    ("wrench", |c| &c.inputs.sensor.wrench),
];

/// Notes on motions, loads and values that the recording lacks. `name` is that of the recording, for errors.
///
/// # Errors
///
/// A quantity that is not finite in some rows of a log from another program: what happened there is unknown, and the prediction
/// of later rows depends on it.
pub fn missing(model: &Model, recording: &Recording, name: &str) -> anyhow::Result<Vec<String>> {
    let foreign = recording.header.settings_toml.trim().is_empty();
    let mut notes = Vec::new();
    for (quantity, of) in QUANTITIES {
        let bad = |c: &CycleRecord| of(c).iter().any(|v| !v.is_finite());
        let count = recording.cycles.iter().filter(|c| bad(c)).count();
        if count == 0 {
            continue;
        }
        if count == recording.cycles.len() {
            notes.push(format!("the log holds no {quantity}."));
            continue;
        }
        let first = recording.cycles.iter().position(bad).unwrap_or(0);
        let time_s = recording.cycles[first].trace.time_s;
        let what = format!(
            "the {quantity} is no number at {time_s} s, nor in {} other row(s)",
            count - 1
        );
        if foreign {
            bail!(
                "{name}, row {}: {what}; expected numbers in all rows or in none: cut the log there",
                first + 1
            );
        }
        notes.push(format!("{what}; these rows are left out."));
    }
    if !model.sensor.at_rest {
        notes.extend(still(model, recording)?);
    }
    Ok(notes)
}

fn still(model: &Model, recording: &Recording) -> anyhow::Result<Vec<String>> {
    let mut notes = Vec::new();
    let changes = |of: fn(&CycleRecord) -> &[f64]| {
        let mut pairs = recording.cycles.windows(2);
        pairs.any(|pair| of(&pair[0]).iter().zip(of(&pair[1])).any(|(a, b)| a != b))
    };
    // Without a robot, or with a force as the input, no velocity is sent.
    let sends = !model.sensor.wrench.drives() && Signals::new(recording)?.is_of_a_rig();
    if sends && !changes(|c| &c.trace.sent_velocity) {
        let sent = recording.cycles[0].trace.sent_velocity;
        let what = match sent.iter().any(|v| *v != 0.0) {
            true => {
                "the velocity that is sent never changes, so no delay or lag of the actuator \
                 can show; record a run in which the robot is told to start or to stop, with some rows before."
            }
            false => {
                "no velocity was sent, so no effect of the actuator can show; record a run in \
                 which the robot is told to move."
            }
        };
        notes.push(what.to_owned());
    }
    if !changes(|c| &c.trace.pose) {
        notes.push(
            "the pose never changes, so nothing that depends on motion can show; record a \
             run in which the rig moves."
                .to_owned(),
        );
    }
    if !model.contact.walls.is_empty() && !touches(model, recording)? {
        notes.push(
            "the tip touches no wall, so no effect of the contact can show; record a run \
             with contact."
                .to_owned(),
        );
    }
    if !model.contact.docking.is_empty() && !docks(model, recording)? {
        notes.push(
            "the docking mechanism is never met, so nothing of it can show; record a run with \
             contact, from before it."
                .to_owned(),
        );
    }
    Ok(notes)
}

/// Whether any docking mechanism of the model exerts a wrench in any cycle.
fn docks(model: &Model, recording: &Recording) -> anyhow::Result<bool> {
    let signals = Signals::new(recording)?;
    let mut docked = Docked::new(&model.contact.docking, signals.cycle_s);
    let mut cycles = (0..signals.len()).filter_map(|n| Some((n, signals.pose(n)?)));
    Ok(cycles.any(|(n, pose)| {
        docked.resume(signals.steps[n]);
        docked.advance(&pose);
        let velocity = signals.velocity_at_pose(n).unwrap_or_else(Twist::zero);
        docked.wrench(&pose, &velocity) != Wrench::zero()
    }))
}

/// Whether the model's tip is inside one of its walls in any cycle.
fn touches(model: &Model, recording: &Recording) -> anyhow::Result<bool> {
    let signals = Signals::new(recording)?;
    let walls: Vec<Wall> = model.contact.walls.iter().map(Wall::new).collect();
    let still = Twist::zero();
    Ok((0..signals.len())
        .filter_map(|n| signals.pose(n))
        .any(|pose| {
            walls
                .iter()
                .any(|wall| wall.penetration(&pose, &still).0 > 0.0)
        }))
}
