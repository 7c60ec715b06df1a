//! Linear damping of a contact.

use crate::effects::{Effect, Group, Naming, Parameter};
use crate::range::{SettingsError, in_range};
use crate::scalar::Scalar;

/// Catalogue entry.
pub const EFFECT: Effect = Effect {
    id: "contact_damping",
    title: "Damping of the contact",
    summary: "the contact damps in proportion to the speed of penetration",
    group: Group::Mechanism,
    naming: Naming::Cause,
    equation: "F = max(0, nominal push + damping_n_s_per_m min(1, pen/onset) dpen/dt) while pen > 0, onset from \
               the nominal model",
    source: "linear spring and damper (Kelvin-Voigt), clipped because a wall cannot pull",
    signature: "force against penetration opens to a loop whose area grows with speed; the rebound is slower",
    typical: "1 to 10 % of critical damping for metal springs, 10 to 30 % for rubber",
    parameters: &[Parameter::new("damping_n_s_per_m", "N s/m", 0.0, 1e7)],
    confused_with: &[
        "hunt_crossley",
        "guide_viscous",
        "actuation_delay",
        "ft_low_pass",
    ],
    tell_apart: "bounces at two speeds: with linear damping the restitution does not depend on speed, with \
                 Hunt-Crossley damping it falls with speed; a delay feeds energy in instead of taking it out",
};

/// Damper between the surfaces of a contact.
#[derive(Clone, Copy, Debug)]
pub struct ContactDamping<S: Scalar> {
    damping: S,
    /// 1/onset; `None`: damping acts at once.
    inverse_onset: Option<S>,
}

impl<S: Scalar> ContactDamping<S> {
    /// `damping_n_s_per_m` 0 to 1e7 N·s/m; `damping_onset_m` 0 to 1 m: penetration over which
    /// damping sets in, 0: at once, with a jump of force at touch.
    pub fn new(damping_n_s_per_m: f64, damping_onset_m: f64) -> Result<Self, SettingsError> {
        in_range("damping_n_s_per_m", damping_n_s_per_m, 0.0, 1e7)?;
        in_range("damping_onset_m", damping_onset_m, 0.0, 1.0)?;
        Ok(Self {
            damping: S::of(damping_n_s_per_m),
            inverse_onset: (damping_onset_m > 1e-9).then(|| S::of(1.0 / damping_onset_m)),
        })
    }

    /// Push (N) in addition to that of the spring, at a penetration (m) that grows by `rate`
    /// (m/s); 0 outside.
    pub fn force(&self, penetration: S, rate: S) -> S {
        if penetration <= S::zero() {
            return S::zero();
        }
        let onset = self
            .inverse_onset
            .map_or(S::one(), |inverse| (penetration * inverse).min(S::one()));
        self.damping * onset * rate
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_sets_in_over_the_onset() {
        let damper = ContactDamping::<f64>::new(100.0, 0.5).unwrap();
        let push = [-0.1, 0.125, 0.5, 2.0].map(|p| damper.force(p, 0.5));
        assert_eq!(push, [0.0, 12.5, 50.0, 50.0]);
        let at_once = ContactDamping::<f64>::new(100.0, 0.0).unwrap();
        assert_eq!(at_once.force(1e-6, -0.5), -50.0);
    }
}
