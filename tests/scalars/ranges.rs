//! The edges of the declared ranges: the lightest spacecraft under the largest load with the widest
//! limits, and a measured pose that jumps. Everything saturates; nothing wraps or becomes NaN.

use softdock_app::record::CycleRecord;
use softdock_control::delay::LawName;
use softdock_control::dynamics::{BodyState, ObservationFrames, TwoBody, TwoBodyState};
use softdock_control::frames::{Twist, Wrench, pose};
use softdock_control::limits::LimitFlags;
use softdock_control::scalar::Scalar;
use softdock_control::settings::{BodySettings, DynamicCompensation, FrameSettings, Settings};
use softdock_tests::bench::sane;
use softdock_tests::driver::{cruising, idle};
use softdock_tests::in_three_scalars;

fn lightest(place_m: f64) -> BodySettings {
    BodySettings {
        mass_kg: 0.1,
        inertia_kg_m2: [[1e-3, 0.0, 0.0], [0.0, 1e-3, 0.0], [0.0, 0.0, 9.0]],
        position_m: [place_m; 3],
        velocity_m_s: [0.01, 0.0, 0.0],
        ..BodySettings::default()
    }
}

fn widest() -> Settings {
    let mut settings = Settings::default();
    settings.delay.law = LawName::None;
    (settings.body_k, settings.body_q) = (lightest(1e3), lightest(-1e3));
    let limits = &mut settings.limits;
    (limits.force_n, limits.torque_n_m) = (1e5, 1e5);
    (limits.step_m, limits.step_rad) = (0.02, 0.05);
    (limits.speed_m_s, limits.speed_rad_s) = (5.0, 5.0);
    (limits.acceleration_m_s2, limits.acceleration_rad_s2) = (1e3, 1e3);
    (limits.box_m, limits.box_rad) = ([5.0; 3], 1.5);
    limits.clamp_fault_cycles = 10_000;
    settings.delay.law = LawName::Seed;
    settings.delay.seed.translation.c = [2e4; 4];
    (
        settings.delay.seed.translation.k_p,
        settings.delay.seed.translation.k_i,
    ) = (100.0, 100.0);
    settings.delay.seed.saturation_mm_s = 10.0;
    settings.sensor.frozen_after_cycles = 0;
    settings
}

fn assert_sane(record: &CycleRecord, settings: &Settings) {
    sane(&record.trace).unwrap();
    let [x, y, z, ..] = record.output.correction.map(|v| v as f64 * 1e-7);
    let step = (x * x + y * y + z * z).sqrt();
    assert!(step <= settings.limits.step_m * 1.001 + 2e-7, "{step} m");
}

/// Loads just below the largest overload limit, kept and reversed, for four seconds each.
fn a_model_that_runs_away_saturates<S: Scalar>() {
    let settings = widest();
    for sign in [1.0, -1.0] {
        let mut driver = cruising::<S>(&settings);
        driver.inputs.sensor.wrench = [5e4 * sign, 5e4, -5e4, 5e4, -5e4 * sign, 5e4];
        for _ in 0..1000 {
            let record = driver.step();
            assert_sane(&record, &settings);
            assert_eq!(record.trace.fault, None);
            assert!(record.trace.limits.has(LimitFlags::SPEED), "no flag");
        }
        assert!(driver.step().trace.limits.has(LimitFlags::MODEL), "no flag");
        driver.inputs.sensor.wrench = driver.inputs.sensor.wrench.map(|v| -v);
        for _ in 0..1000 {
            assert_sane(&driver.step(), &settings);
        }
    }
}

/// A robot that jumps to and fro between the ends of the world, with the heaviest tool.
fn a_pose_that_jumps<S: Scalar>() {
    let mut settings = widest();
    settings.sensor.dynamic_compensation = DynamicCompensation::LoadReaction;
    settings.sensor.tool_mass_kg = 2000.0;
    settings.sensor.tool_com_m = [10.0; 3];
    settings.sensor.position_m = [10.0; 3];
    settings.sensor.tool_inertia_kg_m2 = [[2000.0, 0.0, 0.0], [0.0, 1000.0, 0.0], [0.0; 3]];
    settings.sensor.acceleration_bandwidth_hz = 60.0;
    settings.robot.cycle_s = 0.001;
    let mut driver = idle::<S>(&settings);
    for n in 0..1000 {
        let sign = if n % 7 < 3 { 1.0 } else { -1.0 };
        let angle = 10.0 * sign;
        driver.inputs.robot.pose = Some([1e3 * sign, -1e3, 1e3, angle, -angle, 3.0 * sign]);
        assert_sane(&driver.step(), &settings);
    }
}

/// Two spacecraft at the far ends of the model's ranges, farther than any run leads within a test.
fn the_far_ends_of_the_model<S: Scalar>() {
    let bodies = TwoBody::<S>::new(&lightest(0.0), &lightest(0.0), 0.02);
    let frames = ObservationFrames::<S>::new(&FrameSettings {
        j_position_m: [1e3; 3],
        p_position_m: [-1e3, 1e3, -1e3],
        ..FrameSettings::default()
    });
    let far = |sign: f64| BodyState {
        c_from_body: pose(
            &[sign * 1e6, -sign * 1e6, sign * 1e6],
            &[0.5, 0.5, -0.5, sign],
        ),
        velocity: Twist::<S>::of(&[sign * 100.0, 100.0, -100.0, 20.0, -20.0, sign * 20.0]),
    };
    let mut state = TwoBodyState {
        k: far(1.0),
        q: far(-1.0),
    };
    // 1e5 N and 1e5 N·m, the widest limits of the load.
    let part = 1e5 / 3.0_f64.sqrt();
    for n in 0..500 {
        let sign = if n % 7 < 3 { part } else { -part };
        let wrench = Wrench::of(&[part, -part, sign, part, sign, -part]);
        state = bodies.step(&state, &wrench).0;
        assert!(state.at_its_limits());
        let seen = frames.observe(&state).relative_velocity.get();
        // 35 rad/s at the end of the longest lever, 7 km, and of the two offsets, 1.7 km each.
        let fastest = 4e5;
        assert!(seen[..3].iter().all(|v| v.abs() <= fastest), "{seen:?}");
        for body in [&state.k, &state.q] {
            let at = body.c_from_body.translation.vector;
            assert!(at.amax().get() <= 1e6, "{at:?}");
        }
    }
}

in_three_scalars! {
    far_ends: the_far_ends_of_the_model,
    runaway: a_model_that_runs_away_saturates,
    jumps: a_pose_that_jumps
}
