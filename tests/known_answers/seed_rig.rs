//! The paper's law on the late robot: what it achieves, and the failings that are its own.
//!
//! Speeds are those of the model; scenario S is a pure delay of 32 ms, a pause of 16 ms and a
//! contact of 150 ms.

use softdock_control::delay::LawName;
use softdock_control::io::Trace;
use softdock_control::scalar::Scalar;
use softdock_statistics::RandomStream;
use softdock_tests::closed_loop::ClosedLoop;
use softdock_tests::in_three_scalars;
use softdock_tests::walls::{CYCLE_S, Case};

/// (speed in mm/s, restitution) of the law as set by default; touch in the middle of a cycle.
const SCENARIO_S: [(f64, f64); 8] = [
    (1.0, 1.12),
    (2.0, 0.99),
    (3.0, 0.93),
    (5.0, 0.87),
    (8.0, 0.87),
    (10.0, 0.92),
    (12.0, 1.04),
    (15.0, 1.12),
];

fn scenario_s(speed_mm_s: f64) -> Case {
    Case::scenario_s(speed_mm_s * 1e-3, LawName::Seed)
}

/// With both cures that are not in print.
fn cured(mut case: Case) -> Case {
    case.settings.delay.seed.gate_sums = true;
    case.settings.delay.seed.reset_after_quiet_cycles = 25;
    case
}

fn reaches_its_restitution<S: Scalar>(tolerance: f64) {
    for (speed, known) in SCENARIO_S {
        let e = scenario_s(speed).restitution::<S>();
        assert!(
            (e - known).abs() < tolerance,
            "{speed} mm/s: {e}, known {known}"
        );
    }
}

in_three_scalars! {
    /// Two digits are known. A cycle's shift of a sign change would move e by 0.05.
    scenario: reaches_its_restitution => f64 0.01, f32 0.01, fixed 0.01
}

/// The law works in whole cycles: where the touch falls within a cycle moves the restitution by
/// up to 0.06, so that the worst over all places is 18 %, not the 13 % of the middle.
#[test]
fn restitution_depends_on_the_place_of_the_touch_within_a_cycle() {
    let mut worst = 0.0_f64;
    for (speed, _) in SCENARIO_S {
        for eighth in 0..8 {
            let mut case = scenario_s(speed);
            case.right_m += (f64::from(eighth) / 8.0 - 0.5) * CYCLE_S * speed * 1e-3;
            worst = worst.max((case.restitution::<f64>() - 1.0).abs());
        }
    }
    assert!((0.16..0.19).contains(&worst), "{worst}");
}

/// The printed text taken literally, without low-pass and saturation, misses its claim.
#[test]
fn without_preprocessing_the_spacecraft_sticks_at_higher_speeds() {
    for (speed, known) in [
        (1.0, 0.75),
        (2.0, 0.51),
        (5.0, 0.11),
        (10.0, -0.06),
        (15.0, -0.16),
    ] {
        let mut case = Case::new(23.0, speed * 1e-3);
        case.actuator.delay_s = 0.032;
        case.actuator.pause_s = 0.012;
        case.settings.delay.law = LawName::Seed;
        let seed = &mut case.settings.delay.seed;
        (seed.threshold_mm_s, seed.saturation_mm_s, seed.low_pass_hz) = (0.01, 10.0, 1000.0);
        let e = case.restitution::<f64>();
        assert!((e - known).abs() < 0.02, "{speed} mm/s: {e}, known {known}");
    }
}

/// "After the collision, the compensated speed curve and the model output speed curve gradually
/// coincide", says the paper; by its formulas they do not: the sums stay, and v_back removes less
/// than a per cent of the offset in half a second.
#[test]
fn an_offset_remains_after_the_contact() {
    for (speed, model, command) in [
        (1.0, -1.118, -0.11),
        (5.0, -0.871, -1.28),
        (15.0, -1.121, -0.71),
    ] {
        let case = scenario_s(speed);
        let mut rig = case.start::<f64>();
        case.bounce(&mut rig, 20.0);
        let relative = |t: &Trace| {
            (
                t.model_velocity[0] * 1e3 / speed,
                t.law_velocity[0] * 1e3 / speed,
            )
        };
        let after = |rig: &mut ClosedLoop<f64>, cycles| {
            (1..cycles).fold(rig.step(), |_, _| rig.step()).trace
        };
        let (v_model, v_cmd) = relative(&after(&mut rig, 20));
        assert!(
            (v_model - model).abs() < 0.01,
            "{speed} mm/s: model {v_model}"
        );
        assert!(
            (v_cmd - command).abs() < 0.05,
            "{speed} mm/s: command {v_cmd}"
        );
        // The low-pass has settled after another 20 cycles; what v_back does starts there.
        let (early_model, early) = relative(&after(&mut rig, 20));
        let (late_model, late) = relative(&after(&mut rig, 125));
        let (early, late) = (early - early_model, late - late_model);
        assert!(
            (1.0 - late / early).abs() < 0.01,
            "{speed} mm/s: {early} to {late}"
        );
    }
}

/// The cures remove the offset.
#[test]
fn reset_sums_let_command_and_model_coincide() {
    let case = cured(scenario_s(5.0));
    let mut rig = case.start::<f64>();
    case.bounce(&mut rig, 20.0);
    let last = (0..100).fold(rig.step(), |_, _| rig.step()).trace;
    let offset = last.law_velocity[0] - last.model_velocity[0];
    assert!(offset.abs() < 1e-3 * 5e-3, "{offset}");
}

/// Speed ratios after up to ten bounces between two walls; ends early when the run faults.
fn bounces(mut case: Case) -> Vec<f64> {
    case.right_m = 0.02;
    case.left_m = 0.02;
    let speed = case.speed_m_s();
    let mut rig = case.start::<f64>();
    let ratios = (0..10).map_while(|_| case.bounce(&mut rig, 60.0));
    ratios.map(|v| (v / speed).abs()).collect()
}

#[test]
fn repeated_bounces_run_away() {
    let ratios = bounces(scenario_s(5.0));
    assert!(ratios[0] < 1.0 && ratios[2] > 10.0, "{ratios:?}");
    assert!(ratios.len() < 10, "no limit stopped it: {ratios:?}");
}

#[test]
fn reset_and_gated_sums_survive_repeated_bounces() {
    let ratios = bounces(cured(scenario_s(5.0)));
    assert_eq!(ratios.len(), 10);
    let (mut last, steps) = (1.0, &ratios);
    for ratio in steps {
        assert!((0.80..1.0).contains(&(ratio / last)), "{ratios:?}");
        last = *ratio;
    }
    assert!((ratios[9] - 0.42).abs() < 0.03, "{ratios:?}");
}

/// v_cmd − v_model (mm/s) after 10 s of free flight with white noise on the force.
fn drift(case: &Case, noise_n: f64) -> f64 {
    let mut case = case.clone();
    case.right_m = 1e3;
    let mut random = RandomStream::new(1, 0);
    let mut rig = case.start::<f64>();
    let mut step = || {
        let noise_n = noise_n * random.normal();
        rig.step_with(|inputs| inputs.sensor.wrench[0] += noise_n)
            .trace
    };
    let last = (1..2500).fold(step(), |_, _| step());
    (last.law_velocity[0] - last.model_velocity[0]) * 1e3
}

/// The sums rectify noise, |dv| being positive; the threshold mends that while it exceeds about
/// four standard deviations of F Ts/m.
#[test]
fn noise_is_rectified_unless_gated() {
    let ungated = scenario_s(5.0);
    for (noise_n, known) in [(0.2, -2.4), (1.0, -11.7), (2.0, -22.9)] {
        let found = drift(&ungated, noise_n);
        assert!(
            (found / known - 1.0).abs() < 0.1,
            "{noise_n} N: {found} mm/s"
        );
    }
    let gated = cured(ungated);
    assert!(drift(&gated, 0.2).abs() < 0.01);
    assert!(drift(&gated, 1.0).abs() < 1.5);
}

/// A law per component is not frame-invariant: the same bounce against a turned wall.
#[test]
fn an_oblique_normal_changes_the_restitution() {
    let known_at_45_deg = [
        (1.0, 1.10),
        (2.0, 1.08),
        (5.0, 0.86),
        (10.0, 0.85),
        (15.0, 0.99),
    ];
    for (speed, known) in known_at_45_deg {
        let e = scenario_s(speed)
            .turned(45_f64.to_radians())
            .restitution::<f64>();
        assert!((e - known).abs() < 0.01, "{speed} mm/s: {e}, known {known}");
    }
    let straight = scenario_s(15.0).restitution::<f64>();
    let oblique = scenario_s(15.0)
        .turned(45_f64.to_radians())
        .restitution::<f64>();
    assert!(straight - oblique > 0.1, "{straight} {oblique}");
}

/// The rig is as symmetric as the law: the mirrored bounce, bit for bit.
#[test]
fn mirrored_bounce() {
    let case = scenario_s(5.0);
    let mut mirrored = case.clone();
    mirrored.settings.body_k.velocity_m_s[0] *= -1.0;
    (mirrored.left_m, mirrored.right_m) = (case.right_m, case.left_m);
    let (mut rig, mut other) = (case.start::<f64>(), mirrored.start::<f64>());
    for _ in 0..250 {
        let (a, b) = (rig.step(), other.step());
        assert_eq!(a.output.correction[0], -b.output.correction[0]);
        assert_eq!(a.trace.law_velocity[0], -b.trace.law_velocity[0]);
        assert_eq!(
            a.trace.law_parts.map(|p| p[0]),
            b.trace.law_parts.map(|p| -p[0])
        );
    }
}
