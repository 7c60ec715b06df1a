//! Reports as a colleague sees them: opened in headless Chromium, nothing missing, nothing cut
//! off, nothing asked of the network. Pictures are kept under `target/report-screenshots/`.

use softdock::pages::comparison;
use softdock::pages::diagnosis::page;
use softdock_analysis::compare::compare;
use softdock_experiments::run::record;
use softdock_experiments::scenario::Scenario;
use softdock_io::recording::Recording;
use softdock_physics::model::Model;
use softdock_tests::browser::{Browser, assert_report};
use softdock_tests::process::{demonstration, scratch};
use softdock_tests::synthetic::{self, SyntheticDiagnosis};
use std::fs;

#[test]
fn the_pages_of_the_demonstration_are_whole() {
    let (folder, demo) = demonstration();
    assert!(demo.success, "{}", demo.stderr);
    let mut browser = Browser::start("report_browser_demo_chromium");
    assert_report(
        &mut browser,
        &folder.join("demo/diagnose.html"),
        "diagnose",
        3,
    );
    assert_report(
        &mut browser,
        &folder.join("demo/compare.html"),
        "compare",
        4,
    );
}

#[test]
fn a_diagnosis_of_each_verdict_is_whole() {
    let folder = scratch("report_browser_diagnosis");
    let mut browser = Browser::start("report_browser_diagnosis_chromium");
    let cases = [
        ("diagnosis-named", synthetic::named(), 5),
        ("diagnosis-nothing-missing", synthetic::nothing_missing(), 2),
        ("diagnosis-unexplained", synthetic::unexplained(), 4),
    ];
    for (
        name,
        SyntheticDiagnosis {
            diagnosis,
            before,
            after,
            identity,
        },
        plots,
    ) in cases
    {
        let path = folder.join(format!("{name}.html"));
        let report = page(&diagnosis, &before, &after, &identity).unwrap();
        fs::write(&path, report.to_html()).unwrap();
        assert_report(&mut browser, &path, name, plots);
    }
}

#[test]
fn what_is_wrong_with_a_page_is_found() {
    let folder = scratch("report_browser_faults");
    let mut browser = Browser::start("report_browser_faults_chromium");
    let mut faults = |body: &str| {
        let path = folder.join("page.html");
        fs::write(&path, format!("<!DOCTYPE html><body>{body}</body>")).unwrap();
        browser.inspect(&path).faults().join("\n")
    };
    let good = "<svg width='300' height='50'><polyline points='0,0 9,9 20,5'/><text x='5' y='20'>a</text></svg>";
    assert_eq!(faults(good), "");
    for (body, expected) in [
        ("", "no <svg>"),
        (
            "<svg aria-label='F' width='0' height='50'><rect width='9' height='9'/></svg>",
            "`F` is drawn 0 by 50",
        ),
        (
            "<svg aria-label='F' width='300' height='50'></svg>",
            "`F` is empty",
        ),
        (
            "<svg width='300' height='50'><polyline points='0,0 NaN,9'/></svg>",
            "not a number",
        ),
        (
            "<svg width='300' height='50'><text x='290' y='20'>seventeen letters</text></svg>",
            "cut off: seventeen letters",
        ),
        (
            "<svg width='300' height='50'><text x='9' y='20'>first</text><text x='12' y='22'>second</text></svg>",
            "texts over each other: first | second",
        ),
        (
            "<p style='width: 3000px'>very wide</p>",
            "sticks out of the page: very wide",
        ),
        (
            "<div style='overflow: auto'><table style='width: 3000px'><tr><td>hidden</table></div>",
            "sticks out of the page: hidden",
        ),
        ("<script>nothing.here()</script>", "console: "),
        ("<script>console.error('broken')</script>", "broken"),
        ("<img src='missing.png'>", "missing.png"),
    ] {
        let found = faults(&format!(
            "{body}{}",
            if body.is_empty() { "" } else { good }
        ));
        assert!(
            found.contains(expected),
            "expected `{expected}` in\n{found}"
        );
    }
}

/// A page is made of whatever a recording holds, and says what the comparison found.
#[test]
fn a_comparison_of_any_numbers_has_a_page() {
    let scenario = Scenario::spring_rod().unwrap();
    let mut recording = record(&scenario).unwrap().0;
    let model = Model::default();
    let html = |recording: &Recording| {
        let found = compare(&model, recording).unwrap();
        comparison::page(&found).unwrap().to_html()
    };
    let usual = html(&recording);
    assert!(usual.contains("<svg") && usual.contains("turning point"));
    assert!(usual.contains("body_k"), "the settings are in the page");
    for cycle in &mut recording.cycles {
        cycle.inputs.sensor.wrench = [f64::INFINITY; 6];
        cycle.trace.pose = [f64::NAN; 7];
        cycle.trace.model_velocity = [f64::NAN; 6];
        cycle.trace.sent_velocity = [f64::NAN; 6];
    }
    assert!(html(&recording).contains("Model against recording"));
}
