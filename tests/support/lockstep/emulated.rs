//! A session in QEMU.

use crate::process::{PATIENCE, scratch};
use softdock_app::image::{IMAGE_MAX_BYTES, Image};
use softdock_app::settings::BoardSettings;
use softdock_lockstep::{
    CALLS, Done, FUNCTIONS, FunctionCosts, LIBRARIES, MESSAGE_BYTES, Step, frame, unframe,
};
use softdock_rig::board::qemu::Chip;
use softdock_rig::firmware::{BoardImage, build, emulated_profile};
use std::fs::{File, OpenOptions};
use std::io::{BufReader, Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread;
use std::time::{Duration, Instant};

/// Virtual time per instruction is 2 to this power, ns.
const ICOUNT_SHIFT: u32 = 6;
/// A tick of the board's counter, ns.
const TICK_NS: u32 = 40;
/// Interval of the checks whether QEMU has ended.
const POLL_INTERVAL: Duration = Duration::from_millis(20);

/// Converts ticks to instructions; exact to one instruction.
pub fn instructions(ticks: u32) -> u32 {
    (ticks * TICK_NS) >> ICOUNT_SHIFT
}

/// A session in QEMU, which ends on drop.
#[derive(Debug)]
pub struct Emulated {
    qemu: Child,
    /// None when the session is to end.
    steps: Option<Sender<Step>>,
    done: Receiver<Done>,
    /// Number of executed steps.
    count: usize,
}

impl Emulated {
    /// Starts a session on `chip` with `settings`. `test` must be unique to each session.
    ///
    /// # Panics
    /// If the program cannot be built.
    pub fn start(test: &str, chip: Chip, settings: &BoardSettings) -> Self {
        let (folder, qemu) = launch(test, chip);
        let (steps, done) = converse(&folder, block(settings));
        Self {
            qemu,
            steps: Some(steps),
            done,
            count: 0,
        }
    }

    /// Runs a step; returns its results, with the cost.
    ///
    /// # Panics
    /// If QEMU has ended or does not answer.
    pub fn take(&mut self, step: Step) -> Done {
        self.give(step);
        self.next()
    }

    /// Runs all `steps` in a separate session and returns their results. No step waits for the answer to the previous one.
    ///
    /// # Panics
    /// As [`start`](Self::start) and [`take`](Self::take).
    pub fn run(test: &str, chip: Chip, settings: &BoardSettings, steps: Vec<Step>) -> Vec<Done> {
        let mut board = Self::start(test, chip, settings);
        let count = steps.len();
        steps.into_iter().for_each(|step| board.give(step));
        (0..count).map(|_| board.next()).collect()
    }

    fn give(&self, step: Step) {
        if let Some(steps) = &self.steps {
            // If the session has ended, there is no answer either.
            let _ = steps.send(step);
        }
    }

    fn next(&mut self) -> Done {
        let give_up = Instant::now() + PATIENCE;
        loop {
            if let Ok(done) = self.done.recv_timeout(POLL_INTERVAL) {
                self.count += 1;
                return done;
            }
            let ended = self.qemu.try_wait().expect("QEMU can be looked after");
            assert!(
                ended.is_none() && Instant::now() < give_up,
                "QEMU answered {} steps ({ended:?})",
                self.count
            );
        }
    }
}

impl Drop for Emulated {
    fn drop(&mut self) {
        self.steps = None;
        // It has ended, or it hangs.
        let _ = self.qemu.kill();
        let _ = self.qemu.wait();
    }
}

/// Cost of mathematical functions on `chip`, instructions per call.
///
/// # Panics
/// As [`Emulated::start`]; or if QEMU does not answer.
pub fn function_costs(test: &str, chip: Chip) -> [[f64; LIBRARIES.len()]; FUNCTIONS.len()] {
    let (folder, mut qemu) = launch(test, chip);
    let (send, receive) = channel();
    let (to, from) = (folder.join("to_board"), folder.join("from_board"));
    thread::spawn(move || -> std::io::Result<()> {
        OpenOptions::new()
            .write(true)
            .open(to)?
            .write_all(&[0, 0])?;
        let mut told = Vec::new();
        OpenOptions::new()
            .read(true)
            .open(from)?
            .read_to_end(&mut told)?;
        // The receiver is gone if the test has failed.
        let _ = send.send(told);
        Ok(())
    });
    let told = receive.recv_timeout(PATIENCE);
    // It has ended, or it hangs.
    let _ = qemu.kill();
    let _ = qemu.wait();
    let told = told.expect("QEMU tells the costs");
    let costs: FunctionCosts = unframe(&told[2..]).expect("costs");
    costs.map(|row| row.map(|ticks| f64::from(instructions(ticks)) / f64::from(CALLS)))
}

/// Starts the program on `chip` in a separate folder, with its pipes.
fn launch(test: &str, chip: Chip) -> (PathBuf, Child) {
    let board = BoardImage {
        package: "softdock-lockstep",
        target: chip.target(),
        features: &["board"],
    };
    // The profile matters, because instructions are counted.
    let image = build(&board, &emulated_profile()).expect("the program builds");
    let folder = scratch(test);
    for pipe in ["to_board", "from_board"] {
        let made = Command::new("mkfifo").arg(folder.join(pipe)).status();
        assert!(made.expect("mkfifo is part of coreutils").success());
    }
    let qemu = start(chip, &image, &folder);
    (folder, qemu)
}

fn start(chip: Chip, image: &Path, folder: &Path) -> Child {
    let icount = format!("shift={ICOUNT_SHIFT},sleep=off");
    Command::new("qemu-system-arm")
        .current_dir(folder)
        .args(["-machine", chip.machine(), "-icount", &icount])
        .args(["-nodefaults", "-display", "none", "-monitor", "none"])
        .args(["-semihosting-config", "enable=on,target=native"])
        .arg("-kernel")
        .arg(image)
        .stdin(Stdio::null())
        .spawn()
        .expect("qemu-system-arm is installed: apt-get install qemu-system-arm")
}

fn block(settings: &BoardSettings) -> Vec<u8> {
    let image = Image {
        sequence: 1,
        settings: settings.clone(),
    };
    let mut bytes = vec![0; IMAGE_MAX_BYTES];
    let length = image.encode(&mut bytes).expect("usable settings");
    bytes.truncate(length);
    bytes
}

/// Sends steps and receives their results, each in a separate thread: a pipe without a board blocks forever, and a board that
/// finds the next step in its pipe does not wait for the host.
fn converse(folder: &Path, settings: Vec<u8>) -> (Sender<Step>, Receiver<Done>) {
    let (give, steps) = channel::<Step>();
    let (send, receive) = channel();
    let (to, from) = (folder.join("to_board"), folder.join("from_board"));
    thread::spawn(move || -> std::io::Result<()> {
        let mut to = OpenOptions::new().write(true).open(to)?;
        to.write_all(&u16::try_from(settings.len()).unwrap_or(0).to_le_bytes())?;
        to.write_all(&settings)?;
        let mut buffer = [0; MESSAGE_BYTES];
        for step in steps {
            to.write_all(frame(&step, &mut buffer).expect("a step fits"))?;
        }
        to.write_all(&[0, 0])
    });
    thread::spawn(move || -> std::io::Result<()> {
        let mut from = BufReader::new(File::open(from)?);
        let mut buffer = [0; MESSAGE_BYTES];
        let mut length = [0; 2];
        loop {
            from.read_exact(&mut length)?;
            let body = &mut buffer[..u16::from_le_bytes(length).into()];
            from.read_exact(body)?;
            if send.send(unframe(body).expect("an answer")).is_err() {
                return Ok(());
            }
        }
    });
    (give, receive)
}
