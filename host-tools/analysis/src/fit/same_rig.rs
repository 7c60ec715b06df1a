//! Whether recordings are of one rig, as far as their settings say it.

use softdock_io::recording::Recording;
use toml_edit::DocumentMut;

/// Settings that describe the rig and its spacecraft; what a test starts with and the law may differ.
const OF_THE_RIG: [&str; 9] = [
    "control.body_k.mass_kg",
    "control.body_k.inertia_kg_m2",
    "control.body_q.mass_kg",
    "control.body_q.inertia_kg_m2",
    "control.body_q.fixed",
    "control.sensor.tool_mass_kg",
    "control.sensor.position_m",
    "control.sensor.orientation_wxyz",
    "control.robot.cycle_s",
];

/// What differs between the first recording and the others, in sentences; names go with them.
pub(super) fn differences(logs: &[(&str, &Recording)]) -> Vec<String> {
    let Some(((first_name, first), others)) = logs.split_first() else {
        return Vec::new();
    };
    let Some(first) = settings(first) else {
        return Vec::new();
    };
    let of_other = |(name, other): &(&str, &Recording)| {
        let other = settings(other)?;
        let differ = OF_THE_RIG.iter().filter_map(|path| {
            let (here, there) = (value(&first, path)?, value(&other, path)?);
            (here != there).then(|| format!("`{path}` is {there} in place of {here}"))
        });
        let differ: Vec<String> = differ.collect();
        (!differ.is_empty()).then(|| {
            format!(
                "{name} is of another rig or spacecraft than {first_name}: {}; what differs may show as an error of \
                 the model",
                differ.join(", ")
            )
        })
    };
    others.iter().filter_map(of_other).collect()
}

/// None where a recording has no settings, as those of other programs.
fn settings(recording: &Recording) -> Option<DocumentMut> {
    let text = recording.header.settings_toml.trim();
    (!text.is_empty()).then(|| text.parse().ok()).flatten()
}

fn value(settings: &DocumentMut, path: &str) -> Option<String> {
    let mut item = settings.as_item();
    for key in path.split('.') {
        item = item.get(key)?;
    }
    let text = item.to_string();
    // A list is written over several lines.
    Some(text.split_whitespace().collect::<Vec<_>>().join(" "))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn log(settings: &str) -> Recording {
        let mut recording = Recording::default();
        recording.header.settings_toml = settings.to_owned();
        recording
    }

    #[test]
    fn another_mass_is_another_rig_and_another_speed_is_not() {
        let train = log("[control.body_k]\nmass_kg = 200.0\nvelocity_m_s = [0.04, 0.0, 0.0]\n");
        let slow = log("[control.body_k]\nmass_kg = 200.0\nvelocity_m_s = [0.01, 0.0, 0.0]\n");
        let heavy = log("[control.body_k]\nmass_kg = 300.0\n");
        let foreign = log("");
        let all = [
            ("train", &train),
            ("slow", &slow),
            ("heavy", &heavy),
            ("foreign", &foreign),
        ];
        let found = differences(&all);
        assert_eq!(found.len(), 1, "{found:?}");
        assert!(found[0].starts_with("heavy is of another rig"), "{found:?}");
        assert!(found[0].contains("is 300.0 in place of 200.0"), "{found:?}");
    }
}
