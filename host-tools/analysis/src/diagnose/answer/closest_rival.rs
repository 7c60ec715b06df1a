//! The closest rival of what is named: what else the logs would allow in the place of a named effect, and whether they tell
//! the two apart.

use crate::diagnose::catalogue::is_general_curve;
use crate::diagnose::evidence::{self, AS_MUCH, NEARLY_AS_GOOD, TOLD_APART};
use crate::diagnose::finding::{Experiment, Ranked, RunnerUp, TOGETHER, Tie};
use softdock_physics::effects::{Effect, Law, by_id};
use softdock_physics::model::Channel;
use std::collections::BTreeSet;

/// The closest rival: one effect, or, if none ties, two that tie in the place of a named effect with several amounts. If one
/// effect ties, two that tie in the same place are added to its ties.
fn runner_up(named: &[String], ranked: &[Ranked]) -> Option<RunnerUp> {
    let alone = one_in_place(named, ranked);
    let Some(two) = two_in_place(named, ranked) else {
        return alone;
    };
    match alone.filter(|alone| !alone.told_apart) {
        Some(mut alone) => {
            if alone.of == two.of {
                alone.join(two);
            }
            Some(alone)
        }
        None => Some(two),
    }
}

/// The closest rival of what is named, and ties of the other named effects.
pub(crate) fn all(named: &[String], ranked: &[Ranked]) -> (Option<RunnerUp>, Vec<RunnerUp>) {
    let first = runner_up(named, ranked);
    let further = first
        .as_ref()
        .map(|first| further_ties(named, ranked, first));
    (first, further.unwrap_or_default())
}

/// Ties of named effects other than the one whose rival the runner-up is.
fn further_ties(named: &[String], ranked: &[Ranked], first: &RunnerUp) -> Vec<RunnerUp> {
    let others = named.iter().filter(|id| **id != first.of);
    let of = |id: &String| {
        let ties = ties_of(in_the_place_of(id, named, ranked), ranked);
        let mut ties = ties.into_iter();
        let closest = ties.next()?;
        Some(RunnerUp {
            effect: closest.effect,
            of: id.clone(),
            behind: closest.behind,
            told_apart: false,
            evidence: closest.evidence,
            ties: ties.collect(),
        })
    };
    let mut all: Vec<RunnerUp> = others.filter_map(of).collect();
    if let Some(two) = two_in_place(named, ranked).filter(|two| two.of != first.of) {
        match all.iter_mut().find(|one| one.of == two.of) {
            Some(one) => one.join(two),
            None => all.push(two),
        }
    }
    all
}

/// Rivals in the place of a named effect that are not told from it and explain enough there, each id once.
fn ties_of(places: Vec<InPlace<'_>>, ranked: &[Ranked]) -> Vec<Tie> {
    let mut ties: Vec<Tie> = Vec::new();
    for (of, winner, rival, effect) in places {
        let is_new = ties.iter().all(|tie| tie.effect != *effect);
        if is_new && !is_told_apart(winner, rival) && does_as_much(of, winner, rival, ranked) {
            ties.push(Tie {
                effect: effect.clone(),
                behind: behind(winner, rival),
                evidence: evidence_against(winner, rival),
            });
        }
    }
    ties
}

/// The closest single effect in the place of a named one: one that the search marked as equally good, else the one that is least
/// behind.
fn one_in_place(named: &[String], ranked: &[Ranked]) -> Option<RunnerUp> {
    let tie = ranked.iter().find_map(|rival| {
        let of = rival.as_good_as.as_ref().filter(|of| named.contains(of))?;
        let other = rival.effects.iter().find(|id| !named.contains(id))?;
        let with_it = |r: &&Ranked| {
            let back = rival
                .effects
                .iter()
                .map(|id| if id == other { of } else { id });
            let back: BTreeSet<&String> = back.collect();
            r.beside == rival.beside && r.effects.iter().collect::<BTreeSet<_>>() == back
        };
        Some((of, ranked.iter().find(with_it)?, rival, other))
    });
    let (of, winner, rival, other) = tie.or_else(|| {
        let less = |place: &InPlace<'_>| place.1.fall() - place.2.fall();
        let each = named
            .iter()
            .flat_map(|id| in_the_place_of(id, named, ranked));
        each.min_by(|a, b| less(a).total_cmp(&less(b)))
    })?;
    let mut ties = ties_of(in_the_place_of(of, named, ranked), ranked);
    ties.retain(|tie| tie.effect != *other);
    Some(RunnerUp {
        effect: other.clone(),
        of: of.clone(),
        behind: behind(winner, rival),
        // Errors of form of all that is explained can exceed what the named effect explains. A rival that explains less than half
        // of that effect's part is no tie, even if it is behind by less than such errors.
        told_apart: is_told_apart(winner, rival) || !does_as_much(of, winner, rival, ranked),
        evidence: evidence_against(winner, rival),
        ties,
    })
}

/// Two unnamed effects that tie in the place of a named one with several amounts: over a small angle the weight of a link is an
/// offset and a spring.
fn two_in_place(named: &[String], ranked: &[Ranked]) -> Option<RunnerUp> {
    let is_named = |r: &&Ranked| {
        let all = r.effects.iter().all(|e| named.contains(e));
        all && r.channel == Channel::Wrench && r.refused.is_none()
    };
    let larger = |a: &&Ranked, b: &&Ranked| {
        let by_size = a.effects.len().cmp(&b.effects.len());
        by_size.then(a.fall().total_cmp(&b.fall()))
    };
    let winner = ranked.iter().filter(is_named).max_by(larger)?;
    let rivals = ranked.iter().filter(|r| {
        let alike = r.channel == winner.channel && r.beside == winner.beside;
        alike && r.refused.is_none() && r.effects.len() == winner.effects.len() + 1
    });
    let in_place = rivals.filter_map(|r| {
        let mut gone = winner.effects.iter().filter(|e| !r.effects.contains(e));
        let both = r.effects.iter().filter(|e| !named.contains(e));
        let both: Vec<&str> = both.map(String::as_str).collect();
        let of = gone.next().filter(|_| gone.next().is_none())?;
        let is_tie = both.len() == 2
            && !both.iter().any(|id| is_general_curve(id))
            && !is_told_apart(winner, r)
            && !is_refused_by_its_price(r, winner, both[0], of)
            && explains(of, winner, ranked)
            && does_as_much(of, winner, r, ranked);
        is_tie.then(|| RunnerUp {
            effect: both.join(TOGETHER),
            of: of.clone(),
            behind: behind(winner, r),
            told_apart: false,
            evidence: evidence_against(winner, r),
            ties: Vec::new(),
        })
    });
    in_place.min_by(|a, b| a.behind.total_cmp(&b.behind))
}

/// By how much less χ² falls with a rival. One that fits a little better, but was not taken for other reasons, is behind by 0.
fn behind(winner: &Ranked, rival: &Ranked) -> f64 {
    (winner.fall() - rival.fall()).max(0.0)
}

fn is_told_apart(winner: &Ranked, rival: &Ranked) -> bool {
    rival.as_good_as.is_none() && behind(winner, rival) > by_form(winner)
}

/// How far behind in χ² a rival has to be to be told apart: more than noise causes, and more than an error of form of the winner.
fn by_form(winner: &Ranked) -> f64 {
    TOLD_APART.max(evidence::LAW * winner.fall())
}

/// Evidence against a rival, scaled so that errors of form count as noise does where there are none.
fn evidence_against(winner: &Ranked, rival: &Ranked) -> f64 {
    let behind = behind(winner, rival);
    let by_form = match rival.as_good_as.is_some() && behind > TOLD_APART {
        // A tie by form, where more than noise is left.
        true => (1.0 - NEARLY_AS_GOOD) * winner.fall(),
        false => by_form(winner),
    };
    behind * TOLD_APART / by_form.max(TOLD_APART)
}

/// A named effect, a hypothesis with it, the hypothesis with a rival in its place, and the rival.
type InPlace<'a> = (&'a String, &'a Ranked, &'a Ranked, &'a String);

/// For a named effect: among hypotheses of named effects only, those with most effects, and of these the best for which a rival
/// was tried in its place. One entry for each such rival.
fn in_the_place_of<'a>(id: &'a String, named: &[String], ranked: &'a [Ranked]) -> Vec<InPlace<'a>> {
    let is_named = |r: &&Ranked| r.effects.iter().all(|e| named.contains(e));
    let with_it = ranked.iter().filter(is_named);
    let with_it = with_it.filter(|r| r.effects.contains(id) && explains(id, r, ranked));
    // Hypotheses with fewer named effects leave more, which a rival may explain in its stead.
    let with_it: Vec<&Ranked> = with_it.collect();
    let most = with_it.iter().map(|r| r.effects.len()).max();
    let with_it = with_it
        .into_iter()
        .filter(|r| Some(r.effects.len()) == most);
    let rivals_of = |winner: &'a Ranked| {
        let alike = move |r: &&Ranked| r.channel == winner.channel && r.beside == winner.beside;
        let others = ranked.iter().filter(|r| r.refused.is_none()).filter(alike);
        others.filter_map(move |r| {
            let other = r.effects.iter().find(|e| !named.contains(e))?;
            let ties = r.as_good_as.as_ref() == Some(id);
            let is_excluded =
                is_in_another(other, id, named) || (!ties && takes_another_place(other, id, named));
            if is_general_curve(other) || is_excluded {
                return None;
            }
            if !ties && is_refused_by_its_price(r, winner, other, id) {
                return None;
            }
            let kept = |e: &String| e == id || r.effects.contains(e);
            let exchanged = r.effects.len() == winner.effects.len();
            (exchanged && winner.effects.iter().all(kept)).then_some((id, winner, r, other))
        })
    };
    let mut pairs: Vec<InPlace<'a>> = with_it.flat_map(rivals_of).collect();
    let best = pairs.iter().map(|place| place.1.fall()).fold(0.0, f64::max);
    pairs.retain(|place| place.1.fall() >= best);
    pairs
}

/// Whether an effect is a rival of a named one other than `id`: it contains that one or is of its kind.
fn takes_another_place(other: &str, id: &str, named: &[String]) -> bool {
    let Some(other) = by_id(other) else {
        return false;
    };
    let contains = |name: &str| other.detail_of.iter().any(|(of, _)| *of == name);
    let alike =
        |name: &str| other.kind.is_some() && by_id(name).is_some_and(|e| e.kind == other.kind);
    let others = named.iter().filter(|name| *name != id);
    others.into_iter().any(|name| contains(name) || alike(name))
}

/// Whether a rival is refused as it has more parameters. It is not refused if it fits better by enough, or if it is another kind
/// of effect and within an error of form of the winner. An effect that contains the winner always fits as well.
fn is_refused_by_its_price(rival: &Ranked, winner: &Ranked, other: &str, id: &str) -> bool {
    let further = rival.parameters.saturating_sub(winner.parameters) as f64;
    let better = rival.fall() - winner.fall();
    let is_form = winner.channel == Channel::Wrench && !is_more_than(other, id);
    let by_form = is_form && further * TOLD_APART - better <= evidence::LAW * winner.fall();
    further > 0.0 && better < TOLD_APART && !by_form
}

/// Whether an effect contains another or is of its kind: with more parameters it fits as well without being true.
pub(crate) fn is_more_than(other: &str, id: &str) -> bool {
    by_id(other).zip(by_id(id)).is_some_and(|(other, one)| {
        let is_kin = other.kind.is_some() && other.kind == one.kind;
        is_kin || other.detail_of.iter().any(|(of, _)| *of == id)
    })
}

/// Whether a named effect other than `id` contains this one, which is then no effect of its own.
fn is_in_another(other: &str, id: &str, named: &[String]) -> bool {
    let others = named.iter().filter(|name| *name != id);
    let mut details = others.filter_map(|name| Some(by_id(name)?.detail_of));
    details.any(|detail_of| detail_of.iter().any(|(of, _)| *of == other))
}

/// Whether a rival explains more than [`AS_MUCH`] of what an effect explains beside the others: otherwise it is behind by little
/// only because neither explains much. A rival that is not behind passes (the others alone may have been tried under another
/// noise model). If the effect explains less than an error of form of the others, χ² decides nothing. It is then named for its
/// error on unseen data, and only a rival that the search found to be as good there passes.
fn does_as_much(id: &str, winner: &Ranked, rival: &Ranked, ranked: &[Ranked]) -> bool {
    let rest = without_it(id, winner, ranked);
    let [own, of_rival] = [winner, rival].map(|r| r.fall() - rest);
    let is_within_form = own < by_form(winner) && rival.as_good_as.is_none();
    !is_within_form && (of_rival >= own || of_rival > AS_MUCH * own)
}

/// Whether an effect explains anything beside the others of a hypothesis. If it does not, any effect is its rival.
fn explains(id: &str, with_it: &Ranked, ranked: &[Ranked]) -> bool {
    with_it.fall() - without_it(id, with_it, ranked) > TOLD_APART
}

/// Fall of χ² with the other effects of a hypothesis; 0 where these were not tried.
fn without_it(id: &str, with_it: &Ranked, ranked: &[Ranked]) -> f64 {
    let rest: Vec<&String> = with_it.effects.iter().filter(|e| *e != id).collect();
    let is_rest = |r: &&Ranked| {
        r.beside == with_it.beside
            && r.effects.len() == rest.len()
            && rest.iter().all(|e| r.effects.contains(e))
    };
    ranked.iter().find(is_rest).map_or(0.0, Ranked::fall)
}

/// The experiment that tells an effect and its rival apart, by the catalogue. If it would turn a sensor and there is none
/// (`is_felt` is false), it is that of the rival. `first` stands for an effect that is not in the catalogue. For a rig there is a
/// command that tries it on the simulated one.
pub(crate) fn experiment(
    first: Option<&String>,
    rival: &RunnerUp,
    is_felt: bool,
    of_a_rig: bool,
) -> Option<Experiment> {
    let one = by_id(&rival.of).or_else(|| by_id(first?))?;
    let pair = std::iter::once(one).chain(rival.effect.split(TOGETHER).filter_map(by_id));
    let hangs = |effect: &Effect| matches!(effect.law, Law::Tool(_) | Law::SensorZero(_));
    let effect = pair.into_iter().find(|effect| is_felt || !hangs(effect))?;
    Some(Experiment {
        sentence: effect.tell_apart.to_owned(),
        separation_now: rival.behind,
        separation_then: None,
        command: match of_a_rig {
            true => format!("softdock demo --effect {}", effect.id),
            false => String::new(),
        },
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A hypothesis of effects that lowers χ² by `fall`, with so many parameters.
    fn tried(effects: &[&str], fall: f64, parameters: usize) -> Ranked {
        Ranked {
            effects: effects.iter().map(|&id| id.to_owned()).collect(),
            beside: Vec::new(),
            channel: Channel::Wrench,
            gain_train: fall,
            gain_test: 0.0,
            parameters,
            as_good_as: None,
            refused: None,
        }
    }

    /// A sensor is turned only where there is one.
    #[test]
    fn where_nothing_is_felt_no_sensor_is_to_be_turned() {
        let rival = RunnerUp {
            effect: "actuation_lag".to_owned(),
            of: "tool_mass_error".to_owned(),
            behind: 100.0,
            told_apart: true,
            evidence: 100.0,
            ties: Vec::new(),
        };
        let says = |is_felt| experiment(None, &rival, is_felt, false).unwrap().sentence;
        assert!(says(true).contains("tilt the sensor"), "{}", says(true));
        assert!(says(false).contains("velocity steps"), "{}", says(false));
    }

    fn of(named: &[&str], ranked: &[Ranked]) -> RunnerUp {
        let named: Vec<String> = named.iter().map(|&id| id.to_owned()).collect();
        runner_up(&named, ranked).expect("a rival")
    }

    /// χ² of 1,000 has errors of form of 1, and of 100,000 of 100.
    #[test]
    fn noise_tells_little_apart_and_errors_of_form_tell_much_apart() {
        let tells = |winner: f64, rival: f64| {
            let ranked = [
                tried(&["guide_coulomb"], winner, 1),
                tried(&["guide_viscous"], rival, 1),
            ];
            of(&["guide_coulomb"], &ranked).told_apart
        };
        assert!(!tells(1e3, 1e3 - 11.0));
        assert!(tells(1e3, 1e3 - 13.0));
        assert!(!tells(1e5, 1e5 - 99.0));
        assert!(tells(1e5, 1e5 - 101.0));
    }

    /// A rival that fits better than the answer is not told from it, even where the others alone seem to fit best, under another
    /// noise model.
    #[test]
    fn what_falls_by_as_much_is_not_told_apart() {
        let named = ["guide_coulomb", "clock_offset"];
        let drift = Ranked {
            as_good_as: Some("clock_offset".to_owned()),
            ..tried(&["guide_coulomb", "ft_bias_drift"], 1010.0, 2)
        };
        let alone = tried(&["guide_coulomb"], 1100.0, 1);
        let rival = of(&named, &[tried(&named, 1000.0, 2), drift, alone]);
        assert_eq!(
            (rival.effect.as_str(), rival.told_apart),
            ("ft_bias_drift", false)
        );
    }

    /// Each of two named effects has its tie: one is the runner-up, the other is reported as well.
    #[test]
    fn each_named_effect_has_its_ties() {
        let named = ["guide_asymmetry", "ft_low_pass"];
        let ranked = [
            tried(&named, 1000.0, 2),
            tried(&["guide_asymmetry", "ft_latency"], 995.0, 2),
            tried(&["guide_offset", "ft_low_pass"], 992.0, 2),
            tried(&["guide_viscous", "ft_low_pass"], 900.0, 2),
            tried(&["guide_asymmetry"], 800.0, 1),
            tried(&["ft_low_pass"], 500.0, 1),
        ];
        let first = of(&named, &ranked);
        let of_first: Vec<&str> = first.not_told_from().collect();
        assert_eq!(
            (first.of.as_str(), &of_first[..]),
            ("ft_low_pass", &["ft_latency"][..])
        );
        let named = named.map(str::to_owned);
        let further = further_ties(&named, &ranked, &first);
        let [other] = &further[..] else {
            panic!("{further:?}")
        };
        let of_other: Vec<&str> = other.not_told_from().collect();
        assert_eq!(
            (other.of.as_str(), &of_other[..]),
            ("guide_asymmetry", &["guide_offset"][..])
        );
    }

    /// Weight of a link has two amounts, as have an offset and a spring.
    #[test]
    fn two_effects_can_have_the_place_of_one_of_two_amounts() {
        let rival = |parameters: usize, fall: f64| {
            let ranked = [
                tried(&["guide_coulomb", "bearing_gravity"], 500.0, 3),
                tried(
                    &["guide_coulomb", "guide_offset", "cable_stiffness"],
                    fall,
                    parameters,
                ),
                tried(&["guide_coulomb", "ft_scale"], 300.0, 3),
            ];
            of(&["guide_coulomb", "bearing_gravity"], &ranked)
        };
        let tie = rival(3, 495.0);
        assert_eq!(tie.effect, "guide_offset + cable_stiffness");
        assert_eq!(
            (tie.of.as_str(), tie.told_apart),
            ("bearing_gravity", false)
        );
        assert_eq!(rival(4, 495.0).effect, "ft_scale", "it pays for more");
        assert_eq!(rival(3, 480.0).effect, "ft_scale", "it is told apart");
        let one = tried(&["guide_coulomb", "cable_stiffness"], 499.0, 2);
        let both = tried(
            &["guide_coulomb", "guide_offset", "cable_stiffness"],
            500.0,
            3,
        );
        let named = ["guide_coulomb", "bearing_gravity"];
        let closer = of(&named, &[tried(&named, 500.0, 3), one, both]);
        assert_eq!(closer.effect, "cable_stiffness");
        assert_eq!(closer.ties[0].effect, "guide_offset + cable_stiffness");
    }

    #[test]
    fn every_tie_is_told_and_the_closest_one_is_the_rival() {
        let ranked = [
            tried(&["guide_coulomb"], 500.0, 1),
            tried(&["guide_viscous"], 497.0, 1),
            tried(&["ft_bias"], 495.0, 1),
            tried(&["ft_scale"], 450.0, 1),
        ];
        let rival = of(&["guide_coulomb"], &ranked);
        assert_eq!(
            (rival.effect.as_str(), rival.behind),
            ("guide_viscous", 3.0)
        );
        let ties: Vec<&str> = rival.ties.iter().map(|tie| tie.effect.as_str()).collect();
        assert_eq!(ties, ["ft_bias"]);
    }

    /// Where neither of two effects explains much beside a third one, both are behind it by little.
    #[test]
    fn what_does_less_than_half_is_no_tie() {
        let ties = |rival: f64| {
            let ranked = [
                tried(&["ft_bias", "guide_coulomb"], 1015.0, 2),
                tried(&["ft_bias", "guide_viscous"], 1014.0, 2),
                tried(&["ft_bias", "ft_scale"], rival, 2),
                tried(&["ft_bias"], 1000.0, 1),
            ];
            of(&["ft_bias", "guide_coulomb"], &ranked).ties.len()
        };
        assert_eq!(ties(1007.0), 0);
        assert_eq!(ties(1008.0), 1);
    }

    /// Dry friction in a form with more parameters always fits as well. An effect of another kind pays for its parameters only
    /// where noise decides.
    #[test]
    fn more_parameters_of_the_same_kind_are_no_tie() {
        let rival_of = |other: &str, parameters: usize, fall: f64| {
            let ranked = [
                tried(&["guide_coulomb"], fall, 1),
                tried(&[other], fall - 3.0, parameters),
            ];
            runner_up(&["guide_coulomb".to_owned()], &ranked).map(|rival| rival.told_apart)
        };
        assert_eq!(rival_of("guide_stribeck", 3, 1e3), None);
        assert_eq!(rival_of("guide_stribeck", 3, 1e5), None);
        assert_eq!(rival_of("ft_scale", 3, 1e3), None);
        assert_eq!(rival_of("ft_scale", 3, 1e5), Some(false));
        assert_eq!(rival_of("ft_scale", 1, 1e3), Some(false));
    }

    /// Beside an asymmetric friction a dry one is no effect of its own.
    #[test]
    fn what_a_named_effect_contains_is_no_rival_of_another() {
        let named = ["ft_bias", "guide_asymmetry"];
        let ranked = [
            tried(&named, 1000.0, 2),
            tried(&["guide_asymmetry", "guide_coulomb"], 995.0, 2),
            tried(&["guide_asymmetry", "ft_scale"], 900.0, 2),
        ];
        assert_eq!(of(&named, &ranked).effect, "ft_scale");
    }

    #[test]
    fn what_physics_forbids_is_no_rival() {
        let forbidden = Ranked {
            refused: Some("physics forbids".to_owned()),
            ..tried(&["guide_viscous"], 499.0, 1)
        };
        let ranked = [
            tried(&["guide_coulomb"], 500.0, 1),
            forbidden,
            tried(&["ft_bias"], 300.0, 1),
        ];
        assert_eq!(of(&["guide_coulomb"], &ranked).effect, "ft_bias");
    }

    /// Where more than noise is left, the search says which two are equally good. Evidence is then what errors of form leave of
    /// the difference.
    #[test]
    fn a_tie_by_form_is_a_rival_whatever_chi_squared_says() {
        let as_good = Ranked {
            as_good_as: Some("guide_coulomb".to_owned()),
            ..tried(&["guide_viscous"], 900.0, 1)
        };
        let ranked = [
            tried(&["guide_coulomb"], 1000.0, 1),
            tried(&["ft_bias"], 950.0, 1),
            as_good,
        ];
        let rival = of(&["guide_coulomb"], &ranked);
        assert_eq!(
            (rival.effect.as_str(), rival.told_apart),
            ("guide_viscous", false)
        );
        let expected = TOLD_APART * 100.0 / ((1.0 - NEARLY_AS_GOOD) * 1000.0);
        assert!(
            (rival.evidence - expected).abs() < 1e-9,
            "{}",
            rival.evidence
        );
    }

    /// Of 620,000 errors of form are 620: a weight that does 10 where a viscous friction does 522 is within them.
    #[test]
    fn what_does_next_to_nothing_is_no_tie() {
        let tells = |alone: f64| {
            let ranked = [
                tried(&["bearing_inertia", "guide_viscous"], 621_094.0, 2),
                tried(&["bearing_inertia", "bearing_gravity"], 620_582.0, 2),
                tried(&["bearing_inertia"], alone, 1),
            ];
            of(&["bearing_inertia", "guide_viscous"], &ranked).told_apart
        };
        assert!(tells(620_572.0) && !tells(620_000.0));
    }

    /// Errors of form of a stiff spring are 7 million: another effect may explain more than an offset of 78,000 and still be
    /// within them.
    #[test]
    fn what_does_less_than_an_error_of_form_has_no_tie_but_one_that_foretells() {
        let tells = |as_good_as: Option<&str>| {
            let named = ["cable_stiffness", "guide_offset"];
            let rival = Ranked {
                as_good_as: as_good_as.map(str::to_owned),
                ..tried(&["cable_stiffness", "guide_coulomb"], 7.5489e9, 2)
            };
            let ranked = [
                tried(&named, 7.548_445e9, 2),
                rival,
                tried(&["cable_stiffness"], 7.548_367e9, 1),
            ];
            of(&named, &ranked).told_apart
        };
        assert!(tells(None) && !tells(Some("guide_offset")));
    }
}
