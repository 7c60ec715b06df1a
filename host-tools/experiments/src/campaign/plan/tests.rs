use super::*;
use crate::scenario::SPRING_ROD;
use serde_json::json;

const BASE: &str = r#"
scenario = "spring-rod.toml"
samples = 20
design = "latin_hypercube"

[[factors]]
setting = "board.control.body_k.velocity_m_s[0]"
name = "speed_m_s"
uniform = [0.001, 0.02]

[[factors]]
setting = "board.control.delay.law"
list = ["none", "predictor"]

[[limits]]
outcome = "restitution"
low = 0.9
high = 1.1
"#;

fn planned(campaign: &str) -> Result<Plan> {
    let folder = tempfile::tempdir()?;
    std::fs::write(folder.path().join("spring-rod.toml"), SPRING_ROD)?;
    let path = folder.path().join("campaign.toml");
    std::fs::write(&path, campaign)?;
    Plan::new(&path)
}

fn refused(campaign: &str) -> String {
    format!("{:#}", planned(campaign).unwrap_err())
}

#[test]
fn every_draw_meets_every_combination_with_the_same_noise() {
    let plan = planned(BASE).unwrap();
    assert_eq!(plan.rows(), 40);
    for index in (0..40).step_by(2) {
        let [none, predictor] = [index, index + 1].map(|index| plan.conditions(index));
        assert_eq!(none.values[0], predictor.values[0]);
        assert_eq!(none.seed, predictor.seed);
        assert_eq!(
            [&none.values[1], &predictor.values[1]],
            [&json!("none"), &json!("predictor")]
        );
        let scenario = plan.scenario(index + 1).unwrap();
        assert_eq!(scenario.board.control.delay.law.name(), "predictor");
        assert_eq!(
            scenario.board.control.body_k.velocity_m_s[0],
            none.values[0]
        );
        assert_eq!(scenario.seed, none.seed);
    }
}

#[test]
fn a_plan_comes_back_from_its_file() {
    let plan = planned(BASE).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let place = Place::folder(folder.path());
    plan.write(&place).unwrap();
    let read = Plan::read_to_run(&place).unwrap();
    assert_eq!((&read.hash, read.rows()), (&plan.hash, plan.rows()));
    assert_eq!(read.conditions(17), plan.conditions(17));

    let path = folder.path().join(FILE);
    let text = std::fs::read_to_string(&path).unwrap();
    std::fs::write(&path, text.replace("0.02]", "0.03]")).unwrap();
    let error = Plan::read(&place).unwrap_err();
    assert!(
        format!("{error:#}").contains("was changed after it was planned"),
        "{error:#}"
    );

    std::fs::write(&path, text.replace(&plan.binary, "softdock 9.9.9")).unwrap();
    let error = Plan::read_to_run(&place).unwrap_err().to_string();
    assert!(error.contains("planned by softdock 9.9.9"), "{error}");
    assert!(Plan::read(&place).is_ok());
}

#[test]
fn what_cannot_be_is_said_before_anything_runs() {
    let with = |from: &str, to: &str| refused(&BASE.replace(from, to));
    let typo = with("body_k.velocity_m_s[0]", "body_k.velocty_m_s[0]");
    assert!(
        typo.contains("`board.control.body_k.velocity_m_s[0]`"),
        "{typo}"
    );
    let typo = with("\"predictor\"", "\"predicter\"");
    assert!(typo.contains("predicter"), "{typo}");
    let key = with("low = 0.9", "lo = 0.9");
    assert!(key.contains("did you mean `low`"), "{key}");
    let outcome = with("\"restitution\"", "\"restitusion\"");
    assert!(outcome.contains("did you mean `restitution`"), "{outcome}");
    let range = with("[0.001, 0.02]", "[0.001, 200.0]");
    assert!(range.contains("factor `speed_m_s` at"), "{range}");
    let ways = with("list = [", "uniform = [0.0, 1.0]\nlist = [");
    assert!(ways.contains("exactly one of uniform"), "{ways}");
    let seed = with("board.control.delay.law\"", "seed\"\nname = \"noise\"");
    assert!(seed.contains("`seed` cannot be a factor"), "{seed}");
    let limits = with("low = 0.9", "low = 1.2");
    assert!(
        limits.contains("`low = 1.2` above `high = 1.1`"),
        "{limits}"
    );
    let limits = with("high = 1.1", "high = inf");
    assert!(limits.contains("no `high` for no bound"), "{limits}");
    let limits = with("high = 1.1", "source_read = true");
    assert!(limits.contains("name what was read"), "{limits}");
    let names = with("name = \"speed_m_s\"", "name = \"restitution\"");
    assert!(
        names.contains("two columns would be called `restitution`"),
        "{names}"
    );
}

#[test]
fn one_factor_for_each_setting() {
    let second = |setting: &str, values: &str| {
        let factor = format!("[[factors]]\nname = \"b\"\nsetting = \"{setting}\"\n{values}\n");
        planned(&BASE.replacen("[[limits]]", &format!("{factor}\n[[limits]]"), 1))
    };
    let speed = "board.control.body_k.velocity_m_s";
    let whole = "list = [[0.01, 0.0, 0.0]]";
    for (setting, values) in [
        (format!("{speed}[0]"), "uniform = [0.01, 0.02]"),
        // A whole table, of which the first factor sets a part.
        (speed.to_owned(), whole),
    ] {
        let error = format!("{:#}", second(&setting, values).unwrap_err());
        assert!(
            error.contains("which factor `speed_m_s` sets"),
            "{setting}: {error}"
        );
    }
    assert!(second(&format!("{speed}[1]"), "uniform = [0.0, 0.001]").is_ok());
}
