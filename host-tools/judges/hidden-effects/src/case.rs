//! One case: plan from a seed, two logs, the truth and the oracle.

use std::collections::BTreeMap;

use crate::effect::Effect;
use crate::jog::{self, Jog};
use crate::log::to_csv;
use crate::meta::Meta;
use crate::noise::{Noise, NoiseCharacter};
use crate::residual;
use crate::rig;
use crate::simulate::Run;
use crate::size::{Scene, draw};
use crate::truth::{Level, Truth, Verdict};

/// A case as the tool sees it, and the truth.
#[derive(Clone, Debug)]
pub struct Case {
    /// Name of the case.
    pub name: String,
    /// Text of `meta.json`.
    pub meta_json: String,
    /// Text of `train.csv`.
    pub train_csv: String,
    /// Text of `test.csv`.
    pub test_csv: String,
    /// The answer.
    pub truth: Truth,
}

/// A case that has not been simulated yet.
#[derive(Clone, Debug, PartialEq)]
pub struct CaseSpec {
    pub(crate) name: String,
    pub(crate) seed: u64,
    pub(crate) level: Level,
    pub(crate) effects: Vec<&'static str>,
    pub(crate) size: f64,
}

/// Everything drawn before the first tick.
struct Plan {
    nominal: Meta,
    plant: Meta,
    effects: Vec<Effect>,
    jogs: [Jog; 2],
    rows: usize,
    character: NoiseCharacter,
}

/// Train and test differ in their noise.
const TEST_SEED: u64 = 0x5eed_0002;

impl CaseSpec {
    /// Name of the case and of its folder.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Ids of the hidden effects.
    #[must_use]
    pub fn effects(&self) -> &[&'static str] {
        &self.effects
    }

    /// Kind of the case.
    #[must_use]
    pub fn level(&self) -> Level {
        self.level
    }

    /// Size factor of the effects, 0 when there are none.
    #[must_use]
    pub fn size(&self) -> f64 {
        self.size
    }

    /// Simulates the case; the same spec gives the same text.
    #[must_use]
    pub fn generate(&self) -> Case {
        let plan = self.plan();
        let train = plan.run(0, self.seed, &plan.effects).log();
        let test_seed = self.seed ^ TEST_SEED;
        let test = plan.run(1, test_seed, &plan.effects).log();
        // A tool cannot lose its inertia: the reference run keeps it, and its model knows it.
        let inertia = |effect: &Effect| matches!(effect, Effect::ToolInertia);
        let mut known = plan.nominal.clone();
        known.tool.dynamic_compensation |= plan.effects.iter().any(inertia);
        let reference = plan.run(1, test_seed, &[]).log();
        Case {
            name: self.name.clone(),
            meta_json: serde_json::to_string_pretty(&plan.nominal).unwrap_or_default(),
            train_csv: to_csv(&train),
            test_csv: to_csv(&test),
            truth: Truth {
                effects: self.effects.iter().map(|id| (*id).to_owned()).collect(),
                parameters: parameters(&plan.effects),
                expected: self.expected(),
                level: self.level,
                size: self.size,
                z_oracle_test: residual::z(&known, &reference),
                z_nominal_test: residual::z(&plan.nominal, &test),
            },
        }
    }

    fn expected(&self) -> Verdict {
        match self.level {
            Level::Null | Level::NullWithinTolerance => Verdict::NothingMissing,
            Level::Outside => Verdict::Unexplained,
            Level::Single | Level::Compound | Level::SingleWithinTolerance => Verdict::Named,
        }
    }

    fn plan(&self) -> Plan {
        let mut noise = Noise::new(self.seed, 0);
        let about_tool = self.effects.iter().any(|id| id.starts_with("tool_"));
        let mut nominal = rig::draw(&self.name, !about_tool, &mut noise);
        if self.effects.contains(&"tool_inertia") {
            let mass_kg = (3.5 * self.size * noise.between(0.8, 1.3)).min(16.0);
            nominal.tool = rig::tool(mass_kg, &mut noise);
            nominal.tool.dynamic_compensation = false;
        }
        let sign = noise.sign();
        let approach = [0.030, 0.042].map(|v| v * noise.between(0.92, 1.08) * sign);
        let jogs = jog::draw(&nominal, approach, &mut noise);
        let effects = draw_effects(&self.effects, self.size, &nominal, &jogs, &mut noise);
        rig::settle(&mut nominal, &effects);
        let plant = match self.level {
            Level::NullWithinTolerance | Level::SingleWithinTolerance => {
                rig::draw_tolerance(&mut nominal, &mut noise)
            }
            _ => nominal.clone(),
        };
        let long = nominal.sample_time_s < 0.003 || noise.chance(0.1);
        Plan {
            character: character(&mut noise),
            rows: if long { 3750 } else { 2500 },
            nominal,
            plant,
            effects,
            jogs,
        }
    }
}

impl Plan {
    fn run<'a>(&'a self, log: usize, seed: u64, effects: &'a [Effect]) -> Run<'a> {
        Run {
            nominal: &self.nominal,
            plant: &self.plant,
            effects,
            jog: &self.jogs[log],
            rows: self.rows,
            character: self.character,
            seed,
        }
    }
}

fn draw_effects(
    ids: &[&'static str],
    size: f64,
    nominal: &Meta,
    jogs: &[Jog; 2],
    noise: &mut Noise,
) -> Vec<Effect> {
    let ts = nominal.sample_time_s;
    // Both logs must reach a limit, or the test log could not confirm it.
    let both = |of: &dyn Fn(&Jog) -> f64| of(&jogs[0]).min(of(&jogs[1]));
    let scene = Scene {
        meta: nominal,
        jogs,
        peak_speed: [0..3, 3..6].map(|axes| both(&|j| jog::peak_speed(j, axes.clone()))),
        peak_slope: [0..3, 3..6].map(|axes| both(&|j| jog::peak_slope(j, axes.clone(), ts))),
    };
    ids.iter()
        .filter_map(|id| draw(id, size, &scene, noise))
        .collect()
}

/// A third of the logs are noisier than the data sheet, a quarter are autoregressive.
fn character(noise: &mut Noise) -> NoiseCharacter {
    let noisier = noise.between(1.0, 1.3);
    let (wrench_factor, motion_factor) = match noise.below(9) {
        0 | 1 => (noisier, 1.0),
        2 => (noisier, noisier),
        _ => (1.0, 1.0),
    };
    let ar_coefficient = noise.between(0.1, 0.5);
    NoiseCharacter {
        wrench_factor,
        motion_factor,
        ar_coefficient: if noise.chance(0.25) {
            ar_coefficient
        } else {
            0.0
        },
    }
}

fn parameters(effects: &[Effect]) -> BTreeMap<String, BTreeMap<String, f64>> {
    effects
        .iter()
        .map(|effect| {
            let (id, parameters) = effect.describe();
            (id.to_owned(), parameters)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::suite::suite;

    /// z of a log without noise and effects under the model of its true plant.
    fn left_without_noise(plan: &Plan, log: usize) -> [f64; 4] {
        let silent = NoiseCharacter {
            wrench_factor: 0.0,
            motion_factor: 0.0,
            ar_coefficient: 0.0,
        };
        let run = Run {
            character: silent,
            ..plan.run(log, 1, &[])
        };
        let rows = run.log();
        let [a, b, _, k] = residual::z(&plan.plant, &rows);
        // The rig computer compensates what the user believes.
        let [_, _, c, _] = residual::z(&plan.nominal, &rows);
        [a, b, c, k]
    }

    /// Noise is then all that a null with exact parameters leaves under its nominal model.
    #[test]
    fn a_null_is_its_model_and_noise() {
        /// The format integrates by trapezia, the plant exactly; in sigma.
        const TRAPEZIA: f64 = 0.2;
        let specs = (1..=3).flat_map(suite);
        for spec in specs.filter(|spec| spec.effects.is_empty()) {
            let plan = spec.plan();
            assert_eq!(plan.nominal == plan.plant, spec.level == Level::Null);
            for log in [0, 1] {
                let z = left_without_noise(&plan, log);
                let exact = z[..3].iter().all(|z| *z < 1e-3);
                assert!(exact && z[3] < TRAPEZIA, "{}: {z:?}", spec.name);
            }
        }
    }
}
