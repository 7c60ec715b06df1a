//! Prediction, before a contact, of what a delay will do to it: whether the loop is stable, which rebound each law will give,
//! which results are physically impossible, and what to change.
//!
//! The contact is modelled as one mass on one wall along its normal. `loop_stability` is the linear theory, `limits` has the
//! limits of all laws, `bounce` simulates a contact with the board's own cycle and laws; `advice` puts the results into
//! words.

mod advice;
mod bounce;
mod limits;
mod loop_stability;
mod rig_file;
mod tables;

pub use crate::one_contact::Contact;
pub use limits::Limits;
pub use loop_stability::Critical;
pub use rig_file::{Rig, load_board};

use anyhow::{Context, Result};
use bounce::Bounces;
use serde::Serialize;
use softdock_app::settings::BoardSettings;
use softdock_control::delay::LawName;
use softdock_control::settings::Settings;

/// Restitution above 1 that still counts as passive: a right law varies by this with the instant of the touch within a cycle.
const SLACK: f64 = 0.015;

/// Result of the check.
#[derive(Clone, Debug, Serialize)]
pub struct Check {
    /// Longest delay with which the loop without compensation is stable in a lasting contact, s.
    pub critical_delay_s: f64,
    /// Largest stable stiffness at the rig's delay without compensation, N/m; None if no stiffness is small enough.
    pub critical_stiffness_n_per_m: Option<f64>,
    /// Smallest stable mass, kg; None if no mass is large enough.
    pub critical_mass_kg: Option<f64>,
    /// Smallest stable damping, N·s/m; None if no damping is enough.
    pub critical_damping_n_s_per_m: Option<f64>,
    /// Delay from the model's velocity to its execution, s.
    pub delay_s: f64,
    /// Mass that the contact feels, kg.
    pub effective_mass_kg: f64,
    /// Stiffness of the contact, N/m.
    pub stiffness_n_per_m: f64,
    /// Damping of the contact, N·s/m.
    pub damping_n_s_per_m: f64,
    /// Damping ratio of the contact.
    pub damping_ratio: f64,
    /// Smallest damping that one contact distinguishes from none at this noise of the force, N·s/m; None if the noise is not
    /// known.
    pub damping_in_noise_n_s_per_m: Option<f64>,
    /// Speed towards the wall, m/s.
    pub approach_speed_m_s: f64,
    /// Restitution of the contact itself.
    pub ideal_restitution: f64,
    /// Limits of all laws.
    pub limits: Limits,
    /// The law that the settings choose.
    pub chosen_law: &'static str,
    /// Results of all laws.
    pub laws: Vec<LawRow>,
    /// Advice in sentences, the most important first.
    pub advice: Vec<String>,
}

/// Result of one law.
#[derive(Clone, Debug, Serialize)]
pub struct LawRow {
    /// Name of the law.
    pub law: &'static str,
    /// Mean restitution over instants of the touch within a cycle; None if a contact does not end.
    pub expected_restitution: Option<f64>,
    /// Smallest and largest restitution over these instants.
    pub range: Option<(f64, f64)>,
    /// Whether the rebound is on average no faster than the approach and leads away from the wall, and no fault ends the
    /// test.
    pub stable: bool,
    /// Whether the robot has left the wall while the spacecraft of the model still flies towards it: the mean restitution is
    /// negative, and another contact will follow.
    pub flies_on: bool,
    /// Largest force over that of the contact itself, less 1.
    pub peak_force_error: f64,
    /// Time in contact over that of the contact itself, less 1; None if a contact does not end.
    pub contact_time_error: Option<f64>,
    /// Impulse on the model that was not measured, divided by 2 m v.
    pub impulse_unaccounted: f64,
    /// Whether the law works with the measured pose.
    pub needs_position: bool,
    /// The fault that ends the test.
    pub fault: Option<String>,
}

/// Checks a board against a rig.
///
/// # Errors
/// Settings or rig are out of their ranges, or the spacecraft do not approach the wall.
pub fn check(board: &BoardSettings, rig: &Rig) -> Result<Check> {
    board.validate().context("in the settings")?;
    let settings = &board.control;
    let cycle_s = settings.robot.cycle_s;
    let own_s = settings.delay.horizon_s(cycle_s) - settings.delay.actuator.mean_delay_s();
    let delay_s = rig.mean_delay_s() + own_s;
    let contact = rig.contact;
    let limits = Limits::new(&contact, delay_s, rig.actuator.pause_s, cycle_s);
    let critical = Critical::new(&contact, delay_s);
    let laws = LawName::ALL
        .into_iter()
        .map(|law| row(law, settings, rig))
        .collect::<Result<Vec<_>>>()?;
    let mut check = Check {
        critical_delay_s: contact.critical_delay_s(),
        critical_stiffness_n_per_m: critical.stiffness_n_per_m,
        critical_mass_kg: critical.mass_kg,
        critical_damping_n_s_per_m: critical.damping_n_s_per_m,
        delay_s,
        effective_mass_kg: contact.mass_kg,
        stiffness_n_per_m: contact.stiffness_n_per_m,
        damping_n_s_per_m: contact.damping_n_s_per_m,
        damping_ratio: contact.damping_ratio(),
        damping_in_noise_n_s_per_m: rig.damping_in_noise(cycle_s),
        approach_speed_m_s: rig.approach_speed_m_s,
        ideal_restitution: contact.restitution(),
        limits,
        chosen_law: settings.delay.law.name(),
        laws,
        advice: Vec::new(),
    };
    check.advice = advice::of(&check, settings, rig);
    Ok(check)
}

impl Check {
    /// The row of the law that the settings choose.
    pub fn chosen(&self) -> Option<&LawRow> {
        self.laws.iter().find(|row| row.law == self.chosen_law)
    }
}

fn row(law: LawName, settings: &Settings, rig: &Rig) -> Result<LawRow> {
    let bounces = Bounces::new(law, settings, rig)?;
    let range = bounces.range();
    // Over many contacts the touch falls anywhere in a cycle, so the mean decides. A restitution of zero is that of a wall
    // that absorbs all energy.
    let passive = bounces.mean().is_some_and(|mean| mean <= 1.0 + SLACK);
    let flies_on = bounces.mean().is_some_and(|mean| mean < -SLACK);
    let fault = bounces.fault().map(|fault| {
        let (expected, received) = (fault.expected, fault.received);
        format!(
            "{}: allowed {expected:.4}, received {received:.4}",
            fault.code
        )
    });
    Ok(LawRow {
        law: law.name(),
        expected_restitution: bounces.mean(),
        range,
        stable: passive && !flies_on && fault.is_none(),
        flies_on,
        peak_force_error: bounces.peak_force_error(&rig.contact, rig.approach_speed_m_s),
        contact_time_error: bounces.contact_time_error(&rig.contact),
        impulse_unaccounted: bounces.impulse_unaccounted(),
        needs_position: law.needs_position(),
        fault,
    })
}
