//! Positions of a campaign's draws in the unit cube.
//!
//! Every coordinate is a pure function of the campaign's seed, the number of the draw and the factor's name. An added factor
//! therefore leaves the draws of the others unchanged (except with `sobol` and `saltelli`, whose axes are in the order of the
//! file).

use anyhow::{Result, ensure};
use serde::{Deserialize, Serialize};
use softdock_statistics::RandomStream;

/// Largest number of points and of axes for which the Sobol' sequence is known.
const SOBOL: (u64, usize) = (1 << 16, 256);
/// Number of the random stream that shuffles; no draw has this number.
const SHUFFLE: u64 = u64::MAX;

/// Design of the draws.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// Independent draws.
    #[default]
    Random,
    /// Each axis is divided into as many slices as there are draws, and each slice has one draw.
    LatinHypercube,
    /// Owen-scrambled Sobol' points.
    Sobol,
    /// Pairs of Sobol' points that exchange one axis at a time, for Sobol' indices (Saltelli 2010): each sample takes as many
    /// runs as there are axes, plus two.
    Saltelli,
}

/// The draws of a campaign as points in the unit cube.
#[derive(Clone, Debug)]
pub struct Design {
    kind: Kind,
    seed: u64,
    /// Position in the random stream for each axis, from its name.
    places: Vec<u64>,
    samples: u64,
    /// Latin hypercube: for each axis, the slice of each draw.
    slices: Vec<Vec<u64>>,
}

impl Design {
    /// A design with these axes.
    ///
    /// # Errors
    /// There are more draws or axes than the Sobol' sequence has.
    pub fn new(kind: Kind, seed: u64, axes: &[String], samples: u64) -> Result<Self> {
        let places: Vec<u64> = axes.iter().map(|name| place(name)).collect();
        let used = match kind {
            Kind::Saltelli => 2 * axes.len(),
            _ => axes.len(),
        };
        if matches!(kind, Kind::Sobol | Kind::Saltelli) {
            let (longest, most) = SOBOL;
            ensure!(
                samples <= longest && used <= most,
                "Sobol' points are known for {longest} samples of {most} axes; {samples} of {used} were asked for"
            );
        }
        let slices = match kind {
            Kind::LatinHypercube => places.iter().map(|p| shuffled(seed, *p, samples)).collect(),
            _ => Vec::new(),
        };
        Ok(Self {
            kind,
            seed,
            places,
            samples,
            slices,
        })
    }

    /// Number of points.
    pub fn points(&self) -> u64 {
        self.samples * self.runs_per_sample()
    }

    /// Number of points that belong to one sample.
    pub fn runs_per_sample(&self) -> u64 {
        match self.kind {
            Kind::Saltelli => self.places.len() as u64 + 2,
            _ => 1,
        }
    }

    /// Coordinate of a point along an axis, in (0, 1).
    pub fn coordinate(&self, point: u64, axis: usize) -> f64 {
        let own = || RandomStream::at(self.seed, point, self.places[axis]).uniform();
        match self.kind {
            Kind::Random => inside(own()),
            Kind::LatinHypercube => {
                let slice = self.slices[axis][point as usize] as f64;
                inside((slice + own()) / self.samples as f64)
            }
            Kind::Sobol => self.sobol(point, axis),
            Kind::Saltelli => {
                let (sample, run) = (
                    point / self.runs_per_sample(),
                    point % self.runs_per_sample(),
                );
                // Run 0 is A, run 1 is B, run 2 + i is A with axis i of B.
                let of_b = run == 1 || run == axis as u64 + 2;
                let axes = self.places.len();
                self.sobol(sample, if of_b { axes + axis } else { axis })
            }
        }
    }

    fn sobol(&self, point: u64, axis: usize) -> f64 {
        // The seed selects the shuffling and scrambling of the sequence.
        let seed = (self.seed ^ (self.seed >> 32)) as u32;
        f64::from(sobol_burley::sample(point as u32, axis as u32, seed)).max(f64::EPSILON)
    }
}

/// Position in a random stream, from a name.
pub(super) fn place(name: &str) -> u64 {
    super::checksum::checksum(&[name.as_bytes()])
}

/// Keeps a coordinate below 1, where quantiles of some distributions are infinite.
fn inside(u: f64) -> f64 {
    u.min(1.0 - f64::EPSILON)
}

/// 0 to `count` − 1 in random order (Fisher and Yates).
fn shuffled(seed: u64, place: u64, count: u64) -> Vec<u64> {
    let mut random = RandomStream::at(seed, SHUFFLE, place);
    let mut order: Vec<u64> = (0..count).collect();
    for last in (1..order.len()).rev() {
        let other = (inside(random.uniform()) * (last + 1) as f64) as usize;
        order.swap(last, other);
    }
    order
}

#[cfg(test)]
mod tests {
    use super::*;

    fn design(kind: Kind, axes: &[&str], samples: u64) -> Design {
        let axes: Vec<String> = axes.iter().map(|name| (*name).to_owned()).collect();
        Design::new(kind, 1, &axes, samples).unwrap()
    }

    fn along(design: &Design, axis: usize) -> Vec<f64> {
        let points = 0..design.points();
        points.map(|point| design.coordinate(point, axis)).collect()
    }

    #[test]
    fn an_added_factor_leaves_the_others_where_they_were() {
        for kind in [Kind::Random, Kind::LatinHypercube] {
            let (few, more) = (
                design(kind, &["a", "b"], 50),
                design(kind, &["new", "b", "a"], 50),
            );
            assert_eq!(along(&few, 0), along(&more, 2));
            assert_eq!(along(&few, 1), along(&more, 1));
            assert_ne!(along(&few, 0), along(&few, 1));
        }
    }

    #[test]
    fn every_slice_of_a_latin_hypercube_has_one_draw() {
        let design = design(Kind::LatinHypercube, &["a", "b"], 97);
        for axis in 0..2 {
            let mut slices: Vec<u64> = along(&design, axis)
                .iter()
                .map(|u| (u * 97.0) as u64)
                .collect();
            slices.sort_unstable();
            assert_eq!(slices, (0..97).collect::<Vec<_>>());
        }
    }

    #[test]
    fn sobol_points_fill_every_box_evenly() {
        // A (0, 6, 2)-net: each elementary box of area 1/64 has one of 64 points.
        let design = design(Kind::Sobol, &["a", "b"], 64);
        let (a, b) = (along(&design, 0), along(&design, 1));
        for across in [1, 2, 4, 8, 16, 32, 64_u64] {
            let cell = |(a, b): (&f64, &f64)| {
                (
                    (a * across as f64) as u64,
                    (b * (64 / across) as f64) as u64,
                )
            };
            let cells: std::collections::BTreeSet<_> = a.iter().zip(&b).map(cell).collect();
            assert_eq!(cells.len(), 64, "{across}");
        }
    }

    #[test]
    fn saltelli_exchanges_one_axis_at_a_time() {
        let design = design(Kind::Saltelli, &["a", "b", "c"], 8);
        assert_eq!(design.points(), 40);
        let at = |point| [0, 1, 2].map(|axis| design.coordinate(point, axis));
        for sample in 0..8 {
            let [a, b] = [at(5 * sample), at(5 * sample + 1)];
            assert_eq!(at(5 * sample + 2), [b[0], a[1], a[2]]);
            assert_eq!(at(5 * sample + 4), [a[0], a[1], b[2]]);
        }
    }

    #[test]
    fn too_many_points_are_refused() {
        let error = Design::new(Kind::Sobol, 1, &["a".to_owned()], 70_000).unwrap_err();
        assert!(error.to_string().contains("65536"), "{error}");
    }
}
