//! What a law reports in each cycle, for the trace.

/// How much a law trusts what it has identified of robot and contact. In recordings and JSON the levels keep the names
/// `no_ladder`, `watching`, `identifying` and `leading` of the field `rung`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum ConfidenceLevel {
    /// The law identifies nothing.
    #[default]
    #[cfg_attr(feature = "serde", serde(rename = "NoLadder"))]
    NotAssessed,
    /// The robot's response on the approach is still being compared with the settings, or differs from them while the interlock
    /// is off.
    #[cfg_attr(feature = "serde", serde(rename = "Watching"))]
    Unverified,
    /// The robot behaves as the settings say; the contact is identified as it happens.
    #[cfg_attr(feature = "serde", serde(rename = "Identifying"))]
    Verified,
    /// The identification of a contact did not fit: the next one is led by the model's velocity and
    /// acceleration alone, and guarded.
    #[cfg_attr(feature = "serde", serde(rename = "Leading"))]
    Fallback,
}

crate::flags! {
/// What a law noticed or did in a cycle.
pub struct LawFlags {
    /// A contact is going on.
    0 => CONTACT,
    /// A spurious load, in free flight and not the beginning of a contact, was left out.
    1 => SPURIOUS_LOAD,
    /// The rebound was corrected to the one that the identified contact has.
    2 => GUARD_IDENTIFIED,
    /// The rebound was bounded to what a passive contact can give; the identification did not fit.
    3 => GUARD_PASSIVE,
    /// A contact that is remembered is expected.
    4 => MEMORY,
    /// The robot's delay was followed to the end of the range in which it is followed.
    5 => DELAY_AT_BOUND,
    /// The command is at the largest speed that the law asks for.
    6 => SPEED_LIMIT,
    /// The robot's delay was found to be another one in a contact, and is followed.
    7 => DELAY_FOLLOWED,
    /// A contact has ended as an undamped one, and noise hides a damping that would have slowed the rebound.
    8 => DAMPING_IN_NOISE,
}
}

/// State of a law that identifies robot or contact; zeros for the others.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct LawStatus {
    /// Confidence level.
    #[cfg_attr(feature = "serde", serde(rename = "rung"))]
    pub confidence: ConfidenceLevel,
    /// What the law noticed or did in this cycle.
    pub flags: LawFlags,
    /// Stiffness along the direction of contact, N/m.
    pub stiffness_n_per_m: f64,
    /// Damping along it, N·s/m.
    pub damping_n_s_per_m: f64,
    /// Mean delay from a command to its execution as tracked at present, s.
    pub delay_s: f64,
    /// Cycles by which the reported pose is older than the force.
    pub latency_cycles: u16,
    /// Misfit of the robot (before a contact) or of the contact (in it and after it), as a fraction of the signal.
    pub misfit: f64,
}
