//! Measurements by the robot task of itself and its inputs, after an answer was sent: how long the answer took, how noisy the
//! sensor is, how regular the telegrams are. For people only: no cycle uses them.

use crate::record::CycleRecord;
use micromath::F32Ext;
use softdock_control::io::Sequence;
use softdock_link::service::{AnswerTimes, InputStatistics, Work};

/// Cycles of a window of statistics: about a second.
const WINDOW: u32 = 250;

/// Measures.
#[derive(Clone, Copy, Debug, Default)]
pub struct Meter {
    answers: AnswerTimes,
    inputs: InputStatistics,
    work: Option<Work>,
    /// The count of the processor's cycles when the telegram was read.
    begun: Option<u32>,
    window: Window,
    /// When the last telegram came, µs, and the number and the wrench of its sample.
    last: Option<(u64, u32, [f64; 6])>,
}

/// Sums over the present window.
#[derive(Clone, Copy, Debug, Default)]
struct Window {
    samples: u32,
    /// Squares of the differences from sample to sample, summed over three axes.
    force: f64,
    torque: f64,
    intervals: u32,
    /// Sum of the deviations of the intervals from a cycle, µs.
    sum: f64,
    squares: f64,
}

impl Meter {
    /// Takes in an answered cycle: when its telegram came and when the answer was sent, µs.
    pub fn take(&mut self, record: &CycleRecord, came_us: u64, gone_us: u64, cycle_us: u64) {
        let took_us = gone_us.saturating_sub(came_us);
        let took_us = u32::try_from(took_us).unwrap_or(u32::MAX);
        self.answers
            .take(took_us, u32::try_from(cycle_us).unwrap_or(u32::MAX));
        let sensor = &record.inputs.sensor;
        if let Some((last_us, counter, wrench)) = self.last {
            if record.inputs.robot.sequence == Sequence::Next {
                let interval_us = came_us.saturating_sub(last_us);
                self.window.interval(interval_us as f64 - cycle_us as f64);
            }
            if sensor.counter != counter {
                self.window.sample(&sensor.wrench, &wrench);
            }
        }
        self.last = Some((came_us, sensor.counter, sensor.wrench));
        if self.window.intervals >= WINDOW {
            self.inputs = self.window.statistics(cycle_us as f64);
            self.window = Window::default();
        }
    }

    /// A telegram is read; `cycles` is the processor's cycle count.
    pub fn begin(&mut self, cycles: Option<u32>) {
        self.begun = cycles;
    }

    /// Its answer was sent at this cycle count.
    pub fn end(&mut self, cycles: Option<u32>) {
        if let (Some(begun), Some(now)) = (self.begun, cycles) {
            let last = now.wrapping_sub(begun);
            let most = self.work.map_or(0, |work| work.most).max(last);
            self.work = Some(Work { last, most });
        }
    }

    /// Cycles of the processor for an answer.
    pub fn work(&self) -> Option<Work> {
        self.work
    }

    /// All answers since boot.
    pub fn answers(&self) -> AnswerTimes {
        self.answers
    }

    /// The inputs of the last whole window.
    pub fn inputs(&self) -> InputStatistics {
        self.inputs
    }
}

impl Window {
    fn interval(&mut self, deviation_us: f64) {
        self.intervals += 1;
        self.sum += deviation_us;
        self.squares += deviation_us * deviation_us;
    }

    fn sample(&mut self, now: &[f64; 6], last: &[f64; 6]) {
        self.samples += 1;
        let mut squares = now
            .iter()
            .zip(last)
            .map(|(now, last)| (now - last) * (now - last));
        self.force += squares.by_ref().take(3).sum::<f64>();
        self.torque += squares.sum::<f64>();
    }

    fn statistics(&self, cycle_us: f64) -> InputStatistics {
        let count = f64::from(self.intervals.max(1));
        let mean = self.sum / count;
        let variance = (self.squares / count - mean * mean).max(0.0);
        // The difference of two samples has twice the variance of one.
        let differences = 2.0 * 3.0 * f64::from(self.samples.max(1));
        InputStatistics {
            force_noise_n: root(self.force / differences),
            torque_noise_n_m: root(self.torque / differences),
            cycle_us: (cycle_us + mean) as f32,
            cycle_deviation_us: root(variance),
        }
    }
}

/// micromath's square root: cheap without a floating-point unit, and accurate enough for display.
fn root(square: f64) -> f32 {
    F32Ext::sqrt(square as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Relative error that micromath's root may have.
    const ROOT: f64 = 0.065;

    #[test]
    fn the_root_is_off_by_no_more_than_is_said() {
        let mut worst = 0.0_f64;
        for n in -400..400 {
            let square = 1.07_f64.powi(n).clamp(1e-9, 1e9);
            let error = f64::from(root(square)) / square.sqrt() - 1.0;
            worst = worst.max(error.abs());
        }
        assert!((0.03..ROOT).contains(&worst), "{worst}");
        assert!(root(0.0) < 1e-15, "{}", root(0.0));
    }

    /// Telegrams that come 10 µs early and late in turn, with ±0.3 N and ±0.01 N·m around a load that
    /// grows by 0.01 N per cycle.
    #[test]
    fn noise_and_unevenness_are_found_in_a_changing_load() {
        let mut meter = Meter::default();
        let mut record = CycleRecord::default();
        record.inputs.robot.sequence = Sequence::Next;
        for n in 0..2 * u64::from(WINDOW) {
            let sign = if n % 2 == 0 { 1.0 } else { -1.0 };
            let load = 0.01 * n as f64;
            record.inputs.sensor.counter = n as u32;
            record.inputs.sensor.wrench = [load + 0.3 * sign, 0.0, 0.0, 0.0, 0.01 * sign, 0.0];
            let came_us = 1_000_000 + 4000 * n + if n % 2 == 0 { 10 } else { 0 };
            meter.take(&record, came_us, came_us + 260, 4000);
        }
        let (inputs, answers) = (meter.inputs(), meter.answers());
        // Differences of twice the amplitude, on one axis of three.
        let expected = |amplitude: f64| (4.0 * amplitude * amplitude / 6.0).sqrt();
        let near = |value: f32, expected: f64| (f64::from(value) / expected - 1.0).abs() < ROOT;
        assert!(near(inputs.force_noise_n, expected(0.3)), "{inputs:?}");
        assert!(near(inputs.torque_noise_n_m, expected(0.01)), "{inputs:?}");
        assert!((inputs.cycle_us - 4000.0).abs() < 0.1, "{inputs:?}");
        assert!(near(inputs.cycle_deviation_us, 10.0), "{inputs:?}");
        assert_eq!(
            (answers.longest_us, answers.histogram[1]),
            (260, 2 * WINDOW)
        );
    }

    /// Telegrams of which each is 4 µs later than a cycle after the one before.
    #[test]
    fn a_slow_clock_of_the_robot_is_even() {
        let mut meter = Meter::default();
        let mut record = CycleRecord::default();
        record.inputs.robot.sequence = Sequence::Next;
        for n in 0..=u64::from(WINDOW) {
            meter.take(&record, 4004 * n, 4004 * n, 4000);
        }
        let inputs = meter.inputs();
        assert!((inputs.cycle_us - 4004.0).abs() < 0.1, "{inputs:?}");
        assert!(inputs.cycle_deviation_us < 1e-3, "{inputs:?}");
    }

    #[test]
    fn cycles_of_the_processor_are_counted_over_a_wrap_and_the_most_is_kept() {
        let mut meter = Meter::default();
        meter.begin(None);
        meter.end(None);
        assert_eq!(meter.work(), None, "no counter");
        for (begun, gone) in [(u32::MAX - 99, 200), (1000, 1100)] {
            meter.begin(Some(begun));
            meter.end(Some(gone));
        }
        let (last, most) = (100, 300);
        assert_eq!(meter.work(), Some(Work { last, most }));
    }

    #[test]
    fn a_sample_that_comes_again_is_no_quiet_sensor() {
        let mut meter = Meter::default();
        let mut record = CycleRecord::default();
        record.inputs.robot.sequence = Sequence::Next;
        for n in 0..=u64::from(WINDOW) {
            record.inputs.sensor.counter = (n / 10) as u32;
            record.inputs.sensor.wrench[0] = if n / 10 % 2 == 0 { 1.0 } else { -1.0 };
            meter.take(&record, 4000 * n, 4000 * n, 4000);
        }
        let expected = (4.0_f64 / 6.0).sqrt();
        let noise = f64::from(meter.inputs().force_noise_n);
        assert!((noise / expected - 1.0).abs() < ROOT, "{noise}");
    }
}
