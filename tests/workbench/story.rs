//! The whole story by clicks: from an imported log to "the error fell", and back. Pictures are kept under
//! `target/report-screenshots/`.

use super::server::{Bench, imported};
use softdock_tests::browser::Browser;
use softdock_tests::process::{done, scratch};

/// Widths from a telephone to a wide screen, pixels.
const WIDTHS: [u32; 5] = [400, 800, 1280, 1600, 2560];

#[test]
fn the_error_falls_by_clicks_and_comes_back() {
    let folder = imported("workbench_story", "guide_coulomb");
    let bench = Bench::start(&folder);
    let mut browser = Browser::start("workbench_story_chromium");
    browser.resize(1600, 1000);
    browser.visit(&format!("http://{}/", bench.host()));

    // The verdict and the plots are there without a click.
    browser.until("document.querySelector('#verdict .sentence .mark')");
    browser.until("document.querySelectorAll('#plots canvas').length == 2");
    browser.until("document.querySelector('#check')?.dataset.ready == 'true'");
    browser.keep_pictures("workbench-compare");

    // A recorded column is drawn below, as it was measured.
    let columns = "document.querySelector('#column')";
    browser.evaluate(&format!(
        "{columns}.selectedIndex = 1; {columns}.dispatchEvent(new Event('change'))"
    ));
    browser.until("document.querySelectorAll('#plots canvas').length == 3");

    // A window says what its error follows.
    browser.evaluate("document.dispatchEvent(new KeyboardEvent('keydown', {key: 'n'}))");
    browser.until("document.querySelector('#window .follows')");

    browser.click("#diagnose");
    browser.until("document.querySelector('.hypotheses li')");
    browser.until("document.querySelector('#answer')?.dataset.verdict == 'named'");
    browser.click("[data-try='guide_coulomb']");
    browser.until("document.querySelector('#addition .difference')");
    browser.until("document.querySelector('#plots').dataset.drawn.match(/ [0-9]+ $/)");
    browser.keep_pictures("workbench-trial");

    let error = |browser: &mut Browser, place: usize| -> f64 {
        let text = format!("document.querySelectorAll('.fall strong')[{place}].textContent");
        browser.evaluate(&text).as_str().unwrap().parse().unwrap()
    };
    let (before, after) = (error(&mut browser, 0), error(&mut browser, 1));
    // All channels together, the noise of those without an error included.
    assert!(after < 0.9 * before, "{before} {after}");

    browser.click("#write");
    browser.until("document.querySelector('#added')");
    browser.until("document.querySelectorAll('.waterfalls li').length == 2");
    browser.until("document.querySelector('#verdict .sentence .mark')");
    let model = std::fs::read_to_string(folder.join("model.toml")).unwrap();
    assert!(model.contains("guide_coulomb"));
    browser.keep_pictures("workbench-added");

    for width in WIDTHS {
        browser.resize(width, 900);
        // The plots take their width a moment later than the page.
        browser.until("[...document.querySelectorAll('.uplot')].every(plot => plot.clientWidth <= plot.parentElement.clientWidth)");
        let found = browser.look();
        assert_eq!(found.sticking_out, Vec::<String>::new(), "{width} px");
        assert_eq!(found.console, Vec::<String>::new(), "{width} px");
        if width == WIDTHS[0] {
            browser.keep_pictures("workbench-narrow");
        }
    }
    // Taking it out is shown before it is written, as adding was.
    let has_it = || {
        let model = std::fs::read_to_string(folder.join("model.toml")).unwrap();
        model.contains("id = \"guide_coulomb\"")
    };
    for (choice, left, has) in [
        ("#drop", "now stands", true),
        ("#write", "no longer", false),
    ] {
        browser.click("[aria-label='Take guide_coulomb out']");
        browser.until("document.querySelector('#addition .difference .removed')");
        assert!(has_it());
        browser.click(choice);
        browser.until(&format!(
            "document.querySelector('#added')?.textContent.includes('{left}')"
        ));
        assert_eq!(has_it(), has, "{choice}");
    }
    browser.click("#undo");
    browser.until("document.querySelector('#addition').hidden");
    assert!(has_it());
}

#[test]
fn two_runs_are_laid_over_each_other_and_aligned() {
    let folder = imported("workbench_overlay", "guide_coulomb");
    let bench = Bench::start(&folder);
    let mut browser = Browser::start("workbench_overlay_chromium");
    browser.visit(&format!("http://{}/", bench.host()));
    browser.until("document.querySelectorAll('#plots canvas').length == 2");
    browser.click("[data-recording='train.mcap'] [data-role='overlay']");
    browser.until("document.querySelector('#shift')");
    browser.evaluate("document.dispatchEvent(new KeyboardEvent('keydown', {key: ']'}))");
    browser.until("Number(document.querySelector('#shift').value) > 0");
    browser.click(".overlay button:nth-of-type(3)");
    browser.until("Number(document.querySelector('#shift').value) != 0.004");
    browser.keep_pictures("workbench-overlay");

    // Short contacts in long runs are found, wherever they are: 100 ms in ten seconds and in a hundred, and in two of 200 s.
    browser.evaluate(
        "import('/assets/align.js').then(({ bestShift }) => {
            const run = (from, to, contact) => {
                const time = Float64Array.from({ length: (to - from) * 250 }, (_, n) => from + n / 250);
                const load = (t) => Math.abs(t - contact) < 0.05 ? 100 * Math.cos(10 * Math.PI * (t - contact)) : 0;
                return [time, time.map((t) => 7 + load(t) + 0.1 * Math.sin(1e5 * t))];
            };
            window.shifts = [[run(0, 10, 5), run(0, 100, 60)], [run(0, 200, 150.7), run(3, 203, 120.123)]]
                .map(([first, second]) => bestShift(first, second));
            const [time, values] = run(0, 10, 5);
            window.shifts.push(bestShift(run(0, 10, 5), [time, values.map((value, n) => n % 5 ? NaN : value)]));
        })",
    );
    browser.until("window.shifts");
    let shifts = browser.evaluate("window.shifts");
    for (place, expected) in [-55.0, 30.577].into_iter().enumerate() {
        let found = shifts[place].as_f64().unwrap();
        assert!((found - expected).abs() < 0.005, "{shifts}");
    }
    // Of a run with gaps over most of it.
    assert!(shifts[2].is_null(), "{shifts}");
    assert_eq!(browser.look().console, Vec::<String>::new());
}

/// A scenario is run and all parameters are fitted to it, by clicks.
#[test]
fn a_scenario_is_run_and_fitted_by_clicks() {
    let folder = scratch("workbench_run_story");
    done(&folder, &["init", "."]);
    let secret = "a-token-of-this-test";
    let bench = Bench::listening(&folder, &["--listen", "127.0.0.1", "--token", secret]);
    let mut browser = Browser::start("workbench_run_story_chromium");
    browser.visit(&format!("http://{}/?token={secret}", bench.host()));
    browser.until("document.querySelector('#simulation details')");
    browser.click("#simulation summary");
    browser.click("#run");
    browser.until("document.querySelector('#ran')");
    browser.keep_pictures("workbench-run");
    // The only recording is the one that is fitted on.
    browser.until("document.querySelector('#check')?.dataset.ready == 'true'");
    browser.click("#fit");
    browser.until("document.querySelector('#addition .difference')");
    browser.keep_pictures("workbench-fit");
    browser.click("#write");
    browser.until("document.querySelector('#added')");
    let model = std::fs::read_to_string(folder.join("model.toml")).unwrap();
    assert!(model.contains("effect = \"refit\""), "{model}");
    browser.click("#undo");
    browser.until("!document.querySelector('#added')");
    let model = std::fs::read_to_string(folder.join("model.toml")).unwrap();
    assert!(!model.contains("effect = \"refit\""), "{model}");
    assert_eq!(browser.look().console, Vec::<String>::new());
}
