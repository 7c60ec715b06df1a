//! The impacts in a simulated run, held against the analytic elastic (or damped) bounce ([`one_contact`]).

use super::one_contact;
use super::scenario::Scenario;
use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use serde::Serialize;
use softdock_app::record::CycleRecord;
use softdock_control::delay::status::LawFlags;
use softdock_control::frames::Twist;
use softdock_control::modes::Mode;
use softdock_io::recording::{Recording, TruthRecord};
use softdock_rig::rig::settings::WallSettings;

/// One impact. Errors are relative to the analytic bounce.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Impact {
    /// Time of the first force, s.
    pub time_s: f64,
    /// Closing speed of the model before, mm/s.
    pub speed_in_mm_s: f64,
    /// Separating speed of the model after, mm/s.
    pub speed_out_mm_s: f64,
    /// Speed out over speed in.
    pub restitution: f64,
    /// Restitution of the analytic bounce.
    pub expected_restitution: f64,
    /// Kinetic energy along the normal: (e² − e_expected²).
    pub energy_error: f64,
    /// Largest force over the analytic one, less 1.
    pub peak_force_error: f64,
    /// Time in contact over the analytic one, less 1.
    pub contact_time_error: f64,
    /// Largest true contact force, N.
    pub peak_force_n: f64,
    /// Time in contact, s.
    pub contact_time_s: f64,
    /// (∫ F dt of the measured force − m Δv of the model) / (2 m v): momentum along the normal that no measured force
    /// accounts for.
    pub impulse_unaccounted: f64,
    /// Whether the law took the contact for an undamped one although noise may hide a damping that would have slowed the
    /// rebound.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub damping_in_noise: bool,
}

/// Contacts closer together than this belong to one impact, s: a late robot may leave and touch
/// again while the model still turns.
const SAME_IMPACT_S: f64 = 0.02;
/// Cycles after the last force, and after the law has ended its treatment of the contact, until the model's velocity is
/// final: the sensor's sample and the mean of two velocities.
const SETTLE_CYCLES: u32 = 3;

/// Quantities of a cycle for the search.
#[derive(Clone, Copy, Debug)]
struct Sample {
    time_s: f64,
    running: bool,
    /// Velocity of the model: linear in C, angular in M.
    velocity: Twist<f64>,
    /// Measured orientation of M in C.
    c_from_m: UnitQuaternion<f64>,
    /// True contact force in C, N.
    force: Vector3<f64>,
    /// Impulse in C that the law added to the measured one, N·s.
    added: Vector3<f64>,
    /// Whether the law still treats the contact; its guard acts at the end.
    law_in_contact: bool,
    /// Whether the law flags that noise may hide a damping.
    damping_in_noise: bool,
}

impl Sample {
    fn new(record: &CycleRecord, truth: &TruthRecord) -> Self {
        let orientation = |pose: &[f64; 7]| {
            UnitQuaternion::new_normalize(Quaternion::new(pose[3], pose[4], pose[5], pose[6]))
        };
        let force = Vector3::from_column_slice(&truth.contact_wrench[..3]);
        let flags = record.trace.law_status.flags;
        Self {
            time_s: record.trace.time_s,
            running: record.trace.mode == Mode::Running,
            velocity: Twist::of(&record.trace.model_velocity),
            c_from_m: orientation(&record.trace.pose),
            force: orientation(&truth.pose) * force,
            added: orientation(&record.trace.pose)
                * Vector3::from_column_slice(&record.trace.unaccounted_impulse[..3]),
            law_in_contact: flags.has(LawFlags::CONTACT),
            damping_in_noise: flags.has(LawFlags::DAMPING_IN_NOISE),
        }
    }

    /// Speed of the contact point towards the wall according to the model, m/s.
    fn closing_speed(&self, wall: &WallSettings) -> f64 {
        let spin = self.velocity.angular.cross(&Vector3::from(wall.tip_m));
        let tip = self.velocity.linear + self.c_from_m * spin;
        -Vector3::from(wall.normal).normalize().dot(&tip)
    }
}

/// An impact that is not complete.
#[derive(Clone, Copy, Debug)]
struct Contact {
    before: Sample,
    after: Option<Sample>,
    touch_s: f64,
    cycles: u32,
    /// Cycles since the last force (`free_cycles`), and since the law has ended its treatment (`settled_cycles`).
    free_cycles: u32,
    settled_cycles: u32,
    peak_force_n: f64,
    /// Sum of the forces, N; its direction shows which wall was touched.
    push: Vector3<f64>,
    /// Sum of the impulses that the law added, N·s.
    added: Vector3<f64>,
    damping_in_noise: bool,
}

/// Finds the impacts of a simulated run while it runs.
#[derive(Clone, Debug)]
pub struct ImpactFinder<'a> {
    scenario: &'a Scenario,
    cycle_s: f64,
    before: Option<Sample>,
    contact: Option<Contact>,
    impacts: Vec<Impact>,
}

impl<'a> ImpactFinder<'a> {
    /// A finder that has seen no cycle yet.
    pub fn new(scenario: &'a Scenario) -> Self {
        let cycle_s = scenario.board.control.robot.cycle_s;
        Self {
            scenario,
            cycle_s,
            before: None,
            contact: None,
            impacts: Vec::new(),
        }
    }

    /// Takes the next cycle. An impact is only counted if the loop was closed from before it until after it.
    pub fn push(&mut self, record: &CycleRecord, truth: &TruthRecord) {
        let sample = Sample::new(record, truth);
        if !sample.running {
            (self.before, self.contact) = (None, None);
            return;
        }
        if sample.force != Vector3::zeros() {
            self.touch(sample);
        } else if let Some(contact) = &mut self.contact {
            contact.free_cycles += 1;
            contact.added += sample.added;
            contact.damping_in_noise |= sample.damping_in_noise;
            if !sample.law_in_contact {
                contact.settled_cycles += 1;
            }
            if contact.settled_cycles == SETTLE_CYCLES {
                contact.after = Some(sample);
            }
            if contact.after.is_some() && self.has_parted() {
                self.end();
            }
        }
        self.before = Some(sample);
    }

    /// The complete impacts.
    pub fn finish(self) -> Vec<Impact> {
        self.impacts
    }

    /// Whether the next force belongs to another impact.
    fn has_parted(&self) -> bool {
        let free = self.contact.map_or(0, |contact| contact.free_cycles);
        f64::from(free) * self.cycle_s > SAME_IMPACT_S
    }

    fn touch(&mut self, sample: Sample) {
        let Some(before) = self.before else { return };
        if self.has_parted() {
            // The law was still treating the last contact: take the velocity just before the new touch.
            self.contact = self.contact.map(|contact| Contact {
                after: Some(before),
                ..contact
            });
            self.end();
        }
        let contact = self.contact.get_or_insert(Contact {
            before,
            after: None,
            touch_s: sample.time_s,
            cycles: 0,
            free_cycles: 0,
            settled_cycles: 0,
            peak_force_n: 0.0,
            push: Vector3::zeros(),
            added: Vector3::zeros(),
            damping_in_noise: false,
        });
        contact.cycles += contact.free_cycles + 1;
        (contact.free_cycles, contact.settled_cycles) = (0, 0);
        contact.after = None;
        contact.added += sample.added;
        contact.damping_in_noise |= sample.damping_in_noise;
        contact.peak_force_n = contact.peak_force_n.max(sample.force.norm());
        contact.push += sample.force;
    }

    fn end(&mut self) {
        let Some(Contact {
            before,
            after: Some(after),
            touch_s,
            cycles,
            peak_force_n,
            push,
            added,
            damping_in_noise,
            ..
        }) = self.contact.take()
        else {
            return;
        };
        let along = |wall: &WallSettings| Vector3::from(wall.normal).normalize().dot(&push);
        let walls = self.scenario.rig.mechanism.walls.iter();
        let Some(wall) = walls.max_by(|a, b| along(a).total_cmp(&along(b))) else {
            return;
        };
        let analytic = one_contact::Contact::new(self.scenario, wall);
        let speed_in = before.closing_speed(wall);
        let speed_out = -after.closing_speed(wall);
        let (restitution, expected) = (speed_out / speed_in, analytic.restitution());
        // On average the touch lies half a cycle before the first force, and the parting half a cycle after the last one.
        let contact_time_s = f64::from(cycles) * self.cycle_s;
        self.impacts.push(Impact {
            time_s: touch_s,
            speed_in_mm_s: speed_in * 1e3,
            speed_out_mm_s: speed_out * 1e3,
            restitution,
            expected_restitution: expected,
            energy_error: restitution * restitution - expected * expected,
            // If the contact begins while it separates, there is no peak to compare with.
            peak_force_error: peak_force_n / analytic.peak_force_n(speed_in.max(0.0)) - 1.0,
            contact_time_error: contact_time_s / analytic.contact_time_s() - 1.0,
            peak_force_n,
            contact_time_s,
            impulse_unaccounted: Vector3::from(wall.normal).normalize().dot(&added)
                / (2.0 * analytic.mass_kg * speed_in),
            damping_in_noise,
        });
    }
}

/// All impacts of a recorded run, in their order.
pub fn find(scenario: &Scenario, recording: &Recording) -> Vec<Impact> {
    let mut finder = ImpactFinder::new(scenario);
    for (record, truth) in recording.cycles.iter().zip(&recording.truth) {
        finder.push(record, truth);
    }
    finder.finish()
}
