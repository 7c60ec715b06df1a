//! The true course of a run: the executed motion and every contact.

use crate::Axes;
use crate::contact::Load;
use nalgebra::Vector3;

/// The executed motion at the end of a cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moment {
    /// Time, s.
    pub time_s: f64,
    /// X Y Z A B C, m and rad.
    pub position: Axes,
    /// Velocities of X Y Z A B C, m/s and rad/s.
    pub velocity: Axes,
    /// Wrench on the flange about M in axes of M, N and N·m.
    pub wrench: Axes,
}

/// One contact, from the first touch to the release.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ContactRecord {
    /// Time at which a probe entered a surface, s.
    pub touch_s: f64,
    /// Time at which the last probe left the surface, or at which the force of a damped contact ended before that, s; None if
    /// the run ended before.
    pub release_s: Option<f64>,
    /// Largest sum of normal forces, N.
    pub peak_force_n: f64,
    /// ∫ F dt in the laboratory, N·s.
    pub impulse_n_s: Vector3<f64>,
    /// Last time at which a force acted, s.
    last_force_s: f64,
    /// Force and normal force at the last sample.
    last: (Vector3<f64>, f64),
}

/// The true course of a run.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Log {
    /// One entry per cycle.
    pub moments: Vec<Moment>,
    /// All contacts; the last one may not be released yet.
    pub contacts: Vec<ContactRecord>,
    /// Depth and time of the last sample.
    last_sample: (f64, f64),
}

impl ContactRecord {
    /// Time with force, s; None while it lasts.
    pub fn duration_s(&self) -> Option<f64> {
        self.release_s.map(|release_s| release_s - self.touch_s)
    }

    fn add(&mut self, from_s: f64, to_s: f64, load: &Load) {
        let (force, normal) = self.last;
        self.impulse_n_s += (force + load.force) * (0.5 * (to_s - from_s));
        self.peak_force_n = self.peak_force_n.max(load.normal_force);
        if load.normal_force > 0.0 || normal > 0.0 {
            self.last_force_s = to_s;
        }
        self.last = (load.force, load.normal_force);
    }
}

impl Log {
    /// The first sample, before any motion.
    pub(crate) fn begin(&mut self, load: &Load) {
        self.last_sample = (load.depth, 0.0);
    }

    /// Adds a sample of the load. Between samples, 0.1 ms apart or less, depth and force are interpolated linearly: times of
    /// touch and release are accurate to a microsecond, impulses to a thousandth.
    pub(crate) fn add_sample(&mut self, time_s: f64, load: &Load) {
        let (depth, before_s) = self.last_sample;
        self.last_sample = (load.depth, time_s);
        let open = self.contacts.last().is_some_and(|c| c.release_s.is_none());
        let border_s = || {
            let share = depth / (depth - load.depth);
            before_s + share * (time_s - before_s)
        };
        if !open && load.depth > 0.0 {
            let touch_s = if depth < 0.0 { border_s() } else { before_s };
            self.contacts.push(ContactRecord {
                touch_s,
                last_force_s: touch_s,
                ..ContactRecord::default()
            });
            if let Some(contact) = self.contacts.last_mut() {
                contact.add(touch_s, time_s, load);
            }
        } else if open && let Some(contact) = self.contacts.last_mut() {
            let end_s = if load.depth > 0.0 { time_s } else { border_s() };
            contact.add(before_s, end_s, load);
            if load.depth <= 0.0 {
                contact.release_s = Some(contact.last_force_s);
            }
        }
    }
}
