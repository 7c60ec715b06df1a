//! The library of a search: all effects, at every combination of shapes that is tried, as columns of one regression.

use super::joint::Joint;
use super::prepared_log::PreparedLog;
use super::tested::TestedHypothesis;
use nalgebra::{DMatrix, DVector};
use softdock_physics::effects::mechanism::ABOUT_START;
use softdock_physics::model::load::effects::{LoadEffect, Pace, Shape, Sign};
use softdock_physics::model::load::loaded::Loaded;
use softdock_physics::model::load::{Column, Scene};

/// An effect with given shape parameters.
pub(crate) struct Variant {
    /// The effect.
    pub effect: &'static LoadEffect,
    /// Its shape parameters.
    pub shapes: Vec<f64>,
    /// Places of its columns in [`Library::columns`].
    pub columns: Vec<usize>,
    /// Sign constraint of each coefficient.
    pub signs: Vec<Sign>,
}

impl Variant {
    /// Number of its shapes that were scanned and so count as parameters.
    pub(crate) fn scanned(&self) -> usize {
        self.effect.shapes.iter().filter(|s| !s.choice).count()
    }
}

/// All variants with their columns and the Gram matrix of these.
pub(crate) struct Library {
    /// The hypotheses.
    pub variants: Vec<Variant>,
    /// Ids of effects that the model has.
    pub known: Vec<String>,
    /// Whitened columns over all logs.
    pub columns: Vec<Column>,
    /// Nuisance parameters that were open when `products` was computed.
    tolerances: Vec<usize>,
    /// Gram matrix of these, the columns and the residual, in this order.
    products: DMatrix<f64>,
    /// Gram matrix of the columns after elimination of the nuisance parameters.
    pub gram: DMatrix<f64>,
    /// Products of the columns with the residual, after elimination of the nuisance parameters.
    pub right: DVector<f64>,
}

impl Library {
    /// The library for some logs. Effects that are `excluded` are in the model already, or not to be tried.
    pub(crate) fn new(joint: &Joint, excluded: &dyn Fn(&str) -> bool) -> Self {
        use rayon::prelude::*;
        let model = joint.logs.first().map(|log| &log.scene.model);
        let wanted = tried_variants(joint, excluded);
        let built: Vec<Option<Vec<Column>>> = wanted
            .par_iter()
            .map(|(effect, shapes)| {
                joint.columns(&joint.problem, effect, shapes, &effect.places(), &[])
            })
            .collect();
        let mut store = Store::default();
        let mut variants = Vec::new();
        for ((effect, shapes), columns) in wanted.into_iter().zip(built) {
            let columns = match columns {
                Some(columns) => columns,
                // A late effect has no column yet, as no load is known that it could move: see [`Self::around`].
                None if effect.is_late() => vec![Column::default()],
                None => continue,
            };
            let signs = match effect.coefficients.as_slice() {
                [] => vec![Sign::One; columns.len()],
                some => some.iter().map(|c| c.sign).collect(),
            };
            variants.push(Variant {
                effect,
                shapes,
                columns: columns.into_iter().map(|c| store.place(c)).collect(),
                signs,
            });
        }
        let products = joint.problem.all_products(&store.columns);
        let (gram, right) = joint.problem.after_tolerances(&products);
        let known = model.into_iter().flat_map(|m| &m.effects);
        Self {
            variants,
            known: known.map(|e| e.id.clone()).collect(),
            columns: store.columns,
            tolerances: joint.open_tolerances().collect(),
            products,
            gram,
            right,
        }
    }

    /// The same library around an answer: late effects also move the loads of the answer, and if the tried shapes are too far
    /// `apart`, the answer's effects are added at their own shapes. Without the latter, a delay that is off by half a step of its
    /// grid would leave a difference that any other effect could seem to explain. `None` if neither changes the library.
    pub(crate) fn around(
        mut self,
        joint: &Joint,
        found: &TestedHypothesis,
        apart: bool,
    ) -> Option<Self> {
        let scenes = joint.logs.iter().map(|log| &log.scene);
        let loads: Vec<Loaded<'_>> = scenes
            .map(|scene| Loaded::by(scene, &found.loads(scene)))
            .collect();
        let moves = self.moves(joint, &loads);
        if moves {
            self.move_in_time(joint, &loads);
        }
        if apart {
            self.refine(joint, found, &loads);
        }
        if !moves && !apart {
            return None;
        }
        let products = joint
            .problem
            .more_products(&self.open_products(joint), &self.columns);
        let (gram, right) = joint.problem.after_tolerances(&products);
        Some(Self {
            tolerances: joint.open_tolerances().collect(),
            products,
            gram,
            right,
            ..self
        })
    }

    /// Whether the loads of the answer have to be moved by late effects, which cannot be seen otherwise. Not where there are no
    /// late effects, or the answer is small beside what was known, or the measured reading hardly changes: of a constant command
    /// nobody knows when it was given.
    fn moves(&self, joint: &Joint, of_logs: &[Loaded<'_>]) -> bool {
        /// A late column may lack a load with less than this share of the reading's power: its gain is wrong by about as much.
        const LITTLE: f64 = 0.1;
        let power = |of: &dyn Fn(&PreparedLog, &Loaded<'_>) -> Column| -> f64 {
            let logs = joint.logs.iter().zip(of_logs);
            logs.map(|(log, loads)| variation(&of(log, loads))).sum()
        };
        let more = power(&|_, loads| loads.read());
        let known = power(&|log, _| log.scene.reading.clone());
        let measured = power(&|log, _| {
            let mut measured = log.residual.clone();
            measured.add(&log.scene.reading.0);
            measured
        });
        let varies = measured > LITTLE * more;
        let late = self.variants.iter().any(|v| v.effect.is_late());
        late && more >= LITTLE * known && varies
    }

    /// Computes the columns of late effects around these loads.
    fn move_in_time(&mut self, joint: &Joint, of_logs: &[Loaded<'_>]) {
        for variant in self.variants.iter_mut().filter(|v| v.effect.is_late()) {
            variant.columns = vec![self.columns.len()];
            self.columns
                .push(late_column(joint, of_logs, variant.effect, &variant.shapes));
        }
    }

    /// Adds the effects of an answer at their own shapes.
    fn refine(&mut self, joint: &Joint, found: &TestedHypothesis, of_logs: &[Loaded<'_>]) {
        for fitted in &found.effects {
            let alike = self.variants.iter().find(|v| v.effect.id == fitted.id);
            let Some((effect, signs)) = alike.map(|v| (v.effect, v.signs.clone())) else {
                continue;
            };
            let shape = |shape: &Shape| fitted.parameters.get(shape.name).map_or(0.0, |p| p.value);
            let shapes: Vec<f64> = effect.shapes.iter().map(shape).collect();
            if self
                .variants
                .iter()
                .any(|v| v.effect.id == effect.id && v.shapes == shapes)
            {
                continue;
            }
            let columns = match effect.is_late() && found.effects.len() > 1 {
                true => Some(vec![late_column(joint, of_logs, effect, &shapes)]),
                false => joint.columns(&joint.problem, effect, &shapes, &effect.places(), &[]),
            };
            let Some(columns) = columns else {
                continue;
            };
            let first = self.columns.len();
            let places = (first..first + columns.len()).collect();
            self.columns.extend(columns);
            self.variants.push(Variant {
                effect,
                shapes,
                columns: places,
                signs,
            });
        }
    }

    /// The same columns after some nuisance parameters were held.
    pub(crate) fn anew(self, joint: &Joint) -> Self {
        let products = self.open_products(joint);
        let (gram, right) = joint.problem.after_tolerances(&products);
        Self {
            gram,
            right,
            ..self
        }
    }

    /// The products without the nuisance parameters that are held now.
    fn open_products(&self, joint: &Joint) -> DMatrix<f64> {
        let open: Vec<usize> = joint.open_tolerances().collect();
        let known = self.tolerances.iter().enumerate();
        let open = known.filter(|(_, tolerance)| open.contains(tolerance));
        let columns = self.tolerances.len()..self.products.nrows();
        let kept: Vec<usize> = open.map(|(row, _)| row).chain(columns).collect();
        self.products.select_rows(&kept).select_columns(&kept)
    }
}

/// The whitened column of a late effect: what it adds to the given loads of each log.
fn late_column(
    joint: &Joint,
    of_logs: &[Loaded<'_>],
    effect: &'static LoadEffect,
    shapes: &[f64],
) -> Column {
    let valued = (effect, effect.values(shapes, &[]));
    let each = of_logs.iter().map(|loads| loads.added(valued.clone()));
    let each: Vec<Column> = each.collect();
    joint.problem.whitened(&each.iter().collect::<Vec<_>>())
}

/// Sum of squares about the mean of each axis.
fn variation(column: &Column) -> f64 {
    let of = |series: &Vec<f64>| {
        let mean = series.iter().sum::<f64>() / series.len().max(1) as f64;
        series
            .iter()
            .map(|value| (value - mean).powi(2))
            .sum::<f64>()
    };
    column.0.iter().map(of).sum()
}

/// Columns, each stored once: different effects share some.
#[derive(Default)]
struct Store {
    columns: Vec<Column>,
    prints: Vec<u64>,
}

impl Store {
    fn place(&mut self, column: Column) -> usize {
        let print = column
            .0
            .iter()
            .enumerate()
            .map(|(axis, s)| (axis as f64 + 1.3) * s.iter().map(|v| v + v * v).sum::<f64>())
            .sum::<f64>()
            .to_bits();
        let same = |k: &usize| self.prints[*k] == print && self.columns[*k] == column;
        if let Some(known) = (0..self.columns.len()).find(same) {
            return known;
        }
        self.columns.push(column);
        self.prints.push(print);
        self.columns.len() - 1
    }
}

/// Effects that are tried, with each combination of shapes.
fn tried_variants(
    joint: &Joint,
    excluded: &dyn Fn(&str) -> bool,
) -> Vec<(&'static LoadEffect, Vec<f64>)> {
    let model = joint.logs.first().map(|log| &log.scene.model);
    let all = model.into_iter().flat_map(LoadEffect::all);
    // A commanded force went through no sensor, so a constant is an offset of the guide and no zero of a sensor.
    let driven = model.is_some_and(|model| model.sensor.wrench.drives());
    let is_tried = |effect: &&LoadEffect| {
        let mut scenes = joint.logs.iter().map(|log| &log.scene);
        let is_no_zero = !(driven && effect.is_of_a_zero());
        is_no_zero && !excluded(effect.id) && scenes.any(|scene| effect.is_tried_on(scene))
    };
    let rests_at_one_place = begin_apart(joint);
    let with_shapes = |effect: &'static LoadEffect| {
        let about_start = effect
            .shapes
            .iter()
            .position(|s| s.name == ABOUT_START.name);
        let is_excluded = move |shapes: &Vec<f64>| {
            rests_at_one_place && about_start.is_some_and(|place| shapes[place] > 0.5)
        };
        let shapes = combinations(effect, joint.pace()).into_iter();
        let shapes = shapes.filter(move |shapes| !is_excluded(shapes));
        shapes.map(move |shapes| (effect, shapes))
    };
    all.filter(is_tried).flat_map(with_shapes).collect()
}

/// Whether the logs of a machine begin at opposite ends of its travel. A spring that rests where each log begins then has two
/// rest positions, and stands for whatever depends on the direction alone.
fn begin_apart(joint: &Joint) -> bool {
    /// Share of the travel. Starts of similar logs of one rig differ by up to half of it, opposite ends by all of it. Set by
    /// hand.
    const APART: f64 = 0.75;
    let scenes = || joint.logs.iter().map(|log| &log.scene);
    let width = |ends: [f64; 2]| (ends[1] - ends[0]).max(0.0);
    let travel = scenes().map(|scene| width(range(scene.position.iter().copied())));
    let begins = width(range(scenes().map(Scene::first_position)));
    scenes().all(|scene| !scene.of_a_rig) && begins > APART * travel.fold(0.0, f64::max)
}

fn range(values: impl Iterator<Item = f64>) -> [f64; 2] {
    values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| {
        [low.min(value), high.max(value)]
    })
}

/// All combinations of the shapes that are tried in such logs.
fn combinations(effect: &LoadEffect, logs: Pace) -> Vec<Vec<f64>> {
    let mut all: Vec<Vec<f64>> = vec![Vec::new()];
    for shape in &effect.shapes {
        let tried = effect.tried_values(shape, logs);
        let with = |head: &Vec<f64>, value: &f64| head.iter().chain([value]).copied().collect();
        let each = all
            .iter()
            .flat_map(|head| tried.iter().map(move |value| with(head, value)));
        all = each.collect();
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::noise::autoregressive::AutoregressiveNoise;
    use crate::diagnose::wrench::Memo;
    use softdock_control::frames::pose_components;
    use softdock_control::frames::{Pose, Twist};
    use softdock_control::wrench::Motion;
    use softdock_io::recording::Beginning;
    use softdock_physics::model::Model;
    use std::f64::consts::FRAC_PI_2;
    use std::sync::Arc;

    /// An axis that swings by 20 mm to either side, from one phase of its swing to another. The zero of its sensor is off by 40
    /// tolerances.
    fn swinging([from, to]: [f64; 2]) -> PreparedLog {
        const CYCLE_S: f64 = 0.004;
        const ROWS: i32 = 800;
        let model = "[rig]\nactive_axes = [\"x\"]\n[tool]\nmass_kg = 2.0\n";
        let model = Model::from_toml(model, "model.toml").unwrap();
        let time_s: Vec<f64> = (0..ROWS).map(|n| CYCLE_S * f64::from(n)).collect();
        let rate = (to - from) / (CYCLE_S * f64::from(ROWS));
        let along = |of: &dyn Fn(f64) -> f64| -> Vec<[f64; 6]> {
            let swing = time_s.iter().map(|t| 0.02 * of(from + rate * t));
            swing
                .map(|value| [value, 0.0, 0.0, 0.0, 0.0, 0.0])
                .collect()
        };
        let place = along(&f64::sin).into_iter();
        let pose: Vec<Pose<f64>> = place
            .map(|[x, ..]| Pose::translation(x, 0.0, 0.0))
            .collect();
        let velocity = along(&|phase| rate * phase.cos());
        let acceleration = along(&|phase| -rate * rate * phase.sin());
        let motion = velocity.iter().zip(&acceleration).map(|(v, a)| Motion {
            velocity: Twist::of(v),
            acceleration: Twist::of(a),
        });
        let began = Beginning {
            time_s: 0.0,
            pose: pose_components(&pose[0]),
            whole_turns: 0,
        };
        let rows = time_s.len();
        let scene = Scene::new(&model, CYCLE_S, time_s, pose, motion.collect());
        let scene = scene.of_log(false, 0, |_| nalgebra::Vector3::zeros(), true, &began);
        PreparedLog {
            residual: Column::on_axis(0, std::iter::repeat_n(40.0 * model.tolerance.bias[0], rows)),
            fresh: vec![true; rows],
            noise_model: std::array::from_fn(|_| AutoregressiveNoise::white(0.5)),
            tolerances: super::super::nuisance::columns(&model, &scene),
            sheet_sigma: [0.5; 6],
            half_step: [0.0; 6],
            has_own_origin: false,
            scene,
        }
    }

    fn joint<const N: usize>(phases: [[f64; 2]; N]) -> Joint {
        Joint::new(phases.map(swinging).into(), 1, &Arc::new(Memo::default()))
    }

    /// Strokes from one end to the other: a spring that rests at the first position would pull another way in each direction.
    #[test]
    fn a_spring_rests_where_logs_begin_unless_these_are_opposite_ends() {
        let rests_at_start = |phases| {
            let joint = joint(phases);
            let springs = tried_variants(&joint, &|id| id != "cable_stiffness");
            let place = |effect: &LoadEffect| {
                let mut shapes = effect.shapes.iter();
                shapes.position(|shape| shape.name == ABOUT_START.name)
            };
            springs
                .into_iter()
                .any(|(effect, shapes)| place(effect).is_some_and(|k| shapes[k] == 1.0))
        };
        let (back, forth) = ([-FRAC_PI_2, FRAC_PI_2], [FRAC_PI_2, 3.0 * FRAC_PI_2]);
        assert!(rests_at_start([back, back]));
        assert!(rests_at_start([back, [-0.5, 6.0]]));
        assert!(!rests_at_start([back, forth]));
    }

    /// A library that was made before a nuisance parameter was held equals one that was made after it.
    #[test]
    fn products_are_those_of_the_tolerances_that_were_open() {
        let mut joint = joint([[0.0, 16.0]]);
        let before = Library::new(&joint, &|_| false);
        assert!(joint.hold_strained(None));
        let (before, after) = (before.anew(&joint), Library::new(&joint, &|_| false));
        let again = after.gram.clone();
        assert_eq!(before.gram, again);
        assert_eq!(after.anew(&joint).gram, again);
    }
}
