//! A calibration while the robot is there: which pose comes next, and when there are enough.

use super::advice::{determined_by, open_words};
use super::gravity::Gravity;
use super::plan::{PlannedPose, plan};
use super::source::{Mounting, Reading, error_bits};
use super::standstill;
use anyhow::Result;
use nalgebra::{UnitQuaternion, Vector3};
use softdock_app::record::CycleRecord;
use softdock_control::frames::{Pose, Wrench, abc_from_orientation, orientation_from_abc};
use softdock_control::settings::SensorSettings;

/// Least number of poses: with one more than needed, a pose in which somebody leaned on the tool can be detected and left out.
pub const FEWEST_POSES: usize = 6;
/// Condition that is good enough: a whole plan has less than 5.
pub const GOOD_CONDITION: f64 = 8.0;
/// Rotation from all earlier poses that makes a pose a new one, rad.
const NEW_POSE_RAD: f64 = 0.1;

/// Watches the robot, and says what to do next.
pub struct Guide {
    sensor: SensorSettings,
    mounting: Mounting,
    tilt_rad: f64,
    /// Readings of the present standstill. Once its pose has been reported, the newest reading replaces the last one.
    stand: Vec<Reading>,
    /// Whether the pose of this standstill has been reported.
    told: bool,
    /// Sample of the last reading.
    counter: u32,
    /// Why the last reading cannot be used.
    useless: Option<String>,
    /// Orientations of M that were taken, no two of them alike.
    taken: Vec<UnitQuaternion<f64>>,
    /// Planned poses around the first of these.
    planned: Vec<PlannedPose>,
    /// Orientation of M in the rest before this stand.
    last: Option<UnitQuaternion<f64>>,
}

impl Guide {
    /// A guide for a sensor mounted as its settings say, with a plan that tilts the tool by `tilt_rad`.
    pub fn new(sensor: &SensorSettings, tilt_rad: f64) -> Self {
        Self {
            sensor: sensor.clone(),
            mounting: Mounting::new(sensor),
            tilt_rad,
            stand: Vec::new(),
            told: false,
            counter: 0,
            useless: None,
            taken: Vec::new(),
            planned: Vec::new(),
            last: None,
        }
    }

    /// Takes a cycle of the board.
    pub fn see(&mut self, record: &CycleRecord) {
        let (sensor, robot) = (&record.inputs.sensor, &record.inputs.robot);
        let fresh = sensor.counter != self.counter;
        self.counter = sensor.counter;
        let Some([x, y, z, a, b, c]) = robot.pose else {
            return;
        };
        if !fresh {
            return;
        }
        self.useless = match (sensor.saturated, error_bits(sensor, &self.sensor)) {
            (true, _) => {
                Some("the sensor is saturated: does the tool press against something?".into())
            }
            (false, 0) => None,
            (false, status) => Some(format!(
                "the sensor reports status 0x{status:x} (`softdock doctor`)"
            )),
        };
        if self.useless.is_some() {
            return;
        }
        let rotation = orientation_from_abc(&[a, b, c]);
        self.stand_on(Reading {
            time_s: record.trace.time_s,
            continues: true,
            pose: Pose::from_parts(Vector3::new(x, y, z).into(), rotation),
            wrench: Wrench::of(&sensor.wrench),
        });
    }

    /// Adds a reading to the present standstill, or drops the readings of one that is over and begins another.
    fn stand_on(&mut self, reading: Reading) {
        let first = self.stand.first();
        if first.is_some_and(|first| !standstill::is_still(first, &reading)) {
            self.stand.clear();
            self.told = false;
        } else if self.told {
            self.stand.pop();
        }
        self.stand.push(reading);
    }

    /// What was taken since the last call, in a sentence, and what comes next; None if nothing was.
    ///
    /// # Errors
    /// From the first pose no plan is possible.
    pub fn news(&mut self) -> Result<Option<String>> {
        if self.told || self.stand.is_empty() {
            return Ok(None);
        }
        let settled = standstill::settled_part(&self.stand, 0..self.stand.len());
        let own = &self.stand[settled];
        if !standstill::is_long(own) {
            return Ok(None);
        }
        self.told = true;
        let now = own[0].pose.rotation;
        let before = self.last.replace(now);
        if before.is_some_and(|last| last.angle_to(&now) < standstill::NEW_POSE_RAD) {
            return Ok(None);
        }
        if self.taken.iter().any(|t| t.angle_to(&now) < NEW_POSE_RAD) {
            let text = format!("{} was taken already; {}", degrees(&now), self.next());
            return Ok(Some(text));
        }
        if self.taken.is_empty() {
            self.planned = plan(
                &now,
                &self.mounting,
                self.sensor.gravity_m_s2,
                self.tilt_rad,
            )?;
        }
        self.taken.push(now);
        let mean =
            own.iter().fold(Wrench::zero(), |sum, r| sum + r.wrench) * (1.0 / own.len() as f64);
        Ok(Some(format!(
            "pose {} taken: {}, {}; {}",
            self.taken.len(),
            degrees(&now),
            newtons(&mean),
            self.next()
        )))
    }

    /// Whether there are enough poses, and they differ as they must.
    pub fn is_enough(&self) -> bool {
        self.taken.len() >= FEWEST_POSES && self.condition().is_some_and(|c| c <= GOOD_CONDITION)
    }

    /// Poses that were taken.
    pub fn poses(&self) -> usize {
        self.taken.len()
    }

    /// Present pose and force, for a person who watches.
    pub fn now(&self) -> String {
        if let Some(why) = &self.useless {
            return why.clone();
        }
        match self.stand.last() {
            None => "waiting for the pose and the sensor".to_owned(),
            Some(reading) => format!(
                "{}  {}",
                degrees(&reading.pose.rotation),
                newtons(&reading.wrench)
            ),
        }
    }

    /// Condition number of the calibration with the poses so far; None while a quantity is undetermined.
    fn condition(&self) -> Option<f64> {
        let gravity = Gravity::new(self.sensor.gravity_m_s2);
        let determined = determined_by(&self.taken, &self.mounting, &gravity);
        (determined.open == 0).then_some(determined.condition)
    }

    /// What is open, and where to go.
    fn next(&self) -> String {
        if self.is_enough() {
            return "that is enough".to_owned();
        }
        let gravity = Gravity::new(self.sensor.gravity_m_s2);
        let state = match self.condition() {
            Some(condition) => {
                format!("condition number {condition:.1}, expected at most {GOOD_CONDITION}")
            }
            None => open_words(&determined_by(&self.taken, &self.mounting, &gravity)),
        };
        let missing = self.planned.iter().find(|pose| {
            let there = orientation_from_abc::<f64>(&pose.abc_deg.map(f64::to_radians));
            self.taken
                .iter()
                .all(|t| t.angle_to(&there) >= NEW_POSE_RAD)
        });
        match missing {
            Some(pose) => {
                let [a, b, c] = pose.abc_deg;
                format!("{state}. Next: A {a:.1}°, B {b:.1}°, C {c:.1}°, or one like it")
            }
            None => format!("{state}. Next: any pose in which the tool hangs another way"),
        }
    }
}

fn degrees(rotation: &UnitQuaternion<f64>) -> String {
    // Rounded, and without the sign of a zero.
    let tenths = |angle: f64| (angle.to_degrees() * 10.0).round() / 10.0 + 0.0;
    let [a, b, c] = abc_from_orientation(rotation).map(tenths);
    format!("A {a:.1}°, B {b:.1}°, C {c:.1}°")
}

fn newtons(wrench: &Wrench<f64>) -> String {
    let [x, y, z, ..] = wrench.get();
    format!("force {x:.1}, {y:.1}, {z:.1} N")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn record(cycle: u64, abc_deg: [f64; 3]) -> CycleRecord {
        let [a, b, c] = abc_deg.map(f64::to_radians);
        let mut record = CycleRecord::default();
        record.trace.time_s = cycle as f64 * 0.004;
        record.inputs.sensor.counter = cycle as u32 + 1;
        record.inputs.robot.pose = Some([1.0, 0.0, 1.0, a, b, c]);
        record
    }

    /// Follows what it says, and is done with as many poses as it needs; a pose that was taken is
    /// not taken twice, and no pose is taken while the robot moves.
    #[test]
    fn a_person_who_follows_it_comes_to_an_end() {
        let mut guide = Guide::new(&SensorSettings::default(), 1.0);
        let mut cycle = 0;
        let mut rest = |guide: &mut Guide, abc_deg, cycles| {
            (0..cycles).for_each(|_| {
                guide.see(&record(cycle, abc_deg));
                cycle += 1;
            });
            guide.news().unwrap()
        };
        assert_eq!(rest(&mut guide, [0.0, 0.0, 180.0], 100), None);
        let first = rest(&mut guide, [0.0, 0.0, 180.0], 150).unwrap();
        assert!(first.starts_with("pose 1 taken: A 0.0°, B"), "{first}");
        for n in 0..200 {
            let moved = rest(&mut guide, [f64::from(n) * 0.3, 0.0, 180.0], 1);
            assert_eq!(moved, None);
        }
        assert_eq!(guide.stand.len(), 1, "of a motion nothing is kept");
        // Back in the pose that was taken last: no news.
        assert_eq!(rest(&mut guide, [0.0, 0.0, 180.0], 200), None);
        let planned: Vec<[f64; 3]> = guide.planned.iter().map(|p| p.abc_deg).collect();
        for abc_deg in &planned[1..] {
            assert!(!guide.is_enough());
            let [a, b, c] = abc_deg.map(|d| format!("{d:.1}°"));
            let next = guide.next();
            assert!(
                next.contains(&format!("Next: A {a}, B {b}, C {c}")),
                "{next}"
            );
            rest(&mut guide, *abc_deg, 200).unwrap();
            if guide.is_enough() {
                break;
            }
        }
        assert_eq!(guide.poses(), FEWEST_POSES);
        assert!(guide.condition().unwrap() <= GOOD_CONDITION);
    }

    #[test]
    fn a_status_bit_that_the_board_ignores_spoils_no_reading() {
        let settings = SensorSettings {
            ignored_status_bits: 0x40,
            ..SensorSettings::default()
        };
        let mut guide = Guide::new(&settings, 1.0);
        for (cycle, status, says) in [(0, 0x40, "A 0.0°"), (1, 0x41, "reports status 0x1 (")] {
            let mut record = record(cycle, [0.0; 3]);
            record.inputs.sensor.status = status;
            guide.see(&record);
            assert!(guide.now().contains(says), "{}", guide.now());
        }
    }
}
