//! Errors of an effect of a model file.

/// An invalid `[[effect]]` or `[[hypothesis]]` of a model file.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum EffectError {
    /// No such effect.
    #[error("there is no effect `{id}`; {hint}")]
    Unknown {
        /// The id that was given.
        id: String,
        /// What to write instead.
        hint: String,
    },
    /// The same effect more than once.
    #[error("[[effect]] `{id}` stands there twice; keep one of them")]
    Twice {
        /// Its id.
        id: String,
    },
    /// An effect of a bearing where there is none.
    #[error(
        "[[effect]] `{id}` acts about a bearing, and the model has none: that is an axis of which \
         `[rig] active_axes` names one rotation and nothing else, such as [\"rx\"]"
    )]
    NoBearing {
        /// Its id.
        id: String,
    },
    /// `axes` where they have no meaning.
    #[error(
        "[[effect]] `{id}` has no axes of its own, only actuator effects have; take out `axes`"
    )]
    Axes {
        /// Its id.
        id: String,
    },
    /// No such parameter.
    #[error("[[effect]] `{id}`: unknown parameter `{name}`; {hint}")]
    UnknownParameter {
        /// Id of the effect.
        id: String,
        /// The name that was given.
        name: String,
        /// What to write instead.
        hint: String,
    },
    /// A parameter that has no default.
    #[error("[[effect]] `{id}`: the parameter `{name}` is missing; allowed is {low} to {high}")]
    MissingParameter {
        /// Id of the effect.
        id: String,
        /// The parameter.
        name: &'static str,
        /// Smallest allowed value.
        low: f64,
        /// Largest allowed value.
        high: f64,
    },
    /// A value that the effect cannot have on any rig.
    #[error("[[effect]] `{id}`: `{name}` is {received}; allowed is {low} to {high}")]
    OutOfRange {
        /// Id of the effect.
        id: String,
        /// The parameter.
        name: String,
        /// The value that was given.
        received: f64,
        /// Smallest allowed value.
        low: f64,
        /// Largest allowed value.
        high: f64,
    },
    /// An invalid hypothesis.
    #[error("[[hypothesis]] `{id}`: `{key}`: {why}")]
    Hypothesis {
        /// The id that was given.
        id: String,
        /// The key that does not fit.
        key: String,
        /// Why not, and what is expected.
        why: String,
    },
    /// An interval without a parameter, or with its ends exchanged.
    #[error(
        "[[effect]] `{id}`: interval_95 of `{name}` is [{low}, {high}]; expected [low, high] of a \
         parameter that is given"
    )]
    Interval {
        /// Id of the effect.
        id: String,
        /// The parameter.
        name: String,
        /// Lower end.
        low: f64,
        /// Upper end.
        high: f64,
    },
}
