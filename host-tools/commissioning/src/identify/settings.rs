//! An identification as settings of the board.

use super::Identification;
use super::outcome::Estimate;
use crate::fragment::{Fragment, Setting};
use toml_edit::Value;

/// The section of the settings.
const SECTION: &[&str] = &["control", "delay", "actuator"];

impl Identification {
    /// The settings that follow; `origin` says where the recording comes from.
    pub fn fragment(&self, origin: &str) -> Fragment {
        let number = |key, estimate: &Estimate| {
            let high = estimate.high.unwrap_or(estimate.value);
            Setting::number(key, estimate.value, [estimate.low, high])
        };
        let plain = |key, value: Value, remark: &str| Setting {
            key,
            value,
            remark: remark.to_owned(),
        };
        let mut settings = vec![
            number("delay_s", &self.delay_s),
            number("lag_s", &self.lag_s),
        ];
        match (&self.servo_hz, &self.servo_damping) {
            (Some(hz), Some(damping)) => {
                settings.push(number("servo_hz", hz));
                settings.push(number("servo_damping", damping));
            }
            _ => settings.push(plain("servo_hz", 0.0.into(), "none")),
        }
        if let Some(pause) = &self.pause_s {
            settings.push(number("pause_s", pause));
        }
        let (cycles, known, remark) = match &self.feedback_latency_cycles {
            Some(age) => (age.value, true, "by the force of the tool's inertia"),
            None => (0.0, false, "not told from the delay, which holds it"),
        };
        settings.push(plain(
            "feedback_latency_cycles",
            Value::from(cycles as i64),
            remark,
        ));
        settings.push(plain("feedback_latency_known", known.into(), "see above"));
        Fragment {
            section: SECTION,
            origin: vec![
                format!("Identification of the robot from {origin}:"),
                format!(
                    "{} along {}, mean delay {}.",
                    self.structure,
                    self.axis,
                    self.mean_delay_s.in_ms()
                ),
            ],
            settings,
        }
    }
}
