//! Jogs of a robot, live.

use crate::live::{LiveBoard, LiveRecorder};
use anyhow::{Context, Result, bail, ensure};
use softdock_control::jog::{Jog, JogSettings};
use softdock_control::modes::Command;
use softdock_link::service::Status;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Cycles of rest that are recorded before the first jog and after each: the robot is late, and its last commands show only then.
const REST: u64 = 100;

/// Longest time in which a robot may still execute commands after a stop.
const COMES_TO_REST: Duration = Duration::from_secs(5);

/// The jogs that are requested, and the board's settings for them.
#[derive(Clone, Debug)]
pub struct Jogs {
    /// The axes, in their order.
    pub axes: Vec<Jog>,
    settings: JogSettings,
    cycle_s: f64,
}

impl Jogs {
    /// The axes by the letters that follow `jog`: x, -y, c.
    ///
    /// # Errors
    /// An axis that does not exist, or a board that does not report its settings.
    pub fn new(board: &mut LiveBoard, axes: &[String]) -> Result<Self> {
        let axes: Result<Vec<Jog>> = axes.iter().map(|axis| named(axis)).collect();
        Ok(Self {
            axes: axes?,
            settings: JogSettings {
                speed_m_s: board.number("control.jog.speed_m_s")?,
                reach_m: board.number("control.jog.reach_m")?,
                speed_rad_s: board.number("control.jog.speed_rad_s")?,
                reach_rad: board.number("control.jog.reach_rad")?,
            },
            cycle_s: board.number("control.robot.cycle_s")?,
        })
    }

    /// Cycles of a jog.
    fn cycles(&self, jog: Jog) -> u64 {
        self.settings.excitation(jog, self.cycle_s).cycles().into()
    }

    /// What the robot will do, a line for each axis.
    pub fn announcement(&self) -> String {
        let mut text = String::new();
        for jog in &self.axes {
            let (speed, reach) = self.settings.motion(*jog);
            let fastest = speed * softdock_control::jog::excitation::FASTEST;
            let (reach, unit, fastest, rate) = match jog.is_rotation() {
                false => (reach * 1e3, "mm", fastest * 1e3, "mm/s"),
                true => (reach.to_degrees(), "°", fastest.to_degrees(), "°/s"),
            };
            let seconds = self.cycles(*jog) as f64 * self.cycle_s;
            text += &format!(
                "  {}: up to {reach:.3} {unit} to one side and back, at most {fastest:.3} {rate}, {seconds:.1} s\n",
                word(*jog)
            );
        }
        text
    }

    /// Jogs one axis after the other while `recorder` records; `progress` is told the share that is done
    /// and the axis. When `stop` is raised, the jog is stopped and no other one begins.
    ///
    /// # Errors
    /// The board refuses a jog, faults, or falls silent; or `stop` was raised.
    pub fn run(
        &self,
        board: &mut LiveBoard,
        recorder: &mut LiveRecorder,
        stop: &AtomicBool,
        mut progress: impl FnMut(f64, &str),
    ) -> Result<()> {
        let all: u64 = self.axes.iter().map(|jog| self.cycles(*jog) + REST).sum();
        rest(recorder, stop)?;
        let began = recorder.cycles();
        for jog in &self.axes {
            let word = word(*jog);
            let tell = |cycles| progress((cycles - began) as f64 / all as f64, word);
            if let Err(error) = watched(board, recorder, word, stop, tell) {
                // A motion that nobody watches any more is stopped, whatever the reason.
                stand_still(board).with_context(|| format!("{error:#}"))?;
                return Err(error);
            }
            rest(recorder, stop)?;
        }
        Ok(())
    }
}

/// Begins a jog and watches it until it is over; `tell` is told the cycles that were recorded.
///
/// # Errors
/// As [`Jogs::run`]; the robot may still move.
fn watched(
    board: &mut LiveBoard,
    recorder: &mut LiveRecorder,
    word: &str,
    stop: &AtomicBool,
    mut tell: impl FnMut(u64),
) -> Result<()> {
    let begun = board.client.operate(word);
    let mut status = begun.with_context(|| board.port.clone())?;
    while !is_over(&status, word)? {
        recorder.listen(|_| {})?;
        unless(stop)?;
        tell(recorder.cycles());
        let now = board.client.status();
        status = now.with_context(|| board.port.clone())?;
    }
    Ok(())
}

/// An error once `stop` is raised.
///
/// # Errors
/// It is.
fn unless(stop: &AtomicBool) -> Result<()> {
    ensure!(
        !stop.load(Ordering::Relaxed),
        "stopped: the robot stands still, and nothing was identified"
    );
    Ok(())
}

/// Records so many cycles while the robot rests.
fn rest(recorder: &mut LiveRecorder, stop: &AtomicBool) -> Result<()> {
    let enough = recorder.cycles() + REST;
    while recorder.cycles() < enough {
        recorder.listen(|_| {})?;
        unless(stop)?;
    }
    Ok(())
}

/// Ends a jog, and waits until nothing of it is left in the robot.
fn stand_still(board: &mut LiveBoard) -> Result<()> {
    let unsure = || {
        format!(
            "{}: the board did not confirm that the jog has ended; stop the robot itself",
            board.port
        )
    };
    let mut status = board.client.status().with_context(unsure)?;
    // A board that has latched a fault has ended the jog itself.
    if status.mode == "Jogging" {
        status = board.client.operate("stop").with_context(unsure)?;
    }
    let give_up = Instant::now() + COMES_TO_REST;
    while status.moves && Instant::now() < give_up {
        status = board.client.status().with_context(unsure)?;
    }
    ensure!(
        !status.moves,
        "{}: the board was stopped and is in mode {}, and the robot still moves; stop it itself",
        board.port,
        status.mode
    );
    Ok(())
}

/// Whether the jog is over; an error if it was broken off. A robot that is silent for a moment goes on; a longer silence is
/// noticed by the recorder.
fn is_over(status: &Status, word: &str) -> Result<bool> {
    if let Some((name, expected, received)) = &status.fault {
        bail!(
            "{word}: {name} (expected {expected}, received {received}): the robot stands still; mend the \
             cause, then `softdock params mode reset`"
        );
    }
    match status.mode.as_str() {
        "Jogging" => Ok(false),
        "Hold" => Ok(true),
        mode => bail!(
            "{word}: the board is in mode {mode} all at once; is somebody else working with it?"
        ),
    }
}

/// The jog of a letter: x, -x ..
fn named(axis: &str) -> Result<Jog> {
    let command = Command::from_word(&format!("jog {}", axis.trim()));
    match command {
        Some(Command::Jog(jog)) => Ok(jog),
        _ => bail!(
            "--axis {axis}: expected x, y, z, a, b or c, with a - before it for the other direction"
        ),
    }
}

/// The command of a jog.
fn word(jog: Jog) -> &'static str {
    let of = |(_, command): &&(&str, Command)| *command == Command::Jog(jog);
    Command::WORDS
        .iter()
        .find(of)
        .map_or("jog", |(word, _)| word)
}
