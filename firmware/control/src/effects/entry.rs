//! Catalogue entries: what is known about an effect before any data.

/// An effect's catalogue entry.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Effect {
    /// Stable identifier, as used in model files and verdicts.
    pub id: &'static str,
    /// Short name for people.
    pub title: &'static str,
    /// What it does, in one line.
    pub summary: &'static str,
    /// Where in the chain it acts.
    pub group: Group,
    /// What a verdict may say when it fits.
    pub naming: Naming,
    /// The equation, in the symbols of `parameters`.
    pub equation: &'static str,
    /// Where the equation comes from.
    pub source: &'static str,
    /// What it leaves in a recording.
    pub signature: &'static str,
    /// How large it usually is on a rig.
    pub typical: &'static str,
    /// Parameters, units in their names.
    pub parameters: &'static [Parameter],
    /// Ids of effects that leave a similar signature.
    pub confused_with: &'static [&'static str],
    /// The experiment that tells it from those.
    pub tell_apart: &'static str,
}

/// One parameter of an effect.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Parameter {
    /// Name with its SI unit as suffix.
    pub name: &'static str,
    /// SI unit, `-` if it has none.
    pub unit: &'static str,
    /// Smallest plausible value; not negative where physics forbids a negative value.
    pub low: f64,
    /// Largest plausible value.
    pub high: f64,
}

impl Parameter {
    /// A parameter with its unit and plausible range.
    pub const fn new(name: &'static str, unit: &'static str, low: f64, high: f64) -> Self {
        Self {
            name,
            unit,
            low,
            high,
        }
    }

    /// Whether the parameter may have either sign; if not, a negative value is unphysical.
    pub fn is_signed(&self) -> bool {
        self.low < 0.0
    }

    /// Whether `value` lies in the plausible range; NaN does not.
    pub fn is_plausible(&self, value: f64) -> bool {
        value >= self.low && value <= self.high
    }
}

/// Where in the chain from command to force an effect acts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum Group {
    /// From the commanded velocity to the executed one.
    Actuator,
    /// Forces on the moving side.
    Mechanism,
    /// From forces to the wrench as read.
    Sensor,
    /// The simulated spacecraft and the clock of the control cycle.
    Body,
}

impl Group {
    /// All groups, in the order in which a signal meets them.
    pub const ALL: [Self; 4] = [Self::Actuator, Self::Mechanism, Self::Sensor, Self::Body];

    /// Name with a short description.
    pub const fn title(self) -> &'static str {
        match self {
            Self::Actuator => "Actuator: from the commanded velocity to the executed one",
            Self::Mechanism => "Mechanism: forces on the moving side",
            Self::Sensor => "Sensor: from forces to the wrench as read",
            Self::Body => "Body: the simulated spacecraft and the clock of the cycle",
        }
    }
}

/// What a verdict may say when an effect fits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum Naming {
    /// One physical cause: it may be named.
    Cause,
    /// A curve that fits many mechanisms: it may only be reported as "looks like".
    Shape,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_lower_bound_is_the_sign_constraint() {
        let friction = Parameter::new("force_n", "N", 0.0, 50.0);
        let offset = Parameter::new("force_n", "N", -50.0, 50.0);
        assert!(!friction.is_signed() && offset.is_signed());
        assert!(offset.is_plausible(-3.0) && !friction.is_plausible(-3.0));
        assert!(!offset.is_plausible(f64::NAN));
    }
}
