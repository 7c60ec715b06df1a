//! The closed loop: robot, contact, sensor, rig computer; one log per run.

use nalgebra::{UnitQuaternion, Vector3, Vector6};

use crate::actuator::{Actuator, ActuatorEffect};
use crate::body::Body;
use crate::effect::Effect;
use crate::jog::{JOG_ROWS, Jog};
use crate::load::{LoadEffect, Loads};
use crate::log::Row;
use crate::meta::{Meta, angular, linear};
use crate::noise::{Disturbance, MeasurementNoise, Noise, NoiseCharacter};
use crate::sensor::{Sensor, SensorEffect};

/// Settings of one run.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Run<'a> {
    /// Model of the rig computer (compensation, spacecraft).
    pub(crate) nominal: &'a Meta,
    /// The true plant.
    pub(crate) plant: &'a Meta,
    /// Hidden effects.
    pub(crate) effects: &'a [Effect],
    /// Commands of the first rows.
    pub(crate) jog: &'a Jog,
    /// Number of rows of the log.
    pub(crate) rows: usize,
    /// Real noise.
    pub(crate) character: NoiseCharacter,
    /// Seed of noise, jitter and drop-outs; the reference run has the same.
    pub(crate) seed: u64,
}

/// Pose of M.
struct Motion {
    position: Vector3<f64>,
    rotation: UnitQuaternion<f64>,
}

impl Motion {
    /// Advances by a step: trapezoidal rule for the position, mean rate for the rotation.
    fn step(&mut self, h: f64, before: &Vector6<f64>, after: &Vector6<f64>) {
        let mean = (before + after) * 0.5;
        self.position += linear(&mean) * h;
        let omega = angular(&mean);
        if omega != Vector3::zeros() {
            self.rotation *= UnitQuaternion::from_scaled_axis(omega * h);
        }
    }
}

impl Run<'_> {
    /// Runs the rig and returns its log. Order within a tick: measure, model, command.
    pub(crate) fn log(&self) -> Vec<Row> {
        let plant = self.true_plant();
        let mut side = PhysicalPlant::new(self, &plant);
        let mut noise = MeasurementNoise::new(self.seed, self.character, self.nominal.noise_sigma);
        let mut body = None;
        let mut rows: Vec<Row> = Vec::with_capacity(self.rows);
        for (n, t_s) in self.instants().into_iter().enumerate() {
            let disturbance = noise.tick();
            let mut row = side.measure(t_s, &disturbance);
            row.t_s = n as f64 * self.nominal.sample_time_s;
            row.in_loop = n >= JOG_ROWS;
            if row.in_loop {
                row.model = body.get_or_insert_with(|| self.body()).tick(
                    &row.wrench,
                    &row.position,
                    &row.rotation,
                );
                row.command = row.model;
            } else {
                row.command = self.jog[n];
            }
            side.actuator.send(t_s, row.command);
            rows.push(row);
        }
        rows
    }

    /// The plant with the hidden errors of the tool.
    fn true_plant(&self) -> Meta {
        let mut plant = self.plant.clone();
        for effect in self.effects {
            match effect {
                Effect::ToolMass { delta_kg } => plant.tool.mass_kg += delta_kg,
                Effect::ToolCom { delta_m } => {
                    for (com, delta) in plant.tool.com_m.iter_mut().zip(delta_m.iter()) {
                        *com += delta;
                    }
                }
                _ => {}
            }
        }
        plant
    }

    fn select<T>(&self, of: fn(&Effect) -> Option<&T>) -> Vec<&T> {
        self.effects.iter().filter_map(of).collect()
    }

    fn actuator(&self, plant: &Meta) -> Actuator {
        let moves = core::array::from_fn(|axis| plant.moves(axis));
        Actuator::new(
            &plant.actuator,
            plant.sample_time_s,
            moves,
            &self.select(actuator),
        )
    }

    fn body(&self) -> Body<'_> {
        let mut ratio = 1.0;
        let mut resistance = (0.0, 0.0);
        for effect in self.effects {
            match effect {
                Effect::SpacecraftMass { ratio: r } => ratio = *r,
                Effect::Resistance { stiffness, damping } => resistance = (*stiffness, *damping),
                _ => {}
            }
        }
        let handover = self.jog.last().copied().unwrap_or_else(Vector6::zeros);
        Body::new(self.nominal, ratio, resistance, handover)
    }

    /// True instants of the ticks, s. Jitter either displaces each instant independently, or changes each interval, so that
    /// the instants perform a random walk.
    fn instants(&self) -> Vec<f64> {
        let ts = self.nominal.sample_time_s;
        let jitter = self.effects.iter().find_map(|effect| match effect {
            Effect::Jitter {
                sigma_s,
                gaussian,
                intervals,
            } => Some((*sigma_s, *gaussian, *intervals)),
            _ => None,
        });
        let mut noise = Noise::new(self.seed, 3);
        let mut walk = 0.0;
        let mut last = -ts;
        (0..self.rows)
            .map(|n| {
                let mut t = n as f64 * ts;
                if let Some((sigma_s, gaussian, intervals)) = jitter
                    && n > 0
                {
                    let unit = if gaussian {
                        noise.normal()
                    } else {
                        noise.between(-1.0, 1.0) * 3.0_f64.sqrt()
                    };
                    walk = if intervals { walk } else { 0.0 } + sigma_s * unit;
                    t += walk;
                    // Ticks keep their order, and the computer gets a minimum time.
                    let kept = t.max(last + 0.15 * ts);
                    walk += kept - t;
                    t = kept;
                }
                last = t;
                t
            })
            .collect()
    }
}

/// Robot, contact and sensor: everything outside the rig computer.
struct PhysicalPlant<'a> {
    plant: &'a Meta,
    actuator: Actuator,
    loads: Loads<'a>,
    sensor: Sensor<'a>,
    motion: Motion,
    last_twist: Vector6<f64>,
    /// Instant of the last measurement, s; None before the first.
    last_s: Option<f64>,
}

impl<'a> PhysicalPlant<'a> {
    fn new(run: &'a Run<'_>, plant: &'a Meta) -> Self {
        Self {
            plant,
            actuator: run.actuator(plant),
            loads: Loads::new(plant, run.select(load)),
            sensor: Sensor::new(plant.bias(), run.select(sensor), run.seed),
            motion: Motion {
                position: Vector3::zeros(),
                rotation: UnitQuaternion::identity(),
            },
            last_twist: Vector6::zeros(),
            last_s: None,
        }
    }

    /// Advances to `t_s` and measures there. The inertial load uses the velocity difference over the last period, as defined
    /// by the format.
    fn measure(&mut self, t_s: f64, noise: &Disturbance) -> Row {
        self.advance(t_s);
        let twist = self.actuator.velocity();
        let acceleration = self.last_s.map_or_else(Vector6::zeros, |last_s| {
            (twist - self.last_twist) / (t_s - last_s)
        });
        self.last_twist = twist;
        self.last_s = Some(t_s);
        let Motion { position, rotation } = &self.motion;
        let wrench = self.loads.wrench(position, rotation, &twist)
            + own_wrench(self.plant, rotation, &twist, &acceleration);
        Row {
            t_s,
            in_loop: false,
            wrench: self.sensor.read(t_s, wrench, &noise.wrench),
            command: Vector6::zeros(),
            executed: twist + noise.twist,
            position: position + noise.position,
            rotation: rotation * UnitQuaternion::from_scaled_axis(noise.angle),
            model: Vector6::zeros(),
        }
    }

    fn advance(&mut self, t_s: f64) {
        let arm = self.plant.tip();
        let Self {
            actuator,
            loads,
            motion,
            ..
        } = self;
        let memory = loads.has_memory();
        actuator.advance(t_s, |h, before, after| {
            motion.step(h, before, after);
            if memory {
                let tip = motion.position + motion.rotation * arm;
                let swing = motion.rotation * angular(after).cross(&arm);
                loads.advance(h, tip.x, after[0] + swing.x);
            }
        });
    }
}

/// Weight and inertial wrench of the tool, in S.
fn own_wrench(
    plant: &Meta,
    rotation: &UnitQuaternion<f64>,
    twist: &Vector6<f64>,
    acceleration: &Vector6<f64>,
) -> Vector6<f64> {
    let gravity = rotation.inverse_transform_vector(&plant.gravity());
    let body = rotation.inverse_transform_vector(&linear(acceleration));
    plant.tool.weight(&gravity)
        + plant.tool.inertial_wrench(
            &plant.sensor(),
            &body,
            &angular(acceleration),
            &angular(twist),
        )
}

fn actuator(effect: &Effect) -> Option<&ActuatorEffect> {
    match effect {
        Effect::Actuator(inner) => Some(inner),
        _ => None,
    }
}

fn load(effect: &Effect) -> Option<&LoadEffect> {
    match effect {
        Effect::Load(inner) => Some(inner),
        _ => None,
    }
}

fn sensor(effect: &Effect) -> Option<&SensorEffect> {
    match effect {
        Effect::Sensor(inner) => Some(inner),
        _ => None,
    }
}
