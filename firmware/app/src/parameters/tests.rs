use super::*;
use proptest::prelude::*;
use softdock_link::service::PAYLOAD_MAX_BYTES;

/// The parts of an entry that a test compares.
#[derive(Clone, Debug, PartialEq)]
struct Kept {
    path: String,
    form: Form,
    range: Option<(f64, f64)>,
    unit: String,
    help: String,
    words: Vec<String, 16>,
}

fn all() -> std::vec::Vec<Kept> {
    let settings = BoardSettings::default();
    let keep = |entry: Entry<'_>| Kept {
        path: entry.path.into(),
        form: entry.form,
        range: entry.range,
        unit: entry.unit.into(),
        help: entry.help.into(),
        words: entry.words.iter().map(|word| (*word).into()).collect(),
    };
    (0..count())
        .map(|index| with_entry(&settings, index, keep).unwrap())
        .collect()
}

fn named(path: &str) -> Kept {
    all().into_iter().find(|kept| kept.path == path).unwrap()
}

#[test]
fn settings_are_told_with_unit_range_and_meaning() {
    let mass = named("control.sensor.tool_mass_kg");
    assert_eq!((mass.form, mass.unit.as_str()), (Form::Real, "kg"));
    assert_eq!(mass.range, Some((0.0, 2000.0)));
    assert_eq!(mass.help, " Mass of everything beyond the sensor, kg.\n");
    let sensor = named("can.sensor");
    assert_eq!((sensor.form, sensor.range), (Form::Word, None));
    assert_eq!(sensor.words, ["ati", "sri"]);
    let matrix = Form::Array {
        rows: 3,
        columns: 3,
    };
    let inertia = named("control.body_k.inertia_kg_m2");
    assert_eq!((inertia.form, inertia.unit.as_str()), (matrix, "kg·m²"));
    assert_eq!(named("can.base_id").range, Some((0.0, 127.0)));
    // Only the type bounds it.
    let late = named("control.robot.late_answers_fault");
    assert_eq!(late.range, Some((0.0, f64::from(u32::MAX))));
}

/// A range may depend on other settings.
#[test]
fn a_range_is_that_beside_the_settings_in_use() {
    let mut settings = BoardSettings::default();
    settings.control.robot.cycle_s = 0.012;
    let path = "can.sample_wait_s";
    let index = all().iter().position(|kept| kept.path == path).unwrap();
    let range = with_entry(&settings, index as u16, |entry| entry.range);
    assert_eq!(range, Some(Some((0.0, 0.006))));
}

#[test]
fn every_setting_is_described_and_every_number_has_a_range() {
    let all = all();
    assert!(all.len() > 90, "{}", all.len());
    for kept in &all {
        assert!(
            !kept.help.trim().is_empty(),
            "{}: wrap its struct in `described!` and name it in description.rs",
            kept.path
        );
        let number = matches!(kept.form, Form::Real | Form::Whole | Form::Array { .. });
        assert_eq!(number, kept.range.is_some(), "{}", kept.path);
        if let Some((low, high)) = kept.range {
            assert!(low < high, "{kept:?}");
        }
    }
    let mut paths: std::vec::Vec<_> = all.iter().map(|kept| &kept.path).collect();
    paths.sort();
    paths.dedup();
    assert_eq!(paths.len(), all.len(), "two settings have one name");
}

#[test]
fn every_entry_fits_into_a_frame_and_the_settings_into_their_room() {
    let settings = BoardSettings::default();
    for index in 0..count() {
        let length = with_entry(&settings, index, |entry| {
            postcard::to_slice(&entry, &mut [0; 4 * PAYLOAD_MAX_BYTES])
                .unwrap()
                .len()
        });
        assert!(length.unwrap() + 8 < PAYLOAD_MAX_BYTES, "{index}");
    }
    // Names of full length as well.
    let bytes = bytes_of(&settings).unwrap().len() + 9 * 32;
    assert!(bytes < SETTINGS_BYTES, "{bytes}");
    assert!(with_entry(&settings, count(), |_| ()).is_none());
}

/// Each value can be read, and written back without a change.
#[test]
fn what_is_got_can_be_set_again() {
    let mut settings = BoardSettings::default();
    settings.rsi.robot_ip = crate::settings::Text::try_from("10.0.0.9").unwrap();
    settings.control.body_k.inertia_kg_m2[2][1] = 1.25;
    settings.can.saturation_counts = -7;
    let mut copy = BoardSettings::default();
    for kept in all() {
        let outcome = get(&settings, &kept.path, |value| {
            set(&mut copy, &kept.path, &value)
        });
        assert_eq!(outcome, Ok(Ok(())), "{}", kept.path);
    }
    assert_eq!(copy, settings);
}

#[test]
fn what_does_not_fit_changes_nothing() {
    let mut settings = BoardSettings::default();
    for (path, value, refusal) in [
        ("control", Value::Real(1.0), Refusal::UnknownName),
        (
            "control.sensor.bias.0",
            Value::Real(1.0),
            Refusal::UnknownName,
        ),
        ("", Value::Real(1.0), Refusal::UnknownName),
        ("can.base_id", Value::Real(1.0), Refusal::WrongForm),
        ("can.base_id", Value::Whole(256), Refusal::TooLarge),
        ("can.sensor", Value::Text("atj"), Refusal::UnknownWord),
        (
            "rsi.sentype",
            Value::Text("a text that is longer than any name of an element"),
            Refusal::UnknownWord,
        ),
        (
            "control.sensor.bias",
            Value::Array(Vec::from_slice(&[1.0; 5]).unwrap()),
            Refusal::WrongForm,
        ),
    ] {
        assert_eq!(set(&mut settings, path, &value), Err(refusal), "{path}");
    }
    assert_eq!(settings, BoardSettings::default());
}

#[test]
fn what_cannot_be_a_setting_is_an_error() {
    assert_eq!(walk::count::<Option<u8>>(&[0]), Err(walk::NO_SETTING));
    assert_eq!(walk::count::<[u8; 2]>(&[0, 0]), Err(walk::NO_SETTING));
    let too_short = Err(postcard::Error::DeserializeUnexpectedEnd);
    assert_eq!(walk::count::<u32>(&[]), too_short);
}

proptest! {
    /// A number that is set is the only thing that changes.
    #[test]
    fn only_the_named_setting_changes(index in 0_u16..200, number: f64) {
        prop_assume!(!number.is_nan());
        let settings = BoardSettings::default();
        let Some((path, form)) = with_entry(&settings, index, |e| (e.path.to_owned(), e.form)) else {
            return Ok(());
        };
        prop_assume!(form == Form::Real);
        let mut changed = settings.clone();
        set(&mut changed, &path, &Value::Real(number)).unwrap();
        prop_assert_eq!(get(&changed, &path, |v| v == Value::Real(number)), Ok(true));
        get(&settings, &path, |old| set(&mut changed, &path, &old)).unwrap().unwrap();
        prop_assert_eq!(changed, settings);
    }
}
