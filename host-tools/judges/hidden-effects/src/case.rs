//! One case: a plan from a seed, two logs, the truth and the oracle.

use std::collections::BTreeMap;

use crate::effect::Effect;
use crate::jog::{self, Jog};
use crate::log::{Row, to_csv};
use crate::meta::Meta;
use crate::noise::{Noise, NoiseCharacter, NoiseRange};
use crate::residual;
use crate::rig;
use crate::simulate::Run;
use crate::size::{Scene, draw};
use crate::small;
use crate::truth::{Level, Truth, Verdict};

/// A case as a tool gets it, and the truth.
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
    pub(crate) noise: NoiseRange,
}

/// Everything that is drawn before the first tick.
struct Plan {
    nominal: Meta,
    plant: Meta,
    effects: Vec<Effect>,
    /// Whether the effects are in train and in test.
    shown: [bool; 2],
    jogs: [Jog; 2],
    rows: usize,
    character: NoiseCharacter,
}

/// Offset of the test log's seed, so that its noise differs from that of train.
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

    /// [`Truth::size`] of the case.
    #[must_use]
    pub fn size(&self) -> f64 {
        self.size
    }

    /// Simulates the case; the same spec gives the same text.
    #[must_use]
    pub fn generate(&self) -> Case {
        let factor = match self.level {
            Level::Small => small::factor(self.size, |factor| self.plan(factor).excess(self.seed)),
            _ => self.size,
        };
        let plan = self.plan(factor);
        let test_seed = self.seed ^ TEST_SEED;
        let train = plan.run(0, self.seed, plan.effects_of(0)).log();
        let test = plan.run(1, test_seed, plan.effects_of(1)).log();
        let (z_nominal_test, z_oracle_test) = plan.judged(&test, test_seed);
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
                noise: self.noise,
                z_oracle_test,
                z_nominal_test,
            },
        }
    }

    fn expected(&self) -> Verdict {
        match self.level {
            Level::Null | Level::NullWithinTolerance => Verdict::NothingMissing,
            Level::Outside => Verdict::Unexplained,
            Level::OneLog => Verdict::LogsDisagree,
            Level::Single
            | Level::Compound
            | Level::Triple
            | Level::Small
            | Level::SingleWithinTolerance => Verdict::Named,
        }
    }

    /// Draws rig, motion, effects of this size factor, and noise.
    fn plan(&self, size: f64) -> Plan {
        let mut noise = Noise::new(self.seed, 0);
        let about_tool = self.effects.iter().any(|id| id.starts_with("tool_"));
        let mut nominal = rig::draw(&self.name, !about_tool, &mut noise);
        if self.effects.contains(&"tool_inertia") {
            let mass_kg = (3.5 * size * noise.between(0.8, 1.3)).min(16.0);
            nominal.tool = rig::tool(mass_kg, &mut noise);
            nominal.tool.dynamic_compensation = false;
        }
        let sign = noise.sign();
        let approach = [0.030, 0.042].map(|v| v * noise.between(0.92, 1.08) * sign);
        let jogs = jog::draw(&nominal, approach, &mut noise);
        let effects = draw_effects(&self.effects, size, &nominal, &jogs, &mut noise);
        rig::settle(&mut nominal, &effects);
        let plant = match self.level {
            Level::NullWithinTolerance | Level::SingleWithinTolerance => {
                rig::draw_tolerance(&mut nominal, &mut noise)
            }
            _ => nominal.clone(),
        };
        let long = nominal.sample_time_s < 0.003 || noise.chance(0.1);
        let character = NoiseCharacter::draw(self.noise, &mut noise);
        let first = noise.chance(0.5);
        Plan {
            character,
            shown: match self.level {
                Level::OneLog => [first, !first],
                _ => [true; 2],
            },
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

    /// The effects that a log contains.
    fn effects_of(&self, log: usize) -> &[Effect] {
        if self.shown[log] { &self.effects } else { &[] }
    }

    /// z of a test log under the nominal model, and z of a run with the same seed without the effects.
    fn judged(&self, test: &[Row], seed: u64) -> ([f64; 4], [f64; 4]) {
        // A tool cannot lose its inertia, so the reference run keeps it, and its model contains it.
        let inertia = |effect: &Effect| matches!(effect, Effect::ToolInertia);
        let mut known = self.nominal.clone();
        known.tool.dynamic_compensation |= self.effects.iter().any(inertia);
        let reference = self.run(1, seed, &[]).log();
        (
            residual::z(&self.nominal, test),
            residual::z(&known, &reference),
        )
    }

    /// Residual of the effects in the channel that shows most of them, in multiples of the oracle's z.
    fn excess(&self, seed: u64) -> f64 {
        let oracle = residual::z(&self.nominal, &self.run(1, seed, &[]).log());
        let left = residual::z(&self.nominal, &self.without_noise(1, &self.effects).log());
        // Without the pose: there the trapezoidal rule of the format leaves more than a small effect.
        let each = left.iter().zip(oracle).take(3);
        each.map(|(z, floor)| z / floor.max(1.0))
            .fold(0.0, f64::max)
    }

    fn without_noise<'a>(&'a self, log: usize, effects: &'a [Effect]) -> Run<'a> {
        Run {
            character: NoiseCharacter::SILENCE,
            ..self.run(log, 0, effects)
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
    // Both logs must reach a limit, as otherwise the test log could not confirm it.
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
    use crate::suite::{nothing_hidden, suite};

    /// z of a log without noise and effects under the model of its true plant.
    fn left_without_noise(plan: &Plan, log: usize) -> [f64; 4] {
        let rows = plan.without_noise(log, &[]).log();
        let [a, b, _, k] = residual::z(&plan.plant, &rows);
        // The rig computer compensates with the nominal model.
        let [_, _, c, _] = residual::z(&plan.nominal, &rows);
        [a, b, c, k]
    }

    /// A null with exact parameters leaves nothing but noise under its nominal model.
    #[test]
    fn a_null_is_its_model_and_noise() {
        /// Error of the format's trapezoidal rule, as the plant integrates exactly; in sigma.
        const TRAPEZIA: f64 = 0.2;
        let specs = (1..=3).flat_map(|seed| [suite(seed), nothing_hidden(seed, 8)].concat());
        for spec in specs.filter(|spec| spec.effects.is_empty()) {
            let plan = spec.plan(spec.size);
            assert_eq!(plan.nominal == plan.plant, spec.level == Level::Null);
            for log in [0, 1] {
                let z = left_without_noise(&plan, log);
                let exact = z[..3].iter().all(|z| *z < 1e-3);
                assert!(exact && z[3] < TRAPEZIA, "{}: {z:?}", spec.name);
            }
        }
    }
}
