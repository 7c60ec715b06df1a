//! Physical effects of docking rigs, one file each.
//!
//! An effect is written once and serves four users: the board's predictor, the simulated rig, the
//! comparison of recording and model, and the fit. Each file holds
//! - the equation and its source,
//! - its parameters with units, and the range in which a rig's value plausibly lies,
//! - the signature that the effect leaves in a recording,
//! - a known answer to test it against,
//!
//! and adds one line to [`CATALOGUE`].
//!
//! **Signals.** Between actuator effects runs a velocity per axis, as its *mean over one step*:
//! then position is the sum of step times velocity without error, whatever happens inside a step.
//! Parameters enter as `f64` and are turned into coefficients once, so that the step itself needs
//! only additions, multiplications and comparisons of the scalar `S`.

pub mod actuator;
pub mod mechanism;
pub mod sensor;

/// What is known about an effect before any data: the text of its catalogue entry.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Effect {
    /// Stable identifier, as used in model files and verdicts.
    pub id: &'static str,
    /// The equation, in the symbols of `parameters`.
    pub equation: &'static str,
    /// Where the equation comes from.
    pub source: &'static str,
    /// What it leaves in a recording, and what tells it from its neighbours.
    pub signature: &'static str,
    /// Parameters, units in their names.
    pub parameters: &'static [Parameter],
}

/// One parameter of an effect.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameter {
    /// Name with its SI unit as suffix.
    pub name: &'static str,
    /// SI unit, `-` if it has none.
    pub unit: &'static str,
    /// Smallest plausible value; its sign is the sign constraint.
    pub low: f64,
    /// Largest plausible value.
    pub high: f64,
}

/// All effects, in the order in which a signal meets them.
pub const CATALOGUE: &[&Effect] = &[
    &actuator::transport_delay::EFFECT,
    &actuator::first_order_lag::EFFECT,
    &actuator::second_order_servo::EFFECT,
    &actuator::zero_crossing_pause::EFFECT,
    &actuator::rate_limit::EFFECT,
    &actuator::velocity_saturation::EFFECT,
    &mechanism::plane_contact::EFFECT,
    &mechanism::coulomb_friction::EFFECT,
    &sensor::tool_gravity::EFFECT,
    &sensor::tool_inertia::EFFECT,
    &sensor::bias_drift::EFFECT,
    &sensor::low_pass::EFFECT,
    &sensor::gauge_quantisation::EFFECT,
];

/// A parameter outside the range in which its equation holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OutOfRange {
    /// Name with unit.
    pub parameter: &'static str,
    /// The value that came.
    pub value: f64,
    /// Smallest allowed value.
    pub low: f64,
    /// Largest allowed value.
    pub high: f64,
}

impl core::fmt::Display for OutOfRange {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let Self {
            parameter,
            value,
            low,
            high,
        } = self;
        write!(f, "{parameter} = {value}: allowed is {low} to {high}")
    }
}

impl core::error::Error for OutOfRange {}

/// `value` if it lies in `low..=high`; NaN never does.
pub(crate) fn in_range(
    parameter: &'static str,
    value: f64,
    low: f64,
    high: f64,
) -> Result<f64, OutOfRange> {
    if value >= low && value <= high {
        Ok(value)
    } else {
        Err(OutOfRange {
            parameter,
            value,
            low,
            high,
        })
    }
}

/// Longest step (s) that any effect accepts; the shortest is a microsecond.
const LONGEST_STEP_S: f64 = 1.0;

/// The step of a discretised effect, checked.
pub(crate) fn step_in_range(step_s: f64) -> Result<f64, OutOfRange> {
    in_range("step_s", step_s, 1e-6, LONGEST_STEP_S)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_entry_is_complete_and_its_id_unique() {
        for (i, effect) in CATALOGUE.iter().enumerate() {
            assert!(
                CATALOGUE
                    .iter()
                    .skip(i + 1)
                    .all(|other| other.id != effect.id),
                "{}",
                effect.id
            );
            for text in [effect.id, effect.equation, effect.source, effect.signature] {
                assert!(!text.is_empty(), "{}", effect.id);
            }
            assert!(!effect.parameters.is_empty(), "{}", effect.id);
            for p in effect.parameters {
                assert!(p.low < p.high, "{} {}", effect.id, p.name);
            }
        }
    }

    #[test]
    fn a_value_that_is_not_a_number_is_out_of_range() {
        assert!(in_range("x", f64::NAN, 0.0, 1.0).is_err());
        let error = in_range("mass_kg", -1.0, 0.0, 9.0).unwrap_err();
        assert_eq!(error.to_string(), "mass_kg = -1: allowed is 0 to 9");
    }
}
