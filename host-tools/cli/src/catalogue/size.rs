//! How large each effect is in its picture: large enough to be seen.

use softdock_physics::effects::{Effect, Parameter};

/// The size of one effect in its picture.
#[derive(Clone, Copy, Debug)]
pub(super) struct Size {
    parameters: &'static [Parameter],
}

impl Size {
    /// The size of this effect.
    pub(super) fn of(effect: &Effect) -> Self {
        Self {
            parameters: effect.parameters,
        }
    }

    /// The values of all parameters, in the effect's order. A parameter without a pictured value has its default.
    pub(super) fn values(&self) -> Vec<f64> {
        let value = |p: &Parameter| match p.pictured {
            0.0 => p.default(),
            pictured => pictured,
        };
        self.parameters.iter().map(value).collect()
    }

    /// The size in words, as `pause_s = 0.03`.
    pub(super) fn describe(&self) -> String {
        let pictured = self.parameters.iter().filter(|p| p.pictured != 0.0);
        let values: Vec<String> = pictured
            .map(|p| format!("{} = {}", p.name, p.pictured))
            .collect();
        values.join(", ")
    }
}

#[cfg(test)]
mod tests {
    use softdock_physics::effects::CATALOGUE;

    #[test]
    fn every_effect_has_a_plausible_size() {
        for effect in CATALOGUE {
            let pictured = effect.parameters.iter().filter(|p| p.pictured != 0.0);
            let plausible = pictured.map(|p| p.is_plausible(p.pictured));
            let each: Vec<bool> = plausible.collect();
            assert!(!each.is_empty() && each.iter().all(|p| *p), "{}", effect.id);
        }
    }
}
