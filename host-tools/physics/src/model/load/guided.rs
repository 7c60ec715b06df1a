//! Motion of a point of M along the guide or about the bearing, on which friction depends.

use super::column::Column;

/// A point of M on which a guide may act.
#[derive(Clone, Debug, Default)]
pub(super) struct Guided {
    /// Its velocity along the guide, m/s; of a bearing rad/s.
    pub(super) velocity: Vec<f64>,
    /// Root mean square of it.
    pub(super) rms_speed: f64,
    /// Path between reversals, weighted by its length, m or rad.
    pub(super) usual_stroke: f64,
    /// Reading of a force of 1 N along the guide, or of a torque of 1 N·m about a bearing.
    pub(super) unit: Column,
}

impl Guided {
    pub(super) fn new(velocity: Vec<f64>, unit: Column, cycle_s: f64) -> Self {
        let squares: f64 = velocity.iter().map(|v| v * v).sum();
        Self {
            rms_speed: (squares / velocity.len().max(1) as f64).sqrt(),
            usual_stroke: usual_stroke(&velocity, cycle_s),
            velocity,
            unit,
        }
    }
}

/// Mean length of the strokes between reversals, each weighted by its length; small trembling does not count as a stroke.
fn usual_stroke(velocity: &[f64], cycle_s: f64) -> f64 {
    let (sum, squares) = strokes(velocity, cycle_s)
        .into_iter()
        .fold((0.0, 0.0), |(sum, squares), length| {
            (sum + length, squares + length * length)
        });
    if sum > 0.0 { squares / sum } else { 0.0 }
}

/// Lengths of the path between successive turning points.
fn strokes(velocity: &[f64], cycle_s: f64) -> Vec<f64> {
    /// Share of the whole range by which a motion has to come back to count as reversed. Set by hand: noise is less.
    const BACK: f64 = 0.02;
    let mut at = 0.0;
    let known = velocity.iter().filter(|v| v.is_finite());
    let way: Vec<f64> = known
        .map(|v| {
            at += cycle_s * v;
            at
        })
        .collect();
    let least = way.iter().copied().fold(0.0, f64::min);
    let most = way.iter().copied().fold(0.0, f64::max);
    let back = BACK * (most - least);
    let (mut turned, mut farthest, mut sense) = (0.0, 0.0_f64, 0.0_f64);
    let mut lengths = Vec::new();
    for at in way {
        if sense == 0.0 {
            if (at - turned).abs() > back {
                (farthest, sense) = (at, f64::signum(at - turned));
            }
        } else if sense * (at - farthest) > 0.0 {
            farthest = at;
        } else if sense * (farthest - at) > back {
            lengths.push(f64::abs(farthest - turned));
            (turned, farthest, sense) = (farthest, at, -sense);
        }
    }
    lengths.push(f64::abs(farthest - turned));
    lengths
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Ten strokes of 0.3 m with noise, of which one pauses, and a tremble of a micrometre for as long.
    #[test]
    fn what_trembles_makes_no_stroke_shorter() {
        let stroke = |k: usize| {
            let sense = if k.is_multiple_of(2) { 0.1 } else { -0.1 };
            (0..300).map(move |n| sense + if n % 2 == 0 { 0.15 } else { -0.15 })
        };
        let pause = std::iter::repeat_n(0.0, 50);
        let first = stroke(0).take(150).chain(pause).chain(stroke(0).skip(150));
        let strokes = first.chain((1..10).flat_map(stroke));
        let tremble = (0..3000).map(|n| if n % 2 == 0 { 1e-4 } else { -1e-4 });
        let velocity: Vec<f64> = strokes.chain(tremble).collect();
        let both: Vec<Vec<f64>> = [1.0, -1.0]
            .map(|sense| velocity.iter().map(|v| sense * v).collect())
            .into();
        for velocity in both {
            let stroke = usual_stroke(&velocity, 0.01);
            assert!((stroke - 0.3).abs() < 5e-3, "{stroke}");
        }
        assert_eq!(usual_stroke(&[0.0; 5], 0.01), 0.0);
        assert_eq!(usual_stroke(&[f64::NAN, 1.0], 0.01), 0.01);
    }
}
