//! The state of the board, and an operator's commands.

use super::Board;
use crate::cli::{answer, print, print_json};
use anyhow::{Context, Result, bail};
use serde::Serialize;
use softdock_commissioning::parameters::words;
use softdock_control::modes::{Command, FaultCode, Refusal};
use softdock_io::input::nearest;
use softdock_link::service::{
    AnswerTimes, Counters, EthernetHealth, InputStatistics, Machine, Origin, StackUse, Status,
};
use softdock_report::number::{percent, significant};
use std::fmt::Write;
use std::time::Duration;

/// Parses a period in s, 0.05 to 3600.
pub(super) fn period(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(period) if (0.05..=3600.0).contains(&period) => Ok(period),
        _ => Err("expected 0.05 to 3600 s".into()),
    }
}

#[derive(Serialize)]
struct Sample {
    status: Status,
    counters: Counters,
}

impl Board {
    pub(super) fn print_status(&mut self) -> Result<()> {
        let status = self.client.status()?;
        let counters = self.client.counters()?;
        // Older firmware does not know this request.
        let machine = self.client.machine().ok();
        let log = self.client.log(0)?;
        if self.json {
            return print_json(&serde_json::json!({
                "identity": self.client.identity().text,
                "schema": format!("{:08x}", self.client.identity().schema),
                "status": status,
                "counters": counters,
                "machine": machine,
                "log": log,
            }));
        }
        let mut out = String::new();
        // Writing to a String cannot fail.
        let _ = writeln!(out, "settings  {}", origin(&status.origin));
        let _ = writeln!(out, "mode      {}", mode(&status));
        let _ = writeln!(out, "robot     {}", robot(&status, &counters));
        let _ = writeln!(out, "sensor    {}", sensor(&status, &counters));
        let _ = writeln!(
            out,
            "service   {} frames, {} damaged",
            counters.frames, counters.damaged_frames
        );
        if let Some(machine) = &machine {
            let _ = write!(out, "{}", lines(machine));
        }
        if let Some((name, expected, received)) = &status.fault {
            let _ = writeln!(
                out,
                "FAULT     {}: expected {expected}, received {received}",
                words::<FaultCode>(name)
            );
        }
        if let Some((command, refusal)) = &status.refusal {
            let _ = writeln!(out, "refused   {command}: {}", words::<Refusal>(refusal));
        }
        for line in log {
            let at_s = line.at_ms as f64 * 1e-3;
            let _ = writeln!(out, "{at_s:>9.3} {}", line.text);
        }
        print(&out)
    }

    pub(super) fn watch(&mut self, period_s: f64, samples: Option<usize>) -> Result<()> {
        let mut taken = Vec::new();
        for number in 1.. {
            let status = self.client.status().with_context(|| self.port.clone())?;
            let counters = self.client.counters().with_context(|| self.port.clone())?;
            match self.json {
                true => taken.push(Sample { status, counters }),
                false => print(&line(&status, &counters))?,
            }
            if samples.is_some_and(|samples| number >= samples) {
                break;
            }
            std::thread::sleep(Duration::from_secs_f64(period_s));
        }
        match self.json {
            true => print_json(&serde_json::json!({ "samples": taken })),
            false => Ok(()),
        }
    }

    /// Sends a command and waits until a control cycle has taken it.
    pub(super) fn mode(&mut self, text: &str) -> Result<()> {
        let words = || Command::WORDS.iter().map(|(word, _)| *word);
        if Command::from_word(text).is_none() {
            let offer = nearest(text, words()).map(|near| format!("; did you mean `{near}`?"));
            let known: Vec<&str> = words().collect();
            bail!(
                "`{text}` is no command{}; known are {}",
                offer.unwrap_or_default(),
                known.join(", ")
            );
        }
        let status = self.client.operate(text);
        let status = status.with_context(|| self.port.clone())?;
        let document = serde_json::json!({ "command": text, "mode": status.mode });
        answer(self.json, &document, || format!("mode {}\n", status.mode))
    }
}

fn origin(origin: &Origin) -> String {
    match origin {
        Origin::Flash { sequence } => format!("{sequence}"),
        Origin::Trial { sequence, left_s } => {
            format!("{sequence} ON TRIAL, {left_s} s left to confirm")
        }
        Origin::Defaults { reason } => format!("DEFAULTS, not to be armed: {reason}"),
    }
}

fn mode(status: &Status) -> String {
    let moves = match status.moves {
        true => ", settings cannot change now",
        false => "",
    };
    format!("{}{moves}", status.mode)
}

fn robot(status: &Status, counters: &Counters) -> String {
    format!(
        "{}; {} cycles, {} lost, {} twice, {} overtaken, {} malformed, {} foreign, {} runs",
        match status.robot {
            true => "connected",
            false => "silent",
        },
        counters.cycles,
        counters.lost,
        counters.duplicates,
        counters.overtaken,
        counters.malformed,
        counters.foreign,
        counters.runs
    )
}

fn sensor(status: &Status, counters: &Counters) -> String {
    let state = match status.sensor.as_str() {
        "" => "not started",
        state => state,
    };
    format!(
        "{state}; {} timeouts, {} retries, {} late, {} unpaired, {} unknown, {} invalid; CAN: {} bus-off, {} losses",
        counters.sensor_timeouts,
        counters.sensor_retries,
        counters.sensor_late,
        counters.sensor_unpaired,
        counters.sensor_unknown,
        counters.sensor_invalid,
        counters.bus_offs,
        counters.can_losses
    )
}

/// State of the microcontroller as the board reports it, one line per part.
fn lines(machine: &Machine) -> String {
    let mut out = String::new();
    // Writing to a String cannot fail.
    if let Some(used) = &machine.stack {
        let _ = writeln!(out, "stack     {}", stack(used, &machine.reset));
    }
    if let Some(health) = &machine.ethernet {
        let _ = writeln!(out, "ethernet  {}", ethernet(health));
    }
    if machine.answers != AnswerTimes::NONE {
        let _ = writeln!(out, "answers   {}", answers(&machine.answers));
    }
    if let Some(work) = &machine.work {
        let _ = writeln!(
            out,
            "work      {} cycles of the processor for an answer, at most {}",
            work.last, work.most
        );
    }
    if machine.inputs != InputStatistics::NONE {
        let _ = writeln!(out, "noise     {}", noise(&machine.inputs));
    }
    out
}

fn stack(stack: &StackUse, reset: &str) -> String {
    let share = f64::from(stack.deepest) / f64::from(stack.available);
    format!(
        "{} of {} bytes at its deepest, {}; reset by: {reset}",
        stack.deepest,
        stack.available,
        percent(share, 0)
    )
}

fn ethernet(ethernet: &EthernetHealth) -> String {
    format!(
        "{}; lost {} times, reception brought back {} times",
        match ethernet.link {
            true => "linked",
            false => "no link",
        },
        ethernet.losses,
        ethernet.overruns
    )
}

fn answers(times: &AnswerTimes) -> String {
    format!(
        "after {} µs, at most {} µs, {} later than a cycle",
        times.last_us,
        times.longest_us,
        times.late_answers()
    )
}

fn noise(inputs: &InputStatistics) -> String {
    let of = |value: f32, digits| significant(f64::from(value), digits);
    format!(
        "about {} N and {} N·m rms; telegrams each {} µs ± about {} µs",
        of(inputs.force_noise_n, 2),
        of(inputs.torque_noise_n_m, 2),
        of(inputs.cycle_us, 5),
        of(inputs.cycle_deviation_us, 2)
    )
}

fn line(status: &Status, counters: &Counters) -> String {
    let fault = status
        .fault
        .as_ref()
        .map(|(name, ..)| format!("  FAULT {name}"));
    format!(
        "{:>9.1} s  {:<8} robot {:<9} sensor {:<10} {} cycles, {} lost{}\n",
        status.uptime_ms as f64 * 1e-3,
        status.mode,
        match status.robot {
            true => "connected",
            false => "silent",
        },
        status.sensor,
        counters.cycles,
        counters.lost,
        fault.unwrap_or_default()
    )
}
