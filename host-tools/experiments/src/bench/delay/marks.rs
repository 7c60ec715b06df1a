//! Thresholds of good and bad results, and their marks in tables.

use softdock_report::Mark;

/// A restitution within this of the ideal one is good.
const GOOD: f64 = 0.005;
/// A restitution that is off by more than this is bad.
pub(super) const BAD: f64 = 0.05;
/// Momentum that a law may add, as a share of the rebound's, without a star.
pub(super) const ADDED: f64 = 0.01;
/// What the marks mean.
pub(super) const MARKS: &str =
    "✓ within 0.5 % of the ideal test, · within 5 %, ✗ further off; momentum: ✓ to 2 %";
/// Name of the cases of the headline.
pub(super) const HEADLINE: &str = "headline";

/// Judges momentum that no measured force accounts for.
pub(super) fn mark_of_momentum(added: f64) -> Mark {
    if added <= 2.0 * ADDED {
        Mark::Good
    } else {
        Mark::Bad
    }
}

/// Judges a relative error.
pub(super) fn mark_of_error(error: f64) -> Mark {
    if error <= GOOD {
        Mark::Good
    } else if error <= BAD {
        Mark::Neutral
    } else {
        Mark::Bad
    }
}
