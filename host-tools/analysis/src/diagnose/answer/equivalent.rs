//! Named effects that have an equivalent in other effects, which no log, or not this one, can tell from them.

use crate::diagnose::finding::{Equivalent, Estimate, Parameters};
use crate::diagnose::named::NamedEffect;
use softdock_report::number;
use softdock_statistics::DEVIATIONS_95;

/// An effect, or several, of the catalogue that are equivalent to some of the named ones; `None` if there are none.
pub(crate) fn of<'a>(named: impl Iterator<Item = &'a NamedEffect> + Clone) -> Option<Equivalent> {
    let find = |id: &str| named.clone().find(|n| n.effect.id == id);
    let by_direction = || friction_by_direction(find("guide_coulomb")?, find("guide_offset")?);
    let weight = || match find("bearing_gravity") {
        None => weight(find("cable_stiffness")?),
        Some(_) => None,
    };
    let with_constant = || match find("guide_coulomb").or(find("guide_offset")) {
        None => friction_with_constant(find("guide_asymmetry")?),
        Some(_) => None,
    };
    by_direction().or_else(with_constant).or_else(weight)
}

/// A spring about a bearing that may bend as the sine of a weight does: k sin q = k q − k/6 q³ + ..
fn weight(spring: &NamedEffect) -> Option<Equivalent> {
    let stiffness = spring.estimates.get("stiffness_n_m_per_rad")?;
    let hardening = spring.estimates.get("hardening_n_m_per_rad3")?;
    if !(hardening.low..=hardening.high).contains(&(-stiffness.value / 6.0)) {
        return None;
    }
    let sentence = format!(
        "cable_stiffness may as well be the weight of a link (bearing_gravity, {:.3} N·m per rad about its lowest point): \
         its interval of the hardening holds the bend of a sine. Larger swings tell one from the other, and who knows \
         the joint.",
        stiffness.value
    );
    let sine = Estimate {
        unit: "N·m".to_owned(),
        ..stiffness.clone()
    };
    let parameters = [("sine_n_m".to_owned(), sine)];
    Some(Equivalent {
        of: vec![spring.effect.id.clone()],
        parameters: Parameters::from([("bearing_gravity".to_owned(), parameters.into())]),
        sentence,
    })
}

/// Dry friction and a constant force are friction that differs by direction.
fn friction_by_direction(coulomb: &NamedEffect, offset: &NamedEffect) -> Option<Equivalent> {
    let acts_at = |named: &NamedEffect| named.effect.parameters.get("acts_at").copied();
    if acts_at(coulomb) != acts_at(offset) {
        return None;
    }
    // About a bearing both are torques.
    let (amount, suffix) = match coulomb.estimates.contains_key("force_n") {
        true => ("force_n", "n"),
        false => ("torque_n_m", "n_m"),
    };
    let (dry, constant) = (
        coulomb.estimates.get(amount)?,
        offset.estimates.get(amount)?,
    );
    // −F sgn v + F0: F − F0 against a motion forwards, F + F0 against one backwards.
    let forward = sum(dry, constant, -1.0);
    let backward = sum(dry, constant, 1.0);
    if forward.value < 0.0 || backward.value < 0.0 {
        return None;
    }
    let sentence = format!(
        "guide_coulomb and guide_offset together are the same as a friction that differs by \
         direction (guide_asymmetry): {} {unit} forwards and {} {unit} backwards. No log can tell one \
         from the other; who knows the guide can.",
        number::significant(forward.value, 4),
        number::significant(backward.value, 4),
        unit = dry.unit,
    );
    let parameters = [("forward", forward), ("backward", backward)];
    let parameters = parameters.map(|(name, estimate)| (format!("{name}_{suffix}"), estimate));
    Some(Equivalent {
        of: [coulomb, offset].map(|n| n.effect.id.clone()).to_vec(),
        parameters: Parameters::from([("guide_asymmetry".to_owned(), parameters.into())]),
        sentence,
    })
}

/// Friction that differs by direction, without a part that depends on speed, is a dry friction and a constant force.
fn friction_with_constant(asymmetry: &NamedEffect) -> Option<Equivalent> {
    let of = |name| asymmetry.estimates.get(name);
    let on_a_guide = of("forward_n").zip(of("backward_n"));
    let (both, amount) = match on_a_guide {
        Some(both) => (both, "force_n"),
        None => (of("forward_n_m").zip(of("backward_n_m"))?, "torque_n_m"),
    };
    if asymmetry.estimates.len() > 2 {
        return None;
    }
    let half = |sign: f64| {
        let twice = sum(both.1, both.0, sign);
        let [value, low, high] = [twice.value, twice.low, twice.high].map(|end| 0.5 * end);
        Estimate {
            value,
            low,
            high,
            ..twice
        }
    };
    let (dry, constant) = (half(1.0), half(-1.0));
    let sentence = format!(
        "guide_asymmetry is the same as a dry friction of {:.3} {unit} (guide_coulomb) and a constant of {:.3} {unit} \
         (guide_offset) together. No log can tell one from the other; who knows the guide can.",
        dry.value,
        constant.value,
        unit = dry.unit,
    );
    let parameters = [("guide_coulomb", dry), ("guide_offset", constant)];
    let parameters = parameters.map(|(id, one)| (id.to_owned(), [(amount.to_owned(), one)].into()));
    Some(Equivalent {
        of: vec![asymmetry.effect.id.clone()],
        parameters: Parameters::from(parameters),
        sentence,
    })
}

/// One estimate plus `sign` times another, their deviations independent.
fn sum(one: &Estimate, other: &Estimate, sign: f64) -> Estimate {
    let deviation = |e: &Estimate| 0.5 * (e.high - e.low) / DEVIATIONS_95;
    let value = one.value + sign * other.value;
    let reach = DEVIATIONS_95 * deviation(one).hypot(deviation(other));
    Estimate {
        value,
        unit: one.unit.clone(),
        low: value - reach,
        high: value + reach,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn named(id: &str, force_n: f64, acts_at: f64) -> NamedEffect {
        NamedEffect::new(id, Vec::new())
            .with("force_n", (force_n, 0.1), "N")
            .choosing("acts_at", acts_at)
    }

    #[test]
    fn a_spring_that_may_bend_as_a_sine_is_perhaps_a_weight() {
        let spring = |hardening: f64, sigma: f64| {
            NamedEffect::new("cable_stiffness", Vec::new())
                .with("stiffness_n_m_per_rad", (6.0, 0.1), "N·m/rad")
                .with("hardening_n_m_per_rad3", (hardening, sigma), "N·m/rad^3")
        };
        let said = of([&spring(0.5, 1.0)].into_iter());
        let said = said.expect("a sine bends by -1 N·m/rad^3");
        assert_eq!(said.parameters["bearing_gravity"]["sine_n_m"].value, 6.0);
        assert_eq!(of([&spring(0.5, 0.1)].into_iter()), None);
        let gravity = NamedEffect::new("bearing_gravity", Vec::new());
        assert_eq!(of([&spring(0.5, 1.0), &gravity].into_iter()), None);
    }

    #[test]
    fn friction_by_direction_is_friction_with_an_offset() {
        let dry = named("guide_coulomb", 1.5, 0.0);
        let said = of([&dry, &named("guide_offset", -0.5, 0.0)].into_iter());
        let said = said.expect("the same as guide_asymmetry");
        assert!(
            said.sentence
                .contains("2.000 N forwards and 1.000 N backwards"),
            "{}",
            said.sentence
        );
        let forward = &said.parameters["guide_asymmetry"]["forward_n"];
        assert!((forward.high - 2.0 - DEVIATIONS_95 * 0.1 * 2.0_f64.sqrt()).abs() < 1e-9);
        let other_way = NamedEffect::new("guide_asymmetry", Vec::new())
            .with("forward_n", (2.0, 0.1), "N")
            .with("backward_n", (1.0, 0.1), "N");
        let same = of([&other_way].into_iter()).expect("the same as both");
        let value = |id: &str| same.parameters[id]["force_n"].value;
        assert_eq!([value("guide_coulomb"), value("guide_offset")], [1.5, -0.5]);
        let steeper = other_way
            .clone()
            .with("viscous_difference_n_s_per_m", (5.0, 0.1), "N·s/m");
        assert_eq!(of([&steeper].into_iter()), None);
        // Against the motion in one direction only: no friction does so.
        let strong = named("guide_offset", 2.0, 0.0);
        let elsewhere = named("guide_offset", 0.5, 1.0);
        for other in [&strong, &elsewhere, &dry] {
            assert_eq!(of([&dry, other].into_iter()), None);
        }
    }
}
