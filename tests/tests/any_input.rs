//! Whatever comes in, in any order, in any scalar type: the cycle does not panic, no correction
//! is larger than its limits, and only a closed or a fading loop moves the robot.

use nalgebra::Vector3;
use proptest::prelude::*;
use softdock_control::delay::{LawName, ModelVelocity};
use softdock_control::frames::orientation_from_abc;
use softdock_control::io::{CycleRecord, Inputs, Sequence};
use softdock_control::modes::{Command, Mode};
use softdock_control::scalar::{Fixed, Scalar};
use softdock_control::settings::{CorrectionMode, DynamicCompensation, Settings};
use softdock_tests::driver::Driver;

/// What happens in one cycle.
#[derive(Clone, Debug)]
enum Event {
    Healthy,
    Wrench([f64; 6]),
    Pose(Option<[f64; 6]>),
    Sequence(Sequence),
    Status(u16),
    Saturated,
    Stale,
    LateAnswers(u32),
    Poscorr(u32),
    Command(Command),
    /// Reset, hold, arm and start in four cycles.
    Restart,
}

/// Any number at all: not a number, infinite, huge, tiny, or of a sensible size.
fn any_number() -> impl Strategy<Value = f64> + Clone {
    prop_oneof![
        prop::num::f64::ANY,
        -1e9..1e9f64,
        -10.0..10.0f64,
        Just(f64::MAX)
    ]
}

fn any_event() -> impl Strategy<Value = Event> {
    let six = prop::array::uniform6(any_number());
    let sequence = prop_oneof![
        Just(Sequence::NewRun),
        any::<u32>().prop_map(Sequence::Gap),
        (0..12_u32).prop_map(Sequence::Gap),
    ];
    let command = prop::sample::select(Command::WORDS.map(|(_, command)| command).to_vec());
    prop_oneof![
        20 => Just(Event::Healthy),
        10 => prop::array::uniform6(-15.0..15.0f64).prop_map(Event::Wrench),
        3 => prop::array::uniform6(-3000.0..3000.0f64).prop_map(Event::Wrench),
        1 => six.clone().prop_map(Event::Wrench),
        1 => six.prop_map(|pose| Event::Pose(Some(pose))),
        1 => Just(Event::Pose(None)),
        1 => sequence.prop_map(Event::Sequence),
        1 => any::<u16>().prop_map(Event::Status),
        1 => Just(Event::Saturated),
        3 => Just(Event::Stale),
        1 => any::<u32>().prop_map(Event::LateAnswers),
        1 => any::<u32>().prop_map(Event::Poscorr),
        3 => command.prop_map(Event::Command),
        6 => Just(Event::Restart),
    ]
}

/// Rigs of very different size.
fn any_settings() -> impl Strategy<Value = Settings> {
    let mass = prop::sample::select(vec![0.1, 500.0, 1e6]);
    let flags = prop::array::uniform6(any::<bool>());
    let motion = prop::array::uniform6(-0.2..0.2f64);
    let far = prop::sample::select(vec![0.0, 1.0, 1e3]);
    (mass.clone(), mass, flags, motion, far).prop_map(
        |(mass_k, mass_q, [absolute, seed, end, fixed, inertial, rod], motion, far)| {
            let mut settings = Settings::default();
            let [x, y, z, a, b, c] = motion;
            let bodies = [
                (&mut settings.body_k, mass_k, far),
                (&mut settings.body_q, mass_q, -far),
            ];
            for (body, mass, place) in bodies {
                body.mass_kg = mass;
                let inertia = (mass * 0.2).max(1e-3);
                (0..3).for_each(|i| body.inertia_kg_m2[i] = [0.0; 3]);
                (0..3).for_each(|i| body.inertia_kg_m2[i][i] = inertia * (1.0 + i as f64));
                if rod {
                    body.inertia_kg_m2[2][2] = (inertia * 5e3).min(1e6);
                }
                body.position_m = [place, 0.5 * place, 0.0];
                body.angular_velocity_rad_s = [a, b, c];
            }
            settings.body_k.velocity_m_s = [x, y, z];
            settings.body_q.fixed = fixed;
            if absolute {
                settings.robot.correction_mode = CorrectionMode::Absolute;
            }
            if seed {
                settings.delay.law = LawName::Seed;
            }
            if end {
                settings.delay.model_velocity = ModelVelocity::End;
            }
            if inertial {
                settings.sensor.dynamic_compensation = DynamicCompensation::LoadReaction;
                settings.sensor.tool_mass_kg = 2000.0;
                settings.sensor.tool_com_m = [1.0, -1.0, 2.0];
            }
            settings
        },
    )
}

/// A cycle and an ideal robot that does what it is told.
struct Bench<S: Scalar> {
    driver: Driver<S>,
    settings: Settings,
    /// Counts that the robot stands away from its start.
    offset: [i64; 6],
    start: [f64; 6],
    was_moving: bool,
}

impl<S: Scalar> Bench<S> {
    fn new(settings: &Settings, start: [f64; 6]) -> Self {
        Self {
            driver: Driver::new(settings),
            settings: settings.clone(),
            offset: [0; 6],
            start,
            was_moving: false,
        }
    }

    fn pose(&self) -> [f64; 6] {
        core::array::from_fn(|i| {
            let counts = self.offset[i] as f64;
            let scale = if i < 3 { 1e-7 } else { 1e-4_f64.to_radians() };
            self.start[i] + counts * scale
        })
    }

    fn event(&mut self, event: &Event) -> Result<(), TestCaseError> {
        let command = |command| move |inputs: &mut Inputs| inputs.command = Some(command);
        match event.clone() {
            Event::Healthy => self.cycle(|_| {}),
            Event::Wrench(wrench) => self.cycle(|inputs| inputs.sensor.wrench = wrench),
            Event::Pose(pose) => self.cycle(|inputs| inputs.robot.pose = pose),
            Event::Sequence(sequence) => self.cycle(|inputs| inputs.robot.sequence = sequence),
            Event::Status(status) => self.cycle(|inputs| inputs.sensor.status = status),
            Event::Saturated => self.cycle(|inputs| inputs.sensor.saturated = true),
            Event::Stale => self.checked(|driver| driver.step_stale(|_| {})),
            Event::LateAnswers(count) => self.cycle(|inputs| inputs.robot.late_answers = count),
            Event::Poscorr(stat) => self.cycle(|inputs| inputs.robot.poscorr_stat = stat),
            Event::Command(word) => self.cycle(command(word)),
            Event::Restart => [Command::Reset, Command::Hold, Command::Arm, Command::Start]
                .into_iter()
                .try_for_each(|word| self.cycle(command(word))),
        }
    }

    fn cycle(&mut self, change: impl FnOnce(&mut Inputs)) -> Result<(), TestCaseError> {
        self.checked(|driver| driver.step_with(change))
    }

    fn checked(
        &mut self,
        step: impl FnOnce(&mut Driver<S>) -> CycleRecord,
    ) -> Result<(), TestCaseError> {
        let before = self.pose();
        self.driver.inputs.robot.pose = Some(before);
        let record = step(&mut self.driver);
        let new_run = record.inputs.robot.sequence == Sequence::NewRun;
        let step: [i64; 6] = match self.settings.robot.correction_mode {
            CorrectionMode::Relative => record.output.correction,
            CorrectionMode::Absolute => {
                if new_run {
                    self.start = before;
                    self.offset = [0; 6];
                }
                core::array::from_fn(|i| record.output.correction[i] - self.offset[i])
            }
        };
        (0..6).for_each(|i| self.offset[i] += step[i]);
        self.within_limits(&step, &before)?;
        self.moves_only_when_it_may(&record, &step)?;
        finite(&record)
    }

    /// Half a digit of rounding before and after, in each of three components.
    fn within_limits(&self, step: &[i64; 6], before: &[f64; 6]) -> Result<(), TestCaseError> {
        let limits = &self.settings.limits;
        let [x, y, z, ..] = step.map(|counts| counts as f64 * 1e-7);
        let moved = Vector3::new(x, y, z).norm();
        prop_assert!(moved <= limits.step_m * 1.001 + 2e-7, "{moved} m: {step:?}");
        let turn = |[_, _, _, a, b, c]: [f64; 6]| orientation_from_abc::<f64>(&[a, b, c]);
        let angle = turn(*before).angle_to(&turn(self.pose()));
        prop_assert!(
            angle <= limits.step_rad * 1.001 + 1e-5,
            "{angle} rad: {step:?}"
        );
        Ok(())
    }

    fn moves_only_when_it_may(
        &mut self,
        record: &CycleRecord,
        step: &[i64; 6],
    ) -> Result<(), TestCaseError> {
        let may = match record.trace.mode {
            Mode::Running => true,
            Mode::Fault => false,
            Mode::Idle | Mode::Hold | Mode::Armed => self.was_moving,
        };
        prop_assert!(may || *step == [0; 6], "{:?}: {step:?}", record.trace.mode);
        self.was_moving = record.trace.sent_velocity != [0.0; 6];
        Ok(())
    }
}

fn finite(record: &CycleRecord) -> Result<(), TestCaseError> {
    let t = &record.trace;
    let numbers = [
        &t.pose[..],
        &t.wrench_at_m,
        &t.removed,
        &t.executed_velocity,
    ]
    .into_iter()
    .chain([
        &t.body_k.pose[..],
        &t.body_k.velocity,
        &t.body_q.pose,
        &t.body_q.velocity,
    ])
    .chain([
        &t.model_velocity[..],
        &t.law_velocity,
        &t.sent_velocity,
        &t.command_pose,
    ])
    .chain(t.law_parts.iter().map(|part| &part[..]));
    for (n, group) in numbers.enumerate() {
        prop_assert!(group.iter().all(|v| v.is_finite()), "group {n}: {t:?}");
    }
    Ok(())
}

fn survives<S: Scalar>(
    settings: &Settings,
    start: [f64; 6],
    events: &[Event],
) -> Result<(), TestCaseError> {
    let mut bench = Bench::<S>::new(settings, start);
    events.iter().try_for_each(|event| bench.event(event))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(150))]

    #[test]
    fn never_panics_never_jumps(
        settings in any_settings(),
        at in prop::array::uniform3(-2.0..2.0f64),
        turn in (-3.1..3.1f64, -1.4..1.4f64, -3.1..3.1f64),
        events in prop::collection::vec(any_event(), 1..400),
    ) {
        let start = [at[0], at[1], at[2], turn.0, turn.1, turn.2];
        survives::<f64>(&settings, start, &events)?;
        survives::<f32>(&settings, start, &events)?;
        survives::<Fixed>(&settings, start, &events)?;
    }
}
