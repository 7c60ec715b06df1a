//! Operator jog: a smooth multi-sine velocity per axis that ends with the contact speed.

use core::f64::consts::{PI, TAU};

use nalgebra::Vector6;

use crate::meta::Meta;
use crate::noise::Noise;

/// Number of rows of every log that belong to the jog.
pub(crate) const JOG_ROWS: usize = 1000;

/// Velocity commands of the jog, one per tick, m/s and rad/s.
pub(crate) type Jog = Vec<Vector6<f64>>;

/// Frequency (Hz) and relative amplitude of one sine.
type Sine = (f64, f64);

/// Motion of one axis, the same in both logs except for the phases.
struct AxisPlan {
    sines: Vec<Sine>,
    rms: f64,
    /// Largest distance from the start, m or rad.
    reach: f64,
}

/// State of one axis at the end of the jog.
struct End {
    /// m/s or rad/s.
    speed: f64,
    /// Largest distance from the start at the end, m or rad.
    position: f64,
}

/// Draws the jogs of both logs: the same sines with other phases, ending with the speeds
/// `approach_m_s` along x and almost at rest elsewhere.
pub(crate) fn draw(meta: &Meta, approach_m_s: [f64; 2], noise: &mut Noise) -> [Jog; 2] {
    let mut jogs = [0, 1].map(|_| vec![Vector6::zeros(); JOG_ROWS]);
    for axis in 0..6 {
        let plan = axis_plan(axis, meta, noise);
        for (jog, approach) in jogs.iter_mut().zip(approach_m_s) {
            let samples = draw_axis(
                &plan,
                &end(axis, approach, noise),
                meta.sample_time_s,
                noise,
            );
            if meta.moves(axis) {
                for (row, value) in jog.iter_mut().zip(samples) {
                    row[axis] = value;
                }
            }
        }
    }
    jogs
}

fn axis_plan(axis: usize, meta: &Meta, noise: &mut Noise) -> AxisPlan {
    // A jog of 2 s must still contain complete periods.
    let pace = (3.0 / (JOG_ROWS as f64 * meta.sample_time_s)).max(1.0);
    let gap_m = 0.5 * (meta.contact.x_front_m - meta.contact.x_aft_m);
    let (count, low_hz, high_hz, rms, reach) = match axis {
        0 => (3, 0.9, 2.9, noise.between(0.016, 0.022), 0.5 * gap_m),
        1 | 2 => (2, 0.45, 1.2, noise.between(0.018, 0.038), 0.05),
        _ => (2, 0.4, 1.0, noise.between(0.13, 0.3), 0.5),
    };
    let width = (high_hz - low_hz) / f64::from(count);
    let sines = (0..count)
        .map(|i| {
            let frequency = low_hz + width * (f64::from(i) + noise.unit());
            (frequency * pace, noise.between(0.6, 1.0))
        })
        .collect();
    AxisPlan { sines, rms, reach }
}

fn end(axis: usize, approach_m_s: f64, noise: &mut Noise) -> End {
    let (speed, position) = match axis {
        0 => (approach_m_s, 0.005),
        1 | 2 => (0.003 * noise.normal(), 0.0005),
        _ => (0.008 * noise.normal(), 0.015),
    };
    End { speed, position }
}

/// Tries other phases, then smaller sines, until the axis stays within its reach.
fn draw_axis(plan: &AxisPlan, end: &End, ts: f64, noise: &mut Noise) -> Vec<f64> {
    let power: f64 = plan.sines.iter().map(|(_, a)| 0.5 * a * a).sum();
    let mut scale = plan.rms / power.sqrt();
    loop {
        let phases: Vec<f64> = plan.sines.iter().map(|_| TAU * noise.unit()).collect();
        let samples = shape(plan, &phases, end, scale, ts);
        let mut position = 0.0;
        let farthest = samples.iter().fold(0.0_f64, |far, v| {
            position += v * ts;
            far.max(f64::abs(position))
        });
        if farthest < plan.reach || scale < 1e-3 {
            return samples;
        }
        scale *= 0.99;
    }
}

/// Multi-sine, smoothly switched on and blended into the end speed. If its integral would end too far from the start, a slow
/// bump is added.
fn shape(plan: &AxisPlan, phases: &[f64], end: &End, scale: f64, ts: f64) -> Vec<f64> {
    let end_s = JOG_ROWS as f64 * ts;
    let mut samples: Vec<f64> = (0..JOG_ROWS)
        .map(|n| {
            let t = (n + 1) as f64 * ts;
            let sines = plan.sines.iter().zip(phases);
            let sum: f64 = sines
                .map(|((frequency, amplitude), phase)| {
                    amplitude * (TAU * frequency * t + phase).sin()
                })
                .sum();
            let on = smooth_step(t / 0.2);
            let off = smooth_step((t - end_s + 0.3) / 0.3);
            scale * sum * on * (1.0 - off) + end.speed * off
        })
        .collect();
    let reached: f64 = samples.iter().sum::<f64>() * ts;
    let wanted = reached.clamp(-end.position, end.position);
    // The mean of sin² is 1/2.
    let bump = (wanted - reached) / (0.5 * end_s);
    for (n, value) in samples.iter_mut().enumerate() {
        *value += bump * (PI * n as f64 / JOG_ROWS as f64).sin().powi(2);
    }
    samples
}

/// Cubic step from 0 to 1, flat at both ends.
fn smooth_step(x: f64) -> f64 {
    let x = x.clamp(0.0, 1.0);
    x * x * (3.0 - 2.0 * x)
}

/// Largest command of the linear (0..3) or angular (3..6) axes.
pub(crate) fn peak_speed(jog: &Jog, axes: core::ops::Range<usize>) -> f64 {
    jog.iter()
        .flat_map(|row| axes.clone().map(|axis| row[axis].abs()))
        .fold(0.0, f64::max)
}

/// Largest slope of the command of the linear (0..3) or angular (3..6) axes, 1/s of its unit.
pub(crate) fn peak_slope(jog: &Jog, axes: core::ops::Range<usize>, ts: f64) -> f64 {
    jog.windows(2)
        .flat_map(|w| {
            axes.clone()
                .map(move |axis| (w[1][axis] - w[0][axis]).abs() / ts)
        })
        .fold(0.0, f64::max)
}
