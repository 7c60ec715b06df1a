//! Hypotheses of one, two or more effects on the reading: which columns of each effect are used, and the evidence of the whole.

use super::problem::{Best, Solution, best_gain, solve};
use super::variants::{Library, Variant};
use crate::diagnose::evidence;
use rayon::prelude::*;
use softdock_physics::effects::Effect;
use softdock_physics::model::load::effects::Sign;
use std::collections::BTreeMap;

/// Gain in χ² that the first column of a separable effect (one with a column for each axis, say) has to bring.
const WORTH_A_COLUMN: f64 = 25.0;
/// The same for further columns: that the effect is there is known by then.
const WORTH_ONE_MORE: f64 = 14.0;
/// A column of a detail is used only if more than this share of its square cannot be imitated by the columns before it: a
/// friction level by direction beside the common level of the model, or a viscous difference beside a viscous friction.
const OWN: f64 = 0.05;
/// Pairs that are kept.
const KEPT: usize = 96;
/// Hypotheses of the same effects, in other shapes, that are kept.
pub(crate) const ALIKE: usize = 2;

/// One effect of a hypothesis: which variant, and which of its columns.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Part {
    /// Place in [`Library::variants`].
    pub variant: usize,
    /// Which of the variant's columns are used.
    pub used: Vec<usize>,
}

/// A hypothesis with its evidence.
#[derive(Clone, Debug)]
pub(crate) struct Hypothesis {
    /// One effect, or more.
    pub parts: Vec<Part>,
    /// Best coefficients.
    pub solution: Solution,
    /// Gain less the price of the parameters and the prior odds of the effects.
    pub evidence: f64,
    /// Number of parameters, scanned ones included.
    pub parameters: usize,
}

/// Whether two effects are the same, or of the same kind.
fn is_redundant(one: &Effect, other: &Effect) -> bool {
    one == other || (one.kind.is_some() && one.kind == other.kind)
}

/// Whether the used columns of an effect have a meaning beside the other parts and the effects of the model.
fn is_whole(library: &Library, part: &Part, parts: &[Part]) -> bool {
    let effect = library.variants[part.variant].effect.effect;
    let there = |id: &str| {
        let mut ids = parts.iter().map(|p| library.variants[p.variant].effect.id);
        library.known.iter().any(|known| known == id) || ids.any(|other| other == id)
    };
    (effect.is_whole)(&part.used, &there) && !stands_twice(library, part, parts)
}

/// Whether this part is a detail of another part, in coefficients that it uses: friction levels by direction beside the common
/// level would be a second dry friction, with a transition speed of its own.
fn stands_twice(library: &Library, part: &Part, parts: &[Part]) -> bool {
    let id = |part: &Part| library.variants[part.variant].effect.id;
    let mut details = library.variants[part.variant]
        .effect
        .effect
        .detail_of
        .iter();
    details.any(|(of, sizes)| {
        let uses = |k: &usize| sizes.get(*k).is_some_and(|size| *size != 0.0);
        part.used.iter().any(uses) && parts.iter().any(|other| id(other) == *of)
    })
}

/// Columns and signs of parts, in their order.
fn flat(library: &Library, parts: &[Part]) -> (Vec<usize>, Vec<Sign>) {
    let mut columns = Vec::new();
    let mut signs = Vec::new();
    for part in parts {
        let variant = &library.variants[part.variant];
        for &k in &part.used {
            columns.push(variant.columns[k]);
            signs.push(variant.signs[k]);
        }
    }
    (columns, signs)
}

/// Solves for the coefficients of parts. `price` is that of one parameter. `None` if a part has no meaning of its own, or the
/// data do not determine the coefficients.
pub(crate) fn evaluate(library: &Library, parts: Vec<Part>, price: f64) -> Option<Hypothesis> {
    if !parts.iter().all(|part| is_whole(library, part, &parts)) {
        return None;
    }
    let (columns, signs) = flat(library, &parts);
    let solution = solve(&library.gram, &library.right, &columns, &signs)?;
    let open = signs.iter().filter(|s| **s != Sign::One).count();
    let mut parameters = open;
    let mut selection = 0.0;
    for part in &parts {
        let variant = &library.variants[part.variant];
        parameters += variant.scanned();
        if variant.effect.effect.separable {
            // To choose some of several columns costs evidence, too.
            selection += 2.0 * part.used.len() as f64 * (variant.columns.len() as f64).ln();
        }
    }
    let prior = evidence::prior() * parts.len() as f64;
    let evidence = solution.gain - price * parameters as f64 - selection - prior;
    Some(Hypothesis {
        parts,
        solution,
        evidence,
        parameters,
    })
}

/// The columns of a separable variant that are worth their price beside given columns: either the one that is common to all axes
/// alone, or one for each axis. Beside a common gain that of one axis would be a deviation from it, and nobody would read it so.
fn grown(library: &Library, variant: &Variant, beside: &[usize], signs: &[Sign]) -> Vec<usize> {
    let coefficients = &variant.effect.coefficients;
    let common = |k: &usize| coefficients.get(*k).is_some_and(|c| c.common);
    let all: Vec<usize> = (0..variant.columns.len()).collect();
    let used = grown_from(&all, library, variant, beside, signs);
    if used.len() < 2 || !used.iter().any(common) {
        return used;
    }
    let own: Vec<usize> = all.into_iter().filter(|k| !common(k)).collect();
    grown_from(&own, library, variant, beside, signs)
}

/// The same, from `allowed` columns only, added one at a time.
fn grown_from(
    allowed: &[usize],
    library: &Library,
    variant: &Variant,
    beside: &[usize],
    signs: &[Sign],
) -> Vec<usize> {
    let mut used: Vec<usize> = Vec::new();
    let gain = |used: &[usize]| -> f64 {
        let mut columns = beside.to_vec();
        let mut all_signs = signs.to_vec();
        for &k in used {
            columns.push(variant.columns[k]);
            all_signs.push(variant.signs[k]);
        }
        let detail = variant.effect.effect.is_detail();
        let forbidden = |s: &Best| s.wrong.iter().any(|k| *k >= beside.len());
        best_gain(&library.gram, &library.right, &columns, &all_signs)
            // For a detail a forbidden sign is refused, as the column of the other direction gains the same with a sign that
            // physics allows. So is a further column of forbidden sign: the effect does without it.
            .filter(|s| !detail || s.own > OWN)
            .filter(|s| !(detail || used.len() > 1) || !forbidden(s))
            .map_or(f64::NEG_INFINITY, |s| s.gain)
    };
    let mut reached = if beside.is_empty() { 0.0 } else { gain(&[]) };
    while used.len() < allowed.len() {
        let open = allowed.iter().copied();
        let best = open
            .filter(|k| !used.contains(k))
            .map(|k| {
                let mut more = used.clone();
                more.push(k);
                (gain(&more), k)
            })
            .max_by(|a, b| a.0.total_cmp(&b.0));
        match best {
            Some((value, k)) if value - reached > worth(used.len()) => {
                reached = value;
                used.push(k);
            }
            _ => break,
        }
    }
    used.sort_unstable();
    used
}

fn worth(columns: usize) -> f64 {
    if columns == 0 {
        WORTH_A_COLUMN
    } else {
        WORTH_ONE_MORE
    }
}

/// A variant as a part beside other parts, with the columns that are worth their price there; `None` if there are none.
fn part(library: &Library, index: usize, beside: &[Part]) -> Option<Part> {
    let variant = &library.variants[index];
    let whole = |used: &Vec<usize>| {
        let part = Part {
            variant: index,
            used: used.clone(),
        };
        is_whole(library, &part, beside)
    };
    let used = if variant.effect.effect.separable {
        let (columns, signs) = flat(library, beside);
        let grown = grown(library, variant, &columns, &signs);
        // A column that is not worth its price may be what gives another one a meaning.
        let more = |k: usize| {
            let mut used = grown.clone();
            used.push(k);
            used.sort_unstable();
            used.dedup();
            used
        };
        let all = (0..variant.columns.len()).map(more);
        let grown_is_whole = grown.is_empty() || whole(&grown);
        let extended = || all.into_iter().find(whole);
        if grown_is_whole { grown } else { extended()? }
    } else {
        (0..variant.columns.len()).collect()
    };
    (!used.is_empty()).then_some(Part {
        variant: index,
        used,
    })
}

/// All hypotheses that add one effect to given parts, best first.
pub(crate) fn with_one_more(library: &Library, beside: &[Part], price: f64) -> Vec<Hypothesis> {
    let taken = |index: usize| {
        let effect = |variant: usize| library.variants[variant].effect.effect;
        let mut there = beside.iter();
        there.any(|p| is_redundant(effect(p.variant), effect(index)))
    };
    let mut all: Vec<Hypothesis> = (0..library.variants.len())
        .into_par_iter()
        .filter(|index| !taken(*index))
        .filter_map(|index| {
            let mut parts = beside.to_vec();
            parts.push(part(library, index, beside)?);
            evaluate(library, parts, price)
        })
        .collect();
    all.sort_by(|a, b| b.evidence.total_cmp(&a.evidence));
    all
}

/// The best pairs of different effects, best first; both are chosen together.
pub(crate) fn pairs(library: &Library, price: f64) -> Vec<Hypothesis> {
    let count = library.variants.len();
    // An effect that explains nothing alone may do so beside another one that hides it.
    let whole = |variant: usize| Part {
        variant,
        used: (0..library.variants[variant].columns.len()).collect(),
    };
    let alone: Vec<Part> = (0..count)
        .into_par_iter()
        .map(|i| part(library, i, &[]).unwrap_or_else(|| whole(i)))
        .collect();
    let effect = |i: usize| library.variants[i].effect.effect;
    let pair = |i: usize, k: usize| {
        let beside = |one: usize, two: usize| {
            let parts = grown_pair(library, &alone[one], two)?;
            evaluate(library, parts, price).filter(|h| h.solution.wrong.is_empty())
        };
        let ways = match [i, k].map(|one| effect(one).separable) {
            [true, true] => [beside(i, k), beside(k, i)],
            [true, false] => [beside(k, i), None],
            [false, _] => [beside(i, k), None],
        };
        let ways = ways.into_iter().flatten();
        ways.max_by(|a, b| a.evidence.total_cmp(&b.evidence))
    };
    let mut best: Vec<Hypothesis> = (0..count)
        .into_par_iter()
        .flat_map_iter(|i| {
            let others = (i + 1..count).filter(|k| !is_redundant(effect(i), effect(*k)));
            best_of_each(library, others.filter_map(|k| pair(i, k)))
        })
        .collect();
    best.sort_by(|a, b| b.evidence.total_cmp(&a.evidence));
    // An effect with many shapes must not crowd out other pairs.
    let mut counts: BTreeMap<Vec<&str>, usize> = BTreeMap::new();
    best.retain(|pair| {
        let count = counts.entry(ids(library, pair)).or_default();
        *count += 1;
        *count <= ALIKE
    });
    best.truncate(KEPT);
    best
}

/// Ids of the effects of a hypothesis, sorted.
pub(crate) fn ids(library: &Library, hypothesis: &Hypothesis) -> Vec<&'static str> {
    let parts = hypothesis.parts.iter();
    let mut ids: Vec<&str> = parts
        .map(|part| library.variants[part.variant].effect.id)
        .collect();
    ids.sort_unstable();
    ids
}

/// A pair of effects. The columns of a separable second effect are chosen beside the first one; those of a separable first effect
/// are then chosen again, as beside the second other columns may be needed than alone.
fn grown_pair(library: &Library, one: &Part, other: usize) -> Option<Vec<Part>> {
    let two = part(library, other, std::slice::from_ref(one))?;
    let one = match library.variants[one.variant].effect.effect.separable {
        true => part(library, one.variant, std::slice::from_ref(&two))?,
        false => one.clone(),
    };
    Some(vec![one, two])
}

/// The best hypothesis of each pair of effects.
fn best_of_each(library: &Library, found: impl Iterator<Item = Hypothesis>) -> Vec<Hypothesis> {
    let mut best: BTreeMap<Vec<&str>, Hypothesis> = BTreeMap::new();
    for new in found {
        let known = best
            .entry(ids(library, &new))
            .or_insert_with(|| new.clone());
        if new.evidence > known.evidence {
            *known = new;
        }
    }
    best.into_values().collect()
}
