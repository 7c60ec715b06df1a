//! External forces on the tip: walls, guide, cable, and the effects hidden in them.
//!
//! Walls: `F = max(0, k_n p + c_n min(1, p/delta_c) p')` with the penetration `p`; guide:
//! `F = -(k_t y + c_t y')` along y and z.

use nalgebra::{UnitQuaternion, Vector3, Vector6};

use crate::meta::{Meta, angular, linear, stack};

/// Forces that the nominal model does not contain, along world x unless said otherwise; N, m, s.
#[derive(Clone, Debug)]
pub(crate) enum LoadEffect {
    /// `guide_coulomb`: `-F tanh(v/vs)`, or `-F sign(v)` when `vs` is 0.
    Coulomb { force: f64, smooth: f64 },
    /// `guide_viscous`: `-b v`.
    Viscous { coefficient: f64 },
    /// `guide_stribeck`: `-(F + dF exp(-|v/vS|^n)) sign(v)`.
    Stribeck {
        force: f64,
        extra: f64,
        speed: f64,
        exponent: f64,
        smooth: f64,
    },
    /// `contact_damping`: an additional `c min(1, p/delta_c) p'`.
    ContactDamping { coefficient: f64 },
    /// `hunt_crossley`: `lambda p^n p'`.
    HuntCrossley { lambda: f64, exponent: f64 },
    /// `contact_cubic`: `k3 p³`.
    Cubic { stiffness: f64 },
    /// `contact_deadzone`: play before both walls.
    DeadZone { gap: f64 },
    /// `cable_stiffness`: `-k x` in all three directions, tied to the origin of M or
    /// to the sensor.
    Cable { stiffness: f64, at_sensor: bool },
    /// Outside the catalogue: hysteresis `-F z`, `z' = (v - |v| z |z|^(n-1)/2 - v |z|^n/2)/x0` (Bouc-Wen).
    BoucWen {
        force: f64,
        distance: f64,
        exponent: f64,
    },
    /// Outside the catalogue: force ripple that depends on the position.
    Ripple { force: f64, pitch: f64, phase: f64 },
    /// Outside the catalogue: a spring with lost motion (play operator), `-k w`.
    LostMotion { stiffness: f64, half_width: f64 },
    /// Outside the catalogue: Coulomb friction that varies along the guide.
    RoughGuide {
        force: f64,
        depth: f64,
        pitch: f64,
        phase: f64,
    },
    /// Outside the catalogue: a relaxing spring parallel to that of the wall (Maxwell), `f' = k p' - f/tau`.
    Relaxing { stiffness: f64, tau: f64 },
}

/// Tip motion along x at one instant.
#[derive(Clone, Copy, Debug)]
struct Touch {
    penetration: f64,
    rate: f64,
    /// -1 front wall, +1 aft wall, 0 free.
    direction: f64,
}

/// External loads with their internal states.
#[derive(Clone, Debug)]
pub(crate) struct Loads<'a> {
    plant: &'a Meta,
    effects: Vec<&'a LoadEffect>,
    states: Vec<f64>,
    gap_m: f64,
    last_penetration_m: f64,
}

impl<'a> Loads<'a> {
    /// All loads, relaxed.
    pub(crate) fn new(plant: &'a Meta, effects: Vec<&'a LoadEffect>) -> Self {
        let gap_m = effects
            .iter()
            .map(|effect| match effect {
                LoadEffect::DeadZone { gap } => *gap,
                _ => 0.0,
            })
            .sum();
        Self {
            plant,
            states: vec![0.0; effects.len()],
            effects,
            gap_m,
            last_penetration_m: 0.0,
        }
    }

    /// Whether an effect has an internal state that [`Self::advance`] updates.
    pub(crate) fn has_memory(&self) -> bool {
        self.effects.iter().any(|effect| {
            matches!(
                effect,
                LoadEffect::BoucWen { .. }
                    | LoadEffect::LostMotion { .. }
                    | LoadEffect::Relaxing { .. }
            )
        })
    }

    /// Advances the internal states by a step with the tip at `tip_x_m`, moving at `v_m_s`.
    pub(crate) fn advance(&mut self, h: f64, tip_x_m: f64, v_m_s: f64) {
        let offset = tip_x_m - self.plant.geometry.r_tip_m[0];
        let penetration = self.touch(tip_x_m, v_m_s).penetration;
        let pressed = penetration - self.last_penetration_m;
        self.last_penetration_m = penetration;
        for (effect, z) in self.effects.iter().zip(&mut self.states) {
            match **effect {
                LoadEffect::BoucWen {
                    distance, exponent, ..
                } => {
                    let shape = z.abs().powf(exponent);
                    let dz = v_m_s - 0.5 * shape * (v_m_s.abs() * z.signum() + v_m_s);
                    *z += h * dz / distance;
                }
                LoadEffect::LostMotion { half_width, .. } => {
                    *z = z.clamp(offset - half_width, offset + half_width);
                }
                LoadEffect::Relaxing { stiffness, tau } => {
                    *z = (*z + stiffness * pressed) * (-h / tau).exp();
                }
                _ => {}
            }
        }
    }

    fn touch(&self, tip_x_m: f64, v_m_s: f64) -> Touch {
        let contact = &self.plant.contact;
        let front = tip_x_m - contact.x_front_m - self.gap_m;
        let aft = contact.x_aft_m - tip_x_m - self.gap_m;
        let (penetration, rate, direction) = if front > 0.0 {
            (front, v_m_s, -1.0)
        } else if aft > 0.0 {
            (aft, -v_m_s, 1.0)
        } else {
            (0.0, 0.0, 0.0)
        };
        Touch {
            penetration,
            rate,
            direction,
        }
    }

    /// Wall force along x, N.
    fn wall_force(&self, touch: &Touch) -> f64 {
        let contact = &self.plant.contact;
        let Touch {
            penetration: p,
            rate,
            direction,
        } = *touch;
        let ramp = (p / contact.delta_c_m).min(1.0);
        let mut force = contact.k_n * p + contact.c_n * ramp * rate;
        for (effect, state) in self.effects.iter().zip(&self.states) {
            force += match **effect {
                LoadEffect::ContactDamping { coefficient } => coefficient * ramp * rate,
                LoadEffect::HuntCrossley { lambda, exponent } => lambda * p.powf(exponent) * rate,
                LoadEffect::Cubic { stiffness } => stiffness * p * p * p,
                LoadEffect::Relaxing { .. } => *state,
                _ => 0.0,
            };
        }
        direction * force.max(0.0)
    }

    /// Guide force along x at the tip, N.
    fn guide_force(&self, x: f64, v: f64) -> f64 {
        let ripple = |pitch: f64, phase: f64| (core::f64::consts::TAU * x / pitch + phase).sin();
        self.effects
            .iter()
            .zip(&self.states)
            .map(|(effect, state)| match **effect {
                LoadEffect::Coulomb { force, smooth } => -force * sign(v, smooth),
                LoadEffect::Viscous { coefficient } => -coefficient * v,
                LoadEffect::Stribeck {
                    force,
                    extra,
                    speed,
                    exponent,
                    smooth,
                } => {
                    let peak = extra * (-(v / speed).abs().powf(exponent)).exp();
                    -(force + peak) * sign(v, smooth)
                }
                LoadEffect::BoucWen { force, .. } => -force * state,
                LoadEffect::Ripple {
                    force,
                    pitch,
                    phase,
                } => force * ripple(pitch, phase),
                LoadEffect::LostMotion { stiffness, .. } => -stiffness * state,
                LoadEffect::RoughGuide {
                    force,
                    depth,
                    pitch,
                    phase,
                } => -force * (1.0 + depth * ripple(pitch, phase)) * sign(v, 1e-4),
                _ => 0.0,
            })
            .sum()
    }

    /// Wrench of all external forces on the sensor, in S: `[R^T F; (r - r_S) x R^T F]`.
    pub(crate) fn wrench(
        &self,
        position: &Vector3<f64>,
        rotation: &UnitQuaternion<f64>,
        twist: &Vector6<f64>,
    ) -> Vector6<f64> {
        let plant = self.plant;
        let arm = plant.tip();
        let tip = position + rotation * arm;
        let tip_velocity = linear(twist) + rotation * angular(twist).cross(&arm);
        let offset = tip.x - arm.x;
        let force = Vector3::new(
            self.wall_force(&self.touch(tip.x, tip_velocity.x))
                + self.guide_force(offset, tip_velocity.x),
            -(plant.contact.k_t * tip.y + plant.contact.c_t * tip_velocity.y),
            -(plant.contact.k_t * tip.z + plant.contact.c_t * tip_velocity.z),
        );
        let on_sensor = |force: Vector3<f64>, at: Vector3<f64>| {
            let body = rotation.inverse_transform_vector(&force);
            stack(&body, &(at - plant.sensor()).cross(&body))
        };
        let mut sum = on_sensor(force, arm);
        for effect in &self.effects {
            if let LoadEffect::Cable {
                stiffness,
                at_sensor,
            } = **effect
            {
                let at = if at_sensor {
                    plant.sensor()
                } else {
                    Vector3::zeros()
                };
                let stretched = position + rotation * at - at;
                sum += on_sensor(stretched * -stiffness, at);
            }
        }
        sum
    }
}

/// Sign of `v`; if `smooth` is positive, smoothed as tanh(v/smooth); 0 at rest.
fn sign(v: f64, smooth: f64) -> f64 {
    if smooth > 0.0 {
        (v / smooth).tanh()
    } else if v == 0.0 {
        0.0
    } else {
        v.signum()
    }
}
