//! Physical effects of docking rigs, one file each.
//!
//! An effect is defined once: its law, its parameters with units and plausible ranges, the forms that a search tries, its
//! signature in a recording, its usual size, the effects with which it is confused and the experiment that distinguishes them,
//! the sizes that a simulated rig hides and a picture shows, and a known answer. The simulated rig, the prediction, the fit, the
//! diagnosis and the help page all use that one file. A new effect is a new file and a line in [`CATALOGUE`].
//!
//! [`law`] defines the arguments and the result of each kind of law. The effects of the actuator pass on a velocity per axis, as
//! its *mean over one step*: the position is then exactly the sum of step times velocity, whatever happens within a step.

pub mod actuator;
pub mod body;
mod entry;
mod find;
pub mod formula;
pub mod law;
pub mod mechanism;
pub mod sensor;
mod units;

pub use entry::{
    Difference, Draw, Effect, Group, IsWhole, Kind, Naming, Parameter, Role, SearchStart,
};
pub use find::hint;
pub use find::named;
pub use law::{
    Actuator, Clock, DelayAndLag, DelayLine, Direction, Facing, Guide, Law, Penetration, Reversal,
    Sampling, Slide, Values, sign,
};

use softdock_control::range::{SettingsError, in_range};

/// All effects, group by group, in the order in which a signal meets them.
pub const CATALOGUE: &[&Effect] = &[
    &actuator::command_quantisation::EFFECT,
    &actuator::command_deadzone::EFFECT,
    &actuator::gain_by_direction::EFFECT,
    &actuator::actuation_delay::EFFECT,
    &actuator::actuation_lag::EFFECT,
    &actuator::second_order_servo::EFFECT,
    &actuator::structural_resonance::EFFECT,
    &actuator::zero_cross_pause::EFFECT,
    &actuator::rate_limit::EFFECT,
    &actuator::jerk_limit::EFFECT,
    &actuator::velocity_saturation::EFFECT,
    &actuator::velocity_gain::EFFECT,
    &actuator::backlash::EFFECT,
    &mechanism::guide_coulomb::EFFECT,
    &mechanism::guide_viscous::EFFECT,
    &mechanism::guide_stribeck::EFFECT,
    &mechanism::guide_asymmetry::EFFECT,
    &mechanism::guide_offset::EFFECT,
    &mechanism::guide_hysteresis::EFFECT,
    &mechanism::wall_position::EFFECT,
    &mechanism::contact_deadzone::EFFECT,
    &mechanism::contact_stiffness::EFFECT,
    &mechanism::contact_cubic::EFFECT,
    &mechanism::contact_damping::EFFECT,
    &mechanism::hunt_crossley::EFFECT,
    &mechanism::contact_coulomb::EFFECT,
    &mechanism::contact_preload::EFFECT,
    &mechanism::contact_second_stage::EFFECT,
    &mechanism::contact_hertz::EFFECT,
    &mechanism::contact_eddy_current::EFFECT,
    &mechanism::docking_friction::EFFECT,
    &mechanism::docking_stiffness::EFFECT,
    &mechanism::docking_preload::EFFECT,
    &mechanism::docking_leg::EFFECT,
    &mechanism::docking_latch_play::EFFECT,
    &mechanism::docking_latch_slip::EFFECT,
    &mechanism::cable_stiffness::EFFECT,
    &mechanism::manipulator_resistance::EFFECT,
    &mechanism::bearing_gravity::EFFECT,
    &mechanism::bearing_inertia::EFFECT,
    &sensor::base_tilt::EFFECT,
    &sensor::tool_mass_error::EFFECT,
    &sensor::tool_com_error::EFFECT,
    &sensor::tool_inertia::EFFECT,
    &sensor::ft_mounting::EFFECT,
    &sensor::ft_crosstalk::EFFECT,
    &sensor::ft_scale::EFFECT,
    &sensor::ft_bias::EFFECT,
    &sensor::ft_bias_drift::EFFECT,
    &sensor::ft_low_pass::EFFECT,
    &sensor::ft_saturation::EFFECT,
    &sensor::ft_quantisation::EFFECT,
    &sensor::ft_dropout::EFFECT,
    &sensor::ft_latency::EFFECT,
    &sensor::input_gain::EFFECT,
    &body::sc_mass_error::EFFECT,
    &body::sc_inertia_error::EFFECT,
    &body::clock_jitter::EFFECT,
    &body::clock_offset::EFFECT,
    &body::clock_rate::EFFECT,
];

/// The effect with this id.
pub fn by_id(id: &str) -> Option<&'static Effect> {
    CATALOGUE.iter().copied().find(|effect| effect.id == id)
}

/// Checks the step of a discretised effect: a microsecond to a second.
pub fn check_step(step_s: f64) -> Result<(), SettingsError> {
    in_range("step_s", step_s, 1e-6, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_entry_is_complete() {
        for effect in CATALOGUE {
            let texts = [
                effect.id,
                effect.title,
                effect.summary,
                effect.equation,
                effect.source,
                effect.signature,
                effect.typical,
                effect.tell_apart,
            ];
            for text in texts {
                assert!(!text.is_empty(), "{}", effect.id);
            }
            assert!(effect.summary.len() <= 90, "{} is one line", effect.id);
            assert!(!effect.parameters.is_empty(), "{}", effect.id);
            for p in effect.parameters {
                assert!(p.low < p.high, "{} {}", effect.id, p.name);
            }
            // An entry without a law of its own has one that does nothing.
            let does_nothing = matches!(effect.law, Law::ClockOffset(law) if law(&[1.0]) == 0.0);
            assert!(!does_nothing, "{} has no law", effect.id);
        }
    }

    /// These effects cannot be seen in a log without measured positions.
    #[test]
    fn springs_and_weights_act_by_position_and_friction_does_not() {
        let by_position = CATALOGUE
            .iter()
            .filter(|effect| effect.acts_by_position(false));
        let ids: Vec<&str> = by_position.map(|effect| effect.id).collect();
        assert_eq!(ids, ["cable_stiffness", "bearing_gravity"]);
    }

    #[test]
    fn ids_are_unique_and_found() {
        for effect in CATALOGUE {
            assert_eq!(by_id(effect.id), Some(*effect)); // the first of two equal ids would differ
        }
        assert_eq!(by_id("guide_colomb"), None);
    }

    #[test]
    fn parameter_names_are_unique_within_an_effect() {
        for effect in CATALOGUE {
            for (i, p) in effect.parameters.iter().enumerate() {
                let same_name = effect.parameters.iter().filter(|q| q.name == p.name);
                assert_eq!(same_name.count(), 1, "{} {} {i}", effect.id, p.name);
            }
        }
    }

    #[test]
    fn effects_are_confused_with_others_of_the_catalogue() {
        for effect in CATALOGUE {
            assert!(!effect.confused_with.is_empty(), "{}", effect.id);
            for id in effect.confused_with {
                assert!(by_id(id).is_some(), "{} names {id}", effect.id);
                assert_ne!(*id, effect.id);
            }
        }
    }

    #[test]
    fn groups_follow_the_signal() {
        let place = |effect: &Effect| Group::ALL.iter().position(|g| *g == effect.group);
        assert!(CATALOGUE.is_sorted_by_key(|effect| place(effect)));
    }

    #[test]
    fn a_step_that_is_not_a_number_is_refused() {
        assert!(check_step(f64::NAN).is_err() && check_step(0.004).is_ok());
    }
}
