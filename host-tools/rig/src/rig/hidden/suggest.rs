//! Plausible sizes of hidden effects: possible on a rig, and large enough for a diagnosis to find.

use super::{Hidden, effect, spacecraft};
use crate::rig::RigSettings;
use anyhow::{Context, Result};
use softdock_physics::effects::{CATALOGUE, Draw};
use softdock_statistics::RandomStream;

/// The stream of random numbers that sizes are drawn from; the rig's own begin at 0.
const STREAM: u64 = 100;
/// The stream that the choice of an effect is drawn from.
const CHOICE: u64 = 99;

/// An effect of a plausible size; the same seed draws the same.
///
/// # Errors
/// There is no such effect; the error offers the nearest id.
pub fn suggest(id: &str, seed: u64) -> Result<Hidden> {
    let effect = effect(id)?;
    let hideable = CATALOGUE.iter().filter(|e| !e.is_of_a_bearing());
    let mut hideable = hideable.filter(|e| !e.is_of_a_docking());
    let place = hideable.position(|known| *known == effect);
    let mut noise = RandomStream::new(seed, STREAM + place.unwrap_or(0) as u64);
    let parameters = effect.parameters.iter().filter_map(|parameter| {
        let value = drawn(&parameter.hidden?, &mut noise);
        Some((parameter.name.to_owned(), value))
    });
    Ok(Hidden {
        id: id.to_owned(),
        parameters: parameters.collect(),
    })
}

/// One of all effects that a rig with these settings can hide by itself, of a plausible size; the same seed draws the
/// same.
///
/// # Errors
/// There is none.
pub fn any(settings: &RigSettings, seed: u64) -> Result<Hidden> {
    let possible = |hidden: &Hidden| {
        let mut with = settings.clone();
        with.hidden.push(hidden.clone());
        !hidden.parameters.is_empty() && !spacecraft::concerns(hidden) && with.validate().is_ok()
    };
    let all = CATALOGUE.iter().filter_map(|e| suggest(e.id, seed).ok());
    let mut all: Vec<Hidden> = all.filter(possible).collect();
    let place = (RandomStream::new(seed, CHOICE).uniform() * all.len() as f64).ceil() as usize;
    let place = place.checked_sub(1).context("this rig can hide nothing")?;
    Ok(all.swap_remove(place))
}

fn drawn(draw: &Draw, noise: &mut RandomStream) -> f64 {
    let value = draw.low + (draw.high - draw.low) * noise.uniform();
    let value = if draw.step > 0.0 {
        (value / draw.step).round() * draw.step
    } else {
        value
    };
    // Sizes are told to people: three digits are enough.
    let value = format!("{value:.2e}").parse().unwrap_or(value);
    if draw.signed && noise.uniform() > 0.5 {
        -value
    } else {
        value
    }
}
