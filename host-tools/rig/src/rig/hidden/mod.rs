//! Effects that a simulated rig hides: its behaviour contains them, its model does not.
//!
//! Each entry names an effect of the catalogue with the catalogue's parameters; the rig computes it
//! with the catalogue's own implementation, on top of what its other settings say.
//!
//! ```toml
//! [[rig.hidden]]
//! id = "guide_coulomb"
//! parameters = { force_n = 1.5 }
//! ```
//!
//! Effects of one group act in the catalogue's order, whatever their order in the file. Actuator
//! effects act on all six axes alike, with m read as rad on A, B and C. Forces of the guide act at
//! M along the free direction of `rig.mechanism.guide`, or along x of C without one; those of the
//! cables in all directions. Effects of the contact act on every wall, those of docking mechanisms on
//! every one.

pub(super) mod effect;
#[cfg(test)]
mod load_tests;
pub mod spacecraft;
mod suggest;
#[cfg(test)]
mod tests;

pub use effect::{Hidden, effect};
pub use suggest::{any, suggest};

use super::settings::RigSettings;
use anyhow::{Context, Result, ensure};
use softdock_control::frames::Wrench;
use softdock_physics::effects::body::clock_jitter::Scatter;
use softdock_physics::effects::sensor::tool::ToolState;
use softdock_physics::effects::{CATALOGUE, Clock, Effect, Group, Law};

/// The hidden effect with this id, if it is among them.
pub(super) fn find<'a>(hidden: &'a [Hidden], id: &str) -> Option<&'a Hidden> {
    hidden.iter().find(|hidden| hidden.id == id)
}

/// Checks each entry, and that the rig has what it acts on.
pub(super) fn validate(settings: &RigSettings) -> Result<()> {
    for (place, hidden) in settings.hidden.iter().enumerate() {
        let section = || format!("in [[rig.hidden]] number {}", place + 1);
        hidden.check().with_context(section)?;
        acts(hidden, settings).with_context(section)?;
        let twice = settings.hidden[..place].iter().any(|h| h.id == hidden.id);
        ensure!(
            !twice,
            "`{}` is in [[rig.hidden]] twice; write one entry with the sum",
            hidden.id
        );
    }
    Ok(())
}

/// Whether an effect is one of contacts.
pub(super) fn acts_at_walls(effect: &Effect) -> bool {
    matches!(effect.law, Law::Push(_) | Law::Depth(_) | Law::Friction(_))
}

/// Whether an effect on the tool changes the reading of this rig; true for other effects.
fn moves_the_reading(hidden: &Hidden, settings: &RigSettings) -> Result<bool> {
    let effect = hidden.effect()?;
    let Law::Tool(law) = effect.law else {
        return Ok(true);
    };
    let sensor = &settings.sensor;
    let mut state = ToolState::hanging(sensor.tool_mass_kg, sensor.tool_com_m);
    state.motion.acceleration = [1.0, 2.0, 3.0].into();
    Ok(law(&effect.values(&hidden.parameters), &state) != Wrench::zero())
}

/// Whether an effect on docking mechanisms changes one of this rig; true for other effects.
fn changes_a_docking(hidden: &Hidden, settings: &RigSettings) -> Result<bool> {
    let effect = hidden.effect()?;
    let Law::Docking(law) = effect.law else {
        return Ok(true);
    };
    let values = effect.values(&hidden.parameters);
    Ok(settings.mechanism.docking.iter().any(|docking| {
        let mut kind = docking.kind;
        law(&values, &mut kind);
        kind != docking.kind
    }))
}

/// Whether the rig has what the effect acts on.
fn acts(hidden: &Hidden, settings: &RigSettings) -> Result<()> {
    let id = hidden.id.as_str();
    ensure!(
        !acts_at_walls(hidden.effect()?) || !settings.mechanism.walls.is_empty(),
        "`{id}` acts in contact, and the rig has no wall; add a [[rig.mechanism.walls]]"
    );
    ensure!(
        changes_a_docking(hidden, settings)?,
        "`{id}` changes nothing of what the rig docks with; it needs a [[rig.mechanism.docking]] that has it"
    );
    ensure!(
        !hidden.effect()?.is_of_a_bearing(),
        "`{id}` acts about a bearing, and the guide of the simulated rig is straight"
    );
    ensure!(
        !hidden.effect()?.is_of_a_drive(),
        "`{id}` acts on the input of a drive, and the simulated rig records a sensor"
    );
    ensure!(
        moves_the_reading(hidden, settings)?,
        "`{id}` needs a tool with weight, and `rig.sensor.tool_mass_kg` is 0"
    );
    // A sum of scattered intervals drifts away from the wrench's clock: that exists only in logs of other machines.
    let scatters = matches!(hidden.effect()?.law, Law::Clock(Clock::Scatter(_)));
    let walks = Scatter::of(&hidden.parameters).is_some_and(|scatter| scatter.of_intervals);
    ensure!(
        !(scatters && walks),
        "`of_intervals` is 1: the clock of the simulated rig keeps its rate; allowed is 0"
    );
    let offset_s = match hidden.effect()?.law {
        Law::ClockOffset(law) => law(&hidden.effect()?.values(&hidden.parameters)),
        _ => 0.0,
    };
    let delay_s = settings.robot.actuator.delay_s;
    ensure!(
        -offset_s <= delay_s,
        "`offset_s` is {offset_s}: the pose would show what is not yet commanded; allowed is {} to 0.1, \
         as `rig.robot.actuator.delay_s` is {delay_s}",
        -delay_s
    );
    Ok(())
}

/// Hidden effects of one group with their values, in the catalogue's order.
pub(super) fn in_order(
    hidden: &[Hidden],
    group: Group,
) -> impl Iterator<Item = (&'static Effect, Vec<f64>)> {
    let of_group = CATALOGUE
        .iter()
        .copied()
        .filter(move |effect| effect.group == group);
    of_group.filter_map(|effect| {
        let hidden = find(hidden, effect.id)?;
        Some((effect, effect.values(&hidden.parameters)))
    })
}
