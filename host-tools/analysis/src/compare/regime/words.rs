//! A regime in words.

use super::{Bin, Dependence, Interval, Quantity, Regime};
use softdock_physics::model::Axis;
use softdock_report::number;

/// An offset with less than this share of the error is not worth a word.
const OFFSET_SAID: f64 = 0.1;
/// A share that rounds to the whole.
const NEARLY_ALL: f64 = 0.995;
/// A dependence is called linear if a straight line explains this share of it ...
const STRAIGHT: f64 = 0.9;
/// ... and one by the sign if one value for each sign explains this share.
const SIGNED: f64 = 0.7;
/// Below the first share of the largest value a quantity is low, above the second it is high.
const LOW_AND_HIGH: (f64, f64) = (0.15, 0.5);
/// An error at low values is mentioned if it exceeds the one at high values by this factor.
const LARGER: f64 = 1.25;

impl Regime {
    /// What the error follows, or where it stands: a main clause.
    pub fn clause(&self) -> String {
        let percent = most(self.share);
        let beyond = "of the error beyond the noise";
        match (self.dependence, &self.at) {
            (Dependence::Band, Some(at)) => format!(
                "{percent} {beyond} swings at {} Hz ({} to {} Hz)",
                number::significant(0.5 * (at.from + at.to), 3),
                number::significant(at.from, 3),
                number::significant(at.to, 3)
            ),
            (Dependence::Size, Some(at)) => format!(
                "{percent} {beyond} stands where {} ({} of the time)",
                self.place(at),
                number::percent(at.time_share, 0)
            ),
            _ if self.offset_share >= NEARLY_ALL => format!(
                "an offset of {} makes nearly all {beyond}",
                quantity(self.offset, self.error_unit())
            ),
            _ if self.offset_share >= OFFSET_SAID => format!(
                "an offset of {} makes {} {beyond}, and {} of the rest follows {}: {}",
                quantity(self.offset, self.error_unit()),
                number::percent(self.offset_share, 0),
                most(self.share_beside_offset()),
                self.what(),
                self.shape()
            ),
            _ => format!(
                "{percent} {beyond} follows {}: {}",
                self.what(),
                self.shape()
            ),
        }
    }

    /// The regime in a few words, for a list.
    pub fn short(&self) -> String {
        match (self.dependence, &self.at) {
            (Dependence::Band, Some(at)) => format!(
                "swings at {} Hz",
                number::significant(0.5 * (at.from + at.to), 3)
            ),
            (Dependence::Size, Some(at)) => format!("where {}", self.place(at)),
            _ => format!("follows {}", self.what()),
        }
    }

    /// Name of the quantity for an axis of a plot, with its unit.
    pub fn label(&self) -> String {
        let size = if self.absolute { "size of " } else { "" };
        format!("{size}{} [{}]", self.name(), self.unit)
    }

    /// Whether a constant offset is said with the regime.
    pub fn says_offset(&self) -> bool {
        self.dependence == Dependence::Mean && self.offset_share >= OFFSET_SAID
    }

    fn error_unit(&self) -> &'static str {
        self.channel.unit(self.axis)
    }

    /// Name of the quantity.
    fn name(&self) -> String {
        let (preposition, letter, turns) = match self.along {
            Some(axis) => (preposition(axis), letter(axis), axis.is_rotation()),
            None => ("", "", false),
        };
        match self.variable {
            Quantity::Velocity if turns => format!("rate {preposition} {letter}"),
            Quantity::Velocity => format!("velocity {preposition} {letter}"),
            Quantity::Position => format!("position {letter}"),
            Quantity::Orientation => format!("rotation {preposition} {letter}"),
            Quantity::Force if turns => format!("expected torque {preposition} {letter}"),
            Quantity::Force => format!("expected force {preposition} {letter}"),
            Quantity::Acceleration if turns => {
                format!("angular acceleration {preposition} {letter}")
            }
            Quantity::Acceleration => format!("acceleration {preposition} {letter}"),
            Quantity::TimeInRun => "time in the recording".to_owned(),
            Quantity::TimeSinceContact => "time since contact".to_owned(),
            Quantity::Frequency => "frequency".to_owned(),
        }
    }

    /// The quantity with its article and its condition.
    fn what(&self) -> String {
        let contact = if self.in_contact { " in contact" } else { "" };
        let article = match self.variable {
            Quantity::Position | Quantity::Frequency => "",
            _ => "the ",
        };
        format!("{article}{}{contact}", self.name())
    }

    fn place(&self, at: &Interval) -> String {
        let what = self.what();
        let (low, high) = self.ends();
        let what = if self.absolute {
            format!("the size of {what}")
        } else {
            what
        };
        if at.from <= low && at.to < high {
            format!("{what} is below {}", self.value(at.to))
        } else if at.to >= high && at.from > low {
            format!("{what} is above {}", self.value(at.from))
        } else {
            let (from, to, unit) = match self.is_late() {
                true => (format!("{:.1}", at.from), format!("{:.1}", at.to), "s"),
                false => interval(at.from, at.to, self.unit),
            };
            format!("{what} is between {from} and {to} {unit}")
        }
    }

    /// Whether it is a time that counts from long before the recording, so that only its late digits differ.
    fn is_late(&self) -> bool {
        const LATE: f64 = 100.0;
        let (low, high) = self.ends();
        self.variable == Quantity::TimeInRun && low > LATE * (high - low)
    }

    /// A value of the quantity.
    fn value(&self, value: f64) -> String {
        match self.is_late() {
            true => format!("{value:.1} s"),
            false => quantity(value, self.unit),
        }
    }

    fn ends(&self) -> (f64, f64) {
        let low = self.bins.first().map_or(f64::NAN, |b| b.from);
        (low, self.bins.last().map_or(f64::NAN, |b| b.to))
    }

    /// How the mean error runs along the quantity.
    fn shape(&self) -> String {
        let bins: Vec<&Bin> = self.bins.iter().filter(|b| b.cycles > 0).collect();
        let means = || bins.iter().map(|b| (b.mean, b.cycles as f64));
        let middle = weighted_mean(means());
        let all: f64 = means().map(|(m, n)| n * (m - middle).powi(2)).sum();
        let (slope, by_line) = line(&bins, middle);
        let sides = sides(&bins);
        let by_sides = sides.map_or(0.0, |s| s.explained(middle));
        if by_line >= STRAIGHT * all && by_line >= by_sides {
            let per = quantity(slope, self.error_unit());
            return if self.variable == Quantity::Force && self.unit == self.error_unit() {
                format!("{} of it", number::percent(slope, 2))
            } else {
                format!("{per} per {}", self.unit)
            };
        }
        if let Some(sides) = sides.filter(|s| by_sides >= SIGNED * all && s.differ()) {
            return self.of_sides(&sides, &bins);
        }
        let at = |bin: &Bin| {
            let mean = quantity(bin.mean, self.error_unit());
            format!("{mean} near {}", self.value(bin.centre))
        };
        let lowest = bins.iter().min_by(|a, b| a.mean.total_cmp(&b.mean));
        let highest = bins.iter().max_by(|a, b| a.mean.total_cmp(&b.mean));
        match (lowest, highest) {
            (Some(low), Some(high)) if low.from < high.from => {
                format!("{}, {}", at(low), at(high))
            }
            (Some(low), Some(high)) => format!("{}, {}", at(high), at(low)),
            _ => String::new(),
        }
    }

    fn of_sides(&self, sides: &Sides, bins: &[&Bin]) -> String {
        let unit = self.error_unit();
        let (negative, positive) = (sides.negative.0, sides.positive.0);
        let (negative, positive) = (quantity(negative, unit), quantity(positive, unit));
        let turns = self.along.is_some_and(Axis::is_rotation);
        let letter = self.along.map_or("", letter);
        let text = match (self.variable, turns) {
            (Quantity::Velocity, false) => {
                format!("{negative} while moving in -{letter} and {positive} in +{letter}")
            }
            (Quantity::Velocity, true) => {
                format!("{negative} while turning about -{letter} and {positive} about +{letter}")
            }
            _ => format!("{negative} where it is negative and {positive} where it is positive"),
        };
        let (low, high) = self.ends();
        let largest = high.max(-low);
        let size = |keep: &dyn Fn(f64) -> bool| {
            let kept = bins.iter().filter(|b| keep(b.centre.abs() / largest));
            weighted_mean(kept.map(|b| (b.mean.abs(), b.cycles as f64)))
        };
        // Next to zero the sign itself is uncertain.
        let at_low = size(&|part| (0.01..LOW_AND_HIGH.0).contains(&part));
        let at_high = size(&|part| part > LOW_AND_HIGH.1);
        if at_low > LARGER * at_high {
            let limit = quantity(LOW_AND_HIGH.0 * largest, self.unit);
            return format!("{text}, larger below {limit}");
        }
        text
    }
}

/// A share in percent. Nearly all is never called all: no share is known so well.
fn most(share: f64) -> String {
    if share >= NEARLY_ALL {
        "nearly all".to_owned()
    } else {
        number::percent(share, 0)
    }
}

fn weighted_mean(values: impl Iterator<Item = (f64, f64)>) -> f64 {
    let (sum, weight) = values.fold((0.0, 0.0), |(s, w), (v, n)| (s + v * n, w + n));
    if weight > 0.0 { sum / weight } else { 0.0 }
}

/// Slope of a weighted line through the bins' means, and the sum of squares that it explains.
fn line(bins: &[&Bin], middle: f64) -> (f64, f64) {
    let at = weighted_mean(bins.iter().map(|b| (b.centre, b.cycles as f64)));
    let sum = |value: &dyn Fn(&Bin) -> f64| -> f64 {
        bins.iter().map(|b| b.cycles as f64 * value(b)).sum()
    };
    let along = sum(&|b| (b.centre - at).powi(2));
    let both = sum(&|b| (b.centre - at) * (b.mean - middle));
    if along > 0.0 {
        (both / along, both * both / along)
    } else {
        (0.0, 0.0)
    }
}

/// Mean error and cycles on either side of zero.
#[derive(Clone, Copy)]
struct Sides {
    negative: (f64, f64),
    positive: (f64, f64),
}

impl Sides {
    fn explained(&self, middle: f64) -> f64 {
        let of = |(mean, weight): (f64, f64)| weight * (mean - middle).powi(2);
        of(self.negative) + of(self.positive)
    }

    /// Whether the error has opposite signs on the two sides.
    fn differ(&self) -> bool {
        self.negative.0 * self.positive.0 < 0.0
    }
}

fn sides(bins: &[&Bin]) -> Option<Sides> {
    let side = |sign: f64| {
        let bins = || bins.iter().filter(|b| b.centre * sign > 0.0);
        let weight: f64 = bins().map(|b| b.cycles as f64).sum();
        let mean = weighted_mean(bins().map(|b| (b.mean, b.cycles as f64)));
        (weight > 0.0).then_some((mean, weight))
    };
    Some(Sides {
        negative: side(-1.0)?,
        positive: side(1.0)?,
    })
}

fn preposition(axis: Axis) -> &'static str {
    if axis.is_rotation() { "about" } else { "along" }
}

fn letter(axis: Axis) -> &'static str {
    ["x", "y", "z"][axis.index() % 3]
}

/// A value with its unit; lengths and angles below 1 in thousandths or millionths.
pub(in crate::compare) fn quantity(value: f64, unit: &'static str) -> String {
    let (factor, unit) = readable(value.abs(), unit);
    format!("{} {unit}", number::significant(value * factor, 3))
}

/// Both ends in the same unit.
fn interval(from: f64, to: f64, unit: &'static str) -> (String, String, &'static str) {
    let (factor, unit) = readable(from.abs().max(to.abs()), unit);
    let text = |value: f64| number::significant(value * factor, 3);
    (text(from), text(to), unit)
}

/// Factor and unit in which a value of this size is usually written on a rig: below 1 in thousandths or millionths (mm, µm).
fn readable(size: f64, unit: &'static str) -> (f64, &'static str) {
    let small = size < 1e-3;
    match unit {
        _ if size >= 1.0 => (1.0, unit),
        "m" if small => (1e6, "µm"),
        "m" => (1e3, "mm"),
        "m/s" if small => (1e6, "µm/s"),
        "m/s" => (1e3, "mm/s"),
        "rad" if small => (1e6, "µrad"),
        "rad" => (1e3, "mrad"),
        "rad/s" if small => (1e6, "µrad/s"),
        "rad/s" => (1e3, "mrad/s"),
        other => (1.0, other),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use softdock_physics::model::Channel;

    /// An error that jumps in the middle of ten seconds after an instant, in s.
    fn jump(began: f64) -> Regime {
        let bin = |from: f64, mean: f64| Bin {
            from: began + from,
            to: began + from + 5.0,
            centre: began + from + 2.5,
            cycles: 100,
            mean,
            spread: 0.0,
            rms_sigma: 1.0,
            share: 0.3,
        };
        Regime {
            channel: Channel::Wrench,
            axis: Axis::X,
            variable: Quantity::TimeInRun,
            along: None,
            unit: "s",
            in_contact: false,
            absolute: false,
            dependence: Dependence::Mean,
            share: 0.9,
            offset_share: 0.0,
            offset: 0.0,
            at: None,
            p: 0.0,
            significant: true,
            bins: vec![bin(0.0, 0.0), bin(5.0, 1.0), bin(10.0, 0.0)],
        }
    }

    #[test]
    fn seconds_since_1970_keep_the_digits_that_differ() {
        let soon = jump(0.0).clause();
        assert!(
            soon.ends_with("0 N near 2.50 s, 1.00 N near 7.50 s"),
            "{soon}"
        );
        let late = jump(1_752_828_765.0).clause();
        let ends = "near 1752828767.5 s, 1.00 N near 1752828772.5 s";
        assert!(late.ends_with(ends), "{late}");
    }
}
