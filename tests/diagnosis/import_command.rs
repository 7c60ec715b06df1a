//! `softdock import` with a mapping: what it writes and what it says.

use super::tables::table;
use softdock_io::recording::Recording;
use softdock_physics::model::{Axis, Model};
use softdock_statistics::RandomStream;
use softdock_tests::process::{done, json, scratch, softdock, words};
use std::f64::consts::PI;
use std::fs;

/// A log of positions and forces: its velocity is derived, and a model to start from comes with it.
#[test]
fn an_import_says_what_it_read_and_gives_a_model_to_start_from() {
    let folder = scratch("mapping_starter");
    let log = table("t,p,f", 1000, |n| {
        let angle = 2.0 * PI * n * 4e-3;
        format!("{},{},{}", n * 4e-3, 0.1 * angle.sin(), 4.0 * angle.sin())
    });
    let mapping = "[time]\ncolumn = \"t\"\n[position]\nx = \"p\"\n[wrench]\nfx = \"f\"\n";
    fs::write(folder.join("log.csv"), log).unwrap();
    fs::write(folder.join("mapping.toml"), mapping).unwrap();
    let arguments = words("import log.csv --mapping mapping.toml -o out");
    let run = softdock(&folder, &arguments);
    // A sine of all digits is no sensor's.
    let guessed = "warning: [noise] force_n = 2.3e-3 N is a guess";
    assert!(
        run.code == Some(0) && run.stderr.lines().count() == 1 && run.stderr.starts_with(guessed),
        "{}",
        run.stderr
    );
    for says in [
        "train.mcap: 1000 rows, 3.996 s, a cycle of 0.004000 s",
        "central differences of the poses",
        "Not in the log, or zero throughout: sent velocity, model velocity.",
    ] {
        assert!(run.stdout.contains(says), "`{says}`: {}", run.stdout);
    }
    let text = fs::read_to_string(folder.join("out/model.toml")).unwrap();
    assert!(text.contains("active_axes = [\"x\"]"), "{text}");
    done(&folder, &["compare", "out/model.toml", "out/train.mcap"]);
}

#[test]
fn the_command_takes_one_file_in_place_of_the_mappings_and_tells_what_looks_wrong() {
    let folder = scratch("mapping_command");
    let mapping = "model = \"model.toml\"\n[files]\ntrain = \"other.csv\"\ntest = \"other2.csv\"\n\
                   [time]\ncolumn = \"t\"\n[position]\nx = \"p\"\n\
                   [executed_velocity]\nderive = true\n";
    let log = table("t,p", 150, |n| format!("{},{}", n * 0.01, n * n));
    fs::write(folder.join("mapping.toml"), mapping).unwrap();
    fs::write(folder.join("model.toml"), "# mine\n").unwrap();
    fs::write(folder.join("log.csv"), log).unwrap();
    let arguments = words("import log.csv --mapping mapping.toml -o out --json");
    let run = softdock(&folder, &arguments).succeeded();
    let report = run.json();
    assert_eq!(report["cycles"], 150);
    let warnings = report["warnings"].as_array().unwrap();
    assert!(
        warnings[0]
            .as_str()
            .unwrap()
            .contains("are the positions in mm?"),
        "{warnings:?}"
    );
    assert!(
        run.stderr
            .contains("warning: log.csv: a position of 22200 m"),
        "{}",
        run.stderr
    );
    let files: Vec<_> = ["model.toml", "train.mcap"]
        .map(|f| format!("out/{f}"))
        .into();
    assert_eq!(report["files"], serde_json::json!(files));
    assert_eq!(
        fs::read_to_string(folder.join("out/model.toml")).unwrap(),
        "# mine\n"
    );

    let again = softdock(&folder, &arguments);
    assert!(
        again.code == Some(1) && again.stderr.contains("not overwritten"),
        "{}",
        again.stderr
    );
    let recording = softdock(&folder, &["import", "out/train.mcap", "-o", "copy"]);
    assert!(
        recording.stderr.contains("is a recording already"),
        "{}",
        recording.stderr
    );
    assert!(recording.code == Some(1) && !folder.join("copy").exists());
}

/// Three runs of a carriage, two to fit on, each of two tables side by side; one moves along y, too. One model is written for all.
#[test]
fn several_logs_of_a_machine_need_one_mapping() {
    let mapping = r#"
        [files]
        train = [["slow.csv", "slow-force.csv"], ["fast.csv", "fast-force.csv"]]
        test = [["unseen.csv", "unseen-force.csv"]]
        [time]
        column = "t"
        [position]
        x = "x"
        y = "y"
        [executed_velocity]
        derive = true
        [wrench]
        fx = "f"
    "#;
    let folder = scratch("mapping_several_logs");
    let write = |name: &str, text: String| fs::write(folder.join(name), text).unwrap();
    write("mapping.toml", mapping.to_owned());
    for (name, rate, aside, noise) in [
        ("slow", 1.0, 0.0, 1e-2),
        ("fast", 5.0, 0.01, 3e-2),
        ("unseen", 3.0, 0.0, 1e-1),
    ] {
        let along = |n: f64| 0.1 * (rate * 0.01 * n).sin();
        let row = |n: f64| format!("{:.3},{:.6},{:.6}", 0.01 * n, along(n), aside * along(n));
        write(&format!("{name}.csv"), table("t,x,y", 300, row));
        // Uniform: 0 to 1 from the golden ratio.
        let scatter = |n: f64| noise * (12.0_f64.sqrt() * ((0.618_034 * n).fract() - 0.5));
        let row = |n: f64| format!("{:.4}", 2.0 * along(n) + scatter(n * n));
        write(&format!("{name}-force.csv"), table("f", 300, row));
    }
    let import = |path: &str| {
        softdock(
            &folder,
            &[
                "import",
                path,
                "--mapping",
                "mapping.toml",
                "-o",
                "out",
                "--force",
            ],
        )
    };
    let run = import(".");
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    for (name, origin) in [
        ("train1.mcap", "slow.csv + slow-force.csv"),
        ("train2.mcap", "fast.csv + fast-force.csv"),
        ("test.mcap", "unseen.csv + unseen-force.csv"),
    ] {
        let recording = Recording::open(&folder.join("out").join(name)).unwrap();
        assert_eq!(recording.header.identity, format!("imported from {origin}"));
        let mut lines = run.stdout.lines();
        let said = |line: &str| line.contains(name) && line.ends_with(origin);
        assert!(lines.any(said), "{}", run.stdout);
    }
    let model = fs::read_to_string(folder.join("out/model.toml")).unwrap();
    let model = Model::from_toml(&model, "model.toml").unwrap();
    assert_eq!(model.rig.active_axes, [Axis::X, Axis::Y]);
    // Not that of the unseen log, nor the larger one of the two.
    assert!(
        (0.008..0.013).contains(&model.noise.force_n),
        "{:?}",
        model.noise
    );

    let one = import("slow.csv");
    assert!(
        one.code == Some(1) && one.stderr.contains("names 2 training logs"),
        "{}",
        one.stderr
    );
    write("fast-force.csv", "f\n1.0\n".to_owned());
    let torn = import(".");
    assert!(
        torn.code == Some(1) && torn.stderr.contains("a list of lists"),
        "{}",
        torn.stderr
    );
}

/// A carriage that follows its command, and whose position has white noise, behind a low-pass far below the sampling rate.
#[test]
fn a_velocity_of_filtered_positions_has_the_noise_that_the_filter_leaves() {
    let folder = scratch("mapping_filtered");
    let mut random = RandomStream::new(1, 0);
    let mut position = 0.0;
    let rows = (0..4000).map(|n| {
        let t = 0.01 * f64::from(n);
        let (sent, at) = (0.1 * (3.0 * t).sin(), position);
        position += 0.01 * sent;
        format!("{t:.2},{sent:.7},{:.7}", at + 2e-4 * random.normal())
    });
    let log = ["t,u,p".to_owned()].into_iter().chain(rows);
    let log = log.collect::<Vec<_>>().join("\n");
    let mapping = "[time]\ncolumn = \"t\"\n[position]\nx = \"p\"\n[sent_velocity]\nx = \"u\"\n[executed_velocity]\nderive = true\n\
                   [filter]\ncutoff_hz = 5.0\norder = 4\n";
    fs::write(folder.join("log.csv"), log).unwrap();
    fs::write(folder.join("mapping.toml"), mapping).unwrap();
    done(
        &folder,
        &words("import log.csv --mapping mapping.toml -o out"),
    );
    let compared = json(&folder, &["compare", "out/model.toml", "out/train.mcap"]);
    let of_velocity = &compared["channels"][0];
    let level = of_velocity["rms_sigma"].as_f64().unwrap();
    assert!((0.8..1.3).contains(&level), "{of_velocity}");
}
