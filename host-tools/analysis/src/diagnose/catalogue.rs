//! Questions about entries of the catalogue that a search has to answer.

use softdock_physics::effects::{Naming, by_id};
use softdock_physics::model::Model;
use softdock_physics::model::load::effects::LoadEffect;

/// Whether an effect is in the model already.
pub(crate) fn has(model: &Model, id: &str) -> bool {
    model.effects.iter().any(|e| e.id == id)
}

/// The effect with one amount that is of the same kind as an effect which may be simpler. `None` if `id` may not be simpler, or
/// there is no such effect.
pub(crate) fn simplest(model: &Model, id: &str) -> Option<&'static str> {
    let effect = LoadEffect::find(model, id).filter(|effect| effect.may_be_simpler())?;
    let kind = effect.effect.kind?;
    let mut alike = LoadEffect::all(model).filter(|other| other.effect.kind == Some(kind));
    let simple =
        alike.find(|other| other.coefficients.len() == 1 && !is_general_curve(other.id))?;
    Some(simple.id)
}

/// Whether an effect is a mass or an inertia in addition to that of the model's tool.
pub(crate) fn is_of_the_tool(id: &str) -> bool {
    by_id(id).is_some_and(|e| e.parameters.iter().any(|p| p.of_the_tool != 0.0))
}

/// Whether a catalogue entry is a curve that fits many mechanisms, and therefore no name.
pub(crate) fn is_general_curve(id: &str) -> bool {
    by_id(id).is_some_and(|e| e.naming == Naming::Shape)
}
