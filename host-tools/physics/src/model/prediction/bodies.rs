//! Velocity that the rig's model of the two spacecraft asks for, predicted from the measured and compensated wrench by the
//! two-body dynamics (channel C of docs/docking-rig-log-1.md).
//!
//! The recorded state before the cycle is integrated over one cycle with the wrench at M that the law let the spacecraft feel.
//! The change of K's velocity relative to Q is the predicted change of the model's velocity (averaged over two cycles where the
//! board sends the mean, A11). Cycles in which the board does not integrate by design (start ramp, stale sensor, clamped robot)
//! have no prediction or no change. Mass properties that the model leaves out are those of the board's settings.
//!
//! A log without bodies and settings is predicted with K at the measured pose, moving with the
//! model's velocity, Q fixed, and the wrench compensated with the model's own tool and zero.

use super::signals::{Signals, Step};
use super::{ChannelPrediction, Six};
use crate::effects::mechanism::{ABOUT_START, manipulator_resistance};
use crate::effects::{Law, by_id};
use crate::model::load::pose_of;
use crate::model::{Channel, Model};
use nalgebra::UnitQuaternion;
use softdock_app::record::CycleRecord;
use softdock_control::delay::ModelVelocity;
use softdock_control::dynamics::{BodyState, TwoBody, TwoBodyState, relative_velocity};
use softdock_control::frames::{Pose, Twist, Wrench};
use softdock_control::io::BodyTrace;
use softdock_control::limits::LimitFlags;
use softdock_control::modes::Mode;
use softdock_control::settings::BodySettings;
use softdock_control::wrench::{Compensation, Motion};

const RESISTANCE: &str = manipulator_resistance::EFFECT.id;

/// Predicts the channel; a reason why it cannot is added to `notes`.
pub fn predict(model: &Model, signals: &Signals<'_>, notes: &mut Vec<String>) -> ChannelPrediction {
    let measured: Vec<Six> = signals
        .cycles
        .iter()
        .map(|c| c.trace.model_velocity)
        .collect();
    let predicted = match TwoSpacecraft::new(model, signals) {
        Some(spacecraft) => spacecraft.predict(signals, &measured),
        None => {
            let note = "The model velocity is not predicted: neither the model ([bodies.k] mass_kg and inertia_kg_m2) nor \
                        the recording says how heavy the spacecraft is.";
            notes.extend(signals.has_spacecraft().then(|| note.to_owned()));
            vec![None; measured.len()]
        }
    };
    let noise = &model.noise;
    ChannelPrediction {
        channel: Channel::ModelVelocity,
        measured,
        predicted,
        sigma: super::six(noise.model_velocity_m_s, noise.model_rate_rad_s),
        expected_sigma: Vec::new(),
    }
}

/// The two spacecraft, ready to run.
struct TwoSpacecraft {
    bodies: TwoBody<f64>,
    /// The board's own states and wrench are recorded.
    recorded: bool,
    compensation: Compensation<f64>,
    mean: bool,
    /// Cycles at the start of a run that are not integrated.
    start_cycles: u32,
    active: [bool; 6],
    resistance: Option<Resistance>,
}

impl TwoSpacecraft {
    fn new(model: &Model, signals: &Signals<'_>) -> Option<Self> {
        let settings = signals.settings.clone();
        let known = |body: &crate::model::BodyModel| {
            body.fixed == Some(true) || (body.mass_kg.is_some() && body.inertia_kg_m2.is_some())
        };
        if settings.is_none() && !known(&model.bodies.k) {
            return None;
        }
        let recorded = settings.is_some();
        let settings = settings.unwrap_or_default();
        let (mut k, mut q) = (settings.body_k.clone(), settings.body_q.clone());
        if !recorded {
            q = BodySettings {
                fixed: !known(&model.bodies.q),
                ..BodySettings::default()
            };
        }
        model.bodies.k.apply_to(&mut k);
        model.bodies.q.apply_to(&mut q);
        let nominal = k.clone();
        add_errors(model, &mut k);
        let mut active = [false; 6];
        for axis in &model.rig.active_axes {
            active[axis.index()] = true;
        }
        // A board's settings say where its manipulator is relaxed; the spring of another rig's computer ends at the origin of C.
        let resistance = (!recorded)
            .then(|| Resistance::beyond(&nominal, &mut k, model, signals))
            .flatten();
        Some(Self {
            resistance,
            bodies: TwoBody::new(&k, &q, signals.cycle_s),
            recorded,
            compensation: Compensation::new(&model.sensor_settings()),
            mean: settings.delay.model_velocity == ModelVelocity::Mean,
            // In an imported log the rows from the third of a run on are compared.
            start_cycles: if recorded {
                settings.start.zero_cycles + settings.start.ramp_cycles
            } else {
                1
            },
            active,
        })
    }

    fn predict(&self, signals: &Signals<'_>, measured: &[Six]) -> Vec<Option<Six>> {
        let mut running = 0_u32;
        let mut c_from_q = UnitQuaternion::identity();
        let mut last: Option<Six> = None;
        (0..signals.len())
            .map(|n| {
                let cycle = &signals.cycles[n];
                if cycle.trace.mode != Mode::Running || signals.steps[n] == Step::Hole {
                    running = 0;
                    last = None;
                    c_from_q = self.laboratory(signals, n).unwrap_or(c_from_q);
                    return None;
                }
                if running == 0 && n == 0 {
                    c_from_q = self.laboratory(signals, n).unwrap_or(c_from_q);
                }
                running = running.saturating_add(1);
                if running <= self.start_cycles {
                    return None;
                }
                let mut change = self.change(signals, n, &c_from_q);
                if let (Some(resistance), Some(change)) = (&self.resistance, &mut change) {
                    resistance.add_to(signals, n, &self.velocity_before(signals, n), change);
                }
                // The first integrated cycle only provides the mean of the second.
                let before = std::mem::replace(&mut last, change)?;
                let change = change?;
                Some(std::array::from_fn(|i| {
                    let step = if self.mean {
                        0.5 * (change[i] + before[i])
                    } else {
                        change[i]
                    };
                    measured[n - 1][i] + if self.active[i] { step } else { 0.0 }
                }))
            })
            .collect()
    }

    /// Orientation of Q in the laboratory, which is fixed when the board is armed.
    fn laboratory(&self, signals: &Signals<'_>, n: usize) -> Option<UnitQuaternion<f64>> {
        if !self.recorded {
            return Some(UnitQuaternion::identity());
        }
        let trace = &signals.cycles[n].trace;
        let state = TwoBodyState {
            k: body_state(&trace.body_k),
            q: body_state(&trace.body_q),
        };
        let command = pose_of(&trace.command_pose);
        Some(command.rotation * state.q_from_k().rotation.inverse())
    }

    /// Change of the velocity of K seen from Q in cycle n, in the laboratory.
    fn change(
        &self,
        signals: &Signals<'_>,
        n: usize,
        c_from_q: &UnitQuaternion<f64>,
    ) -> Option<Six> {
        let cycle = &signals.cycles[n];
        let frozen = LimitFlags(LimitFlags::SENSOR_STALE.0 | LimitFlags::ROBOT_CLAMP.0);
        if cycle.trace.limits.has(frozen) {
            return Some([0.0; 6]);
        }
        let (before, wrench) = self.before(signals, n)?;
        let after = self.bodies.step(&before, &wrench).0;
        let change =
            relative_velocity(&after.k, &after.q) - relative_velocity(&before.k, &before.q);
        let change = Twist {
            linear: c_from_q * change.linear,
            angular: change.angular,
        };
        let six = change.get();
        six.iter().all(|v| v.is_finite()).then_some(six)
    }

    /// Velocity of the model before the integration of cycle n, for a log that has it after each cycle, or the mean of before and
    /// after: an error of half a cycle's acceleration by the contact would pass for a resistance.
    fn velocity_before(&self, signals: &Signals<'_>, n: usize) -> Six {
        let logged = |n: usize| signals.cycles[n].trace.model_velocity;
        let (earlier, now) = (logged(n.saturating_sub(1)), logged(n));
        let share = if self.mean { 0.5 } else { 0.0 };
        std::array::from_fn(|i| earlier[i] + share * (now[i] - earlier[i]))
    }

    /// State before the integration of cycle n and the wrench on K in its axes.
    fn before(&self, signals: &Signals<'_>, n: usize) -> Option<(TwoBodyState<f64>, Wrench<f64>)> {
        if self.recorded {
            let last: &CycleRecord = signals.cycles.get(n.checked_sub(1)?)?;
            let state = TwoBodyState {
                k: body_state(&last.trace.body_k),
                q: body_state(&last.trace.body_q),
            };
            // The wrench that the law let the spacecraft feel, which may differ from the sensor's.
            let trace = &signals.cycles[n].trace;
            let felt = std::array::from_fn(|i| {
                trace.wrench_at_m[i] + trace.unaccounted_impulse[i] / signals.cycle_s
            });
            return Some((state, Wrench::of(&felt)));
        }
        let pose = signals.pose(n)?;
        let cycle = &signals.cycles[n];
        let still = Twist::zero();
        let state = TwoBodyState {
            k: BodyState {
                c_from_body: pose,
                velocity: Twist::of(&cycle.trace.model_velocity),
            },
            q: BodyState {
                c_from_body: Pose::identity(),
                velocity: still,
            },
        };
        signals.sampled_in(n)?;
        let motion = Motion {
            velocity: still,
            acceleration: still,
        };
        let raw = Wrench::of(&cycle.inputs.sensor.wrench);
        let wrench = self.compensation.compensate(&raw, &pose.rotation, &motion);
        Some((state, wrench.at_m))
    }
}

/// Adds the effects of the model file to the board's settings of K.
fn add_errors(model: &Model, k: &mut BodySettings) {
    for effect in &model.effects {
        if let Some(known) = by_id(&effect.id)
            && let Law::Spacecraft(law) = known.law
        {
            law(&known.values(&effect.parameters), k);
        }
    }
}

/// Resistance of a space manipulator that the rig's model contains: a spring to the origin of C, or
/// to where the log begins, and a damper on K.
struct Resistance {
    rest_m: [f64; 3],
    stiffness_per_kg: f64,
    damping_per_kg: f64,
}

impl Resistance {
    /// The resistance that the model's effect adds to the nominal K; it is removed from `k` again.
    fn beyond(
        nominal: &BodySettings,
        k: &mut BodySettings,
        model: &Model,
        signals: &Signals<'_>,
    ) -> Option<Self> {
        let effect = model.effects.iter().find(|e| e.id == RESISTANCE)?;
        let of_nominal = [nominal.arm_stiffness_n_per_m, nominal.arm_damping_n_s_per_m];
        let stiffness = std::mem::replace(&mut k.arm_stiffness_n_per_m, of_nominal[0]);
        let damping = std::mem::replace(&mut k.arm_damping_n_s_per_m, of_nominal[1]);
        let about_start = effect.parameters.get(ABOUT_START.name);
        let about_start = about_start.is_some_and(|chosen| *chosen > 0.5);
        Some(Self {
            rest_m: match about_start {
                true => [0, 1, 2].map(|axis| signals.began.pose[axis]),
                false => [0.0; 3],
            },
            stiffness_per_kg: (stiffness - of_nominal[0]) / k.mass_kg,
            damping_per_kg: (damping - of_nominal[1]) / k.mass_kg,
        })
    }

    /// Adds the change of velocity in cycle n, before which the velocity was `before`.
    fn add_to(&self, signals: &Signals<'_>, n: usize, before: &Six, change: &mut Six) {
        let trace = &signals.cycles[n].trace;
        for (axis, change) in change.iter_mut().take(3).enumerate() {
            let pull = self.stiffness_per_kg * (trace.pose[axis] - self.rest_m[axis])
                + self.damping_per_kg * before[axis];
            *change -= signals.cycle_s * pull;
        }
    }
}

fn body_state(trace: &BodyTrace) -> BodyState<f64> {
    BodyState {
        c_from_body: pose_of(&trace.pose),
        velocity: Twist::of(&trace.velocity),
    }
}
