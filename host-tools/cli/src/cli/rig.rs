//! `softdock rig`: the simulated rig in real time, as a peer of a board.

use super::live::raised_by_ctrl_c;
use super::progress::spinner;
use super::{answer, print, print_json, three_numbers};
use anyhow::{Result, bail, ensure};
use clap::Args;
use indicatif::ProgressBar;
use softdock_commissioning::live::LiveBoard;
use softdock_experiments::scenario::Scenario;
use softdock_io::address::address;
use softdock_io::input;
use softdock_io::port::BAUD_RATE;
use softdock_io::say;
use softdock_rig::peer::{Peer, SensorLink, Tally, Watcher};
use softdock_rig::rig::Hidden;
use softdock_rig::rig::hidden::{any, spacecraft, suggest};
use std::io::BufRead;
use std::net::SocketAddr;
use std::path::PathBuf;
use std::sync::mpsc::{Receiver, channel};
use std::thread;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

/// How long `--patient` waits for an answer.
const PATIENCE: Duration = Duration::from_secs(1);
/// Word in place of an effect's id: any effect of the catalogue.
const ANY: &str = "any";
/// Seeds are drawn below this number: short enough to be typed.
const SEEDS: u64 = 1_000_000;

/// Play robot, mechanism and sensor of a scenario in real time against a board.
///
/// The board is `softdock board`, `softdock qemu` or a real one: the robot sends its RSI telegrams to --robot, the
/// sensor connects to --can and speaks SLCAN, or is an EtherCAT segment at --ethercat. It waits for the board and comes
/// back when the board starts over. Three numbers on standard input, A,B,C in degrees, take the robot to another
/// orientation. Ctrl-C ends it and says how many answers were late or never came.
#[derive(Debug, Args)]
#[command(after_help = "\
Example: softdock rig scenario.toml --robot 127.0.0.1:49152 --can 127.0.0.1:29536
(the board in another terminal: softdock board --settings board.toml --robot 127.0.0.1:49152 --can 127.0.0.1:29536 --start)

softdock rig scenario.toml --robot 127.0.0.1:49152 --can 127.0.0.1:29536 --hide any
(a rig with a secret: record it, compare, diagnose; --seed with the number that it says, and --reveal, tell what it was)")]
pub(super) struct RigCommand {
    /// Scenario file (TOML)
    scenario: PathBuf,
    /// UDP address on which the board waits for the robot
    #[arg(long, value_name = "UDP_ADDR", value_parser = address, required_unless_present = "reveal")]
    robot: Option<SocketAddr>,
    /// TCP address of the board's SLCAN port
    #[arg(
        long,
        value_name = "TCP_ADDR",
        value_parser = address,
        required_unless_present_any = ["ethercat", "reveal"],
        conflicts_with = "ethercat"
    )]
    can: Option<SocketAddr>,
    /// UDP address on which the board waits for its EtherCAT segment, in place of --can
    #[arg(long, value_name = "UDP_ADDR", value_parser = address)]
    ethercat: Option<SocketAddr>,
    /// Service port of the board (tcp:HOST:PORT or a serial device), to tell it to stop when latches close
    #[arg(long, value_name = "PORT")]
    service: Option<String>,
    /// Settings of the board, instead of the scenario's: its sensor, names of RSI
    #[arg(long, value_name = "BOARD.toml")]
    settings: Option<PathBuf>,
    /// Effect of the catalogue for the rig to hide, in a size drawn from the seed, or `any`; may be repeated
    #[arg(long, value_name = "ID|any")]
    hide: Vec<String>,
    /// Seed of all random numbers, instead of the scenario's; `--hide any` without it draws one and says it
    #[arg(long)]
    seed: Option<u64>,
    /// Say what --hide and --seed hide, and do no more
    #[arg(long, requires = "hide")]
    reveal: bool,
    /// A, B, C of the flange at the start, degrees, instead of the scenario's
    #[arg(long, value_name = "A,B,C", value_parser = three_numbers, allow_hyphen_values = true)]
    abc_deg: Option<[f64; 3]>,
    /// Let the rig's clock wait for late answers, for a second at most, as no robot does: for a busy computer
    #[arg(long)]
    patient: bool,
    /// End after so long, s
    #[arg(long, value_name = "S")]
    seconds: Option<f64>,
    /// Print one JSON document
    #[arg(long)]
    json: bool,
}

impl RigCommand {
    pub(super) fn execute(self) -> Result<()> {
        if let Some(seconds) = self.seconds {
            ensure!(
                seconds > 0.0 && seconds <= 1e6,
                "--seconds is {seconds}; expected is more than 0, at most 1000000"
            );
        }
        let drawn = self.drawn_seed()?;
        let (scenario, hidden) = self.scenario(drawn)?;
        if self.reveal {
            return self.tell(&hidden);
        }
        if let Some(seed) = drawn {
            say!(
                "rig: the secret has the seed {seed}: --seed {seed} hides it again, with --reveal it is told"
            );
        }
        let sensor = &scenario.rig.sensor;
        if sensor.noise_force_n <= 0.0 && sensor.noise_torque_nm <= 0.0 {
            say!(
                "warning: the simulated sensor has no noise; a board takes readings that repeat for a frozen sensor \
                 unless its `control.sensor.frozen_after_cycles` is 0"
            );
        }
        let peer = self.peer(scenario)?;
        let stop = raised_by_ctrl_c()?;
        let display = Display {
            bar: spinner(),
            service: self.service.clone(),
        };
        let tally = peer.run(&stop, self.seconds, poses(), &display)?;
        drop(display);
        let summary = tally.summary();
        answer(self.json, &summary, || format!("{summary}\n"))?;
        ensure!(
            summary.runs > 0,
            "no board answered on UDP {}: does it run, and is this its --robot address?",
            peer.robot
        );
        Ok(())
    }

    /// The simulated rig and the addresses of its board.
    fn peer(&self, scenario: Scenario) -> Result<Peer> {
        let sensor = match (self.can, self.ethercat) {
            (Some(can), _) => SensorLink::Can(can),
            (None, Some(ethercat)) => SensorLink::Ethercat(ethercat),
            (None, None) => bail!("where is the sensor's port? --can or --ethercat says it"),
        };
        let Some(robot) = self.robot else {
            bail!("where does the board wait for the robot? --robot says it");
        };
        Ok(Peer {
            start_pose: scenario.start_pose(),
            rig: scenario.rig,
            seed: scenario.seed,
            board: scenario.board,
            robot,
            sensor,
            patience: if self.patient {
                PATIENCE
            } else {
                Duration::ZERO
            },
        })
    }

    /// A seed from the time of day, if an effect is to be drawn (`any`) and no seed was given; else None.
    fn drawn_seed(&self) -> Result<Option<u64>> {
        if self.seed.is_some() || !self.hide.iter().any(|id| id == ANY) {
            return Ok(None);
        }
        ensure!(
            !self.reveal,
            "which secret shall be told? Each seed hides another one: --seed with the number that the rig said when it \
             started"
        );
        let now = SystemTime::now().duration_since(UNIX_EPOCH)?;
        Ok(Some(now.as_millis() as u64 % SEEDS))
    }

    /// The scenario with the hidden effects, and the list of these effects.
    fn scenario(&self, drawn: Option<u64>) -> Result<(Scenario, Vec<Hidden>)> {
        let mut scenario = Scenario::load(&self.scenario)?;
        if let Some(path) = &self.settings {
            scenario.board = input::load(path)?;
        }
        if let Some(abc_deg) = self.abc_deg {
            scenario.start_abc_rad = abc_deg.map(f64::to_radians);
        }
        scenario.seed = self.seed.or(drawn).unwrap_or(scenario.seed);
        let mut hidden = Vec::new();
        for id in &self.hide {
            let effect = match id.as_str() {
                ANY => any(&scenario.rig, scenario.seed)?,
                id => suggest(id, scenario.seed)?,
            };
            ensure!(
                !spacecraft::concerns(&effect),
                "`{}` is an error of the spacecraft that the board computes: the rig cannot hide it; change the \
                 board's `control.body_k` instead",
                effect.id
            );
            scenario.rig.hidden.push(effect.clone());
            hidden.push(effect);
        }
        scenario.validate()?;
        Ok((scenario, hidden))
    }

    fn tell(&self, hidden: &[Hidden]) -> Result<()> {
        if self.json {
            return print_json(&hidden);
        }
        for effect in hidden {
            let values = effect.parameters.iter();
            let values: Vec<String> = values.map(|(name, v)| format!("{name} = {v}")).collect();
            print(&format!("{}: {}\n", effect.id, values.join(", ")))?;
        }
        Ok(())
    }
}

/// Orientations that are typed on standard input, rad. The thread ends when standard input ends.
fn poses() -> Receiver<[f64; 3]> {
    let (typed, poses) = channel();
    thread::spawn(move || {
        for line in std::io::stdin().lock().split(b'\n').map_while(Result::ok) {
            let line = String::from_utf8_lossy(&line);
            let line = line.trim();
            match three_numbers(line) {
                Ok(abc_deg) => {
                    if typed.send(abc_deg.map(f64::to_radians)).is_err() {
                        return;
                    }
                    say!("rig: the robot leaves the mechanism and goes to A,B,C = {line} degrees");
                }
                Err(_) if line.is_empty() => {}
                Err(error) => say!("rig: `{line}`: {error}, A,B,C in degrees"),
            }
        }
    });
    poses
}

/// Reports on standard error what happens.
struct Display {
    bar: ProgressBar,
    /// Service port of the board, for the command to stop; None if it was not given.
    service: Option<String>,
}

impl Display {
    fn stop_board(&self) -> Result<()> {
        let mut board = LiveBoard::connect(self.service.as_deref(), BAUD_RATE)?;
        board.client.operate("stop").map(drop)
    }
}

impl Watcher for Display {
    fn say(&self, what: &str) {
        self.bar.suspend(|| say!("rig: {what}"));
    }

    fn captured(&self) {
        let told = self.service.is_some().then(|| self.stop_board());
        self.say(&match told {
            Some(Ok(())) => "the latches have closed; the board was told to stop".to_owned(),
            Some(Err(error)) => {
                format!("the latches have closed, and the board could not be told to stop: {error:#}")
            }
            None => "the latches have closed: stop the board (`softdock params mode stop`), or a delayed loop swings up \
                     on the stiff joint; --service PORT lets the rig's capture switch do it"
                .to_owned(),
        });
    }

    fn show(&self, tally: &Tally) {
        self.bar.tick();
        let late = tally.unanswered + tally.waited;
        self.bar.set_message(format!(
            "{} cycles, {late} not answered in time, {} readings, {} contacts; Ctrl-C ends it",
            tally.cycles, tally.readings, tally.contacts
        ));
    }
}

impl Drop for Display {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}
