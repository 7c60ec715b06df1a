//! An operator's command, and whether the board has carried it out.

use super::Client;
use super::words::{named, words};
use anyhow::{Result, bail};
use softdock_control::modes::Refusal;
use softdock_link::service::{Answer, Request, Status};
use std::time::{Duration, Instant};

/// Longest time for a command to be carried out: cycles come every 4 ms.
const TIMEOUT: Duration = Duration::from_secs(3);
/// How often it is looked whether it was.
const POLL_INTERVAL: Duration = Duration::from_millis(20);

impl Client {
    /// Gives a command and waits until a cycle has taken it. Returns the state after it.
    ///
    /// # Errors
    /// The board refuses it, with what to do; or no cycle takes it.
    pub fn operate(&mut self, command: &str) -> Result<Status> {
        let before = self.status()?.commands;
        self.call(&Request::Mode(command), |answer| {
            (answer == Answer::Done).then_some(())
        })?;
        let give_up = Instant::now() + TIMEOUT;
        let status = loop {
            let status = self.status()?;
            if status.commands != before {
                break status;
            }
            if Instant::now() > give_up {
                bail!(
                    "`{command}` waits: the robot sends no telegrams any more (a new RSI run drops it)"
                );
            }
            std::thread::sleep(POLL_INTERVAL);
        };
        if let Some((refused, why)) = &status.refusal
            && refused.as_str() == command
        {
            let mend = named(why).and_then(mend).map(|mend| format!("; {mend}"));
            let (why, mend) = (words::<Refusal>(why), mend.unwrap_or_default());
            bail!("{refused} refused in mode {}: {why}{mend}", status.mode);
        }
        Ok(status)
    }
}

/// What a person can do about a refusal.
fn mend(refusal: Refusal) -> Option<&'static str> {
    Some(match refusal {
        Refusal::SensorStale => "look at its line (`softdock doctor`)",
        Refusal::SensorUnhealthy => "`softdock doctor` says which",
        Refusal::NoPose => "load the configuration of `softdock robot-config` (RIst)",
        Refusal::ForceTooLarge => {
            "it is beyond `control.start.max_force_n` or `max_torque_n_m`: is the tool \
             free, is the sensor calibrated (`softdock calibrate sensor`)?"
        }
        Refusal::StillMoving => "wait until it has",
        Refusal::MovedSinceArmed => "arm again",
        Refusal::TooFewSamples => "wait until the sensor has rested for a second",
        Refusal::OrientationSingular => "turn the robot away from B = ±90°",
        Refusal::NoRoom => {
            "it could leave the box (`control.limits`) around the pose in which RSI began, or come \
             near B = ±90°: move the robot and start RSI anew, jog the other way, or lower \
             `control.jog.reach_m` or `reach_rad`"
        }
        Refusal::WrongMode => return None,
    })
}
