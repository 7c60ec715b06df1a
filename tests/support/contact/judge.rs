//! Checks of every cycle, whatever the fault; see docs/stale-force.md.

use super::line::{Answered, Cycle, Line};
use softdock_app::record::CycleRecord;
use softdock_app::settings::BoardSettings;
use softdock_control::delay::LawName;
use softdock_control::io::SensorSample;
use softdock_control::modes::{Command, Mode};
use softdock_delay_plants::Sample;

/// Largest energy of a guarded model, divided by its largest energy before the contact, and without the energy that the bound
/// does not see. This allows for the slack of the bound, and for no error of the integrator, because the bound counts the
/// exact work.
const LARGEST_ENERGY: f64 = 1.008;

/// Checks the cycles of a run.
pub(super) struct Judge {
    settings: BoardSettings,
    /// The last used reading, and the number of cycles for which it has not changed.
    reading: SensorSample,
    unchanged: u32,
    /// The previous cycle, and the last one with a fresh reading.
    last: Option<CycleRecord>,
    fresh: Option<CycleRecord>,
    /// Largest velocity that was sent while that reading was not yet stale, m/s and rad/s.
    largest_fresh_velocity: [f64; 2],
    faulted: bool,
    /// Energy in the wall when its force is at the threshold of the bound, counted twice (on the way in and on the way out),
    /// J.
    unseen_j: f64,
    /// Largest energy of the model before its first load above the threshold, J, and whether there was such a load.
    energy_before_contact_j: f64,
    touched: bool,
    /// Largest energy of a guarded model, less `unseen_j`, divided by that before the contact.
    pub(super) most_energy: f64,
}

impl Judge {
    /// For a contact with this stiffness, N/m.
    pub(super) fn new(settings: &BoardSettings, stiffness: f64) -> Self {
        let threshold_n = settings.control.delay.passivity.threshold_n;
        Self {
            unseen_j: threshold_n * threshold_n / stiffness,
            settings: settings.clone(),
            reading: SensorSample::default(),
            unchanged: 0,
            last: None,
            fresh: None,
            largest_fresh_velocity: [0.0; 2],
            faulted: false,
            energy_before_contact_j: 0.0,
            touched: false,
            most_energy: 0.0,
        }
    }

    pub(super) fn check(&mut self, cycle: &Cycle, answered: &Answered) {
        let readable = !cycle.lost && cycle.text.is_none_or(|text| text.contains("{}"));
        let connected = cycle.sender == 0;
        if readable && connected {
            assert!(
                answered.correction.is_some(),
                "a telegram without an answer"
            );
        }
        let fresh = cycle.sample.is_some_and(|sample| {
            let same = sample.counts == self.reading.counts && sample.wrench == self.reading.wrench;
            self.reading = sample;
            !same
        });
        self.unchanged = if fresh { 0 } else { self.unchanged + 1 };
        let Some(record) = &answered.record else {
            return;
        };
        self.faulted &= cycle.command != Some(Command::Reset);
        if self.faulted {
            assert_eq!(record.trace.mode, Mode::Fault, "a fault is left by a reset");
        }
        self.faulted = record.trace.mode == Mode::Fault;
        if self.faulted {
            assert_eq!(record.output.correction, [0; 6], "a fault moves nothing");
        }
        if let (Some(last), Mode::Running) = (self.last, record.trace.mode) {
            self.held_if_stale(&last, record);
            self.no_more_than_the_fresh_data_allow(record);
        }
        self.energy(record);
        self.last = Some(*record);
        let sent = parts(&record.trace.sent_velocity);
        if self.unchanged == 0 {
            (self.fresh, self.largest_fresh_velocity) = (Some(*record), sent);
        } else if self.unchanged <= self.settings.control.sensor.stale_after_cycles {
            self.largest_fresh_velocity =
                core::array::from_fn(|i| self.largest_fresh_velocity[i].max(sent[i]));
        }
    }

    /// Checks that the model is not integrated with a reading that has not changed for too long.
    fn held_if_stale(&self, last: &CycleRecord, record: &CycleRecord) {
        let stale_after = self.settings.control.sensor.stale_after_cycles;
        if self.unchanged > stale_after && last.trace.mode == Mode::Running {
            let (before, now) = (last.trace.body_k.velocity, record.trace.body_k.velocity);
            assert_eq!(before, now, "integrated after {} cycles", self.unchanged);
        }
    }

    /// Checks the sent speed and the change of the model's velocity since the last fresh reading.
    fn no_more_than_the_fresh_data_allow(&self, record: &CycleRecord) {
        let (Some(fresh), stale) = (self.fresh, self.settings.control.sensor.stale_after_cycles)
        else {
            return;
        };
        if self.unchanged > stale && fresh.trace.mode == Mode::Running {
            let now = parts(&record.trace.sent_velocity);
            let (cycles, most) = (self.unchanged, self.largest_fresh_velocity);
            for (now, most) in now.into_iter().zip(most) {
                assert!(
                    now <= most * (1.0 + 1e-9) + 1e-9,
                    "{now} m/s or rad/s of {most}, {cycles} cycles"
                );
            }
        }
        if self.unchanged == 0 || !self.feels_what_is_measured() {
            return;
        }
        let body = &self.settings.control.body_k;
        let wrenches = [&fresh, record].map(|cycle| &cycle.trace.wrench_at_m);
        let twists = [&fresh, record].map(|cycle| &cycle.trace.body_k.velocity);
        let largest = |of: fn(&[f64; 6]) -> f64, twists: [&[f64; 6]; 2]| {
            twists.map(of).into_iter().fold(0.0, f64::max)
        };
        // For a body whose axes are its principal axes, as here.
        let inertia: [f64; 3] = core::array::from_fn(|i| body.inertia_kg_m2[i][i]);
        let [least, greatest] = [
            inertia.into_iter().fold(f64::MAX, f64::min),
            inertia.into_iter().fold(0.0, f64::max),
        ];
        let spin = largest(turning, twists);
        let torque = largest(turning, wrenches) + (greatest - least) * spin * spin;
        let accelerations = [
            (
                speed as fn(&[f64; 6]) -> f64,
                largest(speed, wrenches) / body.mass_kg,
                "m/s",
            ),
            (turning, torque / least, "rad/s"),
        ];
        let cycles = f64::from(self.unchanged.min(stale));
        let change: [f64; 6] = core::array::from_fn(|i| twists[1][i] - twists[0][i]);
        for (part, acceleration, unit) in accelerations {
            let (change, most) = (part(&change), cycles * 0.004 * acceleration);
            assert!(
                change <= most * 1.000_001 + 1e-12,
                "{change} {unit} of {most} in {cycles} cycles"
            );
        }
    }

    /// Whether the law passes the measured wrench on to the spacecraft, without a guard that reduces it.
    fn feels_what_is_measured(&self) -> bool {
        use LawName::{Ats, Lead, None, Polynomial, Seed};
        let delay = &self.settings.control.delay;
        matches!(delay.law, None | Seed | Lead | Polynomial | Ats)
    }

    /// Checks that a guarded model never has more kinetic energy than before the contact.
    fn energy(&mut self, record: &CycleRecord) {
        let delay = &self.settings.control.delay;
        let guarded = delay.passivity_guard || delay.law == LawName::Predictor;
        if !guarded || record.trace.mode != Mode::Running {
            return;
        }
        let body = &self.settings.control.body_k;
        let energy = |velocity: &[f64; 6]| {
            let [x, y, z, a, b, c] = velocity.map(|part| part * part);
            let turning = a * body.inertia_kg_m2[0][0]
                + b * body.inertia_kg_m2[1][1]
                + c * body.inertia_kg_m2[2][2];
            0.5 * (body.mass_kg * (x + y + z) + turning)
        };
        let now = energy(&record.trace.body_k.velocity);
        let [x, y, z, ..] = record.trace.wrench_at_m;
        let loaded = [x, y, z]
            .iter()
            .any(|part| part.abs() >= delay.passivity.threshold_n);
        self.touched |= loaded;
        if !self.touched {
            // Energy that noise has added is not due to a contact.
            self.energy_before_contact_j = self.energy_before_contact_j.max(now);
            return;
        }
        let (now, before) = (now - self.unseen_j, self.energy_before_contact_j);
        assert!(now <= before * LARGEST_ENERGY, "{now} J of {before} J");
        self.most_energy = self.most_energy.max(now / before);
    }

    /// Checks that after a fault only reset, arm and start with valid data move the robot again.
    pub(super) fn end(&mut self, line: &mut Line, sample: &Sample) {
        if !self.faulted {
            return;
        }
        for n in 0..40 {
            let mut cycle = Cycle::new([0.0; 6], sample.position);
            cycle.change(|reading| reading.counts[5] = n & 1);
            cycle.command = [
                None,
                Some(Command::Arm),
                Some(Command::Start),
                Some(Command::Stop),
            ][n as usize % 4];
            self.check(&cycle, &line.run(&cycle));
            assert!(self.faulted);
        }
    }
}

/// Norm of the first three components of a twist or wrench.
fn speed(twist: &[f64; 6]) -> f64 {
    length(&twist[..3])
}

/// Norm of the last three components.
fn turning(twist: &[f64; 6]) -> f64 {
    length(&twist[3..])
}

/// Both norms.
fn parts(twist: &[f64; 6]) -> [f64; 2] {
    [speed(twist), turning(twist)]
}

fn length(vector: &[f64]) -> f64 {
    vector.iter().map(|part| part * part).sum::<f64>().sqrt()
}
