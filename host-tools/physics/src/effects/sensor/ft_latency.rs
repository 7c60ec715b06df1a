//! Age of the sensor's samples.

use crate::effects::{DelayAndLag, Effect, Group, Kind, Law, Naming, Parameter};

/// Catalogue entry.
pub const EFFECT: Effect = Effect {
    id: "ft_latency",
    title: "Latency of the sensor",
    summary: "the wrench is older than its time stamp says",
    group: Group::Sensor,
    naming: Naming::Cause,
    equation: "W(t) = W_nominal(t - latency_s)",
    source: "sensor manuals (internal filters and bus transfer)",
    signature: "the wrench is a shifted copy of what the penetration predicts: force against penetration opens to a \
                loop that feeds energy in",
    typical: "1 to 10 ms: one to some cycles of the sensor's own sampling and the bus",
    parameters: &[Parameter::new("latency_s", "s", 0.0, 1.0)
        .delay_or_lag()
        .hidden(0.012, 0.022)
        .pictured(0.02)],
    confused_with: &[
        "ft_low_pass",
        "clock_offset",
        "actuation_delay",
        "contact_damping",
    ],
    tell_apart: "steps of the load at rest, such as taps on the sensor: a latency shifts a step, a filter smears it; a negative \
                 damping of the contact is a latency",
    law: Law::ReadingDelay(|p| DelayAndLag {
        delay_s: p[0],
        lag_s: 0.0,
    }),
    kind: Some(Kind::LateReading),
    ..Effect::PLAIN
};
