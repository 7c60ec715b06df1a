//! The impacts in a simulated run, held against the analytic elastic (or damped) bounce.
//!
//! An impact of two spacecraft at one point with stiffness k and damping c along a normal n is that of
//! one mass m, with `1/m = n·(1/m_K + 1/m_Q) n + (r_K × n)·I_K⁻¹(r_K × n) + (r_Q × n)·I_Q⁻¹(…)`,
//! r from each centre of mass to the point. With ω = √(k/m) and ζ = c/(2√(km)): contact time
//! `(π − 2 asin ζ)/(ω√(1−ζ²))` (the contact cannot pull, so it ends where k x + c v = 0),
//! restitution `exp(−ζ/√(1−ζ²) (π − 2 asin ζ))`, elastic peak force v√(km).

use super::scenario::Scenario;
use nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector3};
use serde::Serialize;
use softdock_app::record::CycleRecord;
use softdock_control::delay::status::LawFlags;
use softdock_control::frames::{self, Twist};
use softdock_control::modes::Mode;
use softdock_control::settings::BodySettings;
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
    /// What the analytic bounce gives.
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
    /// (∫ F dt of the measured force − m Δv of the model) / (2 m v): momentum along the normal that the law gave
    /// without a measured force.
    pub impulse_unaccounted: f64,
    /// The law took the contact for an undamped one, and noise may hide a damping that would have slowed the rebound.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub damping_in_noise: bool,
}

/// The analytic bounce against one wall.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AnalyticBounce {
    /// Effective mass, kg.
    pub mass_kg: f64,
    /// ω = √(k/m), rad/s.
    pub frequency_rad_s: f64,
    /// Damping ratio.
    pub zeta: f64,
}

impl AnalyticBounce {
    /// From the scenario's bodies and a wall.
    pub fn new(scenario: &Scenario, wall: &WallSettings) -> Self {
        let control = &scenario.board.control;
        let normal = Vector3::from(wall.normal).normalize();
        let start = frames::orientation_from_abc::<f64>(&scenario.start_abc_rad);
        // The laboratory is the simulated world turned so that K stands as M does at the start; the
        // point of contact is the tip on K, and Q's lever leads to the same point.
        let body_pose =
            |body: &BodySettings| frames::pose::<f64>(&body.position_m, &body.orientation_wxyz);
        let (k, q) = (body_pose(&control.body_k), body_pose(&control.body_q));
        let lab_from_c = start * k.rotation.inverse();
        let tip = start * Vector3::from(wall.tip_m);
        let q_to_tip = lab_from_c * (k.translation.vector - q.translation.vector) + tip;
        let inverse = inverse_mass(&control.body_k, &normal, &tip, &start)
            + inverse_mass(
                &control.body_q,
                &normal,
                &q_to_tip,
                &(lab_from_c * q.rotation),
            );
        let mass_kg = 1.0 / inverse;
        Self {
            mass_kg,
            frequency_rad_s: (wall.stiffness_n_per_m / mass_kg).sqrt(),
            zeta: wall.damping_n_s_per_m / (2.0 * (wall.stiffness_n_per_m * mass_kg).sqrt()),
        }
    }

    /// Phase angle of the contact's end: π − 2 asin ζ.
    fn angle(&self) -> f64 {
        std::f64::consts::PI - 2.0 * self.zeta.min(1.0).asin()
    }

    /// Restitution of one bounce.
    pub fn restitution(&self) -> f64 {
        (-self.zeta / (1.0 - self.zeta * self.zeta).max(1e-12).sqrt() * self.angle()).exp()
    }

    /// Time in contact, s.
    pub fn contact_time_s(&self) -> f64 {
        self.angle() / (self.frequency_rad_s * (1.0 - self.zeta * self.zeta).max(1e-12).sqrt())
    }

    /// Largest force at a closing speed (m/s), N: the larger of touch and of the later maximum.
    pub fn peak_force_n(&self, speed_m_s: f64) -> f64 {
        let (w, z) = (self.frequency_rad_s, self.zeta);
        let damped = w * (1.0 - z * z).max(1e-12).sqrt();
        let force = |t: f64| {
            let decay = (-z * w * t).exp() * speed_m_s;
            let x = decay * (damped * t).sin() / damped;
            let v = decay * ((damped * t).cos() - z * w / damped * (damped * t).sin());
            self.mass_kg * (w * w * x + 2.0 * z * w * v)
        };
        // The maximum of a smooth pulse on a grid of a thousandth of it is good to 1e-6.
        let end = self.contact_time_s();
        (0..=1000)
            .map(|i| force(end * f64::from(i) / 1000.0))
            .fold(0.0, f64::max)
    }
}

fn inverse_mass(
    body: &BodySettings,
    normal: &Vector3<f64>,
    lever: &Vector3<f64>,
    lab_from_body: &UnitQuaternion<f64>,
) -> f64 {
    if body.fixed {
        return 0.0;
    }
    let turn = lab_from_body.inverse() * lever.cross(normal);
    let inertia = Matrix3::from_fn(|r, c| body.inertia_kg_m2[r][c]);
    let response = inertia.lu().solve(&turn).unwrap_or_else(Vector3::zeros);
    1.0 / body.mass_kg + turn.dot(&response)
}

/// Contacts closer together than this belong to one impact, s: a late robot may leave and touch
/// again while the model still turns.
const SAME_IMPACT_S: f64 = 0.02;
/// Cycles after the last force, and after the law's last say about the contact, until the model has seen it:
/// the sensor's sample and the mean of two velocities.
const SETTLE_CYCLES: u32 = 3;

/// What the search keeps of a cycle.
#[derive(Clone, Copy, Debug)]
struct Sample {
    time_s: f64,
    running: bool,
    /// Velocity that the model wants: linear in C, angular in M.
    velocity: Twist<f64>,
    /// Measured orientation of M in C.
    c_from_m: UnitQuaternion<f64>,
    /// True contact force in C, N.
    force: Vector3<f64>,
    /// Impulse in C that the law added to the measured one, N·s.
    added: Vector3<f64>,
    /// The law still follows the contact; its guard acts at the end.
    law_in_contact: bool,
    /// The law says that noise may hide a damping.
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

    /// Speed of the wall's contact point towards the wall, as the model wants it, m/s.
    fn closing_speed(&self, wall: &WallSettings) -> f64 {
        let spin = self.velocity.angular.cross(&Vector3::from(wall.tip_m));
        let tip = self.velocity.linear + self.c_from_m * spin;
        -Vector3::from(wall.normal).normalize().dot(&tip)
    }
}

/// An impact that is not over.
#[derive(Clone, Copy, Debug)]
struct Contact {
    before: Sample,
    after: Option<Sample>,
    touch_s: f64,
    cycles: u32,
    /// Cycles since the last force, and since the law has let the contact go.
    free_cycles: u32,
    settled_cycles: u32,
    peak_force_n: f64,
    /// Sum of the forces, which tells the wall.
    push: Vector3<f64>,
    /// Sum of what the law added, N·s.
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
    /// Nothing has been seen.
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

    /// Takes the next cycle. An impact counts if the loop was closed from before until after it.
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

    /// The impacts that are over.
    pub fn finish(self) -> Vec<Impact> {
        self.impacts
    }

    /// Whether the next force is another impact.
    fn has_parted(&self) -> bool {
        let free = self.contact.map_or(0, |contact| contact.free_cycles);
        f64::from(free) * self.cycle_s > SAME_IMPACT_S
    }

    fn touch(&mut self, sample: Sample) {
        let Some(before) = self.before else { return };
        if self.has_parted() {
            // The law was not done with the last one.
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
        let analytic = AnalyticBounce::new(self.scenario, wall);
        let speed_in = before.closing_speed(wall);
        let speed_out = -after.closing_speed(wall);
        let (restitution, expected) = (speed_out / speed_in, analytic.restitution());
        // Touch and parting lie half a cycle outside of the first and last force on average.
        let contact_time_s = f64::from(cycles) * self.cycle_s;
        self.impacts.push(Impact {
            time_s: touch_s,
            speed_in_mm_s: speed_in * 1e3,
            speed_out_mm_s: speed_out * 1e3,
            restitution,
            expected_restitution: expected,
            energy_error: restitution * restitution - expected * expected,
            peak_force_error: peak_force_n / analytic.peak_force_n(speed_in) - 1.0,
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Known answer: the analytic bounce equals a fine integration of m x'' = -k x - c x', clipped.
    #[test]
    fn analytic_bounce_equals_its_integration() {
        for zeta in [0.0, 0.1, 0.4] {
            let bounce = AnalyticBounce {
                mass_kg: 400.0,
                frequency_rad_s: 21.0,
                zeta,
            };
            let (mut x, mut v, mut t, mut peak) = (0.0_f64, 0.01_f64, 0.0, 0.0_f64);
            let h = 1e-6;
            loop {
                let load = 21.0 * 21.0 * x + 2.0 * zeta * 21.0 * v;
                if t > 0.0 && load <= 0.0 {
                    break;
                }
                peak = peak.max(load * 400.0);
                v -= load * h;
                x += v * h;
                t += h;
            }
            assert!((t - bounce.contact_time_s()).abs() < 1e-4, "{zeta}: {t}");
            assert!(
                (-v / 0.01 - bounce.restitution()).abs() < 1e-4,
                "{zeta}: {v}"
            );
            assert!(
                (peak / bounce.peak_force_n(0.01) - 1.0).abs() < 1e-4,
                "{zeta}: {peak}"
            );
        }
    }
}
