//! All readings together with the motion in which they were taken, from which the inertia of the tool is found.
//!
//! Velocity and acceleration are differences of poses; they and the wrench go through the same
//! zero-phase low-pass, so that nothing is shifted between them and the noise of the differences
//! stays small. The pose may be older than the wrench by a latency of the robot's measurement.

use super::observation::{Group, Observation};
use super::source::{Mounting, Reading};
use anyhow::{Result, ensure};
use nalgebra::{Vector3, Vector6};
use softdock_control::frames::Wrench;
use softdock_statistics::LowPass;

/// Cut-off of the low-pass, Hz: below the resonances of tools and robots, above their motion.
const CUTOFF_HZ: f64 = 10.0;
/// Order of one pass of it.
const ORDER: u32 = 4;
/// Observations in a period of the cut-off: neighbours are hardly correlated.
const PER_PERIOD: f64 = 2.5;
/// What is left out at either end of a stretch, s.
const TRIM_S: f64 = 0.1;
/// Shortest stretch without a gap that is used, s.
const SHORTEST_S: f64 = 1.0;
/// Observations of a group: 0.4 s.
const GROUP: usize = 10;
/// Oldest pose that is looked for, s.
pub(super) const OLDEST_S: f64 = 0.04;

/// A stretch of readings at equal distances as filtered signals.
pub(super) struct Stretch<'a> {
    readings: &'a [Reading],
    cycle_s: f64,
    mounting: Mounting,
    /// Acceleration of the sensor's origin, angular velocity and acceleration, in S.
    motion: Vec<[Vector3<f64>; 3]>,
    wrench: Vec<Vector6<f64>>,
}

/// The stretches of a recording.
///
/// # Errors
///
/// No stretch is long enough.
pub(super) fn stretches<'a>(
    readings: &'a [Reading],
    mounting: &Mounting,
) -> Result<Vec<Stretch<'a>>> {
    let mut all = Vec::new();
    let mut begin = 0;
    for n in 1..=readings.len() {
        if n == readings.len() || !readings[n].continues {
            let own = &readings[begin..n];
            let lasts_s = own[own.len() - 1].time_s - own[0].time_s;
            if own.len() > 2 && lasts_s >= SHORTEST_S {
                all.push(Stretch::new(own, mounting));
            }
            begin = n;
        }
    }
    ensure!(
        !all.is_empty(),
        "the tool's inertia needs at least {SHORTEST_S} s of cycles without a gap, each with a new \
         sample of the sensor; leave --inertia away to calibrate from the poses at rest"
    );
    Ok(all)
}

/// The groups of all stretches, with poses that are `age_s` older than the wrench.
pub(super) fn groups(stretches: &[Stretch<'_>], age_s: f64) -> Vec<Group> {
    stretches.iter().flat_map(|s| s.groups(age_s)).collect()
}

impl<'a> Stretch<'a> {
    fn new(readings: &'a [Reading], mounting: &Mounting) -> Self {
        let count = readings.len();
        let cycle_s = (readings[count - 1].time_s - readings[0].time_s) / (count - 1) as f64;
        let mut motion = motions(readings, mounting, cycle_s);
        let mut wrench: Vec<Vector6<f64>> = readings
            .iter()
            .map(|r| Vector6::from_row_slice(&r.wrench.get()))
            .collect();
        let cutoff = CUTOFF_HZ * cycle_s;
        // A log that is slower than the filter is smooth enough as it is.
        if cutoff < 0.4 {
            let filter = LowPass::new(ORDER, cutoff);
            for part in 0..3 {
                for axis in 0..3 {
                    let own: Vec<f64> = motion.iter().map(|m| m[part][axis]).collect();
                    let smooth = filter.zero_phase(&own);
                    motion
                        .iter_mut()
                        .zip(smooth)
                        .for_each(|(m, v)| m[part][axis] = v);
                }
            }
            for axis in 0..6 {
                let own: Vec<f64> = wrench.iter().map(|w| w[axis]).collect();
                let smooth = filter.zero_phase(&own);
                wrench.iter_mut().zip(smooth).for_each(|(w, v)| w[axis] = v);
            }
        }
        Self {
            readings,
            cycle_s,
            mounting: *mounting,
            motion,
            wrench,
        }
    }

    fn groups(&self, age_s: f64) -> Vec<Group> {
        let step = (1.0 / (CUTOFF_HZ * PER_PERIOD * self.cycle_s))
            .round()
            .max(1.0) as usize;
        let trim = (TRIM_S / self.cycle_s).ceil() as usize;
        // The same readings whatever the age is, so that fits can be compared.
        let late = (OLDEST_S / self.cycle_s).ceil() as usize;
        let end = self.readings.len().saturating_sub(trim);
        let chosen: Vec<usize> = (trim + late..end).step_by(step).collect();
        let group = |own: &[usize]| Group {
            time_s: [
                self.readings[own[0]].time_s,
                self.readings[own[own.len() - 1]].time_s,
            ],
            pose: None,
            observations: own.iter().map(|n| self.observation(*n, age_s)).collect(),
        };
        chosen.chunks(GROUP).map(group).collect()
    }

    /// Motion that reading n shows, and the wrench at the instant of that pose.
    fn observation(&self, n: usize, age_s: f64) -> Observation {
        let back = age_s / self.cycle_s;
        let (whole, part) = (back.floor() as usize, back.fract());
        let newer = self.wrench[n.saturating_sub(whole)];
        let older = self.wrench[n.saturating_sub(whole + 1)];
        let wrench = newer * (1.0 - part) + older * part;
        let [acceleration, angular_velocity, angular_acceleration] = self.motion[n];
        Observation {
            c_from_s: self.mounting.c_from_s(&self.readings[n].pose),
            acceleration,
            angular_velocity,
            angular_acceleration,
            wrench: Wrench::of(&[
                wrench[0], wrench[1], wrench[2], wrench[3], wrench[4], wrench[5],
            ]),
        }
    }
}

/// Acceleration of the sensor's origin, angular velocity and acceleration in S, by differences.
fn motions(readings: &[Reading], mounting: &Mounting, cycle_s: f64) -> Vec<[Vector3<f64>; 3]> {
    let last = readings.len() - 1;
    let turn = |from: usize, to: usize| {
        let (from, to) = (&readings[from].pose.rotation, &readings[to].pose.rotation);
        (from.inverse() * to).scaled_axis()
    };
    let s_from_m = mounting.m_from_s.rotation.inverse();
    let arm = mounting.m_from_s.translation.vector;
    (0..readings.len())
        .map(|n| {
            // At the ends the motion of the neighbour.
            let n = n.clamp(1, last - 1);
            let place = |k: usize| readings[k].pose.translation.vector;
            let linear = (place(n + 1) - place(n) * 2.0 + place(n - 1)) / (cycle_s * cycle_s);
            let omega = (turn(n - 1, n) + turn(n, n + 1)) / (2.0 * cycle_s);
            let alpha = (turn(n, n + 1) - turn(n - 1, n)) / (cycle_s * cycle_s);
            let at_sensor = readings[n].pose.rotation.inverse() * linear
                + alpha.cross(&arm)
                + omega.cross(&omega.cross(&arm));
            [s_from_m * at_sensor, s_from_m * omega, s_from_m * alpha]
        })
        .collect()
}
