//! Fuzz targets: the parsers of all data from outside, and complete conversations. A target accepts any bytes and must not
//! panic, hang or break its guarantees.
//!
//! [`driver`] mutates the corpus, on any tool chain; `fuzz/run` runs the same targets with cargo-fuzz, which is guided by
//! coverage. Every input that ever failed stays in the corpus, with which every run begins.
#![allow(
    clippy::unwrap_used,
    reason = "a target that finds something fails the test"
)]

mod answers;
mod codecs;
pub mod driver;
mod ethercat;
mod files;
mod folder;
mod import;
mod log;
mod recorder;
mod service;
mod session;

use std::path::{Path, PathBuf};

/// A target.
#[derive(Clone, Copy, Debug)]
pub struct Target {
    /// Name, also of its folder in the corpus.
    pub name: &'static str,
    /// Runs the target on one input.
    pub run: fn(&[u8]),
    /// Number of inputs in a quick run, which takes a fraction of a second.
    pub few: u64,
}

/// All targets.
pub const TARGETS: [Target; 21] = [
    target("rsi", codecs::rsi, 500),
    target("slcan", codecs::slcan, 500),
    target("can-sensor", codecs::can_sensor, 500),
    target("ethercat-sensor", codecs::ethercat_sensor, 500),
    target("image", codecs::image, 500),
    target("telemetry", codecs::telemetry, 500),
    target("robot-session", session::robot_session, 500),
    target("service-session", service::service_session, 500),
    target("board-answers", answers::board_answers, 300),
    target("ethercat-frames", ethercat::frames, 500),
    target("ethercat-session", ethercat::session, 12),
    target("recorder", recorder::recorder, 60),
    target("recording", files::recording, 1_000),
    target("model", files::model, 1_000),
    target("settings", files::settings, 1_000),
    target("scenario", files::scenario, 500),
    target("campaign", files::campaign, 80),
    target("campaign-folder", folder::campaign_folder, 30),
    target("import", import::table, 300),
    target("docking-rig-log", import::rig_log, 300),
    target("log", log::log, 60),
];

const fn target(name: &'static str, run: fn(&[u8]), few: u64) -> Target {
    Target { name, run, few }
}

/// Folder of the corpus of a target.
pub fn corpus(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("fuzz/corpus")
        .join(name)
}

/// Bytes that are used as a script of events.
struct Script<'a>(&'a [u8]);

impl<'a> Script<'a> {
    fn byte(&mut self) -> Option<u8> {
        let (first, rest) = self.0.split_first()?;
        self.0 = rest;
        Some(*first)
    }

    /// The next bytes; zeros after the end.
    fn bytes<const N: usize>(&mut self) -> [u8; N] {
        core::array::from_fn(|_| self.byte().unwrap_or_default())
    }

    /// As many bytes as the next byte says, but no more than there are.
    fn piece(&mut self) -> Option<&'a [u8]> {
        let length = usize::from(self.byte()?).min(self.0.len());
        let (piece, rest) = self.0.split_at(length);
        self.0 = rest;
        Some(piece)
    }

    /// A number of usual size, or occasionally any number.
    fn number(&mut self, scale: f64) -> f64 {
        match self.byte() {
            Some(255) => f64::from_le_bytes(self.bytes()),
            byte => (f64::from(byte.unwrap_or(128)) - 128.0) * scale,
        }
    }

    fn choose<T: Copy>(&mut self, from: &[T]) -> T {
        from[usize::from(self.byte().unwrap_or_default()) % from.len()]
    }
}
