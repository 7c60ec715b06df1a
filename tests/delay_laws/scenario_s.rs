//! Scenario S (32 ms late, 16 ms of standstill at reversal, 21 rad/s), 1 to 15 mm/s, the onset at
//! four phases within a cycle.

use super::case::{Case, Rebound};
use softdock_control::delay::{LawName, ModelVelocity};
use softdock_delay_plants::{Actuator, Dynamics};

const SPEEDS_MM_S: [f64; 8] = [1.0, 2.0, 3.0, 5.0, 8.0, 10.0, 12.0, 15.0];

/// Worst numbers of many bounces.
struct Worst {
    restitution: (f64, f64),
    peak_force: f64,
    contact_time: f64,
    unaccounted: f64,
}

impl Worst {
    fn of(rebounds: &[Rebound]) -> Self {
        let largest = |of: fn(&Rebound) -> f64| {
            let sizes = rebounds.iter().map(|r| of(r).abs());
            sizes.fold(0.0, f64::max)
        };
        let e = || rebounds.iter().map(|r| r.restitution);
        Self {
            restitution: (e().fold(9.0, f64::min), e().fold(-9.0, f64::max)),
            peak_force: largest(|r| r.peak_force_error),
            contact_time: largest(|r| r.contact_time_error),
            unaccounted: largest(|r| r.impulse_unaccounted),
        }
    }

    /// Largest deviation of the restitution from 1.
    fn error(&self) -> f64 {
        let (low, high) = self.restitution;
        (1.0 - low).max(high - 1.0)
    }

    fn show(&self, name: &str) {
        let (low, high) = self.restitution;
        println!(
            "{name:24} e {low:.3} to {high:.3}, peak force {:.1} %, contact time {:.1} %, impulse not measured {:.3}",
            1e2 * self.peak_force,
            1e2 * self.contact_time,
            self.unaccounted
        );
    }
}

fn worst(name: &str, case: &Case) -> Worst {
    let worst = Worst::of(&case.bounces(&SPEEDS_MM_S));
    worst.show(name);
    worst
}

fn lag(law: LawName, delay_s: f64, time_constant_s: f64) -> Case {
    let mut case = Case::scenario_s(law);
    case.plant.actuator = Actuator {
        delay_s,
        dynamics: Dynamics::Lag { time_constant_s },
        ..case.plant.actuator
    };
    case.settings.delay.actuator.delay_s = delay_s;
    case.settings.delay.actuator.lag_s = time_constant_s;
    case
}

/// Known: within 1.9 % (1.3 % in peak force); within 7.6 % if the robot is a lag of 32 ms.
#[test]
fn lead() {
    let lead = worst("lead", &Case::scenario_s(LawName::Lead));
    assert!(lead.error() < 0.019, "{}", lead.error());
    assert!(lead.peak_force < 0.04);
    assert_eq!(lead.unaccounted, 0.0);
    let mix = worst("lead, 16 + lag 16 ms", &lag(LawName::Lead, 0.016, 0.016));
    assert!(mix.error() < 0.035);
    let lag = worst("lead, lag 32 ms", &lag(LawName::Lead, 0.0, 0.032));
    assert!((0.06..0.09).contains(&lag.error()));
}

/// Known: 1.005 at one phase of the onset, and called luck there. The mean velocity is half a
/// cycle late, which the law makes up for and the known number did not: with 2 ms less the number
/// comes back, without it the law brakes too much.
#[test]
fn polynomial() {
    let mut case = Case::scenario_s(LawName::Polynomial);
    let cubic = worst("polynomial", &case);
    assert!((0.03..0.1).contains(&cubic.error()), "{}", cubic.error());
    assert!((0.15..0.22).contains(&cubic.peak_force));
    case.settings.delay.polynomial.extra_s = -0.002;
    let known = worst("polynomial, 2 ms less", &case);
    assert!(known.error() < 0.03, "{}", known.error());
    case.settings.delay.polynomial.order = 2;
    let square = worst("polynomial 2, 2 ms less", &case);
    assert!((0.15..0.3).contains(&square.error()));
}

/// Known: within 10 %, between 0.88 and 1.4 by the prior. Here the prior is the true delay and the
/// ridge keeps it where the approach tells nothing.
#[test]
fn ats() {
    let ats = worst("ats", &Case::scenario_s(LawName::Ats));
    assert!(ats.error() < 0.025, "{}", ats.error());
    let mix = worst("ats, 16 + lag 16 ms", &lag(LawName::Ats, 0.016, 0.016));
    assert!(mix.error() < 0.03);
    let lag = worst("ats, lag 32 ms", &lag(LawName::Ats, 0.0, 0.032));
    assert!(lag.error() < 0.09);
}

/// Known: 0.0 %, peak force 13 %, impulse not measured 0.09.
#[test]
fn smith() {
    let smith = worst("smith", &Case::scenario_s(LawName::Smith));
    assert!(smith.error() < 0.002, "{}", smith.error());
    assert!(smith.peak_force < 0.1 && smith.contact_time < 0.02);
    assert!((0.03..0.13).contains(&smith.unaccounted));
    let lag = worst("smith, lag 32 ms", &lag(LawName::Smith, 0.0, 0.032));
    assert!(lag.error() < 0.002);
}

/// Known: 0.3 %, peak force 56 %, contact time 106 %, impulse not measured 2.1: a rebound that is
/// right for the wrong reason.
#[test]
fn passivity() {
    let passivity = worst("passivity", &Case::scenario_s(LawName::Passivity));
    assert!(passivity.error() < 0.005, "{}", passivity.error());
    assert!((0.5..0.6).contains(&passivity.peak_force));
    assert!((0.9..1.2).contains(&passivity.contact_time));
    assert!((1.8..2.4).contains(&passivity.unaccounted));
}

/// A dead zone of 1 N takes a tenth of the force at 1 mm/s: most of that the observer gives back.
#[test]
fn smith_dead_zone() {
    let mut case = Case::scenario_s(LawName::SmithDeadZone);
    let observed = worst("smith behind a dead zone", &case);
    assert!(observed.error() < 0.03, "{}", observed.error());
    case.settings.delay.smith_dead_zone.dead_zone_n = 0.0;
    let without = worst("smith behind none", &case);
    assert!(without.error() < 0.002, "{}", without.error());
}

/// Known of a virtual damping of k τ: 0.5 %, peak force 32 %, impulse not measured 0.52.
#[test]
fn desired_restitution() {
    let mut case = Case::scenario_s(LawName::DesiredRestitution);
    case.settings.delay.desired_restitution.stiffness_n_per_m = 220_500.0;
    let elastic = worst("desired restitution 1", &case);
    assert!(elastic.error() < 0.15, "{}", elastic.error());
    assert!((0.2..0.4).contains(&elastic.peak_force));
    assert!(elastic.unaccounted > 0.3);
    case.settings.delay.desired_restitution.restitution = 0.5;
    let (low, high) = worst("desired restitution 0.5", &case).restitution;
    assert!(low > 0.4 && high < 0.65, "{low} {high}");
}

/// Known of a force lead with a fixed gain: 48 %. With the gain by energy it is hardly better here.
#[test]
fn switching_gain() {
    let mut case = Case::scenario_s(LawName::SwitchingGain);
    let (low, high) = worst("switching gain", &case).restitution;
    assert!(low > 1.3 && high < 1.9, "{low} {high}");
    case.settings.delay.switching_gain.gain_by_energy = 0.0;
    let fixed = worst("fixed gain", &case);
    assert!(fixed.restitution.1 > low, "{low}");
}

/// The half cycle of the mean velocity is part of the horizon: without it nothing changes much.
#[test]
fn end_velocity() {
    for law in [LawName::Lead, LawName::Ats, LawName::Smith] {
        let mut case = Case::scenario_s(law);
        case.settings.delay.model_velocity = ModelVelocity::End;
        let worst = Worst::of(&case.bounces(&[5.0]));
        worst.show(law.name());
        assert!(worst.error() < 0.025, "{law:?}: {}", worst.error());
    }
}
