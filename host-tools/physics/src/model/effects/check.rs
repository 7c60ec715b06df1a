//! Which effects and parameters a model file may hold.

use super::{Allowed, EffectError, EffectModel, allowed_parameters};
use crate::effects::Group;
use crate::model::Model;
use crate::model::stage::Stage;
use softdock_io::input::nearest;

impl EffectModel {
    /// Checks all effects of a model file.
    pub(in crate::model) fn validate_all(model: &Model) -> Result<(), EffectError> {
        let effects = &model.effects;
        for (k, effect) in effects.iter().enumerate() {
            effect.validate(model)?;
            if effects[..k].iter().any(|other| other.id == effect.id) {
                return Err(EffectError::Twice {
                    id: effect.id.clone(),
                });
            }
        }
        Ok(())
    }

    /// Checks id, axes, parameters and intervals; `model` provides the hypotheses in addition to the catalogue.
    ///
    /// # Errors
    ///
    /// The first thing that does not fit, with what is allowed.
    pub fn validate(&self, model: &Model) -> Result<(), EffectError> {
        let effect = model.effect(&self.id)?;
        let id = || self.id.clone();
        if effect.is_of_a_bearing() && model.bearing().is_none() {
            return Err(EffectError::NoBearing { id: id() });
        }
        if !self.axes.is_empty() && effect.group != Group::Actuator {
            return Err(EffectError::Axes { id: id() });
        }
        let allowed = allowed_parameters(model, effect);
        for (name, value) in &self.parameters {
            self.validate_parameter(name, *value, &allowed)?;
        }
        let missing = |p: &&Allowed| {
            let given = self.parameters.contains_key(p.name) || p.holds(p.default);
            !given && !self.is_of_one_kind_of_axis()
        };
        if let Some(p) = allowed.iter().find(missing) {
            return Err(EffectError::MissingParameter {
                id: id(),
                name: p.name,
                low: p.low,
                high: p.high,
            });
        }
        for (name, [low, high]) in &self.interval_95 {
            let ordered = low <= high; // not so for NaN
            if !ordered || !self.parameters.contains_key(name) {
                return Err(EffectError::Interval {
                    id: id(),
                    name: name.clone(),
                    low: *low,
                    high: *high,
                });
            }
        }
        Ok(())
    }

    /// Whether all parameters of one kind of axis (translations or rotations) are given: an effect with different parameters for
    /// both needs only those of one.
    fn is_of_one_kind_of_axis(&self) -> bool {
        let has = |stage: Stage, rotation| {
            let mut names = stage.parameters(rotation).iter();
            names.all(|(name, _)| self.parameters.contains_key(*name))
        };
        Stage::of(&self.id, &self.parameters).is_some_and(|stage| {
            stage.has_units_of_its_axes() && (has(stage, true) || has(stage, false))
        })
    }

    fn validate_parameter(
        &self,
        name: &str,
        value: f64,
        allowed: &[Allowed],
    ) -> Result<(), EffectError> {
        let Some(known) = allowed.iter().find(|p| p.name == name) else {
            let names: Vec<&str> = allowed.iter().map(|p| p.name).collect();
            let list = format!("allowed are: {}", names.join(", "));
            return Err(EffectError::UnknownParameter {
                id: self.id.clone(),
                name: name.to_owned(),
                hint: match nearest(name, names) {
                    Some(near) => format!("did you mean `{near}`? {list}"),
                    None => list,
                },
            });
        };
        if known.holds(value) {
            return Ok(());
        }
        Err(EffectError::OutOfRange {
            id: self.id.clone(),
            name: name.to_owned(),
            received: value,
            low: known.low,
            high: known.high,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::load::effects::LoadEffect;

    fn effect(id: &str, parameters: &[(&str, f64)]) -> EffectModel {
        EffectModel {
            id: id.to_owned(),
            parameters: parameters
                .iter()
                .map(|(name, value)| ((*name).to_owned(), *value))
                .collect(),
            ..EffectModel::default()
        }
    }

    fn refused(id: &str, parameters: &[(&str, f64)]) -> String {
        match effect(id, parameters).validate(&Model::default()) {
            Ok(()) => "nothing".to_owned(),
            Err(error) => error.to_string(),
        }
    }

    #[test]
    fn every_choice_of_every_form_is_allowed() {
        for stage in Stage::ALL {
            let mut model = effect(stage.id(), &[]);
            let entry = Model::default().effect(stage.id()).expect("catalogued");
            for p in entry.parameters {
                model.parameters.insert(p.name.to_owned(), p.high);
            }
            for name in stage.form() {
                model.parameters.insert((*name).to_owned(), 1.0);
            }
            assert_eq!(model.validate(&Model::default()), Ok(()));
        }
        for load in LoadEffect::all(&Model::default()) {
            for shape in &load.shapes {
                for value in shape.tried {
                    let model = effect(load.id, &[(shape.name, *value)]);
                    assert_eq!(
                        model.validate(&Model::default()),
                        Ok(()),
                        "{} {value}",
                        shape.name
                    );
                }
            }
        }
    }

    #[test]
    fn a_mistake_gets_a_suggestion() {
        let said = refused("guide_colomb", &[("force_n", 1.0)]);
        assert!(said.contains("did you mean `guide_coulomb`?"), "{said}");
        let said = refused("guide_coulomb", &[("force_kn", 1.0)]);
        assert!(said.contains("did you mean `force_n`?"), "{said}");
        assert!(said.contains("force_n, smoothing_speed_m_s"), "{said}");
    }

    #[test]
    fn a_value_that_no_rig_has_is_refused() {
        let said = refused("guide_coulomb", &[("force_n", -1.0)]);
        assert!(
            said.contains("`force_n` is -1; allowed is 0 to 10000"),
            "{said}"
        );
        for wrong in [f64::NAN, f64::INFINITY] {
            assert!(refused("guide_coulomb", &[("force_n", wrong)]).contains("allowed"));
        }
        let said = refused("rate_limit", &[]);
        assert!(
            said.contains("`max_acceleration_m_s2` is missing"),
            "{said}"
        );
        assert_eq!(refused("ft_bias", &[("fx_n", -0.5)]), "nothing");
    }

    #[test]
    fn a_limit_may_be_given_for_translations_for_rotations_or_for_both() {
        let (linear, angular) = ("max_acceleration_m_s2", "max_acceleration_rad_s2");
        for given in [
            &[(linear, 1.0)][..],
            &[(angular, 1.0)],
            &[(linear, 1.0), (angular, 2.0)],
        ] {
            assert_eq!(refused("rate_limit", given), "nothing", "{given:?}");
        }
        // A joint's jerk, six degrees of play, a command in whole rpm.
        for (id, name, value, linear) in [
            ("jerk_limit", "max_jerk_rad_s3", 12_500.0, "max_jerk_m_s3"),
            ("backlash", "width_rad", 0.1, "width_m"),
            ("command_quantisation", "step_rad_s", 0.105, "step_m_s"),
        ] {
            assert_eq!(refused(id, &[(name, value)]), "nothing");
            assert!(refused(id, &[(linear, value)]).contains("allowed is"));
        }
        let said = refused("rate_limit", &[(angular, 1e9)]);
        assert!(said.contains("allowed is 0.001 to 1000"), "{said}");
    }

    #[test]
    fn twice_the_same_and_misplaced_axes_and_intervals_are_refused() {
        let one = effect("guide_coulomb", &[("force_n", 1.0)]);
        let twice = EffectModel::validate_all(&Model {
            effects: vec![one.clone(), one.clone()],
            ..Model::default()
        });
        assert_eq!(twice, Err(EffectError::Twice { id: one.id.clone() }));
        let mut with_axes = one.clone();
        with_axes.axes.push(crate::model::Axis::X);
        assert!(matches!(
            with_axes.validate(&Model::default()),
            Err(EffectError::Axes { .. })
        ));
        for interval in [[2.0, 1.0], [f64::NAN, 1.0]] {
            let mut wrong = one.clone();
            wrong.interval_95.insert("force_n".to_owned(), interval);
            assert!(matches!(
                wrong.validate(&Model::default()),
                Err(EffectError::Interval { .. })
            ));
        }
    }
}
