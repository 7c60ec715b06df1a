//! Description of the messages: the `ros2msg` schemas of MCAP and the columns of CSV.

use super::field::{Field, Number, Visitor, Words};
use super::topics::{Form, Row};
use std::collections::BTreeMap;
use std::convert::Infallible;
use std::fmt::Write;

/// A field and its representation in a schema.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Described {
    pub(super) field: Field,
    /// Type of its numbers in a `ros2msg` schema.
    pub(super) ros_type: &'static str,
    /// Words of a choice; empty for numbers.
    pub(super) words: &'static [&'static str],
}

/// All fields of a topic in the order of the wire.
pub(super) fn fields(form: impl Into<Form>) -> Vec<Described> {
    let mut describer = Describer::default();
    let Ok(()) = form.into().visit(&mut describer, &mut Row::default());
    describer.0
}

/// The schema of a topic (`ros2msg`), including the message types that it contains.
pub(super) fn ros2msg(form: impl Into<Form>) -> String {
    let fields = fields(form);
    let mut text = String::new();
    for described in &fields {
        let Described { field, .. } = described;
        match field.parts.message {
            Some(message) => declare(&mut text, described, message, &field.wire_name()),
            None => describe_array(&mut text, described),
        }
    }
    let mut messages = BTreeMap::new();
    for Described {
        field, ros_type, ..
    } in fields
    {
        if let Some(message) = field.parts.message {
            messages.insert(message, (field.parts.names, ros_type));
        }
    }
    for (message, (names, ros_type)) in messages {
        // Writing into a String does not fail.
        let _ = write!(text, "{SEPARATOR}\nMSG: {message}\n");
        for name in names {
            let _ = writeln!(text, "{ros_type} {name}");
        }
    }
    text
}

/// Separator before each contained message type of a schema.
pub(super) const SEPARATOR: &str =
    "================================================================================";

/// The schema that versions up to 0.1.0 wrote for the same bytes: with arrays in place of contained messages.
pub(super) fn ros2msg_of_arrays(form: Form) -> String {
    let mut text = String::new();
    for described in fields(form) {
        describe_array(&mut text, &described);
    }
    text
}

fn describe_array(text: &mut String, described: &Described) {
    let (ros_type, name) = (described.ros_type, described.field.wire_name());
    match described.field.parts.names {
        [] => declare(text, described, ros_type, &name),
        names => declare(
            text,
            described,
            &format!("{ros_type}[{}]", names.len()),
            &name,
        ),
    }
}

/// Appends one number of a field as a separate field.
pub(super) fn describe_column(text: &mut String, column: &str, described: &Described) {
    declare(text, described, described.ros_type, column);
}

fn declare(text: &mut String, described: &Described, of_type: &str, name: &str) {
    let Described {
        field,
        ros_type,
        words,
    } = described;
    let mut line = |text_line: std::fmt::Arguments<'_>| {
        // Writing into a String does not fail.
        let _ = text.write_fmt(text_line);
        text.push('\n');
    };
    line(format_args!("# {}; {}", field.about, field.unit.symbol));
    for (code, word) in words.iter().enumerate() {
        let (constant, word) = (name.to_uppercase(), word.to_uppercase());
        line(format_args!("{ros_type} {constant}_{word}={code}"));
    }
    line(format_args!("{of_type} {name}"));
}

#[derive(Default)]
struct Describer(Vec<Described>);

impl Visitor for Describer {
    type Error = Infallible;

    fn numbers<T: Number>(&mut self, field: &Field, values: &mut [T]) -> Result<(), Infallible> {
        debug_assert_eq!(values.len(), field.parts.names.len().max(1), "{field:?}");
        self.0.push(Described {
            field: *field,
            ros_type: T::ROS_TYPE,
            words: &[],
        });
        Ok(())
    }

    fn choice(&mut self, field: &Field, words: Words, _: &mut u8) -> Result<(), Infallible> {
        self.0.push(Described {
            field: *field,
            ros_type: "uint8",
            words,
        });
        Ok(())
    }
}

/// Declarations and units of a schema without the descriptions: a changed description does not make the schema another one.
pub(super) fn declarations(schema: &str) -> impl Iterator<Item = &str> {
    schema.lines().map(|line| match line.strip_prefix('#') {
        Some(about) => about.rsplit(';').next().unwrap_or_default(),
        None => line,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::topics::Topic;
    use std::collections::BTreeSet;

    #[test]
    fn a_schema_as_other_programs_read_it() {
        let expected = "# number of the cycle since boot; 1
uint64 cycle
# number of the cycle times the nominal cycle time; s
float64 time_s
# mode in which the cycle was answered; 1
uint8 MODE_IDLE=0
uint8 MODE_HOLD=1
uint8 MODE_ARMED=2
uint8 MODE_RUNNING=3
uint8 MODE_FAULT=4
uint8 MODE_JOGGING=5
uint8 mode
";
        assert!(ros2msg(Topic::Status).starts_with(expected));
    }

    #[test]
    fn numbers_that_have_names_are_messages() {
        let [named, arrays] = [
            ros2msg(Topic::Motion),
            ros2msg_of_arrays(Topic::Motion.into()),
        ];
        assert!(
            named.contains("\nsoftdock/QuaternionWxyz orientation\n"),
            "{named}"
        );
        let end = format!(
            "{SEPARATOR}\nMSG: geometry_msgs/Vector3\nfloat64 x\nfloat64 y\nfloat64 z\n\
             {SEPARATOR}\nMSG: softdock/QuaternionWxyz\nfloat64 w\nfloat64 x\nfloat64 y\nfloat64 z\n"
        );
        assert!(named.ends_with(&end), "{named}");
        assert!(arrays.contains("\nfloat64[4] orientation\n"), "{arrays}");
        let gauges = "\nint32[6] gauge_counts\n";
        assert!(ros2msg(Topic::Sensor).contains(gauges));
    }

    #[test]
    fn column_names_are_unique_and_carry_units() {
        let mut names = BTreeSet::new();
        for topic in Topic::all(true) {
            for described in fields(*topic) {
                for name in described.field.columns(&topic.prefix()) {
                    assert!(names.insert(name.clone()), "{name} twice");
                }
            }
        }
        for name in [
            "inputs_robot_ipoc_ms",
            "inputs_sensor_gauge_5_counts",
            "motion_position_x_m",
            "model_k_orientation_w",
            "law_c1_angular_z_rad_s",
            "wrench_removed_torque_y_n_m",
        ] {
            assert!(names.contains(name), "{name}");
        }
    }

    /// The sensor's schema in earlier recordings and in new ones.
    #[test]
    fn the_sensor_has_a_form_of_16_and_of_32_bits() {
        let [now, before] = Topic::Sensor.forms().map(ros2msg);
        for (text, status, gauges) in [
            (now, "\nuint32 status\n", "\nint32[6] gauge_counts\n"),
            (before, "\nuint16 status\n", "\nint16[6] gauge_counts\n"),
        ] {
            assert!(text.contains(status) && text.contains(gauges), "{text}");
        }
    }

    #[test]
    fn words_about_a_field_may_change_and_its_unit_may_not() {
        let same = |a, b| declarations(a).eq(declarations(b));
        let schema = "# time of the cycle; s\nfloat64 time_s\n";
        assert!(same(schema, "# when; it was; s\nfloat64 time_s\n"));
        assert!(!same(schema, "# time of the cycle; ms\nfloat64 time_s\n"));
        assert!(!same(schema, "# time of the cycle; s\nfloat32 time_s\n"));
    }

    #[test]
    fn both_spacecraft_share_one_schema() {
        assert_eq!(ros2msg(Topic::BodyK), ros2msg(Topic::BodyQ));
        let [k, q] = [Topic::BodyK, Topic::BodyQ].map(|body| body.in_single().schema_name());
        assert_eq!(
            (k.as_str(), q.as_str()),
            ("softdock/msg/Body32", "softdock/msg/Body32")
        );
    }
}
