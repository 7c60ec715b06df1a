//! The guard: at the end of a contact the rebound is held to what was identified, or at least to what
//! a passive contact can give. It moves the model without a measured force; each action is flagged
//! and its impulse is in the trace.

use crate::delay::status::LawFlags;

/// Misfit up to which the identification is believed, beside noise.
const FITS: f64 = 0.06;
/// Gain of speed that is left alone: no contact gives any.
const GAIN: f64 = 0.008;
/// Departure of the restitution that is left alone, beside noise: of a contact that fits exactly, what each
/// part of misfit adds, and the most.
const TOLERANCE: f64 = 0.01;
const TOLERANCE_OF_MISFIT: f64 = 2.0;
const MOST_TOLERANCE: f64 = 0.03;

/// A contact that has ended.
pub(super) struct Ended {
    /// Velocity of the model along the contact, before and after, m/s.
    pub(super) closing: f64,
    pub(super) after: f64,
    /// Restitution of the identified contact.
    pub(super) restitution: f64,
    /// Misfit of the identification, as a part of the load, and what noise makes of it.
    pub(super) misfit: f64,
    pub(super) noise_misfit: f64,
    /// Standard deviation of the restitution by noise.
    pub(super) noise: f64,
}

impl Ended {
    /// Whether the identified contact describes the loads.
    pub(super) fn fits(&self) -> bool {
        self.misfit < FITS + 1.5 * self.noise_misfit
    }

    /// The velocity that the model should have instead, and the flag of that action.
    pub(super) fn corrected(&self) -> Option<(f64, LawFlags)> {
        let e = -self.after / self.closing;
        let tolerance =
            (TOLERANCE + TOLERANCE_OF_MISFIT * self.misfit).min(MOST_TOLERANCE) + 3.0 * self.noise;
        let gains = e > 1.0 + GAIN + 3.0 * self.noise;
        if self.fits() {
            let known = self.restitution.min(1.0);
            let off = gains || (e - known).abs() > tolerance;
            return off.then_some((-known * self.closing, LawFlags::GUARD_IDENTIFIED));
        }
        let impossible = e > 1.0 + 3.0 * self.noise || e < 0.0;
        let bounded = -e.clamp(0.0, 1.0) * self.closing;
        impossible.then_some((bounded, LawFlags::GUARD_PASSIVE))
    }
}
