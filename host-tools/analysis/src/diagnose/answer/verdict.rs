//! The verdict of a diagnosis, from what the stages found.

use crate::diagnose::finding::Verdict;
use crate::diagnose::question::Question;
use crate::diagnose::stages::Stages;
use crate::diagnose::wrench::left::RemainingStructure;
use softdock_physics::model::prediction::Prediction;
use softdock_physics::model::{Channel, Model};

/// All on which the verdict depends.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Grounds {
    /// The logs hold something that a model can be held against.
    pub testable: bool,
    /// Effects were found.
    pub found: bool,
    /// What is missing differs from log to log.
    pub disagree: bool,
    /// Structure is left beside what was found.
    pub left: bool,
    /// There is no unseen log: effects are judged on the data of their fit.
    pub in_sample: bool,
    /// One effect was asked for. It is answered whatever else is missing.
    pub asked: bool,
}

impl Grounds {
    /// Whether something is left without a name. Beside found effects this needs an unseen log to show it.
    pub(crate) const fn unexplained(self) -> bool {
        self.left && !self.asked && !(self.in_sample && self.found)
    }

    /// The verdict.
    pub(crate) const fn verdict(self) -> Verdict {
        if !self.testable {
            Verdict::NotTestable
        } else if self.disagree && !self.asked {
            Verdict::LogsDisagree
        } else if self.unexplained() {
            Verdict::Unexplained
        } else if self.found {
            Verdict::Named
        } else {
            Verdict::NothingMissing
        }
    }
}

/// The verdict, and its grounds.
pub(crate) struct Judged {
    /// Effects that the stages found, whether they may be named or not.
    pub(crate) found: Vec<String>,
    /// Ids of effects about which the logs disagree.
    pub(crate) disagreeing: Vec<String>,
    /// The sentence for logs that cannot be tested.
    pub(crate) untestable: &'static str,
    pub(crate) verdict: Verdict,
    /// Something is left without a name.
    pub(crate) unexplained: bool,
    /// Only one effect was asked for.
    pub(crate) asked: bool,
}

impl Judged {
    pub(crate) fn new(
        model: &Model,
        stages: &Stages,
        question: &Question<'_>,
        found: Vec<String>,
        left: &[RemainingStructure],
        in_sample: bool,
    ) -> Self {
        let disagreeing = match question.of_one_log {
            true => Vec::new(),
            false => disagreeing(stages),
        };
        let (anything, any_left) = (!found.is_empty(), left.iter().any(RemainingStructure::any));
        let stands_still = !anything && !any_left && stands_still(model, stages);
        let asked = question.is_asked();
        let grounds = Grounds {
            testable: lacking(stages).len() < TESTED && !stands_still,
            found: anything,
            disagree: !disagreeing.is_empty(),
            left: any_left,
            in_sample,
            asked,
        };
        Self {
            found,
            disagreeing,
            untestable: untestable(stages, stands_still),
            verdict: grounds.verdict(),
            unexplained: grounds.unexplained(),
            asked,
        }
    }

    /// Whether the verdict is one with which found effects are not named.
    pub(crate) fn is_unnamed(&self) -> bool {
        matches!(self.verdict, Verdict::Unexplained | Verdict::LogsDisagree)
    }

    pub(crate) fn named(&self) -> &[String] {
        if self.is_unnamed() { &[] } else { &self.found }
    }
}

/// The sentence for logs that cannot be tested.
fn untestable(stages: &Stages, stands_still: bool) -> &'static str {
    if stands_still {
        return "The logs cannot say what is missing: the rig stands still in them. Record a run in which it moves.";
    }
    if stages.logs.have_one_load() {
        return "The logs cannot say what is missing: the load of what moves is the same from beginning to end, and whatever predicts a constant \
                from the motion has a small error. Record runs in which it changes, or several with a constant load that differ in \
                it; effects that you know are there are fitted by name (softdock add EFFECT EFFECT ..), and the error simulated \
                forward says how right they are.";
    }
    "The logs cannot say what is missing: they hold neither commanded velocities, nor a wrench, nor velocities of the model of the \
     spacecraft. What swings freely has a wrench of zero: import it with wrench = \"free\" in [starter] of the mapping."
}

/// Whether nothing moves in any log. Readings at rest show the zero of a sensor and a drift of it, and nothing else.
fn stands_still(model: &Model, stages: &Stages) -> bool {
    let mut logs = stages.logs.all.iter();
    !model.sensor.at_rest && logs.all(|log| log.rests(&model.noise))
}

/// Effects of all stages about which the logs disagree.
fn disagreeing(stages: &Stages) -> Vec<String> {
    let actuator = stages.actuator.iter().flat_map(|a| &a.disagreeing);
    let wrench = stages.wrench.iter().flat_map(|w| &w.found.disagreeing);
    let body = stages.body.accepted.iter().filter(|fit| fit.disagrees);
    let all = actuator.chain(wrench).map(|disagreement| disagreement.id);
    let all = all.chain(body.map(|fit| fit.id));
    let mut ids: Vec<String> = Vec::new();
    for id in all {
        if !ids.iter().any(|known| known == id) {
            ids.push(id.to_owned());
        }
    }
    ids
}

/// Reported for logs of a rig only.
const NO_SPACECRAFT: &str =
    "The model of the spacecraft is not tested: the logs hold no velocities of it.";

/// Number of signals that a log may lack: commands, a wrench, velocities of the spacecraft's model.
const TESTED: usize = 3;

/// Whether the controller of a rig wrote any of the logs.
pub(crate) fn of_a_rig(stages: &Stages) -> bool {
    stages.logs.all.iter().any(|log| log.of_a_rig)
}

/// For each part that cannot be tested on these logs: a sentence with the reason.
fn lacking(stages: &Stages) -> Vec<&'static str> {
    let mut all = Vec::new();
    if stages.actuator.is_none() && !is_driven(stages) {
        all.push("The actuator is not tested: the logs hold no commanded velocities.");
    }
    if stages.wrench.is_none() {
        all.push(match stages.logs.have_one_load() {
            true => {
                "The mechanism, the tool and the sensor are not tested: the load never changes."
            }
            false => {
                "The mechanism, the tool and the sensor are not tested: the logs hold no wrench."
            }
        });
    }
    let model_velocity = |p: &Prediction| {
        let channel = p.channel(Channel::ModelVelocity);
        channel.predicted.iter().any(Option::is_some)
    };
    if !stages.before.all.iter().all(model_velocity) {
        all.push(NO_SPACECRAFT);
    }
    all
}

/// The same without what such logs cannot hold. Velocities of spacecraft are missed only in logs of a rig that have a wrench: the
/// log of a servo has commands only.
pub(crate) fn untested(stages: &Stages) -> impl Iterator<Item = &'static str> {
    let of_a_rig = of_a_rig(stages) && stages.wrench.is_some();
    let all = lacking(stages).into_iter();
    all.filter(move |lack| of_a_rig || *lack != NO_SPACECRAFT)
}

/// Whether the wrench of a log is what drives its motion.
pub(crate) fn is_driven(stages: &Stages) -> bool {
    let mut logs = stages.wrench.iter().flat_map(|w| &w.prepared.logs);
    logs.any(|log| log.scene.model.sensor.wrench.drives())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every combination of grounds, against a second statement of the rules.
    #[test]
    fn each_combination_has_the_end_that_is_promised() {
        for bits in 0..64_u8 {
            let [testable, found, disagree, left, in_sample, asked] =
                std::array::from_fn(|n| bits >> n & 1 == 1);
            let grounds = Grounds {
                testable,
                found,
                disagree,
                left,
                in_sample,
                asked,
            };
            let expected = match (testable, disagree, left, asked, found, in_sample) {
                (false, ..) => Verdict::NotTestable,
                (true, true, _, false, ..) => Verdict::LogsDisagree,
                (true, false, true, false, false, _) => Verdict::Unexplained,
                (true, false, true, false, true, false) => Verdict::Unexplained,
                (true, _, _, _, true, _) => Verdict::Named,
                (true, _, _, _, false, _) => Verdict::NothingMissing,
            };
            assert_eq!(grounds.verdict(), expected, "{grounds:?}");
            let nameless = left && !asked && (!found || !in_sample);
            assert_eq!(grounds.unexplained(), nameless, "{grounds:?}");
        }
    }
}
