//! The laws and their names: what commands, tables and benchmarks go through.

use super::LawName;

impl LawName {
    /// Every law, in the order of tables.
    pub const ALL: [Self; 8] = [
        Self::None,
        Self::Seed,
        Self::Lead,
        Self::Polynomial,
        Self::Ats,
        Self::Smith,
        Self::Passivity,
        Self::Predictor,
    ];

    /// The name in settings, on the command line and in tables.
    pub const fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Seed => "seed",
            Self::Lead => "lead",
            Self::Polynomial => "polynomial",
            Self::Ats => "ats",
            Self::Smith => "smith",
            Self::Passivity => "passivity",
            Self::Predictor => "predictor",
        }
    }

    /// The law of a name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|law| law.name() == name)
    }

    /// Whether the law works with the measured pose: it is of no use on a robot that does not
    /// report where it is, or that reports what it was told.
    pub const fn needs_position(self) -> bool {
        match self {
            Self::None | Self::Seed | Self::Lead | Self::Polynomial => false,
            Self::Ats | Self::Smith | Self::Passivity | Self::Predictor => true,
        }
    }
}
