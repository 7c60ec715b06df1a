//! When the rows of an imported table were: irregular stamps, gaps, late rows; and what follows for a model to start from.

use super::tables::{imported, near, table};
use softdock_analysis::diagnose::{Verdict, diagnose};
use softdock_analysis::import::starter::{Filtered, Told, starter};
use softdock_analysis::import::summary::Summary;
use softdock_physics::model::Model;
use softdock_physics::model::prediction::signals::{Signals, VelocityMeaning};
use softdock_statistics::RandomStream;
use std::f64::consts::PI;

/// Stamps of a computer that samples when it has time: 2 to 6 ms apart, never the same.
fn irregular(header: &str, rows: usize, row: impl Fn(f64) -> String) -> String {
    let mut time_s = 0.0;
    let mut random = RandomStream::new(1, 0);
    let mut text = format!("{header}\n");
    for _ in 0..rows {
        text.push_str(&format!("{time_s},{}\n", row(time_s)));
        time_s += 0.002 + 0.004 * random.uniform();
    }
    text
}

const STAMPED: &str = r#"
    [files]
    train = "log.csv"
    [time]
    column = "t"
    [position]
    x = "p"
    [executed_velocity]
    x = "v"
"#;

#[test]
fn irregular_stamps_are_refused_or_resampled_and_the_loss_is_said() {
    let angle = |t: f64| 2.0 * PI * t;
    let motion = |t: f64| {
        // What is faster than half of 100 Hz cannot be kept.
        let hum = 0.1 * (60.0 * angle(t)).sin();
        format!("{},{}", angle(t).sin(), 2.0 * PI * angle(t).cos() + hum)
    };
    let files = [("log.csv", irregular("t,p,v", 2000, motion))];
    let error = imported("mapping_irregular", STAMPED, &files).unwrap_err();
    for says in [
        "log.csv: the time stamps are irregular: the rows are 0.00200 to 0.00600 s apart",
        "[time]\n  resample_hz = 2",
    ] {
        assert!(error.contains(says), "`{says}`: {error}");
    }
    let mapping = STAMPED.replace("[time]", "[time]\nresample_hz = 100");
    let logs = imported("mapping_resampled", &mapping, &files).unwrap();
    for (n, cycle) in logs.train[0].cycles.iter().enumerate() {
        let at_s = n as f64 * 0.01;
        assert_eq!((cycle.trace.cycle, cycle.trace.time_s), (n as u64, at_s));
        let left = cycle.trace.pose[0] - angle(at_s).sin();
        // (2π 6 ms)³ of a cubic whose slopes are those of parabolas, over 16.
        assert!(left.abs() < 4e-6, "{n}: {left}");
    }
    let told = &logs.warnings[0];
    for says in [
        "log.csv: resampled from 2000 rows to ",
        " samples at 100.0 Hz: ",
        "largest step between rows is 0.00600 s",
        "faster than 50.0 Hz",
    ] {
        assert!(told.contains(says), "`{says}`: {told}");
    }
    let lost = told.split("executed velocity x ").nth(1).unwrap();
    let lost: f64 = lost.split(' ').next().unwrap().parse().unwrap();
    // Of an amplitude of 0.1: it and its alias, which are not alike.
    assert!((0.07..0.11).contains(&lost), "{told}");
    // Rows that are at the samples already need no word.
    let regular = table("t,p,v", 2000, |n| {
        format!("{},{}", 0.01 * n, motion(0.01 * n))
    });
    let logs = imported("mapping_resampled", &mapping, &[("log.csv", regular)]).unwrap();
    assert_eq!(logs.warnings, Vec::<String>::new());
}

/// A spindle at 200 rad/s: of samples 1/60 s apart it turns by more than half a turn, of such 1/70 s apart by less.
#[test]
fn samples_between_which_turns_are_lost_are_refused() {
    let log = table("t,angle,v", 2000, |n| {
        format!("{},{},200", 0.001 * n, 0.2 * n)
    });
    let mapping = |hz: u32| {
        let rotary = STAMPED
            .replace("[position]\n    x = \"p\"", "[orientation]\n    euler = \"xyz\"\n    rx = { column = \"angle\", unit = \"rad\" }")
            .replace("[executed_velocity]\n    x", "[executed_velocity]\n    rx");
        rotary.replace("[time]", &format!("[time]\nresample_hz = {hz}"))
    };
    let files = [("log.csv", log)];
    imported("spindle", &mapping(70), &files).unwrap();
    let refused = imported("spindle", &mapping(60), &files).unwrap_err();
    assert!(
        refused.contains("at 60.00 Hz it turns by up to 3.33 rad")
            && refused.contains("resample_hz of more than 63.66"),
        "{refused}"
    );
}

/// A swing of 50 rad, at the most 5 rad from row to row: of a column that counts turns samples between the rows are right; a column
/// that begins again after each turn, and a quaternion, do not tell them.
#[test]
fn turns_between_rows_are_counted_by_their_column_or_not_at_all() {
    let turns = |t: f64| 50.0 * t.sin() / (2.0 * PI);
    let log = |shown: fn(f64) -> f64| {
        let row = |n: f64| format!("{},{},{}", 0.1 * n, shown(turns(0.1 * n)), n.sin());
        [("log.csv", table("t,q,u", 200, row))]
    };
    let mapping = "files = { train = \"log.csv\" }\ntime = { column = \"t\" }\nwrench = { tx = \"u\" }\n\
                   orientation = { rx = { column = \"q\", unit = \"turn\" } }";
    let counted = log(|q| q);
    let refused = imported("turns_counted", mapping, &counted).unwrap_err();
    let says = [
        "at 10.00 Hz it turns by up to 5.00 rad",
        "resample_hz of more than 15.9",
    ];
    assert!(says.iter().all(|says| refused.contains(says)), "{refused}");
    let resampled = mapping.replace("\"t\"", "\"t\", resample_hz = 40");
    let logs = imported("turns_counted", &resampled, &counted).unwrap();
    let imported_at = Summary::of("log", &logs.train[0], &[]);
    let pose = &imported_at.channels[0];
    assert!((pose.low + 50.0).abs() < 0.1 && (pose.high - 50.0).abs() < 0.1);
    let wrapped = log(|q| q.rem_euclid(1.0));
    let refused = imported("turns_counted", &resampled, &wrapped).unwrap_err();
    assert!(refused.contains("a column that counts turns"), "{refused}");
}

/// 40 Hz of 0.01 rad on a turn of 3 rad/s, sampled at 60 Hz: the whole of it is lost, which halves of its quaternion do not say.
#[test]
fn what_a_resampled_angle_loses_is_said_of_the_angle() {
    let log = table("t,p,v", 1000, |n| {
        let t = 0.002 * n;
        format!("{t},{},0", 3.0 * t + 0.01 * (80.0 * PI * t).sin())
    });
    let mapping = STAMPED
        .replace("[position]\n    x", "[orientation]\n    rx")
        .replace("x = \"v\"", "derive = true")
        .replace("[time]", "[time]\nresample_hz = 60");
    let logs = imported("angle_lost", &mapping, &[("log.csv", log)]).unwrap();
    let told = &logs.warnings[0];
    let lost = told.split("orientation angle ").nth(1).unwrap();
    let lost: f64 = lost.split(" rad (").next().unwrap().parse().unwrap();
    assert!((0.005..0.012).contains(&lost), "{told}");
}

/// Every tenth row comes 2 µs after the one before instead of 5 ms: its stamp is a cycle too early, its value is not.
#[test]
fn rows_that_arrive_in_a_burst_have_no_slope_between_them() {
    let log = table("t,p,v", 1000, |n| {
        let late = if n % 10.0 == 9.0 { 0.004_998 } else { 0.0 };
        format!("{},{},0", 0.005 * n - late, (0.005 * n).sin())
    });
    let mapping = STAMPED
        .replace("x = \"v\"", "derive = true")
        .replace("[time]", "[time]\nresample_hz = 200");
    let logs = imported("burst", &mapping, &[("log.csv", log)]).unwrap();
    for cycle in &logs.train[0].cycles {
        let error = cycle.trace.pose[0] - cycle.trace.time_s.sin();
        assert!(error.abs() < 0.005, "{}: {error}", cycle.trace.time_s);
    }
}

#[test]
fn gaps_are_cut_or_bridged() {
    // Rows 100 to 109 are missing.
    let log = table("t,p,v", 300, |n| {
        let n = if n < 100.0 { n } else { n + 10.0 };
        format!("{},{},1", n * 0.01, n * 0.01)
    });
    let files = [("log.csv", log)];
    let derived = STAMPED.replace("x = \"v\"", "derive = true");
    for mapping in [
        derived.clone(),
        derived.replace("[time]", "[time]\ngaps = \"cut\""),
    ] {
        let logs = imported("mapping_cut", &mapping, &files).unwrap();
        let cycles = &logs.train[0].cycles;
        assert_eq!((cycles[99].trace.cycle, cycles[100].trace.cycle), (99, 110));
        assert!(near(&cycles[100].trace.executed_velocity[..1], &[1.0]));
        let told = logs.warnings.concat();
        assert!(
            told.contains("row 101: 0.100 s are missing") && told.contains("begins anew"),
            "{told}"
        );
    }
    let mapping = derived.replace("[time]", "[time]\ngaps = \"bridge\"");
    let logs = imported("mapping_bridge", &mapping, &files).unwrap();
    assert_eq!(logs.train[0].cycles.len(), 310);
    for (n, cycle) in logs.train[0].cycles.iter().enumerate() {
        assert!(near(&cycle.trace.pose[..1], &[n as f64 * 0.01]), "{n}");
    }
    let told = "bridged by straight lines: 10 of 310 rows are made up";
    assert!(logs.warnings.concat().contains(told), "{:?}", logs.warnings);
}

/// A loop that is late by six tenths of a step now and then has no missing rows.
#[test]
fn rows_that_are_late_are_not_called_missing() {
    let log = table("t,p,v", 400, |n| {
        let t = 0.01 * (n + 0.6 * (n / 40.0).floor());
        format!("{t},{},{}", t.sin(), t.cos())
    });
    let files = [("log.csv", log)];
    let late = "no whole numbers of steps, so that rows are late rather than missing";
    let told = imported("late_loop", STAMPED, &files).unwrap().warnings;
    assert!(told.concat().contains(late), "{told:?}");
    let resampled = STAMPED.replace("[time]", "[time]\nresample_hz = \"auto\"");
    let told = imported("late_loop", &resampled, &files).unwrap().warnings;
    assert!(!told.concat().contains("gap"), "{told:?}");
}

/// A computer that is late with one row in fifty, by six rows: no gap for a log that goes through a low-pass of 4 Hz, whose
/// fastest motion takes ten times as long, and one for a log that keeps all of its motion.
#[test]
fn a_late_row_is_no_gap_behind_a_low_pass() {
    let log = table("t,p,v", 2000, |n| {
        let t = 0.005 * (n + 6.0 * (n / 50.0).floor());
        format!("{t},{},{}", t.sin(), t.cos())
    });
    let files = [("log.csv", log)];
    let derived = STAMPED.replace("x = \"v\"", "derive = true");
    let resampled = derived.replace("[time]", "[time]\nresample_hz = 200");
    let filtered = format!("{resampled}\n[filter]\ncutoff_hz = 4.0\ntrim_s = 0.1");
    let logs = imported("late_rows", &filtered, &files).unwrap();
    let told = logs.warnings.concat();
    assert!(!told.contains("gap") && !told.contains("missing"), "{told}");
    let (rows, trimmed) = (2000 + 39 * 6, 2 * 20);
    assert_eq!(logs.train[0].cycles.len(), rows - trimmed);
    for cycle in &logs.train[0].cycles {
        let error = cycle.trace.pose[0] - cycle.trace.time_s.sin();
        assert!(error.abs() < 1e-3, "{}: {error}", cycle.trace.time_s);
    }
    // What is decimated after that is not lost at any end.
    let fast = filtered.replace("4.0", "40.0") + "\ndecimate = 2";
    let logs = imported("late_rows", &fast, &files).unwrap();
    let told = logs.warnings.concat();
    assert!(told.contains("39 gap(s) cut out"), "{told}");
    assert!(
        told.contains(
            "both ends of each of 40 stretches between gaps, which leaves 400 of 2000 rows"
        ),
        "{told}"
    );
}

/// Whatever is done with the ends of stretches: a stamp that repeats is no gap.
#[test]
fn stamps_that_repeat_are_refused_before_rows_are_trimmed() {
    let log = table("t,p,v", 400, |n| {
        let t = 0.01 * (n - (n / 60.0).floor());
        format!("{t},{},{}", t.sin(), t.cos())
    });
    let mapping = format!("{STAMPED}\n[filter]\ncutoff_hz = 10.0\ntrim_s = 0.1");
    for mapping in [
        mapping.clone(),
        mapping.replace("[time]", "[time]\nresample_hz = 100"),
    ] {
        let error = imported("stamps_repeat", &mapping, &[("log.csv", log.clone())]).unwrap_err();
        assert!(
            error.contains("log.csv, row 61: the time is 0.59"),
            "{error}"
        );
    }
}

/// Row 101 is written twice, and nothing else is wrong.
#[test]
fn of_rows_with_one_time_the_one_that_the_mapping_says_is_kept() {
    let log = table("t,p,v", 301, |n| {
        let (k, again) = if n > 100.0 { (n - 1.0, 0.5) } else { (n, 0.0) };
        let again = if n == 101.0 { again } else { 0.0 };
        format!("{},{},1", 0.01 * k, 0.01 * k + again)
    });
    let files = [("log.csv", log)];
    let error = imported("duplicates", STAMPED, &files).unwrap_err();
    assert!(error.contains("duplicates = \"keep_first\""), "{error}");
    // Behind a row that is left out, rows have the numbers of the file; none is there twice where the time runs back.
    let back = files[0].1.replace("\n2,", "\n1.5,");
    let mapping = STAMPED.replace("[time]", "[time]\nduplicates = \"keep_first\"");
    let error = imported("duplicates", &mapping, &[("log.csv", back)]).unwrap_err();
    assert!(
        error.contains("row 202: the time is 1.5 s") && !error.contains("keep"),
        "{error}"
    );
    for (key, position) in [("keep_first", 1.0), ("keep_last", 1.5)] {
        let mapping = STAMPED.replace("[time]", &format!("[time]\nduplicates = \"{key}\""));
        let logs = imported("duplicates", &mapping, &files).unwrap();
        let cycles = &logs.train[0].cycles;
        assert_eq!((cycles.len(), cycles[299].trace.cycle), (300, 299));
        assert!(near(&cycles[100].trace.pose[..1], &[position]), "{key}");
        let told = logs.warnings.concat();
        assert!(
            told.contains("1 of 301 rows are left out, the first at 1.00000 s"),
            "{told}"
        );
    }
}

/// A mapping that filters a position and a force.
const FILTERED: &str = r#"
    files = { train = "log.csv" }
    time = { column = "t" }
    position = { x = "p" }
    executed_velocity = { derive = true }
    wrench = { fx = "f" }
    filter = { cutoff_hz = 15.0, order = 4, trim_s = 0.3 }
"#;

/// A swept sine fills the band of the filter; what of the force follows it is no noise.
#[test]
fn a_sweep_is_not_taken_for_the_noise_of_a_model_to_start_from() {
    let mut random = RandomStream::new(9, 0);
    let noise: Vec<f64> = (0..8000).map(|_| 0.01 * random.normal()).collect();
    let log = table("t,p,f", 8000, |n| {
        let t = 0.002 * n;
        // From 0 to 20 Hz.
        let (sin, rate) = ((PI * 1.25 * t * t).sin(), 2.0 * PI * 1.25 * t);
        let position = sin / (1.0 + rate * rate);
        format!("{t},{position},{}", -0.5 * sin + noise[n as usize])
    });
    let logs = imported("sweep", FILTERED, &[("log.csv", log)]).unwrap();
    let filtered = logs.filtered.as_ref();
    let text = starter(&logs.train, filtered, &Told::default())
        .unwrap()
        .text;
    let noise = Model::from_toml(&text, "model.toml").unwrap().noise.force_n;
    // Of white noise the filter leaves a quarter.
    assert!((0.001..0.01).contains(&noise), "{noise}");
}

/// A force that follows a motion in no proportion fills the band of the filter, too; the noise is seen above it, before the filter.
#[test]
fn a_band_full_of_motion_is_not_taken_for_noise() {
    let mut random = RandomStream::new(11, 0);
    let noise: Vec<f64> = (0..8000).map(|_| 0.01 * random.normal()).collect();
    let phases: Vec<f64> = (0..140).map(|_| 2.0 * PI * random.uniform()).collect();
    let log = table("t,p,f", 8000, |n| {
        let t = 0.002 * n;
        // Lines from 0.1 to 14 Hz.
        let swing = |k: usize| (2.0 * PI * 0.1 * (k + 1) as f64 * t + phases[k]).sin();
        let position = 0.1 * (0..phases.len()).map(swing).sum::<f64>();
        let noise = noise[n as usize];
        format!("{t},{position},{}", noise - position * position)
    });
    let logs = imported("full_band", FILTERED, &[("log.csv", log)]).unwrap();
    let noise_by = |filtered: &Filtered| {
        let starter = starter(&logs.train, Some(filtered), &Told::default()).unwrap();
        let model = Model::from_toml(&starter.text, "model.toml").unwrap();
        model.noise.force_n
    };
    let seen = logs.filtered.clone().unwrap();
    let noise = noise_by(&seen);
    // Of white noise the filter leaves a quarter.
    assert!((0.0018..0.0032).contains(&noise), "{noise}");
    let behind = noise_by(&Filtered {
        noise: Vec::new(),
        ..seen
    });
    assert!(behind > 10.0 * noise, "{behind}");
}

/// A mapping of a shaft of which only the speed is measured.
const SHAFT: &str =
    "[time]\ncolumn = \"t\"\n[executed_velocity]\nrx = \"w\"\n[wrench]\ntx = \"tau\"";

/// A drive that turns a shaft at speeds that it holds; torques are commands, or rounded to few digits.
fn shaft(torque: impl Fn(f64) -> f64) -> (Model, Vec<String>, Summary, VelocityMeaning) {
    let mapping = format!("{SHAFT}\n[files]\ntrain = \"log.csv\"\n");
    let log = table("t,w,tau", 1000, |n| {
        let speed = 150.0 * (0.002 * n).sin();
        format!(
            "{},{},{}",
            0.01 * n,
            (0.05 * speed).round() * 20.0,
            torque(speed)
        )
    });
    let logs = imported("shaft", &mapping, &[("log.csv", log)]).unwrap();
    assert_eq!(logs.warnings, Vec::<String>::new());
    let starter = starter(&logs.train, None, &Told::default()).unwrap();
    let meaning = Signals::new(&logs.train[0]).unwrap().velocity;
    let model = Model::from_toml(&starter.text, "model.toml").unwrap();
    let summary = Summary::of("log", &logs.train[0], &[]);
    (model, starter.guessed, summary, meaning)
}

#[test]
fn a_model_to_start_from_has_a_noise_of_the_size_of_the_signal() {
    let command = |speed: f64| -1e-3 * speed.signum() - 2e-5 * speed;
    let rounded = |speed: f64| (command(speed) * 2e3).round() / 2e3;
    // A random telegraph: as white as noise, which would have larger values.
    let jumps = |speed: f64| 4e-3 * (1e7 * speed).sin().signum();
    let about_a_constant = |speed: f64| 8e-3 + jumps(speed);
    for torque in [
        &command as &dyn Fn(f64) -> f64,
        &rounded,
        &jumps,
        &about_a_constant,
    ] {
        let (model, guessed, summary, meaning) = shaft(torque);
        let (noise, bias) = (model.noise.torque_n_m, model.tolerance.bias[3]);
        assert!((1e-6..8e-6).contains(&noise), "{noise}");
        assert!(bias < noise, "{bias}");
        let [said] = guessed.as_slice() else {
            panic!("{guessed:?}")
        };
        assert!(said.starts_with("[noise] torque_n_m = "), "{said}");
        assert_eq!(model.noise.force_n, Model::default().noise.force_n);
        // A velocity that repeats says nothing about what it means, and the angle counts turns.
        assert_eq!(meaning, VelocityMeaning::Sampled);
        let angle = &summary.channels[0];
        assert!(angle.name == "pose rx" && angle.high > 100.0, "{angle:?}");
    }
}

/// What no column tells stands in the mapping, so that nobody has to edit the model after each import.
#[test]
fn a_mapping_says_what_the_model_to_start_from_cannot_know() {
    let log = table("t,w,tau", 300, |n| {
        format!("{},{},{}", 0.01 * n, n.sin(), (0.3 * n).sin())
    });
    let import = |says: &str| {
        let mapping = format!("{SHAFT}\n[files]\ntrain = \"log.csv\"\n{says}");
        let logs =
            imported("told", &mapping, &[("log.csv", log.clone())]).map_err(anyhow::Error::msg)?;
        let text = starter(&logs.train, None, &logs.told)?.text;
        anyhow::Ok(Model::from_toml(&text, "model.toml")?)
    };
    let plain = import("").unwrap();
    assert!(!plain.tool.dynamic_compensation && !plain.sensor.wrench.drives());
    let told =
        import("[starter]\nwrench = \"commanded\"\ngravity_m_s2 = [0.0, 0.0, 0.0]\nmass_kg = 12.5")
            .unwrap();
    assert!(told.tool.dynamic_compensation && told.sensor.wrench.drives());
    assert_eq!(
        (told.sensor.gravity_m_s2, told.tool.mass_kg),
        ([0.0; 3], 12.5)
    );
    for (says, expected) in [
        ("[starter]\nmass_kg = -1.0", "[starter] of the mapping"),
        ("[starter]\nmass = 1.0", "unknown key `mass` in [starter]"),
        ("[starter]\nwrench = \"driven\"", "unscaled"),
    ] {
        let error = format!("{:#}", import(says).unwrap_err());
        assert!(error.contains(expected), "{error}");
    }
}

/// Two logs of a shaft whose angle nobody measured, so that its eccentric has another phase in each: no weight is looked for,
/// about which they would disagree.
#[test]
fn logs_without_positions_are_not_asked_what_acts_by_position() {
    let log = |begin: f64| {
        let mut noise = RandomStream::new(7, begin.to_bits());
        let noise: Vec<f64> = (0..2000).map(|_| 5e-5 * noise.normal()).collect();
        table("t,w,tau", 2000, |n| {
            let t = begin + 0.01 * n;
            let (angle, speed) = (-40.0 * (0.5 * t).cos(), 20.0 * (0.5 * t).sin());
            let friction = 1e-3 * speed.signum() + 2e-5 * speed;
            let torque = friction + 2e-4 * angle.sin() + noise[n as usize];
            format!("{},{speed},{}", 0.01 * n, -torque)
        })
    };
    let mapping = format!("{SHAFT}\n[files]\ntrain = \"a.csv\"\ntest = \"b.csv\"\n");
    let files = [("a.csv", log(0.0)), ("b.csv", log(2.0))];
    let logs = imported("no_positions", &mapping, &files).unwrap();
    let (train, test) = (&logs.train, &logs.test);
    let text = starter(train, None, &Told::default()).unwrap().text;
    let model = Model::from_toml(&text.replace("\"measured\"", "\"commanded\""), "model.toml");
    let found = diagnose(&model.unwrap(), &[&train[0]], &[&test[0]], &|_, _| {});
    let found = found.unwrap().diagnosis;
    assert_eq!(found.verdict, Verdict::Named, "{}", found.sentence);
    let friction = |id: &String| ["guide_coulomb", "guide_viscous"].contains(&id.as_str());
    assert!(found.effects.iter().all(friction), "{}", found.sentence);
    let says = |note: &String| {
        let said = [
            "Not tested",
            "bearing_gravity",
            "velocities and no positions",
        ];
        said.iter().all(|part| note.contains(part))
    };
    assert!(found.notes.iter().any(says), "{:?}", found.notes);
}
