//! Calibration with a connected board and its robot.

use super::Sensor;
use crate::cli::live::{raised_by_ctrl_c, upload};
use crate::cli::outputs::mcap_file;
use crate::cli::progress::Progress;
use anyhow::Result;
use clap::Args;
use softdock_commissioning::calibrate::live::{FEWEST_POSES, Guide};
use softdock_commissioning::input::Read;
use softdock_commissioning::live::{LiveBoard, LiveRecorder};
use softdock_control::settings::SensorSettings;
use softdock_io::input::refuse_overwrite;
use softdock_io::port::BAUD_RATE;
use softdock_io::say;
use std::net::SocketAddr;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};

/// Where the board is.
#[derive(Debug, Args)]
pub(super) struct Options {
    /// Watch the robot of the board on this serial device, pseudo-terminal, or tcp:HOST:PORT
    #[arg(long, conflicts_with_all = ["recording", "plan", "inertia", "at_rest"])]
    pub(super) port: Option<String>,
    /// Speed of a serial device, bit/s
    #[arg(long, value_name = "BIT_PER_S", default_value_t = BAUD_RATE)]
    baud: u32,
    /// UDP address on which the board's cycles are heard, if not `network.recorder` of its settings
    #[arg(long, value_name = "UDP_ADDR", requires = "port")]
    listen: Option<SocketAddr>,
    /// Recording of the poses to write
    #[arg(long, value_name = "POSES.mcap", requires = "port", value_parser = mcap_file)]
    keep: Option<PathBuf>,
    /// Write what was found into the board's settings
    #[arg(long, requires = "port")]
    upload: bool,
}

impl Sensor {
    /// Guides the operator from pose to pose, calibrates, and uploads the result.
    pub(super) fn calibrate_live(&self, port: &str) -> Result<()> {
        if let Some(file) = &self.live.keep {
            refuse_overwrite(file, self.to.force)?;
        }
        let mut board = LiveBoard::connect(Some(port), self.live.baud)?;
        say!("{port}: {}", board.client.identity().text);
        let sensor = self.mounted(&mut board)?;
        let address = board.recorder(self.live.listen)?;
        board.hold()?;
        let stop = raised_by_ctrl_c()?;
        let mut recorder = LiveRecorder::open(address, self.live.keep.as_deref())?;
        say!(
            "The board holds. Move the robot by hand or by its own program, slowly, RSI running; rest for \
             a second in each pose, hands off the tool. Ctrl-C takes what there is."
        );
        if let Err(error) = self.watch(&sensor, &mut recorder, &stop) {
            say!("{}", recorder.interrupted());
            return Err(error);
        }
        let (recording, notes) = recorder.finish()?;
        for note in &notes {
            say!("warning: {note}");
        }
        let read = Read {
            recording,
            unseen: None,
            model: None,
            notes,
        };
        let found = self.calibrated(&[read])?;
        let origin = "poses of the robot".to_owned();
        self.give(&found, &origin)?;
        match self.live.upload {
            true => upload(&mut board, &found.fragment(&origin)),
            false => Ok(()),
        }
    }

    /// Shows pose and force, and what to do next, until there are enough poses.
    fn watch(
        &self,
        sensor: &SensorSettings,
        recorder: &mut LiveRecorder,
        stop: &AtomicBool,
    ) -> Result<()> {
        let mut guide = Guide::new(sensor, self.tilt_deg.to_radians());
        let bar = Progress::new();
        while !guide.is_enough() && !stop.load(Ordering::Relaxed) {
            recorder.listen(|record| guide.see(record))?;
            if let Some(news) = guide.news()? {
                bar.say(&news);
            }
            let share = guide.poses() as f64 / FEWEST_POSES as f64;
            bar.show(share.min(1.0), &guide.now());
        }
        Ok(())
    }

    /// Mounting of the sensor, gravity and the status bits that are no fault: from the settings on the command line, else
    /// from the board.
    fn mounted(&self, board: &mut LiveBoard) -> Result<SensorSettings> {
        if self.settings.is_some() || self.to.into.is_some() {
            return self.sensor(None);
        }
        let gravity_m_s2 = match self.gravity {
            Some(gravity) => gravity,
            None => board.numbers("control.sensor.gravity_m_s2")?,
        };
        Ok(SensorSettings {
            position_m: board.numbers("control.sensor.position_m")?,
            orientation_wxyz: board.numbers("control.sensor.orientation_wxyz")?,
            gravity_m_s2,
            ignored_status_bits: board.number("control.sensor.ignored_status_bits")? as u32,
            ..SensorSettings::default()
        })
    }
}
