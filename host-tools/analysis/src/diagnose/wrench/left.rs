//! What effects leave of a channel, and how much of it may be left without being called structure.

use super::regression::joint::{Joint, Rest};
use super::regression::prepared_log::{PreparedLog, sheet_sigma};
use super::regression::tested::TestedHypothesis;
use super::remainder::Remainder;
use crate::diagnose::noise::rounding::Rounded;
use crate::diagnose::noise::structure::Structure;
use softdock_physics::model::load::Column;
use softdock_physics::model::{Axis, Channel};

/// Share of the error that may be left without being called structure.
pub(crate) const REMAINDER: f64 = 0.01;
/// The same where each effect stands beside a smooth remainder. Set by hand, not calibrated: friction laws of real joints leave
/// about 3 %; imitations of effects outside the catalogue leave at least 4 % and mostly more than 10 % (`softdock bench diagnose
/// --seed 3`), so that one of them is named. Set by hand, too, for the servo of a machine that is no docking rig: on public logs
/// forms that are right leave 2 to 4 % of its velocity, one that is wrong 18 %.
const MODELLED: f64 = 0.05;
/// The same where effects and smooth remainder together leave at most [`DESCRIBED`], and nothing touches, whose law the remainder
/// could stand for: what is named then explains at least three times what stays without a name. Set by hand.
const NAMELESS: f64 = 0.25;
/// The same for a machine that is no docking rig. A model to start from knows nothing of it, so its inertia, weight and friction
/// are there before anybody asks. The limit says what a name is good for: what is named explains more than what stays without
/// one.
const HALF: f64 = 0.5;
/// Share of the error that effects and remainder together may leave for [`NAMELESS`]. It is not 0: what a drive's torque, late by
/// some milliseconds, leaves of a swinging weight is a function of none of the remainder's quantities. Set by hand.
const DESCRIBED: f64 = 0.1;

/// What is left of a channel after effects.
#[derive(Clone, Debug, Default)]
pub(crate) struct RemainingStructure {
    /// Axes, with what the tests find on each log.
    pub axes: Vec<(Channel, Axis, Vec<Structure>)>,
    /// Excess of χ² over the noise that is left, as a share of the excess that there was; 0 to 1.
    pub share: f64,
    /// The same share in units of the data sheet's noise, without whitening. What effects gain in whitened χ² beside a remainder
    /// does not measure what they explain.
    plain: f64,
    /// The plain share where a constant counts that effects remove, such as the friction of a motion one way.
    with_constants: f64,
    /// Share that may be left without being called structure.
    pub allowed: f64,
}

impl RemainingStructure {
    pub(crate) fn new(axes: Vec<(Channel, Axis, Vec<Structure>)>, share: f64) -> Self {
        Self {
            axes,
            share,
            plain: share,
            with_constants: share,
            allowed: REMAINDER,
        }
    }

    /// For a velocity: `squares` is χ² of the `count` values that is left, `nominal` is χ² before any effect.
    pub(crate) fn of_velocities(
        axes: Vec<(Channel, Axis, Vec<Structure>)>,
        squares: f64,
        nominal: f64,
        count: usize,
    ) -> Self {
        let excess = (squares - count as f64).max(0.0);
        Self::new(axes, excess / (excess + nominal - squares).max(1.0))
    }

    /// The limit for the velocity of a servo of a machine that is no docking rig.
    pub(crate) fn of_a_servo(self) -> Self {
        Self {
            allowed: MODELLED,
            ..self
        }
    }

    /// The limit, and the share without whitening, for the wrench of a machine that is no docking rig, beside a smooth remainder.
    /// Constants count: with most of a mass in the model, a friction one way is most of what is named.
    pub(crate) fn of_a_machine(self) -> Self {
        Self {
            allowed: HALF,
            share: self.plain.min(self.with_constants),
            ..self
        }
    }

    /// The limit for effects that stand beside a smooth remainder; `left` is what effects and remainder together leave.
    pub(crate) fn beside(self, remainder: &Remainder, left: &Self) -> Self {
        let described = left.share <= DESCRIBED && !remainder.is_of_contact();
        match described {
            true => Self {
                allowed: NAMELESS,
                share: self.plain,
                ..self
            },
            false => Self {
                allowed: MODELLED,
                ..self
            },
        }
    }

    /// Whether the logs show structure, and more is left than is allowed.
    pub(crate) fn any(&self) -> bool {
        self.share > self.allowed && self.is_structured()
    }

    /// Whether the logs show any structure.
    pub(crate) fn is_structured(&self) -> bool {
        self.structured().next().is_some()
    }

    /// Axes that show structure on all logs.
    pub(crate) fn structured(&self) -> impl Iterator<Item = &(Channel, Axis, Vec<Structure>)> {
        self.axes
            .iter()
            .filter(|(_, _, each)| Structure::in_all(each))
    }
}

/// What effects, and a smooth remainder of each log if there is one, leave of the wrench.
pub(crate) fn of_wrench(
    joint: &Joint,
    tested: Option<&TestedHypothesis>,
    smooth: &[Column],
) -> RemainingStructure {
    let gain = tested.map_or(0.0, |t| t.gain);
    of_rests(joint, &joint.rests(tested, smooth), gain, Constant::Common)
}

/// The same with effects whose amounts are fitted to each log on its own; `gain` is the fall of χ² by all of them together.
pub(crate) fn of_wrench_apart(joint: &Joint, own: &[Column], gain: f64) -> RemainingStructure {
    of_rests(joint, &joint.rests(None, own), gain, Constant::Own)
}

/// The constant whose removal counts for no effect, as any offset would remove it.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Constant {
    /// All logs share it.
    Common,
    /// Each log has one of its own.
    Own,
    /// None: what effects remove of a constant counts, too.
    Counts,
}

fn of_rests(joint: &Joint, rests: &[Rest], gain: f64, constant: Constant) -> RemainingStructure {
    let each = joint.logs.iter().zip(rests);
    let of_logs: Vec<(Vec<Structure>, Excess)> =
        each.map(|(log, rest)| of_log(joint, log, rest)).collect();
    let axes = Axis::ALL
        .into_iter()
        .map(|axis| {
            let each = of_logs.iter().map(|(s, _)| s[axis.index()].clone());
            (Channel::Wrench, axis, each.collect())
        })
        .collect();
    let sum = |of: &dyn Fn(&Excess) -> f64| of_logs.iter().map(|(_, e)| of(e)).sum::<f64>();
    let left = sum(&|e| e.plain);
    let raw = |rest: &Rest| rest.raw.clone();
    let exact = |rest: &Rest| rest.exact.clone();
    let plain = share(left, removed(joint, rests.iter().map(raw), constant));
    let by_effects = removed(joint, rests.iter().map(exact), Constant::Counts);
    let white = share(sum(&|e| e.white), joint.explained_beyond_zeros(gain));
    RemainingStructure {
        axes,
        share: if joint.has_remainder {
            plain
        } else {
            plain.max(white)
        },
        plain,
        with_constants: share(left, by_effects),
        allowed: REMAINDER,
    }
}

/// What is left as a share of what there was: `left` + `removed`, at least 1.
fn share(left: f64, removed: f64) -> f64 {
    let (left, removed) = (left.max(0.0), removed.max(0.0));
    left / (left + removed).max(1.0)
}

/// By how much the χ² that a log leaves exceeds its number of values.
struct Excess {
    /// Of the whitened residual.
    white: f64,
    /// Of the residual in units of the data sheet's noise: whitening can swallow what is locked to the motion.
    plain: f64,
}

/// By how much χ² is lower with the `rests` of all logs, in units of the data sheet's noise. What `constant` would remove is not
/// counted: to remove an offset is no merit of an effect.
fn removed(joint: &Joint, rests: impl Iterator<Item = Column>, constant: Constant) -> f64 {
    let changes = |columns: &[Column], axis: usize| {
        let each = joint.logs.iter().zip(columns);
        let sums = each.map(|(log, column)| {
            let count = log.fresh.iter().filter(|fresh| **fresh).count() as f64;
            let (mean, level) = moments(log, column, axis);
            (count, count * mean, count * level * level)
        });
        let about_mean = |(count, sum, power): (f64, f64, f64)| power - sum * sum / count.max(1.0);
        match constant {
            Constant::Own => sums.map(about_mean).sum(),
            Constant::Common => about_mean(sums.fold((0.0, 0.0, 0.0), |all, one| {
                (all.0 + one.0, all.1 + one.1, all.2 + one.2)
            })),
            Constant::Counts => sums.map(|(_, _, power)| power).sum(),
        }
    };
    let nominal = |log: &PreparedLog| {
        let mut nominal = log.scene.change_by_known_effects();
        nominal.add(&log.residual.0);
        nominal
    };
    let nominal: Vec<Column> = joint.logs.iter().map(nominal).collect();
    let rests: Vec<Column> = rests.collect();
    let taken = |axis| changes(&nominal, axis) - changes(&rests, axis);
    (0..6).map(taken).sum()
}

/// Structure of each axis of a log, and the excess of χ² over its number of values.
fn of_log(joint: &Joint, log: &PreparedLog, rest: &Rest) -> (Vec<Structure>, Excess) {
    let (white, levels) = beyond_rounding(log, rest);
    let squares: f64 = white.0.iter().flatten().map(|w| w * w).sum();
    let values = joint.problem.axes * log.fresh.iter().filter(|f| **f).count();
    let structures: Vec<Structure> = (0..6)
        .map(|axis| {
            let level = levels[axis].unwrap_or_else(|| moments(log, &rest.raw, axis).1);
            if log.scene.model.sensor.at_rest {
                // Rows that do not follow each other have no spectrum.
                return Structure {
                    level,
                    ..Structure::default()
                };
            }
            counted(log, &white.0[axis], level)
        })
        .collect();
    let values = values as f64;
    let of_axis = values / joint.problem.axes as f64;
    let left: f64 = structures.iter().map(|s| s.level * s.level).sum();
    let excess = Excess {
        white: squares - values,
        plain: left * of_axis - values,
    };
    (structures, excess)
}

/// Mean and root mean square of a column over the cycles that count, in units of the data sheet's noise.
fn moments(log: &PreparedLog, column: &Column, axis: usize) -> (f64, f64) {
    let counted = column.0[axis].iter().zip(&log.fresh);
    let counted = counted.filter(|(_, fresh)| **fresh).map(|(r, _)| *r);
    let sums = counted.fold((0.0, 0.0, 0.0), |(sum, power, count), r| {
        (sum + r, power + r * r, count + 1.0)
    });
    let (sum, power, count) = sums;
    let count = f64::max(count, 1.0);
    let sheet = log.sheet_sigma[axis];
    (sum / count / sheet, (power / count).sqrt() / sheet)
}

/// Tests only the cycles that count, joined to one series, and maps what is found back to cycles of the log.
fn counted(log: &PreparedLog, white: &[f64], level: f64) -> Structure {
    let counts = log.fresh.iter().enumerate();
    let places: Vec<usize> = counts.filter(|(_, c)| **c).map(|(n, _)| n).collect();
    let series: Vec<f64> = places
        .iter()
        .filter_map(|n| white.get(*n).copied())
        .collect();
    let filter = log.scene.model.sensor.filter;
    let cutoff_hz = filter.map_or(f64::INFINITY, |filter| filter.cutoff_hz);
    let mut found = Structure::below(cutoff_hz, &series, log.counted_cycle_s(), level);
    let place = |n: usize| places.get(n).copied().unwrap_or_default();
    let of_all = |(first, length): (usize, usize)| {
        let last = place(first + length.saturating_sub(1));
        (place(first), last.saturating_sub(place(first)) + 1)
    };
    found.burst_at = of_all(found.burst_at);
    for line in [&mut found.line, &mut found.narrow] {
        line.at = of_all(line.at);
    }
    found.length = log.fresh.len();
    found
}

/// Rounded readings get residuals of their own, and a level over the data sheet's noise. The tolerances were fitted as if
/// rounding were noise, so the fit that includes them counts only where it costs less than the exact one.
fn beyond_rounding(log: &PreparedLog, rest: &Rest) -> (Column, [Option<f64>; 6]) {
    let sheet = sheet_sigma(&log.scene.model);
    let mut white = rest.white.clone();
    let levels = std::array::from_fn(|axis| {
        let half = log.half_step[axis];
        (half > 0.0).then(|| {
            let [with, exact] =
                [&rest.raw, &rest.exact].map(|r| Rounded::new(&r.0[axis], half, sheet[axis]));
            let mut own = if with.cost < exact.cost { with } else { exact };
            // A repeated reading carries no new information.
            for (residual, fresh) in own.white.iter_mut().zip(&log.fresh) {
                if !fresh {
                    *residual = 0.0;
                }
            }
            let squares: f64 = own.white.iter().map(|r| r * r).sum();
            white.0[axis] = own.white;
            let fresh = log.fresh.iter().filter(|f| **f).count();
            (squares / fresh.max(1) as f64).sqrt() * own.sigma / sheet[axis]
        })
    });
    (white, levels)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The whitened share differs before and after `add`, as what the model has already is no gain of the search. The answer must
    /// not differ.
    #[test]
    fn beside_a_remainder_the_plain_share_decides() {
        let left = RemainingStructure {
            share: 0.27,
            plain: 0.16,
            with_constants: 0.2,
            ..RemainingStructure::default()
        };
        let remainder = Remainder::default();
        let described = left
            .clone()
            .beside(&remainder, &RemainingStructure::default());
        assert_eq!((described.share, described.allowed), (0.16, NAMELESS));
        let much = RemainingStructure {
            share: 0.2,
            ..RemainingStructure::default()
        };
        let undescribed = left.clone().beside(&remainder, &much);
        assert_eq!((undescribed.share, undescribed.allowed), (0.27, MODELLED));
        let of_a_machine = left.of_a_machine();
        assert_eq!((of_a_machine.share, of_a_machine.allowed), (0.16, HALF));
    }
}
