//! Reports and the workbench in a real browser: headless Chromium, controlled with its DevTools protocol
//! (<https://chromedevtools.github.io/devtools-protocol/>) over a pair of pipes, so that neither a port nor a network is
//! needed.

mod devtools;
mod inspection;

pub use inspection::{Drawing, Inspection};

use crate::process::{PATIENCE, scratch};
use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use devtools::DevTools;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::thread;
use std::time::{Duration, Instant};

/// Interval between two checks of a wait.
const POLL_INTERVAL: Duration = Duration::from_millis(20);
/// Width of the window, pixels.
const WIDTH_PX: u32 = 1280;
/// Height of the window, pixels; screenshots are of the whole page.
const HEIGHT_PX: u32 = 900;

/// A page as users see it: on a light and on a dark screen, and on paper.
#[derive(Debug)]
pub struct Browser {
    tools: DevTools,
}

impl Browser {
    /// Starts Chromium with an empty profile; `test` names the folder of the profile.
    ///
    /// # Panics
    /// If there is no Chromium, or it does not start.
    pub fn start(test: &str) -> Self {
        let mut tools = DevTools::start(&chromium(), &scratch(test));
        for domain in ["Runtime", "Log", "Network", "Page"] {
            tools.call(&format!("{domain}.enable"), json!({}));
        }
        let mut browser = Self { tools };
        browser.resize(WIDTH_PX, HEIGHT_PX);
        browser
    }

    /// Opens a file and inspects the page.
    ///
    /// # Panics
    /// If the browser does not show the file.
    pub fn inspect(&mut self, page: &Path) -> Inspection {
        let address = format!("file://{}", page.display());
        self.visit(&address);
        let found = self.evaluate(inspection::SCRIPT);
        Inspection::new(&address, &found, self.tools.events())
    }

    /// Saves images of the open page in `target/report-screenshots/`: `NAME.png`, `NAME-dark.png`, and `NAME.pdf` as printed.
    ///
    /// # Panics
    /// If the browser cannot render the page, or a file cannot be written.
    pub fn keep_pictures(&mut self, name: &str) {
        for (scheme, suffix) in [("light", ""), ("dark", "-dark")] {
            let features = json!([{"name": "prefers-color-scheme", "value": scheme}]);
            self.tools
                .call("Emulation.setEmulatedMedia", json!({"features": features}));
            let whole = json!({"format": "png", "captureBeyondViewport": true});
            let picture = self.tools.call("Page.captureScreenshot", whole);
            keep(&format!("{name}{suffix}.png"), &picture);
        }
        self.tools
            .call("Emulation.setEmulatedMedia", json!({"features": []}));
        let paper = json!({"printBackground": false, "preferCSSPageSize": true});
        let printed = self.tools.call("Page.printToPDF", paper);
        keep(&format!("{name}.pdf"), &printed);
    }

    /// Opens an address and waits until it is loaded.
    ///
    /// # Panics
    /// If the browser does not show the page.
    pub fn visit(&mut self, address: &str) {
        self.tools.forget_events();
        let shown = self.tools.call("Page.navigate", json!({"url": address}));
        assert!(shown["errorText"].is_null(), "{address}: {shown}");
        self.tools.wait_for_event("Page.loadEventFired");
    }

    /// Waits until an expression in the page is true.
    ///
    /// # Panics
    /// If it never becomes true; the message contains the text of the page.
    pub fn until(&mut self, expression: &str) {
        let give_up = Instant::now() + PATIENCE;
        while self.evaluate(&format!("Boolean({expression})")) != json!(true) {
            if Instant::now() > give_up {
                let text = self.evaluate("document.body.innerText");
                panic!("never true: {expression}\n{text}");
            }
            thread::sleep(POLL_INTERVAL);
        }
    }

    /// Clicks the middle of an element, and clicks again if the element moved away at that moment.
    ///
    /// # Panics
    /// If there is no such element, or it cannot be clicked.
    pub fn click(&mut self, selector: &str) {
        let watch = format!(
            "(() => {{ window.clicked = false; document.querySelector({selector:?}).addEventListener('click', \
             () => {{ window.clicked = true; }}, {{once: true, capture: true}}); }})()"
        );
        let give_up = Instant::now() + PATIENCE;
        loop {
            let place = self.place_at_rest(selector);
            self.evaluate(&watch);
            for kind in ["mouseMoved", "mousePressed", "mouseReleased"] {
                let event = json!({
                    "type": kind, "x": place[0], "y": place[1], "button": "left", "clickCount": 1
                });
                self.tools.call("Input.dispatchMouseEvent", event);
            }
            // If the click has left the page, the new page does not know `clicked`.
            if self.evaluate("window.clicked") != json!(false) {
                return;
            }
            assert!(Instant::now() < give_up, "{selector} was never hit");
        }
    }

    /// Middle of an element that can be clicked and is not covered, once it no longer moves: content that loads above it
    /// shifts it.
    fn place_at_rest(&mut self, selector: &str) -> Value {
        let middle = format!(
            "(() => {{ const e = document.querySelector({selector:?}); if (!e || e.disabled) return null; \
             e.scrollIntoView({{block: 'center'}}); const b = e.getBoundingClientRect(); \
             const place = [b.x + b.width / 2, b.y + b.height / 2]; \
             return e.contains(document.elementFromPoint(...place)) ? place : null; }})()"
        );
        let give_up = Instant::now() + PATIENCE;
        let mut last = Value::Null;
        loop {
            let place = self.evaluate(&middle);
            if !place.is_null() && place == last {
                return place;
            }
            let text = (Instant::now() > give_up).then(|| self.evaluate("document.body.innerText"));
            assert!(text.is_none(), "never to be pressed: {selector}\n{text:?}");
            last = place;
            thread::sleep(POLL_INTERVAL);
        }
    }

    /// Replaces the text of an element.
    ///
    /// # Panics
    /// If there is no such element.
    pub fn write(&mut self, selector: &str, text: &str) {
        self.click(selector);
        self.evaluate(&format!("document.querySelector({selector:?}).select?.()"));
        self.tools.call("Input.insertText", json!({"text": text}));
    }

    /// Sets the size of the window, in pixels.
    pub fn resize(&mut self, width: u32, height: u32) {
        let window = json!({
            "width": width, "height": height, "deviceScaleFactor": 1, "mobile": false
        });
        self.tools
            .call("Emulation.setDeviceMetricsOverride", window);
    }

    /// Inspects the open page.
    pub fn look(&mut self) -> Inspection {
        let found = self.evaluate(inspection::SCRIPT);
        Inspection::new("the open page", &found, self.tools.events())
    }

    /// Value of an expression in the page. The page's own policy against scripts does not apply to it.
    ///
    /// # Panics
    /// If the expression throws.
    pub fn evaluate(&mut self, expression: &str) -> Value {
        let question = json!({"expression": expression, "returnByValue": true});
        let answer = self.tools.call("Runtime.evaluate", question);
        assert!(answer["exceptionDetails"].is_null(), "{answer}");
        answer["result"]["value"].clone()
    }
}

/// Opens a report, saves images of it as `name`, and checks that it has no faults and at least `plots` plots.
///
/// # Panics
/// If a check fails; the message says which.
pub fn assert_report(browser: &mut Browser, page: &Path, name: &str, plots: usize) {
    let inspection = browser.inspect(page);
    browser.keep_pictures(name);
    let mut faults = inspection.faults();
    let drawn = inspection.drawings.iter().filter(|d| d.curves > 0).count();
    if drawn < plots {
        faults.push(format!("{drawn} plots with curves instead of {plots}"));
    }
    assert!(faults.is_empty(), "{name}:\n{}", faults.join("\n"));
}

/// Writes the base64 `data` of an answer.
fn keep(file: &str, answer: &Value) {
    let data = answer["data"].as_str().expect("an answer with data");
    let bytes = BASE64_STANDARD.decode(data).expect("base64");
    let folder = pictures();
    std::fs::create_dir_all(&folder).expect("the folder of the pictures can be made");
    std::fs::write(folder.join(file), bytes).expect("a picture can be written");
}

/// `target/report-screenshots`.
fn pictures() -> PathBuf {
    let executable = std::env::current_exe().expect("a test has a path");
    let target = executable.ancestors().nth(3);
    target
        .expect("a test stands in target/<profile>/deps")
        .join("report-screenshots")
}

/// The browser: `SOFTDOCK_CHROMIUM`, or the first of the usual names that is installed.
///
/// # Panics
/// If there is none.
fn chromium() -> PathBuf {
    if let Some(named) = std::env::var_os("SOFTDOCK_CHROMIUM") {
        let named = PathBuf::from(named);
        assert!(
            named.is_file(),
            "SOFTDOCK_CHROMIUM is {}, which is no file; expected the path of a Chromium",
            named.display()
        );
        return named;
    }
    let folders = std::env::var_os("PATH").unwrap_or_default();
    let folders: Vec<PathBuf> = std::env::split_paths(&folders).collect();
    let names = ["chromium", "chromium-browser", "google-chrome"];
    let mut places = names
        .iter()
        .flat_map(|name| folders.iter().map(move |folder| folder.join(name)));
    places.find(|place| place.is_file()).unwrap_or_else(|| {
        panic!(
            "Chromium is missing: apt-get install chromium (as root), or name another one in \
             SOFTDOCK_CHROMIUM"
        )
    })
}
