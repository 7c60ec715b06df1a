//! What no named effect accounts for: how much of the error it is, and what can be said of it.

use super::ranking;
use super::verdict::Judged;
use crate::diagnose::finding::{Remainder, Verdict};
use crate::diagnose::noise::structure::Structure;
use crate::diagnose::stages::Stages;
use crate::diagnose::wrench::finding::WrenchFinding;
use crate::diagnose::wrench::left::RemainingStructure;
use crate::diagnose::wrench::{self, OtherSign, Ripple};
use softdock_physics::model::Channel;

/// Smallest share of a smooth remainder with which a quantity is mentioned.
const FOLLOWS: f64 = 0.1;

/// What no named effect accounts for.
pub(crate) struct Unaccounted {
    /// Its share, and what it follows.
    pub(crate) remainder: Remainder,
    /// Ids of general curves that it looks like.
    pub(crate) curves: Vec<String>,
    /// Ripples in the wrench: parts that repeat along an axis.
    pub(crate) ripples: Vec<Ripple>,
}

impl Unaccounted {
    pub(crate) fn new(stages: &Stages, left: &[RemainingStructure], judged: &Judged) -> Self {
        // A general curve is of interest only if structure is left beside it.
        let curves = match !judged.asked && left.iter().any(RemainingStructure::is_structured) {
            true => ranking::general_curves(stages),
            false => Vec::new(),
        };
        let (mut remainder, of_wrench) = remainder(stages, left);
        let ripples = match of_wrench {
            true => ripples(stages),
            false => Vec::new(),
        };
        if !ripples.is_empty() {
            remainder.follows = format!("{}; {}", each_ripple(&ripples), remainder.follows);
        }
        if judged.verdict == Verdict::Unexplained {
            say_other_sign(stages, &mut remainder);
        }
        Self {
            remainder,
            curves,
            ripples,
        }
    }

    /// Ids of what the error looks like, unproven: general curves, and what was found if nothing is named.
    pub(crate) fn looks_like(&self, judged: &Judged) -> Vec<String> {
        let found = judged.found.iter().filter(|_| judged.is_unnamed());
        self.curves.iter().chain(found).cloned().collect()
    }
}

/// What is left with structure of the channel that has most of it, and whether that is the wrench.
fn remainder(stages: &Stages, left: &[RemainingStructure]) -> (Remainder, bool) {
    let structured = left.iter().filter(|left| left.is_structured());
    let most = structured.max_by(|a, b| a.share.total_cmp(&b.share));
    let Some(most) = most else {
        return (Remainder::default(), false);
    };
    let of_wrench = most
        .axes
        .first()
        .is_some_and(|axis| axis.0 == Channel::Wrench);
    let found = stages.wrench.iter().filter(|_| of_wrench);
    let beside = found.filter_map(|found| found.beside_remainder.as_ref());
    let functions = beside.flat_map(|beside| &beside.remainder.follows);
    let words: Vec<String> = functions
        .filter(|(_, _, share)| *share > FOLLOWS)
        .map(|(axis, quantity, share)| {
            let (channel, words) = (Channel::Wrench, quantity.words());
            format!("{channel} {axis}: {:.0} % follows {words}", 100.0 * share)
        })
        .collect();
    let structure = most.structured().map(|(channel, axis, each)| {
        let words = each.last().map(Structure::words).unwrap_or_default();
        format!("{channel} {axis}: {words}")
    });
    let remainder = Remainder {
        share: most.share,
        allowed: most.allowed,
        follows: match words.is_empty() {
            true => structure.collect::<Vec<_>>().join("; "),
            false => words.join("; "),
        },
    };
    (remainder, of_wrench)
}

/// Ripples in what is left of the wrench.
fn ripples(stages: &Stages) -> Vec<Ripple> {
    let of = |found: &WrenchFinding| {
        let accepted = found.found.accepted.as_ref();
        wrench::ripples(&found.prepared, accepted, &found.structured_axes())
    };
    stages.wrench.as_ref().map_or(Vec::new(), of)
}

fn each_ripple(ripples: &[Ripple]) -> String {
    let of = |ripple: &Ripple| format!("{} {}: {}", Channel::Wrench, ripple.axis, ripple.words());
    ripples.iter().map(of).collect::<Vec<_>>().join("; ")
}

/// Adds the law that the rest of the reading would follow with a sign that physics forbids, if there is one.
fn say_other_sign(stages: &Stages, remainder: &mut Remainder) {
    let is_asked = |found: &&WrenchFinding| found.remaining_structure().is_structured();
    let other_sign = stages.wrench.as_ref().filter(is_asked).and_then(|found| {
        let accepted = found.found.accepted.clone().unwrap_or_default();
        wrench::other_sign(&found.prepared, &accepted)
    });
    if let Some(OtherSign { id, amount, share }) = other_sign {
        remainder.follows = format!(
            "{:.0} % of what is left of the wrench is like {id} with {amount}, whose sign physics forbids; an own hypothesis \
             can say what acts so; {}",
            100.0 * share,
            remainder.follows
        );
    }
}
