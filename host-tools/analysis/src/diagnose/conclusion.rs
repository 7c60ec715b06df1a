//! The answer of a diagnosis: that of the stages, or another one that they do not tell from it and that predicts the machine better.

use super::answer::outcome::{Outcome, conclude};
use super::evidence::{DRIVES_AWAY, RUNS_OFF};
use super::finding::Verdict;
use super::logs::Logs;
use super::prediction_error::for_prediction::{Errors, better_ties};
use super::prediction_error::foresight::Foresight;
use super::question::Question;
use super::stages::{self, Stages, accepted};
use crate::compare::sentence::listed;
use softdock_io::recording::Recording;
use softdock_physics::model::Model;
use softdock_report::number;

/// What is asked, and of which logs.
pub(super) struct Asking<'a> {
    /// The model that was given.
    pub model: &'a Model,
    /// The logs of the fit and the unseen ones.
    pub recordings: &'a Logs<&'a Recording>,
    /// Whether the unseen logs are logs of their own, and not the ends of the others.
    pub unseen: bool,
    /// What is asked of the stages.
    pub question: &'a Question<'a>,
}

impl<'a> Asking<'a> {
    /// Runs the stages and draws the conclusion, then tries what may take its place: each tie, and the answer without what drives
    /// its motion away. Not where logs disagree, as none of these foretells another, nor where a user says what to try.
    ///
    /// # Errors
    ///
    /// Logs that cannot be predicted.
    pub(super) fn concluded(
        &self,
        progress: &dyn Fn(f64, &str),
    ) -> anyhow::Result<(Stages, Outcome)> {
        let stages = stages::run(self.model, self.recordings, self.question, progress)?;
        progress(0.95, "drawing the conclusion");
        let outcome = self.conclude(&stages)?;
        let disagree = outcome.diagnosis.verdict == Verdict::LogsDisagree;
        if disagree || self.question.is_asked() || self.question.among.is_some() {
            return Ok((stages, outcome));
        }
        let answer = self.or_a_tie((stages, outcome), progress)?;
        self.or_one_that_stays(answer, progress)
    }

    /// The answer, or the first tie that is [better](Foresight::is_better_than), searched among its own effects.
    fn or_a_tie(
        &self,
        answer: (Stages, Outcome),
        progress: &dyn Fn(f64, &str),
    ) -> anyhow::Result<(Stages, Outcome)> {
        let (stages, outcome) = &answer;
        let ties = better_ties(self.model, self.recordings, stages)?;
        let explains = |outcome: &Outcome| outcome.diagnosis.verdict == Verdict::Named;
        for (tried, ids) in ties.iter().enumerate() {
            let (tried, all) = (tried + 1, ties.len());
            progress(
                0.95,
                &format!("searching what is not told apart, {tried} of {all}"),
            );
            let among = Question {
                among: Some(ids),
                ..*self.question
            };
            let mut other_stages = stages::run(self.model, self.recordings, &among, &|_, _| {})?;
            if let (Some(wrench), Some(tried)) = (&mut other_stages.wrench, &stages.wrench) {
                wrench.remember(tried);
            }
            let other = self.conclude(&other_stages)?;
            let [now, then] = [outcome, &other].map(|one| self.foresight(one));
            // A tie whose simulated motion is better may not take a name away unless its error at each instant is smaller, too.
            let may = explains(&other) || !explains(outcome) || then.foretells_better_than(&now);
            if may && then.is_better_than(&now) {
                return Ok((other_stages, other));
            }
        }
        Ok(answer)
    }

    /// The answer, or, if its simulated motion runs off, the one without effects that act by position, if its own
    /// [stays](Foresight::stays_where_runs_off).
    /// The conclusion of the latter is not drawn if its error is far larger.
    fn or_one_that_stays(
        &self,
        answer: (Stages, Outcome),
        progress: &dyn Fn(f64, &str),
    ) -> anyhow::Result<(Stages, Outcome)> {
        /// Ratio of the errors on unseen data beyond which the conclusion of the other answer is not drawn: least squares, which lower
        /// its error there, do not bring it to [`DRIVES_AWAY`]. Set by hand.
        const HOPELESS: f64 = 1.7 * DRIVES_AWAY;
        let named = &answer.1.diagnosis.effects;
        let turns = self.model.bearing().is_some();
        let acts_by_position = |id: &&String| {
            let effect = self.model.effect(id);
            effect.is_ok_and(|effect| effect.acts_by_position(turns))
        };
        let by_position: Vec<String> = named.iter().filter(acts_by_position).cloned().collect();
        let runs_off = || {
            self.foresight(&answer.1)
                .off_by()
                .is_some_and(|off| off > RUNS_OFF)
        };
        if by_position.is_empty() || !runs_off() {
            return Ok(answer);
        }
        progress(0.95, "searching what does not drive the motion away");
        let excluded = self.question.also_without(&by_position);
        let without = Question {
            without: &excluded,
            ..*self.question
        };
        let stages = stages::run(self.model, self.recordings, &without, &|_, _| {})?;
        let found = Errors::of(
            self.model,
            self.recordings,
            &accepted::all(self.model, &stages),
        )?;
        let answered = Errors::of_predictions(&answer.1.predictions);
        if found.unseen > HOPELESS * answered.unseen {
            return Ok(answer);
        }
        let mut other = self.conclude(&stages)?;
        let [now, then] = [&answer.1, &other].map(|one| self.foresight(one));
        let disagree = other.diagnosis.verdict == Verdict::LogsDisagree;
        if disagree || !then.stays_where_runs_off(&now) {
            return Ok(answer);
        }
        let digits = |value: f64| number::significant(value, 3);
        let [with, less] = [&now, &then].map(|one| digits(one.unseen()));
        let [off, closer] = [&now, &then].map(|one| digits(one.off_by().unwrap_or(f64::NAN)));
        let note = format!(
            "Not named: {}. With it the error on unseen data is {with} instead of {less}, but simulated forward the motion is off by {off} \
             times itself instead of {closer}. A controller that makes the command from the position looks like such a force.",
            listed(&by_position)
        );
        other.diagnosis.notes.push(note);
        Ok((stages, other))
    }

    fn conclude(&self, stages: &Stages) -> anyhow::Result<Outcome> {
        conclude(
            self.model,
            self.recordings,
            stages,
            self.unseen,
            self.question,
        )
    }

    fn foresight<'b>(&'b self, outcome: &'b Outcome) -> Foresight<'b> {
        let errors = Errors::of_predictions(&outcome.predictions);
        Foresight::new(&outcome.after, errors, self.recordings.test())
    }
}
