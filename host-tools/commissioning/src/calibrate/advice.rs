//! Which pose is missing, in words.

use super::equations::Unknowns;
use super::gravity::Gravity;
use super::least_squares::{Determined, determined};
use super::observation::{Group, Observation};
use super::{WORST_CONDITION, source};
use anyhow::{Result, ensure};
use nalgebra::{Matrix3, SymmetricEigen, UnitQuaternion, Vector3};
use softdock_control::frames::Wrench;

/// Smallest turn of the tool about a second axis that shows the direction of gravity, as the sine
/// of an angle (3°).
const LEAST_TURN: f64 = 0.05;
/// Angular acceleration (rad/s²) and acceleration (m/s²) of a brisk jog.
const JOG: [f64; 2] = [2.0, 2.0];

/// Refuses groups that leave a combination of unknowns open.
///
/// # Errors
///
/// What is open, and which pose to add.
pub(super) fn enough(groups: &[Group], unknowns: &Unknowns, gravity: &Gravity) -> Result<()> {
    let direct = Unknowns {
        tilt: false,
        ..*unknowns
    };
    let determined = determined(groups, &direct, gravity);
    if determined.open == 0 {
        return Ok(());
    }
    let found = match groups {
        [] => "no pose at rest was found".to_owned(),
        [one] if one.pose.is_some() => "1 pose at rest was found".to_owned(),
        some if some[0].pose.is_some() => format!("{} poses at rest were found", some.len()),
        _ => "the motion in this recording is not enough".to_owned(),
    };
    anyhow::bail!(
        "{found}, and {}. {}",
        determined.weakest.sentence(),
        best_addition(groups, &direct, gravity)
    )
}

/// Refuses to look for gravity unless the tool was turned about two axes.
///
/// # Errors
///
/// The turns have one axis in C, or none.
pub(super) fn both_tilts(groups: &[Group]) -> Result<()> {
    let orientations: Vec<UnitQuaternion<f64>> = groups
        .iter()
        .flat_map(|g| &g.observations)
        .map(|o| o.c_from_s)
        .collect();
    let turns = orientations.iter().map(|later| {
        let first = orientations[0];
        (later * first.inverse()).imag() * 2.0
    });
    let spread: Matrix3<f64> = turns.map(|t| t * t.transpose()).sum();
    let mut lengths: Vec<f64> = SymmetricEigen::new(spread)
        .eigenvalues
        .iter()
        .map(|e| e.max(0.0).sqrt())
        .collect();
    lengths.sort_by(|a, b| b.total_cmp(a));
    ensure!(
        lengths.get(1).is_some_and(|second| *second > LEAST_TURN),
        "the direction of gravity cannot be found: the tool was turned about one axis of the base \
         only, or not at all. Add a pose that is tilted about another axis of the base, or say \
         --gravity x,y,z"
    );
    Ok(())
}

/// A pose or motion to add: in words, and as the observations that it would give.
struct Addition {
    words: String,
    group: Group,
}

/// The pose or motion that would lower the condition number most; two or three if one is not enough.
pub(super) fn best_addition(groups: &[Group], unknowns: &Unknowns, gravity: &Gravity) -> String {
    let mut all = groups.to_vec();
    let mut words: Vec<String> = Vec::new();
    /// More than three are a plan, not an addition.
    const MOST: usize = 3;
    while words.len() < MOST {
        let judged = candidates(unknowns, gravity).into_iter().map(|addition| {
            let mut with = all.clone();
            with.push(addition.group.clone());
            (worth(&with, unknowns, gravity), addition)
        });
        let Some((worth, best)) = judged.min_by(|a, b| a.0.total_cmp(&b.0)) else {
            break;
        };
        words.push(best.words);
        all.push(best.group);
        if worth < WORST_CONDITION {
            break;
        }
    }
    format!(
        "Add {}; `softdock calibrate sensor --plan` prints a whole set",
        words.join(", and ")
    )
}

/// Condition number, smaller is better. While combinations of unknowns are undetermined, a number beyond any condition that grows
/// with how many they are.
fn worth(groups: &[Group], unknowns: &Unknowns, gravity: &Gravity) -> f64 {
    /// More than any condition.
    const OPEN: f64 = 1e12;
    let determined = determined(groups, unknowns, gravity);
    match determined.open {
        0 => determined.condition,
        open => OPEN * open as f64,
    }
}

fn candidates(unknowns: &Unknowns, gravity: &Gravity) -> Vec<Addition> {
    let axes = [
        ("x", Vector3::x()),
        ("y", Vector3::y()),
        ("z", Vector3::z()),
    ];
    let mut all = Vec::new();
    for (name, axis) in axes {
        for (pointing, sign) in [("down", 1.0), ("up", -1.0)] {
            let words = format!("a pose with the tool's {name} axis vertical, pointing {pointing}");
            all.push(Addition {
                words,
                group: seen(at_rest(&(axis * sign), gravity)),
            });
        }
    }
    if unknowns.inertia {
        for (name, axis) in axes {
            let mut turn = at_rest(&Vector3::z(), gravity);
            turn.angular_acceleration = axis * JOG[0];
            all.push(Addition {
                words: format!("a motion to and fro about the tool's {name} axis"),
                group: seen(turn),
            });
        }
        for (name, axis) in axes {
            let mut push = at_rest(&Vector3::z(), gravity);
            push.acceleration = axis * JOG[1];
            all.push(Addition {
                words: format!("a motion to and fro along the tool's {name} axis"),
                group: seen(push),
            });
        }
    }
    all
}

/// A tool at rest whose direction `down` (axes of S) points to the ground.
fn at_rest(down: &Vector3<f64>, gravity: &Gravity) -> Observation {
    let turn = UnitQuaternion::rotation_between(down, &gravity.vector)
        // Opposite directions: half a turn about anything across.
        .unwrap_or_else(|| {
            let [across, _] = gravity.across();
            UnitQuaternion::from_scaled_axis(across * std::f64::consts::PI)
        });
    Observation::at_rest(turn, Wrench::zero())
}

fn seen(observation: Observation) -> Group {
    Group {
        time_s: [0.0, 0.0],
        pose: None,
        observations: vec![observation],
    }
}

/// What readings in these orientations of M would determine.
pub(super) fn determined_by(
    orientations: &[UnitQuaternion<f64>],
    mounting: &source::Mounting,
    gravity: &Gravity,
) -> Determined {
    let group = |c_from_m: &UnitQuaternion<f64>| {
        let c_from_s = c_from_m * mounting.m_from_s.rotation;
        seen(Observation::at_rest(c_from_s, Wrench::zero()))
    };
    let groups: Vec<Group> = orientations.iter().map(group).collect();
    let at_rest = Unknowns {
        inertia: false,
        tilt: false,
    };
    determined(&groups, &at_rest, gravity)
}

/// The undetermined quantity, in words.
pub(super) fn open_words(determined: &Determined) -> String {
    determined.weakest.sentence()
}
