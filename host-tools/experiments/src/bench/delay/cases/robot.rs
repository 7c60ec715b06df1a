//! Robots that are not what the board believes.

use super::super::case::{Case, PAUSE_S, Robot, belief};

pub(super) fn cases() -> Vec<Case> {
    let mut cases = delays();
    cases.extend(pauses());
    cases.extend(structures());
    let mut jitter = Case::new("jitter", "jitter_of_a_cycle").quick();
    jitter.robot.actuator.jitter = true;
    jitter.touches = 16;
    cases.push(jitter);
    cases.extend(perturbed());
    cases
}

/// Plants around the canonical one, with the latency known and as commissioning leaves it. Their worst and
/// their spread are the result, not the best of them.
fn perturbed() -> [Case; 2] {
    [("perturbed", true), ("perturbed_latency_unknown", false)].map(|(name, known)| {
        let mut case = Case::new("perturbed", name).quick();
        case.believed.feedback_latency_known = known;
        case.perturbed = true;
        case.touches = 48;
        case
    })
}

/// True delays other than the believed 32 ms.
fn delays() -> Vec<Case> {
    [24, 28, 30, 34, 36, 40, 48]
        .map(|ms| {
            let mut case = Case::new("true_delay", format!("true_delay_{ms}_ms"));
            case.robot.actuator.delay_s = f64::from(ms) * 1e-3;
            case.quick = ms == 28 || ms == 40;
            case
        })
        .into()
}

/// True pauses other than the believed 16 ms, and other pauses that the board knows.
fn pauses() -> Vec<Case> {
    let mut cases = Vec::new();
    for ms in [0, 8, 24, 32] {
        let pause_s = f64::from(ms) * 1e-3;
        let mut unknown = Case::new("true_pause", format!("true_pause_{ms}_ms"));
        unknown.robot.actuator.pause_s = pause_s;
        let mut known = Case::new("known_pause", format!("known_pause_{ms}_ms"));
        known.robot.actuator.pause_s = pause_s;
        known.believed.pause_s = pause_s;
        cases.extend([unknown, known]);
    }
    cases
}

/// Robots of another structure than believed; the pause is known. No law may refuse, except in the last case.
fn structures() -> Vec<Case> {
    let names = ["pure", "mixed", "lag", "servo_10_hz", "servo_5_hz"];
    let mut cases = Vec::new();
    for (truth, robot) in names.iter().zip(Robot::ALL) {
        for (wrong, other) in names.iter().zip(Robot::ALL) {
            if truth == wrong {
                continue;
            }
            let name = format!("{truth}_believed_{wrong}");
            let mut case = Case::new("wrong_structure", name).with_robot(robot);
            case.believed = belief(&other.actuator);
            case.believed.pause_s = PAUSE_S;
            case.interlock = false;
            case.quick = *truth == "pure" && *wrong == "lag";
            case.touches = 4;
            cases.push(case);
        }
    }
    let mut refused = Case::new("wrong_structure", "pure_believed_lag_with_interlock").quick();
    refused.believed = belief(&Robot::LAG.actuator);
    cases.push(refused);
    cases
}
