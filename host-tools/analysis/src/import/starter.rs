//! A model to start from, for a log that came without one.

use super::checks::GAP;
use super::model_text::commented;
use super::turns::poses_of;
use anyhow::Context;
use nalgebra::{DMatrix, DVector, Vector3};
use serde::Deserialize;
use softdock_app::record::CycleRecord;
use softdock_io::recording::Recording;
use softdock_physics::model::load::turned_since_first;
use softdock_physics::model::prediction::signals::{Signals, VelocityMeaning};
use softdock_physics::model::{Axis, FilterModel, Model, WrenchMeaning};
use softdock_statistics::{LowPassed, Noise, noise_floor};

/// Comment ahead of the model: values that only the user knows. `turns`: the one axis that moves is a rotation.
fn to_fill_in(turns: bool) -> String {
    let (moved, gravity) = match turns {
        false => (
            "mass_kg       what the sensor carries, or the moved mass of a driven axis",
            "[0, 0, 0] along a horizontal guide",
        ),
        true => (
            "inertia_kg_m2   of what turns; mass_kg and com_m of a weight that hangs off the axis",
            "[-9.81, 0, 0] where rx stands upright",
        ),
    };
    format!(
        "\
# A model to start from. Axes and noise are those of the log; the rest is for you to fill in:
#   [tool] {moved}; then
#          dynamic_compensation = true
#   [sensor] gravity_m_s2   {gravity}; wrench = \"commanded\" for what a motor was told (force,
#            voltage, duty), \"unscaled\" where its scale to newtons is a guess; a motor current that was
#            measured may be late itself: leave \"measured\", with a negative scale in the mapping; \"free\"
#            where nothing drives: effects are then in proportion to the mass or inertia above (1 if you do not know it)
#   [actuator], [[contact.walls]]   what is known of the drive and of what is touched
#   [tolerance]          how well all of these are known
# examples/model.toml has every key. [starter] in the mapping says some of this for every import.
#
"
    )
}

/// Bits to which the range of a wrench is resolved where the log does not show its noise: a plain converter, or a motor's
/// current loop.
const PLAIN_BITS: i32 = 10;
/// A converter with more bits than this has more noise than one of its steps. A smaller noise floor was not measured: it is the
/// rounding of a commanded force.
const FINEST_BITS: i32 = 16;

/// Factor by which the largest of N independent normal deviates may exceed its expected value, √(2 ln N) standard deviations: for
/// N of 100 or more, with a probability of less than a thousandth.
const LARGEST: f64 = 1.5;

/// Properties of a machine that no column of a log holds, as stated in a mapping.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Told {
    /// Meaning of the wrench.
    pub wrench: Option<WrenchMeaning>,
    /// Gravity in C, m/s².
    pub gravity_m_s2: Option<[f64; 3]>,
    /// What the sensor carries, or the moved mass of a driven axis, kg.
    pub mass_kg: Option<f64>,
}

impl Told {
    fn apply(&self, model: &mut Model) {
        let turns = model.bearing().is_some();
        let (tool, sensor) = (&mut model.tool, &mut model.sensor);
        sensor.wrench = self.wrench.unwrap_or(sensor.wrench);
        sensor.gravity_m_s2 = self.gravity_m_s2.unwrap_or(sensor.gravity_m_s2);
        tool.mass_kg = self.mass_kg.unwrap_or(tool.mass_kg);
        // What drives a motion accelerates all that moves.
        tool.dynamic_compensation |= self.mass_kg.is_some() || sensor.wrench.drives();
        if sensor.wrench == WrenchMeaning::Free {
            let unknown = if turns { 0.0 } else { 1.0 };
            tool.mass_kg = self.mass_kg.unwrap_or(unknown);
            tool.inertia_kg_m2 =
                std::array::from_fn(|i| std::array::from_fn(|k| f64::from(u8::from(i == k))));
        }
    }
}

/// Standard deviations of noise: the largest of the three translations and of the three rotations.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoiseFloors {
    /// N and N·m.
    pub wrench: [Option<f64>; 2],
    /// Of a velocity that is measured, m/s and rad/s.
    pub velocity: [Option<f64>; 2],
    /// m and rad.
    pub pose: [Option<f64>; 2],
}

/// The filter of an import, and its effect on the noise.
#[derive(Clone, Debug)]
pub struct Filtered {
    /// The low-pass.
    pub filter: FilterModel,
    /// Noise that it leaves, one entry per log. It is estimated before filtering: afterwards motion may fill the band in which
    /// noise is estimated.
    pub noise: Vec<NoiseFloors>,
}

/// A model to start from.
#[derive(Clone, Debug)]
pub struct Starter {
    /// The text of a `model.toml`: the axes that move, the noise that the log shows, and the filter through which the
    /// log went.
    pub text: String,
    /// What had to be guessed; sentences.
    pub guessed: Vec<String>,
}

/// Writes a model to start from, for logs of one machine.
///
/// # Errors
///
/// A recording without cycles or a rising time, or no recording; an impossible value in `told`.
pub fn starter(
    recordings: &[Recording],
    filtered: Option<&Filtered>,
    told: &Told,
) -> anyhow::Result<Starter> {
    let first = recordings.first().context("expected at least one log")?;
    let filter = filtered.map(|filtered| filtered.filter);
    let seen = recordings
        .iter()
        .map(|recording| Seen::of(recording, filter));
    let seen = seen.collect::<anyhow::Result<Vec<_>>>()?;
    let mut model = Model::default();
    let moves = |axis: &Axis| seen.iter().any(|log| log.moving[axis.index()]);
    model.rig.active_axes = Axis::ALL.into_iter().filter(moves).collect();
    model.sensor.filter = filter;
    told.apply(&mut model);
    model.validate().context("[starter] of the mapping")?;
    let rows = recordings.iter().map(|log| log.cycles.len());
    let before = filtered.map_or(&[][..], |filtered| &filtered.noise);
    let guessed = set_noise(&mut model, &seen, before, rows.sum::<usize>().max(2));
    set_tolerances(&mut model, &seen);
    let origin = first.header.identity.trim_start_matches("imported from ");
    let text = commented(&model, origin);
    Ok(Starter {
        text: to_fill_in(model.bearing().is_some()) + &text,
        guessed,
    })
}

/// Sets the noise of the model to what the logs show, or showed `before` they were filtered. `rows`: of all logs together.
/// Returns notes on values that are guesses because the logs show no noise.
fn set_noise(model: &mut Model, seen: &[Seen], before: &[NoiseFloors], rows: usize) -> Vec<String> {
    let mut guessed = Vec::new();
    let is_free = model.sensor.wrench == WrenchMeaning::Free;
    let moved = [model.tool.mass_kg, model.inertia_about_bearing()];
    let usual = |of: &dyn Fn(&NoiseFloors) -> Option<f64>| {
        let shown = median(seen.iter().map(|log| of(&log.floors)));
        [shown, median(before.iter().map(of))]
            .into_iter()
            .flatten()
            .reduce(f64::min)
    };
    let [force, torque] = [(0, "force_n", "N"), (1, "torque_n_m", "N·m")].map(|(kind, key, unit)| {
        // The load of a free swing is its inertial force.
        let most = |of: &dyn Fn(&Seen) -> f64| {
            let load = |log: &Seen| match is_free {
                true => moved[kind] * log.fastest[kind],
                false => of(log),
            };
            seen.iter().map(load).fold(0.0, f64::max)
        };
        let largest = most(&|log| log.largest[kind]);
        // An input may jump about a constant one, as a voltage between 10 and 12 V.
        let farthest = most(&|log| log.farthest[kind]);
        let floor = usual(&|floors| floors.wrench[kind]);
        let is_noise = |floor: &f64| {
            // White noise of that size would have produced a larger reading: such a wrench is an input that jumps from row to
            // row.
            let highest = farthest * LARGEST / (2.0 * (rows as f64).ln()).sqrt();
            (largest * step(FINEST_BITS)..=highest).contains(floor)
        };
        floor.filter(is_noise).or_else(|| {
            let guess = two_digits(largest * step(PLAIN_BITS) / 12.0_f64.sqrt())?;
            let why = match is_free {
                true => {
                    " of the largest inertial load: no force is recorded; write the standard deviation of the noise of the \
                     acceleration, times what moves, if you know it"
                }
                false => {
                    ": the log shows no noise, as where it was commanded, jumps or is coarsely rounded; write the standard \
                     deviation that you know"
                }
            };
            guessed.push(format!(
                "[noise] {key} = {guess:e} {unit} is a guess, what {PLAIN_BITS} bits resolve{why}"
            ));
            Some(guess)
        })
    });
    let noise = &mut model.noise;
    let [speed, rate] = [0, 1].map(|kind| usual(&|floors| floors.velocity[kind]));
    let [position, angle] = [0, 1].map(|kind| usual(&|floors| floors.pose[kind]));
    for (of_model, of_log) in [
        (&mut noise.force_n, force),
        (&mut noise.torque_n_m, torque),
        (&mut noise.velocity_m_s, speed),
        (&mut noise.rate_rad_s, rate),
        (&mut noise.position_m, position),
        (&mut noise.angle_rad, angle),
    ] {
        // A noise that the rounding of the log hides is not zero.
        *of_model = of_log.and_then(two_digits).unwrap_or(*of_model);
    }
    guessed
}

/// Scales the tolerances of zero and mass with the noise, where that is below the default.
fn set_tolerances(model: &mut Model, seen: &[Seen]) {
    let (noise, default) = (&model.noise, Model::default().noise);
    let force = noise.force_n / default.force_n;
    let torque = noise.torque_n_m / default.torque_n_m;
    for (axis, tolerance) in model.tolerance.bias.iter_mut().enumerate() {
        let scale = if axis < 3 { force } else { torque };
        *tolerance = two_digits(*tolerance * scale.min(1.0)).unwrap_or(*tolerance);
    }
    let mass = &mut model.tolerance.tool_mass_kg;
    *mass = two_digits(*mass * force.min(1.0)).unwrap_or(*mass);
    // The tolerance of the mass is limited so that its inertial force does not exceed the noise: that force may be all that shows
    // the motion.
    let usual = median(seen.iter().map(|log| log.acceleration));
    if let Some(heaviest) = usual.and_then(|a| two_digits(model.noise.force_n / a)) {
        *mass = mass.min(heaviest);
    }
}

/// What one log shows; largest values of a wrench are those of the three forces and of the three torques.
struct Seen {
    moving: [bool; 6],
    floors: NoiseFloors,
    largest: [f64; 2],
    /// Farthest from the mean.
    farthest: [f64; 2],
    /// Largest acceleration of the translations and of the rotations, noise of the velocity included.
    fastest: [f64; 2],
    acceleration: Option<f64>,
}

impl Seen {
    fn of(recording: &Recording, filter: Option<FilterModel>) -> anyhow::Result<Self> {
        let signals = Signals::new(recording)?;
        let cycles = recording.cycles.as_slice();
        let of_poses = match signals.velocity {
            VelocityMeaning::CycleMean => Noise::Differenced,
            VelocityMeaning::Sampled => Noise::White,
        };
        let velocity = |c: &CycleRecord| c.trace.executed_velocity;
        let sent = |c: &CycleRecord| c.trace.sent_velocity;
        let wrench = |c: &CycleRecord| c.inputs.sensor.wrench;
        let places = places(cycles);
        let changes = |of: &dyn Fn(&CycleRecord) -> [f64; 6], axis: usize| {
            let mut pairs = cycles.windows(2);
            pairs.any(|pair| (of(&pair[1])[axis] - of(&pair[0])[axis]).abs() > 0.0)
        };
        let moving: [bool; 6] =
            std::array::from_fn(|axis| changes(&velocity, axis) || changes(&sent, axis));
        let motion = motion(cycles, &moving, &places, &velocity);
        let series = |of: &dyn Fn(&CycleRecord) -> [f64; 6], axis: usize| -> Vec<f64> {
            cycles.iter().map(|cycle| of(cycle)[axis]).collect()
        };
        let filter = filter.map(|filter| filter.on_samples(signals.cycle_s));
        let floors = |of: &dyn Fn(usize) -> Vec<f64>, noise| floors(of, noise, filter);
        let measured = floors(&|axis| series(&wrench, axis), Noise::White);
        let apart = floors(
            &|axis| not_following(series(&wrench, axis), &motion),
            Noise::White,
        );
        // What does not follow the motion also contains the noise of the differentiated acceleration: the smaller estimate
        // counts.
        let less = |kind: usize| {
            measured[kind]
                .into_iter()
                .chain(apart[kind])
                .reduce(f64::min)
        };
        Ok(Self {
            moving,
            floors: NoiseFloors {
                wrench: [less(0), less(1)],
                velocity: floors(&|axis| series(&velocity, axis), of_poses),
                pose: floors(
                    &|axis| places.iter().map(|place| place[axis]).collect(),
                    Noise::White,
                ),
            },
            largest: largest(cycles, &wrench),
            farthest: farthest(cycles, &wrench),
            fastest: fastest(cycles, signals.cycle_s),
            acceleration: acceleration(cycles, signals.cycle_s),
        })
    }
}

/// Position, m, and rotation since the first cycle, rad.
fn places(cycles: &[CycleRecord]) -> Vec<[f64; 6]> {
    let turned = turned_since_first(poses_of(cycles));
    let place = |(cycle, turned): (&CycleRecord, Vector3<f64>)| {
        let [x, y, z, ..] = cycle.trace.pose;
        [x, y, z, turned.x, turned.y, turned.z]
    };
    cycles.iter().zip(turned).map(place).collect()
}

/// Whether a row follows the one before without a gap.
fn is_next(pair: &[CycleRecord], cycle_s: f64) -> bool {
    pair[1].trace.time_s - pair[0].trace.time_s < GAP * cycle_s
}

/// Largest change of a velocity from row to row, per second: m/s² and rad/s².
fn fastest(cycles: &[CycleRecord], cycle_s: f64) -> [f64; 2] {
    let next = || cycles.windows(2).filter(|pair| is_next(pair, cycle_s));
    let change = |pair: &[CycleRecord], axis: usize| {
        let [before, now] = [0, 1].map(|n: usize| pair[n].trace.executed_velocity[axis]);
        (now - before).abs() / cycle_s
    };
    let of = |axes: std::ops::Range<usize>| {
        let each = next().flat_map(|pair| axes.clone().map(move |axis| change(pair, axis)));
        each.filter(|a| a.is_finite()).fold(0.0, f64::max)
    };
    [of(0..3), of(3..6)]
}

/// Root mean square of the acceleration of the three translations from row to row, noise of the velocity included, m/s²; None
/// where nothing moves.
fn acceleration(cycles: &[CycleRecord], cycle_s: f64) -> Option<f64> {
    let square = |pair: &[CycleRecord]| {
        let [before, now] = [0, 1].map(|n: usize| &pair[n].trace);
        let changes =
            (0..3).map(|axis| now.executed_velocity[axis] - before.executed_velocity[axis]);
        is_next(pair, cycle_s).then(|| {
            changes
                .map(|change| (change / cycle_s).powi(2))
                .sum::<f64>()
        })
    };
    let squares = cycles
        .windows(2)
        .filter_map(square)
        .filter(|a| a.is_finite());
    let (sum, count) = squares.fold((0.0, 0.0), |(sum, count), a| (sum + a, count + 1.0));
    (sum > 0.0).then(|| (sum / count).sqrt())
}

/// Position, velocity and acceleration of the axes that move, a column for each, and a constant.
fn motion(
    cycles: &[CycleRecord],
    moving: &[bool; 6],
    places: &[[f64; 6]],
    velocity: &dyn Fn(&CycleRecord) -> [f64; 6],
) -> DMatrix<f64> {
    let last = cycles.len().saturating_sub(1);
    let axes = (0..6).filter(|axis| moving[*axis]);
    let of_axis = |axis: usize| {
        let change = move |n: usize| {
            velocity(&cycles[(n + 1).min(last)])[axis]
                - velocity(&cycles[n.saturating_sub(1)])[axis]
        };
        let column = |of: &dyn Fn(usize) -> f64| DVector::from_fn(cycles.len(), |n, _| of(n));
        [
            column(&|n| places[n][axis]),
            column(&|n| velocity(&cycles[n])[axis]),
            column(&change),
        ]
    };
    let constant = DVector::from_element(cycles.len(), 1.0);
    let columns: Vec<_> = axes.flat_map(of_axis).chain([constant]).collect();
    DMatrix::from_columns(&columns)
}

/// Part of a wrench that does not follow the motion: the residual of a least-squares fit. In a swept sine the motion fills the
/// band in which noise is estimated. It is the wrench itself if the motion is not finite or its columns are dependent.
fn not_following(wrench: Vec<f64>, motion: &DMatrix<f64>) -> Vec<f64> {
    let mut motion = motion.clone();
    for mut column in motion.column_iter_mut() {
        let size = column.norm();
        if size > 0.0 {
            column /= size;
        }
    }
    let measured = DVector::from_vec(wrench);
    match motion.tr_mul(&motion).cholesky() {
        Some(gram) => {
            let amounts = gram.solve(&motion.tr_mul(&measured));
            (measured - motion * amounts).as_slice().to_vec()
        }
        None => measured.as_slice().to_vec(),
    }
}

/// Median of the values that are known, of two the smaller: motion that is taken for noise makes a value larger. None if none is
/// known.
fn median(values: impl Iterator<Item = Option<f64>>) -> Option<f64> {
    let mut values: Vec<f64> = values.flatten().collect();
    values.sort_by(f64::total_cmp);
    values.get(values.len().saturating_sub(1) / 2).copied()
}

/// Step of a converter of so many bits, as a part of the largest value of its range.
fn step(bits: i32) -> f64 {
    2.0 / 2.0_f64.powi(bits)
}

/// A value above 0, rounded to two digits; None for others.
fn two_digits(value: f64) -> Option<f64> {
    format!("{value:.1e}").parse().ok().filter(|v| *v > 0.0)
}

/// Largest absolute value of the three translations and of the three rotations; 0 where nothing is measured.
fn largest(cycles: &[CycleRecord], of: &dyn Fn(&CycleRecord) -> [f64; 6]) -> [f64; 2] {
    [0..3, 3..6].map(|axes| {
        let values = cycles.iter().flat_map(|c| axes.clone().map(|i| of(c)[i]));
        values.fold(0.0, |largest, v| v.abs().max(largest))
    })
}

/// Largest departure of an axis from its mean, of the three translations and of the three rotations; 0 where nothing is measured.
fn farthest(cycles: &[CycleRecord], of: &dyn Fn(&CycleRecord) -> [f64; 6]) -> [f64; 2] {
    let mean: [f64; 6] = std::array::from_fn(|axis| {
        let values = cycles.iter().map(|c| of(c)[axis]);
        let (sum, count) = values
            .filter(|value| value.is_finite())
            .fold((0.0, 0.0), |(sum, count), value| (sum + value, count + 1.0));
        sum / f64::max(count, 1.0)
    });
    let departure = |c: &CycleRecord| {
        let value = of(c);
        std::array::from_fn(|axis| value[axis] - mean[axis])
    };
    largest(cycles, &departure)
}

/// Largest noise floor of the three translations and of the three rotations; `of` an axis the series.
fn floors(
    of: &dyn Fn(usize) -> Vec<f64>,
    noise: Noise,
    filter: Option<LowPassed>,
) -> [Option<f64>; 2] {
    /// Floors below this share of the largest value are round-off of a filter on a signal that stands still: 24 bits, which no
    /// converter and no encoder resolves.
    const ROUND_OFF: f64 = 6e-8;
    let floor = |axis: usize| {
        let values = of(axis);
        let largest = values
            .iter()
            .fold(0.0_f64, |largest, v| largest.max(v.abs()));
        noise_floor(&values, noise, filter).filter(|floor| *floor > ROUND_OFF * largest)
    };
    [0..3, 3..6].map(|axes| axes.filter_map(floor).reduce(f64::max))
}
