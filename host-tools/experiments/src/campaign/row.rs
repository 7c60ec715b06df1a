//! One row: a run under the conditions of its index.

use super::outcome::{Observer, Outcome, Status};
use super::plan::{Conditions, Plan};
use crate::run::run;
use crate::scenario::Scenario;
use std::ops::ControlFlow;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// Computes a row. Errors and panics become outcomes.
pub fn execute(plan: &Plan, index: u64) -> Outcome {
    if let Some(bench) = plan.campaign.bench {
        let Conditions { seed, values } = plan.conditions(index);
        return guarded(|| bench.execute(seed, &values));
    }
    guarded(|| match plan.scenario(index) {
        Ok(scenario) => outcome(&scenario),
        Err(error) => Outcome::failure(Status::Refused, format!("{error:#}")),
    })
}

fn outcome(scenario: &Scenario) -> Outcome {
    let mut observer = Observer::new(scenario);
    let ran = run(scenario, &mut |record, truth| {
        observer.push(record, truth);
        ControlFlow::Continue(())
    });
    match ran {
        Ok(statistics) => observer.finish(&statistics),
        Err(error) => Outcome::failure(Status::Failed, format!("{error:#}")),
    }
}

/// Runs `row`; a panic becomes an outcome.
fn guarded(row: impl FnOnce() -> Outcome) -> Outcome {
    // Unwind safe: all state of the run is dropped with the row.
    catch_unwind(AssertUnwindSafe(row)).unwrap_or_else(|panic| {
        let text = panic.downcast_ref::<String>().map(String::as_str);
        let text = text.or_else(|| panic.downcast_ref::<&str>().copied());
        let reason = text.unwrap_or("no reason was given");
        Outcome::failure(Status::Panicked, reason.to_owned())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_is_a_row_with_its_reason() {
        let outcome = guarded(|| panic!("index {} out of range", 7));
        assert_eq!(outcome.status, Status::Panicked);
        assert_eq!(outcome.reason.as_deref(), Some("index 7 out of range"));
    }
}
