//! The page of the benchmark.

use super::row::Row;
use super::tables;
use anyhow::Result;
use softdock_analysis::identity;
use softdock_control::delay::LawName;
use softdock_report::{Page, Plot, Series};

/// Restitutions beyond this are drawn here.
const DRAWN: f64 = 3.0;
/// Lines that differ in colour; further ones are dashed.
const COLOURS: usize = 6;

/// Tables and plots of all rows.
///
/// # Errors
/// A plot that cannot be drawn.
pub fn page(rows: &[Row], laws: &[LawName]) -> Result<Page> {
    let mut page = Page::new("Laws against the robot's delay");
    page.headline(&headline(rows, laws));
    let (straight, others): (Vec<&Row>, Vec<&Row>) =
        rows.iter().partition(|row| row.sweep == "headline");
    if !straight.is_empty() {
        page.section("Five robots, everything known");
        page.paragraph(
            &format!(
                "An elastic contact of 21 rad/s and 500 kg; the robot stands still for 16 ms when it \
                 reverses. Each number is the worst over {} instants of the touch within a cycle. The \
                 ideal is the bounce in closed form.",
                straight[0].touches
            ),
        );
        page.table(&tables::worst(&straight, laws));
        page.columns(&plots(&straight, laws))?;
        page.table(&tables::speeds(&straight, laws));
    }
    if !others.is_empty() {
        page.section("What is not as believed");
        page.paragraph(
            "One line per case: the restitution of the worst touch, in noise mean and standard \
             deviation. `At least` is the restitution below which no law can bring a first contact: \
             the impulse that is spent before the robot can turn. A run that leaves every bound is \
             said to run away.",
        );
        page.table(&tables::cases(&others, laws));
    }
    page.paragraph(tables::STAR);
    page.section("What no law can do better");
    page.paragraph(
        "On a first contact with a wall that is not known beforehand, a robot that is late by τ goes on \
         for τ and up to a cycle more. `At least`: the impulse that is spent until it can turn, over \
         m v0, less 1; a law that moves the model by measured force alone cannot come below. `Without \
         impulse balance`: a law that follows the predicted model and makes up for nothing. For a pure \
         delay and an undamped or damped linear spring.",
    );
    page.table(&tables::limits(rows));
    page.identity(&identity::text());
    Ok(page)
}

/// What the numbers say, in a sentence.
fn headline(rows: &[Row], laws: &[LawName]) -> String {
    let worst = |law: &LawName, pick: fn(&Row) -> f64| {
        let of_law = rows
            .iter()
            .filter(|row| row.sweep == "headline" && row.law == *law);
        of_law.map(|row| pick(row).abs() * 100.0).reduce(f64::max)
    };
    let text = |law: &LawName| {
        let error = worst(law, Row::restitution_error)?;
        let added = worst(law, |row| row.impulse_unaccounted)?;
        Some(format!("{} {error:.1} and {added:.1} %", law.name()))
    };
    let texts: Vec<String> = laws.iter().filter_map(text).collect();
    if texts.is_empty() {
        return format!("{} rows on the cases that were asked for.", rows.len());
    }
    format!(
        "Largest error of the restitution, and largest part of the momentum that no measured force \
         accounts for, over five robots and 1 to 15 mm/s: {}.",
        texts.join(", ")
    )
}

/// Restitution over speed, one plot per robot.
fn plots(rows: &[&Row], laws: &[LawName]) -> Vec<Plot> {
    let mut robots: Vec<&str> = rows.iter().map(|r| r.actuator).collect();
    robots.dedup();
    let curve = |robot: &str, law: LawName| {
        let of = rows.iter().filter(|r| r.actuator == robot && r.law == law);
        of.map(|r| (r.speed_mm_s, r.restitution.clamp(-DRAWN, DRAWN)))
            .collect::<Vec<_>>()
    };
    robots
        .into_iter()
        .map(|robot| {
            let mut plot = Plot::new(robot, "speed [mm/s]", "restitution");
            let series = |(place, law): (usize, &LawName)| {
                let (name, points) = (law.name(), curve(robot, *law));
                if place < COLOURS {
                    Series::line(name, points)
                } else {
                    Series::dashed(name, points)
                }
            };
            plot.series = laws.iter().enumerate().map(series).collect();
            plot
        })
        .collect()
}
