//! A calibration as settings of the board.

use super::Calibration;
use crate::fragment::{Fragment, Setting, half_widths};
use toml_edit::{Array, Value};

/// The section of the settings.
const SECTION: &[&str] = &["control", "sensor"];

impl Calibration {
    /// The settings that follow; `origin` says where the readings come from.
    pub fn fragment(&self, origin: &str) -> Fragment {
        let of = &self.intervals;
        let mut settings = vec![
            Setting::list("bias", &self.bias, half_widths(&of.bias)),
            Setting::list("gravity_m_s2", &self.gravity_m_s2, self.gravity_words()),
            Setting::number("tool_mass_kg", self.mass_kg, of.mass_kg),
            Setting::list("tool_com_m", &self.com_m, half_widths(&of.com_m)),
            // The whole torque of the weight follows from the centre of mass: an older torque beside it would count twice.
            Setting::list("gravity_torque_n_m", &[0.0; 3], "held by tool_com_m"),
        ];
        if let Some(inertia) = &self.inertia_kg_m2 {
            let row = |row: &[f64; 3]| Setting::list("", row, "").value;
            let rows: Array = inertia.iter().map(row).collect();
            settings.push(Setting {
                key: "tool_inertia_kg_m2",
                value: Value::Array(rows),
                remark: "about the centre of mass; acts with dynamic_compensation = \
                         \"load_reaction\""
                    .to_owned(),
            });
        }
        Fragment {
            section: SECTION,
            origin: vec![
                format!("Calibration of the sensor from {origin}:"),
                format!(
                    "{} {}, {} left out, {:.3} N rms left of a force.",
                    self.used,
                    if self.pose_age_s.is_some() {
                        "parts of a motion"
                    } else {
                        "poses"
                    },
                    self.left_out.len(),
                    self.residual_rms_n
                ),
            ],
            settings,
        }
    }

    fn gravity_words(&self) -> String {
        match self.intervals.gravity_rad {
            Some([first, second]) => format!(
                "found; 95 %: direction ± {:.2}°",
                first.max(second).to_degrees()
            ),
            None => "as given".to_owned(),
        }
    }
}
