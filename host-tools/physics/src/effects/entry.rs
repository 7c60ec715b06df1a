//! Catalogue entries: what is known about an effect before any data.

use super::formula::ActsOn;
use super::mechanism::ACTS_AT;
use super::{Law, Slide};
use std::collections::BTreeMap;

/// Whether a subset of the linear parameters, given by their places, makes sense beside the effects that are present (ids).
pub type IsWhole = fn(parameters: &[usize], beside: &dyn Fn(&str) -> bool) -> bool;

/// An effect's catalogue entry: all information on the effect.
#[derive(Clone, Copy, Debug, serde::Serialize)]
pub struct Effect {
    /// Stable identifier, as used in model files and verdicts.
    pub id: &'static str,
    /// Short name for people.
    pub title: &'static str,
    /// What it does, in one line.
    pub summary: &'static str,
    /// Where in the chain it acts.
    pub group: Group,
    /// What a verdict may say when it fits.
    pub naming: Naming,
    /// The equation, in the symbols of `parameters`.
    pub equation: &'static str,
    /// Where the equation comes from.
    pub source: &'static str,
    /// What it leaves in a recording.
    pub signature: &'static str,
    /// How large it usually is on a rig.
    pub typical: &'static str,
    /// Parameters, units in their names.
    pub parameters: &'static [Parameter],
    /// Ids of effects that leave a similar signature.
    pub confused_with: &'static [&'static str],
    /// The experiment that tells it from those.
    pub tell_apart: &'static str,
    /// How it acts.
    #[serde(skip)]
    pub law: Law,
    /// Its linear parameters are independent: some may be absent.
    #[serde(skip)]
    pub separable: bool,
    /// Effects of which it is a detail. It is then looked for only beside what is found. Each comes with the linear parameters,
    /// in their order, with which this effect equals that one: where the logs do not determine the detail, that one takes its
    /// place.
    #[serde(skip)]
    pub detail_of: &'static [(&'static str, &'static [f64])],
    /// Whether some of its parameters make sense without the others.
    #[serde(skip)]
    pub is_whole: IsWhole,
    /// Kind of effect of which it is one form.
    #[serde(skip)]
    pub kind: Option<Kind>,
    /// A parameter whose absolute value is bounded by a parameter of another effect.
    #[serde(skip)]
    pub difference_of: Option<Difference>,
}

/// A parameter by which another effect's parameter is larger in one direction and smaller in the other. Its absolute value cannot
/// exceed that parameter: what brakes would otherwise drive in one direction.
#[derive(Clone, Copy, Debug)]
pub struct Difference {
    /// Its place.
    pub place: usize,
    /// Id of the other effect.
    pub of: &'static str,
    /// Place of its parameter.
    pub of_place: usize,
}

impl Effect {
    /// The defaults of an entry.
    pub const PLAIN: Self = Self {
        id: "",
        title: "",
        summary: "",
        group: Group::Mechanism,
        naming: Naming::Cause,
        equation: "",
        source: "",
        signature: "",
        typical: "",
        parameters: &[],
        confused_with: &[],
        tell_apart: "",
        law: Law::ClockOffset(|_| 0.0),
        separable: false,
        detail_of: &[],
        is_whole: |_, _| true,
        kind: None,
        difference_of: None,
    };

    /// Its parameters where the guide is a bearing.
    pub fn on_a_bearing(&self) -> Vec<Parameter> {
        let turns = matches!(self.law, Law::Guide(_) | Law::Spring(_));
        let of = |p: &Parameter| if turns { p.of_a_bearing() } else { *p };
        self.parameters.iter().map(of).collect()
    }

    /// Whether it is a detail of other effects.
    pub const fn is_detail(&self) -> bool {
        !self.detail_of.is_empty()
    }

    /// Whether it exists only for a bearing.
    pub fn is_of_a_bearing(&self) -> bool {
        matches!(self.law, Law::Bearing(_))
    }

    /// Whether it is a law of a contact with a wall.
    pub fn is_of_a_contact(&self) -> bool {
        match self.law {
            Law::Push(_) | Law::Depth(_) => true,
            Law::Formula(law) => law.acts_on == ActsOn::Contact,
            _ => false,
        }
    }

    /// Whether it changes only the place of a mass, not its size.
    pub fn is_centre_of_mass_alone(&self) -> bool {
        !self.parameters.is_empty() && self.parameters.iter().all(|p| p.unit == "m")
    }

    /// Whether it is the weight of a body that turns about a bearing: a torque there that depends on the angle.
    pub fn is_weight_about_bearing(&self) -> bool {
        self.is_of_a_bearing() && self.acts_by_position(true)
    }

    /// Whether it depends on the position, and not only on velocity and acceleration. `turns`: the moving side turns about a
    /// bearing, and the weight of a tool with it.
    pub fn acts_by_position(&self, turns: bool) -> bool {
        match self.law {
            Law::Spring(_) => true,
            Law::Tool(_) => turns,
            Law::Guide(guide) | Law::Bearing(guide) => {
                let amounts = vec![1.0; self.parameters.len()];
                let at = |position: f64| {
                    let slide = Slide {
                        position,
                        ..Slide::at_velocity(0.1)
                    };
                    (guide.force)(&amounts, &slide).to_bits()
                };
                at(0.0) != at(0.3)
            }
            _ => false,
        }
    }

    /// Whether it exists only for a docking mechanism.
    pub fn is_of_a_docking(&self) -> bool {
        matches!(self.law, Law::Docking(_))
    }

    /// Whether it exists only for a drive whose commands are recorded instead of a sensor's readings.
    pub fn is_of_a_drive(&self) -> bool {
        matches!(self.law, Law::CommandGain(_))
    }

    /// Whether it multiplies all axes of a wrench by one factor.
    pub fn is_gain_of_all(&self) -> bool {
        match self.law {
            Law::SensorGain(_) => self.parameters.iter().any(|p| p.common),
            Law::CommandGain(_) => true,
            _ => false,
        }
    }

    /// Place of a parameter.
    pub fn place(&self, name: &str) -> Option<usize> {
        self.parameters.iter().position(|p| p.name == name)
    }

    /// Values in the order of the parameters; missing ones have their default.
    pub fn values(&self, given: &BTreeMap<String, f64>) -> Vec<f64> {
        let value = |p: &Parameter| given.get(p.name).copied().unwrap_or(p.default());
        self.parameters.iter().map(value).collect()
    }
}

/// Two entries with one id are the same effect.
impl PartialEq for Effect {
    fn eq(&self, other: &Self) -> bool {
        self.id == other.id
    }
}

/// One parameter of an effect.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Parameter {
    /// Name with its SI unit as suffix.
    pub name: &'static str,
    /// SI unit, `-` if it has none.
    pub unit: &'static str,
    /// Smallest plausible value; not negative where physics forbids a negative value.
    pub low: f64,
    /// Largest plausible value.
    pub high: f64,
    /// How it enters the law.
    #[serde(skip)]
    pub role: Role,
    /// Range from which a simulated rig draws the value of a hidden effect; `None`: it has the default.
    #[serde(skip)]
    pub hidden: Option<Draw>,
    /// Value in the picture of the effect, large enough to be seen.
    #[serde(skip)]
    pub pictured: f64,
    /// Least value relative to the nominal tool's mass, or moment of inertia. 0: no such bound.
    #[serde(skip)]
    pub of_the_tool: f64,
    /// It acts like all other linear parameters at once: a diagnosis names it alone, or the others.
    #[serde(skip)]
    pub common: bool,
    /// What the values 0, 1, .. of a choice mean.
    pub words: &'static [&'static str],
    /// Plausible range for rotations, in their unit, where it differs.
    pub of_rotations: Option<[f64; 2]>,
}

/// How a parameter enters the law of its effect.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Role {
    /// It multiplies its part of the law; at 0 that part is absent.
    Linear,
    /// It enters the law nonlinearly, as a shape.
    Shape(SearchStart),
    /// It selects the form of the law: no physical size of interest, so that it has no interval.
    Form(SearchStart),
}

/// Distance of a bearing's sliding surfaces from its axis, m: a length along a guide, divided by it, is an angle of a bearing.
const LEVER_M: f64 = 0.05;
/// Angle per length, rad/m.
const PER_LEVER: f64 = 1.0 / LEVER_M;

impl Role {
    /// The same role with all values multiplied by `share`.
    fn times(self, share: f64) -> Self {
        match self {
            Self::Linear => self,
            Self::Shape(tried) => Self::Shape(tried.times(share)),
            Self::Form(tried) => Self::Form(tried.times(share)),
        }
    }
}

/// Where the search for a parameter begins.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SearchStart {
    /// Values that are tried.
    pub values: &'static [f64],
    /// Value if a model file does not give one.
    pub default: f64,
    /// It may take any value between those that are tried.
    pub continuous: bool,
    /// Largest value in a search. An effect that fits only with a larger one imitates other effects; a fit that the user asks for
    /// may go beyond.
    pub most: f64,
}

impl SearchStart {
    const fn new(values: &'static [f64], default: f64, continuous: bool) -> Self {
        Self {
            values,
            default,
            continuous,
            most: f64::INFINITY,
        }
    }

    fn times(self, share: f64) -> Self {
        let values = self.values.iter().map(|value| share * value);
        Self {
            values: Box::leak(values.collect()),
            default: share * self.default,
            most: share * self.most,
            ..self
        }
    }
}

/// Range of sizes that a simulated rig hides.
///
/// They are chosen for the diagnosis scenario (200 kg at 40 mm/s between two springs of 6 kN/m, noise of 0.2 N and 1 µm): each is
/// several times the noise in the channel that shows it, and none destabilises the closed loop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Draw {
    /// Smallest.
    pub low: f64,
    /// Largest.
    pub high: f64,
    /// Either sign.
    pub signed: bool,
    /// Drawn values are multiples of this; 0: any.
    pub step: f64,
}

impl Parameter {
    /// A linear parameter with its unit and plausible range.
    pub const fn new(name: &'static str, unit: &'static str, low: f64, high: f64) -> Self {
        Self {
            name,
            unit,
            low,
            high,
            role: Role::Linear,
            hidden: None,
            pictured: 0.0,
            of_the_tool: 0.0,
            common: false,
            words: &[],
            of_rotations: None,
        }
    }

    /// Has another range for rotations: joints and shafts are not as fast in radians as flanges in metres.
    pub(super) const fn of_rotations(self, low: f64, high: f64) -> Self {
        Self {
            of_rotations: Some([low, high]),
            ..self
        }
    }

    /// Limits the search for a shape to a value; a fit may go up to the end of the range.
    pub(super) const fn searched_to(mut self, most: f64) -> Self {
        if let Role::Shape(tried) = &mut self.role {
            tried.most = most;
        }
        self
    }

    /// A choice of the form of the law: 0 is the first of these words, the usual one, 1 the second ..
    pub const fn choice(name: &'static str, words: &'static [&'static str]) -> Self {
        let values: &[f64] = match words.len() {
            2 => &[0.0, 1.0],
            _ => &[0.0, 1.0, 2.0],
        };
        let new = Self::new(name, "-", 0.0, values.len() as f64 - 1.0).form(values, 0.0);
        Self { words, ..new }
    }

    /// Makes it a shape of the law.
    pub const fn shape(self, values: &'static [f64], default: f64) -> Self {
        let role = Role::Shape(SearchStart::new(values, default, true));
        Self { role, ..self }
    }

    /// Makes it a delay or a time constant; the search tries from a part of a cycle of 4 ms to ten of them.
    pub const fn delay_or_lag(self) -> Self {
        self.shape(&[2e-4, 5e-4, 1e-3, 2e-3, 4e-3, 8e-3, 1.6e-2, 4e-2], 0.0)
    }

    /// Makes it a form of the law, with the given values only.
    pub const fn form(self, values: &'static [f64], default: f64) -> Self {
        let role = Role::Form(SearchStart::new(values, default, false));
        Self { role, ..self }
    }

    /// Makes it a form with a continuous size.
    pub const fn form_size(self, values: &'static [f64], default: f64) -> Self {
        let role = Role::Form(SearchStart::new(values, default, true));
        Self { role, ..self }
    }

    /// Sets the range from which a simulated rig draws a hidden value.
    pub const fn hidden(self, low: f64, high: f64) -> Self {
        let (signed, step) = (false, 0.0);
        Self {
            hidden: Some(Draw {
                low,
                high,
                signed,
                step,
            }),
            ..self
        }
    }

    /// Hidden values have either sign.
    pub const fn either_sign(mut self) -> Self {
        if let Some(draw) = &mut self.hidden {
            draw.signed = true;
        }
        self
    }

    /// Hidden values are multiples of this.
    pub const fn in_steps(mut self, step: f64) -> Self {
        if let Some(draw) = &mut self.hidden {
            draw.step = step;
        }
        self
    }

    /// Its value in the picture.
    pub const fn pictured(self, value: f64) -> Self {
        Self {
            pictured: value,
            ..self
        }
    }

    /// It acts like all other linear parameters at once.
    pub const fn common(self) -> Self {
        Self {
            common: true,
            ..self
        }
    }

    /// Its value is at least this share of the nominal tool's.
    pub const fn of_the_tool(self, share: f64) -> Self {
        Self {
            of_the_tool: share,
            ..self
        }
    }

    /// The parameter for a bearing, where forces are torques and displacements are angles, those of a point at `LEVER_M` from the
    /// axis. A speed that is a shape or form may be that of the bearing's surfaces, or of a gear that turns a multiple of it: its
    /// range begins as on a guide, and its end is divided by the lever. All other ranges keep their numbers. A torque has no
    /// point of action.
    pub fn of_a_bearing(&self) -> Self {
        if self.name == ACTS_AT.name {
            return self.form(&[0.0], 0.0);
        }
        let (ending, turned, unit) = match self.unit {
            "N" => ("_n", "_n_m", "N·m"),
            "N/m" => ("_n_per_m", "_n_m_per_rad", "N·m/rad"),
            "N/m^3" => ("_n_per_m3", "_n_m_per_rad3", "N·m/rad^3"),
            "N·s/m" => ("_n_s_per_m", "_n_m_s_per_rad", "N·m·s/rad"),
            "m/s" => ("_m_s", "_rad_s", "rad/s"),
            "m" => ("_m", "_rad", "rad"),
            _ => return *self,
        };
        let stem = self.name.strip_suffix(ending).unwrap_or(self.name);
        let stem = if stem == "force" { "torque" } else { stem };
        let name = format!("{stem}{turned}");
        let (low, high, role) = match (self.unit, self.role) {
            ("m", role) => (
                self.low * PER_LEVER,
                self.high * PER_LEVER,
                role.times(PER_LEVER),
            ),
            ("m/s", role @ (Role::Shape(_) | Role::Form(_))) => {
                (self.low, self.high * PER_LEVER, role)
            }
            (_, role) => (self.low, self.high, role),
        };
        Self {
            name: Box::leak(name.into_boxed_str()),
            unit,
            low,
            high,
            role,
            ..*self
        }
    }

    /// Plausible range for translations, or for rotations in their unit.
    pub fn range(&self, rotation: bool) -> [f64; 2] {
        let own = self.of_rotations.filter(|_| rotation);
        own.unwrap_or([self.low, self.high])
    }

    /// Whether the parameter may have either sign; if not, a negative value is unphysical.
    pub fn is_signed(&self) -> bool {
        self.low < 0.0
    }

    /// Whether `value` lies in the plausible range; NaN does not.
    pub fn is_plausible(&self, value: f64) -> bool {
        value >= self.low && value <= self.high
    }

    /// Whether it selects the form of the law.
    pub fn is_form(&self) -> bool {
        matches!(self.role, Role::Form(_))
    }

    /// Whether it is a form with a continuous size.
    pub fn is_form_size(&self) -> bool {
        matches!(self.role, Role::Form(tried) if tried.continuous)
    }

    /// Values with which its search begins; `None` if it is linear.
    pub fn search_start(&self) -> Option<&SearchStart> {
        match &self.role {
            Role::Linear => None,
            Role::Shape(tried) | Role::Form(tried) => Some(tried),
        }
    }

    /// The word for a value of a choice; `None` if the parameter is no choice.
    pub fn word(&self, value: f64) -> Option<&'static str> {
        self.words.get(value as usize).copied()
    }

    /// Its value if none is given.
    pub fn default(&self) -> f64 {
        self.search_start().map_or(0.0, |tried| tried.default)
    }
}

/// Where in the chain from command to force an effect acts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Group {
    /// From the commanded velocity to the executed one.
    Actuator,
    /// Forces on the moving side.
    Mechanism,
    /// From forces to the wrench as read.
    Sensor,
    /// The simulated spacecraft and the clock of the control cycle.
    Body,
}

impl Group {
    /// All groups, in the order in which a signal meets them.
    pub const ALL: [Self; 4] = [Self::Actuator, Self::Mechanism, Self::Sensor, Self::Body];

    /// Name with a short description.
    pub const fn title(self) -> &'static str {
        match self {
            Self::Actuator => "Actuator: from the commanded velocity to the executed one",
            Self::Mechanism => "Mechanism: forces on the moving side",
            Self::Sensor => "Sensor: from forces to the wrench as read",
            Self::Body => "Body: the simulated spacecraft and the clock of the cycle",
        }
    }
}

/// What a verdict may say when an effect fits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Naming {
    /// One physical cause: it may be named.
    Cause,
    /// A curve that fits many mechanisms: it may only be reported as "looks like".
    Shape,
}

/// Kinds of effects that contain or imitate each other: two of a kind together are one effect whose form is not in the catalogue.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A friction that changes its sign with the direction.
    DryFriction,
    /// A damper in the contact.
    ContactDamping,
    /// A reading that comes late.
    LateReading,
    /// A commanded force that comes late.
    LateCommand,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_lower_bound_is_the_sign_constraint() {
        let friction = Parameter::new("force_n", "N", 0.0, 50.0);
        let offset = Parameter::new("force_n", "N", -50.0, 50.0);
        assert!(!friction.is_signed() && offset.is_signed());
        assert!(offset.is_plausible(-3.0) && !friction.is_plausible(-3.0));
        assert!(!offset.is_plausible(f64::NAN));
    }

    /// 0.1 mm at 50 mm from the axis are 2 mrad, 0.1 m/s are 2 rad/s; forces become torques with the same numbers.
    #[test]
    fn lengths_and_speeds_of_a_guide_are_those_of_a_bearing() {
        let length = Parameter::new("presliding_m", "m", 0.0, 5e-4).form_size(&[0.0, 1e-4], 0.0);
        let angle = length.of_a_bearing();
        let tried = angle.search_start().map(|tried| tried.values);
        assert_eq!((angle.name, angle.high), ("presliding_rad", 0.01));
        assert_eq!(tried, Some(&[0.0, 2e-3][..]));
        let speed = Parameter::new("speed_m_s", "m/s", 1e-4, 0.1).shape(&[1e-3, 2e-2], 5e-3);
        let turning = speed.of_a_bearing();
        let tried = turning.search_start().map(|tried| tried.values);
        assert_eq!((turning.low, turning.high), (1e-4, 2.0));
        assert_eq!(tried, Some(&[1e-3, 2e-2][..]));
        let torque = Parameter::new("force_n", "N", 0.0, 50.0).of_a_bearing();
        assert_eq!((torque.name, torque.high), ("torque_n_m", 50.0));
    }
}
