//! The result of a diagnosis.

use super::evidence::{NAMED, TOLD_APART};
use crate::levels::{BeforeAfter, Step};
use serde::{Deserialize, Serialize};
use softdock_physics::model::{Axis, Channel};
use softdock_report::number;
use std::collections::BTreeMap;

/// The verdict of a diagnosis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// Effects of the catalogue account for the error.
    Named,
    /// What remains is noise or, beside effects that the model file has, nothing that an effect of the catalogue describes
    /// better than a smooth remainder.
    NothingMissing,
    /// There is structure left that no effect of the catalogue accounts for.
    Unexplained,
    /// The logs are not of one machine in one state: what is missing differs from log to log.
    LogsDisagree,
    /// The logs hold nothing that a model could be held against, or nothing that changes.
    NotTestable,
}

/// A parameter with its 95 % interval.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Estimate {
    /// Best value.
    pub value: f64,
    /// SI unit, `-` if it has none.
    pub unit: String,
    /// Lower end of the interval.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

/// A nominal parameter as the logs see it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Nominal {
    /// Best value, SI.
    pub value: f64,
    /// Lower end of its 95 % interval.
    pub low: f64,
    /// Upper end.
    pub high: f64,
    /// How far it is from the value in the model, in tolerances.
    pub tolerances: f64,
}

/// What the named effects leave beyond the noise.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Remainder {
    /// Share of the squared error beyond the noise that is left, on the channel where it is largest; 0 to 1.
    pub share: f64,
    /// Share that may be left with effects being named.
    pub allowed: f64,
    /// The quantity that it follows, or where and when it shows, in words; empty if it is not told from noise.
    pub follows: String,
}

/// Parameters of effects: by effect id, then by name.
pub type Parameters = BTreeMap<String, BTreeMap<String, Estimate>>;

/// A hypothesis at the moment when it is tried.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Trial {
    /// Its effects.
    pub effects: Vec<String>,
    /// Channel in which they act.
    pub channel: Channel,
    /// Fall of χ² over all logs.
    pub gain: f64,
}

/// A hypothesis and its evidence.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Ranked {
    /// Ids of its effects.
    pub effects: Vec<String>,
    /// Ids of effects beside which these were tried: those of the model, and of earlier rounds.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub beside: Vec<String>,
    /// Channel in which they act.
    pub channel: Channel,
    /// Fall of χ² on the log of the fit.
    pub gain_train: f64,
    /// Fall of χ² on unseen data with the same parameters.
    pub gain_test: f64,
    /// Number of parameters, scanned ones included.
    pub parameters: usize,
    /// The named effect in whose place one of these stands and from which it cannot be told on these logs.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub as_good_as: Option<String>,
    /// Why it is not named although it fits.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub refused: Option<String>,
}

impl Ranked {
    /// Fall of χ² over all logs.
    pub(super) fn fall(&self) -> f64 {
        self.gain_train + self.gain_test
    }
}

/// First words of the note about parameters for which unseen data were used.
const OF_ALL_LOGS: &str = "The parameters are those of all logs";
/// Separates the ids of effects that are one rival together.
pub const TOGETHER: &str = " + ";

/// The closest rival of what is named.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RunnerUp {
    /// Its id; if two effects are one rival together, both ids with [`TOGETHER`] between them.
    pub effect: String,
    /// Id of the named effect whose rival it is.
    pub of: String,
    /// By how much less χ² falls with it, over all logs.
    pub behind: f64,
    /// The log tells the two apart.
    pub told_apart: bool,
    /// Evidence against it, scaled so that errors of form count as noise does.
    #[serde(skip)]
    pub evidence: f64,
    /// Further effects from which the log does not tell the named one: of a motion in one direction a dry friction is an offset.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub ties: Vec<Tie>,
}

impl RunnerUp {
    /// The rival and its place, in words.
    pub fn in_words(&self) -> String {
        format!("{} in the place of {}", self.effect, self.of)
    }

    /// By how much less χ² falls with it, and what follows, in words.
    pub fn compared(&self) -> String {
        let falls = match self.behind >= 1.0 {
            true => format!("{} less", number::significant(self.behind, 3)),
            false => "as much".to_owned(),
        };
        let follows = match self.told_apart {
            true if self.behind >= TOLD_APART => "the logs tell the two apart",
            true => "beside the other effects it explains too little to stand there",
            false if self.behind > NAMED => {
                "errors of the laws may make such a difference, and the logs do not tell the two apart"
            }
            false => "the logs do not tell the two apart",
        };
        format!("with it χ² falls by {falls} over all logs; {follows}")
    }

    /// Adds another rival in the same place to its ties.
    pub(super) fn join(&mut self, other: Self) {
        self.ties.push(Tie {
            effect: other.effect,
            behind: other.behind,
            evidence: other.evidence,
        });
    }

    /// Evidence against all rivals in this place together: the sum of their odds.
    pub(super) fn against(&self) -> f64 {
        let each = self.ties.iter().map(|tie| tie.evidence);
        let odds = each.chain([self.evidence]).map(|e| (-0.5 * e).exp());
        -2.0 * odds.sum::<f64>().ln()
    }

    /// All effects from which the log does not tell the named one.
    pub fn not_told_from(&self) -> impl Iterator<Item = &str> {
        let own = (!self.told_apart).then_some(self.effect.as_str());
        own.into_iter()
            .chain(self.ties.iter().map(|tie| tie.effect.as_str()))
    }
}

/// An effect that does nearly as much in the place of a named one.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Tie {
    /// Its id.
    pub effect: String,
    /// By how much less χ² falls with it.
    pub behind: f64,
    /// Evidence against it, as of the runner-up.
    #[serde(skip)]
    pub evidence: f64,
}

/// An experiment that would tell winner and runner-up apart.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Experiment {
    /// What to do, in words.
    pub sentence: String,
    /// 2 Δ log L between the two on these logs.
    pub separation_now: f64,
    /// The same to be expected with the experiment, if it was rehearsed on the simulated rig.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub separation_then: Option<f64>,
    /// A command that runs the experiment on the simulated rig; empty if there is none.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub command: String,
}

/// A window in which an error shows that is unexplained, or that the named effects explain.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Region {
    /// Channel.
    pub channel: Channel,
    /// Axis.
    pub axis: Axis,
    /// Begin, s.
    pub from_s: f64,
    /// End, s.
    pub to_s: f64,
    /// What happens in this window, in words.
    pub regime: String,
}

/// The largest evidence of any effect that may be named, by the stage that tests it; it is named from a limit on. `None` where
/// nothing was tested, or nothing gained enough to be refined.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct StrongestEvidence {
    /// Between sent and executed velocity.
    pub actuator: Option<f64>,
    /// On the reading.
    pub wrench: Option<f64>,
    /// In the rig's model of the spacecraft.
    pub body: Option<f64>,
}

/// The noise that a log shows, and that of the data sheet.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct NoiseFloor {
    /// Channel.
    pub channel: Channel,
    /// Axis.
    pub axis: Axis,
    /// Standard deviation that the log shows, SI.
    pub measured: f64,
    /// Standard deviation by data sheet, SI.
    pub data_sheet: f64,
}

/// Effects that are equivalent to some of the named ones together.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Equivalent {
    /// Ids of the named ones.
    pub of: Vec<String>,
    /// The equivalent effects with their parameters.
    pub parameters: Parameters,
    /// What is equivalent to what, in words.
    pub sentence: String,
}

/// Result of a diagnosis.
#[derive(Clone, Debug, Serialize)]
pub struct Diagnosis {
    /// What is missing, in a sentence or two.
    pub sentence: String,
    /// The verdict.
    pub verdict: Verdict,
    /// Ids of the named effects, the largest share of the error first.
    pub effects: Vec<String>,
    /// Probability of each named effect.
    pub probability: BTreeMap<String, f64>,
    /// Their parameters.
    pub parameters: Parameters,
    /// Nominal parameters about which the logs say something, by name.
    pub nominal: BTreeMap<String, Nominal>,
    /// What is left without a name.
    pub remainder: Remainder,
    /// Ids of effects about which the logs disagree.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub disagreeing: Vec<String>,
    /// Effects that are equivalent to named ones, if there are any.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub equivalent: Option<Equivalent>,
    /// Error before and after.
    pub residual_rms_sigma: BeforeAfter,
    /// The error's fall, effect by effect.
    pub steps: Vec<Step>,
    /// The closest rival.
    pub runner_up: Option<RunnerUp>,
    /// Rivals of the other named effects ([`RunnerUp::of`]) that the logs do not tell from these.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub further_ties: Vec<RunnerUp>,
    /// The experiment that would tell the runner-up from the named effect.
    pub experiment: Option<Experiment>,
    /// Where the error shows: what is left if it is unexplained, else what was explained.
    #[serde(rename = "where")]
    pub regions: Vec<Region>,
    /// Partial matches and general curves (phenomenological shapes): hints, and never names.
    pub looks_like: Vec<String>,
    /// Hypotheses, the likeliest first.
    pub ranked: Vec<Ranked>,
    /// The largest evidence of each stage, whether that effect is named or not.
    pub strongest_evidence: StrongestEvidence,
    /// Noise floor per channel and axis.
    pub noise: Vec<NoiseFloor>,
    /// Notes for the reader.
    pub notes: Vec<String>,
    /// Whether unseen data was given; else the end of the log was held back.
    pub unseen: bool,
    /// The error is that on the logs of the fit, as there are no others and their ends move too little to be held back.
    pub in_sample: bool,
    /// Why the parameters are those of all logs, the unseen ones among them, if they are.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub of_all_logs: Option<String>,
    /// Time that it took, s.
    pub seconds: f64,
}

impl Diagnosis {
    /// States that the parameters are those of all logs, and why.
    pub(crate) fn is_of_all_logs(&mut self, why: String) {
        let test = if self.unseen {
            "those of --test"
        } else {
            "the end of the log"
        };
        self.notes.push(format!(
            "{OF_ALL_LOGS}, also of {test} ({why}). So they have seen what the error is told of; `softdock compare` with a further log \
             says how they foretell."
        ));
        self.of_all_logs = Some(why);
    }

    /// States that the parameters are those of the logs of the fit.
    pub(crate) fn is_of_fit(&mut self) {
        self.of_all_logs = None;
        self.notes.retain(|note| !note.starts_with(OF_ALL_LOGS));
    }
}

#[cfg(test)]
mod tests {
    use super::super::evidence::probability;
    use super::*;

    /// In a motion in one direction four effects do the same, and share the probability that the catalogue contains it at all.
    #[test]
    fn what_is_not_told_from_three_others_is_a_quarter() {
        let tie = |effect: &str, behind: f64| Tie {
            effect: effect.to_owned(),
            behind,
            evidence: behind,
        };
        let mut rival = RunnerUp {
            effect: "guide_offset".to_owned(),
            of: "guide_coulomb".to_owned(),
            behind: 0.0,
            told_apart: false,
            evidence: 0.0,
            ties: vec![tie("ft_bias", 0.0), tie("guide_viscous", 0.0)],
        };
        let share = probability(rival.against(), false) / probability(f64::INFINITY, false);
        assert!((share - 0.25).abs() < 1e-9, "{share}");
        let others: Vec<&str> = rival.not_told_from().collect();
        assert_eq!(others, ["guide_offset", "ft_bias", "guide_viscous"]);
        rival.told_apart = true;
        assert_eq!(rival.not_told_from().count(), 2);
    }
}
