//! Effects that the model file names already, on top of the nominal reading.

use super::LoadEffect;
use crate::model::EffectModel;
use crate::model::load::Scene;

/// Adds what effects of a model file do to the reading of a scene. What acts on the reading as a
/// whole (a delay, a gain) acts last, on all that loads the sensor, wherever it stands in the file.
pub(crate) fn add_known(scene: &mut Scene, effects: &[EffectModel]) {
    let known: Vec<(&EffectModel, &LoadEffect)> = effects
        .iter()
        .filter_map(|effect| Some((effect, LoadEffect::find(&effect.id)?)))
        .collect();
    for on_reading in [false, true] {
        for (effect, law) in &known {
            if law.acts_on_reading() == on_reading {
                let part = law.contribution(scene, &effect.parameters);
                scene.reading.add(&part);
            }
        }
    }
}
