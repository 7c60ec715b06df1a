//! Draws one effect of a given size.
//!
//! Size 1 leaves a residual of about 0.4 to 3 N rms in the wrench, or 0.2 to 3 mm/s rms in the executed velocity. Other sizes
//! scale the parameter that determines the residual.
//! Details that a catalogue cannot know (smoothing, trigger, place, shape) are drawn at random.

use nalgebra::{Vector3, Vector6};

use crate::actuator::{ActuatorEffect, Location};
use crate::effect::Effect;
use crate::jog::Jog;
use crate::limit;
use crate::load::LoadEffect;
use crate::meta::Meta;
use crate::noise::Noise;
use crate::sensor::{DriftShape, SensorEffect};

/// Change of the executed jog velocity by a limit of size 1, sigma rms.
const LIMIT_Z: f64 = 8.0;

/// Quantities on which the sizes depend.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Scene<'a> {
    /// Nominal model.
    pub(crate) meta: &'a Meta,
    /// Jogs of both logs.
    pub(crate) jogs: &'a [Jog; 2],
    /// Largest jog command that both logs reach, m/s and rad/s.
    pub(crate) peak_speed: [f64; 2],
    /// Largest jog slope that both logs reach, m/s² and rad/s².
    pub(crate) peak_slope: [f64; 2],
}

impl Scene<'_> {
    /// See [`limit::factor`].
    fn limit(&self, target_z: f64, limited: impl Fn(f64) -> ActuatorEffect) -> f64 {
        limit::factor(self.meta, self.jogs, target_z, limited)
    }
}

/// Draws the effect `id`; `None` for an id that does not exist.
pub(crate) fn draw(id: &str, size: f64, scene: &Scene<'_>, noise: &mut Noise) -> Option<Effect> {
    actuator(id, size, scene, noise)
        .map(Effect::Actuator)
        .or_else(|| guide(id, size, noise).map(Effect::Load))
        .or_else(|| contact(id, size, scene.meta, noise).map(Effect::Load))
        .or_else(|| sensor(id, size, scene.meta, noise).map(Effect::Sensor))
        .or_else(|| other(id, size, scene.meta, noise))
        .or_else(|| outside(id, size, scene.meta, noise))
}

fn actuator(id: &str, size: f64, scene: &Scene<'_>, noise: &mut Noise) -> Option<ActuatorEffect> {
    let place = noise.pick([Location::Input, Location::Output]);
    let reset = noise.chance(0.5);
    let weight = noise.between(0.8, 1.3) * size;
    Some(match id {
        "actuation_delay" => ActuatorEffect::Delay {
            extra_s: (0.006 * weight).min(0.018),
        },
        "actuation_lag" => ActuatorEffect::Lag {
            extra_s: (0.0065 * weight).min(0.014),
        },
        "zero_cross_pause" => {
            let pause_s = 0.009 * weight;
            ActuatorEffect::Pause {
                pause_s,
                trigger: place,
                // Without a reset a short gate can fall between two samples and leave no trace.
                reset: reset || pause_s < 2.0 * scene.meta.sample_time_s,
            }
        }
        "rate_limit" => {
            let limited = |f: f64| ActuatorEffect::RateLimit {
                linear: f * scene.peak_slope[0],
                angular: f * scene.peak_slope[1],
                place,
            };
            limited(scene.limit(LIMIT_Z * weight, limited))
        }
        "velocity_saturation" => {
            let limited = |f: f64| ActuatorEffect::Saturation {
                linear: f * scene.peak_speed[0],
                angular: f * scene.peak_speed[1],
                place,
            };
            limited(scene.limit(LIMIT_Z * weight, limited))
        }
        "structural_resonance" => ActuatorEffect::Resonance {
            frequency_hz: 15.0 / weight.sqrt(),
            damping: noise.between(0.02, 0.1),
        },
        _ => return None,
    })
}

fn guide(id: &str, size: f64, noise: &mut Noise) -> Option<LoadEffect> {
    let smooth = if noise.chance(0.3) {
        0.0
    } else {
        noise.between(1e-4, 1e-3)
    };
    let force = noise.between(1.0, 2.0) * size;
    Some(match id {
        "guide_coulomb" => LoadEffect::Coulomb { force, smooth },
        "guide_viscous" => LoadEffect::Viscous {
            coefficient: 55.0 * force,
        },
        "guide_stribeck" => LoadEffect::Stribeck {
            force,
            extra: force * noise.between(0.7, 1.1),
            speed: noise.between(0.004, 0.010),
            exponent: noise.pick([1.0, 2.0]),
            smooth: smooth.min(5e-4),
        },
        _ => return None,
    })
}

fn contact(id: &str, size: f64, meta: &Meta, noise: &mut Noise) -> Option<LoadEffect> {
    // Penetration at a contact speed of 0.03 m/s.
    let depth = 0.03 * contact_time_s(meta);
    let weight = noise.between(0.8, 1.5) * size;
    Some(match id {
        "contact_damping" => LoadEffect::ContactDamping {
            coefficient: 160.0 * weight,
        },
        "hunt_crossley" => {
            let exponent = noise.pick([1.0, 1.0, 1.25, 1.5]);
            LoadEffect::HuntCrossley {
                lambda: 350.0 * weight / depth.powf(exponent),
                exponent,
            }
        }
        "contact_cubic" => LoadEffect::Cubic {
            stiffness: 2.0 * weight / depth.powi(3),
        },
        "contact_deadzone" => LoadEffect::DeadZone {
            gap: 3.5 * weight / meta.contact.k_n,
        },
        "cable_stiffness" => LoadEffect::Cable {
            stiffness: 90.0 * weight,
            at_sensor: noise.chance(0.3),
        },
        _ => return None,
    })
}

fn sensor(id: &str, size: f64, meta: &Meta, noise: &mut Noise) -> Option<SensorEffect> {
    let with_bias = noise.chance(0.5);
    let weight = noise.between(0.8, 1.5) * size;
    Some(match id {
        "ft_bias_drift" => {
            let time = if noise.chance(0.5) {
                DriftShape::Exponential(noise.between(1.5, 6.0))
            } else {
                DriftShape::Ramp(20.0)
            };
            let last = Vector6::from_fn(|i, _| {
                let part = noise.sign() * noise.between(0.5, 1.3) * weight;
                if i < 3 { part } else { 0.06 * part }
            });
            SensorEffect::Drift {
                // A ramp of 20 s has reached half when the log ends.
                last: if let DriftShape::Ramp(_) = time {
                    last * 2.0
                } else {
                    last
                },
                shape: time,
            }
        }
        "ft_scale" => SensorEffect::Scale {
            gain: gain(0.016 * weight * noise.sign(), noise),
            with_bias,
        },
        "ft_crosstalk" => SensorEffect::CrossTalk {
            entries: entries(weight, meta, noise),
            with_bias,
        },
        "ft_quantisation" => SensorEffect::Quantisation {
            force: 2.0 * weight,
            torque: 0.12 * weight,
            down: noise.chance(0.4),
        },
        "ft_dropout" => SensorEffect::DropOut {
            probability: (0.12 * weight).clamp(0.004, 0.2),
            run: noise.pick([1, 1, 2, 4]),
        },
        _ => return None,
    })
}

/// One gain for all six components, for the forces only, or slightly different for each.
fn gain(error: f64, noise: &mut Noise) -> Vector6<f64> {
    let kind = noise.below(3);
    Vector6::from_fn(|i, _| match kind {
        0 => 1.0 + error,
        1 if i >= 3 => 1.0,
        1 => 1.0 + error,
        _ => 1.0 + error * noise.between(0.7, 1.3),
    })
}

/// Draws three to six entries, at least two of them driven by the contact force.
fn entries(weight: f64, meta: &Meta, noise: &mut Noise) -> Vec<(usize, usize, f64)> {
    let count = 3 + noise.below(4);
    let free = meta.dof_mask[1] == 1;
    let mut entries: Vec<(usize, usize, f64)> = Vec::with_capacity(count);
    while entries.len() < count {
        let column = if entries.len() < 2 || !free && noise.chance(0.5) {
            0
        } else {
            noise.below(6)
        };
        let row = noise.below(6);
        let taken = entries.iter().any(|(r, c, _)| (*r, *c) == (row, column));
        if row == column || taken {
            continue;
        }
        // Force to torque is a lever arm of some mm; torque to force is its inverse.
        let unit = match (row < 3, column < 3) {
            (true, true) => 0.02,
            (false, true) => 0.0007,
            (true, false) => 0.1,
            (false, false) => 0.015,
        };
        let value = unit * weight * noise.sign() * noise.between(0.6, 1.4);
        entries.push((row, column, value));
    }
    entries
}

fn other(id: &str, size: f64, meta: &Meta, noise: &mut Noise) -> Option<Effect> {
    let weight = noise.between(0.8, 1.5) * size;
    Some(match id {
        "tool_mass_error" => Effect::ToolMass {
            delta_kg: 0.1 * weight * noise.sign(),
        },
        "tool_com_error" => {
            // Nm per N of weight; the centre of mass of a light tool is shifted further.
            let reach = (0.13 * weight / (9.81 * meta.tool.mass_kg)).min(0.02);
            let direction = noise.normal3();
            Effect::ToolCom {
                delta_m: flat(direction, meta).normalize() * reach,
            }
        }
        "tool_inertia" => Effect::ToolInertia,
        "manipulator_resistance" => Effect::Resistance {
            stiffness: 6.0 * weight,
            damping: 12.0 * weight * noise.between(0.7, 1.3),
        },
        "sc_mass_error" => Effect::SpacecraftMass {
            ratio: 1.0 + 0.01 * weight * noise.sign(),
        },
        "clock_jitter" => {
            let share = (0.12 * weight).min(0.25);
            Effect::Jitter {
                sigma_s: share * meta.sample_time_s,
                gaussian: noise.chance(0.5),
                intervals: noise.chance(0.5),
            }
        }
        _ => return None,
    })
}

/// `1/W = sqrt(m/k)`, s: a contact at the speed v has the depth `v/W` and the deceleration `v W`.
fn contact_time_s(meta: &Meta) -> f64 {
    (meta.spacecraft.mass_kg / meta.contact.k_n).sqrt()
}

/// Reduces the component along gravity, as a shifted centre of mass shows across it.
fn flat(direction: Vector3<f64>, meta: &Meta) -> Vector3<f64> {
    let down = meta.gravity().normalize();
    direction - down * (0.7 * direction.dot(&down))
}

fn outside(id: &str, size: f64, meta: &Meta, noise: &mut Noise) -> Option<Effect> {
    let weight = noise.between(0.8, 1.5) * size;
    let phase = noise.between(0.0, core::f64::consts::TAU);
    let (force, pitch) = (3.0 * weight, noise.between(0.004, 0.012));
    Some(match id {
        "OOL_bouc_wen" => Effect::Load(LoadEffect::BoucWen {
            force: 1.8 * force,
            distance: noise.between(0.0015, 0.004),
            exponent: noise.between(1.0, 2.0),
        }),
        "OOL_force_ripple" => Effect::Load(LoadEffect::Ripple {
            force: 0.7 * force,
            pitch,
            phase,
        }),
        "OOL_lost_motion" => Effect::Load(LoadEffect::LostMotion {
            stiffness: 110.0 * force,
            half_width: noise.between(0.002, 0.004),
        }),
        "OOL_rough_guide" => Effect::Load(LoadEffect::RoughGuide {
            force,
            depth: noise.between(0.6, 0.9),
            pitch,
            phase,
        }),
        "OOL_relaxing_contact" => Effect::Load(LoadEffect::Relaxing {
            stiffness: meta.contact.k_n * 0.1 * weight,
            tau: noise.between(0.06, 0.2),
        }),
        "OOL_temperature_step" => Effect::Sensor(SensorEffect::TemperatureStep {
            axis: noise.below(3),
            size: force * noise.sign(),
            at: noise.between(0.4, 0.75) * 2500.0 * meta.sample_time_s,
            rise: noise.between(0.02, 0.3),
        }),
        "OOL_random_walk_bias" => Effect::Sensor(SensorEffect::RandomWalk {
            per_root_second: Vector6::from_fn(|i, _| 0.6 * weight * if i < 3 { 1.0 } else { 0.06 }),
        }),
        "OOL_mains_hum" => Effect::Sensor(SensorEffect::Hum {
            frequency: noise.pick([50.0, 60.0, 23.0]) + noise.between(-0.2, 0.2),
            amplitude: Vector6::from_fn(|i, _| weight * if i < 3 { 1.2 } else { 0.07 }),
            phase: Vector6::from_fn(|_, _| noise.between(0.0, core::f64::consts::TAU)),
        }),
        _ => return None,
    })
}
