//! A benchmark case: a plant, and the board's belief of it.

use super::scene::Scene;
use softdock_control::delay::actuator::ActuatorSettings;
use softdock_delay_plants::{Actuator, Dynamics, Formulation, Measurement};

/// Speeds of the headline, mm/s.
pub const SPEEDS_MM_S: [f64; 8] = [1.0, 2.0, 3.0, 5.0, 8.0, 10.0, 12.0, 15.0];
/// Standstill at a reversal unless a case says otherwise, s.
pub const PAUSE_S: f64 = 0.016;

/// Cycle of all cases, s.
pub const CYCLE_S: f64 = 0.004;

/// A robot, with a name for tables.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Robot {
    /// Name of its structure.
    pub name: &'static str,
    /// Its dynamics.
    pub actuator: Actuator,
}

/// A plant, and the board's belief of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Case {
    /// Its name, in tables and for `--case`.
    pub name: String,
    /// The sweep that it belongs to.
    pub sweep: &'static str,
    /// The true robot.
    pub robot: Robot,
    /// How the simulation computes its motion.
    pub formulation: Formulation,
    /// The robot that the board believes in.
    pub believed: ActuatorSettings,
    /// Whether the law may refuse to go on when it finds a robot unlike the believed one.
    pub interlock: bool,
    /// The spacecraft and the mechanism between them.
    pub scene: Scene,
    /// Errors of the feedback.
    pub measurement: Measurement,
    /// Speeds, mm/s.
    pub speeds_mm_s: Vec<f64>,
    /// Number of instants of the touch within a cycle; each has its own noise.
    pub touches: usize,
    /// Whether each touch has another plant, see [`Case::of_touch`].
    pub perturbed: bool,
    /// Whether the quick benchmark contains the case.
    pub quick: bool,
}

impl Case {
    /// The canonical case: head-on at 5 mm/s, with a robot that the board knows. An entry changes only what it is about.
    pub fn new(sweep: &'static str, name: impl Into<String>) -> Self {
        Self {
            name: name.into(),
            sweep,
            robot: Robot::PURE,
            formulation: Formulation::Exact,
            believed: belief(&Robot::PURE.actuator),
            interlock: true,
            scene: Scene::head_on(),
            measurement: Measurement::default(),
            speeds_mm_s: vec![5.0],
            touches: 8,
            perturbed: false,
            quick: false,
        }
    }

    /// The case with another robot, which the board knows.
    pub fn with_robot(mut self, robot: Robot) -> Self {
        self.robot = robot;
        self.believed = belief(&robot.actuator);
        self
    }

    /// The case, marked as a part of the quick benchmark.
    pub fn quick(mut self) -> Self {
        self.quick = true;
        self
    }

    /// The case at one of its touches. The touches of a perturbed case are spread evenly over true delay ± 6 ms, stiffness
    /// and mass × 0.6 to 1.67, true pause ± 4 ms, and up to 0.5 N and 2 µm of noise. The board knows the mass.
    pub fn of_touch(&self, touch: usize) -> Self {
        let mut case = self.clone();
        if !self.perturbed {
            return case;
        }
        let spread = |base: usize| 2.0 * radical_inverse(touch + 1, base) - 1.0;
        let factor = |base: usize| (spread(base) * WIDEST_FACTOR.ln()).exp();
        case.robot.actuator.delay_s += 0.006 * spread(2);
        case.scene.law.stiffness *= factor(3);
        case.scene.mass_kg *= factor(5);
        case.robot.actuator.pause_s += 0.004 * spread(7);
        case.measurement.force_noise_n = 0.25 * (1.0 + spread(11));
        case.measurement.position_noise_m = 1e-6 * (1.0 + spread(13));
        case
    }

    /// Whether `--case NAME` means this one: its name, or that of its sweep.
    pub fn is_called(&self, name: &str) -> bool {
        self.name == name || self.sweep == name
    }
}

impl Robot {
    /// 32 ms of transport delay.
    pub const PURE: Self = Self::of("pure 32 ms", 0.032, Dynamics::None);
    /// 16 ms of transport delay and a lag of 16 ms.
    pub const MIXED: Self = Self::of("16 ms + lag 16 ms", 0.016, lag(0.016));
    /// A lag of 32 ms.
    pub const LAG: Self = Self::of("lag 32 ms", 0.0, lag(0.032));
    /// 16 ms of transport delay and a servo of 10 Hz.
    pub const SERVO_10: Self = Self::of("16 ms + servo 10 Hz", 0.016, servo(10.0));
    /// A servo of 5 Hz.
    pub const SERVO_5: Self = Self::of("servo 5 Hz", 0.0, servo(5.0));
    /// The structures of the headline.
    pub const ALL: [Self; 5] = [
        Self::PURE,
        Self::MIXED,
        Self::LAG,
        Self::SERVO_10,
        Self::SERVO_5,
    ];

    const fn of(name: &'static str, delay_s: f64, dynamics: Dynamics) -> Self {
        let mut actuator = Actuator::ideal();
        actuator.delay_s = delay_s;
        actuator.dynamics = dynamics;
        actuator.pause_s = PAUSE_S;
        Self { name, actuator }
    }
}

const fn lag(time_constant_s: f64) -> Dynamics {
    Dynamics::Lag { time_constant_s }
}

const fn servo(hz: f64) -> Dynamics {
    Dynamics::Servo { hz, damping: 0.7 }
}

/// The board's settings after a perfect identification of the robot.
pub fn belief(actuator: &Actuator) -> ActuatorSettings {
    let mut believed = ActuatorSettings {
        delay_s: actuator.delay_s,
        pause_s: actuator.pause_s,
        feedback_latency_known: true,
        ..ActuatorSettings::default()
    };
    match actuator.dynamics {
        Dynamics::None => {}
        Dynamics::Lag { time_constant_s } => believed.lag_s = time_constant_s,
        Dynamics::Servo { hz, damping } => {
            (believed.servo_hz, believed.servo_damping) = (hz, damping);
        }
    }
    believed
}

/// Largest factor on stiffness and mass of a perturbed plant; the smallest is its inverse.
const WIDEST_FACTOR: f64 = 1.0 / 0.6;

/// Van der Corput sequence in (0, 1): the digits of a number in a base, mirrored at the point, are evenly spread. With one
/// prime base per quantity this is Halton's sequence.
fn radical_inverse(mut number: usize, base: usize) -> f64 {
    let (mut value, mut digit) = (0.0, 1.0);
    while number > 0 {
        digit /= base as f64;
        value += digit * (number % base) as f64;
        number /= base;
    }
    value
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn perturbed_plants_fill_their_ranges() {
        let values: Vec<f64> = (1..=8).map(|n| radical_inverse(n, 2)).collect();
        assert_eq!(
            values,
            [0.5, 0.25, 0.75, 0.125, 0.625, 0.375, 0.875, 0.0625]
        );
        let case = Case {
            perturbed: true,
            ..Case::new("perturbed", "perturbed")
        };
        let delays = (0..64).map(|touch| case.of_touch(touch).robot.actuator.delay_s);
        let (least, most) = delays.fold((1.0, 0.0), |(a, b): (f64, f64), d| (a.min(d), b.max(d)));
        assert!((0.026..0.0263).contains(&least) && (0.0377..0.038).contains(&most));
    }
}
