//! The page that teaches an effect, for the terminal and as a report.

use super::picture::Picture;
use super::terminal;
use anyhow::Result;
use softdock_io::identity;
use softdock_physics::effects::{Effect, Naming, Parameter, by_id};
use softdock_report::number::significant;
use softdock_report::{Cell, Column, Page, Table};

/// Width of the text, characters.
const WIDTH: usize = 88;
/// Indent below a heading, characters.
const INDENT: usize = 2;

/// Everything that the catalogue knows about an effect, as text for a terminal.
pub fn lesson(effect: &Effect, picture: &Picture) -> String {
    let mut text = format!("{} ({})\n", effect.title, effect.id);
    text += &wrapped(&sentence(effect.summary));
    for (heading, body) in sections(effect) {
        text += &format!("\n{heading}\n{}", wrapped(&body));
        if heading == SIGNATURE {
            let shown = format!("Shown here: {}.", picture.excitation.describe());
            text += &format!("\n{}\n{}", wrapped(&shown), terminal::draw(picture));
        }
    }
    text += &format!("\nParameters\n{}", parameters(effect));
    text
}

/// The lesson as a page with a plot.
///
/// # Errors
///
/// If the plot cannot be drawn.
pub fn page(effect: &Effect, picture: &Picture) -> Result<Page> {
    let mut page = Page::new(format!("{} ({})", effect.title, effect.id));
    page.headline(&sentence(effect.summary));
    for (heading, body) in sections(effect) {
        page.section(heading).paragraph(&body);
        if heading == SIGNATURE {
            page.plot(&picture.to_plot(effect))?;
        }
    }
    page.section("Parameters").table(&parameters(effect));
    page.identity(&identity::text());
    Ok(page)
}

/// Heading of the section that has the picture.
const SIGNATURE: &str = "What it leaves in a recording";

/// Headings and texts, in the order in which they are read.
fn sections(effect: &Effect) -> Vec<(&'static str, String)> {
    let rivals: Vec<String> = effect
        .confused_with
        .iter()
        .map(|id| by_id(id).map_or_else(|| (*id).into(), |e| format!("{id} ({})", e.title)))
        .collect();
    let mut sections = vec![
        ("Equation", effect.equation.into()),
        ("Source", effect.source.into()),
        (SIGNATURE, sentence(effect.signature)),
        ("Typical size", sentence(effect.typical)),
        ("Confused with", rivals.join(", ")),
        ("What tells them apart", sentence(effect.tell_apart)),
    ];
    if effect.naming == Naming::Shape {
        let caution = "This curve fits many mechanisms. A diagnosis therefore never names it as the cause, but \
                       reports that the remaining error looks like it.";
        sections.push(("How far to trust it", caution.into()));
    }
    sections
}

fn parameters(effect: &Effect) -> Table {
    let mut table = Table::new(vec![
        Column::text("Parameter"),
        Column::text("Unit"),
        Column::number("From", ""),
        Column::number("To", ""),
        Column::text("Sign, or meaning"),
    ]);
    for parameter in effect.parameters {
        table.push(vec![
            Cell::text(parameter.name),
            Cell::text(parameter.unit),
            Cell::text(significant(parameter.low, 2)),
            Cell::text(significant(parameter.high, 2)),
            Cell::text(meaning(parameter)),
        ]);
    }
    table
}

fn meaning(parameter: &Parameter) -> String {
    if !parameter.words.is_empty() {
        let words = parameter.words.iter().enumerate();
        let words: Vec<String> = words.map(|(k, word)| format!("{k}: {word}")).collect();
        return words.join(", ");
    }
    let sign = if parameter.is_form() {
        "chooses the form of the law"
    } else if parameter.is_signed() {
        "either"
    } else {
        "never negative: a negative fit is refused"
    };
    sign.to_owned()
}

/// A text of the catalogue as a sentence: capital first, full stop last.
fn sentence(text: &str) -> String {
    let mut rest = text.chars();
    match rest.next() {
        Some(first) => format!("{}{}.", first.to_uppercase(), rest.as_str()),
        None => String::new(),
    }
}

/// Indented lines of at most [`WIDTH`] characters, each ended by a line break.
fn wrapped(text: &str) -> String {
    let (mut lines, mut line) = (String::new(), String::new());
    for word in text.split_whitespace() {
        let length = INDENT + line.chars().count() + 1 + word.chars().count();
        if !line.is_empty() && length > WIDTH {
            lines += &format!("{:INDENT$}{line}\n", "");
            line.clear();
        }
        if !line.is_empty() {
            line.push(' ');
        }
        line += word;
    }
    lines + &format!("{:INDENT$}{line}\n", "")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wrapping_keeps_every_word() {
        let text = "one two three ".repeat(40);
        let lines = wrapped(&text);
        assert!(lines.lines().all(|line| line.chars().count() <= WIDTH));
        assert!(lines.lines().count() > 1);
        assert_eq!(lines.split_whitespace().count(), 120);
        assert_eq!(sentence("the robot is late"), "The robot is late.");
    }
}
