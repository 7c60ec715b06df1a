//! Evaluation of one run.

use super::case::Case;
use super::ideal::{Ideal, Motion, energy, rebound_sign, restitution};
use super::scene::End;
use super::trial::{Moment, Trial};
use nalgebra::Vector3;
use serde::Serialize;
use softdock_delay_plants::{Log, RobotPose};

/// Contacts closer than this are one impact, s: a late robot may leave the wall for a moment.
const SAME_IMPACT_S: f64 = 0.03;
/// Time after the release in which a law may still correct the rebound, s.
const SETTLE_S: f64 = 0.08;
/// Numbers are clipped here; a run with a larger one counts as run away.
const LARGEST: f64 = 99.0;
/// Time after the ideal contact over which positions are still compared, s.
const AFTER_CONTACT_S: f64 = 0.04;
/// Lever that converts an angular velocity error to a linear one, m.
const ARM_M: f64 = 0.3;

/// How a run ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Ending {
    /// As intended.
    Ended,
    /// The contact was never released.
    Stuck,
    /// The board latched a fault before anything was touched.
    Refused,
    /// Nothing was touched.
    NoContact,
    /// Fewer impacts than there should be.
    ImpactsMissing,
    /// A fault, or numbers beyond `LARGEST`.
    RanAway,
}

/// The numbers of one run; all finite.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Numbers {
    /// Speed of the model after over speed before.
    pub restitution: f64,
    /// Restitution of the probe on the robot, by the executed motion; None where the normal changes.
    pub robot_restitution: Option<f64>,
    /// Kinetic energy after over energy before, less the ideal ratio.
    pub energy_error: f64,
    /// Largest true force over the ideal one, less 1.
    pub peak_force_error: f64,
    /// True time in contact over the ideal one, less 1.
    pub contact_time_error: f64,
    /// (∫ F dt of the measured force − m Δv of the model) / (2 m v0), along the approach.
    pub impulse_unaccounted: f64,
    /// Largest error of a spacecraft's velocity, over the speed of approach; rotations at 0.3 m.
    pub velocity_error: f64,
    /// Error of the executed position over contact and 40 ms: its RMS over the ideal RMS, and its largest value over v0/ω.
    /// None unless the bounce has a closed form.
    pub tracking: Option<(f64, f64)>,
    /// Largest command over the speed of approach.
    pub command_peak: f64,
    /// How it ended.
    pub ending: Ending,
}

/// An impact: contacts separated by less than [`SAME_IMPACT_S`].
#[derive(Clone, Copy, Debug)]
struct Impact {
    touch_s: f64,
    release_s: Option<f64>,
    with_force_s: f64,
    peak_force_n: f64,
}

/// Evaluates a run against the ideal test.
pub fn measure(case: &Case, speed_m_s: f64, ideal: &Ideal, trial: &Trial) -> Numbers {
    let impacts = impacts(&trial.log);
    let (Some(first), Some(begin)) = (impacts.first(), trial.moments.first()) else {
        let refused = trial.fault.is_some();
        let ending = if refused {
            Ending::Refused
        } else {
            Ending::NoContact
        };
        return nothing(ideal, ending);
    };
    let count = match case.scene.end {
        End::Impacts(n) => n,
        End::After(_) => usize::MAX,
    };
    let counted = &impacts[..count.min(impacts.len())];
    let to_s = settled_s(case, counted, impacts.get(counted.len()));
    let before = last_before(&trial.moments, first.touch_s).unwrap_or(begin);
    let after = last_before(&trial.moments, to_s).unwrap_or(begin);
    let (start, end) = (motion(before), motion(after));
    let e = restitution(case, counted.len(), &start, &end);
    let with_force_s: f64 = counted.iter().map(|i| i.with_force_s).sum();
    let peak_force_n = counted.iter().map(|i| i.peak_force_n).fold(0.0, f64::max);
    let numbers = Numbers {
        restitution: e,
        robot_restitution: robot_restitution(case, counted.len(), trial, [first.touch_s, to_s]),
        energy_error: energy(case, &end) / energy(case, &start) - ideal.energy,
        peak_force_error: peak_force_n / ideal.peak_force_n - 1.0,
        contact_time_error: with_force_s / ideal.contact_s - 1.0,
        impulse_unaccounted: unaccounted(case, speed_m_s, trial, [before, after]),
        velocity_error: velocity_error(ideal, &end) / speed_m_s,
        tracking: tracking(case, speed_m_s, ideal, trial),
        command_peak: command_peak(trial) / speed_m_s,
        ending: ending(case, trial, &impacts, count),
    };
    bounded(numbers)
}

/// The numbers of a run without a contact.
fn nothing(ideal: &Ideal, ending: Ending) -> Numbers {
    Numbers {
        restitution: 0.0,
        robot_restitution: None,
        energy_error: -ideal.energy,
        peak_force_error: -1.0,
        contact_time_error: -1.0,
        impulse_unaccounted: 0.0,
        velocity_error: 1.0,
        tracking: None,
        command_peak: 1.0,
        ending,
    }
}

fn impacts(log: &Log) -> Vec<Impact> {
    let mut impacts: Vec<Impact> = Vec::new();
    let end_s = log.moments.last().map_or(0.0, |moment| moment.time_s);
    for contact in &log.contacts {
        let with_force_s = contact.release_s.unwrap_or(end_s) - contact.touch_s;
        if let Some(last) = impacts.last_mut()
            && last
                .release_s
                .is_some_and(|r| contact.touch_s - r < SAME_IMPACT_S)
        {
            last.release_s = contact.release_s;
            last.with_force_s += with_force_s;
            last.peak_force_n = last.peak_force_n.max(contact.peak_force_n);
        } else {
            impacts.push(Impact {
                touch_s: contact.touch_s,
                release_s: contact.release_s,
                with_force_s,
                peak_force_n: contact.peak_force_n,
            });
        }
    }
    impacts
}

/// Time at which the model's velocity after the test is read, s.
fn settled_s(case: &Case, counted: &[Impact], next: Option<&Impact>) -> f64 {
    let last = counted.last().and_then(|i| i.release_s);
    match (case.scene.end, last) {
        (End::Impacts(_), Some(release_s)) => {
            let next_s = next.map_or(f64::INFINITY, |next| next.touch_s);
            (release_s + SETTLE_S).min(next_s)
        }
        _ => f64::INFINITY,
    }
}

fn last_before(moments: &[Moment], time_s: f64) -> Option<&Moment> {
    moments.iter().take_while(|m| m.time_s < time_s).last()
}

/// Restitution of the probe by the executed velocity along the normal, signed as [`restitution`]. None where the normal
/// changes.
fn robot_restitution(
    case: &Case,
    impacts: usize,
    trial: &Trial,
    [touch_s, to_s]: [f64; 2],
) -> Option<f64> {
    let normal = Vector3::from(case.scene.normal()?);
    let probe = Vector3::from(case.scene.probe);
    let along = |before_s: f64| {
        let moments = trial.log.moments.iter();
        let last = moments.take_while(|m| m.time_s < before_s).last()?;
        let pose = RobotPose::new(&last.position, &last.velocity);
        Some(pose.point(&probe).1.dot(&normal))
    };
    Some(rebound_sign(case, impacts) * along(to_s)? / along(touch_s)?)
}

fn motion(moment: &Moment) -> Motion {
    [moment.k, moment.q]
}

fn unaccounted(case: &Case, speed_m_s: f64, trial: &Trial, [before, after]: [&Moment; 2]) -> f64 {
    let direction = Vector3::from(case.scene.direction);
    let felt = trial
        .moments
        .windows(2)
        .filter(|pair| pair[1].time_s > before.time_s && pair[1].time_s <= after.time_s)
        .map(|pair| pair[1].force.dot(&direction) * (pair[1].time_s - pair[0].time_s))
        .sum::<f64>();
    let gained = case.scene.mass_kg * (after.k[0] - before.k[0]).dot(&direction);
    (felt - gained) / (2.0 * case.scene.mass_kg * speed_m_s)
}

fn velocity_error(ideal: &Ideal, end: &Motion) -> f64 {
    let apart = |a: &[Vector3<f64>; 2], b: &[Vector3<f64>; 2]| {
        (a[0] - b[0]).norm().hypot(ARM_M * (a[1] - b[1]).norm())
    };
    apart(&end[0], &ideal.after[0]).max(apart(&end[1], &ideal.after[1]))
}

/// Position error from the robot's own touch on, over the ideal contact and [`AFTER_CONTACT_S`]: normalised RMS, and
/// normalised peak.
fn tracking(case: &Case, speed_m_s: f64, ideal: &Ideal, trial: &Trial) -> Option<(f64, f64)> {
    let bounce = ideal.bounce?;
    let touch_s = trial.log.contacts.first()?.touch_s;
    let window = touch_s..=touch_s + bounce.contact_s + AFTER_CONTACT_S;
    let (mut apart, mut size, mut largest) = (0.0, 0.0, 0.0_f64);
    for moment in &trial.log.moments {
        if !window.contains(&moment.time_s) {
            continue;
        }
        let known = bounce.displacement_m(moment.time_s - touch_s);
        let error = moment.position[0] - trial.distance_m - known;
        apart += error * error;
        size += known * known;
        largest = largest.max(error.abs());
    }
    let amplitude = speed_m_s / case.scene.omega();
    (size > 0.0).then(|| ((apart / size).sqrt(), largest / amplitude))
}

fn command_peak(trial: &Trial) -> f64 {
    let speeds = trial.moments.iter().map(|m| m.sent.norm());
    speeds.fold(0.0, f64::max)
}

fn ending(case: &Case, trial: &Trial, impacts: &[Impact], count: usize) -> Ending {
    let open = impacts.last().is_some_and(|i| i.release_s.is_none());
    let all_there = matches!(case.scene.end, End::After(_)) || impacts.len() >= count;
    match (trial.fault.is_some(), all_there) {
        (true, _) => Ending::RanAway,
        (_, false) => Ending::ImpactsMissing,
        _ if open && impacts.len() <= count => Ending::Stuck,
        _ => Ending::Ended,
    }
}

/// Clips the numbers to [`LARGEST`]; if one was clipped, the ending becomes [`Ending::RanAway`].
fn bounded(mut numbers: Numbers) -> Numbers {
    let (nrms, peak) = numbers.tracking.unwrap_or((0.0, 0.0));
    let mut tracking = [nrms, peak];
    let [nrms, peak] = &mut tracking;
    let mut away = false;
    for number in [
        &mut numbers.restitution,
        &mut numbers.energy_error,
        &mut numbers.peak_force_error,
        &mut numbers.contact_time_error,
        &mut numbers.impulse_unaccounted,
        &mut numbers.velocity_error,
        &mut numbers.command_peak,
        nrms,
        peak,
    ] {
        away |= number.is_nan() || number.abs() > LARGEST;
        *number = if number.is_nan() {
            LARGEST
        } else {
            number.clamp(-LARGEST, LARGEST)
        };
    }
    numbers.tracking = numbers.tracking.map(|_| (tracking[0], tracking[1]));
    let stuck = numbers.ending == Ending::Stuck;
    if away && !stuck {
        numbers.ending = Ending::RanAway;
    }
    numbers
}
