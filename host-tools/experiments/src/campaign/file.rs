//! The campaign file, as a person writes it.

use super::bench::Bench;
use super::design::Kind;
use super::distribution::{Distribution, Grid, Normal};
use super::outcome;
use anyhow::{Result, bail, ensure};
use serde::{Deserialize, Serialize};
use softdock_control::delay::LawName;
use softdock_io::input::nearest;
use std::collections::BTreeSet;

/// A campaign file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CampaignFile {
    /// What is tested, for reports.
    #[serde(default)]
    pub title: String,
    /// Path of the scenario that varies (TOML), relative to this file's folder.
    #[serde(default)]
    pub scenario: Option<String>,
    /// A benchmark, in place of a scenario.
    #[serde(default)]
    pub bench: Option<Bench>,
    /// Cases of the benchmark, or sweeps of cases; all if there are none.
    #[serde(default)]
    pub cases: Vec<String>,
    /// Laws of `bench = "delay"`; all if there are none.
    #[serde(default)]
    pub laws: Vec<LawName>,
    /// Number of draws of the factors that are drawn; each is combined with every combination of listed and grid values.
    #[serde(default = "one")]
    pub samples: u64,
    /// Seed of all draws, and of the noise of every run.
    #[serde(default = "one")]
    pub seed: u64,
    /// Design of the draws.
    #[serde(default)]
    pub design: Kind,
    /// The settings of the scenario that vary.
    #[serde(default)]
    pub factors: Vec<Factor>,
    /// Limits that a run has to keep to be a success; in any case it must end without a fault.
    #[serde(default)]
    pub limits: Vec<Limit>,
    /// Names of the outcomes in the report; empty for all.
    #[serde(default)]
    pub outcomes: Vec<String>,
    /// Name of the outcome whose largest magnitudes are the worst rows; by default that of the first limit.
    #[serde(default)]
    pub worst: Option<String>,
}

fn one() -> u64 {
    1
}

/// A quantity that varies, and its distribution.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Factor {
    /// The setting, by its dotted name in the scenario: `rig.mechanism.walls[0].stiffness_n_per_m`.
    #[serde(default)]
    pub setting: Option<String>,
    /// Several settings that all get the value.
    #[serde(default)]
    pub settings: Vec<String>,
    /// Name of the column; by default the last part of the setting's name.
    #[serde(default)]
    pub name: Option<String>,
    /// Uniform between two numbers.
    #[serde(default)]
    pub uniform: Option<[f64; 2]>,
    /// Log-uniform between two numbers.
    #[serde(default)]
    pub log_uniform: Option<[f64; 2]>,
    /// Normal, within bounds if there are any.
    #[serde(default)]
    pub normal: Option<Normal>,
    /// Each of these values, combined with every combination of the other lists and grids.
    #[serde(default)]
    pub list: Option<Vec<serde_json::Value>>,
    /// As `list`, with equidistant values.
    #[serde(default)]
    pub grid: Option<Grid>,
}

/// Limits of an outcome.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Limit {
    /// Name of the outcome.
    pub outcome: String,
    /// Smallest allowed value.
    #[serde(default)]
    pub low: Option<f64>,
    /// Largest allowed value.
    #[serde(default)]
    pub high: Option<f64>,
    /// Source of the limit, in words.
    #[serde(default)]
    pub source: Option<String>,
    /// Whether somebody has read the source; if not, the report marks it.
    #[serde(default)]
    pub source_read: bool,
}

impl Factor {
    /// All settings that get the factor's value.
    pub fn targets(&self) -> Vec<&str> {
        let all = self.setting.iter().chain(&self.settings);
        all.map(String::as_str).collect()
    }

    /// Name of the factor's column.
    pub fn column(&self) -> String {
        let last = |setting: &&str| setting.rsplit('.').next().unwrap_or(setting).to_owned();
        let own = || self.targets().first().map(last);
        self.name.clone().or_else(own).unwrap_or_default()
    }

    /// Distribution of the factor.
    ///
    /// # Errors
    /// Not exactly one distribution is given, or its numbers are invalid.
    pub fn distribution(&self) -> Result<Distribution> {
        let ways = [
            self.uniform.map(Distribution::Uniform),
            self.log_uniform.map(Distribution::LogUniform),
            self.normal.map(Distribution::Normal),
            self.list.clone().map(Distribution::List),
            self.grid.map(Distribution::Grid),
        ];
        let mut ways = ways.into_iter().flatten();
        let (Some(way), None) = (ways.next(), ways.next()) else {
            bail!("expected exactly one of uniform, log_uniform, normal, list and grid");
        };
        way.check()?;
        Ok(way)
    }
}

impl Limit {
    fn check(&self) -> Result<()> {
        let Self {
            outcome, low, high, ..
        } = self;
        check_outcome(outcome)?;
        ensure!(
            low.is_some() || high.is_some(),
            "the limit of `{outcome}` has neither `low` nor `high`; give one or both"
        );
        for (name, bound) in [("low", low), ("high", high)] {
            ensure!(
                bound.is_none_or(f64::is_finite),
                "the limit of `{outcome}` has `{name} = {}`; expected a finite number, or no `{name}` for no bound there",
                bound.unwrap_or_default()
            );
        }
        if let (Some(low), Some(high)) = (low, high) {
            ensure!(
                low <= high,
                "the limit of `{outcome}` has `low = {low}` above `high = {high}`, which nothing keeps; exchange them"
            );
        }
        let named = self.source.as_ref().is_some_and(|s| !s.trim().is_empty());
        ensure!(
            named || !self.source_read,
            "the limit of `{outcome}` has `source_read = true` and no `source`; name what was read"
        );
        Ok(())
    }

    /// Whether a value is within the limits.
    pub fn holds(&self, value: f64) -> bool {
        let low = self.low.unwrap_or(f64::NEG_INFINITY);
        let high = self.high.unwrap_or(f64::INFINITY);
        (low..=high).contains(&value)
    }

    /// Distance of a value from the nearest bound; positive outside, negative within.
    pub fn beyond(&self, value: f64) -> f64 {
        let below = self.low.map(|low| low - value);
        let above = self.high.map(|high| value - high);
        let sides = below.into_iter().chain(above);
        sides.fold(f64::NEG_INFINITY, f64::max)
    }

    /// The bounds in words, without the unit.
    pub fn bounds(&self) -> String {
        match (self.low, self.high) {
            (Some(low), Some(high)) => format!("{low} to {high}"),
            (Some(low), None) => format!("at least {low}"),
            (None, Some(high)) => format!("at most {high}"),
            (None, None) => String::new(),
        }
    }
}

impl CampaignFile {
    /// Checks everything that can be checked without the scenario.
    ///
    /// # Errors
    /// The first thing that is wrong.
    pub fn check(&self) -> Result<()> {
        ensure!(self.samples > 0, "`samples` is 0; expected 1 or more");
        match (&self.scenario, self.bench) {
            (Some(_), None) => ensure!(
                !self.factors.is_empty(),
                "no [[factors]]: a campaign varies something"
            ),
            (None, Some(_)) => ensure!(
                self.factors.is_empty(),
                "[[factors]] vary a scenario; of a `bench`, `cases` and `laws` are chosen"
            ),
            _ => bail!("expected either `scenario` or `bench`"),
        }
        ensure!(
            self.bench.is_some() || (self.cases.is_empty() && self.laws.is_empty()),
            "`cases` and `laws` are those of a `bench`"
        );
        let mut columns: BTreeSet<String> =
            super::columns::own_columns().map(str::to_owned).collect();
        for factor in &self.factors {
            let column = factor.column();
            ensure!(
                !factor.targets().is_empty(),
                "a factor has no `setting`; give the dotted name of what varies"
            );
            ensure!(
                columns.insert(column.clone()),
                "two columns would be called `{column}`; give one factor another `name`"
            );
        }
        self.limits.iter().try_for_each(Limit::check)?;
        self.outcomes
            .iter()
            .chain(&self.worst)
            .try_for_each(|name| check_outcome(name))
    }
}

fn check_outcome(name: &str) -> Result<()> {
    let known = || outcome::NUMBERS.iter().map(|number| number.name);
    if known().any(|known| known == name) {
        return Ok(());
    }
    match nearest(name, known()) {
        Some(near) => bail!("unknown outcome `{name}`; did you mean `{near}`?"),
        None => bail!(
            "unknown outcome `{name}`; known are {}",
            known().collect::<Vec<_>>().join(", ")
        ),
    }
}
