//! Zero-phase low-pass: a Butterworth filter run forwards and backwards over a whole signal.
//!
//! If two signals go through the same filter, a linear fit of one to the other stays valid. That is why an import filters
//! either all measured signals or none, and why predictions from sent velocities are filtered, too. With both passes the
//! amplitude at the cutoff is one half.

use std::f64::consts::PI;

/// Length of the extension at each end, in periods of the cutoff. The transient of the filter has decayed when the signal
/// begins: to exp(−2π·8·0.38) = 5e-9 for order 4.
const SETTLING_PERIODS: f64 = 8.0;

/// A second-order section with unit gain at rest, in transposed direct form II.
#[derive(Clone, Copy, Debug)]
struct Section {
    b: [f64; 3],
    /// Coefficients of the denominator without the leading 1.
    a: [f64; 2],
}

/// A Butterworth low-pass.
#[derive(Clone, Debug)]
pub struct LowPass {
    sections: Vec<Section>,
    padding: usize,
}

impl LowPass {
    /// A filter of `order` with its cutoff at `cutoff` of the sampling rate, 0 < cutoff < 0.5.
    ///
    /// The analogue poles `exp(jπ(2k+1+n)/2n)` go through the bilinear transform with the cutoff
    /// prewarped (Oppenheim, Schafer, Discrete-Time Signal Processing, 7.1).
    pub fn new(order: u32, cutoff: f64) -> Self {
        let warped = (PI * cutoff).tan();
        let pairs = (0..order / 2).map(|k| {
            // Distance of a pole pair from the imaginary axis: half of its damping.
            let damping = (PI * f64::from(2 * k + 1) / f64::from(2 * order)).sin();
            let norm = 1.0 + 2.0 * damping * warped + warped * warped;
            let b = warped * warped / norm;
            Section {
                b: [b, 2.0 * b, b],
                a: [
                    2.0 * (warped * warped - 1.0) / norm,
                    (1.0 - 2.0 * damping * warped + warped * warped) / norm,
                ],
            }
        });
        let single = (order % 2 == 1).then(|| {
            let b = warped / (1.0 + warped);
            Section {
                b: [b, b, 0.0],
                a: [(warped - 1.0) / (1.0 + warped), 0.0],
            }
        });
        Self {
            sections: pairs.chain(single).collect(),
            padding: (SETTLING_PERIODS / cutoff).ceil() as usize,
        }
    }

    /// Filters a signal without a phase shift. Each end is extended by the point reflection of the signal about its end
    /// point, which keeps value and slope.
    pub fn zero_phase(&self, signal: &[f64]) -> Vec<f64> {
        let (Some(first), Some(last)) = (signal.first(), signal.last()) else {
            return Vec::new();
        };
        let padding = self.padding.min(signal.len() - 1);
        let before = signal[1..=padding].iter().rev().map(|v| 2.0 * first - v);
        let after = signal[signal.len() - 1 - padding..signal.len() - 1]
            .iter()
            .rev()
            .map(|v| 2.0 * last - v);
        let mut values: Vec<f64> = before.chain(signal.iter().copied()).chain(after).collect();
        for _ in 0..2 {
            self.run(&mut values);
            values.reverse();
        }
        values[padding..padding + signal.len()].to_vec()
    }

    /// Runs the filter over the values, starting in the steady state of the first value.
    fn run(&self, values: &mut [f64]) {
        let start = values.first().copied().unwrap_or(0.0);
        for pair in self.sections.chunks(2) {
            match *pair {
                [first, second] => chained(values, start, [first, second]),
                [single, ..] => chained(values, start, [single]),
                [] => {}
            }
        }
    }
}

/// Runs sections in series, value by value: the processor overlaps the second section's work on a value with the first
/// section's work on the next.
fn chained<const N: usize>(values: &mut [f64], start: f64, sections: [Section; N]) {
    // In the steady state the output equals the input, which determines the state.
    let mut states = sections.map(|Section { b, a }| [(1.0 - b[0]) * start, (b[2] - a[1]) * start]);
    for value in values {
        for (Section { b, a }, state) in sections.iter().zip(&mut states) {
            let input = *value;
            let output = b[0] * input + state[0];
            state[0] = b[1] * input - a[0] * output + state[1];
            state[1] = b[2] * input - a[1] * output;
            *value = output;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Amplitude and phase shift (samples) of a filtered sine, measured in the middle of the signal.
    fn response(order: u32, cutoff: f64, frequency: f64) -> (f64, f64) {
        let n = 4000;
        let angle = |i: usize| 2.0 * PI * frequency * i as f64;
        let signal: Vec<f64> = (0..n).map(|i| angle(i).sin()).collect();
        let filtered = LowPass::new(order, cutoff).zero_phase(&signal);
        let middle = 1000..3000;
        let count = middle.len() as f64;
        let sine: f64 = middle.clone().map(|i| filtered[i] * angle(i).sin()).sum();
        let cosine: f64 = middle.map(|i| filtered[i] * angle(i).cos()).sum();
        let (s, c) = (2.0 * sine / count, 2.0 * cosine / count);
        (s.hypot(c), c.atan2(s) / (2.0 * PI * frequency))
    }

    #[test]
    fn the_amplitude_is_that_of_butterworth_twice_and_nothing_is_shifted() {
        for order in 1..=6 {
            for (cutoff, frequency) in [(0.05_f64, 0.01_f64), (0.05, 0.05), (0.1, 0.2), (0.2, 0.05)]
            {
                let ratio = (PI * frequency).tan() / (PI * cutoff).tan();
                let expected = 1.0 / (1.0 + ratio.powi(2 * order as i32));
                let (amplitude, shift) = response(order, cutoff, frequency);
                assert!(
                    (amplitude - expected).abs() < 1e-6,
                    "order {order}, {frequency} of {cutoff}: {amplitude} {expected}"
                );
                assert!(shift.abs() < 1e-6 || expected < 1e-4, "{order}: {shift}");
            }
        }
    }

    #[test]
    fn a_straight_line_passes_to_its_very_ends() {
        let line: Vec<f64> = (0..500).map(|i| 3.0 - 0.1 * f64::from(i)).collect();
        let filtered = LowPass::new(4, 0.05).zero_phase(&line);
        for (a, b) in line.iter().zip(&filtered) {
            assert!((a - b).abs() < 1e-6, "{a} {b}");
        }
        assert!(LowPass::new(4, 0.05).zero_phase(&[]).is_empty());
        assert_eq!(LowPass::new(4, 0.05).zero_phase(&[2.0]), [2.0]);
    }
}
