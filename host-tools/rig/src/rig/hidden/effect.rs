//! An effect that a rig hides, as a scenario names it.

use anyhow::{Result, bail, ensure};
use serde::{Deserialize, Serialize};
use softdock_io::input::nearest;
use softdock_physics::effects::{Effect, Parameter, named};
use std::collections::BTreeMap;

/// One hidden effect.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Hidden {
    /// Its id in the catalogue.
    pub id: String,
    /// Its parameters by the catalogue's names, SI; one that is left out is 0.
    pub parameters: BTreeMap<String, f64>,
}

impl Hidden {
    /// Its entry in the catalogue.
    ///
    /// # Errors
    /// There is no such effect; the error offers the nearest id.
    pub fn effect(&self) -> Result<&'static Effect> {
        effect(&self.id)
    }

    /// Checks id, parameter names and values against the catalogue.
    pub(super) fn check(&self) -> Result<()> {
        let effect = self.effect()?;
        for (name, value) in &self.parameters {
            let known = effect.parameters.iter().find(|p| p.name == name);
            let Some(parameter) = known else {
                bail!("{}", unknown_parameter(effect, name));
            };
            ensure!(
                parameter.is_plausible(*value),
                "`{name}` is {value}; allowed is {} to {}",
                parameter.low,
                parameter.high
            );
        }
        let given = |p: &Parameter| self.parameters.get(p.name).copied().unwrap_or(p.default());
        for parameter in effect.parameters {
            ensure!(
                parameter.is_plausible(given(parameter)),
                "`{}` is missing; allowed is {} to {}",
                parameter.name,
                parameter.low,
                parameter.high
            );
        }
        Ok(())
    }
}

/// The effect of the catalogue with this id.
///
/// # Errors
/// There is none; the error offers the nearest id.
pub fn effect(id: &str) -> Result<&'static Effect> {
    named(id)
}

fn unknown_parameter(effect: &Effect, name: &str) -> String {
    let names: Vec<&str> = effect.parameters.iter().map(|p| p.name).collect();
    let what = format!("`{}` has no parameter `{name}`", effect.id);
    match nearest(name, names.iter().copied()) {
        Some(near) => format!("{what}; did you mean `{near}`?"),
        None => format!("{what}; it has {}", names.join(", ")),
    }
}
