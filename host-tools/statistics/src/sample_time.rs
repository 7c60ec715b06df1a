//! The sample time of rows whose time stamps may be rounded.

use crate::median;

/// Median step of ascending times. If it differs from the mean of all steps of similar length, that mean is taken: stamps in
/// milliseconds of rows every 8.85 ms have steps of mostly 9 ms, and a velocity computed with 9 ms is 1.7 % too small. None
/// without a step.
///
/// ```
/// use softdock_statistics::sample_time;
/// let stamps = |rows: u32| (0..rows).map(|n| (8.85 * f64::from(n)).round() * 1e-3);
/// assert!((sample_time(stamps(1000)).unwrap() - 8.85e-3).abs() < 1e-6);
/// assert_eq!(sample_time([0.0, 0.5, 1.0, 7.0, 7.5].into_iter()), Some(0.5));
/// assert_eq!(sample_time([3.0].into_iter()), None);
/// ```
pub fn sample_time(times: impl Iterator<Item = f64>) -> Option<f64> {
    /// Range of similar steps, relative to the median: longer ones are gaps, shorter ones errors.
    const ALIKE: std::ops::Range<f64> = 0.5..1.5;
    /// Relative difference of mean and median above which the time stamps are taken to be rounded.
    const DIGITS: f64 = 1e-3;
    let times: Vec<f64> = times.collect();
    let steps = times.windows(2).map(|pair| pair[1] - pair[0]);
    let mut steps: Vec<f64> = steps.filter(|step| step.is_finite()).collect();
    let middle = median(&mut steps)?;
    steps.retain(|step| ALIKE.contains(&(step / middle)));
    let mean = steps.iter().sum::<f64>() / steps.len().max(1) as f64;
    let is_rounded = (mean - middle).abs() > DIGITS * middle;
    Some(if is_rounded { mean } else { middle })
}
