//! Laws written by the user: an expression of the signals of a motion, with checked units.

use super::units::Dimension;
use super::{Effect, Group, Law, Naming, Parameter, Role, SearchStart, Values};
use exmex::{Express, FlatEx, FloatOpsFactory, MakeOperators};
use softdock_io::input::nearest;

/// Signals on which a formula may depend.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Signals {
    /// Position along the guide, m; angle about a bearing, rad.
    pub position: f64,
    /// Rate of the position, m/s or rad/s.
    pub velocity: f64,
    /// Rate of the velocity, m/s² or rad/s².
    pub acceleration: f64,
    /// Sign of the velocity: −1, 0 or 1.
    pub direction: f64,
    /// Push of the walls along the guide, N.
    pub force: f64,
    /// Time since the log began, s.
    pub time: f64,
    /// Penetration of a wall, m; 0 outside.
    pub depth: f64,
    /// Rate of the penetration, m/s.
    pub rate: f64,
    /// Distance of the tip to a wall, m; 0 inside.
    pub gap: f64,
}

/// A signal: its name, its unit along a guide and about a bearing, and its value.
type Signal = (&'static str, [&'static str; 2], fn(&Signals) -> f64);

/// The signals that may occur in a formula.
const SIGNALS: [Signal; 9] = [
    ("position", ["m", "rad"], |s| s.position),
    ("velocity", ["m/s", "rad/s"], |s| s.velocity),
    ("acceleration", ["m/s^2", "rad/s^2"], |s| s.acceleration),
    ("direction", ["-"; 2], |s| s.direction),
    ("force", ["N", "N·m"], |s| s.force),
    ("time", ["s"; 2], |s| s.time),
    ("depth", ["m"; 2], |s| s.depth),
    ("rate", ["m/s"; 2], |s| s.rate),
    ("gap", ["m"; 2], |s| s.gap),
];

/// Where a formula acts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ActsOn {
    /// A force along the guide, N; a torque about a bearing, N·m.
    Guide,
    /// A push of each wall beside the nominal one, N, where the tip is in the wall.
    Contact,
    /// A force out of each wall on the tip at any distance, N.
    Wall,
    /// An axis of the reading, fx fy fz (N) tx ty tz (N·m).
    Reading(usize),
}

impl ActsOn {
    /// Words of a model file for it.
    pub const WORDS: [&str; 9] = [
        "guide", "contact", "wall", "fx", "fy", "fz", "tx", "ty", "tz",
    ];

    /// From its word in a model file; `None` for any other word.
    pub fn of(word: &str) -> Option<Self> {
        match Self::WORDS.iter().position(|known| *known == word)? {
            0 => Some(Self::Guide),
            1 => Some(Self::Contact),
            2 => Some(Self::Wall),
            axis => Some(Self::Reading(axis - 3)),
        }
    }

    /// Unit of the formula's value; `turns`: the guide is a bearing.
    pub fn unit(self, turns: bool) -> &'static str {
        match self {
            Self::Reading(3..) => "N·m",
            Self::Guide if turns => "N·m",
            _ => "N",
        }
    }

    fn gives(self, signal: &str) -> bool {
        match signal {
            "depth" => self == Self::Contact,
            "rate" => matches!(self, Self::Contact | Self::Wall),
            "gap" => self == Self::Wall,
            _ => true,
        }
    }
}

/// A law as an expression.
#[derive(Debug)]
pub struct Formula {
    expression: FlatEx<f64>,
    /// Source of each variable of the expression.
    sources: Vec<Source>,
    /// Where it acts.
    pub acts_on: ActsOn,
    /// Whether the guide is a bearing.
    turns: bool,
}

#[derive(Clone, Copy, Debug)]
enum Source {
    Parameter(usize),
    Signal(usize),
}

/// A parameter of a formula.
#[derive(Clone, Copy, Debug)]
pub struct Symbol<'a> {
    /// Its name.
    pub name: &'a str,
    /// Its unit, as `N·s/m`.
    pub unit: &'a str,
    /// Smallest value.
    pub low: f64,
    /// Largest value.
    pub high: f64,
}

/// Parameters that a formula may have.
const MOST_PARAMETERS: usize = 8;
/// Values that a search tries for a nonlinear parameter: 5 % apart over a decade, which finds a ripple with five periods in the
/// travel.
const TRIED: usize = 48;
/// The same if there are several such parameters: all combinations are tried.
const TRIED_TOGETHER: usize = 8;

impl Formula {
    /// Parses a formula. `turns`: the guide is a bearing.
    ///
    /// # Errors
    ///
    /// The first error, with what is allowed: syntax, names, units.
    pub fn parse(
        text: &str,
        acts_on: ActsOn,
        turns: bool,
        symbols: &[Symbol<'_>],
    ) -> Result<Self, String> {
        if let Some(why) = unknown_function(text) {
            return Err(why);
        }
        let expression: FlatEx<f64> = exmex::parse(text).map_err(|error| {
            format!(
                "{}; expected an expression as `stiffness * position^3`",
                error.msg()
            )
        })?;
        let names = expression.var_names().to_vec();
        let source = |name: &String| source(name, text, acts_on, symbols);
        let sources: Vec<Source> = names.iter().map(source).collect::<Result<_, _>>()?;
        if let Some(unused) = symbols.iter().find(|s| !names.iter().any(|n| n == s.name)) {
            return Err(format!(
                "the parameter `{}` does not occur in it; take it out",
                unused.name
            ));
        }
        let formula = Self {
            expression,
            sources,
            acts_on,
            turns,
        };
        if symbols.len() > MOST_PARAMETERS {
            return Err(format!(
                "it has {} parameters; allowed are {MOST_PARAMETERS}: what has more fits anything",
                symbols.len()
            ));
        }
        formula.check_units(symbols)?;
        Ok(formula)
    }

    /// Its value, in the unit of [`ActsOn::unit`]; not finite where the formula is undefined.
    pub fn value(&self, p: Values<'_>, signals: &Signals) -> f64 {
        let value = |source: &Source| match source {
            Source::Parameter(k) => p[*k],
            Source::Signal(k) => (SIGNALS[*k].2)(signals),
        };
        let values: Vec<f64> = self.sources.iter().map(value).collect();
        self.expression.eval(&values).unwrap_or(f64::NAN)
    }

    /// Its parameters as those of an effect: those in which it is jointly linear are linear, the others are shapes that are
    /// searched over their range.
    pub fn parameters(&self, symbols: &[Symbol<'static>]) -> Vec<Parameter> {
        let linear = self.linear(symbols);
        let shaping = symbols.len() - linear.len();
        let count = if shaping > 1 { TRIED_TOGETHER } else { TRIED };
        let parameter = |(k, s): (usize, &Symbol<'static>)| Parameter {
            role: match linear.contains(&k) {
                true => Role::Linear,
                false => {
                    let values: &'static [f64] = Box::leak(tried(s, count).into_boxed_slice());
                    Role::Shape(SearchStart {
                        values,
                        default: values[count / 2],
                        continuous: true,
                        most: f64::INFINITY,
                    })
                }
            },
            ..Parameter::new(s.name, s.unit, s.low, s.high)
        };
        symbols.iter().enumerate().map(parameter).collect()
    }

    /// The catalogue entry of an effect with this law, with static lifetime.
    pub fn entry(
        self,
        id: &'static str,
        title: &'static str,
        text: &'static str,
        symbols: &[Symbol<'static>],
    ) -> Effect {
        let parameters = self.parameters(symbols);
        let group = match self.acts_on {
            ActsOn::Reading(_) => Group::Sensor,
            ActsOn::Guide | ActsOn::Contact | ActsOn::Wall => Group::Mechanism,
        };
        Effect {
            id,
            title,
            summary: text,
            group,
            naming: Naming::Cause,
            equation: text,
            source: "own hypothesis of the model file",
            signature: "what the formula says",
            typical: "within the ranges of the model file",
            parameters: Box::leak(parameters.into_boxed_slice()),
            tell_apart: "an experiment in which the formula and its rivals differ",
            law: Law::Formula(Box::leak(Box::new(self))),
            separable: false,
            ..Effect::PLAIN
        }
    }

    /// The largest set of parameters in which it is jointly linear, by their places.
    fn linear(&self, symbols: &[Symbol<'_>]) -> Vec<usize> {
        let count = symbols.len().min(MOST_PARAMETERS);
        let mut sets: Vec<u32> = (1..1 << count).collect();
        sets.sort_by_key(|set| std::cmp::Reverse(set.count_ones()));
        let members =
            |set: u32| -> Vec<usize> { (0..count).filter(|k| set & (1 << k) != 0).collect() };
        let mut all = sets.into_iter().map(members);
        all.find(|set| self.is_linear_in(set, symbols))
            .unwrap_or_default()
    }

    /// Whether it is jointly linear in these parameters and vanishes when they are 0; tested at unrelated points.
    fn is_linear_in(&self, linear: &[usize], symbols: &[Symbol<'_>]) -> bool {
        (0..POINTS).all(|point| {
            let signals = signals_at(point);
            let others = values_at(point, symbols);
            let with = |factor: f64, which: usize| {
                let mut p = others.clone();
                for k in linear {
                    p[*k] = factor * (scattered(point, 40 + 10 * which + k) - 0.3);
                }
                p
            };
            let sum: Vec<f64> = {
                let (a, b) = (with(1.0, 0), with(1.0, 1));
                let add = |k: usize| {
                    if linear.contains(&k) {
                        a[k] + b[k]
                    } else {
                        a[k]
                    }
                };
                (0..a.len()).map(add).collect()
            };
            let at = |p: &[f64]| self.value(p, &signals);
            let (a, b) = (at(&with(1.0, 0)), at(&with(1.0, 1)));
            let close = |x: f64, y: f64| (x - y).abs() <= 1e-9 * (x.abs() + y.abs() + 1e-300);
            close(at(&sum), a + b) && close(at(&with(3.0, 0)), 3.0 * a)
        })
    }

    /// Checks the unit of its value: if all quantities are expressed in other base units, the value has to change like one of its
    /// unit.
    fn check_units(&self, symbols: &[Symbol<'_>]) -> Result<(), String> {
        let units = dimensions(symbols)?;
        let result = self.acts_on.unit(self.turns);
        let wanted = Dimension::of(result).unwrap_or_default();
        let mut tested = false;
        for point in 0..POINTS {
            let signals = signals_at(point);
            let values = values_at(point, symbols);
            let plain = self.value(&values, &signals);
            if !plain.is_finite() || plain == 0.0 {
                continue;
            }
            tested = true;
            for (name, scale) in OTHER_UNITS {
                let scaled = values.iter().zip(&units);
                let scaled: Vec<f64> = scaled.map(|(v, unit)| v * unit.factor(scale)).collect();
                let got = self.value(&scaled, &scaled_signals(&signals, self.turns, scale));
                let expected = plain * wanted.factor(scale);
                if (got - expected).abs() > 1e-6 * expected.abs() {
                    return Err(format!(
                        "it does not give {result}: with {name} twice as large it becomes {:.4} times what it \
                         was, and {result} {:.4} times; check the units of its parameters ({})",
                        got / plain,
                        wanted.factor(scale),
                        self.units()
                    ));
                }
            }
        }
        match tested {
            true => Ok(()),
            false => {
                Err("it has no value other than 0 within the ranges of its parameters".to_owned())
            }
        }
    }

    /// The units of the signals in it, as words.
    fn units(&self) -> String {
        let signals = self.sources.iter().filter_map(|source| match source {
            Source::Signal(k) => Some(&SIGNALS[*k]),
            Source::Parameter(_) => None,
        });
        let said: Vec<String> = signals
            .map(|(name, unit, _)| format!("{name} is in {}", unit[usize::from(self.turns)]))
            .collect();
        match said.is_empty() {
            true => "no signal is in it".to_owned(),
            false => said.join(", "),
        }
    }
}

/// A message if the text calls something that is not a function; `None` if it does not.
fn unknown_function(text: &str) -> Option<String> {
    let operators = FloatOpsFactory::<f64>::make();
    let functions = || {
        let all = operators.iter().map(|operator| operator.repr());
        all.filter(|name| name.starts_with(|c: char| c.is_ascii_alphabetic()))
    };
    let is_of_name = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let called = text.match_indices('(').filter_map(|(end, _)| {
        let before = text[..end].trim_end();
        let name = before.rsplit(|c| !is_of_name(c)).next()?;
        name.starts_with(|c: char| c.is_ascii_alphabetic())
            .then_some((before.len() - name.len(), name))
    });
    let (at, name) = called
        .into_iter()
        .find(|(_, name)| !functions().any(|known| known == *name))?;
    let hint =
        nearest(name, functions()).map_or(String::new(), |near| format!("did you mean `{near}`? "));
    let known: Vec<&str> = functions().collect();
    Some(format!(
        "`{name}` at character {} is no function; {hint}known are: {}",
        text[..at].chars().count() + 1,
        known.join(", ")
    ))
}

fn source(
    name: &str,
    text: &str,
    acts_on: ActsOn,
    symbols: &[Symbol<'_>],
) -> Result<Source, String> {
    if let Some(k) = symbols.iter().position(|s| s.name == name) {
        return Ok(Source::Parameter(k));
    }
    let signals = || SIGNALS.iter().map(|s| s.0).filter(|s| acts_on.gives(s));
    if signals().any(|known| known == name) {
        let place = SIGNALS.iter().position(|s| s.0 == name).unwrap_or(0);
        return Ok(Source::Signal(place));
    }
    let known: Vec<&str> = symbols.iter().map(|s| s.name).chain(signals()).collect();
    let hint = match nearest(name, known.iter().copied()) {
        Some(near) => format!("did you mean `{near}`?"),
        None => "a parameter needs a line with its unit and range".to_owned(),
    };
    let place = text
        .find(name)
        .map_or(0, |at| text[..at].chars().count() + 1);
    Err(format!(
        "`{name}` at character {place} is not known; {hint} known are: {}",
        known.join(", ")
    ))
}

/// Values of a parameter over its range: in equal ratios where it is positive and spans more than one decade, else in equal
/// steps.
fn tried(s: &Symbol<'_>, count: usize) -> Vec<f64> {
    let share = |k: usize| (k as f64 + 0.5) / count as f64;
    let by_factors = s.low > 0.0 && s.high / s.low > 10.0;
    let value = |k: usize| match by_factors {
        true => s.low * (s.high / s.low).powf(share(k)),
        false => s.low + (s.high - s.low) * share(k),
    };
    (0..count).map(value).collect()
}

/// Dimensions of the parameters.
fn dimensions(symbols: &[Symbol<'_>]) -> Result<Vec<Dimension>, String> {
    let of = |s: &Symbol<'_>| {
        Dimension::of(s.unit).ok_or_else(|| {
            format!(
                "unit `{}` of `{}` is not known; expected products of m, s, kg, N, rad, Hz and \
                 `-` for none, as `N·s/m` or `N/m^3`",
                s.unit, s.name
            )
        })
    };
    symbols.iter().map(of).collect()
}

/// Base units that are changed, and the factors by which numbers of metres, seconds and newtons then change.
const OTHER_UNITS: [(&str, [f64; 3]); 3] = [
    ("metres", [2.0, 1.0, 1.0]),
    ("seconds", [1.0, 2.0, 1.0]),
    ("newtons", [1.0, 1.0, 2.0]),
];

/// Number of points at which a formula is evaluated for the checks.
const POINTS: usize = 8;

/// Pseudo-random numbers in (0, 1): multiples of the golden ratio.
fn scattered(point: usize, k: usize) -> f64 {
    let golden = 0.618_033_988_749_894_9;
    (golden * (1.0 + point as f64 * 13.0 + k as f64 * 7.0))
        .fract()
        .clamp(0.05, 0.95)
}

/// Parameters within their ranges.
fn values_at(point: usize, symbols: &[Symbol<'_>]) -> Vec<f64> {
    let value = |(k, s): (usize, &Symbol<'_>)| s.low + (s.high - s.low) * scattered(point, 20 + k);
    symbols.iter().enumerate().map(value).collect()
}

fn signals_at(point: usize) -> Signals {
    let value = |k: usize| 2.0 * scattered(point, k) - 0.9;
    let velocity = value(1);
    Signals {
        position: value(0),
        velocity,
        acceleration: value(2),
        direction: velocity.signum(),
        force: value(3).abs(),
        time: value(4).abs(),
        depth: value(5).abs(),
        rate: value(6),
        gap: value(7).abs(),
    }
}

fn scaled_signals(s: &Signals, turns: bool, scale: [f64; 3]) -> Signals {
    let scaled = |name: &str| {
        let signal = SIGNALS.iter().find(|signal| signal.0 == name);
        signal.map_or(0.0, |(_, unit, value)| {
            let dimension = Dimension::of(unit[usize::from(turns)]).unwrap_or_default();
            value(s) * dimension.factor(scale)
        })
    };
    Signals {
        position: scaled("position"),
        velocity: scaled("velocity"),
        acceleration: scaled("acceleration"),
        direction: scaled("direction"),
        force: scaled("force"),
        time: scaled("time"),
        depth: scaled("depth"),
        rate: scaled("rate"),
        gap: scaled("gap"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const COGGING: [Symbol<'static>; 3] = [
        Symbol {
            name: "amplitude_n",
            unit: "N",
            low: 0.0,
            high: 20.0,
        },
        Symbol {
            name: "phase_rad",
            unit: "rad",
            low: 0.0,
            high: 6.3,
        },
        Symbol {
            name: "pitch_m",
            unit: "m",
            low: 1e-3,
            high: 0.1,
        },
    ];
    const TEXT: &str = "amplitude_n * sin(2 * PI * position / pitch_m + phase_rad)";

    #[test]
    fn it_is_evaluated_and_its_linear_parameter_found() {
        let formula = Formula::parse(TEXT, ActsOn::Guide, false, &COGGING).unwrap();
        let at = Signals {
            position: 0.0125,
            ..Signals::default()
        };
        assert!((formula.value(&[3.0, 0.0, 0.05], &at) - 3.0).abs() < 1e-12);
        let roles: Vec<bool> = formula
            .parameters(&COGGING)
            .iter()
            .map(|p| p.role == Role::Linear)
            .collect();
        assert_eq!(roles, [true, false, false]);
    }

    /// Neither amplitude is linear alone, both together are.
    #[test]
    fn linear_parameters_are_found_together() {
        let of = |name, unit, low, high| Symbol {
            name,
            unit,
            low,
            high,
        };
        let symbols = [
            of("a_n", "N", -1.0, 1.0),
            of("b_n", "N", -1.0, 1.0),
            of("pitch_m", "m", 1e-3, 1.0),
        ];
        let text = "a_n * sin(position/pitch_m) + b_n * cos(position/pitch_m)";
        let formula = Formula::parse(text, ActsOn::Guide, false, &symbols).unwrap();
        assert_eq!(formula.linear(&symbols), [0, 1]);
    }

    #[test]
    fn mistakes_are_named() {
        let wrong = |text: &str, symbols: &[Symbol<'static>]| {
            Formula::parse(text, ActsOn::Guide, false, symbols).unwrap_err()
        };
        let said = wrong("amplitude_n * sin(positoin)", &COGGING[..1]);
        assert!(
            said.contains("`positoin` at character 19") && said.contains("`position`?"),
            "{said}"
        );
        let said = wrong("amplitude_n * position", &COGGING[..1]);
        assert!(
            said.contains("does not give N") && said.contains("metres"),
            "{said}"
        );
        let said = wrong("amplitude_n * sgn(velocity)", &COGGING[..1]);
        assert!(
            said.contains("`sgn` at character 15") && said.contains("signum"),
            "{said}"
        );
        let said = wrong("amplitude_n * (1 + ", &COGGING[..1]);
        assert!(said.contains("expected an expression"), "{said}");
        let said = wrong("amplitude_n * depth / pitch_m", &COGGING);
        assert!(said.contains("`depth`"), "{said}");
        let said = wrong("amplitude_n", &COGGING[..2]);
        assert!(said.contains("`phase_rad` does not occur"), "{said}");
    }

    /// About a bearing angles have no unit, and the value is a torque.
    #[test]
    fn on_a_bearing_it_gives_a_torque() {
        let symbols = [Symbol {
            name: "drag",
            unit: "N·m·s/rad",
            low: 0.0,
            high: 1.0,
        }];
        let on = |turns| Formula::parse("drag * velocity", ActsOn::Guide, turns, &symbols);
        assert!(on(true).is_ok());
        let said = on(false).unwrap_err();
        assert!(said.contains("velocity is in m/s)"), "{said}");
    }
}
