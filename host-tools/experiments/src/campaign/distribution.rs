//! Distribution of a factor: maps a number between 0 and 1 to a value, or lists values.

use anyhow::{Result, ensure};
use nalgebra::ComplexField;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use statrs::distribution::{ContinuousCDF, Normal as Standard};

/// Most values of a grid: all are held in memory.
const MOST_POINTS: u32 = 1_000_000;

/// Up to so many values of a list are printed one by one.
const MOST_SAID: usize = 12;

/// A normal distribution.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Normal {
    /// Mean.
    pub mean: f64,
    /// Standard deviation.
    pub sigma: f64,
    /// Lower bound.
    #[serde(default)]
    pub low: Option<f64>,
    /// Upper bound.
    #[serde(default)]
    pub high: Option<f64>,
}

/// Numbers at equal distances.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Grid {
    /// The first.
    pub from: f64,
    /// The last.
    pub to: f64,
    /// How many.
    pub points: u32,
}

/// A distribution of values.
#[derive(Clone, Debug, PartialEq)]
pub enum Distribution {
    /// Evenly between two numbers.
    Uniform([f64; 2]),
    /// Evenly in the logarithm between two positive numbers.
    LogUniform([f64; 2]),
    /// Normal, cut off at its bounds.
    Normal(Normal),
    /// Each of these values.
    List(Vec<Value>),
    /// Each of these numbers.
    Grid(Grid),
}

impl Distribution {
    /// An error unless the numbers make a valid distribution.
    pub(super) fn check(&self) -> Result<()> {
        match self {
            Self::Uniform([low, high]) => {
                self.finite(&[*low, *high])?;
                ensure!(
                    low < high,
                    "uniform from {low} to {high}: expected low < high"
                );
            }
            Self::LogUniform([low, high]) => {
                self.finite(&[*low, *high])?;
                ensure!(
                    *low > 0.0 && low < high,
                    "log_uniform from {low} to {high}: expected 0 < low < high"
                );
            }
            Self::Normal(normal) => self.check_normal(normal)?,
            Self::List(values) => {
                ensure!(
                    !values.is_empty(),
                    "the list is empty; expected one value or more"
                );
                // TOML's nan and inf become `null`.
                ensure!(
                    !values.contains(&Value::Null),
                    "{}: expected finite numbers; `null` stands for one that is nan or inf",
                    self.text()
                );
            }
            Self::Grid(grid) => {
                self.finite(&[grid.from, grid.to])?;
                ensure!(
                    (1..=MOST_POINTS).contains(&grid.points),
                    "{}: expected 1 to {MOST_POINTS}",
                    self.text()
                );
            }
        }
        Ok(())
    }

    /// An error unless all numbers are finite.
    fn finite(&self, numbers: &[f64]) -> Result<()> {
        let wrong = numbers.iter().find(|number| !number.is_finite());
        ensure!(
            wrong.is_none(),
            "{}: expected finite numbers, received {}",
            self.text(),
            wrong.copied().unwrap_or_default()
        );
        Ok(())
    }

    /// An error if the bounds of a normal distribution leave nothing between them.
    fn check_normal(&self, normal: &Normal) -> Result<()> {
        let bounds = normal.low.into_iter().chain(normal.high);
        let numbers: Vec<f64> = bounds.chain([normal.mean, normal.sigma]).collect();
        self.finite(&numbers)?;
        ensure!(
            normal.sigma > 0.0,
            "normal with sigma {}: expected more than 0",
            normal.sigma
        );
        let [low, high] = shares(normal);
        ensure!(
            high - low > 1e-6,
            "{}: less than a millionth of it lies between its bounds; expected low < high around the mean",
            self.text()
        );
        Ok(())
    }

    /// The values of a list or grid, which are combined with those of other factors; None for a distribution that is drawn
    /// from.
    pub fn levels(&self) -> Option<Vec<Value>> {
        match self {
            Self::List(values) => Some(values.clone()),
            Self::Grid(Grid { from, to, points }) => {
                let last = f64::from(points.saturating_sub(1).max(1));
                let at = |i: u32| json!(from + (to - from) * (f64::from(i) / last));
                Some((0..*points).map(at).collect())
            }
            _ => None,
        }
    }

    /// The value below which the share `u` of all draws lies; NaN for a list or grid.
    pub fn quantile(&self, u: f64) -> f64 {
        match self {
            Self::Uniform([low, high]) => low + (high - low) * u,
            Self::LogUniform([low, high]) => {
                let (low, high) = (ComplexField::ln(*low), ComplexField::ln(*high));
                ComplexField::exp(low + (high - low) * u)
            }
            Self::Normal(normal) => {
                let [from, to] = shares(normal);
                let z = standard().inverse_cdf(from + (to - from) * u);
                normal.mean + normal.sigma * z
            }
            // Lists and grids are not drawn from.
            Self::List(_) | Self::Grid(_) => f64::NAN,
        }
    }

    /// Description of the distribution.
    pub fn text(&self) -> String {
        match self {
            Self::Uniform([low, high]) => format!("uniform {low} to {high}"),
            Self::LogUniform([low, high]) => format!("log-uniform {low} to {high}"),
            Self::Normal(Normal {
                mean,
                sigma,
                low,
                high,
            }) => {
                let bound = |word, bound: &Option<f64>| bound.map(|b| format!(", {word} {b}"));
                let bounds = [bound("from", low), bound("to", high)];
                let bounds: String = bounds.into_iter().flatten().collect();
                format!("normal {mean} ± {sigma}{bounds}")
            }
            Self::List(values) if values.len() > MOST_SAID => {
                let ends = [values.first(), values.last()]
                    .map(|v| v.map_or_else(String::new, Value::to_string));
                format!("{} values, {} to {}", values.len(), ends[0], ends[1])
            }
            Self::List(values) => {
                let values: Vec<String> = values.iter().map(Value::to_string).collect();
                format!("each of {}", values.join(", "))
            }
            Self::Grid(Grid { from, to, points }) => format!("{points} values from {from} to {to}"),
        }
    }
}

/// Cumulative probabilities of a normal distribution at its bounds.
fn shares(normal: &Normal) -> [f64; 2] {
    let share = |bound: f64| standard().cdf((bound - normal.mean) / normal.sigma);
    [
        normal.low.map_or(0.0, share),
        normal.high.map_or(1.0, share),
    ]
}

fn standard() -> Standard {
    Standard::standard()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_those_of_the_tables() {
        let normal = |low, high| {
            Distribution::Normal(Normal {
                mean: 10.0,
                sigma: 2.0,
                low,
                high,
            })
        };
        assert!((normal(None, None).quantile(0.975) - 13.919_927_97).abs() < 1e-6);
        // Cut at the mean: half of what is left lies below the upper quartile.
        let half = normal(Some(10.0), None).quantile(0.5);
        assert!((half - (10.0 + 2.0 * 0.674_489_75)).abs() < 1e-6, "{half}");
        assert_eq!(Distribution::Uniform([1.0, 3.0]).quantile(0.25), 1.5);
        let log = Distribution::LogUniform([1e-3, 1e3]).quantile(0.5);
        assert!((log - 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_grid_has_both_ends() {
        let grid = Distribution::Grid(Grid {
            from: 0.1,
            to: 0.3,
            points: 3,
        });
        assert_eq!(
            grid.levels(),
            Some(vec![json!(0.1), json!(0.2), json!(0.3)])
        );
    }

    #[test]
    fn what_is_no_distribution_is_refused() {
        let normal = |sigma, low| {
            Distribution::Normal(Normal {
                mean: 0.0,
                sigma,
                low,
                high: None,
            })
        };
        let grid = |to, points| {
            Distribution::Grid(Grid {
                from: 0.0,
                to,
                points,
            })
        };
        for (wrong, said) in [
            (Distribution::Uniform([2.0, 1.0]), "expected low < high"),
            (Distribution::Uniform([f64::NAN, 1.0]), "received NaN"),
            (Distribution::Uniform([0.0, f64::INFINITY]), "received inf"),
            (Distribution::LogUniform([0.0, 1.0]), "expected 0 < low"),
            (
                Distribution::LogUniform([1.0, f64::INFINITY]),
                "received inf",
            ),
            (normal(0.0, None), "expected more than 0"),
            (normal(f64::INFINITY, None), "received inf"),
            (normal(1.0, Some(9.0)), "a millionth"),
            (normal(1.0, Some(f64::NAN)), "received NaN"),
            (Distribution::List(vec![]), "the list is empty"),
            (
                Distribution::List(vec![json!(1.0), json!(f64::NAN)]),
                "nan or inf",
            ),
            (grid(f64::NEG_INFINITY, 2), "received -inf"),
            (grid(1.0, u32::MAX), "expected 1 to 1000000"),
        ] {
            let error = wrong.check().unwrap_err().to_string();
            assert!(error.contains(said), "{error}");
        }
    }
}
