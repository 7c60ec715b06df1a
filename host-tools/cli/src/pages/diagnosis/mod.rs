//! The report of a diagnosis: one page that an engineer sends to a colleague.
//!
//! Sections without content are left out: a page about a model that misses nothing has no parameters, and one about an
//! unexplained error has no effects.

mod evidence;
mod findings;
mod focus;
mod parameters;
mod plots;
mod provenance;
mod words;

use anyhow::ensure;
use focus::Focus;
use softdock_analysis::diagnose::{Diagnosis, Verdict};
use softdock_physics::model::prediction::Prediction;
use softdock_report::{Mark, Page};

/// What a diagnosis was made from, so that a reader can repeat it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Identity {
    /// Model file.
    pub model_path: String,
    /// Text of the model with the named effects in it.
    pub model_toml: String,
    /// Recording that the effects were fitted on.
    pub train: String,
    /// Recording that the fit has not seen, if there is one.
    pub test: Option<String>,
    /// Firmware or program that made the judged recording; empty if the recording does not say.
    pub firmware: String,
    /// Settings of the board during the judged recording; empty if the recording has none.
    pub settings_toml: String,
}

impl Identity {
    /// The recording that the error is judged on.
    fn judged(&self) -> &str {
        self.test.as_ref().unwrap_or(&self.train)
    }
}

/// The report.
///
/// `before` is the prediction of the judged recording with the model as it was given, `after` that with the named effects.
/// The judged recording is the unseen one where there is one. Without named effects `after` is not shown.
///
/// # Errors
///
/// If the two predictions are not of the same recording, or a plot cannot be drawn.
pub fn page(
    diagnosis: &Diagnosis,
    before: &Prediction,
    after: &Prediction,
    identity: &Identity,
) -> anyhow::Result<Page> {
    ensure!(
        before.time_s == after.time_s,
        "the predictions before and after are of different recordings ({} and {} cycles); expected \
         two predictions of {}",
        before.time_s.len(),
        after.time_s.len(),
        identity.judged()
    );
    let source = Source {
        diagnosis,
        before,
        after: (!diagnosis.effects.is_empty()).then_some(after),
        identity,
    };
    let mut page = Page::new(format!("Diagnosis of {}", identity.judged()));
    let (mark, badge) = match diagnosis.verdict {
        Verdict::Named => (Mark::Neutral, "Named"),
        Verdict::NothingMissing => (Mark::Good, "Nothing missing"),
        Verdict::Unexplained => (Mark::Bad, "Unexplained"),
        Verdict::LogsDisagree => (Mark::Bad, "The logs disagree"),
        Verdict::NotTestable => (Mark::Bad, "Not testable"),
    };
    page.verdict(mark, badge, &diagnosis.sentence);
    source.error(&mut page)?;
    for focus in Focus::of(&source) {
        source.plots(&mut page, &focus)?;
    }
    source.ranking(&mut page)?;
    source.parameters(&mut page)?;
    source.rival(&mut page)?;
    source.regions(&mut page);
    source.hints(&mut page);
    source.noise(&mut page);
    source.provenance(&mut page);
    Ok(page)
}

/// Input of all sections.
struct Source<'a> {
    diagnosis: &'a Diagnosis,
    before: &'a Prediction,
    /// Prediction with the named effects; None without named effects.
    after: Option<&'a Prediction>,
    identity: &'a Identity,
}

impl Source<'_> {
    /// The prediction with the named effects, or without any that of the given model.
    fn best(&self) -> &Prediction {
        self.after.unwrap_or(self.before)
    }
}
