//! What holds in every cycle, whatever goes wrong; see docs/stale-force.md.

use super::line::{Answered, Cycle, Line};
use softdock_app::record::CycleRecord;
use softdock_app::settings::BoardSettings;
use softdock_control::delay::LawName;
use softdock_control::io::SensorSample;
use softdock_control::modes::{Command, Mode};
use softdock_delay_plants::Sample;

/// Energy of a guarded model, by what it began with, less what the bound cannot see.
const LARGEST_ENERGY: f64 = 1.015;

/// Follows a run.
pub(super) struct Judge {
    settings: BoardSettings,
    /// The reading that was used last, and for how many cycles it has not changed.
    reading: SensorSample,
    unchanged: u32,
    /// The cycle before, and the last one on a fresh reading.
    last: Option<CycleRecord>,
    fresh: Option<CycleRecord>,
    /// Fastest that was sent while that reading could be believed, m/s.
    fastest: f64,
    faulted: bool,
    /// Energy in the wall when its force is at the threshold of the bound, twice (once on the way in, once on the
    /// way out), J.
    unseen: f64,
    /// Most energy of a guarded model, less that, by what it began with.
    pub(super) most_energy: f64,
}

impl Judge {
    /// For a contact of this stiffness, N/m.
    pub(super) fn new(settings: &BoardSettings, stiffness: f64) -> Self {
        let threshold_n = settings.control.delay.passivity.threshold_n;
        Self {
            unseen: threshold_n * threshold_n / stiffness,
            settings: settings.clone(),
            reading: SensorSample::default(),
            unchanged: 0,
            last: None,
            fresh: None,
            fastest: 0.0,
            faulted: false,
            most_energy: 0.0,
        }
    }

    pub(super) fn look(&mut self, cycle: &Cycle, answered: &Answered) {
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
        let sent = speed(&record.trace.sent_velocity);
        if self.unchanged == 0 {
            (self.fresh, self.fastest) = (Some(*record), sent);
        } else if self.unchanged <= self.settings.control.sensor.stale_after_cycles {
            self.fastest = self.fastest.max(sent);
        }
    }

    /// The model is not integrated on a reading that has not changed for too long.
    fn held_if_stale(&self, last: &CycleRecord, record: &CycleRecord) {
        let stale_after = self.settings.control.sensor.stale_after_cycles;
        if self.unchanged > stale_after && last.trace.mode == Mode::Running {
            let (before, now) = (last.trace.body_k.velocity, record.trace.body_k.velocity);
            assert_eq!(before, now, "integrated after {} cycles", self.unchanged);
        }
    }

    /// Since the last fresh reading: the speed of what is sent, and the model's change of velocity.
    fn no_more_than_the_fresh_data_allow(&self, record: &CycleRecord) {
        let (Some(fresh), stale) = (self.fresh, self.settings.control.sensor.stale_after_cycles)
        else {
            return;
        };
        if self.unchanged > stale && fresh.trace.mode == Mode::Running {
            let (now, most) = (speed(&record.trace.sent_velocity), self.fastest);
            let cycles = self.unchanged;
            assert!(
                now <= most * (1.0 + 1e-9) + 1e-9,
                "{now} m/s of {most} m/s, {cycles} cycles"
            );
        }
        if self.unchanged == 0 || !self.feels_what_is_measured() {
            return;
        }
        let force = speed(&fresh.trace.wrench_at_m).max(speed(&record.trace.wrench_at_m));
        let cycles = f64::from(self.unchanged.min(stale));
        let most = cycles * 0.004 * force / self.settings.control.body_k.mass_kg;
        let (then, now) = (fresh.trace.body_k.velocity, record.trace.body_k.velocity);
        let change: [f64; 6] = core::array::from_fn(|i| now[i] - then[i]);
        let change = speed(&change);
        assert!(
            change <= most * 1.000_001 + 1e-12,
            "{change} m/s of {most} in {cycles} cycles"
        );
    }

    /// Laws that hand the measured wrench on to the spacecraft, with no guard that takes of it.
    fn feels_what_is_measured(&self) -> bool {
        use LawName::{Ats, Lead, None, Polynomial, Seed};
        let delay = &self.settings.control.delay;
        matches!(delay.law, None | Seed | Lead | Polynomial | Ats)
    }

    /// A guarded model never has more kinetic energy than it began with.
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
        let [x, y, z] = body.velocity_m_s;
        let before = energy(&[x, y, z, 0.0, 0.0, 0.0]);
        let now = energy(&record.trace.body_k.velocity) - self.unseen;
        assert!(now <= before * LARGEST_ENERGY, "{now} J of {before} J");
        self.most_energy = self.most_energy.max(now / before);
    }

    /// After a fault nothing but reset, arm and start on healthy data moves the robot again.
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
            self.look(&cycle, &line.run(&cycle));
            assert!(self.faulted);
        }
    }
}

/// Length of the first three components.
fn speed(twist: &[f64; 6]) -> f64 {
    twist[..3]
        .iter()
        .map(|part| part * part)
        .sum::<f64>()
        .sqrt()
}
