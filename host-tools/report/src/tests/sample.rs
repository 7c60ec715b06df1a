//! A page with one of everything, as a command would write it.

use super::{force_plot, noise};
use crate::*;

/// Time of a 4 ms cycle, in s.
fn time_s(cycle: u32) -> f64 {
    f64::from(cycle) * 0.004
}

pub(super) fn sample_page() -> Page {
    let spike = |cycle| if cycle % 3_000 == 42 { 1.5e-3 } else { 0.0 };
    let residual: Vec<(f64, f64)> = (0..15_000)
        .map(|cycle| (time_s(cycle), 2e-4 * noise(cycle) + spike(cycle)))
        .collect();
    let mut page = Page::new("Run 7 against the model <chaser-b>");
    page.headline(
        "The robot answers 32.1 ms late and pauses 11 ms at each reversal; with both in the model the velocity error \
         falls from 1.84 to 0.26 mm/s on data that the fit has not seen.",
    );
    page.verdict(Mark::Good, "<Named>", "Delay & pause.");
    page.list(&["<one>".to_owned(), "two".to_owned()]);
    page.code("softdock compare 'a <b>'");
    page.section("Where rig and model disagree");
    page.paragraph(
        "71 % of the squared error is in the executed velocity along z, in the 40 ms after the velocity changes sign.",
    );
    page.table(&channels());
    let figures = |page: &mut Page| -> anyhow::Result<()> {
        page.bars(&shares())?.plot(&force())?;
        page.plot(&velocity(&residual))?;
        page.section("What was learned").bars(&fall())?;
        let each = page.section("Each axis");
        each.columns(&small_plots(&residual))?;
        Ok(())
    };
    figures(&mut page).unwrap();
    page.details(
        "All settings of this run",
        "delay_s = 0.032\nlaw = \"seed\" # <unsafe> & more",
    );
    page.identity("softdock 0.1.0 (4aa91bc) · settings 7f3a91c2 · run-7.mcap");
    page
}

fn channels() -> Table {
    let mut table = Table::new(vec![
        Column::text("Channel"),
        Column::number("RMS error", ""),
        Column::text("Unit"),
        Column::number("Error", "σ"),
        Column::number("Share", ""),
        Column::number("Delay within", "ms"),
    ]);
    for (name, rms, unit, sigma, mark, share) in [
        ("executed velocity z", 1.84, "mm/s", 9.23, Mark::Bad, 0.713),
        ("wrench z", 0.1234, "N", 1.04, Mark::Good, 0.221),
        ("pose x", 0.000_021, "m", 1.6, Mark::Neutral, 0.066),
    ] {
        table.push(vec![
            Cell::text(name),
            Cell::number(rms, 3),
            Cell::text(unit),
            Cell::number(sigma, 3).marked(mark),
            Cell::percent(share),
            Cell::interval(32.0 - rms, 32.0 + rms, 2),
        ]);
    }
    table
}

fn shares() -> BarChart {
    let label = "share of the squared error";
    let mut chart = BarChart::new("Where the error is", label, Format::Percent(1));
    chart.bars = vec![
        Bar::new("zero crossing", 0.62),
        Bar::new("first contact", 0.21),
        Bar::new("turning point", 0.01),
    ];
    chart
}

fn band(from: f64, to: f64, label: &str) -> Band {
    let label = label.to_owned();
    let hue = None;
    Band {
        from,
        to,
        label,
        hue,
    }
}

fn force() -> Plot {
    let contact = |cycle: u32| match cycle {
        4_000..4_200 => (f64::from(cycle - 4_000) * 0.0157).sin(),
        _ => 0.0,
    };
    let measured = (3_800..4_500).map(|i| (time_s(i), 42.0 * contact(i) + 1.2 * noise(i)));
    let model = (3_800..4_500).map(|i| (time_s(i), 40.0 * contact(i + 8)));
    let mut plot = force_plot(vec![
        Series::line("measured", measured.collect()),
        Series::dashed("model", model.collect()),
    ]);
    plot.shaded = vec![
        band(15.2, 16.0, "approach"),
        band(16.0, 16.4, "compression"),
        band(16.4, 16.43, "zero crossing"),
        band(16.43, 16.8, "rebound"),
    ];
    plot
}

fn velocity(residual: &[(f64, f64)]) -> Plot {
    let mut plot = Plot::new("Error over the whole run", "time [s]", "velocity [m/s]");
    plot.series = vec![Series::line("executed minus model", residual.to_vec())];
    let starts = (0..5).map(|i| time_s(i * 3_000));
    plot.shaded = starts
        .map(|from| band(from, from + 1.5, "failing"))
        .collect();
    plot
}

fn fall() -> BarChart {
    let label = "RMS velocity error [mm/s]";
    let title = "The error falls on unseen data";
    let mut chart = BarChart::waterfall(title, label, Format::Significant(3));
    chart.bars = vec![
        Bar::new("model as delivered", 1.84),
        Bar::new("+ actuator.transport_delay", 0.71),
        Bar::new("+ actuator.reversal_pause", 0.26),
        Bar::new("+ sensor.thermal_drift", 0.27),
    ];
    chart
}

fn small_plots(residual: &[(f64, f64)]) -> [Plot; 4] {
    let axis = |name: &str, hue: Hue| {
        let mut plot = Plot::new(format!("Velocity error, {name}"), "time [s]", "error [m/s]");
        let points = residual.iter().skip(100).step_by(7).copied().collect();
        plot.series = vec![Series::line("", points).colored(hue)];
        plot
    };
    let regime = (0..3_000).map(|i| (noise(i) * 8.0, noise(i) * 0.8 + noise(i + 9_000) * 0.3));
    let mut cloud = Plot::new("Error against speed", "speed [mm/s]", "error [mm/s]");
    cloud.series = vec![Series::new("cycles", Style::Points, regime.collect())];
    let mut stairs = Plot::new("Commanded correction", "time [s]", "correction [mm]");
    let sent = (0..25).map(|i| (time_s(i), f64::from(i % 6)));
    stairs.series = vec![Series::new("sent", Style::Step, sent.collect())];
    stairs.y_from_zero = true;
    [axis("x", Hue::Blue), axis("y", Hue::Green), cloud, stairs]
}
