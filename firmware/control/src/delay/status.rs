//! What a law tells about itself in each cycle, for the trace.

/// How much a law trusts what it has found out about robot and contact. In recordings and JSON it keeps the
/// names `no_ladder`, `watching`, `identifying` and `leading` of the field `rung`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum ConfidenceLevel {
    /// The law finds out nothing.
    #[default]
    #[cfg_attr(feature = "serde", serde(rename = "NoLadder"))]
    NotAssessed,
    /// The robot's answer to the approach is being compared with what is believed of it.
    #[cfg_attr(feature = "serde", serde(rename = "Watching"))]
    Unverified,
    /// The robot does as believed; the contact is identified as it happens.
    #[cfg_attr(feature = "serde", serde(rename = "Identifying"))]
    Verified,
    /// The identification of a contact did not fit: the next one is led by the model's velocity and
    /// acceleration alone, and guarded.
    #[cfg_attr(feature = "serde", serde(rename = "Leading"))]
    Fallback,
}

/// What a law noticed or did in a cycle, one bit each.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct LawFlags(pub u16);

impl LawFlags {
    /// A contact is going on.
    pub const CONTACT: Self = Self(1);
    /// A spurious load, in free flight and not the beginning of a contact, was left out.
    pub const SPURIOUS_LOAD: Self = Self(1 << 1);
    /// The rebound was corrected to the one that the identified contact has.
    pub const GUARD_IDENTIFIED: Self = Self(1 << 2);
    /// The rebound was bounded to what a passive contact can give; the identification did not fit.
    pub const GUARD_PASSIVE: Self = Self(1 << 3);
    /// A contact that is remembered is expected.
    pub const MEMORY: Self = Self(1 << 4);
    /// The robot's delay was followed to the end of the range in which it is followed.
    pub const DELAY_AT_BOUND: Self = Self(1 << 5);
    /// The command is at the largest speed that the law asks for.
    pub const SPEED_LIMIT: Self = Self(1 << 6);
    /// The robot's delay was found to be another one in a contact, and is followed.
    pub const DELAY_FOLLOWED: Self = Self(1 << 7);
    /// A contact has ended as an undamped one, and noise hides a damping that would have slowed the rebound.
    pub const DAMPING_IN_NOISE: Self = Self(1 << 8);

    /// Adds flags.
    pub fn set(&mut self, flags: Self) {
        self.0 |= flags.0;
    }

    /// Whether any of `flags` is set.
    pub fn has(self, flags: Self) -> bool {
        self.0 & flags.0 != 0
    }
}

/// State of a law that finds things out; zeros for the others.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct LawStatus {
    /// Confidence level.
    #[cfg_attr(feature = "serde", serde(rename = "rung"))]
    pub confidence: ConfidenceLevel,
    /// What was noticed or done.
    pub flags: LawFlags,
    /// Stiffness along the direction of contact, N/m.
    pub stiffness_n_per_m: f64,
    /// Damping along it, N·s/m.
    pub damping_n_s_per_m: f64,
    /// Mean delay from a command to its execution, followed while running, s.
    pub delay_s: f64,
    /// Cycles by which the reported pose is older than the force.
    pub latency_cycles: u16,
    /// Misfit of robot (before a contact) or contact (in one and after it), as a part of the signal.
    pub misfit: f64,
}
