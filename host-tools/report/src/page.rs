//! The page: one HTML file that is complete in itself.

use super::charts::{self, BarChart, Interval};
use super::plot::Plot;
use super::table::{Mark, Table};
use super::text::escape;
use super::theme;
use anyhow::Result;

/// Layout of the page; the colours come from [`theme::css`].
const LAYOUT: &str = include_str!("page.css");

/// Size of each of the small plots that stand side by side, without title and legend, in pixels.
const SMALL_PLOT_PX: (u32, u32) = (430, 225);

/// A report, filled from top to bottom. All texts are escaped; nothing in a page refers to anything outside.
#[derive(Clone, Debug)]
pub struct Page {
    title: String,
    body: String,
    identity: String,
}

impl Page {
    /// A page with nothing but its title.
    pub fn new(title: impl Into<String>) -> Self {
        Self {
            title: title.into(),
            body: String::new(),
            identity: String::new(),
        }
    }

    /// The headline: one sentence that sums the report up.
    pub fn headline(&mut self, sentence: &str) -> &mut Self {
        self.element("p class=\"headline\"", sentence)
    }

    /// The headline with a short verdict in a coloured badge.
    pub fn verdict(&mut self, mark: Mark, badge: &str, sentence: &str) -> &mut Self {
        let (class, badge, sentence) = (mark.class(), escape(badge), escape(sentence));
        self.push(&format!(
            "<p class=\"headline verdict-{class}\"><strong class=\"badge\">{badge}</strong> {sentence}</p>\n"
        ))
    }

    /// Starts a section.
    pub fn section(&mut self, title: &str) -> &mut Self {
        self.element("h2", title)
    }

    /// A paragraph of text.
    pub fn paragraph(&mut self, text: &str) -> &mut Self {
        self.element("p", text)
    }

    /// Paragraphs or short remarks of equal rank, one below the other.
    pub fn list(&mut self, items: &[String]) -> &mut Self {
        self.push("<ul>\n");
        for item in items {
            self.element("li", item);
        }
        self.push("</ul>\n")
    }

    /// Text to copy, as a command.
    pub fn code(&mut self, text: &str) -> &mut Self {
        self.element("pre class=\"code\"", text)
    }

    /// A table; wider ones than the page scroll.
    pub fn table(&mut self, table: &Table) -> &mut Self {
        let table = table.to_html();
        self.push(&format!("<div class=\"scroll\">\n{table}</div>\n"))
    }

    /// A plot.
    ///
    /// # Errors
    ///
    /// As [`Plot::to_svg`].
    pub fn plot(&mut self, plot: &Plot) -> Result<&mut Self> {
        Ok(self.figure(&plot.to_svg()?))
    }

    /// Small plots side by side, for the same quantity in several axes, runs or regimes. Their sizes are ignored.
    ///
    /// # Errors
    ///
    /// As [`Plot::to_svg`].
    pub fn columns(&mut self, plots: &[Plot]) -> Result<&mut Self> {
        self.push("<div class=\"columns\">\n");
        for plot in plots {
            self.figure(&plot.to_svg_sized(SMALL_PLOT_PX)?);
        }
        Ok(self.push("</div>\n"))
    }

    /// A bar chart or a waterfall.
    ///
    /// # Errors
    ///
    /// As [`BarChart::to_svg`].
    pub fn bars(&mut self, chart: &BarChart) -> Result<&mut Self> {
        Ok(self.figure(&chart.to_svg()?))
    }

    /// Intervals around estimates of different units, each drawn relative to its own value.
    ///
    /// # Errors
    ///
    /// As [`BarChart::to_svg`].
    pub fn intervals(&mut self, title: &str, intervals: &[Interval]) -> Result<&mut Self> {
        Ok(self.figure(&charts::intervals(title, intervals)?))
    }

    /// Intervals around estimates of one unit, which may be near zero.
    ///
    /// # Errors
    ///
    /// As [`BarChart::to_svg`].
    pub fn intervals_in(
        &mut self,
        title: &str,
        unit: &str,
        intervals: &[Interval],
    ) -> Result<&mut Self> {
        Ok(self.figure(&charts::intervals_in(title, unit, intervals)?))
    }

    /// Preformatted text that is folded away until the reader opens it, such as all settings of a run.
    pub fn details(&mut self, summary: &str, text: &str) -> &mut Self {
        self.push(&format!(
            "<details>\n<summary>{}</summary>\n<pre>{}</pre>\n</details>\n",
            escape(summary),
            escape(text)
        ))
    }

    /// Version and identity of the program that made the page, for its foot.
    pub fn identity(&mut self, identity: &str) -> &mut Self {
        identity.clone_into(&mut self.identity);
        self
    }

    /// The complete HTML document, which is also well-formed XML.
    pub fn to_html(&self) -> String {
        // The policy makes a browser refuse every outside address, should one ever slip in.
        format!(
            "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n\
             <meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; style-src 'unsafe-inline'\"/>\n\
             <title>{title}</title>\n<style>\n{colors}{LAYOUT}</style>\n</head>\n<body>\n<main>\n<h1>{title}</h1>\n\
             {body}</main>\n<footer>{identity}</footer>\n</body>\n</html>\n",
            title = escape(&self.title),
            colors = theme::css(),
            body = self.body,
            identity = escape(&self.identity),
        )
    }

    fn push(&mut self, html: &str) -> &mut Self {
        self.body.push_str(html);
        self
    }

    fn figure(&mut self, svg: &str) -> &mut Self {
        self.push(&format!("<figure>\n{svg}</figure>\n"))
    }

    /// An element with `text` as its content; `open` is the tag's name and its attributes.
    fn element(&mut self, open: &str, text: &str) -> &mut Self {
        let name = open.split(' ').next().unwrap_or(open);
        self.push(&format!("<{open}>{}</{name}>\n", escape(text)))
    }
}
