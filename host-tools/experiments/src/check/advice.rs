//! Advice on what to change, in sentences.

use super::limits::LARGEST_PHI;
use super::rig_file::Rig;
use super::{Check, LawRow, SLACK};
use crate::one_contact::Contact;
use softdock_control::delay::LawName;
use softdock_control::settings::Settings;

/// Difference between believed and true delay from which on it is reported, s: a quarter of a cycle of 4 ms.
const DELAY_MATTERS_S: f64 = 0.001;
/// Largest deviation of the restitution from the contact's own that counts as right.
const RIGHT: f64 = 0.02;
/// Largest relative error of force or time in contact, and largest impulse that was not measured, with which a right rebound
/// is not called accidental.
const FORCE_MATTERS: f64 = 0.25;
const IMPULSE_MATTERS: f64 = 0.25;

/// All advice, the weightiest first.
pub(super) fn of(check: &Check, settings: &Settings, rig: &Rig) -> Vec<String> {
    let mut advice = physics(check);
    advice.extend(beliefs(check.delay_s, settings, rig));
    advice.extend(law(check));
    advice.extend(speed(settings, rig));
    advice.extend(hidden(check, rig));
    advice
}

/// A remark on the damping that noise may hide from the predictor.
fn hidden(check: &Check, rig: &Rig) -> Option<String> {
    let unseen = Contact {
        damping_n_s_per_m: check.damping_in_noise_n_s_per_m?,
        ..rig.contact
    };
    let noise_n = rig.noise_force_n.filter(|noise_n| *noise_n > 0.0)?;
    (rig.contact.damping_n_s_per_m < unseen.damping_n_s_per_m).then(|| {
        format!(
            "Behind {noise_n} N of noise one contact at {} mm/s does not show a damping below {:.2} N·s/m (ζ = {:.2e}, rebound \
             {:.4}): a contact that passes for undamped may have that much.",
            1e3 * rig.approach_speed_m_s,
            unseen.damping_n_s_per_m,
            unseen.damping_ratio(),
            unseen.restitution()
        )
    })
}

/// Advice on physical limits, which no setting overcomes.
fn physics(check: &Check) -> Vec<String> {
    let (limits, mut advice) = (&check.limits, Vec::new());
    let softer = check.effective_mass_kg * (LARGEST_PHI / check.delay_s.max(1e-9)).powi(2);
    if !limits.feasible {
        advice.push(format!(
            "No law can give the restitution of {:.3} on a first contact: at least {:.3} is left when the \
             robot has answered. Soften the contact, raise the mass, or make the robot faster.",
            check.ideal_restitution, limits.least_restitution
        ));
    } else if !limits.feasible_at_approach_speed {
        advice.push(format!(
            "The delay is {:.2} of the contact's phase, beyond √2: the robot must retreat faster than it \
             came. Soften the contact below {softer:.0} N/m, or raise the mass.",
            limits.phi
        ));
    }
    if limits.peak_force_ratio > 1.05 {
        advice.push(format!(
            "Expect a first contact to push at least {:.0} % harder than the ideal one.",
            1e2 * (limits.peak_force_ratio - 1.0)
        ));
    }
    advice
}

/// Advice on settings of the robot that differ from the rig.
fn beliefs(delay_s: f64, settings: &Settings, rig: &Rig) -> Vec<String> {
    let (believed, mut advice) = (&settings.delay.actuator, Vec::new());
    let believed_s = settings.delay.horizon_s(settings.robot.cycle_s);
    if (believed_s - delay_s).abs() > DELAY_MATTERS_S {
        advice.push(format!(
            "The settings believe in a loop delay of {:.2} ms; with this robot it is {:.2} ms, of which {:.2} ms are the \
             robot's. Set `delay.actuator`: delay_s = {}, lag_s = {}.",
            1e3 * believed_s,
            1e3 * delay_s,
            1e3 * rig.mean_delay_s(),
            rig.actuator.delay_s,
            rig.actuator.lag_s
        ));
    }
    let (is, wanted) = (
        believed.feedback_latency_cycles,
        rig.feedback_latency_cycles,
    );
    if is != wanted {
        advice.push(format!(
            "The reported pose is {wanted} cycles older than the force; the settings say {is}. Set \
             `delay.actuator.feedback_latency_cycles` = {wanted}: this error looks like damping or energy."
        ));
    }
    advice
}

/// Advice on the chosen law, and on better ones.
fn law(check: &Check) -> Vec<String> {
    let Some(chosen) = check.chosen() else {
        return Vec::new();
    };
    let told = |row: &&LawRow| row.fault.is_some() || row.law == chosen.law;
    let mut advice: Vec<String> = check.laws.iter().filter(told).filter_map(fails).collect();
    if chosen.law == LawName::Seed.name() && chosen.stable {
        advice.push(
            "Law `seed` keeps its sums: over repeated bounces it runs away, whatever one bounce says."
                .into(),
        );
    }
    advice.extend(hollow(chosen));
    let off = |row: &LawRow| {
        let e = row.expected_restitution.unwrap_or(f64::INFINITY);
        (e - check.ideal_restitution).abs()
    };
    let better = check
        .laws
        .iter()
        .filter(|row| row.stable && hollow(row).is_none())
        .min_by(|a, b| off(a).total_cmp(&off(b)));
    match better {
        Some(row) if off(chosen) > RIGHT && off(row) < 0.5 * off(chosen) => {
            let position = if row.needs_position {
                "; it needs position feedback"
            } else {
                ""
            };
            advice.push(format!(
                "Law `{}` would give {:.3} of {:.3}{position}.",
                row.law,
                row.expected_restitution.unwrap_or_default(),
                check.ideal_restitution
            ));
        }
        None => advice.push(without_a_law(check)),
        Some(_) => {}
    }
    advice
}

/// Why a law is not stable; None if it is.
fn fails(row: &LawRow) -> Option<String> {
    let law = row.law;
    if let Some(fault) = &row.fault {
        return Some(format!(
            "With law `{law}` the test ends in a fault: {fault}."
        ));
    }
    if row.flies_on {
        return Some(format!(
            "With law `{law}` the robot leaves the wall before the spacecraft has turned: the restitution is \
             negative, and it touches again and again. The law leads too much for this contact, or the \
             delay is believed too long."
        ));
    }
    (!row.stable)
        .then(|| format!("Law `{law}` adds energy: do not close the loop with it on this contact."))
}

/// A remark on a law whose rebound is right although force or time in contact are not.
fn hollow(row: &LawRow) -> Option<String> {
    let long = row
        .contact_time_error
        .is_none_or(|error| error.abs() > FORCE_MATTERS);
    if !row.stable || !(long || row.impulse_unaccounted.abs() > IMPULSE_MATTERS) {
        return None;
    }
    Some(format!(
        "Law `{}` reaches its rebound by an impulse that is not measured ({:.2} of the bounce): force and \
         duration of the contact are not those of the test.",
        row.law, row.impulse_unaccounted
    ))
}

fn without_a_law(check: &Check) -> String {
    let mut text = format!(
        "No law is right here (within {SLACK} of a passive rebound, and by measured force). Soften the \
         contact, raise the mass, or make the robot faster."
    );
    if let Some(b) = check.critical_damping_n_s_per_m {
        text += &format!(" Without compensation {b:.0} N·s/m of damping make the loop stable.");
    }
    text
}

/// Advice if the contact itself exceeds limits of the board.
fn speed(settings: &Settings, rig: &Rig) -> Option<String> {
    let peak_n = rig.contact.peak_force_n(rig.approach_speed_m_s);
    (peak_n > 0.8 * settings.limits.force_n).then(|| {
        format!(
            "The contact itself reaches {peak_n:.0} N and `limits.force_n` is {}: approach more slowly, or \
             allow more.",
            settings.limits.force_n
        )
    })
}
