//! One of 37 faults at a random moment of a contact, and days of them. See [`softdock_tests::contact`].

use softdock_app::settings::BoardSettings;
use softdock_control::delay::LawName;
use softdock_lockstep::Session;
use softdock_tests::contact::{KINDS, run_cases, soak_law};
use softdock_tests::lockstep::Board;
use softdock_tests::process::each_in_its_own_process;
use std::thread;

/// Cycles of an hour.
const HOUR: u64 = 900_000;

fn host(settings: &BoardSettings) -> Box<dyn Board> {
    Box::new(Session::<f64>::new(settings).unwrap())
}

fn campaign(count: usize) {
    thread::scope(|scope| {
        let run = |first| move || run_cases(first, 2, count, &mut host);
        let workers = [0, 1].map(|first| scope.spawn(run(first)));
        let most = workers.map(|worker| worker.join().unwrap());
        println!(
            "{count} contacts, energy at most {:.4}",
            most[0].max(most[1])
        );
    });
}

#[test]
fn no_fault_in_a_contact_moves_what_it_should_not() {
    campaign(3 * KINDS);
}

#[test]
#[ignore = "long: 10,000 contacts with a fault"]
fn no_fault_in_any_of_10_000_contacts_moves_what_it_should_not() {
    campaign(10_000);
}

/// All laws, so many cycles in all.
fn soak(test: &str, cycles: u64) {
    let each = cycles / LawName::ALL.len() as u64;
    each_in_its_own_process(test, &LawName::ALL, |law| soak_law(*law, each, &mut host));
}

#[test]
fn two_minutes_of_faults_and_operators() {
    let test = "faults::contact::two_minutes_of_faults_and_operators";
    soak(test, HOUR * 2 / 60);
}

#[test]
#[ignore = "long: a day of faults and operators in virtual time"]
fn a_day_of_faults_and_operators() {
    let test = "faults::contact::a_day_of_faults_and_operators";
    soak(test, 24 * HOUR);
}
