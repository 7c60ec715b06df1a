//! Which effects and parameters a model file may hold.

use super::EffectModel;
use crate::input::nearest;
use crate::model::actuator::Stage;
use crate::model::load::effects::{LoadEffect, Sign};
use softdock_control::effects::{CATALOGUE, Effect, Group, by_id};

/// Effects on clock, craft and sampling, which [`crate::model::prediction`] knows by their ids.
const OTHERS: [&str; 8] = [
    "clock_jitter",
    "clock_rate",
    "clock_offset",
    "sc_mass_error",
    "sc_inertia_error",
    "manipulator_resistance",
    "ft_quantisation",
    "ft_dropout",
];

/// An `[[effect]]` of a model file that cannot be.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum EffectError {
    /// No such effect.
    #[error("there is no effect `{id}`; {hint}")]
    Unknown {
        /// The id that was given.
        id: String,
        /// What to write instead.
        hint: String,
    },
    /// The same effect more than once.
    #[error("[[effect]] `{id}` stands there twice; keep one of them")]
    Twice {
        /// Its id.
        id: String,
    },
    /// An effect of the catalogue without a prediction.
    #[error("[[effect]] `{id}` can be simulated but not fitted or predicted; take it out")]
    NotPredicted {
        /// Its id.
        id: String,
    },
    /// `axes` where they have no meaning.
    #[error(
        "[[effect]] `{id}` has no axes of its own, only actuator effects have; take out `axes`"
    )]
    Axes {
        /// Its id.
        id: String,
    },
    /// No such parameter.
    #[error("[[effect]] `{id}`: unknown parameter `{name}`; {hint}")]
    UnknownParameter {
        /// Id of the effect.
        id: String,
        /// The name that was given.
        name: String,
        /// What to write instead.
        hint: String,
    },
    /// A parameter that has no default.
    #[error("[[effect]] `{id}`: the parameter `{name}` is missing; allowed is {low} to {high}")]
    MissingParameter {
        /// Id of the effect.
        id: String,
        /// The parameter.
        name: &'static str,
        /// Smallest allowed value.
        low: f64,
        /// Largest allowed value.
        high: f64,
    },
    /// A value that the effect cannot have on any rig.
    #[error("[[effect]] `{id}`: `{name}` is {received}; allowed is {low} to {high}")]
    OutOfRange {
        /// Id of the effect.
        id: String,
        /// The parameter.
        name: String,
        /// The value that was given.
        received: f64,
        /// Smallest allowed value.
        low: f64,
        /// Largest allowed value.
        high: f64,
    },
    /// An interval without parameter, or with its ends exchanged.
    #[error(
        "[[effect]] `{id}`: interval_95 of `{name}` is [{low}, {high}]; expected [low, high] of a \
         parameter that is given"
    )]
    Interval {
        /// Id of the effect.
        id: String,
        /// The parameter.
        name: String,
        /// Lower end.
        low: f64,
        /// Upper end.
        high: f64,
    },
}

/// A parameter that an effect may have in a model file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Allowed {
    /// Name with unit.
    pub name: &'static str,
    /// SI unit, `-` if it has none.
    pub unit: &'static str,
    /// Smallest value.
    pub low: f64,
    /// Largest value.
    pub high: f64,
    /// Value where the file gives none.
    default: f64,
    /// It says which form of the effect it is; there is nothing to fit.
    pub choice: bool,
}

/// Parameters that an effect may have: those of the catalogue, and the choices of its form.
pub(crate) fn known(effect: &Effect) -> Vec<Allowed> {
    let mut all: Vec<Allowed> = effect
        .parameters
        .iter()
        .map(|p| Allowed {
            name: p.name,
            unit: p.unit,
            low: p.low,
            high: p.high,
            default: 0.0,
            choice: false,
        })
        .collect();
    let forms = Stage::ALL.into_iter().filter(|s| s.id() == effect.id);
    for name in forms.flat_map(|stage| stage.form()) {
        add(&mut all, Allowed::chosen(name, "-", 0.0, 1.0, 0.0));
    }
    add_rotations(&mut all, effect);
    if effect.id == "ft_quantisation" {
        add(&mut all, Allowed::chosen("rounds_down", "-", 0.0, 1.0, 0.0));
    }
    let Some(load) = LoadEffect::find(effect.id) else {
        return all;
    };
    for c in load.coefficients {
        let low = if c.sign == Sign::Free { f64::MIN } else { 0.0 };
        let of = Allowed::chosen(c.name, c.unit, low, f64::MAX, 0.0);
        add(
            &mut all,
            Allowed {
                choice: false,
                ..of
            },
        );
    }
    for shape in load.shapes {
        let least = shape.tried.iter().copied().fold(shape.default, f64::min);
        let most = shape.tried.iter().copied().fold(shape.default, f64::max);
        let of = Allowed::chosen(shape.name, shape.unit, least, most, shape.default);
        let of = add(&mut all, of);
        of.default = shape.default;
        of.choice = shape.choice;
    }
    all
}

/// Adds the parameters of rotations where a stage has others than for translations, with the same
/// range in their unit.
fn add_rotations(all: &mut Vec<Allowed>, effect: &Effect) {
    let stages = Stage::ALL.into_iter().filter(|s| s.id() == effect.id);
    for stage in stages.filter(|s| s.has_units_of_its_axes()) {
        let pairs = stage.parameters(true).iter().zip(stage.parameters(false));
        for ((name, unit), (linear, _)) in pairs {
            if let Some(of) = all.iter().find(|p| p.name == *linear).copied() {
                add(all, Allowed { name, unit, ..of });
            }
        }
    }
}

/// Adds a parameter; one of the same name keeps the catalogue's range.
fn add(all: &mut Vec<Allowed>, one: Allowed) -> &mut Allowed {
    let place = all.iter().position(|a| a.name == one.name);
    let place = place.unwrap_or_else(|| {
        all.push(one);
        all.len() - 1
    });
    &mut all[place]
}

impl Allowed {
    fn chosen(name: &'static str, unit: &'static str, low: f64, high: f64, default: f64) -> Self {
        Self {
            name,
            unit,
            low,
            high,
            default,
            choice: true,
        }
    }

    fn holds(&self, value: f64) -> bool {
        value >= self.low && value <= self.high
    }
}

impl EffectModel {
    /// The catalogue's entry with this id.
    ///
    /// # Errors
    ///
    /// [`EffectError::Unknown`] with the nearest id.
    pub fn catalogued(id: &str) -> Result<&'static Effect, EffectError> {
        by_id(id).ok_or_else(|| EffectError::Unknown {
            id: id.to_owned(),
            hint: match nearest(id, CATALOGUE.iter().map(|effect| effect.id)) {
                Some(near) => format!("did you mean `{near}`?"),
                None => "`softdock effects` lists them".to_owned(),
            },
        })
    }

    /// Checks all effects of a model file.
    pub(in crate::model) fn validate_all(effects: &[Self]) -> Result<(), EffectError> {
        for (k, effect) in effects.iter().enumerate() {
            effect.validate()?;
            if effects[..k].iter().any(|other| other.id == effect.id) {
                return Err(EffectError::Twice {
                    id: effect.id.clone(),
                });
            }
        }
        Ok(())
    }

    /// Checks id, axes, parameters and intervals.
    ///
    /// # Errors
    ///
    /// The first thing that does not fit, with what is allowed.
    pub fn validate(&self) -> Result<(), EffectError> {
        let effect = Self::catalogued(&self.id)?;
        let id = || self.id.clone();
        let predicted = Stage::ALL.iter().any(|stage| stage.id() == self.id)
            || LoadEffect::find(&self.id).is_some()
            || OTHERS.contains(&self.id.as_str());
        if !predicted {
            return Err(EffectError::NotPredicted { id: id() });
        }
        if !self.axes.is_empty() && effect.group != Group::Actuator {
            return Err(EffectError::Axes { id: id() });
        }
        let allowed = known(effect);
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

    /// An effect with parameters of their own for translations and rotations needs those of one.
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
        match effect(id, parameters).validate() {
            Ok(()) => "nothing".to_owned(),
            Err(error) => error.to_string(),
        }
    }

    #[test]
    fn every_choice_of_every_form_is_allowed() {
        for stage in Stage::ALL {
            let mut model = effect(stage.id(), &[]);
            let entry = EffectModel::catalogued(stage.id()).expect("catalogued");
            for p in entry.parameters {
                model.parameters.insert(p.name.to_owned(), p.high);
            }
            for name in stage.form() {
                model.parameters.insert((*name).to_owned(), 1.0);
            }
            assert_eq!(model.validate(), Ok(()));
        }
        for load in LoadEffect::all() {
            for shape in load.shapes {
                for value in shape.tried.iter().chain([&shape.default]) {
                    let model = effect(load.id, &[(shape.name, *value)]);
                    assert_eq!(model.validate(), Ok(()), "{} {value}", shape.name);
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
        let said = refused("rate_limit", &[(angular, 1e9)]);
        assert!(said.contains("allowed is 0.001 to 1000"), "{said}");
    }

    #[test]
    fn twice_the_same_and_misplaced_axes_and_intervals_are_refused() {
        let one = effect("guide_coulomb", &[("force_n", 1.0)]);
        let twice = EffectModel::validate_all(&[one.clone(), one.clone()]);
        assert_eq!(twice, Err(EffectError::Twice { id: one.id.clone() }));
        let mut with_axes = one.clone();
        with_axes.axes.push(crate::model::Axis::X);
        assert!(matches!(
            with_axes.validate(),
            Err(EffectError::Axes { .. })
        ));
        for interval in [[2.0, 1.0], [f64::NAN, 1.0]] {
            let mut wrong = one.clone();
            wrong.interval_95.insert("force_n".to_owned(), interval);
            assert!(matches!(
                wrong.validate(),
                Err(EffectError::Interval { .. })
            ));
        }
    }
}
