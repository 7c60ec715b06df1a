//! How far fixed point and f32 are from f64 over the spring-rod test: approach, contact and
//! rebound at the late robot, three seconds, with every delay law.
//!
//! The board without a floating-point unit runs fixed point; these numbers are what that costs.

use nalgebra::{Quaternion, UnitQuaternion};
use softdock_control::delay::LawName;
use softdock_control::io::Trace;
use softdock_control::scalar::{Fixed, Scalar};
use softdock_experiments::scenario::Scenario;
use softdock_tests::every_setting::every_setting;
use softdock_tests::walls::Case;

/// Approach speeds, m/s.
const SPEEDS_M_S: [f64; 4] = [0.001, 0.003, 0.005, 0.015];
/// A contact that is across no axis, rad.
const WALL_TURNED_RAD: f64 = 0.4;
const CYCLES: usize = 750;

/// Largest distance from f64.
#[derive(Clone, Copy, Debug, Default)]
struct Deviation {
    /// Commanded position, m, and orientation, rad.
    position_m: f64,
    orientation_rad: f64,
    /// Velocity of the model and of the command, m/s and rad/s.
    velocity_m_s: f64,
    velocity_rad_s: f64,
    /// Speed after the contact over speed before it.
    restitution: f64,
}

impl Deviation {
    fn note(&mut self, found: &Trace, known: &Trace) {
        let most = |a: &[f64], b: &[f64]| {
            let apart = a.iter().zip(b).map(|(a, b)| (a - b).abs());
            apart.fold(0.0, f64::max)
        };
        let (p, q) = (&found.command_pose, &known.command_pose);
        self.position_m = self.position_m.max(most(&p[..3], &q[..3]));
        let angle = orientation(p).angle_to(&orientation(q));
        self.orientation_rad = self.orientation_rad.max(angle);
        for (v, w) in [
            (&found.body_k.velocity, &known.body_k.velocity),
            (&found.sent_velocity, &known.sent_velocity),
        ] {
            self.velocity_m_s = self.velocity_m_s.max(most(&v[..3], &w[..3]));
            self.velocity_rad_s = self.velocity_rad_s.max(most(&v[3..], &w[3..]));
        }
    }

    fn is_within(&self, bound: &Self) -> bool {
        self.position_m <= bound.position_m
            && self.orientation_rad <= bound.orientation_rad
            && self.velocity_m_s <= bound.velocity_m_s
            && self.velocity_rad_s <= bound.velocity_rad_s
            && self.restitution <= bound.restitution
    }
}

fn orientation(pose: &[f64; 7]) -> UnitQuaternion<f64> {
    let [_, _, _, w, i, j, k] = *pose;
    UnitQuaternion::from_quaternion(Quaternion::new(w, i, j, k))
}

/// The settings of the built-in scenario, between the walls of the known answers.
fn spring_rod(speed_m_s: f64, law: LawName) -> Case {
    let scenario = Scenario::spring_rod().unwrap().with_law(law);
    let mut case = Case::scenario_s(speed_m_s, law).turned(WALL_TURNED_RAD);
    let known = case.settings.clone();
    case.settings = scenario.board.control;
    case.settings.body_k.velocity_m_s = known.body_k.velocity_m_s;
    // The walls push; nothing hangs on this sensor. It sits beside the centre of mass, so that the
    // contact turns the spacecraft as well.
    case.settings.sensor.tool_mass_kg = 0.0;
    case.settings.sensor.position_m = [0.02, 0.05, 0.1];
    case.settings.body_k.angular_velocity_rad_s = [0.002, -0.001, 0.003];
    // A quarter of a second of free flight behind the start ramp.
    let ramp_s = 0.5 * f64::from(case.settings.start.ramp_cycles) * case.settings.robot.cycle_s;
    case.right_m += ramp_s * speed_m_s;
    case
}

/// All cycles of a run, and the restitution.
fn run<S: Scalar>(case: &Case) -> (Vec<Trace>, f64) {
    let mut rig = case.start::<S>();
    let traces: Vec<Trace> = (0..CYCLES).map(|_| rig.step().trace).collect();
    assert!(traces.iter().all(|t| t.fault.is_none()));
    let along = |t: &Trace| {
        let [x, y, z, ..] = t.body_k.velocity;
        case.normal.dot(&nalgebra::Vector3::new(x, y, z))
    };
    let last = traces.last().unwrap();
    let touched = traces.iter().any(|t| t.wrench_at_m[0].abs() > 1.0);
    // Passivity may take all of the speed away, and the spacecraft rests on the rod.
    let rests = case.settings.delay.law == LawName::Passivity;
    assert!(
        touched && (rests || last.wrench_at_m[0].abs() < 1e-6),
        "{last:?}"
    );
    (traces.clone(), -along(last) / case.speed_m_s())
}

fn deviation<S: Scalar>(case: &Case) -> Deviation {
    let (known, found) = (run::<f64>(case), run::<S>(case));
    let mut deviation = Deviation {
        restitution: (found.1 - known.1).abs(),
        ..Deviation::default()
    };
    for (found, known) in found.0.iter().zip(&known.0) {
        deviation.note(found, known);
    }
    deviation
}

/// All laws, by the names that a settings file may have, but for the one whose differentiator switches: of it only the
/// rebounds agree.
fn laws() -> Vec<LawName> {
    let all = every_setting();
    let law = all.iter().find(|f| f.name == "delay.law").unwrap();
    let set = |word: &_| law.set(&Default::default(), word).unwrap().delay.law;
    let all = law.corners().into_iter().map(|word| set(&word));
    all.filter(|law| *law != LawName::SwitchingGain).collect()
}

fn stays_within<S: Scalar>(bound: impl Fn(LawName) -> Deviation) {
    let cases = laws()
        .into_iter()
        .flat_map(|law| SPEEDS_M_S.map(|speed| (law, speed)));
    let found = cases.map(|case| (case, deviation::<S>(&spring_rod(case.1, case.0))));
    let beyond: Vec<_> = found
        .filter(|((law, _), found)| !found.is_within(&bound(*law)))
        .collect();
    assert!(beyond.is_empty(), "{beyond:#?}");
}

/// A few least digits at 4 decimals of a millimetre: where one of them falls the other way in a cycle
/// of the contact, the rod pushes a little more, or less. Without such a cycle half a digit, with the
/// laws that multiply by at most 1337 what fixed point rounds at 2.3e-10. Polynomial and time series
/// take differences of neighbouring samples, smith and passivity add small products up over the
/// contact: there it is some more.
fn fixed_point(law: LawName) -> Deviation {
    let usual = Deviation {
        position_m: 5e-7,
        orientation_rad: 2e-6,
        velocity_m_s: 5e-7,
        velocity_rad_s: 2e-6,
        restitution: 3e-5,
    };
    let some_digits = Deviation {
        position_m: 1e-6,
        velocity_m_s: 5e-6,
        restitution: 6e-4,
        ..usual
    };
    match law {
        LawName::Polynomial | LawName::Ats | LawName::Smith => some_digits,
        LawName::SmithDeadZone | LawName::DesiredRestitution => at_an_edge(),
        LawName::Passivity => Deviation {
            position_m: 1e-5,
            orientation_rad: 3e-6,
            velocity_m_s: 2e-5,
            velocity_rad_s: 5e-6,
            restitution: 1e-3,
        },
        LawName::Predictor => Deviation {
            position_m: usual.position_m,
            ..six_axes_led()
        },
        _ => usual,
    }
}

/// Laws that do another thing below a force: a load at that edge falls otherwise by a rounding, for a cycle.
fn at_an_edge() -> Deviation {
    Deviation {
        position_m: 1e-5,
        orientation_rad: 3e-6,
        velocity_m_s: 1e-3,
        velocity_rad_s: 3e-4,
        restitution: 1e-3,
    }
}

/// The predictor leads all axes along a direction that it identifies: where the contact turns the spacecraft, a rounding
/// of the direction shows in single cycles' velocities, and in nothing that stays.
fn six_axes_led() -> Deviation {
    Deviation {
        position_m: 1e-7,
        orientation_rad: 2e-6,
        velocity_m_s: 2e-5,
        velocity_rad_s: 2e-4,
        restitution: 5e-6,
    }
}

/// f32 rounds at 6e-8 of a number: of a unit quaternion, and of a position of 0.1 m. The laws that
/// fit or decide (time series, Smith, passivity, predictor) show it in single cycles' velocities.
fn f32_rounding(law: LawName) -> Deviation {
    let usual = Deviation {
        position_m: 1e-7,
        orientation_rad: 2e-6,
        velocity_m_s: 1e-7,
        velocity_rad_s: 2e-6,
        restitution: 5e-6,
    };
    match law {
        LawName::SmithDeadZone | LawName::DesiredRestitution => at_an_edge(),
        LawName::Ats | LawName::Smith => Deviation {
            velocity_m_s: 5e-6,
            ..usual
        },
        // What it takes away adds up over the contact.
        LawName::Passivity => Deviation {
            position_m: 2e-6,
            velocity_m_s: 2e-5,
            velocity_rad_s: 5e-6,
            restitution: 2e-4,
            ..usual
        },
        LawName::Predictor => six_axes_led(),
        _ => usual,
    }
}

#[test]
fn fixed_point_deviates_by_no_more_than_stated() {
    stays_within::<Fixed>(fixed_point);
}

#[test]
fn f32_deviates_by_no_more_than_stated() {
    stays_within::<f32>(f32_rounding);
}
