//! Low-pass filter inside the sensor.

use crate::effects::{DelayAndLag, Effect, Group, Kind, Law, Naming, Parameter};

/// Catalogue entry.
pub const EFFECT: Effect = Effect {
    id: "ft_low_pass",
    title: "Low-pass filter of the sensor",
    summary: "a filter in the sensor rounds and delays the wrench",
    group: Group::Sensor,
    naming: Naming::Cause,
    equation: "time_constant_s dW/dt = W_in - W; cut-off frequency 1/(2 pi time_constant_s)",
    source: "sensor manuals (first-order filter settings)",
    signature: "the wrench is late against penetration and its onset is rounded; a late robot delays the motion, \
                not the force",
    typical: "1 to 20 ms (8 to 150 Hz), set in the sensor's electronics",
    parameters: &[Parameter::new("time_constant_s", "s", 0.0, 1.0)
        .delay_or_lag()
        .hidden(0.012, 0.022)
        .pictured(0.03)],
    confused_with: &[
        "ft_latency",
        "contact_damping",
        "actuation_lag",
        "ft_dropout",
    ],
    tell_apart: "steps of the load, such as taps on the sensor: a filter smears a step, a latency shifts it; a damped contact is late only \
                 while it moves, a filter also after the motion has stopped",
    law: Law::ReadingDelay(|p| DelayAndLag {
        delay_s: 0.0,
        lag_s: p[0],
    }),
    kind: Some(Kind::LateReading),
    ..Effect::PLAIN
};
