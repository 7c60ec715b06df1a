//! A recording of 250,000 cycles in the browser.

use super::server::Bench;
use softdock_tests::browser::Browser;
use softdock_tests::process::{done, scratch, softdock, words};

/// Cycles of 1,000 s.
const CYCLES: u32 = 250_000;
/// Width of the window, pixels.
const WIDTH: u32 = 1600;
/// Lines that uPlot draws for a pixel of a series: into the column, to its lowest, its highest and its last value.
const LINES_PER_PIXEL: u32 = 4;
/// Series of the two plots: measured, predicted; the difference and both edges of its band.
const SERIES: u32 = 5;

/// What a step of the view draws depends on the pixels and not on the length of the recording.
#[test]
#[ignore = "long: a recording of 1,000 s and its comparison"]
fn a_quarter_of_a_million_points_are_panned() {
    let folder = scratch("workbench_long");
    done(&folder, &["init", "."]);
    let run = words("run scenario.toml --duration-s 1000 -o long.mcap");
    // In so long a time it leaves the box: a fault, in which it rests to the end.
    assert_eq!(softdock(&folder, &run).code, Some(1));
    let bench = Bench::start(&folder);
    let path = "/api/prediction?recording=long.mcap&model=model.toml&channel=wrench&axis=x";
    let body = bench.get(path).body;
    let rows = u32::from_le_bytes(body[..4].try_into().unwrap());
    assert_eq!(rows, CYCLES);

    let mut browser = Browser::start("workbench_long_chromium");
    browser.resize(WIDTH, 1000);
    browser.visit(&format!("http://{}/", bench.host()));
    browser.until("document.querySelectorAll('#plots canvas').length == 2");
    browser.evaluate(
        "(() => { const draw = Path2D.prototype.lineTo; window.drawn = 0; \
         Path2D.prototype.lineTo = function (...to) { window.drawn++; return draw.apply(this, to); }; })()",
    );
    for key in ["+", "ArrowRight", "ArrowRight", "ArrowLeft", "-", "0"] {
        browser.evaluate("window.drawn = 0");
        browser.evaluate(&format!(
            "document.dispatchEvent(new KeyboardEvent('keydown', {{key: '{key}'}}))"
        ));
        browser.until("window.drawn > 0");
        let drawn = browser.evaluate("window.drawn").as_u64().unwrap();
        let most = u64::from(LINES_PER_PIXEL * SERIES * WIDTH);
        assert!(drawn <= most, "{key}: {drawn} lines");
    }
    browser.keep_pictures("workbench-long");
    assert_eq!(browser.look().console, Vec::<String>::new());
}
