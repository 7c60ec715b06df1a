//! Whether recordings are of one rig, as far as their settings say it.

use softdock_io::recording::Recording;
use toml_edit::DocumentMut;

/// Settings that describe the rig and its spacecraft. Initial conditions and the control law may differ between logs.
/// Each is a path, the words before the value, and the unit.
const OF_THE_RIG: [(&str, &str, &str); 9] = [
    ("control.body_k.mass_kg", "mass of spacecraft K", " kg"),
    ("control.body_k.inertia_kg_m2", "inertia of K", " kg·m²"),
    ("control.body_q.mass_kg", "mass of spacecraft Q", " kg"),
    ("control.body_q.inertia_kg_m2", "inertia of Q", " kg·m²"),
    ("control.body_q.fixed", "Q fixed:", ""),
    ("control.sensor.tool_mass_kg", "mass of the tool", " kg"),
    ("control.sensor.position_m", "sensor at", " m"),
    ("control.sensor.orientation_wxyz", "sensor turned by", ""),
    ("control.robot.cycle_s", "cycle of", " s"),
];

/// Differences of settings between the first recording and each other one, as sentences with the names of the recordings.
pub(super) fn differences(logs: &[(&str, &Recording)]) -> Vec<String> {
    let Some(((first_name, first), others)) = logs.split_first() else {
        return Vec::new();
    };
    let Some(first) = settings(first) else {
        return Vec::new();
    };
    let of_other = |(name, other): &(&str, &Recording)| {
        let other = settings(other)?;
        let differ: Vec<String> = differing(&first, &other)
            .map(|((path, ..), here, there)| format!("`{path}` is {there} in place of {here}"))
            .collect();
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

/// Settings in which the first unseen recording differs from the first one of the fit, as the beginning of a sentence. None if no
/// setting differs, or there is no unseen recording.
pub(crate) fn said_first(train: &[&Recording], test: &[&Recording]) -> Option<String> {
    let (fit, unseen) = (settings(train.first()?)?, settings(test.first()?)?);
    let (mut here, mut there) = (Vec::new(), Vec::new());
    for ((_, words, unit), of_fit, of_unseen) in differing(&fit, &unseen) {
        let told = |value: &str| format!("{words} {}{unit}", value.trim_end_matches(".0"));
        here.push(told(&of_fit));
        there.push(told(&of_unseen));
    }
    (!here.is_empty()).then(|| {
        format!(
            "The test log was recorded with {}, the training log with {}",
            there.join(" and "),
            here.join(" and ")
        )
    })
}

/// Settings that differ, with both values.
fn differing(
    here: &DocumentMut,
    there: &DocumentMut,
) -> impl Iterator<
    Item = (
        &'static (&'static str, &'static str, &'static str),
        String,
        String,
    ),
> {
    OF_THE_RIG.iter().filter_map(move |setting| {
        let (here, there) = (value(here, setting.0)?, value(there, setting.0)?);
        (here != there).then_some((setting, here, there))
    })
}

/// Settings of a recording. None where it has none, as recordings of other programs.
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
        assert_eq!(said_first(&[&train], &[&slow]), None);
        let said = said_first(&[&train], &[&heavy]).unwrap();
        assert_eq!(
            said,
            "The test log was recorded with mass of spacecraft K 300 kg, the training log with mass of spacecraft K 200 kg"
        );
    }
}
