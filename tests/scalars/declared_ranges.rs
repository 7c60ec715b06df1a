//! Every setting and every input, at the ends of its declared range and beyond, in three scalar
//! types: beyond, a setting is refused by name; at the ends the cycle runs through an ordeal of
//! extreme inputs and stays finite, saturates, says so, and never wraps.
//!
//! Fixed point panics on overflow in this profile. Besides, what is a function of the inputs
//! alone is compared with f64: a wrap is an error of 4e9.

use proptest::prelude::*;
use softdock_app::record::{CycleRecord, Inputs};
use softdock_app::robot_cycle::RobotCycle;
use softdock_control::delay::LawName;
use softdock_control::io::Sequence;
use softdock_control::limits::LimitFlags;
use softdock_control::modes::{Command, FaultCode, Mode};
use softdock_control::scalar::{Fixed, Scalar};
use softdock_control::settings::{BodySettings, DynamicCompensation, Settings};
use softdock_tests::bench::Bench;
use softdock_tests::every_setting::{Field, Kind, every_setting, made_to_fit};
use std::f64::consts::FRAC_PI_2;

/// Cycles from one start to the next, and of rest after a start.
const BLOCK: usize = 250;
const REST: usize = 60;
/// Commands with which a block begins.
const START_UP: [Command; 4] = [Command::Reset, Command::Hold, Command::Arm, Command::Start];
/// All kinds of extremes.
const ORDEAL: usize = 8 * BLOCK;
/// Largest difference of a wrench to that of f64, N and N·m. The range is 1e8 N·m; 1e-5 of that
/// is what the fixed-point estimate of the acceleration costs with the heaviest tool.
const WRENCH_TOLERANCE: f64 = 1e3;
/// Start pose: A and C at ±90°, where one of sine and cosine vanishes, and far away.
const START: [f64; 6] = [-900.0, 2.0, 1.0, FRAC_PI_2, 0.7, -FRAC_PI_2];

/// Every part of the cycle has something to do, and no fault ends it early.
fn busy() -> Settings {
    let mut settings = Settings::default();
    for (body, speed) in [(&mut settings.body_k, 0.02), (&mut settings.body_q, -0.01)] {
        body.velocity_m_s = [speed, 0.01, 0.0];
        body.angular_velocity_rad_s = [0.01, speed, -0.02];
        body.position_m = [40.0 * speed, 0.1, 0.0];
    }
    let sensor = &mut settings.sensor;
    sensor.dynamic_compensation = DynamicCompensation::LoadReaction;
    (sensor.tool_mass_kg, sensor.tool_com_m) = (0.3, [0.01, -0.02, 0.09]);
    sensor.frozen_after_cycles = 0;
    settings.limits.clamp_fault_cycles = 10_000;
    settings
}

/// Inputs of one cycle of an ordeal: the kinds of extremes that come with a fresh sample.
fn extreme(kind: usize, n: usize, settings: &Settings, inputs: &mut Inputs) {
    let limits = &settings.limits;
    let sign = if n % 14 < 7 { 1.0 } else { -1.0 };
    let load = |share: f64| {
        let (f, t) = (share * limits.force_n, share * limits.torque_n_m);
        [f, -f, f, t, -t, t]
    };
    match kind {
        0 => inputs.sensor.wrench = load(0.55),
        1 => inputs.sensor.wrench = load(0.55 * sign),
        2 => inputs.robot.status = 0xfe,
        3 => {
            inputs.robot.pose = Some([1e3, -1e3, 1e3, 10.0, -10.0, 10.0].map(|v| v * sign));
            let lost = if n.is_multiple_of(2) { 99 } else { u32::MAX };
            inputs.robot.sequence = Sequence::Gap(if n.is_multiple_of(3) { 0 } else { lost });
        }
        4 => {
            let extremes = [1e6, 1e9, f64::MAX, f64::INFINITY, f64::NAN, 5e-324];
            let reading = extremes[n % extremes.len()] * sign;
            inputs.sensor.wrench = [reading; 6];
        }
        5 => inputs.sensor.wrench = load(1.5 * sign),
        6 => {
            let poses = [1e3_f64.next_up(), f64::NAN, f64::NEG_INFINITY, 1e300];
            inputs.robot.pose = Some([poses[n % poses.len()]; 6]);
        }
        _ => {}
    }
}

/// What an extreme input must leave behind.
fn is_flagged(settings: &Settings, record: &CycleRecord) -> Result<(), String> {
    let (inputs, trace) = (&record.inputs, &record.trace);
    let unreadable = |v: &f64| v.is_nan() || v.abs() > 1e6;
    let flagged = trace.limits.has(LimitFlags::MEASURED);
    if inputs.sensor.wrench.iter().any(unreadable) && !flagged {
        return Err(format!("no flag: {inputs:?}"));
    }
    let [x, y, z, ..] = trace.wrench_at_m;
    let force = (x * x + y * y + z * z).sqrt();
    if force > settings.limits.force_n * 1.001 && trace.mode == Mode::Running {
        return Err(format!("{force} N and no fault"));
    }
    let by = |code| trace.fault.is_some_and(|f| f.code == code);
    if by(FaultCode::Overload) && settings.limits.stop_on_overload && trace.mode != Mode::Fault {
        return Err(format!("not latched: {trace:?}"));
    }
    Ok(())
}

/// An ordeal beside a cycle in f64 that gets the same inputs, with which fixed point is compared.
struct Ordeal<S: Scalar> {
    bench: Bench<S>,
    reference: Option<RobotCycle<f64>>,
    settings: Settings,
}

impl<S: Scalar> Ordeal<S> {
    fn new(settings: &Settings, compared: bool) -> Self {
        Self {
            bench: Bench::new(settings, START),
            reference: compared.then(|| RobotCycle::new(settings).unwrap()),
            settings: settings.clone(),
        }
    }

    /// Answers how many cycles moved the robot by a closed loop.
    fn run(&mut self, cycles: std::ops::Range<usize>) -> Result<usize, String> {
        let mut running = 0;
        for n in cycles {
            let (kind, step) = (n / BLOCK, n % BLOCK);
            let record = match (kind, step) {
                (7, REST..) if step % 5 < 3 => self.bench.stale()?,
                (_, REST..) => {
                    let settings = &self.settings;
                    self.bench
                        .cycle(|inputs| extreme(kind, step, settings, inputs))?
                }
                // Reset, hold, arm and start, then rest.
                _ => self
                    .bench
                    .cycle(|inputs| inputs.command = START_UP.get(step).copied())?,
            };
            running += usize::from(record.trace.mode == Mode::Running);
            is_flagged(&self.settings, &record)?;
            self.compare(&record)
                .map_err(|error| format!("cycle {n}: {error}"))?;
        }
        Ok(running)
    }

    fn compare(&mut self, record: &CycleRecord) -> Result<(), String> {
        let Some(reference) = &mut self.reference else {
            return Ok(());
        };
        let known = reference.step(&record.inputs).trace;
        let found = &record.trace;
        let pairs = found.wrench_at_m.iter().zip(&known.wrench_at_m);
        for (found, known) in pairs.chain(found.removed.iter().zip(&known.removed)) {
            if (found - known).abs() > WRENCH_TOLERANCE {
                return Err(format!("{found}, in f64 {known}"));
            }
        }
        Ok(())
    }
}

/// In all three scalars; answers the most cycles that ran closed.
fn endure(name: &str, settings: &Settings, cycles: std::ops::Range<usize>) -> usize {
    let runs = (0..SCALARS).map(|scalar| endure_in(scalar, name, settings, cycles.clone()));
    runs.max().unwrap_or_default()
}

/// f64, f32 and fixed point.
const SCALARS: usize = 3;

/// In one of the scalars.
fn endure_in(
    scalar: usize,
    name: &str,
    settings: &Settings,
    cycles: std::ops::Range<usize>,
) -> usize {
    let outcome = match scalar % SCALARS {
        0 => Ordeal::<f64>::new(settings, false).run(cycles),
        1 => Ordeal::<f32>::new(settings, false).run(cycles),
        _ => Ordeal::<Fixed>::new(settings, true).run(cycles),
    };
    match outcome {
        Ok(running) => running,
        Err(error) => panic!("{name}: {error}\n{settings:?}"),
    }
}

fn field<'a>(name: &str, all: &'a [Field]) -> &'a Field {
    all.iter()
        .find(|f| f.name == name)
        .unwrap_or_else(|| panic!("no setting `{name}`"))
}

/// All delay laws, by the names that a settings file may have.
fn laws(all: &[Field]) -> Vec<LawName> {
    let law = field("delay.law", all);
    let corners = law.corners();
    let set = |word| law.set(&Settings::default(), word).unwrap().delay.law;
    corners.iter().map(set).collect()
}

#[test]
fn a_value_beyond_its_range_is_refused_by_name() {
    let all = every_setting();
    assert!(all.len() > 60, "{}", all.len());
    let base = Settings::default();
    for field in &all {
        for value in field.beyond() {
            for spoilt in [
                field.set_first(&base, &value),
                field.set_last(&base, &value),
            ] {
                // What the type cannot hold, the parser refuses.
                let Ok(spoilt) = spoilt else { continue };
                let refused = spoilt.validate().map_err(|e| e.field);
                assert!(
                    refused.is_err_and(|name| name.starts_with(&field.name)),
                    "`{}` = {value}: {refused:?}",
                    field.name
                );
                assert!(RobotCycle::<Fixed>::new(&spoilt).is_err());
            }
        }
    }
}

#[test]
fn every_setting_at_the_ends_of_its_range_in_a_scalar_by_turns() {
    every_setting_at_the_ends_of_its_range(1);
}

#[test]
#[ignore = "long: every setting at the ends of its range in three number types"]
fn every_setting_at_the_ends_of_its_range_in_every_scalar() {
    every_setting_at_the_ends_of_its_range(SCALARS);
}

/// One field at a time at each end of its range, beside settings that use everything; in so many scalars.
fn every_setting_at_the_ends_of_its_range(scalars: usize) {
    let all = every_setting();
    let laws = laws(&all);
    let mut running = 0;
    for (i, field) in all.iter().enumerate() {
        for (j, corner) in field.corners().iter().enumerate() {
            let mut base = busy();
            base.delay.law = laws[(i + j) % laws.len()];
            let wanted = field.set(&base, corner).unwrap();
            let Some(settings) = made_to_fit(wanted, field, &all) else {
                // All elements alike are no tensor; see the tensors below.
                assert!(field.name.ends_with("inertia_kg_m2"), "{}", field.name);
                continue;
            };
            let name = format!("`{}` = {corner}", field.name);
            for scalar in 0..scalars {
                running += endure_in(i + j + scalar, &name, &settings, 0..ORDEAL);
            }
        }
    }
    assert!(running > 20_000, "hardly ever closed: {running} cycles");
}

/// The spacecraft's inertia: a tensor's elements have their ranges only together.
#[test]
fn tensors_at_the_ends_of_their_range() {
    let slanted = |least: f64, most: f64| {
        // Largest along (1, 1, 1), least across: ratio most / least.
        let (mean, apart) = ((most + 2.0 * least) / 3.0, (most - least) / 3.0);
        [
            [mean, apart, apart],
            [apart, mean, apart],
            [apart, apart, mean],
        ]
    };
    let diagonal = |a: f64, b: f64, c: f64| [[a, 0.0, 0.0], [0.0, b, 0.0], [0.0, 0.0, c]];
    let tensors = [
        diagonal(1e-3, 1e-3, 1e-3),
        diagonal(1e-3, 9.99, 1e-3),
        diagonal(1e6, 1e6, 1e6),
        diagonal(1e6, 100.001, 1e6),
        slanted(1e-3, 9.0),
        slanted(300.0, 2.9e6),
    ];
    for (n, tensor) in tensors.iter().enumerate() {
        for mass_kg in [0.1, 1e6] {
            let mut settings = busy();
            for body in [&mut settings.body_k, &mut settings.body_q] {
                *body = BodySettings {
                    inertia_kg_m2: *tensor,
                    mass_kg,
                    ..body.clone()
                };
            }
            (settings.limits.force_n, settings.limits.torque_n_m) = (1e5, 1e5);
            endure(&format!("tensor {n}"), &settings, 0..ORDEAL);
        }
    }
}

/// All combinations of the ends of some fields that are wanted, as one grid.
fn grid(
    names: &[&str],
    all: &[Field],
    base: Settings,
    wanted: impl Fn(&Settings) -> bool,
) -> Vec<Settings> {
    names.iter().fold(vec![base], |grid, name| {
        let field = field(name, all);
        let place = |settings: &Settings| {
            let corners = field.corners();
            let at = |corner| made_to_fit(field.set(settings, corner).unwrap(), field, all);
            corners
                .iter()
                .filter_map(at)
                .filter(&wanted)
                .collect::<Vec<_>>()
        };
        grid.iter().flat_map(place).collect()
    })
}

/// Whether the settings of every law but the chosen one are as before: no other law reads them.
fn others_are_untouched(settings: &Settings, before: &Settings) -> bool {
    let (now, before) = (&settings.delay, &before.delay);
    (now.law == LawName::Seed || now.seed == before.seed)
        && (matches!(now.law, LawName::Smith | LawName::SmithDeadZone) || now.smith == before.smith)
        && (now.law == LawName::Predictor || now.predictor == before.predictor)
}

/// Every seventh: no word and no flag has as many values, so that each takes all of its turns.
#[test]
fn combinations_of_words_and_flags_in_a_scalar_by_turns() {
    combinations_of_words_and_flags(7, 1);
}

#[test]
#[ignore = "long: all combinations of words and flags in three number types"]
fn all_combinations_of_words_and_flags_in_every_scalar() {
    combinations_of_words_and_flags(1, SCALARS);
}

/// Words and flags with each other: each of so many combinations, in so many scalars.
fn combinations_of_words_and_flags(step: usize, scalars: usize) {
    let all = every_setting();
    let mut choices: Vec<_> = all
        .iter()
        .filter(|f| matches!(f.kind, Kind::Flag | Kind::Word(_)))
        .map(|f| f.name.as_str())
        .collect();
    assert!(choices.len() >= 8, "{choices:?}");
    // First the law, which says what else matters.
    choices.sort_by_key(|name| *name != "delay.law");
    let busy = busy();
    let untouched = |settings: &Settings| others_are_untouched(settings, &busy);
    let combinations = grid(&choices, &all, busy.clone(), untouched);
    let different: Vec<_> = combinations.iter().step_by(step).collect();
    for law in laws(&all) {
        let is_there = different.iter().any(|s| s.delay.law == law);
        assert!(is_there, "{law:?} is left out");
    }
    for (n, settings) in different.into_iter().enumerate() {
        for scalar in 0..scalars {
            endure_in(n + scalar, "words and flags", settings, BLOCK..BLOCK + 150);
        }
    }
}

/// From the fastest rig with the coarsest digits to the slowest with the finest.
#[test]
fn all_corners_of_the_limits() {
    let all = every_setting();
    let names = [
        "robot.cycle_s",
        "robot.correction_decimals",
        "limits.step_m",
        "limits.speed_m_s",
        "limits.acceleration_m_s2",
        "limits.box_m",
    ];
    let corners = grid(&names, &all, busy(), |_| true);
    assert_eq!(corners.len(), 64);
    for settings in corners {
        endure("limits", &settings, BLOCK..2 * BLOCK);
    }
}

/// The lightest spacecraft, the widest limits, the largest gains, with each law.
#[test]
fn every_law_with_the_widest_settings() {
    let all = every_setting();
    for law in laws(&all) {
        let mut settings = busy();
        for field in all.iter().filter(|f| {
            f.name.starts_with("limits.") || f.name.starts_with("delay.") && f.name != "delay.law"
        }) {
            let corners = field.corners();
            let wanted = corners.last().map(|corner| field.set(&settings, corner));
            settings = made_to_fit(wanted.unwrap().unwrap(), field, &all).unwrap();
        }
        settings.delay.law = law;
        (settings.body_k.mass_kg, settings.body_q.mass_kg) = (0.1, 0.1);
        settings.body_k.position_m = [1e3; 3];
        settings.body_q.position_m = [-1e3; 3];
        endure(&format!("{law:?}"), &settings, 0..ORDEAL);
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(24) })]

    /// Any fields at any ends of their ranges at once.
    #[test]
    fn any_corner_of_all_settings(choice in prop::collection::vec(0..4_usize, 100)) {
        let all = every_setting();
        let mut settings = busy();
        for (field, choice) in all.iter().zip(choice.iter().cycle()) {
            let Some(corner) = field.corners().get(*choice).cloned() else { continue };
            let wanted = field.set(&settings, &corner).unwrap();
            settings = made_to_fit(wanted, field, &all).unwrap_or(settings);
        }
        endure("any corner", &settings, 0..ORDEAL);
    }
}
