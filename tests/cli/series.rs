//! `softdock compare --series`: the numbers behind the curves.

use softdock_io::data_table::{DataTable, Values};
use softdock_tests::process::{done, json, scratch, softdock};
use std::fs;

const SCENARIO: &str = include_str!("../../host-tools/scenarios/spring-rod.toml");
const MODEL: &str = include_str!("../../host-tools/scenarios/spring-rod.model.toml");

#[test]
fn the_series_are_those_that_the_comparison_judges() {
    let folder = scratch("cli_series");
    fs::write(folder.join("scenario.toml"), SCENARIO).unwrap();
    fs::write(folder.join("model.toml"), MODEL).unwrap();
    done(&folder, &["run", "scenario.toml", "-o", "run.mcap"]);
    let compare = |file: &str| {
        let arguments = ["compare", "model.toml", "run.mcap", "--series", file];
        json(&folder, &arguments)
    };
    let document = compare("series.csv");
    assert_eq!(document["series"]["rows"], 750);
    assert_eq!(document["series"]["columns"][0], "time_s");
    let text = fs::read_to_string(folder.join("series.csv")).unwrap();
    let head: Vec<&str> = text.lines().next().unwrap().split(',').collect();
    assert_eq!(head.len(), 1 + 4 * 6 * 4);
    assert_eq!(head[0], "time_s");
    assert_eq!(
        head[1..5],
        [
            "executed_velocity_x_measured_m_s",
            "executed_velocity_x_predicted_m_s",
            "executed_velocity_x_residual_m_s",
            "executed_velocity_x_sigma_m_s"
        ]
    );
    assert!(head.contains(&"wrench_rz_measured_n_m"), "{head:?}");
    assert_eq!(text.lines().count(), 751);

    assert_eq!(document.get("curves"), None, "750 rows are a file's");
    let short = [
        "run",
        "scenario.toml",
        "-o",
        "short.mcap",
        "--duration-s",
        "0.8",
    ];
    done(&folder, &short);
    let both = ["compare", "model.toml", "run.mcap", "short.mcap"];
    let compared = done(&folder, &both);
    for name in ["== run.mcap\n", "\n== short.mcap\n"] {
        assert!(compared.contains(name), "{compared}");
    }
    let refused = softdock(&folder, &[&both[..], &["--report", "both.html"]].concat());
    let expected = "--report, --series and --json expect one recording, received 2";
    assert!(refused.stderr.contains(expected), "{}", refused.stderr);
    let short = json(&folder, &["compare", "model.toml", "short.mcap"]);
    let curves = short["curves"].as_object().unwrap();
    assert_eq!(curves.len(), 1 + 4 * 6 * 4);
    assert_eq!(curves["wrench_x_residual_n"].as_array().unwrap().len(), 200);

    compare("series.parquet");
    let table = DataTable::read_parquet(&folder.join("series.parquet")).unwrap();
    let column = |what: &str| match table.values(&format!("executed_velocity_x_{what}_m_s")) {
        Ok(Values::Number(values)) => values.clone(),
        other => panic!("{other:?}"),
    };
    // The residual is the difference, and its mean square what the comparison says.
    let (measured, predicted, residual) =
        (column("measured"), column("predicted"), column("residual"));
    let mut squares = 0.0;
    for ((measured, predicted), residual) in measured.iter().zip(&predicted).zip(&residual) {
        if let Some(residual) = residual {
            assert_eq!(measured.unwrap() - predicted.unwrap(), *residual);
            squares += residual * residual;
        }
    }
    let rms = (squares / measured.len() as f64).sqrt();
    let channel = &document["channels"][0];
    assert_eq!(
        (&channel["name"], &channel["axis"]),
        (&"executed_velocity".into(), &"x".into())
    );
    let said = channel["rms"].as_f64().unwrap();
    assert!((rms - said).abs() < 1e-9 * said, "{rms}, {said}");

    // As MCAP it stands beside the recording: a message for each cycle, at the recording's times.
    compare("series.mcap");
    let read = |name: &str, topic: &str| -> Vec<(u64, usize)> {
        let bytes = fs::read(folder.join(name)).unwrap();
        let messages = mcap::MessageStream::new(&bytes).unwrap();
        let messages = messages
            .map(Result::unwrap)
            .filter(|m| m.channel.topic == topic);
        messages.map(|m| (m.log_time, m.data.len())).collect()
    };
    let (series, status) = (read("series.mcap", "/compare"), read("run.mcap", "/status"));
    assert_eq!(series.len(), 750);
    assert_eq!(series[0].1, 4 + 8 * head.len());
    let times = |all: &[(u64, usize)]| all.iter().map(|(time, _)| *time).collect::<Vec<_>>();
    assert_eq!(times(&series), times(&status));
}
