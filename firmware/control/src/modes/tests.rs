use super::*;

#[test]
fn a_fault_is_left_only_by_reset_with_healthy_data() {
    let mut modes = Modes::default();
    modes.latch(Fault::new(FaultCode::Overload, 1.0, 2.0));
    for (word, command) in Command::WORDS {
        if command != Command::Reset {
            assert_eq!(
                modes.command(command, Ok(())),
                Err(Refusal::WrongMode),
                "{word}"
            );
        }
    }
    let stale = Err(Refusal::SensorStale);
    assert_eq!(modes.command(Command::Reset, stale), stale);
    modes.latch(Fault::new(FaultCode::Numeric, 0.0, 0.0));
    assert_eq!(modes.fault().map(|f| f.code), Some(FaultCode::Overload));
    assert_eq!(modes.command(Command::Reset, Ok(())), Ok(()));
    assert_eq!((modes.mode(), modes.fault()), (Mode::Hold, None));
}

#[test]
fn running_is_reached_only_through_hold_and_arm() {
    let mut modes = Modes::default();
    assert_eq!(
        modes.command(Command::Start, Ok(())),
        Err(Refusal::WrongMode)
    );
    assert_eq!(modes.command(Command::Arm, Ok(())), Err(Refusal::WrongMode));
    assert!(modes.command(Command::Hold, Err(Refusal::NoPose)).is_ok());
    assert_eq!(
        modes.command(Command::Arm, Err(Refusal::NoPose)),
        Err(Refusal::NoPose)
    );
    assert!(modes.command(Command::Arm, Ok(())).is_ok());
    assert!(modes.command(Command::Start, Ok(())).is_ok());
    assert_eq!(modes.mode(), Mode::Running);
}

/// Each command in each mode, with data that allow it and data that do not: the table of docs/modes.md without events.
#[test]
fn each_command_leads_where_the_table_says() {
    use Mode::{Armed, Fault, Hold, Idle, Jogging, Running};
    let led = |mode, command| {
        let fault = None;
        let mut modes = Modes { mode, fault };
        let outcome = modes.command(command, Ok(()));
        let mut unfit = Modes { mode, fault };
        let refused = unfit.command(command, Err(Refusal::SensorStale));
        let needs_nothing = matches!(command, Command::Hold | Command::Stop);
        if outcome.is_ok() && !needs_nothing {
            assert_eq!((refused, unfit.mode), (Err(Refusal::SensorStale), mode));
        } else {
            assert_eq!((refused, unfit.mode), (outcome, modes.mode));
        }
        outcome.is_ok().then_some(modes.mode)
    };
    let jog = Command::Jog(Jog::Y);
    let table = [
        (Idle, [Some(Hold), None, None, None, None, None, None]),
        (
            Hold,
            [
                Some(Hold),
                Some(Armed),
                None,
                Some(Hold),
                None,
                Some(Hold),
                Some(Jogging),
            ],
        ),
        (
            Armed,
            [
                Some(Hold),
                None,
                Some(Running),
                Some(Hold),
                None,
                None,
                None,
            ],
        ),
        (
            Running,
            [Some(Hold), None, None, Some(Hold), None, None, None],
        ),
        (
            Jogging,
            [Some(Hold), None, None, Some(Hold), None, None, None],
        ),
        (Fault, [None, None, None, None, Some(Hold), None, None]),
    ];
    for (mode, row) in table {
        let [hold, arm, start, stop, reset, zero, jogs] = row;
        assert_eq!(led(mode, Command::Hold), hold, "{mode:?}");
        assert_eq!(led(mode, Command::Arm), arm, "{mode:?}");
        assert_eq!(led(mode, Command::Start), start, "{mode:?}");
        assert_eq!(led(mode, Command::Stop), stop, "{mode:?}");
        assert_eq!(led(mode, Command::Reset), reset, "{mode:?}");
        assert_eq!(led(mode, Command::Zero), zero, "{mode:?}");
        assert_eq!(led(mode, jog), jogs, "{mode:?}");
        assert_eq!(mode.moves(), matches!(mode, Running | Jogging));
        let mut modes = Modes { mode, fault: None };
        modes.end_jog();
        assert_eq!(modes.mode, if mode == Jogging { Hold } else { mode });
    }
}

#[test]
fn a_command_is_found_by_its_word_and_by_nothing_else() {
    for (word, command) in Command::WORDS {
        assert_eq!(Command::from_word(word), Some(command));
        assert_eq!(Command::from_word(&word.to_uppercase()), None);
    }
    assert_eq!(Command::from_word(""), None);
}

#[test]
fn a_command_is_told_by_the_word_that_an_operator_types() {
    let mut told = Vec::new();
    for (typed, command) in Command::WORDS {
        let word = command.word();
        assert_eq!(word, typed);
        assert!(!word.is_empty() && !told.contains(&word), "{command:?}");
        told.push(word);
    }
    assert_eq!(Command::Arm.word(), "arm");
    assert_eq!(Command::Jog(Jog::MinusC).word(), "jog -c");
}
