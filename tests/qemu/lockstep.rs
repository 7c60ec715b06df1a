//! Machine code and host, step by step: the same answers and the same records in every bit, and
//! what each part of the work costs in instructions. Virtual time counts instructions, so each run
//! is the same.

use softdock_app::settings::BoardSettings;
use softdock_control::delay::LawName;
use softdock_control::modes::{FaultCode, Mode};
use softdock_lockstep::{Done, PARTS, Session, Step};
use softdock_report::{Cell, Column, Format, Table};
use softdock_rig::board::qemu::Chip;
use softdock_rig::firmware::{RELEASED, emulated_profile};
use softdock_tests::lockstep::{Emulated, SameBits, instructions, story};
use std::collections::BTreeSet;

/// 100 s: every chapter of the story.
const CYCLES: usize = 25_000;
/// The first chapter.
const CHAPTER: usize = 2_500;
/// Instructions for a whole answer: 1/16 ms at 480 MHz, if an instruction takes a cycle.
const ANSWER_BUDGET: u32 = 30_000;
/// The same with the predictor: 1/7 ms.
const PREDICTOR_BUDGET: u32 = 68_000;
/// The same with a lag and a servo believed behind the delay: 1/5 ms.
const SERVO_BUDGET: u32 = 95_000;
/// Instructions for dynamics and delay law.
const CONTROL_BUDGET: u32 = 6_000;
/// Instructions of the Cortex-M3 for a whole answer: 3.5 of 4 ms at 100 MHz, if an instruction takes a
/// cycle.
const M3_BUDGET: u32 = 350_000;

fn settings() -> BoardSettings {
    let mut settings = BoardSettings::default();
    settings.control.delay.law = LawName::Seed;
    settings.control.sensor.tool_mass_kg = 2.0;
    settings.control.sensor.tool_com_m = [0.01, -0.02, 0.05];
    // The inputs do not follow the answers, so the model may go where it likes.
    settings.control.limits.box_m = [5.0; 3];
    settings.control.limits.clamp_fault_cycles = 10_000;
    settings.control.start.max_force_n = 1000.0;
    settings.control.start.max_zero_force_n = 1000.0;
    settings
}

fn on_host(settings: &BoardSettings, steps: &[Step]) -> Vec<Done> {
    let mut session = Session::<f64>::new(settings).unwrap();
    steps
        .iter()
        .map(|step| session.take(step, &mut ()))
        .collect()
}

/// The steps lead through everything that they are meant to lead through.
fn assert_eventful(done: &[Done]) {
    let records: Vec<_> = done
        .iter()
        .filter_map(|done| done.record.as_ref())
        .collect();
    let running = records.iter().filter(|r| r.trace.mode == Mode::Running);
    let contact = running
        .clone()
        .filter(|r| r.inputs.sensor.wrench[0].abs() > 1.0);
    assert!(records.len() > 20_000, "{} cycles", records.len());
    assert!(running.count() > 5_000);
    assert!(contact.count() > 1_000);
    let modes: BTreeSet<_> = records
        .iter()
        .map(|r| format!("{:?}", r.trace.mode))
        .collect();
    assert_eq!(modes.len(), 5, "{modes:?}");
    let faults: BTreeSet<_> = records
        .iter()
        .filter_map(|r| r.trace.fault)
        .map(|fault| format!("{:?}", fault.code))
        .collect();
    assert!(faults.len() >= 4, "{faults:?}");
    assert!(records.iter().any(|r| r.trace.refusal.is_some()));
}

/// Median and maximum of a part of the work while the loop is closed, instructions.
fn cost(done: &[Done], part: impl Fn(&Done) -> u32) -> [u32; 2] {
    let running = |done: &&Done| {
        let record = done.record.as_ref();
        record.is_some_and(|r| r.trace.mode == Mode::Running)
    };
    let ticks = done.iter().filter(running).map(part);
    let mut counts: Vec<u32> = ticks.map(instructions).collect();
    counts.sort_unstable();
    [counts[counts.len() / 2], counts[counts.len() - 1]]
}

fn total(done: &Done) -> u32 {
    done.cost.iter().sum()
}

/// Dynamics and delay law.
fn control(done: &Done) -> u32 {
    done.cost[2] + done.cost[3]
}

fn print_costs(title: &str, done: &[Done]) {
    let mut table = Table::new(vec![
        Column::text(title),
        Column::number("Median", "instructions"),
        Column::number("Maximum", "instructions"),
    ]);
    let mut row = |name: &str, [median, most]: [u32; 2]| {
        let count = |n: u32| Cell::formatted(n.into(), Format::Fixed(0));
        table.push(vec![Cell::text(name), count(median), count(most)]);
    };
    for (part, name) in PARTS.iter().enumerate() {
        row(name, cost(done, |done| done.cost[part]));
    }
    row("whole answer", cost(done, total));
    println!("{table}");
}

#[test]
fn the_first_chapter_is_the_same_in_every_bit() {
    let mut settings = settings();
    settings.control.delay.law = LawName::Predictor;
    settings.control.delay.predictor.interlock = false;
    let steps = story(&settings, CHAPTER);
    same_bits("lockstep_chapter", &settings, steps);
}

/// Host and board in every bit; the costs on the board: of a whole answer and of dynamics and law.
fn same_bits(name: &str, settings: &BoardSettings, steps: Vec<Step>) -> [u32; 2] {
    let host = on_host(settings, &steps);
    if steps.len() > CHAPTER {
        assert_eventful(&host);
    }
    let board = Emulated::run(name, Chip::An500, settings, steps);
    assert_eq!(board.len(), host.len());

    let mut judge = SameBits::default();
    for (board, host) in board.iter().zip(&host) {
        judge.judge(board, host);
    }
    print_costs("Cortex-M7, f64", &board);
    let ([_, answer], [_, control]) = (cost(&board, total), cost(&board, control));
    [answer, control]
}

#[test]
#[ignore = "long: 25,000 cycles in QEMU, counted with the real profile"]
fn the_cortex_m7_sends_every_bit_that_the_host_sends_within_its_budget() {
    let settings = settings();
    let steps = story(&settings, CYCLES);
    let [answer, control] = same_bits("lockstep_m7", &settings, steps);
    assert!(answer <= ANSWER_BUDGET, "{answer} instructions");
    assert!(control <= CONTROL_BUDGET, "{control} instructions");
}

/// The default law, in contact for as long as the story pushes: its worst cycle.
#[test]
#[ignore = "long: 25,000 cycles in QEMU, counted with the real profile"]
fn the_predictor_is_the_same_on_the_board_and_within_its_budget() {
    let mut settings = settings();
    settings.control.delay.law = LawName::Predictor;
    settings.control.delay.actuator.pause_s = 0.016;
    // The robot of the story does not answer the commands.
    settings.control.delay.predictor.interlock = false;
    let steps = story(&settings, CYCLES);
    let [answer, _] = same_bits("lockstep_predictor", &settings, steps);
    assert!(answer <= PREDICTOR_BUDGET, "{answer} instructions");
}

/// A robot that is believed to have a lag and a servo behind its delay: the longest way ahead.
#[test]
#[ignore = "long: 25,000 cycles in QEMU, counted with the real profile"]
fn the_predictor_with_lag_and_servo_is_within_its_budget() {
    let mut settings = settings();
    settings.control.delay.law = LawName::Predictor;
    settings.control.delay.actuator.delay_s = 0.022;
    settings.control.delay.actuator.lag_s = 0.005;
    settings.control.delay.actuator.servo_hz = 20.0;
    settings.control.delay.actuator.pause_s = 0.016;
    settings.control.delay.predictor.interlock = false;
    let steps = story(&settings, CYCLES);
    let [answer, _] = same_bits("lockstep_servo", &settings, steps);
    assert!(answer <= SERVO_BUDGET, "{answer} instructions");
}

/// A robot with a cycle of 1 ms, and the laws that are quick enough for it.
#[test]
fn a_cycle_of_a_millisecond_is_the_same_in_every_bit() {
    for law in [LawName::Seed, LawName::Lead] {
        let mut settings = settings();
        settings.control.robot.cycle_s = 0.001;
        settings.can.sample_wait_s = 0.0004;
        // A jog may not change its velocity by more in a cycle.
        settings.control.jog.speed_m_s = 0.005;
        settings.control.jog.reach_m = 0.02;
        settings.control.jog.speed_rad_s = 0.0075;
        settings.control.jog.reach_rad = 0.02;
        settings.control.delay.law = law;
        let steps = story(&settings, CHAPTER);
        let [answer, _] = same_bits(&format!("lockstep_1_khz_{}", law.name()), &settings, steps);
        if emulated_profile() == RELEASED {
            assert!(answer <= ANSWER_BUDGET, "{law:?}: {answer} instructions");
        }
    }
}

#[test]
#[ignore = "long: 2,300 cycles in QEMU, counted with the real profile"]
fn the_cortex_m3_follows_in_fixed_point_within_its_cycle() {
    let settings = settings();
    // Up to the first fault both go the same way; later they may latch it a cycle apart.
    let steps = story(&settings, 2300);
    let host = on_host(&settings, &steps);
    let board = Emulated::run("lockstep_m3", Chip::An385, &settings, steps);
    print_costs("Cortex-M3, 64-bit fixed point", &board);

    let mut worst = [0.0_f64; 2];
    for (n, (board, host)) in board.iter().zip(&host).enumerate() {
        let (Some(board), Some(host)) = (&board.record, &host.record) else {
            assert_eq!(board.answer.is_empty(), host.answer.is_empty(), "step {n}");
            continue;
        };
        assert_eq!(board.trace.mode, host.trace.mode, "step {n}");
        assert_ne!(board.trace.fault.map(|f| f.code), Some(FaultCode::Numeric));
        let pairs = |a: &[f64], b: &[f64]| {
            let apart = a.iter().zip(b).map(|(a, b)| (a - b).abs());
            apart.fold(0.0, f64::max)
        };
        let (b, h) = (&board.trace, &host.trace);
        worst[0] = worst[0].max(pairs(&b.command_pose, &h.command_pose));
        worst[1] = worst[1].max(pairs(&b.sent_velocity, &h.sent_velocity));
    }
    println!(
        "deviation from f64: pose {:.1e} m, velocity {:.1e} m/s",
        worst[0], worst[1]
    );
    // A threshold of the law, passed a cycle earlier or later, shows in the velocity; the pose stays
    // below what a robot repeats.
    assert!(worst[0] < 5e-6 && worst[1] < 1e-4, "{worst:?}");

    let [_, answer] = cost(&board, total);
    assert!(answer <= M3_BUDGET, "{answer} instructions");
}
