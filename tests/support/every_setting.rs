//! Every field of the settings, found by walking their text form. A setting that is added later is found too, with the range
//! that its validation declares.

use softdock_control::range::SettingsError;
use softdock_control::settings::Settings;
use toml_edit::{DocumentMut, Item, Value};

/// Used to find a range: no setting allows this value.
const BEYOND_ALL: f64 = 1e300;

/// Type of a field.
#[derive(Clone, Debug, PartialEq)]
pub enum Kind {
    /// A real number with its smallest and largest value.
    Real(f64, f64),
    /// An integer with its smallest and largest value.
    Whole(i64, i64),
    /// A Boolean.
    Flag,
    /// One of several words.
    Word(Vec<String>),
}

/// One field; an array is one field with several values.
#[derive(Clone, Debug)]
pub struct Field {
    /// Dotted name, as in errors.
    pub name: String,
    /// Type and range.
    pub kind: Kind,
    places: Vec<Place>,
}

/// Path to one value.
type Place = Vec<Step>;

#[derive(Clone, Debug)]
enum Step {
    Key(String),
    Index(usize),
}

/// All fields of the settings, with their ranges while the other settings have their defaults.
///
/// # Panics
/// If a number has no declared range, or its error has another name.
pub fn every_setting() -> Vec<Field> {
    let document = text_form(&Settings::default());
    let mut fields: Vec<Field> = Vec::new();
    walk(document.as_item(), &mut Place::new(), &mut fields);
    for field in &mut fields {
        field.kind = kind_of(field);
    }
    fields
}

impl Field {
    /// Settings with this value in all places of the field, or the error of the parser.
    ///
    /// # Errors
    /// Not a value of the field's type.
    pub fn set(&self, settings: &Settings, value: &Value) -> Result<Settings, String> {
        self.set_some(settings, value, usize::MAX)
    }

    /// As [`Self::set`], in the first place only, which a validation must not miss.
    ///
    /// # Errors
    /// Not a value of the field's type.
    pub fn set_first(&self, settings: &Settings, value: &Value) -> Result<Settings, String> {
        self.set_some(settings, value, 1)
    }

    /// As [`Self::set`], in the last place only.
    ///
    /// # Errors
    /// Not a value of the field's type.
    pub fn set_last(&self, settings: &Settings, value: &Value) -> Result<Settings, String> {
        let last = Self {
            places: self.places.iter().rev().take(1).cloned().collect(),
            ..self.clone()
        };
        last.set(settings, value)
    }

    fn set_some(
        &self,
        settings: &Settings,
        value: &Value,
        places: usize,
    ) -> Result<Settings, String> {
        let mut document = text_form(settings);
        for place in self.places.iter().take(places) {
            *at(document.as_item_mut(), place) = Item::Value(value.clone());
        }
        toml_edit::de::from_document(document).map_err(|e| e.to_string())
    }

    /// The values at the ends of the range; all values of a flag or a word.
    pub fn corners(&self) -> Vec<Value> {
        match &self.kind {
            Kind::Real(low, high) => vec![(*low).into(), (*high).into()],
            Kind::Whole(low, high) => vec![(*low).into(), (*high).into()],
            Kind::Flag => vec![false.into(), true.into()],
            Kind::Word(words) => words.iter().map(Value::from).collect(),
        }
    }

    /// Values just beyond and far beyond the range, and NaN for real numbers.
    pub fn beyond(&self) -> Vec<Value> {
        match self.kind {
            Kind::Real(low, high) => [
                low.next_down(),
                high.next_up(),
                f64::MAX,
                f64::MIN,
                f64::INFINITY,
                f64::NEG_INFINITY,
                f64::NAN,
            ]
            .map(Value::from)
            .into(),
            Kind::Whole(low, high) => vec![(low - 1).into(), (high + 1).into()],
            Kind::Flag => vec![],
            Kind::Word(_) => vec!["?".into()],
        }
    }
}

/// The settings `wanted`, with other fields moved into the ranges that `wanted` leaves for them. None if `field` itself does
/// not fit the others.
pub fn made_to_fit(mut wanted: Settings, field: &Field, all: &[Field]) -> Option<Settings> {
    for _ in 0..8 {
        let Err(error) = wanted.validate() else {
            return Some(wanted);
        };
        if error.field.starts_with(&field.name) {
            return None;
        }
        let other = all.iter().find(|f| error.field == f.name)?;
        let allowed = error.received.clamp(error.low, error.high);
        wanted = match other.kind {
            Kind::Whole(..) => other.set(&wanted, &(allowed as i64).into()),
            _ => other.set(&wanted, &allowed.into()),
        }
        .ok()?;
    }
    None
}

fn text_form(settings: &Settings) -> DocumentMut {
    toml_edit::ser::to_document(settings).expect("settings have a text form")
}

fn walk(item: &Item, place: &mut Place, fields: &mut Vec<Field>) {
    if let Some(table) = item.as_table_like() {
        for (key, child) in table.iter() {
            place.push(Step::Key(key.into()));
            walk(child, place, fields);
            place.pop();
        }
    } else if let Some(array) = item.as_array() {
        for index in 0..array.len() {
            place.push(Step::Index(index));
            walk(&item[index], place, fields);
            place.pop();
        }
    } else {
        let name = dotted(place);
        match fields.iter_mut().find(|field| field.name == name) {
            Some(field) => field.places.push(place.clone()),
            None => fields.push(Field {
                name,
                kind: bare_kind(item),
                places: vec![place.clone()],
            }),
        }
    }
}

fn dotted(place: &Place) -> String {
    let keys = place.iter().filter_map(|step| match step {
        Step::Key(key) => Some(key.as_str()),
        Step::Index(_) => None,
    });
    keys.collect::<Vec<_>>().join(".")
}

fn at<'a>(item: &'a mut Item, place: &Place) -> &'a mut Item {
    place.iter().fold(item, |item, step| match step {
        Step::Key(key) => &mut item[key.as_str()],
        Step::Index(index) => &mut item[*index],
    })
}

/// The type without its range.
fn bare_kind(item: &Item) -> Kind {
    match item.as_value() {
        Some(Value::Float(_)) => Kind::Real(0.0, 0.0),
        Some(Value::Integer(_)) => Kind::Whole(0, 0),
        Some(Value::Boolean(_)) => Kind::Flag,
        Some(Value::String(_)) => Kind::Word(Vec::new()),
        other => panic!("a kind of setting that is not driven yet: {other:?}"),
    }
}

fn kind_of(field: &Field) -> Kind {
    match &field.kind {
        Kind::Real(..) => {
            let error = refusal(field, &BEYOND_ALL.into());
            let SettingsError { low, high, .. } =
                error.unwrap_or_else(|| panic!("`{}` has no declared range", field.name));
            Kind::Real(low, high)
        }
        Kind::Whole(..) => {
            let largest = [u32::MAX.into(), u16::MAX.into(), u8::MAX.into()]
                .into_iter()
                .find(|v: &i64| field.set(&Settings::default(), &(*v).into()).is_ok())
                .unwrap_or_else(|| panic!("`{}`: a type that is not driven yet", field.name));
            // If validation gives no error, every value of the type is allowed.
            refusal(field, &largest.into()).map_or(Kind::Whole(0, largest), |e| {
                Kind::Whole(e.low as i64, e.high as i64)
            })
        }
        Kind::Flag => Kind::Flag,
        Kind::Word(_) => Kind::Word(words(field)),
    }
}

/// The error of a value that is too large, which must name the field.
fn refusal(field: &Field, value: &Value) -> Option<SettingsError> {
    let settings = field.set_first(&Settings::default(), value).ok()?;
    let error = settings.validate().err()?;
    assert_eq!(error.field, field.name, "{error}");
    Some(error)
}

/// The words that a field accepts, from the parser's own message:
/// "unknown variant `?`, expected `a` or `b`" or "..., expected one of `a`, `b`, `c`".
fn words(field: &Field) -> Vec<String> {
    let message = field
        .set(&Settings::default(), &"?".into())
        .expect_err("no word is `?`");
    let first_line = message.lines().next().unwrap_or_default();
    let expected = first_line.split("expected").nth(1).unwrap_or_default();
    let words: Vec<String> = expected
        .split('`')
        .skip(1)
        .step_by(2)
        .map(Into::into)
        .collect();
    assert!(words.len() > 1, "`{}`: {message}", field.name);
    words
}
