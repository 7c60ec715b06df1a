//! The default law: the robot is led so that it is where the two craft would be, when it is there.
//!
//! The model is moved by the measured force; what is added where samples or noise hide it is in the
//! trace. A twin of the robot knows where it is and where the commands on their way will bring it;
//! each contact is identified as it happens; the command follows the motion that two craft with such a
//! contact would have, one delay ahead, and leans into the contact so that the impulse still to come is
//! that of the rebound. The page `docs/delay/predictor.md` follows it through with its equations,
//! limits and numbers.
//!
//! | file | what |
//! |---|---|
//! | `coordinates` | the robot's six axes, in metres |
//! | `chain`, `pause`, `twin` | the robot: delay, lag, servo, pause |
//! | `approach`, `noise` | what the flight to the contact shows of robot and sensor |
//! | `drift` | the delay after it, from how the robot turns in each contact |
//! | `identify`, `bank` | the contact, and how old the reported pose is |
//! | `touch`, `contact`, `rebound`, `guard`, `walls` | a contact's course, its end, and what is remembered of it |
//! | `reference`, `solver`, `balance`, `turn`, `command` | the command |
//! | `leading` | the command without an identified contact |
//!
//! It computes in f64 whatever the scalar of the cycle is.

mod approach;
mod balance;
mod bank;
mod chain;
mod command;
mod contact;
mod coordinates;
mod drift;
mod flight;
mod guard;
mod identify;
mod leading;
mod linear;
mod noise;
mod pause;
mod rebound;
mod reference;
mod settings;
mod solver;
mod touch;
mod turn;
mod twin;
mod walls;

pub use settings::PredictorSettings;

use super::actuator::ActuatorSettings;
use super::status::{LawFlags, LawStatus, Rung};
use super::{DelaySettings, LawInput, LawOutput};
use crate::frames::Wrench;
use crate::modes::{Fault, FaultCode};
use crate::scalar::Scalar;
use approach::Approach;
use chain::Chain;
use command::Situation;
use contact::Contact;
use drift::Drift;
use flight::Flight;
use leading::Leading;
use nalgebra::{SMatrix, SVector};
use noise::LoadNoise;
use reference::Reference;
use solver::Solver;
use turn::Turns;
use twin::Plan;
use walls::Walls;

type V6 = SVector<f64, 6>;
type M6 = SMatrix<f64, 6, 6>;

/// Cycles that a command looks ahead: a delay and the longer part of a contact.
const HORIZON: usize = 48;
/// Free commands of the horizon.
const MOVES: usize = 12;
/// Latencies of the pose that are told apart: 0 to 4 cycles.
const LATENCIES: usize = 5;
/// Commands that are kept: the longest delay of the settings, the range in which it is followed, the
/// latency of the settings.
const KEPT: usize = 76;
/// Longest delay that can be followed, cycles.
const LONGEST: usize = KEPT - 8;

/// Share of an error of position that the twin takes over in a cycle, without noise.
const OBSERVER: f64 = 0.3;
/// How noise lowers it: of its ratio to the way that the robot is late.
const OBSERVER_DOUBT: f64 = 112.0;
/// Expected ω τ of a contact whose stiffness nothing is known of: the middle, in proportion, of
/// those that can be compensated, 0.2 to 1.8.
const EXPECTED_PHASE: f64 = 0.6;
/// Mean delays, and cycles more, after which the robot has reached the speed of the model.
const PHASE_IN: f64 = 3.0;
const PHASE_IN_MORE: f64 = 8.0;
/// Largest misfit of the approach beyond noise, as a part of the way that the robot is late.
const MISFIT: f64 = 0.0035;

/// The law and its state.
///
/// Flight and contact are kept beside the rest, which works on both: neither is ever moved, which on a
/// microcontroller would cost more stack than the rest of the cycle. For the same reason the steps of
/// a cycle are not inlined into each other.
#[derive(Clone, Debug)]
pub struct Predictor {
    pilot: Pilot,
    /// Observed in every cycle; none before the first.
    flight: Option<Flight>,
    contact: Option<Contact>,
}

/// What is believed and decided.
#[derive(Clone, Debug)]
struct Pilot {
    settings: PredictorSettings,
    plan: Plan,
    solver: Solver,
    /// Latency that is believed, and whether it is known.
    latency: usize,
    latency_known: bool,
    /// This cycle was observed already.
    seen: bool,
    approach: Approach,
    noise: LoadNoise,
    walls: Walls,
    turns: Turns,
    rung: Rung,
    leading: Leading,
    drift: Drift,
    /// Cycles until the delay after the last contact is known.
    settling: u32,
    /// Stiffness and damping of the last contact, N/m and N·s/m.
    identified: [f64; 2],
    misfit: f64,
    /// Cycles since the start ramp.
    released: u32,
    flags: LawFlags,
    fault: Option<Fault>,
}

/// The latency to begin with: the known one, or the middle.
fn first_latency(actuator: &ActuatorSettings) -> usize {
    if actuator.feedback_latency_known {
        usize::from(actuator.feedback_latency_cycles).min(LATENCIES - 1)
    } else {
        LATENCIES / 2
    }
}

fn plan(actuator: &ActuatorSettings, cycle_s: f64, reported: usize) -> Plan {
    Plan {
        chain: Chain::new(actuator, cycle_s, reported as f64, LONGEST),
        pause: actuator.pause_s / cycle_s,
        cycle_s,
    }
}

impl Predictor {
    /// Before the first cycle; `cycle_s` in s.
    #[inline(always)] // or each level would hold a copy of the law on the stack
    pub fn new(settings: &DelaySettings, cycle_s: f64) -> Self {
        Self {
            pilot: Pilot::new(settings, cycle_s),
            flight: None,
            contact: None,
        }
    }

    /// The same as a new one.
    #[inline(never)]
    pub fn restart(&mut self, settings: &DelaySettings, cycle_s: f64) {
        self.pilot = Pilot::new(settings, cycle_s);
        self.flight = None;
        self.contact = None;
    }

    /// The wrench that the model feels, at M in axes of M: none in free flight, and in a contact the
    /// mean of the last two measured ones, with what the samples cannot see of its beginning.
    pub fn condition<S: Scalar>(&mut self, input: &LawInput<'_, S>) -> Wrench<S> {
        self.observe(input);
        let Some(flight) = &mut self.flight else {
            return *input.wrench;
        };
        let velocity = flight.velocity(&input.model_end);
        flight.take_load(input.wrench);
        let felt = self.pilot.feel(flight, &mut self.contact, input, &velocity);
        flight.wrench(&felt)
    }

    /// One cycle: the velocity that the robot is told.
    pub fn step<S: Scalar>(&mut self, input: &LawInput<'_, S>) -> LawOutput<S> {
        self.observe(input);
        self.pilot.seen = false;
        let Some(flight) = &mut self.flight else {
            return LawOutput::of(input.model_end);
        };
        if !input.released {
            // The ramp shows the sensor's noise before any load may move the model.
            flight.take_load(input.wrench);
            self.pilot.noise.add(&flight.load);
        }
        self.pilot.lead(flight, self.contact.as_mut(), input)
    }

    /// Takes in what was sent and where the robot is, once in a cycle.
    #[inline(never)]
    fn observe<S: Scalar>(&mut self, input: &LawInput<'_, S>) {
        let pilot = &mut self.pilot;
        if core::mem::replace(&mut pilot.seen, true) {
            return;
        }
        pilot.flags = LawFlags::default();
        let Some(flight) = &mut self.flight else {
            let flight = self.flight.insert(Flight::new(input));
            let velocity = flight.velocity(&input.model_end);
            pilot.approach = Approach::new(flight.measured, &velocity);
            return;
        };
        let gain = pilot.observer(&flight.velocity(&input.model_end));
        let command = flight.advance(input, &pilot.plan, gain);
        if pilot.approach.is_over() {
            let cycle_s = pilot.plan.cycle_s;
            pilot.drift.add(&flight.residual, &flight.axes, cycle_s);
        }
        if self.contact.is_none() {
            pilot.watch(flight, &command);
        }
        flight.look(&pilot.plan, pilot.latency);
    }
}

impl Pilot {
    #[inline(always)] // or each level would hold a copy of it on the stack
    fn new(settings: &DelaySettings, cycle_s: f64) -> Self {
        let actuator = &settings.actuator;
        // Commissioning sees the delay up to the reported pose, of which the latency is a part.
        let reported = usize::from(actuator.feedback_latency_cycles);
        let latency = first_latency(actuator);
        let plan = plan(actuator, cycle_s, reported);
        Self {
            solver: Solver::new(plan.chain.response(latency)),
            noise: LoadNoise::new(settings.predictor.force_noise_n),
            settings: settings.predictor.clone(),
            plan,
            latency,
            latency_known: actuator.feedback_latency_known,
            seen: false,
            approach: Approach::new(V6::zeros(), &V6::zeros()),
            walls: Walls::default(),
            turns: Turns::default(),
            rung: Rung::Watching,
            leading: Leading::new(),
            drift: Drift::default(),
            settling: 0,
            identified: [0.0; 2],
            misfit: 0.0,
            released: 0,
            flags: LawFlags::default(),
            fault: None,
        }
    }

    /// Gain of the twin's observer: noise against the way that the robot is late.
    fn observer(&self, velocity: &V6) -> f64 {
        let late = velocity.norm() * self.plan.chain.mean * self.plan.cycle_s;
        let noise = self.approach.findings.noise_m;
        OBSERVER / (1.0 + OBSERVER_DOUBT * noise / late.max(1e-9))
    }

    /// The flight: follows the delay, and does not let a robot into a first contact that is not as
    /// believed.
    #[inline(never)]
    fn watch(&mut self, flight: &mut Flight, command: &V6) {
        if self.approach.is_over() {
            self.follow(flight);
            return;
        }
        if let Some(late) = self.approach.take(&flight.measured, command, &self.plan) {
            self.change_delay(flight, late);
        }
        let findings = &self.approach.findings;
        self.misfit = findings.misfit;
        if findings.at_bound {
            self.flags.set(LawFlags::DELAY_AT_BOUND);
        }
        if findings.complete {
            self.rung = Rung::Identifying;
            let late = self.approach.speed() * self.plan.chain.mean * self.plan.cycle_s;
            let most = MISFIT + findings.noise_m / late.max(1e-9);
            if self.settings.interlock && (findings.misfit > most || findings.at_bound) {
                let code = FaultCode::ActuatorUnlike;
                self.fault = Some(Fault::new(code, most, findings.misfit));
            }
        }
    }

    /// The command of this cycle.
    #[inline(never)]
    fn lead<S: Scalar>(
        &mut self,
        flight: &mut Flight,
        contact: Option<&mut Contact>,
        input: &LawInput<'_, S>,
    ) -> LawOutput<S> {
        let velocity = flight.velocity(&input.model_end);
        let cycle_s = self.plan.cycle_s;
        let axes = flight.at_force(&self.plan, self.latency);
        // Until the approach is known the model is where the robot is: both are in phase.
        if input.released {
            self.released = self.released.saturating_add(1);
        }
        let in_phase = f64::from(self.released) > PHASE_IN * self.plan.chain.mean + PHASE_IN_MORE;
        if !(self.approach.is_over() && in_phase) && contact.is_none() {
            flight.model = axes.position() + velocity * cycle_s;
            let mut output = LawOutput::of(input.model_end);
            output.status = self.status();
            output.fault = self.fault.take();
            return output;
        }
        let now = flight.cycle;
        let (reference, estimate) = match &contact {
            Some(contact) => (
                contact.reference(self.latency, cycle_s),
                Some(*contact.estimate(self.latency)),
            ),
            None => self.in_flight(flight, &velocity, now),
        };
        let situation = Situation {
            cycle: now,
            plan: &self.plan,
            commands: &flight.commands,
            solver: &self.solver,
            latency: self.latency,
            axes,
            velocity,
            reference,
            contact: estimate,
            turns: self.turns,
            leaned: contact.as_ref().map_or(0.0, |contact| contact.leaned),
        };
        let trusted = self.rung != Rung::Leading;
        let decision = self.leading.decide(&situation, contact.is_some(), trusted);
        self.turns = decision.turns;
        if let Some(contact) = contact {
            contact.leaned += decision.lean * cycle_s;
        }
        let place = if self.leading.trust > 0.0 {
            flight.model
        } else {
            axes.position()
        };
        flight.model = place + velocity * cycle_s;
        if decision.at_speed_limit {
            self.flags.set(LawFlags::SPEED_LIMIT);
        }
        let mut output = LawOutput::of(flight.twist(&decision.command));
        output.parts[0] = flight.twist(&decision.tracking);
        output.parts[1] = flight.twist(&decision.leaning);
        output.status = self.status();
        output.fault = self.fault.take();
        output
    }

    /// Straight on, or into a wall that is remembered.
    fn in_flight(
        &mut self,
        flight: &Flight,
        velocity: &V6,
        now: usize,
    ) -> (Reference, Option<identify::Estimate>) {
        let horizon = HORIZON as f64 - MOVES as f64;
        let wall = self
            .walls
            .ahead(&flight.model, velocity, now, horizon, self.plan.cycle_s);
        if let Some((reference, estimate)) = wall {
            self.flags.set(LawFlags::MEMORY);
            return (reference, Some(estimate));
        }
        let straight = Reference {
            touch: now as f64,
            position: flight.model,
            velocity: *velocity,
            push: V6::zeros(),
            closing: 0.0,
            spring: None,
        };
        (straight, None)
    }

    fn status(&self) -> LawStatus {
        LawStatus {
            rung: self.rung,
            flags: self.flags,
            stiffness_n_per_m: self.identified[0],
            damping_n_s_per_m: self.identified[1],
            delay_s: (self.plan.chain.mean - self.latency as f64) * self.plan.cycle_s,
            latency_cycles: self.latency as u16,
            misfit: self.misfit,
        }
    }
}
