//! The page and the table of the paper's experiment.

use super::impact_table;
use super::reproduce::{Bounces, Flight, Reproduction};
use anyhow::Result;
use softdock_app::record::CycleRecord;
use softdock_control::delay::LawName;
use softdock_control::modes::Mode;
use softdock_io::identity;
use softdock_io::recording::Recording;
use softdock_report::{Band, Cell, Column, Mark, Page, Plot, Series, Table};

/// Speeds whose curves are shown, mm/s (the paper's Figs. 5 to 8 span 1 to 15).
const SHOWN_MM_S: [f64; 4] = [1.0, 5.0, 10.0, 15.0];
/// The parts of the law in the order of the trace, named as in Fig. 9.
const PARTS: [&str; 7] = [
    "c1 Σ",
    "c2 Σ",
    "c3 Σ",
    "c4 Σ",
    "b0 s_dv",
    "b1 s_v |dv|",
    "v_back",
];
/// The table: one line per law and speed.
pub fn table(reproduction: &Reproduction) -> Table {
    let mut columns = vec![Column::text("law")];
    columns.extend(impact_table::columns());
    columns.push(Column::number("over touch instants", ""));
    columns.push(Column::number("offset left", ""));
    let mut table = Table::new(columns);
    for Flight { row, .. } in &reproduction.flights {
        let mut cells = vec![Cell::text(row.law.name())];
        cells.extend(impact_table::cells(&row.impact));
        cells.push(Cell::interval(row.restitution_low, row.restitution_high, 3));
        cells.push(Cell::percent(row.offset_after));
        table.push(cells);
    }
    table
}

/// Repeated bounces: one line per variant.
pub fn bounce_table(reproduction: &Reproduction) -> Table {
    let mut table = Table::new(vec![
        Column::text("two stops, 5 mm/s"),
        Column::text("restitution of each impact"),
        Column::text("peak force of each impact [N]"),
        Column::text("end"),
    ]);
    for bounces in &reproduction.bounces {
        let list = |value: fn(&crate::impacts::Impact) -> String| {
            bounces
                .impacts
                .iter()
                .map(value)
                .collect::<Vec<_>>()
                .join(" ")
        };
        let end = bounces
            .fault
            .clone()
            .unwrap_or_else(|| "ran to the end".to_owned());
        let mark = if bounces.fault.is_some() {
            Mark::Bad
        } else {
            Mark::Neutral
        };
        table.push(vec![
            Cell::text(&bounces.name),
            Cell::text(list(|i| format!("{:.2}", i.restitution))),
            Cell::text(list(|i| format!("{:.0}", i.peak_force_n))),
            Cell::text(&end).marked(mark),
        ]);
    }
    table
}

/// The result in a sentence.
pub fn headline(reproduction: &Reproduction) -> String {
    let restitutions = |law| {
        reproduction
            .flights
            .iter()
            .filter(move |f| f.row.law == law)
            .map(|f| f.row.impact.restitution)
    };
    let worst = restitutions(LawName::Seed)
        .map(|e| (e - 1.0).abs())
        .fold(0.0, f64::max);
    let (low, high) = restitutions(LawName::None)
        .fold((f64::INFINITY, 0.0_f64), |(low, high), e| {
            (low.min(e), high.max(e))
        });
    format!(
        "A robot that is 32 ms late gives an elastic bounce back {low:.2} to {high:.2} times too \
         fast at every speed; the paper's law brings it within {:.0} % of 1 between 1 and 15 mm/s, \
         and runs away over repeated bounces.",
        worst * 100.0
    )
}

/// The page.
pub fn page(reproduction: &Reproduction) -> Result<Page> {
    let mut page = Page::new("The spring-rod experiment");
    page.headline(&headline(reproduction));
    page.section("Against the analytic elastic bounce");
    page.table(&table(reproduction));
    page.paragraph(
        "The law works in whole cycles of 4 ms, so it matters where in a cycle the touch falls: \
         the last but one column is the range over four instants, the others are for one of them.",
    );
    page.section("Growing impacts (Fig. 4)");
    page.paragraph(
        "Two stops that face each other: each impact should be as strong as the last. The literal \
         law, whose sums are never reset, runs away as well; gating and resetting them, which the \
         paper does not have, keeps it bounded at this speed, not at every one.",
    );
    page.table(&bounce_table(reproduction));
    let forces: Vec<Plot> = reproduction.bounces.iter().map(force_plot).collect();
    page.columns(&forces)?;
    page.section("Velocities before and after compensation (Figs. 5 to 8)");
    page.paragraph(
        "The model's velocity comes from the measured force; the command is what the robot is \
         told; executed is what the robot reports. Without compensation command and model are one.",
    );
    let both = [LawName::None, LawName::Seed];
    page.columns(&plots(reproduction, &both, velocity_plot))?;
    page.section("The seven parts of the law (Fig. 9)");
    for plot in plots(reproduction, &[LawName::Seed], parts_plot) {
        page.plot(&plot)?;
    }
    page.section("What the literal law leaves behind");
    page.paragraph(
        "Nothing in the printed equations takes the sums back to zero: after the contact the \
         command differs from the model for seconds (last column of the table). The curves coincide \
         again only if the sums are reset.",
    );
    if let Some(flight) = reproduction.flights.first() {
        page.details(
            "Settings of the first run",
            &flight.recording.header.settings_toml,
        );
    }
    page.identity(&identity::text());
    Ok(page)
}

fn plots(reproduction: &Reproduction, laws: &[LawName], draw: fn(&Flight) -> Plot) -> Vec<Plot> {
    let shown = |flight: &&Flight| {
        laws.contains(&flight.row.law) && SHOWN_MM_S.contains(&flight.row.speed_mm_s)
    };
    let mut flights: Vec<&Flight> = reproduction.flights.iter().filter(shown).collect();
    flights.sort_by(|a, b| a.row.speed_mm_s.total_cmp(&b.row.speed_mm_s));
    flights.into_iter().map(draw).collect()
}

/// Time shown before the first and after the last contact, s.
const MARGIN_S: f64 = 0.15;

/// A curve of all cycles of the closed loop.
fn curve(recording: &Recording, value: impl Fn(&CycleRecord) -> f64) -> Vec<(f64, f64)> {
    let running = recording
        .cycles
        .iter()
        .filter(|cycle| cycle.trace.mode == Mode::Running);
    running
        .map(|cycle| (cycle.trace.time_s, value(cycle)))
        .collect()
}

/// Keeps of a plot only the time around the shaded contacts.
fn around_contact(mut plot: Plot) -> Plot {
    let from = plot
        .shaded
        .first()
        .map_or(f64::MIN, |band| band.from - MARGIN_S);
    let to = plot
        .shaded
        .last()
        .map_or(f64::MAX, |band| band.to + MARGIN_S);
    for series in &mut plot.series {
        series.points.retain(|(t, _)| (from..=to).contains(t));
    }
    plot
}

/// Time spans of contact.
fn contacts(recording: &Recording) -> Vec<Band> {
    let mut bands: Vec<Band> = Vec::new();
    for (cycle, truth) in recording.cycles.iter().zip(&recording.truth) {
        let t = cycle.trace.time_s;
        if truth.contact_wrench.iter().all(|v| *v == 0.0) {
            continue;
        }
        match bands.last_mut() {
            Some(band) if t - band.to < 0.01 => band.to = t,
            _ => bands.push(Band {
                from: t,
                to: t,
                label: "contact".to_owned(),
                hue: None,
            }),
        }
    }
    bands
}

fn velocity_plot(flight: &Flight) -> Plot {
    let (row, recording) = (&flight.row, &flight.recording);
    let title = format!("{} mm/s, law {}", row.speed_mm_s, row.law.name());
    let mut plot = Plot::new(&title, "time [s]", "velocity x [mm/s]");
    plot.series = vec![
        Series::line(
            "model",
            curve(recording, |c| c.trace.model_velocity[0] * 1e3),
        ),
        Series::line(
            "executed",
            curve(recording, |c| c.trace.executed_velocity[0] * 1e3),
        ),
        Series::dashed(
            "command",
            curve(recording, |c| c.trace.sent_velocity[0] * 1e3),
        ),
    ];
    plot.shaded = contacts(recording);
    around_contact(plot)
}

fn parts_plot(flight: &Flight) -> Plot {
    let recording = &flight.recording;
    let title = format!("{} mm/s", flight.row.speed_mm_s);
    let mut plot = Plot::new(&title, "time [s]", "part of the command [mm/s]");
    plot.series = PARTS
        .iter()
        .enumerate()
        .map(|(i, name)| Series::line(*name, curve(recording, |c| c.trace.law_parts[i][0] * 1e3)))
        .collect();
    plot.shaded = contacts(recording);
    around_contact(plot)
}

fn force_plot(bounces: &Bounces) -> Plot {
    let mut plot = Plot::new(&bounces.name, "time [s]", "contact force x [N]");
    let force = curve(&bounces.recording, |c| c.trace.wrench_at_m[0]);
    plot.series = vec![Series::line("measured force", force)];
    plot
}
