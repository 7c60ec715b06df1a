//! How a point of M moves along the guide or about the bearing, of which a friction depends.

use super::column::Column;

/// A point of M on which a guide may act.
#[derive(Clone, Debug, Default)]
pub(super) struct Guided {
    /// Its velocity along the guide, m/s; of a bearing rad/s.
    pub(super) velocity: Vec<f64>,
    /// Root mean square of it.
    pub(super) rms_speed: f64,
    /// Way from one reversal to the next, where most of the way is made, m or rad.
    pub(super) usual_stroke: f64,
    /// Reading of a force of 1 N along the guide; of a torque of 1 N·m about a bearing.
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

/// Mean length of the strokes between reversals, each weighed by its length: what trembles at rest makes many and counts little.
fn usual_stroke(velocity: &[f64], cycle_s: f64) -> f64 {
    let strokes = velocity.chunk_by(|a, b| a.signum() == b.signum());
    let lengths = strokes.map(|stroke| (cycle_s * stroke.iter().sum::<f64>()).abs());
    let (sum, squares) = lengths.fold((0.0, 0.0), |(sum, squares), length| {
        (sum + length, squares + length * length)
    });
    if sum > 0.0 { squares / sum } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Ten strokes of 0.3 m, and a tremble of a micrometre for as long.
    #[test]
    fn a_tremble_at_rest_makes_no_stroke_shorter() {
        let strokes = (0..10).flat_map(|k| vec![if k % 2 == 0 { 0.1 } else { -0.1 }; 300]);
        let tremble = (0..3000).map(|n| if n % 2 == 0 { 1e-4 } else { -1e-4 });
        let velocity: Vec<f64> = strokes.chain(tremble).collect();
        let stroke = usual_stroke(&velocity, 0.01);
        assert!((stroke - 0.3).abs() < 1e-3, "{stroke}");
        assert_eq!(usual_stroke(&[0.0; 5], 0.01), 0.0);
    }
}
