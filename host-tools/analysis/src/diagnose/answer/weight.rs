//! Notes on a named weight about a bearing, which may be none: that of an upright axis, and one without an inertia.

use super::notes::Answer;
use crate::diagnose::named::NamedEffect;
use crate::diagnose::wrench::{Fitted, TestedHypothesis};
use softdock_physics::effects::Effect;
use softdock_report::number;
use softdock_statistics::DEVIATIONS_95;

impl Answer<'_> {
    /// Note that a weight is named of which these logs exclude the inertia. A weight m g l has an inertia of at least m l², so that it
    /// swings like a pendulum of length l or longer.
    pub(super) fn without_inertia(&self) -> Option<String> {
        /// Shortest pendulum that a machine has, m. Set by hand.
        const SHORTEST_M: f64 = 5e-3;
        const STANDARD_GRAVITY_M_S2: f64 = 9.80665;
        const INERTIA: &str = "kg·m²";
        let weight = self.weight()?;
        let has_inertia = self.model.inertia_about_bearing() > 0.0;
        let wrench = self.stages.wrench.as_ref().filter(|_| !has_inertia)?;
        let is_inertia = |one: &&Fitted| {
            let mut units = one.parameters.values().map(|p| p.unit);
            units.len() > 0 && units.all(|unit| unit == INERTIA)
        };
        let named = self.reduction.named.iter();
        let mut named = named.flat_map(|(named, _)| named.estimates.values());
        if named.any(|estimate| estimate.unit == INERTIA) {
            return None;
        }
        let has_weight = |t: &&TestedHypothesis| t.ids().contains(&weight.effect.id);
        let mut tried = wrench.found.ranked.iter().filter(has_weight);
        let inertia = tried.find_map(|t| t.effects.iter().find(is_inertia))?;
        let largest = inertia
            .parameters
            .values()
            .map(|p| p.value + DEVIATIONS_95 * p.sigma);
        let largest = largest.fold(0.0, f64::max);
        let torques = weight
            .estimates
            .values()
            .filter(|estimate| estimate.unit == "N·m");
        let torque = torques
            .map(|estimate| estimate.value.powi(2))
            .sum::<f64>()
            .sqrt();
        let length_m = largest * STANDARD_GRAVITY_M_S2 / torque;
        (length_m < SHORTEST_M).then(|| {
            format!(
                "{} is named, and these logs allow a moment of inertia of {} kg·m² beside it at most: a weight of {} N·m would swing like a pendulum of {} \
                 mm. If a controller makes the torque from the position, or something else moves the axis, these logs do not tell what the axis weighs.",
                weight.effect.id,
                number::significant(largest, 2),
                number::significant(torque, 2),
                number::significant(1e3 * length_m, 2),
            )
        })
    }

    /// The weight about the bearing that is named.
    fn weight(&self) -> Option<&NamedEffect> {
        let mut named = self.reduction.named.iter().map(|(named, _)| named);
        named.find(|named| {
            let effect = self.model.effect(&named.effect.id);
            effect.is_ok_and(Effect::is_weight_about_bearing)
        })
    }

    /// Note that a weight is named although the model has no gravity: an upright axis would have none.
    pub(super) fn without_gravity(&self) -> Option<String> {
        let axis = self.model.bearing()?;
        let weight = self.weight()?;
        (self.model.sensor.gravity_m_s2 == [0.0; 3]).then(|| {
            format!(
                "{} is named, and the model has no gravity. If {axis} stands upright, say so and nothing is lifted: gravity_m_s2 of [sensor] \
                 along it.",
                weight.effect.id
            )
        })
    }
}
