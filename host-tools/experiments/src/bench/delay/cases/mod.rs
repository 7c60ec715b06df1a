//! All cases. A new case is one more entry in a list here.

mod contact;
mod feedback;
mod robot;
mod space;

use super::case::{Case, Robot, SPEEDS_MM_S};
use softdock_delay_plants::Formulation;

/// All cases, the headline first.
pub fn all() -> Vec<Case> {
    let mut cases = headline();
    cases.extend(robot::cases());
    cases.extend(contact::cases());
    cases.extend(feedback::cases());
    cases.extend(space::cases());
    cases
}

/// The quick benchmark: fewer cases, fewer touches.
pub fn quick() -> Vec<Case> {
    let mut cases: Vec<Case> = all().into_iter().filter(|case| case.quick).collect();
    for case in &mut cases {
        case.touches = case.touches.min(4);
        case.speeds_mm_s.retain(|v| [1.0, 5.0, 15.0].contains(v));
    }
    cases
}

/// Five structures of the robot, eight speeds, everything known.
fn headline() -> Vec<Case> {
    let mut cases = Vec::new();
    for robot in Robot::ALL {
        let mut case = Case::new("headline", "headline").with_robot(robot).quick();
        case.speeds_mm_s = SPEEDS_MM_S.to_vec();
        cases.push(case);
    }
    cases.extend(Robot::ALL.map(again));
    cases
}

/// The case with a robot of the headline, simulated by the second formulation, which shares no equation with the first.
fn again(robot: Robot) -> Case {
    let mut case = Case::new("fixed_steps", "headline_in_fixed_steps").with_robot(robot);
    case.formulation = Formulation::FixedSteps;
    case
}
