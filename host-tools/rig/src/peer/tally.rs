//! Counters of a run, and their summary.

use serde::Serialize;
use std::fmt;

/// Counters of a rig in real time.
#[derive(Clone, Debug, Default)]
pub struct Tally {
    /// Times that RSI began and was answered.
    pub runs: u64,
    /// Telegrams of those runs.
    pub cycles: u64,
    /// Telegrams that were answered before the next one left.
    pub in_time: u64,
    /// Telegrams whose answer the rig had to wait for.
    pub waited: u64,
    /// Telegrams that were not answered.
    pub unanswered: u64,
    /// Answers that came behind the next telegram.
    pub late: u64,
    /// Datagrams that were no answers.
    pub malformed: u64,
    /// Times that this computer itself was late by a cycle or more.
    pub stalls: u64,
    /// Sum and greatest of the times to an answer, s.
    pub answer_s: (f64, f64),
    /// Readings that the sensor has given.
    pub readings: u64,
    /// Times that a contact began.
    pub contacts: u64,
    /// Greatest contact force, N.
    pub greatest_force_n: f64,
    /// When the latches caught the spacecraft in this run, s.
    pub captured_s: Option<f64>,
    /// The capture switch asks the board to stop.
    pub asks_to_stop: bool,
    /// Why the robot stopped, the last time that it did.
    pub robot_stopped: Option<String>,
}

/// Summary of a run, for output.
#[derive(Clone, Debug, Serialize)]
pub struct Summary {
    /// Times that RSI began and was answered.
    pub runs: u64,
    /// Telegrams of those runs.
    pub cycles: u64,
    /// Answers in time.
    pub in_time: u64,
    /// Answers that came too late.
    pub late: u64,
    /// Late answers that the rig waited for.
    pub waited: u64,
    /// Answers that never came.
    pub missed: u64,
    /// Datagrams that were no answers.
    pub malformed: u64,
    /// Times that this computer itself was late by a cycle or more.
    pub own_stalls: u64,
    /// Mean time to an answer, ms.
    pub answer_mean_ms: Option<f64>,
    /// Longest time to an answer in time, ms.
    pub answer_slowest_ms: Option<f64>,
    /// Readings that the sensor has given.
    pub sensor_readings: u64,
    /// Times that a contact began.
    pub contacts: u64,
    /// Greatest contact force, N.
    pub greatest_force_n: f64,
    /// When the latches caught the spacecraft in the last run, s.
    pub captured_s: Option<f64>,
    /// Why the robot stopped, the last time that it did.
    pub robot_stopped: Option<String>,
}

impl Tally {
    /// Counts an answer, which was in time or waited for.
    pub(super) fn answered(&mut self, after_s: f64, waited: bool) {
        if waited {
            self.waited += 1;
            return;
        }
        self.in_time += 1;
        self.answer_s.0 += after_s;
        self.answer_s.1 = self.answer_s.1.max(after_s);
    }

    /// Summary of the counters.
    pub fn summary(&self) -> Summary {
        let some = self.in_time > 0;
        Summary {
            runs: self.runs,
            cycles: self.cycles,
            in_time: self.in_time,
            late: self.late + self.waited,
            waited: self.waited,
            missed: self.unanswered.saturating_sub(self.late),
            malformed: self.malformed,
            own_stalls: self.stalls,
            answer_mean_ms: some.then(|| 1e3 * self.answer_s.0 / self.in_time as f64),
            answer_slowest_ms: some.then_some(1e3 * self.answer_s.1),
            sensor_readings: self.readings,
            contacts: self.contacts,
            greatest_force_n: self.greatest_force_n,
            captured_s: self.captured_s,
            robot_stopped: self.robot_stopped.clone(),
        }
    }
}

impl fmt::Display for Summary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{} cycles: {} answered in time, {} late, {} not at all",
            self.cycles, self.in_time, self.late, self.missed
        )?;
        if let (Some(mean), Some(slowest)) = (self.answer_mean_ms, self.answer_slowest_ms) {
            write!(f, " (mean {mean:.2} ms, slowest {slowest:.2} ms)")?;
        }
        if self.waited > 0 {
            write!(
                f,
                "\nthe rig's clock waited for {} late answers",
                self.waited
            )?;
        }
        write!(
            f,
            "\n{} readings of the sensor, {} contacts, greatest contact force {:.1} N",
            self.sensor_readings, self.contacts, self.greatest_force_n
        )?;
        if let Some(captured_s) = self.captured_s {
            write!(f, "\nthe latches closed at {captured_s:.3} s")?;
        }
        if self.malformed > 0 {
            write!(f, "\n{} datagrams were no answers", self.malformed)?;
        }
        if self.own_stalls > 0 {
            write!(
                f,
                "\nthis computer itself was late by a cycle or more {} times: it is too busy for the pace of a robot{}",
                self.own_stalls,
                if self.waited > 0 {
                    ""
                } else {
                    "; --patient lets the rig wait for the board"
                }
            )?;
        }
        Ok(())
    }
}
