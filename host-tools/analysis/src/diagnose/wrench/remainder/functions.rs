//! The smooth functions of which a remainder consists.
//!
//! Cosines over the range of a quantity, with amplitudes that fall as k^−1.5: smoother functions are likelier. Each is a function
//! of one quantity on one axis of the reading. The simple laws of that quantity are projected out, so that a friction, a spring
//! or a weight whose form is its own is still called by its name. From functions of position and time all simple laws are
//! projected out, as on a ramp of the velocity they look like friction.

use crate::diagnose::wrench::regression::prepared_log::PreparedLog;
use nalgebra::{Cholesky, DMatrix, DVector, Dyn};
use softdock_control::frames::Pose;
use softdock_physics::model::load::{Column, Scene};
use softdock_statistics::periodogram;
use std::f64::consts::PI;

const POSITION: usize = 12;
const DIRECTION: usize = 8;
const VELOCITY: usize = 8;
const ACCELERATION: usize = 6;
const DEPTH: usize = 6;
/// Most functions of time in one log.
const TIME: usize = 12;
/// Share of the largest speed below which the direction of motion is not sure.
const SLOW: f64 = 0.02;
/// The remainder may follow time up to the frequency below which this share of the motion's power lies. Faster functions of time
/// would follow the strokes, and swallow what acts in them.
const SLOWEST: f64 = 0.1;

/// A function of the motion: a column for each log.
pub(super) type Function = Vec<Column>;

/// The quantity on which the functions of a group depend.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Quantity {
    Position,
    PositionEachWay,
    Velocity,
    Acceleration,
    Depth,
    DampedDepth,
    Time,
}

impl Quantity {
    const ALL: [Self; 7] = [
        Self::Position,
        Self::PositionEachWay,
        Self::Velocity,
        Self::Acceleration,
        Self::Depth,
        Self::DampedDepth,
        Self::Time,
    ];

    /// In words.
    pub(crate) fn words(self) -> &'static str {
        match self {
            Self::Position => "the position",
            Self::PositionEachWay => "the position, another way in each direction",
            Self::Velocity => "the velocity",
            Self::Acceleration => "the acceleration",
            Self::Depth => "the depth of the contact",
            Self::DampedDepth => "depth and velocity of the contact",
            Self::Time => "the time",
        }
    }
}

/// Functions whose amplitudes have one variance.
pub(super) struct Group {
    pub quantity: Quantity,
    pub functions: Vec<Function>,
}

/// The groups of functions of one axis. Those that vanish on all logs are left out, and those of position where a log's origin is
/// its own.
pub(super) fn of_axis(logs: &[PreparedLog], axis: usize) -> Vec<Group> {
    let motions = Motions::new(logs, axis);
    let placed = !logs.iter().any(|log| log.has_own_origin);
    let of_position = [Quantity::Position, Quantity::PositionEachWay];
    let asked = |quantity: &Quantity| placed || !of_position.contains(quantity);
    let finite = |c: &Column| !c.is_zero() && c.0[axis].iter().all(|v| v.is_finite());
    let some = |function: &Function| function.iter().any(finite);
    let groups = Quantity::ALL.into_iter().filter(asked).map(|quantity| {
        let functions = motions.functions(quantity).into_iter().filter(some);
        Group {
            quantity,
            functions: functions.collect(),
        }
    });
    groups.filter(|group| !group.functions.is_empty()).collect()
}

/// Motions of one axis over all logs.
struct Motions {
    all: Vec<Motion>,
    axis: usize,
    scales: Scales,
}

impl Motions {
    fn new(logs: &[PreparedLog], axis: usize) -> Self {
        let all = logs.iter().map(|log| Motion::new(&log.scene, axis));
        let all: Vec<Motion> = all.collect();
        Self {
            scales: Scales::of(&all),
            all,
            axis,
        }
    }

    /// Functions of one quantity, with its simple laws projected out.
    fn functions(&self, quantity: Quantity) -> Vec<Function> {
        let scales = &self.scales;
        let place = |k, m: &Motion, n: usize| wave(k, scales.place(m.position[n]));
        let depth = |k, m: &Motion, n: usize| wave(k - 1, scales.depth(m.depth[n]));
        let side = |m: &Motion, n: usize| scales.side(m.velocity[n]);
        match quantity {
            Quantity::Position => self.of_motion().taken_from(self.group(POSITION, &place)),
            Quantity::PositionEachWay => {
                let each_way = self.group(DIRECTION, &|k, m, n| side(m, n) * place(k, m, n));
                let dry = self.laws(&|m, n| vec![side(m, n)]);
                dry.taken_from(each_way)
            }
            Quantity::Velocity => {
                let velocity = |k, m: &Motion, n: usize| wave(k, scales.speed(m.velocity[n]));
                let friction = self.laws(&|m, n| vec![1.0, side(m, n), m.velocity[n]]);
                friction.taken_from(self.group(VELOCITY, &velocity))
            }
            Quantity::Acceleration => {
                let slope = |k, m: &Motion, n: usize| wave(k, scales.slope(m.acceleration[n]));
                let inertia = self.laws(&|m, n| vec![1.0, m.acceleration[n]]);
                inertia.taken_from(self.group(ACCELERATION, &slope))
            }
            Quantity::Depth => self.group(DEPTH, &|k, m, n| m.pushes(n) * depth(k, m, n)),
            Quantity::DampedDepth => self.group(DEPTH, &|k, m, n| {
                m.velocity[n] / scales.speed * m.pushes(n).abs() * depth(k, m, n)
            }),
            Quantity::Time => self.of_motion().taken_from(of_time(&self.all, self.axis)),
        }
    }

    /// The first `count` functions. `of` gives a value from the number of the function (from 1 on), the motion and the cycle.
    fn group(&self, count: usize, of: &dyn Fn(usize, &Motion, usize) -> f64) -> Vec<Function> {
        let column = |k, m: &Motion| Column::on_axis(self.axis, (0..m.len()).map(|n| of(k, m, n)));
        let function = |k| self.all.iter().map(|m| column(k, m)).collect();
        (1..=count).map(function).collect()
    }

    fn laws(&self, laws: &dyn Fn(&Motion, usize) -> Vec<f64>) -> SimpleLaws<'_> {
        SimpleLaws::new(&self.all, self.axis, laws)
    }

    /// The simple laws that place and time are freed of, as on a ramp they follow all of a motion: a constant, a spring, dry and
    /// viscous friction, inertia, and about a bearing a weight on a lever.
    fn of_motion(&self) -> SimpleLaws<'_> {
        self.laws(&|m, n| {
            let (q, v) = (m.position[n], m.velocity[n]);
            let mut laws = vec![1.0, q, self.scales.side(v), v, m.acceleration[n]];
            if self.axis >= 3 {
                laws.extend([q.sin(), q.cos()]);
            }
            laws
        })
    }
}

/// Simple laws that are projected out of functions: what is left is the residual of a regression on them.
struct SimpleLaws<'a> {
    motions: &'a [Motion],
    axis: usize,
    /// A column of unit length for each law, a row for each cycle of all motions.
    laws: DMatrix<f64>,
    normal: Option<Cholesky<f64, Dyn>>,
}

impl<'a> SimpleLaws<'a> {
    fn new(motions: &'a [Motion], axis: usize, laws: &dyn Fn(&Motion, usize) -> Vec<f64>) -> Self {
        /// Ridge that keeps the normal matrix definite where laws depend on each other.
        const OWN: f64 = 1e-9;
        let rows = motions
            .iter()
            .flat_map(|m| (0..m.len()).map(|n| laws(m, n)));
        let rows: Vec<Vec<f64>> = rows.collect();
        let count = rows.first().map_or(0, Vec::len);
        let mut laws = DMatrix::from_fn(rows.len(), count, |n, k| rows[n][k]);
        for mut law in laws.column_iter_mut() {
            let length = law.norm();
            law /= length.max(f64::MIN_POSITIVE);
        }
        let normal = laws.tr_mul(&laws) + OWN * DMatrix::identity(count, count);
        Self {
            motions,
            axis,
            laws,
            normal: Cholesky::new(normal),
        }
    }

    fn taken_from(&self, functions: Vec<Function>) -> Vec<Function> {
        let Some(normal) = &self.normal else {
            return Vec::new();
        };
        let less = |function: Function| -> Function {
            let all = self.motions.iter().zip(&function);
            let all = all.flat_map(|(m, column)| (0..m.len()).map(|n| column.at(self.axis, n)));
            let series = DVector::from_iterator(self.laws.nrows(), all);
            let rest = &series - &self.laws * normal.solve(&self.laws.tr_mul(&series));
            let mut from = 0;
            let part = |m: &Motion| {
                let rows = from..from + m.len();
                from = rows.end;
                Column::on_axis(self.axis, rows.map(|n| rest[n]))
            };
            self.motions.iter().map(part).collect()
        };
        functions.into_iter().map(less).collect()
    }
}

fn wave(k: usize, share: f64) -> f64 {
    (PI * k as f64 * share).cos() / (k.max(1) as f64).powf(1.5)
}

/// Functions of time; each belongs to one log and is 0 on the others.
fn of_time(motions: &[Motion], axis: usize) -> Vec<Function> {
    let mut all = Vec::new();
    for (log, motion) in motions.iter().enumerate() {
        for k in 0..=motion.slower_functions() {
            let series = (0..motion.len()).map(|n| wave(k, n as f64 / motion.len() as f64));
            let mut function = vec![Column::default(); motions.len()];
            function[log] = Column::on_axis(axis, series);
            all.push(function);
        }
    }
    all
}

/// Motion of one axis over a log.
pub(super) struct Motion {
    pub(super) position: Vec<f64>,
    velocity: Vec<f64>,
    acceleration: Vec<f64>,
    /// Depth of the contact along this axis, m: positive where the wall pushes in its positive direction, negative otherwise.
    depth: Vec<f64>,
}

impl Motion {
    pub(super) fn new(scene: &Scene, axis: usize) -> Self {
        let start = scene.pose.first();
        let position = |(n, pose): (usize, &Pose<f64>)| match (axis, start) {
            (0..3, _) => pose.translation.vector[axis],
            _ if scene.model.bearing().is_some_and(|a| a.index() == axis) => scene.position[n],
            (_, Some(start)) => (start.rotation.inverse() * pose.rotation).scaled_axis()[axis - 3],
            _ => 0.0,
        };
        let depth = |n: usize| -> f64 {
            let touches = scene.touches.iter().filter(|_| axis < 3);
            let along = touches.map(|t| t.penetration[n].max(0.0) * t.normal[axis]);
            along.sum()
        };
        Self {
            position: scene.pose.iter().enumerate().map(position).collect(),
            velocity: scene
                .motion
                .iter()
                .map(|m| m.velocity.get()[axis])
                .collect(),
            acceleration: scene
                .motion
                .iter()
                .map(|m| m.acceleration.get()[axis])
                .collect(),
            depth: (0..scene.pose.len()).map(depth).collect(),
        }
    }

    fn len(&self) -> usize {
        self.position.len()
    }

    /// Sign of the direction in which a wall pushes; 0 out of contact.
    fn pushes(&self, n: usize) -> f64 {
        match self.depth[n] {
            0.0 => 0.0,
            depth => depth.signum(),
        }
    }

    /// How many half periods of time are slower than the motion.
    fn slower_functions(&self) -> usize {
        let power = periodogram(&self.velocity);
        let total: f64 = power.iter().sum();
        let mut sum = 0.0;
        let slow = power.iter().take_while(|p| {
            sum += **p;
            sum < SLOWEST * total
        });
        let periods = slow.count() + 1;
        (2 * periods / 3).clamp(1, TIME)
    }
}

/// Ranges of the quantities over all logs.
struct Scales {
    position: (f64, f64),
    speed: f64,
    acceleration: f64,
    depth: f64,
}

impl Scales {
    fn of(motions: &[Motion]) -> Self {
        let largest = |of: &dyn Fn(&Motion) -> &Vec<f64>| {
            let all = motions.iter().flat_map(of);
            all.fold(0.0, |most: f64, v| most.max(v.abs()))
        };
        let positions = motions.iter().flat_map(|m| &m.position);
        Self {
            position: positions.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| {
                (low.min(*v), high.max(*v))
            }),
            speed: largest(&|m| &m.velocity),
            acceleration: largest(&|m| &m.acceleration),
            depth: largest(&|m| &m.depth),
        }
    }

    fn place(&self, position: f64) -> f64 {
        (position - self.position.0) / (self.position.1 - self.position.0)
    }

    /// Direction of motion from −1 to 1, smooth about rest.
    fn side(&self, velocity: f64) -> f64 {
        (velocity / (SLOW * self.speed)).tanh()
    }

    fn speed(&self, velocity: f64) -> f64 {
        signed_root(velocity / self.speed)
    }

    fn slope(&self, acceleration: f64) -> f64 {
        signed_root(acceleration / self.acceleration)
    }

    fn depth(&self, depth: f64) -> f64 {
        depth.abs() / self.depth
    }
}

/// Maps −1 … 1 to 0 … 1 by a square root, which is finer around rest.
fn signed_root(share: f64) -> f64 {
    0.5 + 0.5 * share.signum() * share.abs().sqrt()
}
