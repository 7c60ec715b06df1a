//! The answer of a case, and the text of `truth.json`.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value, json};

use crate::noise::NoiseRange;

/// The possible verdicts of a tool.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// The missing effects are these.
    Named,
    /// The model explains the logs.
    NothingMissing,
    /// Something is missing that no catalogue entry explains.
    Unexplained,
    /// The logs are not those of one machine.
    LogsDisagree,
    /// The logs cannot say.
    NotTestable,
}

/// Kind of a case. The labels easy, medium and hard of other sets are all [`Level::Single`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Level {
    /// One effect, exact parameters.
    #[serde(alias = "easy", alias = "medium", alias = "hard")]
    Single,
    /// Two effects.
    Compound,
    /// Nothing hidden.
    Null,
    /// Nothing hidden, parameters off within the declared tolerances.
    NullWithinTolerance,
    /// One effect, parameters off within the declared tolerances.
    SingleWithinTolerance,
    /// An effect that no catalogue contains.
    Outside,
    /// Three effects.
    Triple,
    /// One effect that is in only one of the two logs.
    OneLog,
    /// One effect whose residual is a tenth to a third of the noise.
    Small,
}

/// The answer of one case.
#[derive(Clone, Debug, PartialEq)]
pub struct Truth {
    /// Ids of the hidden effects.
    pub effects: Vec<String>,
    /// True sizes by effect and parameter, SI units.
    pub parameters: BTreeMap<String, BTreeMap<String, f64>>,
    /// Right verdict.
    pub expected: Verdict,
    /// Kind of the case.
    pub level: Level,
    /// Size factor; 1 leaves a residual of about 0.4 to 3 N rms. For [`Level::Small`] the residual itself, in multiples of
    /// the oracle's z. 0 if nothing is hidden, or unknown.
    pub size: f64,
    /// Noise of the case.
    pub noise: NoiseRange,
    /// z of [A, B, C, K] on the test log without the effect (same seed, same noise).
    pub z_oracle_test: [f64; 4],
    /// z of [A, B, C, K] on the test log under the nominal model.
    pub z_nominal_test: [f64; 4],
}

/// Ids of effects in other sets, and the corresponding ids of this one.
const ALIASES: [(&str, &str); 4] = [
    ("actuator_gain", "velocity_gain"),
    ("actuator_backlash", "backlash"),
    ("ft_lowpass", "ft_low_pass"),
    ("contact_stiffness_error", "contact_stiffness"),
];

/// The id of this set for an effect.
fn canonical(id: String) -> String {
    let known = ALIASES.iter().find(|(alias, _)| *alias == id);
    known.map_or(id, |(_, own)| (*own).to_owned())
}

/// Content of one entry of `truth.json`; other keys are ignored.
#[derive(Deserialize)]
struct Entry {
    effects: Vec<String>,
    #[serde(default)]
    params: BTreeMap<String, BTreeMap<String, Value>>,
    level: Level,
    expected: Verdict,
    #[serde(default)]
    size: f64,
    #[serde(default)]
    noise: NoiseRange,
    test: LogZ,
}

#[derive(Deserialize)]
struct LogZ {
    z_nominal: Channels,
    z_oracle: Channels,
}

/// z by channel.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "UPPERCASE")]
pub(crate) struct Channels {
    a: f64,
    b: f64,
    c: f64,
    k: f64,
}

impl From<Channels> for [f64; 4] {
    fn from(z: Channels) -> Self {
        [z.a, z.b, z.c, z.k]
    }
}

impl From<[f64; 4]> for Channels {
    fn from([a, b, c, k]: [f64; 4]) -> Self {
        Self { a, b, c, k }
    }
}

/// Reads a `truth.json`: an object with one entry per case.
///
/// # Errors
/// The position in the text, and what was expected there.
pub fn parse_truth(text: &str) -> Result<BTreeMap<String, Truth>, serde_json::Error> {
    let entries: BTreeMap<String, Entry> = serde_json::from_str(text)?;
    let truth = |entry: Entry| Truth {
        effects: entry.effects.into_iter().map(canonical).collect(),
        parameters: entry
            .params
            .into_iter()
            .map(|(id, values)| (canonical(id), flatten(values)))
            .collect(),
        expected: entry.expected,
        level: entry.level,
        size: entry.size,
        noise: entry.noise,
        z_oracle_test: entry.test.z_oracle.into(),
        z_nominal_test: entry.test.z_nominal.into(),
    };
    Ok(entries.into_iter().map(|(k, v)| (k, truth(v))).collect())
}

/// Numbers under their names, arrays as `name_0`, `name_1`, ...; texts are left out.
fn flatten(values: BTreeMap<String, Value>) -> BTreeMap<String, f64> {
    let mut flat = BTreeMap::new();
    let mut open: Vec<(String, Value)> = values.into_iter().collect();
    while let Some((name, value)) = open.pop() {
        match value {
            Value::Number(number) => {
                if let Some(number) = number.as_f64() {
                    flat.insert(name, number);
                }
            }
            Value::Array(items) => {
                open.extend(
                    (0..)
                        .zip(items)
                        .map(|(i, item)| (format!("{name}_{i}"), item)),
                );
            }
            _ => {}
        }
    }
    flat
}

/// Text of a `truth.json`.
#[must_use]
pub fn truth_json<'a>(cases: impl IntoIterator<Item = (&'a str, &'a Truth)>) -> String {
    let entries: Map<String, Value> = cases
        .into_iter()
        .map(|(name, truth)| (name.to_owned(), entry(truth)))
        .collect();
    format!("{:#}", Value::Object(entries))
}

fn entry(truth: &Truth) -> Value {
    json!({
        "effects": truth.effects,
        "params": truth.parameters,
        "level": truth.level,
        "expected": truth.expected,
        "size": truth.size,
        "noise": truth.noise,
        "test": {
            "z_nominal": Channels::from(truth.z_nominal_test),
            "z_oracle": Channels::from(truth.z_oracle_test),
        },
    })
}
