//! Model-assisted Smith predictor: a model of the contact responds at once, and its error is corrected when the late robot has
//! measured the force.
//!
//! ```text
//! F = F_meas + F̂(x_model) − F̂(x_exec)
//! ```
//!
//! Smith, "Closer control of loops with dead time", Chem. Eng. Prog. 53 (1957) 217; for contact
//! tests Li et al. with this sum. F̂ is a spring (and a damper, if given) along the direction of the
//! contact (`contact`); x_exec is the measured position, so the law needs position
//! feedback.
//!
//! Choices that the sum leaves open:
//! - The surface is found at the onset. By then the model, which is ahead of the robot by the delay, is already behind the
//!   surface: without a correction the rebound would be √(1 + φ²) too fast. Each cycle therefore integrates the contact anew
//!   (`replay`) from its onset, which lies a delay earlier in the model's time, with F̂ and with the misfit F_meas − F̂(x_exec)
//!   of every cycle since. The model gets the velocity that results.
//! - Stiffness and surface are identified from the samples of the contact, with the given stiffness as a prior; or the stiffness
//!   is fixed as given.
//! - The model never leaves more than a tenth faster than it came: a surface that was identified wrongly must not add energy
//!   without end.
//! - The robot is led back to the model's position with a time constant, as the commands that are already sent at the onset carry
//!   it deeper.
//!
//! During the contact a part of the impulse is computed, not measured: F̂(x_model) − F̂(x_exec). With the right delay and a
//! spring it sums to nearly zero. With a wrong delay it does not, and the rebound looks perfect all the same.
//! `unaccounted_impulse` in the trace is that part.

mod replay;
mod spring;

use super::contact::{Along, ContactLine, saturated};
use super::status::LawStatus;
use super::{DelaySettings, LawInput, LawOutput};
use crate::frames::{Twist, Wrench};
use crate::scalar::Scalar;
use replay::Replay;

/// Quiet cycles after which a contact is closed although the model is still behind the surface: it was a false start.
const LONGEST_QUIET_CYCLES: u32 = 64;

crate::described! {
/// Settings of the Smith predictor.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields, default))]
pub struct SmithSettings: "delay.smith" {
    /// Stiffness of the contact along its direction, N/m: known, or where identification begins.
    pub stiffness_n_per_m: f64 = 1e5 => 10.0..=1e8,
    /// Damping of the contact, N·s/m; never identified.
    pub damping_n_s_per_m: f64 = 0.0 => 0.0..=1e6,
    /// The stiffness is identified on line.
    pub identify: bool = true,
    /// Force from which a contact counts, N: beyond the sensor's noise.
    pub threshold_n: f64 = 1.0 => 0.01..=1e3,
    /// Time constant with which the robot is led back to the model's position, s.
    pub catch_up_s: f64 = 0.04 => 0.02..=10.0,
}
}

/// The law and the contact that it follows.
#[derive(Clone, Debug)]
pub struct Smith<S: Scalar> {
    settings: SmithSettings,
    line: ContactLine<S>,
    replay: Replay<S>,
    cycle_s: f64,
    ts: S,
    /// Cycles from the model's velocity to its execution; includes the half cycle by which a mean velocity is late.
    lead: S,
    /// Cycles of commands that the reported pose does not show yet: whole cycles, and the fraction.
    pipeline: (usize, S),
    /// Rate at which the distance to the model's position is reduced, 1/s.
    catch_up_per_s: S,
    latency_cycles: u8,
}

impl<S: Scalar> Smith<S> {
    /// No contact yet; `cycle_s` in s.
    pub fn new(settings: &DelaySettings, cycle_s: f64) -> Self {
        let own = &settings.smith;
        let latency_cycles = settings.actuator.feedback_latency_cycles;
        let late = settings.actuator.mean_delay_s() / cycle_s + f64::from(latency_cycles);
        let whole = late.min(super::SENT_HISTORY as f64 - 1.0);
        Self {
            settings: *own,
            line: ContactLine::new(own.threshold_n, &settings.actuator),
            replay: Replay::new(latency_cycles.into(), cycle_s),
            cycle_s,
            ts: S::of(cycle_s),
            lead: S::of(settings.horizon_s(cycle_s) / cycle_s),
            pipeline: (whole as usize, S::of(whole - f64::from(whole as u32))),
            catch_up_per_s: S::of(1.0 / own.catch_up_s),
            latency_cycles,
        }
    }

    /// The wrench with which the model gets the velocity of the replayed contact.
    pub fn condition(&mut self, input: &LawInput<'_, S>) -> Wrench<S> {
        let measured = *input.wrench;
        let Some(along) = self.line.update(input) else {
            return measured;
        };
        if along.mobility <= S::of(1e-8) {
            return measured;
        }
        if along.opened {
            self.replay.open(&self.settings, &along, self.lead);
        }
        self.replay.push(&along);
        self.replay.run();
        let wanted = -self.replay.velocity() * S::of(1e-3);
        let wrench = self.added(&along, wanted);
        if self.replay.depth() < S::zero() {
            self.line.close_when_quiet();
        } else {
            self.line.close_after(LONGEST_QUIET_CYCLES);
        }
        measured + wrench
    }

    /// One cycle: the model's velocity, plus in a contact the velocity that leads the robot back to the model's position (part
    /// 0).
    pub fn step(&mut self, input: &LawInput<'_, S>) -> LawOutput<S> {
        let mut output = LawOutput::of(input.model);
        output.status = self.status();
        if self.line.is_open() && !input.frozen {
            let back = self.line.push(input) * self.catch_up(input);
            output.command = input.model + back;
            output.parts[0] = back;
        }
        output
    }

    /// The wrench along the contact that has to be added to the measured one, so that the model has a velocity of `wanted` (m/s,
    /// away from the surface) after this cycle.
    fn added(&self, along: &Along<S>, wanted: S) -> Wrench<S> {
        let answer = saturated(along.load * along.mobility, 1e5) * self.ts;
        let missing = wanted - along.velocity - answer;
        // Two divisions, as the product of the divisors might vanish in fixed point.
        let force = saturated(missing / self.ts, 1e4) / along.mobility.max(S::of(1e-4));
        self.line.wrench(saturated(force, 1e6))
    }

    /// Velocity along the contact that leads the robot to the model's position, m/s, positive away from the surface.
    fn catch_up(&self, input: &LawInput<'_, S>) -> S {
        let Some(reported) = self.replay.reported_depth() else {
            return S::zero();
        };
        let (whole, rest) = self.pipeline;
        let newest_first = || input.sent.oldest_ordered().rev();
        let along = |sent: &Twist<S>| self.line.part(sent, input);
        let sum = newest_first()
            .take(whole)
            .fold(S::zero(), |sum, sent| sum + along(sent));
        let oldest = newest_first().nth(whole).map_or(S::zero(), along) * rest;
        // A motion away from the surface reduces the depth.
        let commanded = reported - (sum + oldest) * self.ts * S::of(1e3);
        let missing = (self.replay.depth() - commanded) * S::of(1e-3);
        let fastest = self.replay.approach() * S::of(1e-3);
        -(missing * self.catch_up_per_s).clamp(-fastest, fastest)
    }

    /// The load of a wrench along an open contact, and the load that the contact model expects at the last reported depth, both
    /// N. `None` without a contact, or before the surface is known.
    pub(super) fn expected(&self, wrench: &Wrench<S>) -> Option<(S, S)> {
        if !self.line.is_open() {
            return None;
        }
        let expected = self.replay.expected_n()?;
        Some((self.line.load(wrench), expected))
    }

    /// A force along the contact as a wrench at M, axes of M.
    pub(super) fn along(&self, force: S) -> Wrench<S> {
        self.line.wrench(force)
    }

    fn status(&self) -> LawStatus {
        LawStatus {
            stiffness_n_per_m: self.replay.stiffness_n_per_m(),
            damping_n_s_per_m: self.settings.damping_n_s_per_m,
            delay_s: self.lead.get() * self.cycle_s,
            latency_cycles: self.latency_cycles.into(),
            misfit: self.replay.misfit().get(),
            ..self.line.status()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::delay::docking::{Docking, STIFFNESS, believed, between_walls, robot};
    use crate::delay::spacecraft::{CYCLE_S, Spacecraft};
    use crate::delay::status::LawFlags;
    use crate::delay::{Law, LawName, ModelVelocity};
    use crate::settings::BodySettings;
    use softdock_delay_plants::{Actuator, Measurement};

    /// A robot that is 32 ms late and reverses without a pause.
    fn late() -> Actuator {
        Actuator {
            pause_s: 0.0,
            ..robot()
        }
    }

    fn smith(docking: &Docking) -> &Smith<f64> {
        match &docking.law {
            Law::Smith(law) => law,
            _ => panic!("another law"),
        }
    }

    fn settings(latency: u8) -> DelaySettings {
        let mut settings = believed(LawName::Smith, &late());
        settings.actuator.feedback_latency_cycles = latency;
        settings.model_velocity = ModelVelocity::End;
        settings
    }

    fn docking(latency: u8) -> Docking {
        let feedback = Measurement {
            pose_latency_cycles: latency.into(),
            ..Measurement::default()
        };
        let plant = between_walls(late(), 0.0, feedback);
        Docking::new(&settings(latency), &plant, 0.005)
    }

    #[test]
    fn elastic_contacts_give_back_the_speed_that_came() {
        for latency in [0, 2] {
            let mut docking = docking(latency);
            for n in 0..3 {
                let restitution = docking.bounce();
                assert!(
                    (restitution - 1.0).abs() < 6e-4,
                    "{latency} {n}: {restitution}"
                );
                let status = docking.status;
                assert!(
                    (status.stiffness_n_per_m / STIFFNESS - 1.0).abs() < 1e-5,
                    "{status:?}"
                );
                assert!((status.delay_s - 0.032).abs() < 1e-12 && status.misfit < 1e-4);
                assert_eq!(status.latency_cycles, u16::from(latency));
            }
        }
    }

    /// The model has the velocity of the replayed contact, and the robot is where the model was a delay ago.
    #[test]
    fn in_a_contact_the_model_is_that_of_the_replay_and_the_robot_follows_it() {
        for latency in [0, 2] {
            let mut docking = docking(latency);
            let mut depths = Vec::new();
            let (mut opened, mut closed) = (0, 0);
            for n in 0..320 {
                docking.step();
                let law = smith(&docking);
                depths.push(law.replay.depth() * 1e-3);
                if docking.status.flags.has(LawFlags::CONTACT) {
                    (opened, closed) = (if opened == 0 { n } else { opened }, n);
                    assert!((docking.speed() - law.replay.velocity() * 1e-3).abs() < 1e-12);
                }
            }
            assert!((40..60).contains(&(closed - opened)), "{opened} {closed}");
            // It is led there with a time constant of 0.04 s.
            let moments = docking.plant.log().moments[7..].iter();
            for (n, (depth, moment)) in depths.iter().zip(moments).enumerate() {
                let robot = moment.position[0] - 0.0045;
                let led = !(closed - 12..closed).contains(&n) || (robot - depth).abs() < 3e-6;
                assert!(led, "{latency} {n}: {robot} {depth}");
            }
        }
    }

    /// Without a contact the command is the model's velocity; in one the correction towards the model's position is its first
    /// part.
    #[test]
    fn what_leads_back_is_a_part_of_the_command() {
        let mut docking = docking(0);
        while !docking.status.flags.has(LawFlags::CONTACT) {
            docking.step();
        }
        docking.run(10);
        let wrench = Wrench::of(&docking.sample.wrench);
        let spacecraft = &docking.spacecraft;
        let mut input = spacecraft.input(&wrench);
        let mut law = smith(&docking).clone();
        let output = law.step(&input);
        let part = output.parts[0].linear.x;
        assert!(part != 0.0 && part.abs() <= 0.005 * (1.0 + 1e-9));
        assert!((output.command.linear.x - input.model.linear.x - part).abs() < 1e-15);
        input.frozen = true;
        let output = law.step(&input);
        assert_eq!(
            (output.command, output.parts[0]),
            (input.model, Twist::zero())
        );
    }

    /// Two spacecraft of 10⁹ kg: 1 N changes the velocity by 2e-9 m/s in a second.
    #[test]
    fn what_a_push_cannot_move_feels_what_is_measured() {
        let body = BodySettings {
            mass_kg: 1e9,
            ..BodySettings::default()
        };
        let spacecraft = Spacecraft::new(&body, &body);
        let wrench = Wrench::of(&[50.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
        let model = Twist::of(&[-0.005, 0.0, 0.0, 0.0, 0.0, 0.0]);
        let mut law = Smith::new(&settings(0), CYCLE_S);
        assert_eq!(law.condition(&spacecraft.asked(&wrench, model)), wrench);
        assert!(law.line.is_open());
    }

    /// In an open contact: the load of the wrench along it, and the load of the contact model.
    #[test]
    fn what_is_expected_is_the_load_where_the_robot_was_seen() {
        let mut docking = docking(0);
        let none = smith(&docking).expected(&Wrench::zero());
        assert_eq!(none, None);
        while !docking.status.flags.has(LawFlags::CONTACT) {
            docking.step();
        }
        docking.run(5);
        for _ in 0..25 {
            docking.step();
            // The load at the beginning of the cycle is the one at the depth that the robot reports then.
            let moments = &docking.plant.log().moments;
            let seen = Wrench::of(&moments[moments.len() - 2].wrench);
            let (load, expected) = smith(&docking).expected(&seen).unwrap();
            assert!((load + seen.force.x).abs() < 1e-9 && load >= 0.0, "{load}");
            assert!((load - expected).abs() < 0.05, "{load} {expected}");
            let force = smith(&docking).along(load);
            assert!((force.force.x + load).abs() < 1e-9);
        }
    }

    /// The commands on their way: whole cycles and a fraction, no more than are kept.
    #[test]
    fn what_is_on_its_way_to_the_robot_counts_as_executed() {
        for (delay_s, latency, whole, rest) in [
            (0.0333, 2, 10, 0.325),
            (0.2, 0, 50, 0.0),
            (0.2, 255, 63, 0.0),
        ] {
            let mut settings = settings(latency);
            settings.actuator.delay_s = delay_s;
            let law = Smith::<f64>::new(&settings, CYCLE_S);
            assert_eq!(law.pipeline.0, whole);
            assert!((law.pipeline.1 - rest).abs() < 1e-9, "{:?}", law.pipeline);
        }
        // In a contact, with the same command in all cycles.
        let mut docking = docking(0);
        while !docking.status.flags.has(LawFlags::CONTACT) {
            docking.step();
        }
        docking.run(12);
        let mut law = smith(&docking).clone();
        law.pipeline = (10, 0.325);
        let sent = Twist::of(&[1e-3, 0.0, 0.0, 0.0, 0.0, 0.0]);
        (0..64).for_each(|_| docking.spacecraft.sent.write(sent));
        let wrench = Wrench::of(&docking.sample.wrench);
        let input = docking.spacecraft.input(&wrench);
        let deeper = law.replay.depth() - law.replay.reported_depth().unwrap();
        let missing = deeper * 1e-3 - 10.325 * CYCLE_S * 1e-3;
        let expected = -(missing / 0.04).clamp(-0.005, 0.005);
        let found = law.catch_up(&input);
        assert!(expected.abs() < 0.0049);
        assert!((found - expected).abs() < 1e-6, "{found} {expected}");
        // No faster than the approach.
        let far = Twist::of(&[1.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
        (0..64).for_each(|_| docking.spacecraft.sent.write(far));
        let fastest = law.replay.approach() * 1e-3;
        let found = law.catch_up(&docking.spacecraft.input(&wrench));
        assert!(
            (found.abs() - fastest).abs() < 1e-12 && fastest < 0.006,
            "{found}"
        );
    }
}
