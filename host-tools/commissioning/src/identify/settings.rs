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
        let by_force = "by the force of the tool's inertia";
        let (cycles, known, remark) = match &self.feedback_latency_cycles {
            Some(age) => (
                age.value,
                age.is_exact(),
                format!("{by_force}: {}", age.in_cycles()),
            ),
            None => (
                0.0,
                false,
                "not told from the delay, which holds it".to_owned(),
            ),
        };
        settings.push(plain(
            "feedback_latency_cycles",
            Value::from(cycles as i64),
            &remark,
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

#[cfg(test)]
mod tests {
    use super::*;
    use softdock_physics::model::Axis;

    /// The board takes an age that is marked as known for the only possible one.
    #[test]
    fn an_age_is_known_where_no_other_is_possible() {
        for (low, high, says) in [
            (1.0, Some(1.0), "feedback_latency_known = true"),
            (
                0.0,
                Some(3.0),
                "1 cycle(s), 0 to 3 are possible\nfeedback_latency_known = false",
            ),
            (
                1.0,
                None,
                "1 cycle(s), 1 and more are possible\nfeedback_latency_known = false",
            ),
        ] {
            let found = Identification {
                delay_s: Estimate::exactly(0.03),
                lag_s: Estimate::exactly(0.0),
                pause_s: None,
                mean_delay_s: Estimate::exactly(0.03),
                servo_hz: None,
                servo_damping: None,
                feedback_latency_cycles: Some(Estimate {
                    value: 1.0,
                    low,
                    high,
                }),
                axis: Axis::X,
                structure: "delay".to_owned(),
                residual_rms: 0.0,
                axes: Vec::new(),
                notes: Vec::new(),
                cycle_s: 0.004,
            };
            let text = found.fragment("a test").text();
            assert!(text.contains(says), "{text}");
        }
    }
}
