//! Parameters of a docking mechanism that a fit may change: stiffness, damping, friction and preload. Lengths, widths and slopes
//! are measured with a ruler.

use serde_json::Value;
use softdock_mechanism::DockingSettings;

/// Endings of their names, with units; the first match counts.
const MOVED: [(&str, &str); 9] = [
    ("_n_per_m", "N/m"),
    ("_n_per_m15", "N/m^1.5"),
    ("_n_s_per_m", "N·s/m"),
    ("_s_per_m", "s/m"),
    ("_nm_per_rad", "N·m/rad"),
    ("_nm_s_per_rad", "N·m·s/rad"),
    ("_n", "N"),
    ("critical_speed_m_s", "m/s"),
    ("_coefficient", "-"),
];

/// One such parameter.
#[derive(Clone, Debug, PartialEq)]
pub struct DockingNumber {
    /// Its place in the mechanism, as a JSON pointer (RFC 6901).
    pub pointer: String,
    /// SI unit, `-` if it has none.
    pub unit: &'static str,
    /// Its value.
    pub value: f64,
}

impl DockingNumber {
    /// Its name in tables.
    pub fn name(&self, docking: usize) -> String {
        format!(
            "contact.docking[{docking}].kind{}",
            self.pointer.replace('/', ".")
        )
    }
}

/// All such parameters of a mechanism, in the order of their names.
pub fn numbers(docking: &DockingSettings) -> Vec<DockingNumber> {
    let mut all = Vec::new();
    if let Ok(kind) = serde_json::to_value(docking.kind) {
        collect(&kind, "", &mut all);
    }
    all
}

fn collect(value: &Value, at: &str, all: &mut Vec<DockingNumber>) {
    let Value::Object(keys) = value else { return };
    for (key, value) in keys {
        let pointer = format!("{at}/{key}");
        let moved = MOVED.iter().find(|(ending, _)| key.ends_with(ending));
        match (value.as_f64(), moved) {
            (Some(value), Some((_, unit))) => all.push(DockingNumber {
                pointer,
                unit,
                value,
            }),
            _ => collect(value, &pointer, all),
        }
    }
}

/// Sets the parameter at a pointer; a pointer that does not exist is ignored.
pub fn set(docking: &mut DockingSettings, pointer: &str, value: f64) {
    let Ok(mut kind) = serde_json::to_value(docking.kind) else {
        return;
    };
    if let Some(number) = kind.pointer_mut(pointer) {
        *number = value.into();
    }
    if let Ok(kind) = serde_json::from_value(kind) {
        docking.kind = kind;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DOCKING: &str = "
        position_m = [2.0, 0.0, 0.0]
        [kind.probe_cone]
        half_angle_rad = 0.9
        mouth_radius_m = 0.25
        head_radius_m = 0.04
        [kind.probe_cone.surface]
        stiffness_n_per_m = 20000.0
        friction_coefficient = 0.12
        [kind.probe_cone.socket]
        capture_depth_m = 0.006
        capture_radius_m = 0.008
        latch_stiffness_n_per_m = 50000.0";

    #[test]
    fn what_is_stiff_or_rough_moves_and_what_is_long_stays() {
        let mut docking: DockingSettings = toml_edit::de::from_str(DOCKING).unwrap();
        let all = numbers(&docking);
        let named = |name: &str| all.iter().find(|n| n.name(0).ends_with(name));
        assert_eq!(named("surface.stiffness_n_per_m").unwrap().unit, "N/m");
        assert_eq!(named("friction_coefficient").unwrap().value, 0.12);
        assert_eq!(named("latch_stiffness_n_per_m").unwrap().value, 5e4);
        assert!(named("half_angle_rad").is_none() && named("capture_radius_m").is_none());
        for number in &all {
            set(&mut docking, &number.pointer, 2.0 * number.value);
        }
        for (before, after) in all.iter().zip(numbers(&docking)) {
            assert_eq!(after.value, 2.0 * before.value, "{}", before.pointer);
        }
    }
}
