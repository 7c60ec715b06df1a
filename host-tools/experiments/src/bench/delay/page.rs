//! The page of the benchmark.

use super::ranking::{self, sentence, standings};
use super::row::Row;
use super::tables;
use anyhow::Result;
use softdock_control::delay::LawName;
use softdock_io::identity;
use softdock_report::{Page, Plot, Series};

/// Larger restitutions are drawn at this value.
const DRAWN: f64 = 3.0;
/// Number of colours of lines; further lines are dashed.
const COLOURS: usize = 6;

/// Tables and plots of all rows.
///
/// # Errors
/// A plot that cannot be drawn.
pub fn page(rows: &[Row], laws: &[LawName]) -> Result<Page> {
    let mut page = Page::new("Laws against the robot's delay");
    let all: Vec<&Row> = rows.iter().collect();
    let standings = standings(&all, laws);
    let best_first: Vec<LawName> = standings.iter().map(|standing| standing.law).collect();
    page.headline(&sentence(&standings));
    page.table(&ranking::table(&standings));
    let (straight, others): (Vec<&Row>, Vec<&Row>) =
        rows.iter().partition(|row| row.sweep == "headline");
    if !straight.is_empty() {
        everything_known(&mut page, &straight, laws, &best_first)?;
    }
    if !others.is_empty() {
        not_as_believed(&mut page, &others, laws, &best_first);
    }
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

/// Section on cases in which the board knows robot and contact; `rows` is not empty.
fn everything_known(
    page: &mut Page,
    rows: &[&Row],
    laws: &[LawName],
    best_first: &[LawName],
) -> Result<()> {
    page.section("Five robots, everything known");
    page.paragraph(&format!(
        "An elastic contact of 21 rad/s and 500 kg; the robot stands still for 16 ms when it \
         reverses. Each number is the worst over {} instants of the touch within a cycle. The \
         ideal is the bounce in closed form.",
        rows[0].touches
    ));
    page.table(&tables::robots(rows, best_first));
    page.columns(&plots(rows, best_first))?;
    page.table(&tables::worst(rows, best_first));
    page.table(&tables::speeds(rows, laws, best_first));
    Ok(())
}

/// Section on cases in which robot or contact differs from the board's belief.
fn not_as_believed(page: &mut Page, rows: &[&Row], laws: &[LawName], best_first: &[LawName]) {
    page.section("What is not as believed");
    page.paragraph(
        "One line per case: the restitution of the worst touch. `At least` is the restitution below which no law can bring a first contact: \
         the impulse that is spent before the robot can turn. A run that leaves every bound is \
         said to run away.",
    );
    page.table(&tables::cases(rows, laws, best_first));
    let spread = tables::spread(rows, laws, best_first);
    if !spread.rows.is_empty() {
        page.paragraph(
            "Mean and standard deviation over the touches, where something is drawn by chance.",
        );
        page.table(&spread);
    }
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
