//! `[[hypothesis]]` of a model file: an effect of the user's own, as a formula.

use super::EffectError;
use crate::effects::formula::{ActsOn, Formula, Symbol};
use crate::effects::{Effect, by_id};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::sync::{LazyLock, Mutex, PoisonError};

/// One `[[hypothesis]]`: it competes with the catalogue.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Hypothesis {
    /// Its id in verdicts and in `[[effect]]`.
    pub id: String,
    /// Its name for people.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub title: String,
    /// Where it acts: one of [`ActsOn::WORDS`].
    pub acts_on: String,
    /// Expression of signals and parameters that gives N, or N·m on tx ty tz and a bearing.
    pub formula: String,
    /// Its parameters.
    pub parameters: BTreeMap<String, HypothesisParameter>,
}

/// A parameter of a [`Hypothesis`].
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HypothesisParameter {
    /// Unit, as `N·s/m`; `-` for none.
    pub unit: String,
    /// Smallest value that it can have; 0: physics forbids a negative one.
    pub low: f64,
    /// Largest value.
    pub high: f64,
}

/// Entries by their definition: the same definition read twice gives the same entry.
static ENTRIES: LazyLock<Mutex<BTreeMap<String, &'static Effect>>> = LazyLock::new(Mutex::default);

impl Hypothesis {
    /// The catalogue entry of this effect. `turns`: the guide is a bearing.
    ///
    /// # Errors
    ///
    /// The first error, with what is allowed.
    pub fn effect(&self, turns: bool) -> Result<&'static Effect, EffectError> {
        let mut entries = ENTRIES.lock().unwrap_or_else(PoisonError::into_inner);
        let definition = format!("{turns} {self:?}");
        if let Some(known) = entries.get(&definition) {
            return Ok(known);
        }
        let entry: &'static Effect = Box::leak(Box::new(self.entry(turns)?));
        entries.insert(definition, entry);
        Ok(entry)
    }

    fn entry(&self, turns: bool) -> Result<Effect, EffectError> {
        let wrong = |key: &str, why: String| EffectError::Hypothesis {
            id: self.id.clone(),
            key: key.to_owned(),
            why,
        };
        let mut letters = self.id.chars();
        let starts = letters.next().is_some_and(|c| c.is_ascii_lowercase());
        let goes_on = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_';
        if !starts || !letters.all(goes_on) {
            let why = "expected a lower-case letter, then letters, digits and `_`";
            return Err(wrong("id", why.to_owned()));
        }
        if by_id(&self.id).is_some() {
            let why = "the catalogue has an effect of this name; choose another";
            return Err(wrong("id", why.to_owned()));
        }
        let acts_on = ActsOn::of(&self.acts_on).ok_or_else(|| {
            let why = format!(
                "is `{}`; expected {}",
                self.acts_on,
                ActsOn::WORDS.join(", ")
            );
            wrong("acts_on", why)
        })?;
        let symbols: Vec<Symbol<'static>> = self.parameters.iter().map(symbol).collect();
        for (symbol, key) in symbols.iter().zip(self.parameters.keys()) {
            let (low, high) = (symbol.low, symbol.high);
            let ordered = low < high && low.is_finite() && high.is_finite();
            if !ordered {
                let why = format!("low is {low} and high is {high}; expected low < high");
                return Err(wrong(&format!("parameters.{key}"), why));
            }
        }
        let formula = Formula::parse(&self.formula, acts_on, turns, &symbols)
            .map_err(|why| wrong("formula", why))?;
        let title = match self.title.as_str() {
            "" => format!("own hypothesis `{}`", self.id),
            title => format!("{title} (own hypothesis)"),
        };
        Ok(formula.entry(kept(&self.id), kept(&title), kept(&self.formula), &symbols))
    }
}

fn symbol((name, parameter): (&String, &HypothesisParameter)) -> Symbol<'static> {
    Symbol {
        name: kept(name),
        unit: kept(&parameter.unit),
        low: parameter.low,
        high: parameter.high,
    }
}

/// A text with static lifetime: entries live as long as the program, as those of the catalogue do.
fn kept(text: &str) -> &'static str {
    Box::leak(text.to_owned().into_boxed_str())
}
