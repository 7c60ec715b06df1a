//! One contact with a wall across x, and how far it is from the ideal one.

use super::run::{Run, run, settings};
use softdock_control::settings::Settings;
use softdock_delay_plants::truth::Bounce;
use softdock_delay_plants::{
    Actuator, Contact, ForceLaw, Formulation, Measurement, PlantSettings, Wall,
};
use softdock_experiments::bench::delay::case::{PAUSE_S, Robot, belief};

pub(crate) const MASS_KG: f64 = 500.0;
/// Natural frequency of scenario S, rad/s.
pub(crate) const OMEGA: f64 = 21.0;
pub(crate) const CYCLE_S: f64 = 0.004;
/// Flight to the wall, s: long enough for the fit of the approach.
const FLIGHT_S: f64 = 0.8;

/// The robots of the benchmark, all without a pause, 32 to 45 ms late.
pub(crate) const PURE: Actuator = moving_on(Robot::PURE);
pub(crate) const MIXED: Actuator = moving_on(Robot::MIXED);
pub(crate) const LAG: Actuator = moving_on(Robot::LAG);
pub(crate) const SERVO: Actuator = moving_on(Robot::SERVO_10);
pub(crate) const SLOW_SERVO: Actuator = moving_on(Robot::SERVO_5);

const fn moving_on(robot: Robot) -> Actuator {
    Actuator {
        pause_s: 0.0,
        ..robot.actuator
    }
}

/// A robot that stands still for 16 ms at a reversal.
pub(crate) const fn pausing(actuator: Actuator) -> Actuator {
    Actuator {
        pause_s: PAUSE_S,
        ..actuator
    }
}

/// A contact; scenario S unless changed.
#[derive(Clone, Debug)]
pub(crate) struct Case {
    pub(crate) robot: Actuator,
    pub(crate) believed: Actuator,
    pub(crate) omega: f64,
    pub(crate) zeta: f64,
    pub(crate) exponent: f64,
    pub(crate) speed_m_s: f64,
    /// Phase of the onset within a cycle, 0 to 1.
    pub(crate) onset_phase: f64,
    pub(crate) measurement: Measurement,
    pub(crate) latency_known: bool,
    /// 0: derived.
    pub(crate) expected_stiffness: f64,
    pub(crate) interlock: bool,
    pub(crate) formulation: Formulation,
    pub(crate) seed: u64,
}

impl Default for Case {
    fn default() -> Self {
        Self {
            robot: pausing(PURE),
            believed: pausing(PURE),
            omega: OMEGA,
            zeta: 0.0,
            exponent: 1.0,
            speed_m_s: 0.005,
            onset_phase: 0.3,
            measurement: Measurement::default(),
            latency_known: true,
            expected_stiffness: 0.0,
            interlock: true,
            formulation: Formulation::Exact,
            seed: 1,
        }
    }
}

/// A contact that is over.
pub(crate) struct Outcome {
    /// Departure of the restitution from the true one.
    pub(crate) error: f64,
    pub(crate) restitution: f64,
    /// Relative departures.
    pub(crate) energy: f64,
    pub(crate) peak_force: f64,
    pub(crate) contact_time: f64,
    /// Momentum without a measured force, by 2 m v.
    pub(crate) unaccounted: f64,
    pub(crate) run: Run,
}

/// Noise of force and position.
pub(crate) fn noise(force_n: f64, position_m: f64) -> Measurement {
    Measurement {
        force_noise_n: force_n,
        torque_noise_n_m: 0.1 * force_n,
        position_noise_m: position_m,
        angle_noise_rad: position_m,
        ..Measurement::default()
    }
}

/// So many phases of the onset within a cycle.
pub(crate) fn onset_phases(count: u32) -> impl Iterator<Item = f64> {
    (0..count).map(move |i| (f64::from(i) + 0.3) / f64::from(count))
}

impl Case {
    pub(crate) fn settings(&self) -> Settings {
        let mut settings = settings();
        settings.body_k.velocity_m_s = [self.speed_m_s, 0.0, 0.0];
        settings.delay.actuator = belief(&self.believed);
        settings.delay.actuator.feedback_latency_known = self.latency_known;
        settings.delay.predictor.contact_stiffness_n_per_m = self.expected_stiffness;
        settings.delay.predictor.interlock = self.interlock;
        settings
    }

    pub(crate) fn plant(&self) -> PlantSettings {
        let distance = self.speed_m_s * (FLIGHT_S + self.onset_phase * CYCLE_S);
        let law = ForceLaw {
            exponent: self.exponent,
            ..ForceLaw::linear(
                MASS_KG * self.omega * self.omega,
                2.0 * self.zeta * MASS_KG * self.omega,
            )
        };
        let wall = Wall {
            point: [distance, 0.0, 0.0],
            normal: [-1.0, 0.0, 0.0],
            law,
        };
        PlantSettings {
            actuator: self.robot,
            formulation: self.formulation,
            contact: Contact {
                probes: vec![[0.0; 3]],
                surfaces: vec![wall.into()],
            },
            measurement: self.measurement,
            seed: self.seed,
            ..PlantSettings::default()
        }
    }

    pub(crate) fn fly(&self) -> Outcome {
        let duration_s = 1.25 + 3.2 / self.omega * (1.0 + self.zeta);
        let run = run(&self.settings(), &self.plant(), duration_s);
        let ideal = Bounce::new(
            MASS_KG,
            MASS_KG * self.omega * self.omega,
            self.zeta,
            self.speed_m_s,
        );
        let contact = run.log.contacts.first().copied().unwrap_or_default();
        let restitution = run.restitution();
        let energy = (restitution / ideal.restitution).powi(2) - 1.0;
        Outcome {
            error: restitution - ideal.restitution,
            restitution,
            energy,
            peak_force: contact.peak_force_n / ideal.peak_force_n - 1.0,
            contact_time: contact.duration_s().unwrap_or(0.0) / ideal.contact_s - 1.0,
            unaccounted: run.unaccounted() / (2.0 * MASS_KG * self.speed_m_s),
            run,
        }
    }
}

/// Mean, standard deviation and largest size of errors.
pub(crate) fn spread(errors: &[f64]) -> (f64, f64, f64) {
    let count = errors.len() as f64;
    let mean = errors.iter().sum::<f64>() / count;
    let squares: f64 = errors.iter().map(|e| (e - mean) * (e - mean)).sum();
    let worst = errors.iter().fold(0.0, |worst: f64, e| {
        if e.is_nan() {
            f64::INFINITY
        } else {
            worst.max(e.abs())
        }
    });
    (mean, (squares / count).sqrt(), worst)
}

/// Flies all cases, prints them under a name, and answers the largest error.
pub(crate) fn worst(name: &str, cases: impl Iterator<Item = Case>) -> f64 {
    let errors: Vec<f64> = cases.map(|case| case.fly().error).collect();
    let (mean, deviation, worst) = spread(&errors);
    let count = errors.len();
    println!("{name:44} {mean:+.4} ± {deviation:.4}, at most {worst:.4} of {count}");
    worst
}
