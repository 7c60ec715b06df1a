//! What is said of recordings that are not fit to be compared.

use softdock_analysis::diagnose::diagnose;
use softdock_analysis::import::checks::{CheckError, Context, check, filter_needed, signs};
use softdock_app::record::CycleRecord;
use softdock_io::recording::Recording;
use softdock_physics::model::{Axis, Model};
use softdock_statistics::RandomStream;
use std::f64::consts::TAU;

const TS: f64 = 0.004;

/// A mass on a spring; position, velocity and force belong together.
fn recording(rows: usize, change: impl Fn(usize, &mut CycleRecord)) -> Recording {
    let cycles = (0..rows).map(|n| {
        let mut cycle = CycleRecord::default();
        let time_s = n as f64 * TS;
        let (sin, cos) = (2.0 * time_s).sin_cos();
        cycle.trace.cycle = n as u64;
        cycle.trace.time_s = time_s;
        cycle.trace.pose = [0.1 * sin, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0];
        cycle.trace.executed_velocity[0] = 0.2 * cos;
        cycle.inputs.sensor.wrench[0] = -40.0 * sin;
        change(n, &mut cycle);
        cycle
    });
    Recording {
        cycles: cycles.collect(),
        ..Recording::default()
    }
}

fn context(model: Option<&Model>) -> Context<'_> {
    Context {
        name: "log",
        sample_time_s: Some(TS),
        fewest_rows: None,
        imports: true,
        model,
    }
}

fn refused(recording: &Recording) -> CheckError {
    check(recording, &context(None)).unwrap_err()
}

#[test]
fn a_good_recording_is_left_in_peace() {
    let nothing: [&str; 0] = [];
    assert_eq!(
        check(&recording(1000, |_, _| ()), &context(None)).unwrap(),
        nothing
    );
    // A sensor that is not there is no fault either.
    let blind = recording(1000, |_, c| c.inputs.sensor.wrench = [f64::NAN; 6]);
    assert_eq!(check(&blind, &context(None)).unwrap(), nothing);
}

#[test]
fn errors_carry_their_numbers() {
    let name = || "log".to_owned();
    assert_eq!(
        refused(&recording(99, |_, _| ())),
        CheckError::TooShort {
            name: name(),
            expected: 100,
            received: 99,
            remedy: "record for longer"
        }
    );
    let mut model = Model::default();
    model.sensor.at_rest = true;
    assert_eq!(
        check(&recording(11, |_, _| ()), &context(Some(&model))).unwrap_err(),
        CheckError::TooShort {
            name: name(),
            expected: 12,
            received: 11,
            remedy: "take more poses, or, with `test_every` of [split], keep fewer of them apart"
        }
    );
    assert!(check(&recording(12, |_, _| ()), &context(Some(&model))).is_ok());
    let repeated = refused(&recording(200, |n, c| {
        if n == 50 {
            c.trace.time_s -= TS;
        }
    }));
    assert!(
        matches!(repeated, CheckError::TimeNotRising { row: 51, .. }),
        "{repeated}"
    );
    let slower = refused(&recording(200, |_, c| c.trace.time_s *= 2.0));
    assert!(
        matches!(slower, CheckError::SampleTime { expected_s: TS, received_s, .. }
            if (received_s - 2.0 * TS).abs() < 1e-9),
        "{slower}"
    );
}

#[test]
fn of_a_log_in_which_nothing_changes_its_rows_are_said_and_what_is_not_measured() {
    let still = |sent: f64| {
        refused(&recording(200, |n, c| {
            *c = CycleRecord::default();
            c.trace.time_s = n as f64 * TS;
            c.trace.sent_velocity[3] = sent * n as f64;
        }))
    };
    let said = still(0.0).to_string();
    assert!(
        said.contains("in its 200 rows, 0 s to 0.796 s") && said.contains("take other rows"),
        "{said}"
    );
    let said = still(0.1).to_string();
    assert!(
        said.contains("only what was sent does") && said.contains("[executed_velocity]"),
        "{said}"
    );
}

#[test]
fn what_looks_wrong_is_told() {
    type Change = fn(usize, &mut CycleRecord);
    let cases: [(Change, &str); 10] = [
        (
            // With the last digit of a sensor, which no integral has.
            |n, c| c.trace.pose[0] += 99.0 + 1e-6 * (n % 2) as f64,
            "in mm? Say `unit = \"mm\"` for them in [position]",
        ),
        (
            |_, c| c.trace.executed_velocity[0] *= 2.0,
            "position x changes 0.5000 times",
        ),
        (|_, c| c.trace.executed_velocity[0] *= -1.0, "wrong sign"),
        (
            |_, c| c.trace.executed_velocity[3] = 90.0,
            "Say `unit = \"deg/s\"`, or \"rpm\", for it in [executed_velocity]",
        ),
        (
            |n, c| {
                c.trace.time_s = n as f64;
                c.trace.executed_velocity[0] *= TS;
            },
            "in milliseconds? Say `unit = \"ms\"` for `column` in [time]",
        ),
        (|_, c| c.inputs.sensor.wrench[0] *= 1e-6, "is it in kN"),
        (
            |_, c| c.inputs.sensor.wrench[0] *= 1e4,
            "counts of the sensor",
        ),
        (
            |_, c| c.inputs.sensor.wrench[0] = 1e3 * c.trace.pose[0],
            "force fx holds the numbers of position x",
        ),
        (
            |_, c| c.trace.pose[4] = 0.1,
            "row 1: the quaternion has the length 1.00",
        ),
        (
            |n, c| c.trace.time_s += if n >= 500 { 0.5 } else { 0.0 },
            "row 501: 0.5",
        ),
    ];
    for (change, expected) in cases {
        let unpromised = Context {
            sample_time_s: None,
            ..context(None)
        };
        let warnings = check(&recording(1000, change), &unpromised).unwrap();
        assert!(
            warnings
                .iter()
                .any(|w| w.starts_with("log") && w.contains(expected)),
            "expected {expected} in {warnings:?}"
        );
    }
}

/// Who reads a log back has said what its units are.
#[test]
fn units_are_asked_for_once() {
    let fast = recording(1000, |_, c| c.inputs.sensor.wrench[0] *= 1e4);
    let read_back = Context {
        imports: false,
        ..context(None)
    };
    assert_eq!(check(&fast, &context(None)).unwrap().len(), 1);
    assert!(check(&fast, &read_back).unwrap().is_empty());
}

/// A test part behind the end of a motion, of which a filter leaves next to nothing.
#[test]
fn what_a_filter_leaves_of_a_motion_is_nothing() {
    let still = recording(1000, |n, c| {
        c.trace.pose = [0.27, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0];
        c.trace.executed_velocity = [0.0; 6];
        c.inputs.sensor.wrench[0] = 4e-69 * n as f64;
    });
    let refused = refused(&still);
    let expected = matches!(refused, CheckError::NothingChanges { .. });
    assert!(expected, "{refused}");
}

#[test]
fn position_and_velocity_in_other_units_are_refused() {
    for (scale, expected) in [
        (1e3, "is the position in mm?"),
        (1e-3, "is the velocity in mm/s?"),
        (57.3, "`scale` 57.3"),
        (-57.3, "wrong sign"),
    ] {
        let error = refused(&recording(1000, |_, c| c.trace.pose[0] *= scale));
        let CheckError::Units { ratio, hint, .. } = &error else {
            panic!("{error}");
        };
        assert!((ratio / scale - 1.0).abs() < 1e-3, "{ratio}");
        assert!(hint.contains(expected), "{error}");
    }
}

/// An axis of which only the position was measured, beside one of which the velocity was, too.
#[test]
fn a_velocity_that_was_not_measured_is_in_no_other_unit() {
    let shakes = |n: usize, c: &mut CycleRecord| c.trace.pose[1] = 1e-6 * (7.0 * n as f64).sin();
    check(&recording(1000, shakes), &context(None)).unwrap();
}

#[test]
fn two_rates_in_one_file_are_told() {
    let mut recording = recording(1000, |_, _| ());
    for (n, cycle) in recording.cycles.iter_mut().enumerate().skip(700) {
        cycle.trace.time_s += (n - 700) as f64 * TS;
    }
    let mut context = context(None);
    context.sample_time_s = None;
    let warnings = check(&recording, &context).unwrap();
    assert!(
        warnings
            .iter()
            .any(|w| w.contains("two sample times in one file")),
        "{warnings:?}"
    );
}

/// An axis on a path of two frequencies: mass 10 kg, friction 20 N·s/m and 3 N, noise of 0.2 N.
fn axis(scale: f64) -> Recording {
    let mut random = RandomStream::new(1, 0);
    let mut recording = recording(5000, |_, _| ());
    for (n, cycle) in recording.cycles.iter_mut().enumerate() {
        let time_s = n as f64 * TS;
        let part = |size: f64, omega: f64| {
            let (sin, cos) = (omega * time_s).sin_cos();
            [size * sin, size * omega * cos, -size * omega * omega * sin]
        };
        let (slow, fast) = (part(0.05, 2.0), part(0.01, 7.0));
        let [x, v, a]: [f64; 3] = std::array::from_fn(|i| slow[i] + fast[i]);
        cycle.trace.pose[0] = x;
        cycle.trace.executed_velocity[0] = v;
        let load = -(10.0 * a + 20.0 * v + 3.0 * v.signum()) + 0.2 * random.normal();
        cycle.inputs.sensor.wrench[0] = scale * load;
    }
    recording
}

/// Its mass alone.
fn moved() -> Model {
    let mut model = Model::default();
    model.rig.active_axes = vec![Axis::X];
    model.tool.mass_kg = 10.0;
    model.tool.dynamic_compensation = true;
    model
}

#[test]
fn a_force_of_the_wrong_sign_or_size_is_told_with_the_line_to_change() {
    let model = moved();
    let told = |scale: f64| {
        let log = axis(scale);
        let mut told = check(&log, &context(Some(&model))).unwrap();
        told.extend(signs(&[("log", &log)], Some(&model)));
        told
    };
    assert_eq!(told(1.0), Vec::<String>::new());
    let sign = "force fx drives the motion instead of resisting it: mass and friction would be negative \
                (p < 1e-6).";
    for scale in [-1.0, -2.0] {
        let told = told(scale);
        assert!(told.len() == 1 && told[0].contains(sign), "{told:?}");
        assert!(told[0].contains("scale = -1.0"), "{told:?}");
    }
    for (scale, factor) in [(2.0, "is 2.00 times what"), (0.1, "is 0.100 times what")] {
        let told = told(scale);
        assert!(told.len() == 1 && told[0].contains(factor), "{told:?}");
    }
    let mut constant = axis(1.0);
    let all = constant.cycles.iter_mut();
    all.for_each(|c| c.inputs.sensor.wrench[0] = -0.02);
    let told = check(&constant, &context(Some(&model))).unwrap();
    assert!(
        told.len() == 1 && told[0].contains("force fx is -0.0200 N in every row"),
        "{told:?}"
    );
    // A closed loop moves with the force: nothing is concluded.
    let mut closed = axis(-1.0);
    closed.cycles[0].trace.mode = softdock_control::modes::Mode::Running;
    assert_eq!(
        signs(&[("closed", &closed)], Some(&model)),
        Vec::<String>::new()
    );
}

/// A hand that pushes in one of two logs does not make the sign of the other wrong.
#[test]
fn logs_that_contradict_each_other_about_a_sign_are_told_so() {
    let (right, pushed) = (axis(1.0), axis(-1.0));
    let told = signs(&[("a.csv", &right), ("b.csv", &pushed)], None);
    let said = "force fx resists the motion in a.csv; it drives it in b.csv";
    assert!(told.len() == 1 && told[0].starts_with(said), "{told:?}");
    assert!(!told[0].contains("scale"), "{told:?}");
}

/// What is named with a force of the wrong sign is nothing to begin with; of one log among several the warning says it.
#[test]
fn a_doubtful_sign_is_said_before_the_answer() {
    let model = moved();
    let said = |scales: &[f64]| {
        let mut logs: Vec<Recording> = scales.iter().map(|scale| axis(*scale)).collect();
        logs.iter_mut().for_each(|log| log.cycles.truncate(1500));
        let logs: Vec<&Recording> = logs.iter().collect();
        let report = diagnose(&model, &logs, &[], &|_, _| {}).unwrap();
        report.diagnosis.sentence
    };
    let first =
        "First see to the sign of force fx, which drives the motion instead of resisting it. ";
    assert!(said(&[-1.0]).starts_with(first));
    for right in [&[1.0][..], &[-1.0, 1.0]] {
        assert!(!said(right).contains("sign of"), "{right:?}");
    }
}

/// The same axis by an encoder that is off by 5 µm, the velocity from its positions.
fn by_encoder() -> Recording {
    let mut random = RandomStream::new(1, 1);
    let mut recording = axis(1.0);
    let mut last = None;
    for cycle in &mut recording.cycles {
        let x = cycle.trace.pose[0] + 5e-6 * random.normal();
        cycle.trace.pose[0] = x;
        cycle.trace.executed_velocity[0] = (x - last.replace(x).unwrap_or(x)) / TS;
    }
    recording
}

/// The motion ends at 1.1 Hz and has 0.37 m/s² rms, the noise has 1.14: nine tenths of the mean square.
#[test]
fn an_acceleration_that_is_noise_is_told_with_the_cutoff_that_keeps_it_down() {
    let (quiet, mut noisy) = (axis(1.0), by_encoder());
    assert_eq!(filter_needed(&[("log", &quiet)], None), None);
    let cutoff_hz = |log: &Recording| {
        let told = filter_needed(&[("quiet", &quiet), ("log", log)], None).unwrap();
        let share: f64 = between(&told, "log: ", " %").parse().unwrap();
        assert!((85.0..95.0).contains(&share), "{told}");
        between(&told, "`cutoff_hz = ", "`").parse::<f64>().unwrap()
    };
    let by_force = cutoff_hz(&noisy);
    assert!((1.1..2.2).contains(&by_force), "{by_force}");
    // An axis that only shakes has no say, whatever its noise is like.
    let mut random = RandomStream::new(1, 2);
    for (n, cycle) in noisy.cycles.iter_mut().enumerate() {
        let slow = 1e-5 * (0.5 * n as f64 * TS).sin();
        cycle.trace.executed_velocity[1] = slow + 1e-4 * random.normal();
    }
    assert_eq!(cutoff_hz(&noisy), by_force);
    let model = moved();
    let [beginning, of_quiet] = [&noisy, &quiet].map(|log| Recording {
        cycles: log.cycles[..1500].to_vec(),
        ..log.clone()
    });
    let first = |logs: &[&Recording]| {
        let report = diagnose(&model, logs, &[], &|_, _| {}).unwrap();
        report
            .diagnosis
            .sentence
            .starts_with("First filter the log: ")
    };
    assert!(first(&[&beginning]) && !first(&[&beginning, &of_quiet]));
    // Without a force the spectrum tells.
    let cycles = noisy.cycles.iter_mut();
    cycles.for_each(|cycle| cycle.inputs.sensor.wrench = [f64::NAN; 6]);
    let by_spectrum = cutoff_hz(&noisy);
    assert!((1.1..2.2).contains(&by_spectrum), "{by_spectrum}");
}

/// The part of a text between two others.
fn between<'a>(text: &'a str, before: &str, behind: &str) -> &'a str {
    let (_, rest) = text.split_once(before).unwrap();
    rest.split_once(behind).unwrap().0
}

#[test]
fn a_robot_that_moves_before_it_is_told_to_is_told() {
    let at = |n: f64| (2.0 * n * TS).cos() + 0.3 * (7.0 * n * TS).sin();
    let position = |n: f64| 0.5 * (2.0 * n * TS).sin() - 0.3 / 7.0 * (7.0 * n * TS).cos();
    let log = |lag: f64| {
        recording(2000, |n, c| {
            c.trace.pose[0] = position(n as f64);
            c.trace.executed_velocity[0] = at(n as f64);
            c.trace.sent_velocity[0] = at(n as f64 + lag);
        })
    };
    let nothing: [&str; 0] = [];
    assert_eq!(check(&log(8.0), &context(None)).unwrap(), nothing);
    let told = check(&log(-8.0), &context(None)).unwrap().concat();
    assert!(told.contains("ahead of the sent one by 32.0 ms"), "{told}");
}

/// A shaft that turns alone; `of_velocity`: what its rate is multiplied by, as in another unit.
fn shaft(rate_rad_s: f64, of_velocity: f64) -> Recording {
    recording(1000, |n, c| {
        let turn = 0.5 * rate_rad_s * n as f64 * TS + 0.1 * (n as f64 * TS).sin();
        let rate = rate_rad_s + 0.1 * (n as f64 * TS).cos();
        c.trace.pose = [0.0, 0.0, 0.0, turn.cos(), turn.sin(), 0.0, 0.0];
        c.trace.executed_velocity = [0.0, 0.0, 0.0, rate * of_velocity, 0.0, 0.0];
        c.inputs.sensor.wrench = [0.0, 0.0, 0.0, 1.0 + 1e-3 * (n % 7) as f64, 0.0, 0.0];
    })
}

#[test]
fn an_angular_velocity_in_degrees_is_told_by_the_angle() {
    let told = |rate, factor| check(&shaft(rate, factor), &context(None));
    let nothing: [&str; 0] = [];
    assert_eq!(told(1.0, 1.0).unwrap(), nothing);
    let refused = told(1.0, 1.0_f64.to_degrees()).unwrap_err().to_string();
    assert!(refused.contains("`unit = \"deg/s\"` for rx"), "{refused}");
    let refused = told(1.0, 1.0_f64.to_radians()).unwrap_err().to_string();
    assert!(refused.contains("`unit = \"deg\"` for rx"), "{refused}");
    for (factor, unit) in [(60.0 / TAU, "rpm"), (1.0 / TAU, "rev/s"), (TAU, "turn")] {
        let told = told(1.0, factor).unwrap().concat();
        assert!(
            told.contains(&format!("`unit = \"{unit}\"` for rx")),
            "{told}"
        );
    }
    // A motor's shaft turns faster than any spacecraft.
    assert_eq!(told(250.0, 1.0).unwrap(), nothing);
    let told = told(1200.0, 1.0).unwrap().concat();
    assert!(told.contains("degrees per second"), "{told}");
}
