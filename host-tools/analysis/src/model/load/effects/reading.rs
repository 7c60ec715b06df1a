//! What the sensor makes of a wrench: drift, gains, cross-talk, delay.

use super::{Coefficient, LoadEffect, Shape, choice, free, shape};
use crate::model::WrenchMeaning;
use crate::model::load::{Column, Scene};

const FINAL: &[Coefficient] = &[
    free("fx_n", "N"),
    free("fy_n", "N"),
    free("fz_n", "N"),
    free("tx_n_m", "N·m"),
    free("ty_n_m", "N·m"),
    free("tz_n_m", "N·m"),
];
const GAINS: &[Coefficient] = &[
    free("fx", "-"),
    free("fy", "-"),
    free("fz", "-"),
    free("tx", "-"),
    free("ty", "-"),
    free("tz", "-"),
    free("all_axes", "-"),
];
/// Whether gain and cross-talk act on the zero as well.
const WITH_ZERO: Shape = choice("with_zero", "-", &[0.0, 1.0], 0.0);

macro_rules! cross_talk {
    ($($name:literal $unit:literal),*) => { &[$(free($name, $unit)),*] };
}
/// Entry "to from", row by row, without the diagonal.
const ENTRIES: &[Coefficient] = cross_talk!(
    "fx_from_fy" "-", "fx_from_fz" "-", "fx_from_tx" "1/m", "fx_from_ty" "1/m", "fx_from_tz" "1/m",
    "fy_from_fx" "-", "fy_from_fz" "-", "fy_from_tx" "1/m", "fy_from_ty" "1/m", "fy_from_tz" "1/m",
    "fz_from_fx" "-", "fz_from_fy" "-", "fz_from_tx" "1/m", "fz_from_ty" "1/m", "fz_from_tz" "1/m",
    "tx_from_fx" "m", "tx_from_fy" "m", "tx_from_fz" "m", "tx_from_ty" "-", "tx_from_tz" "-",
    "ty_from_fx" "m", "ty_from_fy" "m", "ty_from_fz" "m", "ty_from_tx" "-", "ty_from_tz" "-",
    "tz_from_fx" "m", "tz_from_fy" "m", "tz_from_fz" "m", "tz_from_tx" "-", "tz_from_ty" "-"
);

/// The effects.
pub(super) const EFFECTS: &[LoadEffect] = &[
    LoadEffect {
        id: "ft_bias_drift",
        coefficients: FINAL,
        shapes: &[shape(
            "time_constant_s",
            "s",
            &[0.7, 1.2, 2.0, 3.0, 4.0, 5.5, 8.0, 12.0, 25.0, 1e3],
            1e3,
        )],
        separable: true,
        build: |scene, shapes| {
            let moving = !scene.model.sensor.at_rest;
            moving.then(|| (0..6).map(|axis| drift(scene, axis, shapes[0])).collect())
        },
    },
    LoadEffect {
        id: "ft_scale",
        coefficients: GAINS,
        shapes: &[WITH_ZERO],
        separable: true,
        build: |scene, shapes| {
            let each = (0..6).map(|axis| leaked(scene, axis, axis, shapes[0]));
            Some(each.chain([scaled(scene, shapes[0])]).collect())
        },
    },
    LoadEffect {
        id: "ft_crosstalk",
        coefficients: ENTRIES,
        shapes: &[WITH_ZERO],
        separable: true,
        build: |scene, shapes| {
            let entries = (0..6).flat_map(|to| (0..6).map(move |from| (to, from)));
            Some(
                entries
                    .filter(|(to, from)| to != from)
                    .map(|(to, from)| leaked(scene, to, from, shapes[0]))
                    .collect(),
            )
        },
    },
    LoadEffect {
        id: "ft_saturation",
        coefficients: &[],
        shapes: &[shape(
            "limit_n",
            "N",
            &[
                2.0, 3.0, 4.0, 5.5, 7.5, 10.0, 13.0, 17.0, 22.0, 28.0, 36.0, 46.0, 60.0, 80.0,
                105.0, 140.0, 190.0, 250.0, 330.0, 450.0, 600.0, 1e3, 2e3, 5e3,
            ],
            1e4,
        )],
        separable: false,
        build: |scene, shapes| {
            let column = saturated(scene, shapes[0]);
            (measured(scene) && !column.is_zero()).then(|| vec![column])
        },
    },
    LoadEffect {
        id: "ft_latency",
        coefficients: &[],
        shapes: &[shape(
            "latency_s",
            "s",
            &[2e-4, 5e-4, 1e-3, 2e-3, 4e-3, 8e-3, 1.6e-2],
            0.0,
        )],
        separable: false,
        build: |scene, shapes| measured(scene).then(|| vec![shifted(scene, shapes[0])]),
    },
    LoadEffect {
        id: "ft_low_pass",
        coefficients: &[],
        shapes: &[shape(
            "time_constant_s",
            "s",
            &[2e-4, 5e-4, 1e-3, 2e-3, 4e-3, 8e-3, 1.6e-2],
            0.0,
        )],
        separable: false,
        build: |scene, shapes| measured(scene).then(|| vec![filtered(scene, shapes[0])]),
    },
    LoadEffect {
        id: "actuation_delay",
        coefficients: &[],
        shapes: &[shape(
            "extra_delay_s",
            "s",
            &[2e-4, 5e-4, 1e-3, 2e-3, 4e-3, 8e-3, 1.6e-2],
            0.0,
        )],
        separable: false,
        build: |scene, shapes| commanded(scene).then(|| vec![shifted(scene, -shapes[0])]),
    },
    LoadEffect {
        id: "actuation_lag",
        coefficients: &[],
        shapes: &[shape(
            "extra_lag_s",
            "s",
            &[2e-4, 5e-4, 1e-3, 2e-3, 4e-3, 8e-3, 1.6e-2],
            0.0,
        )],
        separable: false,
        build: |scene, shapes| commanded(scene).then(|| vec![anticipated(scene, shapes[0])]),
    },
];

fn measured(scene: &Scene) -> bool {
    scene.model.sensor.wrench == WrenchMeaning::Measured && !scene.model.sensor.at_rest
}

fn commanded(scene: &Scene) -> bool {
    scene.model.sensor.wrench == WrenchMeaning::Commanded && !scene.model.sensor.at_rest
}

/// 1 − exp(−t/T) on one axis, from the start of the log; a ramp of 1/T for a large T.
fn drift(scene: &Scene, axis: usize, time_constant_s: f64) -> Column {
    let start = scene.time_s.first().copied().unwrap_or(0.0);
    let since = scene.time_s.iter().map(|time_s| time_s - start);
    Column::on_axis(axis, since.map(|t| -(-t / time_constant_s).exp_m1()))
}

/// Change of the reading if no force were read beyond a limit.
fn saturated(scene: &Scene, limit_n: f64) -> Column {
    Column::of(scene.len(), |n| {
        let beyond = |force: f64| force.clamp(-limit_n, limit_n) - force;
        let [x, y, z] = [0, 1, 2].map(|axis| beyond(scene.reading.at(axis, n)));
        [x, y, z, 0.0, 0.0, 0.0]
    })
}

/// The nominal load of one axis, read on another.
fn leaked(scene: &Scene, to: usize, from: usize, with_zero: f64) -> Column {
    let zero = if with_zero > 0.5 {
        0.0
    } else {
        scene.bias[from]
    };
    let read = (0..scene.len()).map(|n| scene.reading.at(from, n));
    Column::on_axis(to, read.map(|value| value - zero))
}

/// The nominal load of all axes.
fn scaled(scene: &Scene, with_zero: f64) -> Column {
    let kept = if with_zero > 0.5 { 0.0 } else { 1.0 };
    Column::of(scene.len(), |n| {
        std::array::from_fn(|axis| scene.reading.at(axis, n) - kept * scene.bias[axis])
    })
}

/// Change of the reading if it were later by a time; negative: earlier.
fn shifted(scene: &Scene, latency_s: f64) -> Column {
    let cycles = latency_s / scene.cycle_s;
    let last = scene.len().saturating_sub(1);
    Column::of(scene.len(), |n| {
        let at = (n as f64 - cycles).clamp(0.0, last as f64);
        let (low, share) = (at.floor() as usize, at.fract());
        std::array::from_fn(|axis| {
            let value = |k: usize| scene.reading.at(axis, k.min(last));
            value(low) + share * (value(low + 1) - value(low)) - value(n)
        })
    })
}

/// Change of the reading by a first-order low-pass; the reading is straight between cycles.
fn filtered(scene: &Scene, time_constant_s: f64) -> Column {
    let h = scene.cycle_s / time_constant_s.max(1e-9);
    let left = (-h).exp();
    let mut state: Option<[f64; 6]> = None;
    Column::of(scene.len(), |n| {
        let now: [f64; 6] = std::array::from_fn(|axis| scene.reading.at(axis, n));
        let before: [f64; 6] =
            std::array::from_fn(|axis| scene.reading.at(axis, n.saturating_sub(1)));
        let mut value = state.unwrap_or(now);
        for axis in 0..6 {
            let slope = (now[axis] - before[axis]) / h;
            value[axis] = now[axis] - slope + (value[axis] - before[axis] + slope) * left;
        }
        state = Some(value);
        std::array::from_fn(|axis| value[axis] - now[axis])
    })
}

/// What a force behind a lag needs as command beyond itself: T dF/dt.
fn anticipated(scene: &Scene, lag_s: f64) -> Column {
    let last = scene.len().saturating_sub(1);
    Column::of(scene.len(), |n| {
        let (before, after) = (n.saturating_sub(1), (n + 1).min(last));
        let span = (after - before).max(1) as f64 * scene.cycle_s;
        std::array::from_fn(|axis| {
            lag_s * (scene.reading.at(axis, after) - scene.reading.at(axis, before)) / span
        })
    })
}
