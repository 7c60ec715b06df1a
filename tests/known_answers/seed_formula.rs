//! The paper's delay law (section 4.2) against its formulas, written down a second time.

use proptest::prelude::*;
use softdock_control::delay::seed::{Seed, SeedCoefficients, SeedSettings};
use softdock_control::frames::Twist;
use softdock_control::scalar::{Fixed, Scalar};

const CYCLE_S: f64 = 0.004;

/// The formulas as printed, in mm/s, with the printed coefficients: v_cmd for each v_model.
fn printed(v: &[f64], threshold: f64, saturation: f64, low_pass_hz: f64) -> Vec<f64> {
    let gain = 1.0 - (-core::f64::consts::TAU * low_pass_hz * CYCLE_S).exp();
    let c = [2.57, -16.81, 146.0, 1337.0];
    let (mut filtered, mut last, mut sums, mut back) = (v[0], v[0], [0.0; 4], 0.0);
    let mut command = |v: &f64| {
        let dv = (gain * (v - filtered)).clamp(-saturation, saturation);
        filtered += gain * (v - filtered);
        let s_v = if filtered == 0.0 {
            0.0
        } else {
            -filtered.signum()
        };
        let s_dv = if dv.abs() < threshold {
            0.0
        } else {
            dv.signum()
        };
        (0..4).for_each(|i| sums[i] += s_v * dv.abs().powi(i as i32 + 1));
        back += v - last;
        let polynomial: f64 = (0..4).map(|i| c[i] * sums[i]).sum();
        last =
            v + 0.1 * s_dv + 2.0 * s_v * dv.abs() + polynomial + 0.005 * (v - last) + 5e-6 * back;
        last
    };
    v.iter().map(&mut command).collect()
}

fn along_x<S: Scalar>(speed_mm_s: f64) -> Twist<S> {
    Twist::of(&[speed_mm_s * 1e-3, 0.0, 0.0, 0.0, 0.0, 0.0])
}

fn commands<S: Scalar>(settings: &SeedSettings, v: &[f64]) -> Vec<f64> {
    let mut law = Seed::<S>::new(settings, CYCLE_S);
    let step = |v: &f64| law.step(&along_x(*v)).command.linear.x.get() * 1e3;
    v.iter().map(step).collect()
}

fn agrees<S: Scalar>(
    settings: &SeedSettings,
    v: &[f64],
    tolerance: f64,
) -> Result<(), TestCaseError> {
    let known = printed(
        v,
        settings.threshold_mm_s,
        settings.saturation_mm_s,
        settings.low_pass_hz,
    );
    for (n, (a, b)) in commands::<S>(settings, v).iter().zip(known).enumerate() {
        prop_assert!((a - b).abs() < tolerance, "{n}: {a}, known {b}");
    }
    Ok(())
}

/// Seven parts and the model add up to the command, on all six axes.
fn parts_add_up<S: Scalar>(v: &[f64], tolerance_mm_s: f64) -> Result<(), TestCaseError> {
    let mut law = Seed::<S>::new(&SeedSettings::default(), CYCLE_S);
    for (n, speed) in v.iter().enumerate() {
        let model = Twist::<S>::of(&core::array::from_fn(|i| speed * 1e-3 * (i as f64 - 2.4)));
        let out = law.step(&model);
        let sum = out.parts.iter().fold(model, |sum, part| sum + *part);
        let error = (sum - out.command).get().map(|e| e.abs() * 1e3);
        prop_assert!(error.iter().all(|e| *e < tolerance_mm_s), "{n}: {error:?}");
    }
    Ok(())
}

/// A random walk of the model's velocity, mm/s: contacts and free flight of all kinds.
fn any_velocity() -> impl Strategy<Value = Vec<f64>> {
    (-20.0..20.0f64, prop::collection::vec(-0.4..0.4f64, 1..200)).prop_map(|(start, steps)| {
        let sum = |v: &mut f64, step| {
            *v += step;
            Some(*v)
        };
        steps.into_iter().scan(start, sum).collect()
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// Preprocessed as by default. f64: rounding of sums of some 10 mm/s. f32: a velocity of 50
    /// mm/s is good to 4e-6, which the polynomial passes on with a slope of up to 35, 200 times,
    /// in both directions. Fixed: 2e-7 mm/s after scaling, likewise.
    ///
    /// The b0 term jumps where dv crosses the threshold, which only f64 hits exactly: the other
    /// two run with a threshold that is never reached.
    #[test]
    fn formulas_as_printed(v in any_velocity()) {
        let settings = SeedSettings::default();
        agrees::<f64>(&settings, &v, 1e-9)?;
        let smooth = SeedSettings { threshold_mm_s: 1.0, ..settings };
        agrees::<f32>(&smooth, &v, 2e-3)?;
        agrees::<Fixed>(&smooth, &v, 5e-4)?;
    }

    /// Without any preprocessing: every other reading of "a low-pass and saturation" starts here.
    #[test]
    fn formulas_without_preprocessing(v in any_velocity()) {
        let raw = SeedSettings {
            threshold_mm_s: 0.01,
            saturation_mm_s: 10.0,
            low_pass_hz: 1000.0,
            ..SeedSettings::default()
        };
        // Slower changes: the raw sums of fast ones run away into their saturation.
        let slow: Vec<f64> = v.iter().map(|v| v * 0.3).collect();
        agrees::<f64>(&raw, &slow, 1e-9)?;
    }

    /// The command is the model and the seven parts of Fig. 9. f32 and fixed: the parts are
    /// divided by 1000 one by one.
    #[test]
    fn seven_parts_are_the_difference(v in any_velocity()) {
        parts_add_up::<f64>(&v, 1e-12)?;
        parts_add_up::<f32>(&v, 1e-3)?;
        parts_add_up::<Fixed>(&v, 1e-5)?;
    }

    /// The law knows no direction: mirrored input gives mirrored output, bit for bit. Fixed point
    /// rounds downwards, which is not symmetric, and may fall on the other side of a threshold.
    #[test]
    fn mirrored(v in any_velocity()) {
        let settings = SeedSettings::default();
        let mirror: Vec<f64> = v.iter().map(|v| -v).collect();
        let negated = |v: Vec<f64>| v.into_iter().map(|v| -v).collect::<Vec<_>>();
        prop_assert_eq!(
            commands::<f64>(&settings, &v), negated(commands::<f64>(&settings, &mirror)));
        prop_assert_eq!(
            commands::<f32>(&settings, &v), negated(commands::<f32>(&settings, &mirror)));
    }
}

/// Each coefficient acts alone as its formula says.
#[test]
fn each_term_alone() {
    let only = |change: fn(&mut SeedCoefficients)| {
        let mut settings = SeedSettings {
            threshold_mm_s: 0.05,
            saturation_mm_s: 0.3,
            low_pass_hz: 1000.0,
            ..SeedSettings::default()
        };
        settings.translation = SeedCoefficients {
            b0: 0.0,
            b1: 0.0,
            c: [0.0; 4],
            k_p: 0.0,
            k_i: 0.0,
        };
        change(&mut settings.translation);
        // A brake from 2 mm/s: dv is 0, −0.1, −0.3 (of −0.5) and −0.04 (below the threshold).
        commands::<f64>(&settings, &[2.0, 1.9, 1.4, 1.36])
    };
    let check = |found: Vec<f64>, known: [f64; 4]| {
        for (a, b) in found.iter().zip(known) {
            assert!((a - b).abs() < 1e-9, "{found:?} {known:?}");
        }
    };
    check(only(|c| c.b0 = 1.0), [2.0, 0.9, 0.4, 1.36]);
    check(only(|c| c.b1 = 1.0), [2.0, 1.8, 1.1, 1.32]);
    check(only(|c| c.c[0] = 1.0), [2.0, 1.8, 1.0, 0.92]);
    check(only(|c| c.c[1] = 1.0), [2.0, 1.89, 1.3, 1.2584]);
    check(only(|c| c.k_p = 0.1), [2.0, 1.89, 1.351, 1.3609]);
    check(only(|c| c.k_i = 0.1), [2.0, 1.89, 1.341, 1.3029]);
}
