//! Contacts with one of 37 faults at a random time: a board's link and cycle with an independent plant, for every law. Also
//! long runs of bouncing with random faults.
//!
//! The board is anything that accepts datagrams ([`Board`]): the session on the host, or machine code in QEMU.
#![allow(clippy::unwrap_used, reason = "a helper of a test fails the test")]

mod faults;
mod judge;
mod line;
mod soak;
mod tape;

pub use soak::soak_law;

use crate::lockstep::Board;
use faults::{FAULTS, Moment};
use judge::Judge;
use line::{Answered, Cycle, Line};
use proptest::prelude::{Strategy, any};
use proptest::strategy::ValueTree;
use proptest::test_runner::{Config, RngSeed, TestRunner};
use softdock_app::settings::BoardSettings;
use softdock_control::delay::LawName;
use softdock_control::modes::Command;
use softdock_delay_plants::{Actuator, Contact, Measurement, Plant, PlantSettings, Wall};

/// Kinds of faults.
pub const KINDS: usize = FAULTS.len();

/// Makes a board with these settings.
pub type MakeBoard<'a> = &'a mut dyn FnMut(&BoardSettings) -> Box<dyn Board>;

const CYCLE_S: f64 = 0.004;
/// Longest wait for the contact, cycles.
const APPROACH: usize = 400;
/// Healthy cycles after the fault.
const AFTER: usize = 60;

/// A contact and the time of its fault.
#[derive(Clone, Debug)]
struct Case {
    law: LawName,
    guard: bool,
    mass_kg: f64,
    speed_m_s: f64,
    /// Natural frequency of mass and wall, rad/s.
    omega: f64,
    delay_s: f64,
    pause_s: f64,
    tilt: f64,
    /// Distance of the contact from the axis through the centre of mass, m: the body turns.
    lever_m: f64,
    /// Cycles from the contact to the fault.
    at: usize,
    /// Duration of the fault, cycles.
    lasts: usize,
    seed: u64,
}

fn case() -> impl Strategy<Value = Case> {
    let law = (0..LawName::ALL.len(), any::<bool>());
    let craft = (100.0..2000.0, 0.002..0.015);
    let rig = (10.0..30.0, 0.008..0.048, 0.0..0.02, -0.5..0.5, -0.1..0.1);
    (law, craft, rig, (0usize..90, 1usize..60), any::<u64>()).prop_map(
        |(
            (law, guard),
            (mass_kg, speed_m_s),
            (omega, delay_s, pause_s, tilt, lever_m),
            (at, lasts),
            seed,
        )| Case {
            law: LawName::ALL[law],
            guard,
            mass_kg,
            speed_m_s,
            omega,
            delay_s,
            pause_s,
            tilt,
            lever_m,
            at,
            lasts,
            seed,
        },
    )
}

impl Case {
    fn settings(&self) -> BoardSettings {
        let mut settings = BoardSettings::default();
        settings.rsi.robot_ip = "192.168.1.10".try_into().unwrap();
        let control = &mut settings.control;
        control.body_k.mass_kg = self.mass_kg;
        control.body_k.velocity_m_s = [self.speed_m_s, 0.0, 0.0];
        control.body_q.fixed = true;
        control.delay.law = self.law;
        control.delay.passivity_guard = self.guard;
        control.delay.actuator.delay_s = self.delay_s;
        control.delay.actuator.pause_s = self.pause_s;
        settings
    }

    /// Stiffness of the wall, N/m.
    fn stiffness(&self) -> f64 {
        self.omega * self.omega * self.mass_kg
    }

    fn plant(&self) -> Plant {
        let normal = [-self.tilt.cos(), self.tilt.sin(), 0.0];
        Plant::new(&PlantSettings {
            actuator: Actuator {
                delay_s: self.delay_s,
                pause_s: self.pause_s,
                ..Actuator::ideal()
            },
            contact: Contact {
                probes: vec![[0.0, self.lever_m, 0.0]],
                surfaces: vec![
                    Wall::elastic([2e-3, self.lever_m, 0.0], normal, self.stiffness()).into(),
                ],
            },
            measurement: Measurement {
                force_noise_n: 0.05,
                torque_noise_n_m: 0.005,
                ..Measurement::default()
            },
            seed: self.seed,
            ..PlantSettings::default()
        })
    }

    /// Runs the case with a fault of the table; returns the largest energy of a guarded model, divided by that before the
    /// contact.
    fn run(&self, spoil: usize, make: MakeBoard<'_>) -> f64 {
        let (settings, mut plant) = (self.settings(), self.plant());
        let mut line = Line::new(&settings, make(&settings));
        let mut judge = Judge::new(&settings, self.stiffness());
        let start = [Command::Hold, Command::Arm, Command::Start];
        let mut sample = plant.first_sample();
        let mut touch = None;
        let mut any = self.seed;
        for n in 0..APPROACH + self.at + self.lasts + AFTER {
            if touch.is_none() && n > 40 && sample.wrench[0].abs() > 1.0 {
                touch = Some(n);
            }
            let since = touch.and_then(|touch| n.checked_sub(touch + self.at));
            let mut cycle = Cycle::new(sample.wrench, sample.position);
            cycle.command = start.get(n).copied();
            let fault = since.filter(|since| *since < self.lasts);
            let reading = cycle.sample.unwrap_or_default();
            line.remember(reading, fault.is_none());
            any = any
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            if let Some(since) = fault {
                let moment = Moment {
                    since,
                    any: any >> 33,
                };
                FAULTS[spoil].1(&mut cycle, &mut line, moment);
            }
            let answered = line.run(&cycle);
            judge.check(&cycle, &answered);
            sample = plant.step(velocity(
                &answered,
                settings.control.robot.correction_decimals,
            ));
            if since.is_some_and(|since| since > self.lasts + AFTER) {
                break;
            }
        }
        assert!(touch.is_some(), "no contact");
        judge.end(&mut line, &sample);
        judge.most_energy
    }
}

/// The robot's velocity after an answer; zero without one.
fn velocity(answered: &Answered, decimals: u8) -> [f64; 6] {
    let digit = 0.1_f64.powi(decimals.into()) / CYCLE_S;
    let counts = answered.correction.unwrap_or_default();
    core::array::from_fn(|i| {
        let unit = if i < 3 {
            digit * 1e-3
        } else {
            digit.to_radians()
        };
        counts[i] as f64 * unit
    })
}

/// Runs every `step`-th case from `first` up to `count`, with the faults in turn. Returns the largest energy of a guarded
/// model, divided by that before the contact.
///
/// # Panics
/// If a check fails; the case is printed.
pub fn run_cases(first: usize, step: usize, count: usize, make: MakeBoard<'_>) -> f64 {
    let seed = RngSeed::Fixed(17 + first as u64);
    let mut runner = TestRunner::new(Config {
        rng_seed: seed,
        ..Config::default()
    });
    let mut most = 0.0_f64;
    for n in (first..count).step_by(step) {
        let spoil = n % FAULTS.len();
        let case = case().new_tree(&mut runner).unwrap().current();
        let run = std::panic::AssertUnwindSafe(|| case.run(spoil, make));
        match std::panic::catch_unwind(run) {
            Ok(energy) => most = most.max(energy),
            Err(panic) => {
                eprintln!("run {n}, `{}`: {case:?}", FAULTS[spoil].0);
                std::panic::resume_unwind(panic);
            }
        }
    }
    most
}
