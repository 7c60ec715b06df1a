//! How a diagnosis ends, by what the stages found.

use super::finding::Verdict;

/// What decides.
#[derive(Clone, Copy, Debug)]
pub(super) struct Grounds {
    /// The logs hold something that a model can be held against.
    pub testable: bool,
    /// Effects were found.
    pub found: bool,
    /// What is missing differs from log to log.
    pub disagree: bool,
    /// Beside what was found there is structure.
    pub left: bool,
    /// There is no second log: effects are judged on what they were fitted on.
    pub in_sample: bool,
    /// One effect was asked for. Who asks gets it, whatever else there is.
    pub asked: bool,
}

impl Grounds {
    /// Whether something is left without a name. Beside effects, that has to show on two logs.
    pub(super) const fn unexplained(self) -> bool {
        self.left && !self.asked && !(self.in_sample && self.found)
    }

    /// The end.
    pub(super) const fn verdict(self) -> Verdict {
        if !self.testable {
            Verdict::NotTestable
        } else if self.disagree && !self.asked {
            Verdict::LogsDisagree
        } else if self.unexplained() {
            Verdict::Unexplained
        } else if self.found {
            Verdict::Named
        } else {
            Verdict::NothingMissing
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every combination, and the rules a second time.
    #[test]
    fn each_combination_has_the_end_that_is_promised() {
        for bits in 0..64_u8 {
            let [testable, found, disagree, left, in_sample, asked] =
                std::array::from_fn(|n| bits >> n & 1 == 1);
            let grounds = Grounds {
                testable,
                found,
                disagree,
                left,
                in_sample,
                asked,
            };
            let expected = match (testable, disagree, left, asked, found, in_sample) {
                (false, ..) => Verdict::NotTestable,
                (true, true, _, false, ..) => Verdict::LogsDisagree,
                (true, false, true, false, false, _) => Verdict::Unexplained,
                (true, false, true, false, true, false) => Verdict::Unexplained,
                (true, _, _, _, true, _) => Verdict::Named,
                (true, _, _, _, false, _) => Verdict::NothingMissing,
            };
            assert_eq!(grounds.verdict(), expected, "{grounds:?}");
            let nameless = left && !asked && (!found || !in_sample);
            assert_eq!(grounds.unexplained(), nameless, "{grounds:?}");
        }
    }
}
