//! The 37 faults at random moments of a contact, and days of bouncing, on the machine code of the Cortex-M7: judged as
//! on the host, and the same in every bit.

use softdock_app::settings::BoardSettings;
use softdock_control::delay::LawName;
use softdock_tests::contact::{KINDS, run_cases, soak_law};
use softdock_tests::lockstep::{Board, Twins};
use softdock_tests::process::each_in_its_own_process;
use std::time::Instant;

/// Cycles of an hour.
const HOUR: u64 = 900_000;

/// Boards of a test, each with a number.
fn boards(test: &'static str) -> impl FnMut(&BoardSettings) -> Box<dyn Board> {
    let mut count = 0;
    move |settings| {
        count += 1;
        Box::new(Twins::start(&format!("{test}_{count}"), settings))
    }
}

#[test]
fn some_faults_in_a_contact_move_nothing_that_they_should_not() {
    run_cases(0, 20, KINDS, &mut boards("qemu_contact"));
}

#[test]
#[ignore = "long: each of 37 faults in a contact in QEMU"]
fn no_fault_in_a_contact_moves_what_it_should_not() {
    let most = run_cases(0, 1, KINDS, &mut boards("qemu_contacts"));
    println!("{} contacts, energy at most {most:.4}", KINDS);
}

#[test]
#[ignore = "long: an hour of faults and operators in QEMU"]
fn an_hour_of_faults_and_operators() {
    let test = "qemu::contact::an_hour_of_faults_and_operators";
    each_in_its_own_process(test, &[LawName::Predictor], |law| {
        let began = Instant::now();
        soak_law(*law, HOUR, &mut boards("qemu_soak"));
        println!("{HOUR} cycles in {:.0} s", began.elapsed().as_secs_f64());
    });
}
