//! The `softdock` command: one file per subcommand.

use anyhow::Result;
use clap::Parser;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use serde::Serialize;
use softdock_control::delay::LawName;
use softdock_report::Terminal;
use std::io::Write;
use std::sync::atomic::{AtomicBool, Ordering};

/// Defines an enumeration of subcommands with an `execute` that runs the chosen one.
macro_rules! commands {
    ($name:ident { $($command:ident($options:ty)),+ $(,)? }) => {
        #[derive(Debug, clap::Subcommand)]
        enum $name {
            $($command($options)),+
        }

        impl $name {
            fn execute(self) -> anyhow::Result<()> {
                match self {
                    $(Self::$command(command) => command.execute()),+
                }
            }
        }
    };
}

mod add;
mod agree;
mod bench;
mod board;
mod calibrate;
mod campaign;
mod check;
mod compare;
mod completions;
mod demo;
mod diagnose;
mod doctor;
mod effects;
mod export;
mod findings;
mod firmware;
mod fit;
mod flash;
mod history;
mod identify;
mod import;
mod init;
mod live;
mod logs;
mod outputs;
mod params;
mod piece_args;
mod progress;
mod qemu;
mod record;
mod remove;
mod replay;
mod reproduce;
mod rig;
mod robot_config;
mod run;
mod workbench;

/// Hardware-in-the-loop docking tests: run them, record them, and find out where model and rig
/// disagree.
///
/// Results go to standard output, everything else to standard error. Nothing is overwritten
/// without --force.
#[derive(Debug, Parser)]
#[command(
    name = "softdock",
    version,
    about,
    after_help = "Try it now, without hardware: softdock demo"
)]
pub struct Cli {
    #[command(subcommand)]
    command: Command,
}

commands!(Command {
    Demo(demo::Demo),
    Init(init::Init),
    Run(run::Run),
    Board(board::Board),
    Rig(rig::RigCommand),
    Firmware(firmware::Firmware),
    Flash(flash::Flash),
    Record(record::Record),
    Qemu(qemu::QemuCommand),
    Params(params::Params),
    RobotConfig(robot_config::RobotConfig),
    Calibrate(calibrate::Calibrate),
    Check(check::CheckCommand),
    Identify(identify::Identify),
    Doctor(doctor::Doctor),
    Compare(compare::Compare),
    Diagnose(diagnose::Diagnose),
    Add(add::Add),
    Remove(remove::Remove),
    Fit(fit::Fit),
    History(history::History),
    Bench(bench::Bench),
    Campaign(campaign::Campaign),
    Effects(effects::Effects),
    Reproduce(reproduce::Reproduce),
    Replay(replay::Replay),
    Export(export::Export),
    Import(import::Import),
    Workbench(workbench::Workbench),
    Completions(completions::Completions),
    Man(completions::Man),
});

impl Cli {
    /// Carries the command out.
    pub fn execute(self) -> Result<()> {
        fit_tables_to_the_terminal();
        self.command.execute()
    }
}

/// Tables are as wide as the terminal, if standard output is one, and coloured unless `NO_COLOR` is set
/// (<https://no-color.org>).
fn fit_tables_to_the_terminal() {
    if let Some((_, columns)) = console::Term::stdout().size_checked() {
        let colours = console::colors_enabled();
        Terminal { columns, colours }.use_for_tables();
    }
}

/// Delay laws by their names on the command line.
fn law_names() -> impl TypedValueParser<Value = LawName> {
    let names = PossibleValuesParser::new(LawName::ALL.map(LawName::name));
    // clap has checked that the name is in the list.
    names.map(|name| LawName::named(&name).unwrap_or_default())
}

/// Writes a result to standard output. A reader that has gone away (`| head`) is no error.
fn print(text: &str) -> Result<()> {
    let mut out = std::io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(error) if error.kind() == std::io::ErrorKind::BrokenPipe => Ok(()),
        other => Ok(other?),
    }
}

/// Whether the one JSON document has been written to standard output.
static DOCUMENT: AtomicBool = AtomicBool::new(false);

/// Writes one JSON document to standard output.
fn print_json(value: &impl Serialize) -> Result<()> {
    DOCUMENT.store(true, Ordering::Relaxed);
    print(&format!("{}\n", serde_json::to_string_pretty(value)?))
}

/// Writes a result to standard output: one JSON document, or this text.
fn answer<Text: AsRef<str>>(
    json: bool,
    value: &impl Serialize,
    text: impl FnOnce() -> Text,
) -> Result<()> {
    match json {
        true => print_json(value),
        false => print(text().as_ref()),
    }
}

/// Writes an error as the one JSON document. If a result has been written already, the exit code and standard error report
/// the error alone.
pub fn print_json_error(error: &str) {
    if !DOCUMENT.load(Ordering::Relaxed) {
        // If standard output cannot be written to, nobody reads the error there.
        drop(print_json(&serde_json::json!({ "error": error })));
    }
}

/// Three numbers of the command line, `0,0,-9.81`.
fn three_numbers(text: &str) -> Result<[f64; 3], String> {
    let numbers = text.split(',').map(|part| part.trim().parse::<f64>());
    let numbers: Result<Vec<f64>, _> = numbers.collect();
    match numbers.as_deref() {
        Ok([x, y, z]) if [x, y, z].iter().all(|v| v.is_finite()) => Ok([*x, *y, *z]),
        _ => Err("expected three numbers with commas between them, as in 0,0,-9.81".to_owned()),
    }
}
