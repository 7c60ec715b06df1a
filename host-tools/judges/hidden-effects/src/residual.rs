//! Residuals of the nominal model and their size `z`, as the log format defines them.
//!
//! `z` = RMS over all rows and the active axes of residual / sigma, for the channels
//! A actuator, B wrench, C rig model, K kinematics.

use nalgebra::{UnitQuaternion, Vector3, Vector6};

use crate::body::Dynamics;
use crate::log::{Row, from_csv};
use crate::meta::{ActuatorModel, Contact, Meta, NoiseSigma, angular, linear, stack};

/// Sigma of the rig-model channel, m/s and rad/s: rounding in the rig computer.
const MODEL_SIGMA: f64 = 2e-7;

/// Normalised residuals z of [A, B, C, K] for the text of a log under the model of a `meta.json`.
///
/// # Errors
/// The line or the field that cannot be read.
pub fn normalised(meta_json: &str, csv: &str) -> Result<[f64; 4], String> {
    let meta: Meta = serde_json::from_str(meta_json).map_err(|e| format!("meta.json: {e}"))?;
    Ok(z(&meta, &from_csv(csv)?))
}

/// Normalised residuals z of [A, B, C, K].
pub(crate) fn z(meta: &Meta, rows: &[Row]) -> [f64; 4] {
    let sigma = &meta.noise_sigma;
    let executed = nominal_execution(&meta.actuator, meta.sample_time_s, rows);
    let dynamics = Dynamics::new(meta);
    let mut sums = [Mean::default(); 4];
    for n in 0..rows.len() {
        let row = &rows[n];
        let a = row.executed - executed[n];
        let b = row.wrench - nominal_wrench(meta, rows, n);
        let c = model_residual(meta, &dynamics, rows, n);
        let k = kinematic_residual(meta.sample_time_s, rows, n);
        for axis in 0..6 {
            let moves = meta.moves(axis);
            let (velocity, load) = scales(sigma, axis);
            sums[1].add(b[axis] / load);
            if moves {
                sums[0].add(a[axis] / velocity);
                sums[2].add(c[axis] / MODEL_SIGMA);
            }
            if moves && axis < 3 {
                sums[3].add(k[axis] / (core::f64::consts::SQRT_2 * sigma.position_m));
            }
        }
    }
    sums.map(|mean| mean.root())
}

/// Standard deviations of velocity and of wrench on one axis.
fn scales(sigma: &NoiseSigma, axis: usize) -> (f64, f64) {
    if axis < 3 {
        (sigma.velocity_m_s, sigma.force_n)
    } else {
        (sigma.rate_rad_s, sigma.torque_nm)
    }
}

#[derive(Clone, Copy, Debug, Default)]
struct Mean {
    sum: f64,
    count: usize,
}

impl Mean {
    fn add(&mut self, value: f64) {
        self.sum += value * value;
        self.count += 1;
    }

    fn root(self) -> f64 {
        (self.sum / self.count.max(1) as f64).sqrt()
    }
}

/// `y(n) = e y(n-1) + (1-e) v_cmd(n-1-d)`, `e = exp(-Ts/T)`. With a fractional `d = k + f` the older command acts for the
/// first `f Ts` of the tick and the younger one for the rest.
fn nominal_execution(model: &ActuatorModel, ts: f64, rows: &[Row]) -> Vec<Vector6<f64>> {
    let d = model.transport_delay_s / ts;
    // Rounding must not reduce a delay of whole samples by one.
    let whole = (d + 1e-9).floor();
    let fraction = (d - whole).max(0.0);
    let older = (-fraction * ts / model.lag_time_constant_s).exp();
    let younger = (-(1.0 - fraction) * ts / model.lag_time_constant_s).exp();
    let command = |n: usize, back: usize| {
        n.checked_sub(back)
            .map_or_else(Vector6::zeros, |i| rows[i].command)
    };
    let back = whole as usize + 1;
    let mut y = Vector6::zeros();
    (0..rows.len())
        .map(|n| {
            if n > 0 {
                let first = command(n, back + 1);
                let second = command(n, back);
                y = first + (y - first) * older;
                y = second + (y - second) * younger;
            }
            y
        })
        .collect()
}

/// Sum of contact, guide, weight, inertia and bias, in S.
fn nominal_wrench(meta: &Meta, rows: &[Row], n: usize) -> Vector6<f64> {
    let row = &rows[n];
    let arm = meta.tip();
    let omega = angular(&row.executed);
    let tip = row.position + row.rotation * arm;
    let velocity = linear(&row.executed) + row.rotation * omega.cross(&arm);
    let force =
        row.rotation
            .inverse_transform_vector(&contact_force(&meta.contact, &tip, &velocity));
    let gravity = row.rotation.inverse_transform_vector(&meta.gravity());
    let mut sum = stack(&force, &(arm - meta.sensor()).cross(&force))
        + meta.tool.weight(&gravity)
        + meta.bias();
    if meta.tool.dynamic_compensation {
        let acceleration = if n > 0 {
            (row.executed - rows[n - 1].executed) / meta.sample_time_s
        } else {
            Vector6::zeros()
        };
        let body = row
            .rotation
            .inverse_transform_vector(&linear(&acceleration));
        sum += meta
            .tool
            .inertial_wrench(&meta.sensor(), &body, &angular(&acceleration), &omega);
    }
    sum
}

fn contact_force(contact: &Contact, tip: &Vector3<f64>, velocity: &Vector3<f64>) -> Vector3<f64> {
    let wall = |p: f64, rate: f64| {
        let damping = contact.c_n * (p / contact.delta_c_m).min(1.0);
        (contact.k_n * p + damping * rate).max(0.0)
    };
    let x = if tip.x > contact.x_front_m {
        -wall(tip.x - contact.x_front_m, velocity.x)
    } else if tip.x < contact.x_aft_m {
        wall(contact.x_aft_m - tip.x, -velocity.x)
    } else {
        0.0
    };
    Vector3::new(
        x,
        -(contact.k_t * tip.y + contact.c_t * velocity.y),
        -(contact.k_t * tip.z + contact.c_t * velocity.z),
    )
}

/// `v_model(n) - v_model(n-1) - Ts/2 (A(n) + A(n-1))` after the second row of mode 1; else zero.
fn model_residual(meta: &Meta, dynamics: &Dynamics, rows: &[Row], n: usize) -> Vector6<f64> {
    if n < 2 || !rows[n - 2].in_loop {
        return Vector6::zeros();
    }
    let acceleration = |row: &Row| {
        let rotation: &UnitQuaternion<f64> = &row.rotation;
        dynamics.acceleration(&row.wrench, rotation, &angular(&row.model))
    };
    let sum = acceleration(&rows[n]) + acceleration(&rows[n - 1]);
    rows[n].model - rows[n - 1].model - sum * (0.5 * meta.sample_time_s)
}

/// `p(n) - p(n-1) - Ts/2 (v(n) + v(n-1))`.
fn kinematic_residual(ts: f64, rows: &[Row], n: usize) -> Vector3<f64> {
    if n == 0 {
        return Vector3::zeros();
    }
    let (new, old) = (&rows[n], &rows[n - 1]);
    new.position - old.position - (linear(&new.executed) + linear(&old.executed)) * (0.5 * ts)
}
