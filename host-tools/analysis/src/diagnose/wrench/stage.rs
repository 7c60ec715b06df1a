//! The search for effects on the reading of one pair of logs.

use super::model_selection::{Rival, parts_of, with_forms_reselected, without_equivalents};
use super::prepared_log::PreparedLog;
use super::search::{DETAILS, Hypothesis, pairs, with_one_more};
use super::tested::{Tested, fitted_to, tested};
use super::variants::{Library, Variant};

/// Gain in χ² below which nothing is accepted, without the price of the parameters.
const SIGNIFICANT: f64 = 40.0;
/// Share of the gain on the fitted log that unseen data has to confirm, per unit of χ².
const CONFIRMED: f64 = 0.15;
/// A further effect has to add this share of what is explained already.
const ADDED: f64 = 0.02;
/// Among hypotheses that differ by less than this share of the gain the simplest is taken.
const DETAIL: f64 = 0.004;
/// Where much is left, a further effect may add less, if it takes this share of what is left.
const OF_THE_REST: f64 = 0.1;
/// Pieces of a log that are left out in turn.
const PIECES: usize = 6;
/// Most effects on one channel.
const MOST: usize = 5;
/// Evidence by which a pair has to be better although it has no more parameters: an effect alone
/// is simpler than two.
const SIMPLER: f64 = 15.0;
/// Hypotheses that are refined and held against unseen data, alone and in pairs.
const TRIED: usize = 12;
/// Gain in χ² below which a hypothesis is not looked at again.
const NEGLIGIBLE_GAIN: f64 = 15.0;

/// Result of the search on the reading.
pub(crate) struct Found {
    /// What is accepted, if anything.
    pub accepted: Option<Tested>,
    /// All that were held against unseen data, best first.
    pub ranked: Vec<Tested>,
    /// Effects of the same kind in the place of one of several that are accepted.
    pub rivals: Vec<Rival>,
}

/// Searches; `finished` says whether a hypothesis leaves nothing but noise on both logs. `forced`:
/// the best hypothesis is taken although it is not significant.
pub(crate) fn search(
    train: &PreparedLog,
    test: &PreparedLog,
    excluded: &dyn Fn(&str) -> bool,
    finished: &dyn Fn(&Tested) -> bool,
    forced: bool,
) -> Found {
    let library = Library::new(&train.scene, &train.problem, excluded);
    let price = (train.problem.count.max(2) as f64).ln();
    let test_all = |hypotheses: &[Hypothesis]| -> Vec<Tested> {
        use rayon::prelude::*;
        distinct(&library, hypotheses)
            .par_iter()
            .map(|h| tested(&library, h, train, test))
            .collect()
    };
    let is_detail = |variant: &Variant| DETAILS.contains(&variant.effect.id);
    // Who asks for a detail alone has in the model what it is a detail of.
    let any = forced || library.variants.iter().all(is_detail);
    let whole = |h: &Hypothesis| {
        let mut variants = h.parts.iter().map(|part| &library.variants[part.variant]);
        !variants.any(is_detail)
    };
    let first = |all: Vec<Hypothesis>| -> Vec<Hypothesis> {
        all.into_iter().filter(|h| any || whole(h)).collect()
    };
    let singles = test_all(&first(with_one_more(&library, &[], price)));
    let doubles = test_all(&first(pairs(&library, price)));
    let single = best(&singles, None, price);
    let double = best(&doubles, None, price);
    let mut accepted = match (single, double) {
        (Some(one), Some(two)) => Some(if pair_wins(&one, &two, price, finished) {
            two
        } else {
            one
        }),
        (one, two) => one.or(two),
    };
    while let Some(now) = &accepted {
        match with_another(&library, now, train, price, finished, &test_all) {
            Some(next) => accepted = Some(next),
            None => break,
        }
    }
    let pieces = |h: &Hypothesis| -> Vec<Tested> {
        let fit = |k| fitted_to(&train.without(k, PIECES), &library, h, train, test);
        (0..PIECES).map(fit).collect()
    };
    let rivals = match &mut accepted {
        Some(several) if several.effects.len() > 1 => {
            let much = train.has_much_left(several);
            without_equivalents(&library, several, much, price, &test_all, &pieces)
        }
        _ => Vec::new(),
    };
    let mut ranked = singles;
    ranked.extend(doubles);
    ranked.sort_by(|a, b| b.evidence.total_cmp(&a.evidence));
    if forced && accepted.is_none() {
        accepted = ranked.iter().find(|t| t.wrong.is_empty()).cloned();
    }
    Found {
        accepted,
        ranked,
        rivals,
    }
}

/// What is accepted with one more effect, if any is worth it, and the forms of all chosen again.
fn with_another(
    library: &Library,
    now: &Tested,
    train: &PreparedLog,
    price: f64,
    finished: &dyn Fn(&Tested) -> bool,
    test: &dyn Fn(&[Hypothesis]) -> Vec<Tested>,
) -> Option<Tested> {
    let (rest, much) = (train.left(now), train.has_much_left(now));
    if now.effects.len() >= MOST || (finished(now) && !much) {
        return None;
    }
    let more = test(&with_one_more(library, &parts_of(library, now), price));
    let next = best(&more, Some(now), price)?;
    if !is_worth_it(next.gain - now.gain, now.gain, rest, much) {
        return None;
    }
    let again = with_forms_reselected(library, parts_of(library, &next), price);
    let again = again.and_then(|h| test(&[h]).pop());
    Some(again.filter(|t| is_better(t, &next)).unwrap_or(next))
}

/// Whether the same effects in other forms explain significantly more, and not less of unseen data.
fn is_better(other: &Tested, than: &Tested) -> bool {
    other.wrong.is_empty()
        && other.gain > than.gain + SIGNIFICANT
        && other.gain_test >= than.gain_test
}

/// Whether a further effect is more than a detail of those before it.
fn is_worth_it(added: f64, gain: f64, rest: f64, much: bool) -> bool {
    added > ADDED * gain || (much && is_much(added, rest))
}

/// Whether a gain takes much of what is left.
pub(crate) fn is_much(gain: f64, rest: f64) -> bool {
    gain > OF_THE_REST * rest
}

/// Whether a pair is to be preferred to a single effect.
fn pair_wins(one: &Tested, two: &Tested, price: f64, finished: &dyn Fn(&Tested) -> bool) -> bool {
    if two.parameters <= one.parameters && two.evidence > one.evidence + SIMPLER {
        return true;
    }
    let added = two.gain - one.gain;
    let significant = added
        > SIGNIFICANT + 2.0 * price * (two.parameters - one.parameters.min(two.parameters)) as f64
        && two.gain_test - one.gain_test > CONFIRMED * added * ratio(one).min(1.0);
    significant && two.evidence > one.evidence && (added > ADDED * one.gain || !finished(one))
}

/// Gain on unseen data over gain on the log of the fit.
fn ratio(tested: &Tested) -> f64 {
    (tested.gain_test / tested.gain.max(1e-9)).max(0.0)
}

/// The best hypothesis that is accepted beside what there is already.
fn best(all: &[Tested], before: Option<&Tested>, price: f64) -> Option<Tested> {
    let (gain, gain_test, parameters) =
        before.map_or((0.0, 0.0, 0), |b| (b.gain, b.gain_test, b.parameters));
    let accepted: Vec<&Tested> = all
        .iter()
        .filter(|t| {
            let more = t.parameters.saturating_sub(parameters) as f64;
            t.wrong.is_empty()
                && t.beyond_rounding.0.min(t.beyond_rounding.1) > SIGNIFICANT
                && t.gain - gain > SIGNIFICANT + 2.0 * price * more
                && t.gain_test - gain_test > CONFIRMED * (t.gain - gain)
        })
        .collect();
    let top = accepted
        .iter()
        .max_by(|a, b| a.evidence.total_cmp(&b.evidence))?;
    // The simplest among those that explain the same but for details.
    let same =
        |t: &&&Tested| top.gain - t.gain < DETAIL * top.gain && t.parameters < top.parameters;
    let simplest = accepted.iter().filter(same).max_by(|a, b| {
        b.parameters
            .cmp(&a.parameters)
            .then(a.evidence.total_cmp(&b.evidence))
    });
    Some((**simplest.unwrap_or(top)).clone())
}

/// The best hypotheses, at most a few shapes of the same effects.
fn distinct(library: &Library, hypotheses: &[Hypothesis]) -> Vec<Hypothesis> {
    let mut kept: Vec<(Vec<&str>, Hypothesis)> = Vec::new();
    for hypothesis in hypotheses {
        if hypothesis.solution.gain < NEGLIGIBLE_GAIN {
            continue;
        }
        let mut ids: Vec<&str> = hypothesis
            .parts
            .iter()
            .map(|p| library.variants[p.variant].effect.id)
            .collect();
        ids.sort_unstable();
        let alike = kept.iter().filter(|k| k.0 == ids).count();
        if alike < 2 {
            kept.push((ids, hypothesis.clone()));
        }
        if kept.len() >= TRIED {
            break;
        }
    }
    kept.into_iter().map(|k| k.1).collect()
}
