//! A board in QEMU: the firmware of the microcontroller, instruction by instruction, behind the
//! same addresses as a board that is a process ([`super::process`]).
//!
//! | file | |
//! |---|---|
//! | `chip` | the machines that are emulated |
//! | `flash` | the emulated flash: settings, and whether to start; it may last |
//! | `ports` | the addresses, checked before anything is started |
//! | `segment` | the way to the EtherCAT segment |
//! | `emulator` | QEMU as a child process |
//! | `log` | the firmware's log as text |

mod chip;
mod emulator;
mod flash;
mod log;
mod ports;
mod segment;

pub use chip::Chip;
use softdock_io::say;

use crate::firmware::{build, emulated_profile};
use anyhow::{Context, Result, bail};
use emulator::{Emulator, Wires};
use log::Log;
use ports::Ports;
use segment::Relay;
use softdock_app::emulated_flash::Crash;
use softdock_app::settings::BoardSettings;
use std::net::SocketAddr;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

/// How often it is looked whether QEMU or the user has ended the run.
const POLL_INTERVAL: Duration = Duration::from_millis(20);

/// Where a board in QEMU listens and what it does by itself.
#[derive(Clone, Debug)]
pub struct Qemu {
    /// Settings of the board, for a flash without any.
    pub settings: BoardSettings,
    /// File that is the board's flash; without one the flash is lost at the end.
    pub flash: Option<PathBuf>,
    /// UDP address for the robot's telegrams.
    pub robot: SocketAddr,
    /// TCP address for the sensor's SLCAN client.
    pub can: Option<SocketAddr>,
    /// UDP address for the sensor's EtherCAT segment; the firmware is then that with EtherCAT in place of CAN.
    pub ethercat: Option<SocketAddr>,
    /// TCP address of the service; without one the service is not connected.
    pub service: Option<SocketAddr>,
    /// Arm and start, once, as soon as robot and sensor are healthy.
    pub start: bool,
    /// Crash at the first start, for a test.
    pub crash: Option<Crash>,
    /// TCP address of QEMU's machine protocol (QMP), for a test.
    pub monitor: Option<SocketAddr>,
    /// The machine.
    pub chip: Chip,
}

impl Qemu {
    /// Builds the firmware and runs it until `stop` is raised.
    ///
    /// # Errors
    /// QEMU or the target of the firmware is not installed, an address is taken, the settings may
    /// not be used, the firmware does not build, or QEMU ends by itself.
    pub fn run(self, stop: &Arc<AtomicBool>) -> Result<()> {
        let flash = flash::content(&self.settings, self.start, self.crash)?;
        let ports = Ports::check(self.robot, self.can, self.service)?;
        let segment = self.ethercat.map(ports::segment).transpose()?;
        let relay = segment.map(Relay::start).transpose()?;
        emulator::find()?;
        let elf = build(&self.chip.image(relay.is_some()), &emulated_profile())?;
        let log = Log::of(&elf)?;

        // Removed with everything in it when this function ends.
        let folder = tempfile::tempdir().context("cannot make a folder for the emulated flash")?;
        let mut rsi_port = self.settings.network.rsi_port;
        let (file, _locked) = match self.flash {
            None => {
                let file = folder.path().join("flash.bin");
                flash::write(&file, &flash)?;
                (file, None)
            }
            Some(file) => {
                let (settings, locked) = flash::keep(&file, &flash)?;
                say!("qemu: settings as they are in {}", file.display());
                rsi_port = settings.map_or(rsi_port, |settings| settings.network.rsi_port);
                (file, Some(locked))
            }
        };
        let wires = Wires {
            ports: &ports,
            relay: relay.as_ref(),
            rsi_port,
            monitor: self.monitor,
        };
        let mut emulator = Emulator::start(self.chip, &elf, &file, &wires)?;
        let stream = emulator.log()?;
        let mut announced = ports.to_string();
        if let Some(relay) = &relay {
            announced += &format!(", EtherCAT on UDP {}", relay.segment);
        }
        let printer = thread::spawn(move || log.print(stream, &announced));
        let outcome = supervise(&mut emulator, stop);
        drop(emulator);
        printer
            .join()
            .unwrap_or_else(|_| bail!("the log's thread ended unexpectedly"))?;
        outcome
    }
}

/// Waits for Ctrl-C, or for QEMU to die.
fn supervise(emulator: &mut Emulator, stop: &AtomicBool) -> Result<()> {
    while !stop.load(Ordering::Relaxed) {
        if let Some(status) = emulator.exit_status()? {
            bail!("QEMU ended by itself ({status}); what it said stands above");
        }
        thread::sleep(POLL_INTERVAL);
    }
    Ok(())
}
