//! The pictures of docs/delay, drawn from scenario S:
//!
//! ```sh
//! cargo test -p softdock-tests --test integration delay_laws::pictures -- --ignored
//! ```

use super::case::{CYCLE_S, Case};
use softdock_control::delay::LawName;
use softdock_delay_plants::truth::Bounce;
use softdock_report::{Hue, Plot, Series};
use std::path::Path;

/// Time shown, s, of which a part lies before the touch.
const SHOWN_S: f64 = 0.55;
const BEFORE_S: f64 = 0.08;
/// Velocities shown, in approach speeds.
const LOWEST: f64 = -5.0;
const HIGHEST: f64 = 1.4;

/// The curves, (s since the onset, velocity in approach speeds), and the title.
fn fly(law: LawName) -> Plot {
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
    let (k, _) = case.contact();
    let contact_s = Bounce::new(case.mass_kg, k, 0.0, v).contact_s;
    let ideal = (0..200).map(|i| {
        let t = f64::from(i) / 200.0 * SHOWN_S - BEFORE_S;
        (t, (case.omega * t.clamp(0.0, contact_s)).cos())
    });
    let shown = |mut curve: Vec<(f64, f64)>| {
        for (t, v) in &mut curve {
            *t -= onset_s;
            *v = v.clamp(LOWEST, HIGHEST);
        }
        curve.retain(|(t, _)| (-BEFORE_S..=SHOWN_S - BEFORE_S).contains(t));
        curve
    };
    let title = format!(
        "law {}: e = {:.2}, peak force {:+.0} %",
        law.name(),
        rebound.restitution,
        1e2 * rebound.peak_force_error
    );
    let mut plot = Plot::new(title, "time since the touch [s]", "velocity [v]");
    plot.series = vec![
        Series::dashed("right", ideal.collect()).colored(Hue::Grey),
        Series::line("executed", shown(executed)).colored(Hue::Vermilion),
        Series::line("command", shown(command)).colored(Hue::Green),
        Series::line("model", shown(model)).colored(Hue::Blue),
    ];
    plot
}

#[test]
#[ignore = "writes docs/delay/pictures"]
fn pictures() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/delay/pictures");
    std::fs::create_dir_all(&folder).unwrap();
    for law in LawName::ALL {
        let path = folder.join(format!("{}.svg", law.name()));
        // Behind a picture in a text is any page, dark ones too; its colours are made for white.
        let white = "<svg style=\"background:white\"";
        let svg = fly(law).to_svg().unwrap().replacen("<svg", white, 1);
        std::fs::write(path, svg).unwrap();
    }
}
