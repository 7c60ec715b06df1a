//! The amplitude of a simulated swing against that of the real one, whatever their phases do: the smallest error of the frequency turns
//! these, but only a wrong friction makes another amplitude.

/// Factor by which the amplitude is wrong, 1 or more, from measured and simulated positions: exp of the rms, over parts of the log, of
/// the logarithm of simulated over measured amplitude. None of a motion that does not swing.
pub(super) fn amplitude_factor(swing: &[[f64; 2]]) -> Option<f64> {
    /// Most parts of a log.
    const PARTS: usize = 16;
    /// Amplitudes below this share of the largest one are noise, and friction that no law of the catalogue describes.
    const SWINGS: f64 = 0.02;
    /// Crossings of the mean, in three periods, that a part has to have: by the phase in which a shorter one is cut its amplitude differs
    /// by more than some percent. A motion that has fewer is no swing, but coasts or creeps.
    const CROSSINGS: usize = 6;
    let mean = swing.iter().map(|both| both[0]).sum::<f64>() / swing.len() as f64;
    let above = |both: &[f64; 2]| both[0] > mean;
    let pairs = swing.windows(2);
    let crossings = pairs
        .filter(|pair| above(&pair[0]) != above(&pair[1]))
        .count();
    let count = (crossings / CROSSINGS).min(PARTS);
    if count == 0 {
        return None;
    }
    let parts = swing.chunks(swing.len().div_ceil(count));
    let amplitudes = parts.map(|part| {
        [0, 1].map(|k| {
            let count = part.len() as f64;
            let mean = part.iter().map(|both| both[k]).sum::<f64>() / count;
            let squares = part
                .iter()
                .map(|both| (both[k] - mean).powi(2))
                .sum::<f64>();
            (squares / count).sqrt()
        })
    });
    let amplitudes: Vec<[f64; 2]> = amplitudes.collect();
    let largest = amplitudes.iter().map(|both| both[0]).fold(0.0, f64::max);
    let swings = amplitudes.iter().filter(|both| both[0] > SWINGS * largest);
    let squares = swings.map(|[measured, simulated]| {
        let least = SWINGS * largest;
        (simulated.max(least) / measured).ln().powi(2)
    });
    let squares: Vec<f64> = squares.collect();
    let mean = squares.iter().sum::<f64>() / squares.len() as f64;
    Some(mean.sqrt().exp()).filter(|factor| factor.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A swing that loses this share of its amplitude in a second, at this rate, rad/s.
    fn decay(share: f64, rate: f64) -> impl Fn(usize) -> f64 {
        move |n| {
            let t = 0.01 * n as f64;
            (-share * t).exp() * (rate * t).cos()
        }
    }

    #[test]
    fn the_amplitude_counts_and_not_the_phase() {
        let factor = |simulated: &dyn Fn(usize) -> f64| {
            let measured = decay(0.1, 6.0);
            let both: Vec<[f64; 2]> = (0..2000).map(|n| [measured(n), simulated(n)]).collect();
            amplitude_factor(&both)
        };
        let in_time = factor(&decay(0.1, 6.0)).unwrap();
        let turned = factor(&decay(0.1, 6.1)).unwrap();
        assert!(
            (in_time - 1.0).abs() < 1e-9 && turned < 1.02,
            "{in_time} {turned}"
        );
        // Half of the friction: on average over 20 s the logarithm is off by 0.05/s times 11.5 s, rms.
        let half = factor(&decay(0.05, 6.0)).unwrap();
        assert!((half.ln() - 0.577).abs() < 0.02, "{half}");
        let creeps: Vec<[f64; 2]> = (0..2000).map(|n| [n as f64, n as f64]).collect();
        assert_eq!(amplitude_factor(&creeps), None);
        assert_eq!(amplitude_factor(&[]), None);
    }
}
