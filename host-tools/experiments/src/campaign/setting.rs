//! Settings of a scenario by their dotted names, as in its file: `rig.mechanism.walls[0].point_m[2]`.

use crate::scenario::Scenario;
use anyhow::{Context, Result, bail};
use serde_json::{Map, Value};
use softdock_io::input::nearest;

/// Suffixes of names and their units; a longer suffix stands before those that it ends with.
const UNITS: &[(&str, &str)] = &[
    ("_n_s_per_m", "N·s/m"),
    ("_n_per_m", "N/m"),
    ("_n_per_s", "N/s"),
    ("_nm_per_s", "N·m/s"),
    ("_n_m_s", "N·m·s"),
    ("_n_m", "N·m"),
    ("_nm", "N·m"),
    ("_kg_m2", "kg·m²"),
    ("_rad_s2", "rad/s²"),
    ("_rad_s", "rad/s"),
    ("_m_s2", "m/s²"),
    ("_m_s", "m/s"),
    ("_rad", "rad"),
    ("_cycles", "cycles"),
    ("_percent", "%"),
    ("_hz", "Hz"),
    ("_kg", "kg"),
    ("_us", "µs"),
    ("_n", "N"),
    ("_m", "m"),
    ("_s", "s"),
];

/// Unit of a setting or outcome, by the end of its name; `1` for none.
pub fn unit(name: &str) -> &'static str {
    let last = name.rsplit('.').next().unwrap_or(name);
    let name = last.split('[').next().unwrap_or(last);
    let found = UNITS.iter().find(|(ending, _)| name.ends_with(ending));
    found.map_or("1", |(_, unit)| unit)
}

/// A part of a dotted name.
#[derive(Clone, Debug, PartialEq, Eq)]
enum Step {
    Key(String),
    Place(usize),
}

/// A setting's dotted name.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SettingName(Vec<Step>);

impl SettingName {
    /// Reads a name.
    ///
    /// # Errors
    /// The name is not made of words with dots between and indices in brackets.
    pub fn parse(name: &str) -> Result<Self> {
        let mut steps = Vec::new();
        for part in name.split('.') {
            let (key, places) = part.split_at(part.find('[').unwrap_or(part.len()));
            let places = places
                .strip_prefix('[')
                .map_or(Some(""), |p| p.strip_suffix(']'));
            let places = places.filter(|_| !key.is_empty()).with_context(|| {
                format!("`{name}`: expected words with dots between, as in rig.mechanism.walls[0].stiffness_n_per_m")
            })?;
            steps.push(Step::Key(key.to_owned()));
            for place in places.split("][").filter(|place| !place.is_empty()) {
                let place = place.parse();
                steps.push(Step::Place(place.with_context(|| {
                    format!("`{name}`: expected a whole number in brackets")
                })?));
            }
        }
        Ok(Self(steps))
    }

    /// Whether the other name is the same setting, or a part of this one.
    pub(super) fn contains(&self, other: &Self) -> bool {
        other.0.starts_with(&self.0)
    }

    /// Sets the value. A key that does not exist is added: reading the scenario shows whether it is known.
    fn set(&self, tree: &mut Value, value: Value) -> Result<()> {
        let mut at = tree;
        for step in &self.0 {
            if at.is_null() {
                *at = Value::Object(Map::new());
            }
            at = match (step, at) {
                (Step::Key(key), Value::Object(map)) => {
                    map.entry(key.as_str()).or_insert(Value::Null)
                }
                (Step::Place(place), Value::Array(values)) => {
                    let count = values.len();
                    values.get_mut(*place).with_context(|| {
                        format!(
                            "there is no element [{place}]: the list has {count}, counted from 0"
                        )
                    })?
                }
                (Step::Key(key), _) => bail!("what stands before `{key}` has no parts with names"),
                (Step::Place(place), _) => bail!("what stands before [{place}] is no list"),
            };
        }
        // A drawn whole number replaces an integer of the scenario as an integer.
        *at = match (&*at, value.as_f64()) {
            (Value::Number(now), Some(drawn)) if !now.is_f64() && drawn.fract() == 0.0 => {
                Value::from(drawn as i64)
            }
            _ => value,
        };
        Ok(())
    }
}

/// A scenario whose settings can be changed by name.
#[derive(Clone, Debug)]
pub struct Settings(Value);

impl Settings {
    /// The settings of a scenario.
    ///
    /// # Errors
    /// Never for a scenario that was read from a file.
    pub fn of(scenario: &Scenario) -> Result<Self> {
        Ok(Self(serde_json::to_value(scenario)?))
    }

    /// The scenario with other values, not validated.
    ///
    /// # Errors
    /// A setting does not exist (the nearest name is given), or does not take the value.
    pub fn with<'a>(
        &self,
        values: impl IntoIterator<Item = (&'a SettingName, Value)>,
    ) -> Result<Scenario> {
        let mut tree = self.0.clone();
        for (name, value) in values {
            name.set(&mut tree, value)?;
        }
        Ok(serde_json::from_value(tree)?)
    }

    /// Checks that a setting exists and takes a value; `name` is that of the file.
    ///
    /// # Errors
    /// As [`with`](Self::with).
    pub fn try_one(&self, name: &str, value: &Value) -> Result<Scenario> {
        let setting = SettingName::parse(name)?;
        self.with([(&setting, value.clone())]).map_err(|error| {
            let mut known = Vec::new();
            names(&self.0, "", &mut known);
            match nearest(name, known.iter().map(String::as_str)) {
                Some(near) if near != name => error.context(format!(
                    "no setting `{name}` with the value {value}; did you mean `{near}`?"
                )),
                _ => error.context(format!("`{name}` cannot be {value}")),
            }
        })
    }
}

/// Dotted names of all values in a tree.
fn names(tree: &Value, prefix: &str, found: &mut Vec<String>) {
    match tree {
        Value::Object(map) => {
            for (key, value) in map {
                let dot = if prefix.is_empty() { "" } else { "." };
                names(value, &format!("{prefix}{dot}{key}"), found);
            }
        }
        Value::Array(values) => {
            for (place, value) in values.iter().enumerate() {
                names(value, &format!("{prefix}[{place}]"), found);
            }
        }
        _ => found.push(prefix.to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn spring_rod() -> Settings {
        Settings::of(&Scenario::spring_rod().unwrap()).unwrap()
    }

    fn error(name: &str, value: Value) -> String {
        format!("{:#}", spring_rod().try_one(name, &value).unwrap_err())
    }

    #[test]
    fn nothing_is_lost_on_the_way() {
        let scenario = Scenario::spring_rod().unwrap();
        let same = spring_rod().with([]).unwrap();
        assert_eq!(same, scenario);
    }

    #[test]
    fn any_setting_has_a_name() {
        let changed = |name, value: Value| spring_rod().try_one(name, &value).unwrap();
        let scenario = changed("rig.mechanism.walls[0].point_m[2]", json!(0.85));
        assert_eq!(scenario.rig.mechanism.walls[0].point_m, [1.2045, 0.1, 0.85]);
        let scenario = changed("board.control.body_k.inertia_kg_m2[1][1]", json!(99.0));
        assert_eq!(scenario.board.control.body_k.inertia_kg_m2[1][1], 99.0);
        let scenario = changed("board.control.delay.law", json!("predictor"));
        assert_eq!(scenario.board.control.delay.law.name(), "predictor");
        // A setting that the file leaves out.
        let scenario = changed("rig.sensor.low_pass_hz", json!(80.0));
        assert_eq!(scenario.rig.sensor.low_pass_hz, Some(80.0));
        // A drawn number for a setting that is a count.
        let scenario = changed("rig.robot.timeout_cycles", json!(7.0));
        assert_eq!(scenario.rig.robot.timeout_cycles, 7);
    }

    #[test]
    fn a_typo_gets_a_suggestion() {
        let typo = error("rig.robot.actuator.dealy_s", json!(0.03));
        assert!(
            typo.contains("did you mean `rig.robot.actuator.delay_s`"),
            "{typo}"
        );
        let typo = error("rig.mechanism.wals[0].stiffness_n_per_m", json!(1e5));
        assert!(
            typo.contains("`rig.mechanism.walls[0].stiffness_n_per_m`"),
            "{typo}"
        );
        let place = error("rig.mechanism.walls[3].stiffness_n_per_m", json!(1e5));
        assert!(place.contains("the list has 1"), "{place}");
        let kind = error("rig.robot.actuator.delay_s", json!("late"));
        assert!(kind.contains("cannot be \"late\""), "{kind}");
        let name = error("rig..delay_s", json!(0.0));
        assert!(name.contains("words with dots between"), "{name}");
    }

    #[test]
    fn names_say_their_units() {
        assert_eq!(unit("rig.mechanism.walls[0].stiffness_n_per_m"), "N/m");
        assert_eq!(unit("board.control.body_k.velocity_m_s[0]"), "m/s");
        assert_eq!(unit("peak_force_n"), "N");
        assert_eq!(unit("restitution"), "1");
    }
}
