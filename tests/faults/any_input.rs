//! Whatever comes in, in any order, in any scalar type: the cycle does not panic, no correction
//! is larger than its limits, and only a closed or a fading loop moves the robot.

use proptest::prelude::*;
use softdock_control::delay::{LawName, ModelVelocity};
use softdock_control::io::Sequence;
use softdock_control::modes::Command;
use softdock_control::scalar::{Fixed, Scalar};
use softdock_control::settings::{CorrectionMode, DynamicCompensation, Settings};
use softdock_tests::bench::Bench;

/// What happens in one cycle.
#[derive(Clone, Debug)]
enum Event {
    Healthy,
    Wrench([f64; 6]),
    Pose(Option<[f64; 6]>),
    Sequence(Sequence),
    Status(u32),
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
        1 => any::<u32>().prop_map(Event::Status),
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

fn happen<S: Scalar>(bench: &mut Bench<S>, event: &Event) -> Result<(), String> {
    match event.clone() {
        Event::Healthy => bench.cycle(|_| {}),
        Event::Wrench(wrench) => bench.cycle(|inputs| inputs.sensor.wrench = wrench),
        Event::Pose(pose) => bench.cycle(|inputs| inputs.robot.pose = pose),
        Event::Sequence(sequence) => bench.cycle(|inputs| inputs.robot.sequence = sequence),
        Event::Status(status) => bench.cycle(|inputs| inputs.sensor.status = status),
        Event::Saturated => bench.cycle(|inputs| inputs.sensor.saturated = true),
        Event::Stale => bench.stale(),
        Event::LateAnswers(count) => bench.cycle(|inputs| inputs.robot.late_answers = count),
        Event::Poscorr(stat) => bench.cycle(|inputs| inputs.robot.status = stat),
        Event::Command(word) => bench.cycle(|inputs| inputs.command = Some(word)),
        Event::Restart => return bench.restart(),
    }
    .map(|_| ())
}

fn survives<S: Scalar>(
    settings: &Settings,
    start: [f64; 6],
    events: &[Event],
) -> Result<(), TestCaseError> {
    let mut bench = Bench::<S>::new(settings, start);
    events
        .iter()
        .try_for_each(|event| happen(&mut bench, event))
        .map_err(TestCaseError::fail)
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
