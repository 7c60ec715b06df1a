//! New settings for a board: all of them or none.

use super::client::ATTEMPTS;
use super::{Client, LinkError, OwnedValue, Setting, missing};
use anyhow::{Context, Result, bail, ensure};
use serde::Serialize;
use softdock_link::service::{Answer, Origin, Refusal, Request, SelfTest};
use std::time::{Duration, Instant};

/// Longest time for a board to start over.
const RESTART: Duration = Duration::from_secs(30);

/// A setting that is to change.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Difference {
    /// Its path.
    pub name: String,
    /// The value in use.
    pub board: OwnedValue,
    /// The value that it is to have.
    pub wanted: OwnedValue,
    /// Unit; empty: none.
    pub unit: String,
}

/// The settings of a board that are not as wanted.
///
/// # Errors
/// The board does not have one that is wanted.
pub fn differences(
    settings: &[Setting],
    wanted: &[(String, OwnedValue)],
) -> Result<Vec<Difference>> {
    let mut differences = Vec::new();
    for (name, value) in wanted {
        let Some(setting) = settings.iter().find(|setting| setting.name == *name) else {
            return Err(missing(name, settings));
        };
        if setting.value != *value {
            differences.push(Difference {
                name: name.clone(),
                board: setting.value.clone(),
                wanted: value.clone(),
                unit: setting.unit.clone(),
            });
        }
    }
    Ok(differences)
}

impl Client {
    /// Gives the board new settings: stages and checks them, commits them, waits until the board has
    /// started over with them, confirms, and reads them back. `tell` is told each step.
    ///
    /// # Errors
    /// Something was refused, or the line broke. Says which settings the board has then.
    pub fn change(
        &mut self,
        differences: &[Difference],
        confirm_within_s: u16,
        tell: &mut impl FnMut(&str),
    ) -> Result<()> {
        tell("checking");
        self.still()?;
        self.begin()?;
        let staged = self.stage(differences);
        self.or_give_up(staged)?;
        self.try_draft(confirm_within_s, tell)?;
        tell("reading back");
        for Difference { name, wanted, .. } in differences {
            let value = self.value(name)?;
            let expected = wanted.for_board();
            ensure!(
                value.for_board() == expected,
                "`{name}` is {value} after all, in place of {wanted}; nothing else was found wrong: try again"
            );
        }
        Ok(())
    }

    /// Goes back: ends a trial, or returns to the settings before those in use.
    ///
    /// # Errors
    /// As [`Self::change`]; or there are no settings before.
    pub fn roll_back(&mut self, confirm_within_s: u16, tell: &mut impl FnMut(&str)) -> Result<()> {
        self.still()?;
        if matches!(self.status()?.origin, Origin::Trial { .. }) {
            let boot = self.identity().boot;
            let ended = self.call(&Request::Abort, |answer| {
                // Done: the first answer was lost, and behind the restart there is nothing to end.
                matches!(answer, Answer::Restarting | Answer::Done).then_some(())
            });
            if !matches!(ended, Err(LinkError::Silent | LinkError::Garbled(_))) {
                ended?;
            }
            tell("the trial ends; the board starts over");
            return self.wait_for_restart(boot);
        }
        self.expect_done(&Request::Previous)?;
        self.try_draft(confirm_within_s, tell)
    }

    /// Has the board hang, and waits until its watchdog has started it over.
    ///
    /// # Errors
    /// It was refused, the line broke, or the board did not come back.
    pub fn hang(&mut self) -> Result<()> {
        let boot = self.identity().boot;
        let hangs = self.call(&Request::SelfTest(SelfTest::Hang), |answer| {
            (answer == Answer::Restarting).then_some(())
        });
        if !matches!(hangs, Err(LinkError::Silent | LinkError::Garbled(_))) {
            hangs?;
        }
        self.wait_for_restart(boot)
    }

    /// The value of a setting.
    ///
    /// # Errors
    /// As [`Self::call`].
    pub fn value(&mut self, name: &str) -> Result<OwnedValue, LinkError> {
        self.call(&Request::Get(name), |answer| match answer {
            // Rows do not matter to whoever compares.
            Answer::Value(value) => {
                Some(OwnedValue::new(&value, softdock_link::service::Form::Real))
            }
            _ => None,
        })
    }

    /// Refuses while the robot moves, as the board would refuse the change at its end.
    fn still(&mut self) -> Result<()> {
        match self.status()?.moves {
            true => Err(LinkError::Refused(Refusal::Moves)).context(UNCHANGED),
            false => Ok(()),
        }
    }

    /// Begins a new draft; refused while settings of another program are on trial.
    fn begin(&mut self) -> Result<()> {
        self.expect_done(&Request::Begin).context(UNCHANGED)
    }

    /// Changes the draft.
    fn stage(&mut self, differences: &[Difference]) -> Result<()> {
        for Difference { name, wanted, .. } in differences {
            let value = wanted.for_board();
            self.expect_done(&Request::Set { path: name, value })
                .with_context(|| format!("`{name}` = {wanted}"))
                .context(UNCHANGED)?;
        }
        Ok(())
    }

    /// Gives up a draft that was refused: it must not look like a change in progress.
    fn or_give_up(&mut self, staged: Result<()>) -> Result<()> {
        if staged.is_err() {
            // What the line says now adds nothing to what was refused.
            drop(self.expect_done(&Request::Abort));
        }
        staged
    }

    /// Validates, commits, waits and confirms.
    fn try_draft(&mut self, confirm_within_s: u16, tell: &mut impl FnMut(&str)) -> Result<()> {
        let valid = self.expect_done(&Request::Validate).context(UNCHANGED);
        self.or_give_up(valid.map(drop))?;
        let boot = self.identity().boot;
        tell("writing");
        let request = Request::Commit { confirm_within_s };
        let committed = self.call(&request, |answer| {
            (answer == Answer::Restarting).then_some(())
        });
        match committed {
            // The answer may be what was lost: whether the board starts over will tell.
            Ok(()) | Err(LinkError::Silent | LinkError::Garbled(_)) => {}
            // So it is when the same request came again behind the restart, which ended the conversation.
            Err(LinkError::Refused(Refusal::NoConversation)) => {}
            Err(error @ LinkError::Refused(_)) => return Err(error).context(UNCHANGED),
            Err(error) => return Err(error).context(on_trial(confirm_within_s)),
        }
        tell("the board starts over with the new settings");
        self.wait_for_restart(boot)
            .with_context(|| on_trial(confirm_within_s))?;
        let status = self.status().with_context(|| on_trial(confirm_within_s))?;
        if !matches!(status.origin, Origin::Trial { .. }) {
            bail!("the board started over without the new settings: it has its old ones");
        }
        tell("confirming");
        self.confirm().with_context(|| on_trial(confirm_within_s))
    }

    /// Keeps the settings that are on trial.
    fn confirm(&mut self) -> Result<(), LinkError> {
        let boot = self.identity().boot;
        match self.expect_done(&Request::Confirm) {
            Err(error @ LinkError::Refused(Refusal::NotOnTrial)) => {
                self.hello(ATTEMPTS)?;
                // In the same boot it was confirmed already, and the first answer was lost; in
                // another one the time was over.
                (self.identity().boot == boot).then_some(()).ok_or(error)
            }
            other => other,
        }
    }

    /// Waits until the board has another number of its boot.
    fn wait_for_restart(&mut self, boot: u32) -> Result<()> {
        let give_up = Instant::now() + RESTART;
        while Instant::now() < give_up {
            match self.hello(1) {
                Ok(()) if self.identity().boot != boot => return Ok(()),
                Ok(()) => std::thread::sleep(Duration::from_millis(50)),
                Err(LinkError::Silent | LinkError::Garbled(_)) => {}
                Err(error) => return Err(error.into()),
            }
        }
        bail!(
            "the board did not start over within {} s",
            RESTART.as_secs()
        )
    }
}

const UNCHANGED: &str = "the board's settings are as they were";

fn on_trial(seconds: u16) -> String {
    format!(
        "the new settings were not confirmed: the board has its old ones, or goes back to them by itself within {seconds} s (`softdock params status` tells)"
    )
}
