//! `softdock flash`: write the image, and settings if wanted, to the board.

use super::doctor::Doctor;
use anyhow::{Context, Result, bail, ensure};
use clap::Args;
use softdock_app::image::{IMAGE_MAX_BYTES, Image};
use softdock_app::settings::BoardSettings;
use softdock_io::input;
use softdock_io::port::only_board;
use softdock_io::say;
use softdock_rig::firmware::{
    Elf, RELEASED, Region, SensorLink, build, nucleo_h743zi, regions, repository,
};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Command;

/// The chip as probe-rs names it.
const CHIP: &str = "STM32H743ZITx";

/// Build the image, write it to the NUCLEO-H743ZI2 by its ST-Link, run it, and print its log.
///
/// Needs probe-rs (https://probe.rs). With --settings, the settings of FILE are written first, to
/// both places where the board looks for them; without it, the board keeps those that it has. With
/// --self-test the board is tested in place of printing its log, as by `softdock doctor --self-test`.
#[derive(Debug, Args)]
#[command(after_help = "\
Example: softdock flash --settings board.toml

softdock flash --settings board.toml --self-test --hang
(the first power-on of a board, docs/board.md)")]
pub(super) struct Flash {
    /// What the sensor is on
    #[arg(long, value_enum, default_value_t, conflicts_with = "image")]
    sensor: SensorLink,
    /// Settings for the board (TOML)
    #[arg(long, value_name = "FILE")]
    settings: Option<PathBuf>,
    /// Image to write (ELF) in place of a fresh one
    #[arg(long, value_name = "FILE")]
    image: Option<PathBuf>,
    /// First power-on: have the board show what it can do
    #[arg(long)]
    self_test: bool,
    /// Have the board hang as well, so that its watchdog shows that it resets it
    #[arg(long, requires = "self_test")]
    hang: bool,
    /// Serial line of the board for --self-test, if not that of the only probe
    #[arg(long, value_name = "PORT", requires = "self_test")]
    port: Option<String>,
}

impl Flash {
    pub(super) fn execute(self) -> Result<()> {
        let settings: Option<BoardSettings> =
            self.settings.as_deref().map(input::load).transpose()?;
        ensure_probe_rs()?;
        let script = std::fs::read_to_string(repository()?.join("memory.x"))?;
        let regions = regions(&script).context("memory.x")?;
        let image = match self.image {
            Some(path) => path,
            None => build(&nucleo_h743zi(self.sensor), RELEASED)?,
        };
        Elf::open(&image)?
            .ensure_in(region(&regions, "FLASH")?)
            .with_context(|| image.display().to_string())?;
        if let Some(settings) = settings {
            write_settings(settings, region(&regions, "SETTINGS")?)?;
        }
        let chip: [&Path; 2] = ["--chip".as_ref(), CHIP.as_ref()];
        let image: &Path = image.as_ref();
        if !self.self_test {
            return probe_rs(&["run".as_ref(), chip[0], chip[1], image]);
        }
        probe_rs(&["download".as_ref(), chip[0], chip[1], image])?;
        probe_rs(&["reset".as_ref(), chip[0], chip[1]])?;
        let port = self.port.map_or_else(only_board, Ok)?;
        Doctor::self_test(port, self.hang).execute()
    }
}

fn region<'a>(regions: &'a [Region], name: &str) -> Result<&'a Region> {
    let found = regions.iter().find(|region| region.name == name);
    found.with_context(|| format!("memory.x has no region {name}"))
}

fn ensure_probe_rs() -> Result<()> {
    let found = Command::new("probe-rs").arg("--version").output();
    ensure!(
        found.is_ok_and(|output| output.status.success()),
        "probe-rs, which talks to the ST-Link, is not installed; install it: cargo install probe-rs-tools --locked"
    );
    Ok(())
}

/// Writes the settings into the first slot and erases the second, so that no older settings are chosen.
fn write_settings(settings: BoardSettings, slots: &Region) -> Result<()> {
    let mut bytes = vec![0xff; usize::try_from(slots.length)?];
    let sequence = 1;
    Image { sequence, settings }.encode(&mut bytes[..IMAGE_MAX_BYTES])?;
    let mut file = tempfile::NamedTempFile::new()?;
    file.write_all(&bytes)?;
    let address = format!("{:#x}", slots.origin);
    let options = ["--binary-format", "bin", "--base-address", &address];
    let mut arguments: Vec<&Path> = vec!["download".as_ref(), "--chip".as_ref(), CHIP.as_ref()];
    arguments.extend(options.iter().map(Path::new));
    arguments.push(file.path());
    probe_rs(&arguments)
}

/// Runs probe-rs, a second time if the first fails: after a power-up, and while the chip sleeps, the first connection is
/// known to fail (probe-rs #4113, #4031).
fn probe_rs(arguments: &[&Path]) -> Result<()> {
    if done_by_probe_rs(arguments)? {
        return Ok(());
    }
    say!("flash: probe-rs ended with an error; once more");
    if done_by_probe_rs(arguments)? {
        return Ok(());
    }
    bail!(
        "probe-rs ended with an error twice; its message is above. If it found no probe: is the board plugged in at CN1 (ST-Link), \
         and may you use it (https://probe.rs/docs/getting-started/probe-setup)? If it found the probe but not the chip, try in \
         this order: unplug CN1 and plug it in again; do without connecting under reset (unset PROBE_RS_CONNECT_UNDER_RESET); \
         plug CN1 in while BOOT0 is high (CN11, pin 7 to pin 5), so that the chip starts its boot loader in place of the \
         firmware, and take the wire away when it is flashed"
    )
}

fn done_by_probe_rs(arguments: &[&Path]) -> Result<bool> {
    let status = Command::new("probe-rs").args(arguments).status();
    let status = status.context("cannot start probe-rs")?;
    // No exit code: Ctrl-C ended a run that prints the log.
    Ok(status.success() || status.code().is_none())
}
