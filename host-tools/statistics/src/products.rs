//! Inner products of long series, of which a search computes millions, and root mean squares.

/// Sum of products of two series, over the length of the shorter one. Eight partial sums are kept, which the processor adds
/// in parallel.
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; 8];
    let (a_parts, b_parts) = (a.chunks_exact(8), b.chunks_exact(8));
    let both = a.len().min(b.len());
    let rest = both - both % 8..both;
    for (a, b) in a_parts.zip(b_parts) {
        for k in 0..8 {
            sums[k] += a[k] * b[k];
        }
    }
    let rest = a[rest.clone()].iter().zip(&b[rest]).map(|(a, b)| a * b);
    sums.iter().sum::<f64>() + rest.sum::<f64>()
}

/// Root mean square; 0 for an empty slice.
pub fn rms(values: &[f64]) -> f64 {
    let squares = values.iter().map(|v| v * v);
    (squares.sum::<f64>() / values.len().max(1) as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use super::dot;

    #[test]
    fn the_shorter_series_ends_the_sum() {
        let squares = |n: u32| f64::from(n * (n + 1) * (2 * n + 1) / 6);
        let up_to = |n: u32| (1..=n).map(f64::from).collect::<Vec<_>>();
        for (a, b) in [(0, 5), (5, 5), (8, 8), (19, 16), (16, 19), (9, 100)] {
            assert_eq!(dot(&up_to(a), &up_to(b)), squares(a.min(b)));
        }
    }
}
