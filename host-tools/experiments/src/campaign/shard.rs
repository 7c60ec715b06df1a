//! A shard: every N-th row of a campaign.

use std::fmt::{self, Display, Formatter};
use std::str::FromStr;

/// Shard `number` of `of`: the rows whose index modulo `of` is `number`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Shard {
    /// Number of this shard, from 0.
    pub number: u64,
    /// Number of shards.
    pub of: u64,
}

impl Shard {
    /// The whole campaign.
    pub const WHOLE: Self = Self { number: 0, of: 1 };

    /// Whether a row belongs to the shard. Neighbouring rows go to different shards, as the cost of a row drifts along a
    /// factor.
    pub fn has(self, index: u64) -> bool {
        index % self.of == self.number
    }

    /// File name of the shard's part.
    pub fn part(self) -> String {
        format!("part-{}-of-{}.parquet", self.number, self.of)
    }

    /// The shard of a part's file name; None if it is no such name.
    pub fn of_part(name: &str) -> Option<Self> {
        let numbers = name.strip_prefix("part-")?.strip_suffix(".parquet")?;
        numbers.replace("-of-", "/").parse().ok()
    }
}

impl Display for Shard {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.number, self.of)
    }
}

impl FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let numbers = text.split_once('/').and_then(|(number, of)| {
            Some(Self {
                number: number.parse().ok()?,
                of: of.parse().ok()?,
            })
        });
        let shard = numbers.filter(|shard| shard.number < shard.of);
        shard.ok_or_else(|| {
            format!("expected I/N with I from 0 to N-1, as in 0/40; received {text}")
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shards_are_numbers_below_their_count() {
        assert_eq!("3/40".parse(), Ok(Shard { number: 3, of: 40 }));
        for wrong in ["40/40", "1", "-1/2", "0/0", "a/b", ""] {
            let error = wrong.parse::<Shard>().unwrap_err();
            assert!(error.contains("as in 0/40"), "{error}");
        }
    }

    #[test]
    fn every_row_belongs_to_one_shard() {
        for index in 0..100 {
            let owners = (0..7).filter(|number| {
                Shard {
                    number: *number,
                    of: 7,
                }
                .has(index)
            });
            assert_eq!(owners.count(), 1);
        }
    }

    #[test]
    fn a_part_is_known_by_its_name() {
        let shard = Shard { number: 3, of: 40 };
        assert_eq!(Shard::of_part(&shard.part()), Some(shard));
        assert_eq!(Shard::of_part("part-3-of-40.parquet.tmp"), None);
    }
}
