//! A benchmark as the base of a campaign: its rows in shards, on one machine or on many.
//!
//! A row is one law on one case at one speed, or the diagnosis of one pair of logs in which an effect is hidden. Each draw
//! has another seed, so that `samples` sets the size of the benchmark.

use super::distribution::Distribution;
use super::outcome::{Outcome, Status};
use crate::bench::delay::case::Case;
use crate::bench::delay::{cases, run};
use crate::bench::diagnose;
use anyhow::{Context, Result, ensure};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use softdock_control::delay::LawName;
use softdock_hidden_effects::suite;
use softdock_io::shell::quoted;

/// The benchmark of a campaign.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Bench {
    /// `softdock bench delay`: every delay law on the same plants.
    Delay,
    /// `softdock bench diagnose`: effects hidden in logs.
    Diagnose,
}

impl Bench {
    /// The factors: names of columns, each with its values. Without chosen cases or laws, all are taken.
    ///
    /// # Errors
    /// A case does not exist.
    pub fn factors(
        self,
        chosen_cases: &[String],
        chosen_laws: &[LawName],
    ) -> Result<Vec<(&'static str, Distribution)>> {
        let list =
            |words: Vec<String>| Distribution::List(words.into_iter().map(Value::String).collect());
        let asked = |names: &[&str]| {
            let none = |name: &&String| !names.contains(&name.as_str());
            let unknown = chosen_cases.iter().find(none);
            ensure!(
                unknown.is_none(),
                "`cases`: there is no case `{}`; there are {}",
                unknown.map_or("", |name| name),
                names.join(", ")
            );
            Ok(())
        };
        match self {
            Self::Delay => {
                let all = cases::all();
                let mut names: Vec<&str> = all.iter().map(|case| case.sweep).collect();
                names.dedup();
                names.extend(all.iter().map(|case| case.name.as_str()));
                asked(&names)?;
                let chosen = all.iter().filter(|case| {
                    chosen_cases.is_empty() || chosen_cases.iter().any(|name| case.is_called(name))
                });
                let at = |case: &Case| {
                    let speeds = case.speeds_mm_s.iter();
                    speeds.map(|speed| word(case, *speed)).collect::<Vec<_>>()
                };
                let laws = match chosen_laws.is_empty() {
                    true => LawName::ALL.to_vec(),
                    false => chosen_laws.to_vec(),
                };
                let laws = laws.iter().map(|law| law.name().to_owned());
                Ok(vec![
                    ("law", list(laws.collect())),
                    ("case", list(chosen.flat_map(at).collect())),
                ])
            }
            Self::Diagnose => {
                let all = suite(1);
                let names: Vec<&str> = all.iter().map(|spec| spec.name()).collect();
                asked(&names)?;
                let chosen = |name: &&str| {
                    chosen_cases.is_empty() || chosen_cases.iter().any(|case| case == name)
                };
                let chosen = names.into_iter().filter(chosen).map(str::to_owned);
                Ok(vec![("case", list(chosen.collect()))])
            }
        }
    }

    /// Name of the outcome that ranks the worst rows.
    pub fn worst(self) -> &'static str {
        match self {
            Self::Delay => "energy_error",
            Self::Diagnose => "error_left_percent",
        }
    }

    /// Names of the outcomes of this benchmark.
    pub fn outcomes(self) -> &'static [&'static str] {
        match self {
            Self::Delay => &[
                "restitution",
                "energy_error",
                "peak_force_error",
                "contact_time_error",
                "impulse_unaccounted",
            ],
            Self::Diagnose => &["error_left_percent"],
        }
    }

    /// Computes a row; `values` are those of [`factors`](Self::factors).
    pub fn execute(self, seed: u64, values: &[Value]) -> Outcome {
        let words: Vec<&str> = values.iter().filter_map(Value::as_str).collect();
        let ran = match (self, words.as_slice()) {
            (Self::Delay, [law, case]) => delay(law, case, seed),
            (Self::Diagnose, [case]) => diagnosed(case, seed),
            _ => Err(anyhow::anyhow!("the plan has other factors")),
        };
        ran.unwrap_or_else(|error| Outcome::failure(Status::Failed, format!("{error:#}")))
    }

    /// The command that shows a row as the benchmark prints it.
    pub fn command(self, seed: u64, values: &[Value]) -> String {
        let word = |k: usize| values.get(k).and_then(Value::as_str).unwrap_or_default();
        match self {
            Self::Delay => {
                let case = word(1).rsplitn(3, ", ").last().unwrap_or_default();
                format!(
                    "softdock bench delay --case {} --law {} --seed {seed}",
                    quoted(case),
                    word(0)
                )
            }
            Self::Diagnose => {
                format!(
                    "softdock bench diagnose --case {} --seed {seed} --all",
                    word(0)
                )
            }
        }
    }
}

/// One word for a case, its robot and a speed.
fn word(case: &Case, speed_mm_s: f64) -> String {
    format!("{}, {}, at {speed_mm_s} mm/s", case.name, case.robot.name)
}

fn delay(law: &str, name: &str, seed: u64) -> Result<Outcome> {
    let all = cases::all();
    let mut at = all
        .iter()
        .flat_map(|case| case.speeds_mm_s.iter().map(move |speed| (case, *speed)));
    let found = at.find(|(case, speed)| word(case, *speed) == name);
    let (case, speed_mm_s) = found.with_context(|| format!("there is no case `{name}`"))?;
    let law = LawName::named(law).with_context(|| format!("there is no law `{law}`"))?;
    let row = run::row(case, speed_mm_s, law, seed)?;
    let finite = |value: f64| Some(value).filter(|v| v.is_finite());
    let speed_m_s = speed_mm_s * 1e-3;
    Ok(Outcome {
        impacts: row.touches as u64,
        speed_in_m_s: Some(speed_m_s),
        speed_out_m_s: finite(row.restitution * speed_m_s),
        restitution: finite(row.restitution),
        expected_restitution: finite(row.expected_restitution),
        energy_error: finite(row.energy_error),
        peak_force_error: finite(row.peak_force_error),
        contact_time_error: finite(row.contact_time_error),
        impulse_unaccounted: finite(row.impulse_unaccounted),
        fault: (row.failed > 0).then(|| format!("{:?}", row.ending)),
        ..Outcome::default()
    })
}

fn diagnosed(name: &str, seed: u64) -> Result<Outcome> {
    let specs = suite(seed);
    let spec = specs.iter().find(|spec| spec.name() == name);
    let spec = spec.with_context(|| format!("there is no case `{name}`"))?;
    let row = diagnose::one(spec)?;
    let verdict = serde_json::to_value(row.verdict)?;
    let said = [verdict.as_str().unwrap_or_default().to_owned()];
    Ok(Outcome {
        hidden: Some(row.hidden.join(" + ")),
        said: Some(
            said.into_iter()
                .chain(row.effects)
                .collect::<Vec<_>>()
                .join(" "),
        ),
        right: Some(row.right),
        error_left_percent: row.drop_percent.map(|drop| 100.0 - drop),
        ..Outcome::default()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn only(case: &str) -> [String; 1] {
        [case.to_owned()]
    }

    /// A row of the campaign is the benchmark's row with the same seed.
    #[test]
    fn a_row_is_the_benchmarks_own() {
        let factors = Bench::Delay.factors(&only("headline"), &[LawName::Lead]);
        let factors = factors.unwrap();
        let levels = |k: usize| factors[k].1.levels().unwrap();
        assert_eq!(levels(0), ["lead"]);
        let values = [levels(0)[0].clone(), levels(1)[3].clone()];
        let outcome = Bench::Delay.execute(5, &values);
        let case = &cases::all()[0];
        let row = run::row(case, case.speeds_mm_s[3], LawName::Lead, 5).unwrap();
        assert_eq!(outcome.restitution, Some(row.restitution));
        assert!(Bench::Delay.command(5, &values).contains(&case.name));
    }

    #[test]
    fn every_case_is_a_word_of_its_own() {
        let all = Bench::Delay.factors(&[], &[]).unwrap();
        let levels = all[1].1.levels().unwrap();
        let words: std::collections::BTreeSet<_> = levels.iter().map(Value::to_string).collect();
        assert_eq!(words.len(), levels.len());
    }

    #[test]
    fn a_case_that_there_is_not_is_refused() {
        let said = Bench::Diagnose.factors(&only("h999"), &[]);
        let said = said.unwrap_err().to_string();
        assert!(
            said.contains("there is no case `h999`; there are h001"),
            "{said}"
        );
    }
}
