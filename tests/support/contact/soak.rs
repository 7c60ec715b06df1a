//! Long runs of bouncing between two walls, with random faults and a simulated operator: no memory leaks, no drift, and all
//! checks of a cycle hold in every cycle.

use super::faults::{FAULTS, Moment};
use super::judge::Judge;
use super::line::{Answered, Cycle, Line};
use super::tape::Tape;
use super::{MakeBoard, velocity};
use softdock_app::settings::BoardSettings;
use softdock_control::delay::LawName;
use softdock_control::jog::Jog;
use softdock_control::modes::{Command, Mode};
use softdock_delay_plants::{Actuator, Contact, Measurement, Plant, PlantSettings, Sample, Wall};

/// Longest time between two interventions of the operator at the robot, cycles: a minute.
const EPISODE: u64 = 15_000;
/// Mean number of cycles between two random events, of the operator and of the faults.
const RARELY: u64 = 1_500;
/// Cycles that the operator waits after a fault before acting.
const WATCHES: u64 = 100;
/// Number of resets after which the board is restarted.
const MOST_RESETS: u64 = 20;
/// Last digit of a position: mm with 4 decimals.
const DIGIT_M: f64 = 1e-7;

/// Pseudo-random numbers.
struct Dice(u64);

impl Dice {
    fn roll(&mut self, sides: u64) -> u64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) % sides
    }
}

/// A fault that is present.
#[derive(Clone, Copy)]
struct PresentFault {
    /// Its place in [`FAULTS`].
    place: usize,
    /// Cycles since its beginning.
    since: u64,
    /// Cycles that it lasts.
    lasts: u64,
}

struct Soak<'a> {
    settings: BoardSettings,
    make: MakeBoard<'a>,
    line: Line,
    judge: Judge,
    tape: Tape,
    plant: Plant,
    sample: Sample,
    dice: Dice,
    mode: Mode,
    /// Cycles since the last command or change of mode.
    quiet: u64,
    /// Resets that did not end the present fault.
    resets: u64,
    fault: Option<PresentFault>,
    /// Reference position of the displacement, and the sum of the corrections since, in counts.
    drift: Option<([f64; 3], [i64; 3])>,
    /// Number of starts of the loop, of faults and of restarts.
    starts: u64,
    faults: u64,
    restarts: u64,
}

fn settings(law: LawName) -> BoardSettings {
    let mut settings = BoardSettings::default();
    settings.rsi.robot_ip = "192.168.1.10".try_into().unwrap();
    settings.control.body_k.velocity_m_s = [0.005, 0.001, 0.0];
    settings.control.body_q.fixed = true;
    settings.control.delay.law = law;
    settings
}

fn plant(seed: u64) -> Plant {
    let wall = |x: f64| Wall::elastic([x, 0.0, 0.0], [-x.signum(), 0.0, 0.0], 100_000.0);
    let actuator = Actuator {
        delay_s: 0.032,
        ..Actuator::ideal()
    };
    Plant::new(&PlantSettings {
        actuator,
        contact: Contact {
            probes: vec![[0.0; 3]],
            surfaces: vec![wall(3e-3).into(), wall(-3e-3).into()],
        },
        measurement: Measurement {
            force_noise_n: 0.05,
            position_noise_m: 1e-6,
            ..Measurement::default()
        },
        seed,
        ..PlantSettings::default()
    })
}

impl<'a> Soak<'a> {
    fn new(law: LawName, piece: u64, make: MakeBoard<'a>) -> Self {
        let settings = settings(law);
        let mut plant = plant(1);
        Self {
            line: Line::new(&settings, make(&settings)),
            make,
            // The energy is checked in separate contacts.
            judge: Judge::new(&settings, 0.0),
            tape: Tape::new(&settings, piece),
            sample: plant.first_sample(),
            plant,
            dice: Dice(law as u64),
            mode: Mode::Idle,
            quiet: 0,
            resets: 0,
            fault: None,
            drift: None,
            starts: 0,
            faults: 0,
            restarts: 0,
            settings,
        }
    }

    /// Runs some cycles of the robot.
    fn run(&mut self, cycles: u64) {
        for n in 0..cycles {
            if n % EPISODE == EPISODE - 1 {
                self.walk_to_the_robot();
            }
            self.cycle();
        }
    }

    /// The robot is moved back by hand, and RSI is restarted.
    fn walk_to_the_robot(&mut self) {
        self.plant = plant(self.dice.roll(1 << 30));
        self.sample = self.plant.first_sample();
        self.line.jump(-1000);
        self.drift = None;
    }

    /// Ends a state in which the zero was taken under load, so that no reset finds a small force any more.
    fn restart_the_board(&mut self) {
        self.line = Line::new(&self.settings, (self.make)(&self.settings));
        self.judge = Judge::new(&self.settings, 0.0);
        self.tape.boot();
        (self.mode, self.resets) = (Mode::Idle, 0);
        self.restarts += 1;
        self.walk_to_the_robot();
    }

    fn cycle(&mut self) {
        let mut cycle = Cycle::new(self.sample.wrench, self.sample.position);
        cycle.command = self.operator();
        let reading = cycle.sample.unwrap_or_default();
        if self.fault.is_none() && self.dice.roll(RARELY) == 0 {
            self.fault = Some(PresentFault {
                place: self.dice.roll(FAULTS.len() as u64) as usize,
                since: 0,
                lasts: 1 + self.dice.roll(60),
            });
            self.faults += 1;
        }
        self.line.remember(reading, self.fault.is_none());
        if let Some(fault) = self.fault {
            let moment = Moment {
                since: fault.since as usize,
                any: self.dice.roll(1 << 30),
            };
            FAULTS[fault.place].1(&mut cycle, &mut self.line, moment);
            let since = fault.since + 1;
            self.fault = (since < fault.lasts).then_some(PresentFault { since, ..fault });
        }
        let answered = self.line.run(&cycle);
        self.judge.check(&cycle, &answered);
        self.check_drift(&answered);
        let decimals = self.settings.control.robot.correction_decimals;
        self.sample = self.plant.step(velocity(&answered, decimals));
    }

    /// Behaviour of the operator: starts, waits, restarts after a fault, stops occasionally, jogs.
    fn operator(&mut self) -> Option<Command> {
        self.quiet += 1;
        let whim = self.dice.roll(RARELY) == 0;
        match self.mode {
            Mode::Idle => Some(Command::Hold),
            Mode::Hold if self.quiet > WATCHES => match self.dice.roll(10) {
                0 => Some(Command::Zero),
                1 => Some(Command::Jog(Jog::Y)),
                _ => Some(Command::Arm),
            },
            Mode::Armed if self.quiet > 3 => Some(Command::Start),
            Mode::Running | Mode::Jogging if whim => Some(Command::Stop),
            Mode::Fault if self.quiet > WATCHES => {
                self.quiet = 0;
                self.resets += 1;
                if self.resets > MOST_RESETS {
                    self.restart_the_board();
                }
                // The operator removes what presses on the sensor.
                if self.sample.wrench[0].abs() > 10.0 {
                    self.walk_to_the_robot();
                }
                Some(Command::Reset)
            }
            _ => None,
        }
    }

    /// Checks that the sum of the corrections equals the intended displacement, to one digit.
    fn check_drift(&mut self, answered: &Answered) {
        let Some(record) = &answered.record else {
            return;
        };
        self.tape.take(record);
        let trace = &record.trace;
        let begins = matches!(trace.mode, Mode::Armed | Mode::Jogging) && trace.mode != self.mode;
        if begins {
            let [x, y, z, ..] = trace.pose;
            self.drift = Some(([x, y, z], [0; 3]));
        }
        if trace.mode != self.mode {
            self.starts += u64::from(trace.mode == Mode::Running);
            (self.mode, self.quiet, self.resets) = (trace.mode, 0, 0);
        }
        let Some((origin, sent)) = &mut self.drift else {
            return;
        };
        for i in 0..3 {
            sent[i] += record.output.correction[i];
            let meant = trace.command_pose[i] - origin[i];
            let drift = sent[i] as f64 * DIGIT_M - meant;
            let judged = trace.mode.moves();
            assert!(!judged || drift.abs() <= DIGIT_M, "{drift} m on axis {i}");
        }
    }
}

/// Memory of this process, bytes.
fn resident() -> u64 {
    let pages = std::fs::read_to_string("/proc/self/statm").unwrap_or_default();
    let pages = pages
        .split(' ')
        .nth(1)
        .and_then(|pages| pages.parse::<u64>().ok());
    pages.unwrap_or_default() * 4096
}

/// Runs some cycles with a law, records them, and prints a summary.
///
/// # Panics
/// If a check fails, if there is drift or a leak, or if a recording does not reproduce the cycles.
pub fn soak_law(law: LawName, cycles: u64, make: MakeBoard<'_>) {
    let mut soak = Soak::new(law, cycles / 8, make);
    soak.run(cycles / 4);
    soak.tape.end();
    let early = resident();
    soak.run(cycles - cycles / 4);
    soak.tape.end();
    let grown = resident().saturating_sub(early);
    let Soak {
        starts,
        faults,
        restarts,
        tape: Tape { pieces, bytes, .. },
        ..
    } = soak;
    println!(
        "{law:?}: {cycles} cycles, {starts} starts, {faults} faults, {restarts} boards started over, {pieces} recordings of {bytes} bytes in all, \
         {grown} bytes more"
    );
    assert!(starts > cycles / 50_000, "{law:?} ran {starts} times only");
    // Allows for a minute of the plant's log.
    assert!(grown < 16 << 20, "{law:?}: {grown} bytes more");
}
