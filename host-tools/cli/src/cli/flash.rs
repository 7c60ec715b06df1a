//! `softdock flash`: write the image, and settings if wanted, to the board.

use anyhow::{Context, Result, bail, ensure};
use clap::Args;
use softdock_analysis::input;
use softdock_app::image::{IMAGE_MAX_BYTES, Image};
use softdock_app::settings::BoardSettings;
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
/// both places where the board looks for them; without it, the board keeps those that it has.
#[derive(Debug, Args)]
#[command(after_help = "Example: softdock flash --settings board.toml")]
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
        probe_rs(&[
            "run".as_ref(),
            "--chip".as_ref(),
            CHIP.as_ref(),
            image.as_ref(),
        ])
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

/// The first slot gets the settings, the second becomes empty, so that nothing older wins.
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

fn probe_rs(arguments: &[&Path]) -> Result<()> {
    let status = Command::new("probe-rs")
        .args(arguments)
        .status()
        .context("cannot start probe-rs")?;
    // Ctrl-C ends a run that prints the log.
    if status.success() || status.code().is_none() {
        return Ok(());
    }
    bail!(
        "probe-rs ended with an error; its message is above. If it found no probe: is the board plugged in at CN1 (ST-Link), \
         and may you use it (https://probe.rs/docs/getting-started/probe-setup)?"
    )
}
