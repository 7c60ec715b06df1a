//! The plan: one file with everything that a row depends on.

use super::bench::Bench;
use super::checksum::checksum;
use super::design::{self, Design};
use super::distribution::Distribution;
use super::file::{CampaignFile, Factor};
use super::place::Place;
use super::setting::{SettingName, Settings};
use crate::scenario::Scenario;
use anyhow::{Context, Result, bail, ensure};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use softdock_io::shell::quoted;
use softdock_io::{identity, input};
use softdock_statistics::RandomStream;
use std::path::Path;

/// Name of the plan's file.
pub(super) const FILE: &str = "plan.json";
/// Name and version of the format.
const FORMAT: &str = "softdock-campaign/1";
/// Name from which the random stream of a row's seed is taken.
const SEED: &str = "seed";
/// More rows than this are taken for a mistake: a week on a hundred cores.
const MOST_ROWS: u64 = 100_000_000;

/// Content of the plan's file.
#[derive(Debug, Serialize, Deserialize)]
struct PlanFile {
    format: String,
    /// Hash of the two texts below.
    hash: String,
    /// The program that made the plan; no other may run it.
    binary: String,
    rows: u64,
    /// The campaign file.
    campaign_toml: String,
    /// The scenario, with all defaults written out.
    scenario_toml: String,
}

/// A plan that can be run.
#[derive(Clone, Debug)]
pub struct Plan {
    /// The campaign file.
    pub campaign: CampaignFile,
    /// The campaign file and the scenario as texts.
    pub texts: [String; 2],
    /// Hash of both texts.
    pub hash: String,
    /// The program that made the plan.
    pub binary: String,
    /// The factors.
    pub factors: Vec<PlannedFactor>,
    /// Settings of the scenario; None for a benchmark.
    settings: Option<Settings>,
    design: Design,
    /// Number of combinations of the values of lists and grids.
    combinations: u64,
}

/// A factor of a plan.
#[derive(Clone, Debug)]
pub struct PlannedFactor {
    /// Name of its column.
    pub name: String,
    /// Settings that get its value, as written.
    pub settings: Vec<String>,
    /// Distribution of the factor.
    pub distribution: Distribution,
    targets: Vec<SettingName>,
    /// Its values, or the axis of the design from which they are drawn.
    source: Source,
}

#[derive(Clone, Debug)]
enum Source {
    Levels(Vec<Value>),
    Axis(usize),
}

/// The conditions of a row.
#[derive(Clone, Debug, PartialEq)]
pub struct Conditions {
    /// Seed of the run's noise.
    pub seed: u64,
    /// Values of the factors.
    pub values: Vec<Value>,
}

impl PlannedFactor {
    /// Plans a factor of a campaign file. One that is drawn takes the next axis of the design.
    fn of(factor: &Factor, axes: &mut Vec<String>) -> Result<Self> {
        let name = factor.column();
        let distribution = factor
            .distribution()
            .with_context(|| format!("factor `{name}`"))?;
        let source = match distribution.levels() {
            Some(levels) => Source::Levels(levels),
            None => {
                axes.push(name.clone());
                Source::Axis(axes.len() - 1)
            }
        };
        let written = factor.targets();
        ensure!(
            !written.contains(&SEED),
            "`seed` cannot be a factor: every draw has a noise of its own"
        );
        let targets = written.iter().map(|setting| SettingName::parse(setting));
        Ok(Self {
            name,
            targets: targets.collect::<Result<Vec<_>>>()?,
            settings: written.into_iter().map(str::to_owned).collect(),
            distribution,
            source,
        })
    }

    /// The factors of a benchmark.
    fn of_bench(bench: Bench, campaign: &CampaignFile) -> Result<Vec<Self>> {
        let planned = |(name, distribution): (&str, Distribution)| Self {
            name: name.to_owned(),
            settings: vec![name.to_owned()],
            targets: Vec::new(),
            source: Source::Levels(distribution.levels().unwrap_or_default()),
            distribution,
        };
        Ok(bench
            .factors(&campaign.cases, &campaign.laws)?
            .into_iter()
            .map(planned)
            .collect())
    }
}

impl Plan {
    /// Reads a campaign file and the scenario that it names, and checks both ends of every factor against the ranges of the
    /// settings.
    ///
    /// # Errors
    /// The first error in either file, or the first factor that names no setting or leaves its range.
    pub fn new(path: &Path) -> Result<Self> {
        let campaign: CampaignFile = input::load(path)?;
        let folder = path.parent().unwrap_or(Path::new(""));
        let scenario = match &campaign.scenario {
            Some(scenario) => Scenario::load(&folder.join(scenario))?.to_toml()?,
            None => String::new(),
        };
        let text = std::fs::read_to_string(path)?;
        let plan = Self::of([text, scenario], this_binary()?);
        let plan = plan.with_context(|| format!("in {}", path.display()))?;
        plan.check_ends()
            .with_context(|| format!("in {}", path.display()))?;
        Ok(plan)
    }

    fn of(texts: [String; 2], binary: String) -> Result<Self> {
        let campaign: CampaignFile = input::parse(&texts[0], "campaign")?;
        campaign.check()?;
        let (mut factors, settings) = match campaign.bench {
            Some(bench) => (PlannedFactor::of_bench(bench, &campaign)?, None),
            None => {
                let base: Scenario = input::parse(&texts[1], "scenario of the campaign")?;
                (Vec::new(), Some(Settings::of(&base)?))
            }
        };
        let mut axes = Vec::new();
        for factor in &campaign.factors {
            let planned = PlannedFactor::of(factor, &mut axes)?;
            refuse_overwritten(&factors, &planned.name, &planned.targets)?;
            factors.push(planned);
        }
        let levels = factors.iter().filter_map(|factor| match &factor.source {
            Source::Levels(levels) => Some(levels.len() as u64),
            Source::Axis(_) => None,
        });
        let combinations = levels.fold(1, u64::saturating_mul);
        ensure!(
            campaign.samples <= MOST_ROWS,
            "{} samples are more than {MOST_ROWS} rows",
            campaign.samples
        );
        let design = Design::new(campaign.design, campaign.seed, &axes, campaign.samples)?;
        let hash = checksum(&[FORMAT.as_bytes(), texts[0].as_bytes(), texts[1].as_bytes()]);
        let plan = Self {
            hash: format!("{hash:016x}"),
            campaign,
            texts,
            binary,
            factors,
            settings,
            design,
            combinations,
        };
        let rows = plan.design.points().checked_mul(plan.combinations);
        ensure!(
            rows.is_some_and(|rows| rows <= MOST_ROWS),
            "{} draws with {} combinations each are more than {MOST_ROWS} rows",
            plan.design.points(),
            plan.combinations
        );
        Ok(plan)
    }

    /// Checks that each end of each factor, with all others as in the scenario, gives a valid scenario.
    fn check_ends(&self) -> Result<()> {
        let Some(settings) = &self.settings else {
            return Ok(());
        };
        for factor in &self.factors {
            let ends = match &factor.source {
                Source::Levels(levels) => levels.clone(),
                // Beyond three sigma a row may be refused, which is then its outcome.
                Source::Axis(_) => [0.001, 0.999]
                    .map(|u| factor.distribution.quantile(u).into())
                    .to_vec(),
            };
            for end in ends {
                for setting in &factor.settings {
                    let named = || format!("factor `{}`", factor.name);
                    settings.try_one(setting, &end).with_context(named)?;
                }
                let all = factor.targets.iter().map(|target| (target, end.clone()));
                let scenario = settings.with(all)?;
                scenario
                    .validate()
                    .with_context(|| format!("factor `{}` at {end}", factor.name))?;
            }
        }
        Ok(())
    }

    /// Writes the plan to the campaign's location; a missing folder is made.
    ///
    /// # Errors
    /// The location cannot be written to.
    pub fn write(&self, place: &Place) -> Result<()> {
        let [campaign_toml, scenario_toml] = self.texts.clone();
        let file = PlanFile {
            format: FORMAT.to_owned(),
            hash: self.hash.clone(),
            binary: self.binary.clone(),
            rows: self.rows(),
            campaign_toml,
            scenario_toml,
        };
        let text = serde_json::to_string_pretty(&file)?;
        place.add(FILE, text.into_bytes())
    }

    /// Reads the plan of a campaign, to evaluate it.
    ///
    /// # Errors
    /// There is no plan, or it was changed.
    pub fn read(place: &Place) -> Result<Self> {
        let name = place.file(FILE);
        let bytes = place.read(FILE)?.with_context(|| {
            format!(
                "there is no {name}; `softdock campaign plan CAMPAIGN.toml -o {}` makes it",
                quoted(place)
            )
        })?;
        let file: PlanFile =
            serde_json::from_slice(&bytes).with_context(|| format!("in {name}"))?;
        ensure!(
            file.format == FORMAT,
            "{name}: expected format `{FORMAT}`, received `{}`",
            file.format
        );
        let plan = Self::of([file.campaign_toml, file.scenario_toml], file.binary)
            .with_context(|| format!("in {name}"))?;
        ensure!(
            plan.hash == file.hash && plan.rows() == file.rows,
            "{name} was changed after it was planned; plan anew elsewhere"
        );
        Ok(plan)
    }

    /// Reads the plan of a campaign, to run it.
    ///
    /// # Errors
    /// As [`read`](Self::read), or another program planned it.
    pub fn read_to_run(place: &Place) -> Result<Self> {
        let plan = Self::read(place)?;
        let own = this_binary()?;
        if plan.binary != own {
            bail!(
                "{place} was planned by another program and would give rows that are not comparable\n  \
                 planned by {}\n  this is    {own}\nUse that program, or plan anew elsewhere.",
                plan.binary
            );
        }
        Ok(plan)
    }

    /// Number of rows.
    pub fn rows(&self) -> u64 {
        self.design.points() * self.combinations
    }

    /// Number of runs of one sample of the design: more than one for Sobol' indices.
    pub fn runs_per_sample(&self) -> u64 {
        self.design.runs_per_sample()
    }

    /// Number of combinations of listed and grid values; each draw is run with all of them.
    pub fn combinations(&self) -> u64 {
        self.combinations
    }

    /// Whether no factor is drawn: one draw then covers all combinations.
    pub fn is_exhaustive(&self) -> bool {
        let is_listed = |factor: &PlannedFactor| matches!(factor.source, Source::Levels(_));
        self.factors.iter().all(is_listed)
    }

    /// Number of the draw of a row. Rows of one draw have its drawn values and its noise in common, so they can be compared.
    pub fn draw(&self, index: u64) -> u64 {
        index / self.combinations / self.runs_per_sample()
    }

    /// The conditions of a row: a pure function of the plan and the index. All combinations of a draw have the same drawn
    /// values and noise, so that they can be compared pair by pair.
    pub fn conditions(&self, index: u64) -> Conditions {
        let (point, mut combination) = (index / self.combinations, index % self.combinations);
        let value = |factor: &PlannedFactor| match &factor.source {
            Source::Levels(levels) => {
                let count = levels.len() as u64;
                let level = levels[(combination % count) as usize].clone();
                combination /= count;
                level
            }
            Source::Axis(axis) => {
                let u = self.design.coordinate(point, *axis);
                factor.distribution.quantile(u).into()
            }
        };
        let values = self.factors.iter().map(value).collect();
        let draw = self.draw(index);
        let noise = RandomStream::at(self.campaign.seed, draw, design::place(SEED)).uniform();
        let seed = (noise * f64::from(u32::MAX)) as u64;
        Conditions { seed, values }
    }

    /// The scenario of a row.
    ///
    /// # Errors
    /// The values of its factors together leave a range, or the campaign is one of a benchmark.
    pub fn scenario(&self, index: u64) -> Result<Scenario> {
        let Conditions { seed, values } = self.conditions(index);
        let settings = self
            .settings
            .as_ref()
            .context("a row of a benchmark has no scenario")?;
        let values = self.factors.iter().zip(values);
        let values = values.flat_map(|(factor, value)| {
            factor
                .targets
                .iter()
                .map(move |target| (target, value.clone()))
        });
        let mut scenario = settings.with(values)?;
        scenario.seed = seed;
        scenario.validate()?;
        Ok(scenario)
    }
}

/// An error if a factor sets a setting that another factor before it sets, too.
fn refuse_overwritten(before: &[PlannedFactor], name: &str, targets: &[SettingName]) -> Result<()> {
    for other in before {
        let theirs = other.targets.iter().zip(&other.settings);
        for (target, setting) in theirs {
            ensure!(
                !targets.iter().any(|own| own.contains(target)),
                "factor `{name}` sets `{setting}` again, which factor `{}` sets; expected one factor for each setting: leave one out",
                other.name
            );
        }
    }
    Ok(())
}

/// Name, version and git state of this program, and a checksum of its file: two builds of one commit
/// may compute differently.
pub fn this_binary() -> Result<String> {
    let path = std::env::current_exe().context("cannot find the running program")?;
    let bytes = std::fs::read(&path).with_context(|| format!("cannot read {}", path.display()))?;
    Ok(format!("{} {:016x}", identity::text(), checksum(&[&bytes])))
}

#[cfg(test)]
mod tests;
