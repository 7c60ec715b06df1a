//! The headline: five structures of the robot, eight speeds, everything known.

use super::super::case::{Case, Robot, SPEEDS_MM_S};
use softdock_delay_plants::Formulation;

pub(super) fn cases() -> Vec<Case> {
    let mut cases = Vec::new();
    for robot in Robot::ALL {
        let mut case = Case::new("headline", "headline").with_robot(robot).quick();
        case.speeds_mm_s = SPEEDS_MM_S.to_vec();
        cases.push(case);
    }
    cases.extend(Robot::ALL.map(again));
    cases
}

/// The same robots in the second formulation, which shares no equation with the first.
fn again(robot: Robot) -> Case {
    let mut case = Case::new("fixed_steps", "headline_in_fixed_steps").with_robot(robot);
    case.formulation = Formulation::FixedSteps;
    case
}
