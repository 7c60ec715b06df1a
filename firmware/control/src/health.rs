//! Checks of a cycle's inputs: is the sensor fresh and sane, is the robot in step?
//!
//! Reactions follow the project's safety notes: an old sample ramps the rate down and then latches a fault; status bits,
//! saturation and non-finite numbers latch at once.
//!
//! **A reading that repeats is old.** The six gauges of a working sensor flicker, so that a new sample with six equal words is
//! not a measurement. `stale_after_cycles` after the last change of the reading, whether the samples since are missing or
//! repeated, the model is not integrated any more. After `frozen_after_cycles` of repeated samples a fault latches; sooner where
//! the largest load that the limits allow could meanwhile change the motion by more than they allow in a cycle:
//!
//! ```text
//! ½ a T² ≤ s      a = F (1/m_K + 1/m_Q), s = limits.step_m; and likewise for rotations
//! ```

use crate::io::{Inputs, SensorSample, Sequence};
use crate::modes::{Fault, FaultCode, Mode, Readiness, Refusal};
use crate::settings::{BodySettings, Settings};
use nalgebra::ComplexField;

/// Largest coordinate of a measured position that is believed, m: no robot reaches farther.
const FARTHEST_M: f64 = 1.0e3;
/// Largest excess over 1 of the squared norm of a measured quaternion.
const LARGEST_EXCESS: f64 = 1.0e-6;

/// Whether a measured pose is finite and within its declared range.
pub(crate) fn plausible(pose: &[f64; 7]) -> bool {
    implausible(pose).is_none()
}

/// The first number beyond its range: (limit, value). For a quaternion the value is its squared norm less 1.
fn implausible([x, y, z, q @ ..]: &[f64; 7]) -> Option<(f64, f64)> {
    let excess = q.iter().map(|v| v * v).sum::<f64>() - 1.0;
    let far = FARTHEST_M;
    [(*x, far), (*y, far), (*z, far), (excess, LARGEST_EXCESS)]
        .into_iter()
        .find(|(value, limit)| !value.is_finite() || value.abs() > *limit)
        .map(|(value, limit)| (limit, value))
}

/// Remembers what the checks need from cycle to cycle.
#[derive(Clone, Debug)]
pub struct Health {
    stale_after: u32,
    fault_after: u32,
    frozen_after: u32,
    ignored_status: u32,
    lost_fault: u32,
    late_fault: u32,
    /// Cycles since the newest sample: those that were run, and those whose telegrams were lost.
    age: u32,
    lost: u32,
    /// Cycles from the sample with which the reading last changed to the newest sample, which repeats it.
    repeated: u32,
    last: SensorSample,
    late_at_start: u32,
}

impl Health {
    /// From validated settings.
    pub fn new(settings: &Settings) -> Self {
        let (sensor, robot) = (&settings.sensor, &settings.robot);
        Self {
            stale_after: sensor.stale_after_cycles,
            fault_after: sensor.fault_after_cycles,
            frozen_after: sensor.frozen_after_cycles.min(unseen_cycles(settings)),
            ignored_status: sensor.ignored_status_bits,
            lost_fault: robot.lost_telegrams_fault,
            late_fault: robot.late_answers_fault,
            age: 0,
            lost: 0,
            repeated: 0,
            last: SensorSample::default(),
            late_at_start: 0,
        }
    }

    /// Takes in this cycle's inputs. Returns the fault that they cause, in a mode in which the robot moves or is about to
    /// (`guarded`).
    pub fn check(&mut self, inputs: &Inputs, mode: Mode, guarded: bool) -> Option<Fault> {
        self.count(&inputs.sensor, inputs.robot.sequence);
        let driven = mode.moves();
        if inputs.robot.sequence == Sequence::NewRun || !driven {
            self.late_at_start = inputs.robot.late_answers;
        }
        if !guarded {
            return None;
        }
        self.numeric(inputs)
            .or_else(|| self.robot(inputs, driven))
            .or_else(|| self.sensor(&inputs.sensor))
    }

    /// Whether the newest sample arrived in this cycle and is healthy.
    pub fn good_sample(&self, inputs: &Inputs) -> bool {
        self.age == 0 && self.sensor(&inputs.sensor).is_none() && self.numeric(inputs).is_none()
    }

    /// Cycles that were run since the newest sample arrived.
    pub fn sensor_age(&self) -> u32 {
        self.age
    }

    /// Whether the sample is too old to integrate, or only repeats an old reading.
    pub fn stale(&self) -> bool {
        let repeated = if self.frozen_after > 0 {
            self.repeated
        } else {
            0
        };
        self.elapsed().saturating_add(repeated) > self.stale_after
    }

    /// Whether sensor and robot allow arming (the force is judged elsewhere).
    pub fn ready(&self, inputs: &Inputs) -> Readiness {
        let sensor = &inputs.sensor;
        if sensor.counter == 0 || self.stale() {
            return Err(Refusal::SensorStale);
        }
        if self.sensor(sensor).is_some() || self.numeric(inputs).is_some() {
            return Err(Refusal::SensorUnhealthy);
        }
        match inputs.robot.pose {
            None => Err(Refusal::NoPose),
            Some(_) if inputs.robot.gimbal_locked => Err(Refusal::OrientationSingular),
            Some(_) => Ok(()),
        }
    }

    /// Cycles since the newest sample, those of lost telegrams among them.
    fn elapsed(&self) -> u32 {
        self.age.saturating_add(self.lost)
    }

    /// Updates the age. A new sample after lost telegrams is as fresh as any, as the telegram of this cycle has triggered it.
    fn count(&mut self, sample: &SensorSample, sequence: Sequence) {
        if let Sequence::Gap(lost) = sequence {
            self.lost = self.lost.saturating_add(lost);
        }
        if sample.counter == self.last.counter {
            self.age = self.age.saturating_add(1);
            return;
        }
        let identical = sample.counts == self.last.counts && sample.wrench == self.last.wrench;
        self.repeated = if identical {
            self.repeated.saturating_add(self.age).saturating_add(1)
        } else {
            0
        };
        (self.age, self.lost) = (0, 0);
        self.last = *sample;
    }

    fn numeric(&self, inputs: &Inputs) -> Option<Fault> {
        if inputs.sensor.wrench.iter().any(|v| !v.is_finite()) {
            return Some(Fault::new(FaultCode::Numeric, 0.0, 0.0));
        }
        let (limit, value) = implausible(inputs.robot.pose.as_ref()?)?;
        let received = if value.is_finite() { value } else { 0.0 };
        let expected = if value.is_finite() { limit } else { 0.0 };
        Some(Fault::new(FaultCode::Numeric, expected, received))
    }

    fn robot(&self, inputs: &Inputs, driven: bool) -> Option<Fault> {
        if !driven {
            return None;
        }
        let late = inputs.robot.late_answers.saturating_sub(self.late_at_start);
        let fault = |code, expected: u32, received: u32| {
            Some(Fault::new(code, f64::from(expected), f64::from(received)))
        };
        match inputs.robot.sequence {
            Sequence::NewRun => fault(FaultCode::RobotRestarted, 0, 0),
            Sequence::Gap(lost) if lost > self.lost_fault => {
                fault(FaultCode::TelegramsLost, self.lost_fault, lost)
            }
            _ if late > self.late_fault => fault(FaultCode::LateAnswers, self.late_fault, late),
            _ if inputs.robot.pose.is_none() => fault(FaultCode::PoseLost, 1, 0),
            _ => None,
        }
    }

    fn sensor(&self, sample: &SensorSample) -> Option<Fault> {
        let status = sample.status & !self.ignored_status;
        let frozen = self.frozen_after > 0 && self.repeated > self.frozen_after;
        let fault = |code, expected: u32, received: u32| {
            Some(Fault::new(code, f64::from(expected), f64::from(received)))
        };
        if status != 0 {
            fault(FaultCode::SensorStatus, 0, status)
        } else if sample.saturated {
            fault(FaultCode::SensorSaturated, 0, 1)
        } else if self.elapsed() > self.fault_after {
            fault(FaultCode::SensorStale, self.fault_after, self.elapsed())
        } else if frozen {
            fault(FaultCode::SensorFrozen, self.frozen_after, self.repeated)
        } else {
            None
        }
    }
}

/// Cycles in which the largest load that `limits` allow moves the spacecraft, unmeasured, by no more than the largest correction
/// of one cycle; at least one.
fn unseen_cycles(settings: &Settings) -> u32 {
    let (limits, bodies) = (&settings.limits, [&settings.body_k, &settings.body_q]);
    let free = |body: &&&BodySettings| !body.fixed;
    let moved = bodies.iter().filter(free);
    let per_mass: f64 = moved.clone().map(|body| 1.0 / body.mass_kg).sum();
    let least_inertia = |body: &BodySettings| {
        let i = &body.inertia_kg_m2;
        nalgebra::Matrix3::from_fn(|row, column| i[row][column])
            .symmetric_eigenvalues()
            .min()
    };
    let per_inertia: f64 = moved.map(|body| 1.0 / least_inertia(body)).sum();
    let squared_s2 =
        |step: f64, acceleration: f64| 2.0 * step / acceleration.max(f64::MIN_POSITIVE);
    let translation = squared_s2(limits.step_m, limits.force_n * per_mass);
    let rotation = squared_s2(limits.step_rad, limits.torque_n_m * per_inertia);
    let longest_s = ComplexField::sqrt(translation.min(rotation));
    ((longest_s / settings.robot.cycle_s) as u32).max(1)
}

#[cfg(test)]
mod tests;
