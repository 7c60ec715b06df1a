//! Quantities of a recording that an error may depend on.

use super::Quantity;
use crate::compare::motion::Motion;
use crate::compare::{Phase, Source};
use softdock_physics::model::{Axis, Channel};
use softdock_statistics::{Groups, median};
use std::ops::Range;

/// Loads below this multiple of the sensor's noise are none.
const LOADED: f64 = 10.0;
/// Number of equal parts into which the time of a recording is divided.
const TIMES: usize = 8;
/// Longest time after the beginning of a contact, s.
const AFTER_CONTACT_S: f64 = 1.0;

/// A quantity, with the cycles of the recording grouped by it.
#[derive(Clone, Debug)]
pub(super) struct Candidate {
    pub(super) quantity: Quantity,
    pub(super) along: Option<Axis>,
    pub(super) unit: &'static str,
    pub(super) in_contact: bool,
    /// Sorted by the size of the quantity, without its sign.
    pub(super) absolute: bool,
    pub(super) groups: Groups,
}

/// All quantities that take different values in this recording.
pub(super) fn all(
    source: &Source<'_>,
    motion: &Motion,
    contacts: &[Range<usize>],
) -> Vec<Candidate> {
    let mut quantities = Vec::new();
    for axis in Axis::ALL {
        quantities.extend(of_axis(source, motion, axis));
    }
    let touching = touching(source.signals.len(), contacts);
    let mut found = Vec::new();
    for (quantity, axis, values) in quantities {
        found.extend(variants(quantity, axis, values, &touching));
    }
    let time = source.prediction.time_s.clone();
    let since = since_contact(source.signals.len(), source.signals.cycle_s, contacts);
    let since = Groups::along(since).map(Groups::with_others);
    let times = [
        (Quantity::TimeInRun, Groups::equal(time, TIMES)),
        (Quantity::TimeSinceContact, since),
    ];
    for (quantity, groups) in times {
        found.extend(groups.map(|groups| Candidate {
            quantity,
            along: None,
            unit: "s",
            in_contact: false,
            absolute: false,
            groups,
        }));
    }
    found
}

/// Variants of a quantity of an axis: over the whole recording, in contact only, and by its size where it takes both signs.
fn variants(
    quantity: Quantity,
    axis: Axis,
    values: Vec<f64>,
    touching: &[bool],
) -> impl Iterator<Item = Candidate> {
    let size: Vec<f64> = values.iter().map(|v| v.abs()).collect();
    let touched: Vec<f64> = values
        .iter()
        .zip(touching)
        .map(|(v, touching)| if *touching { *v } else { f64::NAN })
        .collect();
    let both_signs = values.iter().any(|v| *v < 0.0) && values.iter().any(|v| *v > 0.0);
    let has_size = both_signs && quantity.has_size();
    let variants = [
        (Groups::along(values), false, false),
        (Groups::along(touched).map(Groups::with_others), true, false),
        (Groups::along(size).filter(|_| has_size), false, true),
    ];
    variants
        .into_iter()
        .filter_map(move |(groups, in_contact, absolute)| {
            Some(Candidate {
                quantity,
                along: Some(axis),
                unit: unit(quantity, axis),
                in_contact,
                absolute,
                groups: groups?,
            })
        })
}

/// Quantities along, or about, one axis.
fn of_axis(source: &Source<'_>, motion: &Motion, axis: Axis) -> Vec<(Quantity, Axis, Vec<f64>)> {
    let i = axis.index();
    let mut found = Vec::new();
    if motion.moves[i] {
        let place = if axis.is_rotation() {
            Quantity::Orientation
        } else {
            Quantity::Position
        };
        let of = |values: &[[f64; 6]]| values.iter().map(|v| v[i]).collect();
        found.push((Quantity::Velocity, axis, of(&motion.velocity)));
        found.push((place, axis, of(&motion.position)));
        found.push((Quantity::Acceleration, axis, of(&motion.acceleration)));
    }
    let load = load(source, motion, i);
    let largest = load.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
    let sigma = source.prediction.channel(Channel::Wrench).sigma[i];
    if largest > LOADED * sigma {
        found.push((Quantity::Force, axis, load));
    }
    found
}

/// Load beyond its median in free flight.
fn load(source: &Source<'_>, motion: &Motion, axis: usize) -> Vec<f64> {
    let free = motion.load.iter().zip(source.phases);
    let mut free: Vec<f64> = free
        .filter(|(load, phase)| **phase == Phase::FreeFlight && load[axis].is_finite())
        .map(|(load, _)| load[axis])
        .collect();
    let rest = median(&mut free).unwrap_or(0.0);
    motion.load.iter().map(|w| w[axis] - rest).collect()
}

fn unit(quantity: Quantity, axis: Axis) -> &'static str {
    match (quantity, axis.is_rotation()) {
        (Quantity::Velocity, false) => "m/s",
        (Quantity::Velocity, true) => "rad/s",
        (Quantity::Acceleration, false) => "m/s²",
        (Quantity::Acceleration, true) => "rad/s²",
        (Quantity::Force, false) => "N",
        (Quantity::Force, true) => "N·m",
        (Quantity::Position, _) => "m",
        (Quantity::Orientation, _) => "rad",
        (Quantity::TimeInRun | Quantity::TimeSinceContact, _) => "s",
        (Quantity::Frequency, _) => "Hz",
    }
}

fn touching(cycles: usize, contacts: &[Range<usize>]) -> Vec<bool> {
    let mut touching = vec![false; cycles];
    for contact in contacts {
        if let Some(part) = touching.get_mut(contact.clone()) {
            part.fill(true);
        }
    }
    touching
}

fn since_contact(cycles: usize, cycle_s: f64, contacts: &[Range<usize>]) -> Vec<f64> {
    let mut since = vec![f64::NAN; cycles];
    for contact in contacts {
        for (n, value) in since.iter_mut().enumerate().skip(contact.start) {
            let after = (n - contact.start) as f64 * cycle_s;
            *value = if after <= AFTER_CONTACT_S {
                after
            } else {
                f64::NAN
            };
        }
    }
    since
}
