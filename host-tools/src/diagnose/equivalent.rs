//! Effects that are others in other words: no log can tell them apart.

use super::named::Named;

/// Says which other effect of the catalogue is the same as some of the named ones together.
pub(super) fn note<'a>(named: impl Iterator<Item = &'a Named> + Clone) -> Option<String> {
    let find = |id: &str| named.clone().find(|n| n.effect.id == id);
    let (coulomb, offset) = (find("guide_coulomb")?, find("guide_offset")?);
    let of = |named: &Named, name: &str| named.effect.parameters.get(name).copied();
    let acts_at = |named: &Named| of(named, "acts_at").unwrap_or(0.0);
    if acts_at(coulomb) != acts_at(offset) {
        return None;
    }
    // −F sgn v + F0: F − F0 against a motion forwards, F + F0 against one backwards.
    let (dry, constant) = (of(coulomb, "force_n")?, of(offset, "force_n")?);
    let (forward, backward) = (dry - constant, dry + constant);
    (forward >= 0.0 && backward >= 0.0).then(|| {
        format!(
            "guide_coulomb and guide_offset together are the same as a friction that differs by \
             direction (guide_asymmetry): {forward:.3} N forwards and {backward:.3} N backwards. No \
             log can tell one from the other; who knows the guide can."
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::EffectModel;

    fn named(id: &str, parameters: &[(&str, f64)]) -> Named {
        let parameters = parameters.iter().map(|(name, v)| ((*name).to_owned(), *v));
        Named {
            effect: EffectModel {
                id: id.to_owned(),
                parameters: parameters.collect(),
                ..EffectModel::default()
            },
            estimates: Default::default(),
        }
    }

    #[test]
    fn friction_by_direction_is_friction_with_an_offset() {
        let dry = named("guide_coulomb", &[("force_n", 1.5)]);
        let constant = named("guide_offset", &[("force_n", -0.5)]);
        let said = note([&dry, &constant].into_iter()).unwrap_or_default();
        assert!(
            said.contains("2.000 N forwards and 1.000 N backwards"),
            "{said}"
        );
        // Against the motion in one direction only: no friction does so.
        let strong = named("guide_offset", &[("force_n", 2.0)]);
        assert_eq!(note([&dry, &strong].into_iter()), None);
        let elsewhere = named("guide_offset", &[("force_n", 0.5), ("acts_at", 1.0)]);
        assert_eq!(note([&dry, &elsewhere].into_iter()), None);
        assert_eq!(note([&dry].into_iter()), None);
    }
}
