//! Where readings come from.

use anyhow::Result;
use nalgebra::UnitQuaternion;
use softdock_control::frames::{self, Pose, Wrench};
use softdock_control::io::SensorSample;
use softdock_control::settings::SensorSettings;
use softdock_io::recording::Recording;
use softdock_physics::model::prediction::signals::{Signals, Step};

/// Time between two recordings that are read one after the other, s.
const BETWEEN_S: f64 = 1.0;

/// A raw reading of the sensor with the pose in which it was read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reading {
    /// Time, s.
    pub time_s: f64,
    /// Whether it follows the reading before it after one cycle, without a gap.
    pub continues: bool,
    /// Pose of M in C.
    pub pose: Pose<f64>,
    /// Raw wrench in S.
    pub wrench: Wrench<f64>,
}

/// Something that delivers readings one by one.
pub trait Source {
    /// The next reading; None at the end.
    ///
    /// # Errors
    ///
    /// The source fails.
    fn next_reading(&mut self) -> Result<Option<Reading>>;

    /// All readings that are left.
    ///
    /// # Errors
    ///
    /// The source fails.
    fn readings(&mut self) -> Result<Vec<Reading>> {
        let mut all = Vec::new();
        while let Some(reading) = self.next_reading()? {
            all.push(reading);
        }
        Ok(all)
    }
}

/// The readings of recordings as if they had been made one after the other.
///
/// # Errors
///
/// Those of [`RecordedReadings`].
pub fn one_after_the_other<'a>(
    recordings: impl IntoIterator<Item = &'a Recording>,
) -> Result<Vec<Reading>> {
    let mut all: Vec<Reading> = Vec::new();
    for recording in recordings {
        let mut own = RecordedReadings::new(recording)?.readings()?;
        if let (Some(last), Some(first)) = (all.last(), own.first()) {
            let later_s = last.time_s + BETWEEN_S - first.time_s;
            own.iter_mut().for_each(|reading| reading.time_s += later_s);
        }
        all.extend(own);
    }
    Ok(all)
}

/// Status bits of a sample for which its reading is none: those that the board does not ignore.
pub(super) fn error_bits(sample: &SensorSample, settings: &SensorSettings) -> u32 {
    sample.status & !settings.ignored_status_bits
}

/// Whether a sample of a recording is usable, by the settings of its board; of another rig's log no bit is ignored.
fn is_healthy(sample: &SensorSample, signals: &Signals<'_>) -> bool {
    let settings = signals.settings.as_ref().map(|settings| &settings.sensor);
    let bits = settings.map_or(sample.status, |settings| error_bits(sample, settings));
    !sample.saturated && bits == 0
}

/// A sentence on readings of a recording that cannot be used; None if all can.
///
/// # Errors
///
/// Those of [`RecordedReadings`].
pub fn unusable(recording: &Recording) -> Result<Option<String>> {
    let signals = Signals::new(recording)?;
    let cycles = signals.cycles.iter();
    let bad = cycles.filter(|c| !is_healthy(&c.inputs.sensor, &signals));
    let times_s: Vec<f64> = bad.map(|cycle| cycle.trace.time_s).collect();
    let (Some(first), Some(last)) = (times_s.first(), times_s.last()) else {
        return Ok(None);
    };
    Ok(Some(format!(
        "{} readings between {first:.1} s and {last:.1} s are left out: the sensor is saturated or reports an error; a \
         pose in which it does is none.",
        times_s.len()
    )))
}

/// Mounting of the sensor on the flange.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Mounting {
    /// Pose of S in M.
    pub m_from_s: Pose<f64>,
}

impl Mounting {
    /// As the settings say.
    pub fn new(settings: &SensorSettings) -> Self {
        Self {
            m_from_s: frames::pose(&settings.position_m, &settings.orientation_wxyz),
        }
    }

    /// Orientation of S in C for a pose of M.
    pub fn c_from_s(&self, c_from_m: &Pose<f64>) -> UnitQuaternion<f64> {
        c_from_m.rotation * self.m_from_s.rotation
    }
}

/// The readings of a recording: cycles with a pose and a new, healthy sample.
#[derive(Debug)]
pub struct RecordedReadings<'a> {
    signals: Signals<'a>,
    next: usize,
    /// The last cycle that was delivered.
    last: Option<usize>,
}

impl<'a> RecordedReadings<'a> {
    /// Of a recording.
    ///
    /// # Errors
    ///
    /// Those of [`Signals::new`].
    pub fn new(recording: &'a Recording) -> Result<Self> {
        Ok(Self {
            signals: Signals::new(recording)?,
            next: 0,
            last: None,
        })
    }

    fn at(&self, n: usize) -> Option<Reading> {
        let cycle = &self.signals.cycles[n];
        let sensor = &cycle.inputs.sensor;
        let good = is_healthy(sensor, &self.signals);
        let pose = self.signals.pose(n)?;
        (good && self.signals.sampled_in(n) == Some(n)).then(|| Reading {
            time_s: cycle.trace.time_s,
            continues: self.last.is_some_and(|last| last + 1 == n)
                && self.signals.steps[n] == Step::Next,
            pose,
            wrench: Wrench::of(&sensor.wrench),
        })
    }
}

impl Source for RecordedReadings<'_> {
    fn next_reading(&mut self) -> Result<Option<Reading>> {
        while self.next < self.signals.len() {
            let n = self.next;
            self.next += 1;
            if let Some(reading) = self.at(n) {
                self.last = Some(n);
                return Ok(Some(reading));
            }
        }
        Ok(None)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use softdock_app::record::CycleRecord;

    /// A bit that the user has declared ignored does not make a reading useless; another one does.
    #[test]
    fn ignored_status_bits_leave_readings() {
        let cycle = |n: u32| {
            let mut cycle = CycleRecord::default();
            cycle.trace.cycle = n.into();
            cycle.trace.time_s = f64::from(n) * 0.004;
            cycle.inputs.sensor.counter = n + 1;
            cycle.inputs.sensor.status = if n == 3 { 0x41 } else { 0x40 };
            cycle.inputs.robot.pose = Some([0.0; 6]);
            cycle
        };
        let mut recording = Recording {
            cycles: (0..10).map(cycle).collect(),
            ..Recording::default()
        };
        recording.header.settings_toml = "[control.sensor]\nignored_status_bits = 64\n".to_owned();
        let used = RecordedReadings::new(&recording)
            .unwrap()
            .readings()
            .unwrap();
        assert_eq!(used.len(), 9);
        let told = unusable(&recording).unwrap().unwrap();
        assert!(told.starts_with("1 readings between 0.0 s"), "{told}");
    }
}
