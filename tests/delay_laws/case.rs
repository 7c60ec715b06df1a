//! A test: what the board believes and what the plant is, and the contact that comes of it.

use softdock_app::record::CycleRecord;
use softdock_control::delay::LawName;
use softdock_control::modes::Mode;
use softdock_control::scalar::Scalar;
use softdock_control::settings::Settings;
use softdock_delay_plants::{Actuator, Contact, Measurement, PlantSettings, Wall};
use softdock_tests::closed_loop::ClosedLoop;

/// Cycle, s.
pub(crate) const CYCLE_S: f64 = 0.004;
/// Digits of a correction: 1e-6 mm, so that rounding is no effect of its own.
const DECIMALS: u8 = 6;

/// A test: what the board believes and what the plant is.
#[derive(Clone, Debug)]
pub(crate) struct Case {
    pub(crate) settings: Settings,
    pub(crate) plant: PlantSettings,
    pub(crate) speed_m_s: f64,
    pub(crate) mass_kg: f64,
    /// Stiffness by mass, square of the natural frequency: rad/s.
    pub(crate) omega: f64,
    pub(crate) damping_ratio: f64,
    /// Phase of the onset within a cycle, 0 to 1.
    pub(crate) onset_phase: f64,
    /// From the start to the onset at full speed, s.
    pub(crate) flight_s: f64,
}

/// What came of a contact.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rebound {
    /// Speed after over speed before.
    pub(crate) restitution: f64,
    /// Peak force over that of the ideal contact, less 1.
    pub(crate) peak_force_error: f64,
    /// Contact time likewise.
    pub(crate) contact_time_error: f64,
    /// Impulse of measured force less momentum of the model, by 2 m v.
    pub(crate) impulse_unaccounted: f64,
}

impl Case {
    /// Scenario S: 32 ms late, stands still for 16 ms at a reversal, 21 rad/s, elastic.
    pub(crate) fn scenario_s(law: LawName) -> Self {
        let mut settings = Settings::default();
        settings.robot.correction_decimals = DECIMALS;
        settings.body_q.fixed = true;
        settings.limits.box_m = [1.0; 3];
        settings.delay.law = law;
        settings.delay.actuator.pause_s = 0.016;
        Self {
            settings,
            plant: PlantSettings {
                actuator: Actuator {
                    delay_s: 0.032,
                    pause_s: 0.016,
                    ..Actuator::ideal()
                },
                ..PlantSettings::default()
            },
            speed_m_s: 0.005,
            mass_kg: 500.0,
            omega: 21.0,
            damping_ratio: 0.0,
            onset_phase: 0.5,
            flight_s: 0.4,
        }
    }

    /// The loop, running: its next step is the first of the start ramp.
    pub(crate) fn start<S: Scalar>(&self) -> ClosedLoop<S> {
        ClosedLoop::started(&self.settings, &self.plant)
    }

    /// The contact that the plant has, N/m and N·s/m.
    pub(crate) fn contact(&self) -> (f64, f64) {
        let k = self.mass_kg * self.omega * self.omega;
        (k, 2.0 * self.damping_ratio * self.mass_kg * self.omega)
    }

    /// Along x against a wall, until long after the contact.
    pub(crate) fn bounce<S: Scalar>(&self) -> Rebound {
        self.record::<S>(|_| {})
    }

    /// Likewise, with every cycle shown.
    pub(crate) fn record<S: Scalar>(&self, mut see: impl FnMut(&CycleRecord)) -> Rebound {
        let mut case = self.clone();
        case.settings.body_k.mass_kg = self.mass_kg;
        case.settings.body_k.velocity_m_s = [self.speed_m_s, 0.0, 0.0];
        let (k, c) = self.contact();
        let distance_m = self.speed_m_s * (self.flight_s + CYCLE_S * self.onset_phase);
        let mut wall = Wall::elastic([distance_m, 0.0, 0.0], [-1.0, 0.0, 0.0], k);
        wall.law.damping = c;
        case.plant.contact = Contact {
            probes: vec![[0.0; 3]],
            surfaces: vec![wall.into()],
        };
        let mut rig = case.start::<S>();
        let (mut added, mut velocity, mut after) = (0.0, 0.0, 0);
        while after < 100 && rig.cycles < 4000 {
            let record = rig.step();
            see(&record);
            added += record.trace.unaccounted_impulse[0];
            velocity = record.trace.body_k.velocity[0];
            let touched = rig.plant.log().contacts.first();
            after += u32::from(touched.is_some_and(|c| c.release_s.is_some()));
            assert_eq!(record.trace.mode, Mode::Running, "{:?}", record.trace);
        }
        let touched = rig.plant.log().contacts[0];
        let ideal = softdock_delay_plants::truth::Bounce::new(
            self.mass_kg,
            k,
            self.damping_ratio,
            self.speed_m_s,
        );
        Rebound {
            restitution: -velocity / self.speed_m_s,
            peak_force_error: touched.peak_force_n / ideal.peak_force_n - 1.0,
            contact_time_error: touched.duration_s().unwrap_or(f64::INFINITY) / ideal.contact_s
                - 1.0,
            impulse_unaccounted: added / (2.0 * self.mass_kg * self.speed_m_s),
        }
    }

    /// Bounces at several speeds and phases of the onset within a cycle.
    pub(crate) fn bounces(&self, speeds_mm_s: &[f64]) -> Vec<Rebound> {
        self.bounces_at(speeds_mm_s, &[0.0, 0.25, 0.5, 0.75])
    }

    pub(crate) fn bounces_at(&self, speeds_mm_s: &[f64], onset_phases: &[f64]) -> Vec<Rebound> {
        let mut case = self.clone();
        let mut rebounds = Vec::new();
        for speed in speeds_mm_s {
            for onset_phase in onset_phases {
                (case.speed_m_s, case.onset_phase) = (speed * 1e-3, *onset_phase);
                rebounds.push(case.bounce::<f64>());
            }
        }
        rebounds
    }
}

/// Measurement whose pose is late by some cycles.
pub(crate) fn late_pose(cycles: usize) -> Measurement {
    Measurement {
        pose_latency_cycles: cycles,
        ..Measurement::default()
    }
}
