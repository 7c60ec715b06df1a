//! The pictures of docs/delay, drawn from scenario S:
//!
//! ```sh
//! cargo test -p softdock-tests --test integration delay_laws::pictures -- --ignored
//! ```

use super::case::{CYCLE_S, Case, Rebound};
use softdock_control::delay::LawName;
use softdock_delay_plants::truth::Bounce;
use std::fmt::Write;
use std::path::Path;

/// Size of the picture and of its margins, px.
const SIZE: (f64, f64) = (640.0, 280.0);
const LEFT: f64 = 56.0;
const RIGHT: f64 = 12.0;
const TOP: f64 = 34.0;
const BOTTOM: f64 = 36.0;
/// Time shown, s, of which a part lies before the touch.
const SHOWN_S: f64 = 0.55;
const BEFORE_S: f64 = 0.08;
/// Largest velocity shown, in approach speeds, and lowest smallest one.
const HIGHEST: f64 = 1.4;
const LOWEST: f64 = -5.0;

/// A curve: (s since the onset, velocity in approach speeds).
type Curve = Vec<(f64, f64)>;

struct Flight {
    model: Curve,
    command: Curve,
    executed: Curve,
    ideal: Curve,
    rebound: Rebound,
}

impl Flight {
    /// Smallest velocity that is shown.
    fn low(&self) -> f64 {
        let curves = [&self.model, &self.command, &self.executed];
        let all = curves.into_iter().flatten().map(|point| point.1);
        (all.fold(-1.0, f64::min) - 0.4).max(LOWEST)
    }
}

fn fly(law: LawName) -> Flight {
    let case = Case::scenario_s(law);
    let v = case.speed_m_s;
    let (mut model, mut command, mut executed) = (vec![], vec![], vec![]);
    let mut onset_s = None;
    let rebound = case.record::<f64>(|record| {
        let t = record.trace.time_s;
        model.push((t, record.trace.body_k.velocity[0] / v));
        command.push((t, record.trace.sent_velocity[0] / v));
        // The difference of two poses stands for the cycle before.
        executed.push((t - 0.5 * CYCLE_S, record.trace.executed_velocity[0] / v));
        let pushed = record.trace.wrench_at_m[0] < 0.0;
        // The onset lies in the middle of the cycle before the first force.
        onset_s = onset_s.or(pushed.then_some(t - 0.5 * CYCLE_S));
    });
    let onset_s = onset_s.unwrap();
    for curve in [&mut model, &mut command, &mut executed] {
        curve.iter_mut().for_each(|point| point.0 -= onset_s);
    }
    let (k, _) = case.contact();
    let contact_s = Bounce::new(case.mass_kg, k, 0.0, v).contact_s;
    let ideal = (0..200).map(|i| {
        let t = f64::from(i) / 200.0 * SHOWN_S - BEFORE_S;
        (t, (case.omega * t.clamp(0.0, contact_s)).cos())
    });
    Flight {
        model,
        command,
        executed,
        ideal: ideal.collect(),
        rebound,
    }
}

fn place((t, v): (f64, f64), low: f64) -> (f64, f64) {
    let x = LEFT + (t + BEFORE_S) / SHOWN_S * (SIZE.0 - LEFT - RIGHT);
    let share = (v - low) / (HIGHEST - low);
    (x, SIZE.1 - BOTTOM - share * (SIZE.1 - TOP - BOTTOM))
}

fn line(svg: &mut String, curve: &Curve, low: f64, style: &str) {
    let shown = |point: &&(f64, f64)| (-BEFORE_S..=SHOWN_S - BEFORE_S).contains(&point.0);
    let points: Vec<String> = curve
        .iter()
        .filter(shown)
        .map(|(t, v)| place((*t, v.clamp(low, HIGHEST)), low))
        .map(|(x, y)| format!("{x:.1},{y:.1}"))
        .collect();
    let _ = writeln!(
        svg,
        r#"<polyline fill="none" {style} points="{}"/>"#,
        points.join(" ")
    );
}

fn text(svg: &mut String, (x, y): (f64, f64), style: &str, text: &str) {
    let _ = writeln!(svg, r#"<text x="{x:.1}" y="{y:.1}" {style}>{text}</text>"#);
}

fn axes(svg: &mut String, low: f64) {
    for v in [-4.0, -3.0, -2.0, -1.0, 0.0, 1.0]
        .into_iter()
        .filter(|v| *v > low)
    {
        let (x, y) = place((-BEFORE_S, v), low);
        let (end, _) = place((SHOWN_S - BEFORE_S, v), low);
        let _ = writeln!(
            svg,
            "<line x1=\"{x:.1}\" y1=\"{y:.1}\" x2=\"{end:.1}\" y2=\"{y:.1}\" stroke=\"#ddd\"/>"
        );
        let at = (x - 8.0, y + 4.0);
        text(svg, at, r#"text-anchor="end""#, &format!("{v} v"));
    }
    for t in [0.0, 0.1, 0.2, 0.3, 0.4] {
        let (x, _) = place((t, 0.0), low);
        let at = (x, SIZE.1 - BOTTOM + 18.0);
        text(svg, at, r#"text-anchor="middle""#, &format!("{t} s"));
    }
}

fn svg(law: LawName, flight: &Flight) -> String {
    let (width, height) = SIZE;
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" \
         font-family=\"sans-serif\" font-size=\"12\">\n\
         <rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n"
    );
    let low = flight.low();
    axes(&mut svg, low);
    let curves = [
        (&flight.ideal, "#999", r#"stroke-dasharray="5 4""#, "right"),
        (&flight.executed, "#d62728", "", "executed"),
        (&flight.command, "#2ca02c", "", "command"),
        (&flight.model, "#1f77b4", "", "model"),
    ];
    let mut x = LEFT;
    for (curve, colour, dash, name) in curves {
        line(
            &mut svg,
            curve,
            low,
            &format!(r#"stroke="{colour}" stroke-width="1.6" {dash}"#),
        );
        text(&mut svg, (x, 20.0), &format!(r#"fill="{colour}""#), name);
        x += 16.0 + 8.0 * name.len() as f64;
    }
    let summary = format!(
        "law {}: e = {:.2}, peak force {:+.0} %",
        law.name(),
        flight.rebound.restitution,
        1e2 * flight.rebound.peak_force_error
    );
    text(
        &mut svg,
        (width - RIGHT, 20.0),
        r#"text-anchor="end""#,
        &summary,
    );
    svg + "</svg>\n"
}

#[test]
#[ignore = "writes docs/delay/pictures"]
fn pictures() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/delay/pictures");
    std::fs::create_dir_all(&folder).unwrap();
    for law in LawName::ALL {
        let path = folder.join(format!("{}.svg", law.name()));
        std::fs::write(path, svg(law, &fly(law))).unwrap();
    }
}
