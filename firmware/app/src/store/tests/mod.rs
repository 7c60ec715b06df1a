pub(crate) mod flash;

use super::*;
use embassy_futures::block_on;
use embedded_storage_async::nor_flash::NorFlashErrorKind;
use flash::{Flash, SLOT, TORN, Torn};

const NEW: Block = [0; IMAGE_MAX_BYTES];

fn with_mass(mass_kg: f64) -> BoardSettings {
    let mut settings = BoardSettings::default();
    settings.control.body_k.mass_kg = mass_kg;
    settings
}

fn boot(flash: &mut Flash, trial: Option<Trial>) -> Boot {
    block_on(Store::new(flash).boot(trial, &mut NEW.clone()))
}

fn write(flash: &mut Flash, mass_kg: f64, in_use: &Origin) -> Result<Trial, StoreError> {
    let settings = with_mass(mass_kg);
    block_on(Store::new(flash).write(&settings, in_use, 60, &mut NEW.clone()))
}

fn confirm(flash: &mut Flash, trial: &Trial) -> Result<Origin, StoreError> {
    block_on(Store::new(flash).confirm(trial, &mut NEW.clone()))
}

fn mass(boot: &Boot) -> f64 {
    boot.settings.control.body_k.mass_kg
}

/// Writes and keeps a set.
fn change(flash: &mut Flash, mass_kg: f64) -> Origin {
    let in_use = boot(flash, None).origin;
    let trial = write(flash, mass_kg, &in_use).unwrap();
    confirm(flash, &trial).unwrap()
}

#[test]
fn an_empty_flash_gives_defaults_and_says_so() {
    let boot = boot(&mut Flash::erased(), None);
    assert_eq!(boot.settings, BoardSettings::default());
    assert_eq!(boot.origin, Origin::Defaults(ImageError::Absent));
}

#[test]
fn a_trial_counts_for_one_start_and_kept_settings_for_ever() {
    let mut flash = Flash::erased();
    let first = change(&mut flash, 11.0);
    assert_eq!(boot(&mut flash, None).origin, first);
    let trial = write(&mut flash, 22.0, &first).unwrap();
    let tried = boot(&mut flash, Some(trial));
    assert_eq!((mass(&tried), tried.origin), (22.0, Origin::Trial(trial)));
    // Nobody confirms: a loss of power, or a second start.
    let after = boot(&mut flash, None);
    assert_eq!((mass(&after), after.origin), (11.0, first));
    // Confirmed it stays.
    let second = confirm(&mut flash, &trial).unwrap();
    let after = boot(&mut flash, None);
    assert_eq!((mass(&after), after.origin), (22.0, second));
    let previous = block_on(Store::new(&mut flash).previous(&second, &mut NEW.clone()));
    assert_eq!(previous, Some(with_mass(11.0)));
}

#[test]
fn sets_take_turns_in_the_two_slots() {
    let mut flash = Flash::erased();
    for n in 1..=5_u32 {
        let expected = Origin::Flash {
            sequence: n,
            slot: [Slot::B, Slot::A][n as usize % 2],
        };
        assert_eq!(change(&mut flash, f64::from(n)), expected);
        assert_eq!(mass(&boot(&mut flash, None)), f64::from(n));
    }
}

/// Settings written by a launcher or a probe count without a confirmation.
#[test]
fn a_block_by_itself_is_used_and_followed() {
    let mut flash = Flash::erased();
    let settings = with_mass(7.0);
    let mut block = vec![0xff; IMAGE_MAX_BYTES];
    let sequence = u32::MAX;
    Image { sequence, settings }.encode(&mut block).unwrap();
    flash.put(0, &block);
    assert_eq!(mass(&boot(&mut flash, None)), 7.0);
    let next = change(&mut flash, 8.0);
    let (sequence, slot) = (0, Slot::B);
    assert_eq!(next, Origin::Flash { sequence, slot });
    assert_eq!(mass(&boot(&mut flash, None)), 8.0);
}

#[test]
fn settings_of_another_firmware_are_refused_by_name_and_left_alone() {
    let mut flash = Flash::erased();
    let settings = with_mass(7.0);
    let mut block = vec![0xff; IMAGE_MAX_BYTES];
    let sequence = 3;
    let length = Image { sequence, settings }.encode(&mut block).unwrap();
    block[5] ^= 1;
    let body = length - 4;
    let checksum = crate::checksum::CHECKSUM.checksum(&block[..body]);
    block[body..length].copy_from_slice(&checksum.to_le_bytes());
    flash.put(0, &block);
    let Origin::Defaults(error @ ImageError::Schema { .. }) = boot(&mut flash, None).origin else {
        panic!("settings of another form were used");
    };
    assert!(error.to_string().contains("of another firmware"), "{error}");
    let (sequence, slot) = (1, Slot::B);
    assert_eq!(change(&mut flash, 5.0), Origin::Flash { sequence, slot });
    assert_eq!(mass(&boot(&mut flash, None)), 5.0);
    // Also after an unconfirmed trial, which is overwritten.
    let mut flash = Flash::erased();
    flash.put(SLOT, &block);
    let defaults = boot(&mut flash, None).origin;
    for trial in [1.0, 2.0] {
        assert_eq!(write(&mut flash, trial, &defaults).unwrap().slot, Slot::A);
    }
}

#[test]
fn a_second_trial_waits_for_the_first() {
    let mut flash = Flash::erased();
    let trial = write(&mut flash, 1.0, &Origin::Defaults(ImageError::Absent)).unwrap();
    let again = write(&mut flash, 2.0, &Origin::Trial(trial));
    assert_eq!(again, Err(StoreError::OnTrial));
}

#[test]
fn settings_that_may_not_be_used_are_not_written() {
    let mut flash = Flash::erased();
    let first = change(&mut flash, 11.0);
    let done = flash.done;
    let refused = write(&mut flash, -1.0, &first);
    assert!(matches!(
        refused,
        Err(StoreError::Image(ImageError::Settings(_)))
    ));
    assert_eq!(flash.done, done);
}

#[test]
fn a_trial_whose_block_was_damaged_is_not_tried() {
    let mut flash = Flash::erased();
    let first = change(&mut flash, 11.0);
    let trial = write(&mut flash, 22.0, &first).unwrap();
    flash.flip(SLOT + 200);
    assert_eq!(mass(&boot(&mut flash, Some(trial))), 11.0);
    assert!(confirm(&mut flash, &trial).is_err());
    assert_eq!(mass(&boot(&mut flash, None)), 11.0);
}

/// A cell that does not hold its bit, anywhere in the block: no trial begins.
#[test]
fn what_does_not_come_back_from_the_flash_is_not_tried() {
    let mut before = Flash::erased();
    let first = change(&mut before, 11.0);
    let mut written = before.clone();
    let trial = write(&mut written, 22.0, &first).unwrap();
    let mut block = NEW;
    let settings = with_mass(22.0);
    let length = Image::encode_on_trial(trial.sequence, &settings, &mut block).unwrap();
    for at in (0..length).filter(|at| block[*at] & 1 != 0) {
        let mut flash = before.clone();
        flash.worn = Some(SLOT + at);
        assert!(write(&mut flash, 22.0, &first).is_err(), "byte {at}");
        assert_eq!(mass(&boot(&mut flash, None)), 11.0);
    }
}

/// The content is valid, but not what was to be written.
#[test]
fn a_flash_that_does_nothing_is_noticed() {
    let mut flash = Flash::erased();
    let first = change(&mut flash, 11.0);
    write(&mut flash, 5.0, &first).unwrap();
    flash.deaf = true;
    // The same settings as before, with another number.
    let Origin::Flash { sequence, slot } = first else {
        panic!("{first:?}");
    };
    let later = Origin::Flash {
        sequence: sequence + 8,
        slot,
    };
    for (mass_kg, in_use) in [(22.0, first), (5.0, later)] {
        let outcome = write(&mut flash, mass_kg, &in_use);
        assert_eq!(outcome, Err(StoreError::ReadBack), "{mass_kg}");
    }
    assert_eq!(mass(&boot(&mut flash, None)), 11.0);
}

/// A valid word of another block, which was there before and survived an erasure.
#[test]
fn a_confirmation_keeps_its_own_block_and_no_other() {
    let mut flash = Flash::erased();
    let first = change(&mut flash, 11.0);
    let trial = write(&mut flash, 22.0, &first).unwrap();
    let Trial {
        sequence, checksum, ..
    } = trial;
    let kept = |word: [u8; WORD_BYTES]| {
        let mut flash = flash.clone();
        flash.put(SLOT + IMAGE_MAX_BYTES, &word);
        mass(&boot(&mut flash, None))
    };
    assert_eq!(kept(confirmation::word(sequence, checksum)), 22.0);
    assert_eq!(kept(confirmation::word(sequence - 1, checksum)), 11.0);
    assert_eq!(kept(confirmation::word(sequence, checksum ^ 1)), 11.0);
    let mut damaged = confirmation::word(sequence, checksum);
    damaged[WORD_BYTES - 1] = 0;
    assert_eq!(kept(damaged), 11.0);
}

/// Writes and confirms 22 over 11 with a power loss after this many words. Returns the flash, and whether the board reported
/// success.
fn cut(mut flash: Flash, words: usize, torn: Torn) -> (Flash, bool) {
    flash.power = Some((words, torn));
    let in_use = boot(&mut flash, None).origin;
    let outcome = write(&mut flash, 22.0, &in_use).and_then(|trial| confirm(&mut flash, &trial));
    flash.power = None;
    (flash, outcome.is_ok())
}

/// Power is lost at every single word that is erased or written, with every kind of remains: the next start has the old or the
/// new set, intact, and a later change works.
#[test]
fn a_loss_of_power_leaves_the_old_or_the_new_set() {
    let mut before = Flash::erased();
    change(&mut before, 5.0);
    change(&mut before, 11.0);
    let mut all = before.clone();
    change(&mut all, 22.0);
    let words = all.done - before.done;
    assert!(words > SLOT / flash::WORD + 40, "{words}");
    let survive = |torn: Torn| {
        let (mut old, mut new) = (0, 0);
        for at in 0..words {
            let (mut after, done) = cut(before.clone(), at, torn);
            assert!(!done, "word {at}: power was lost");
            let boot = boot(&mut after, None);
            assert!(
                matches!(boot.origin, Origin::Flash { .. }),
                "word {at}, {torn:?}: {:?}",
                boot.origin
            );
            match mass(&boot) {
                11.0 => old += 1,
                22.0 => new += 1,
                other => panic!("word {at}, {torn:?}: neither the old nor the new set: {other}"),
            }
            change(&mut after, 33.0);
            assert_eq!(mass(&super::tests::boot(&mut after, None)), 33.0);
        }
        (old, new)
    };
    let (mut old, mut new) = (0, 0);
    std::thread::scope(|threads| {
        for thread in TORN.map(|torn| threads.spawn(move || survive(torn))) {
            let of_one = thread.join().unwrap();
            old += of_one.0;
            new += of_one.1;
        }
    });
    // Only the last word, the confirmation, makes it new, if all of it was written.
    assert_eq!((old, new), (4 * words - 1, 1));
    assert!(cut(before, words, Torn::Old).1);
}

/// The same when a set was tried before and dropped: it never comes back by itself.
#[test]
fn a_set_that_was_given_up_does_not_come_back() {
    let mut before = Flash::erased();
    let first = change(&mut before, 11.0);
    write(&mut before, 5.0, &first).unwrap();
    let mut all = before.clone();
    change(&mut all, 22.0);
    for at in 0..all.done - before.done {
        for torn in TORN {
            let (mut after, _) = cut(before.clone(), at, torn);
            let mass = mass(&boot(&mut after, None));
            assert!(mass == 11.0 || mass == 22.0, "word {at}, {torn:?}: {mass}");
        }
    }
}

/// Flash that was not erased is not written a second time.
#[test]
fn a_word_that_cannot_be_written_is_an_error() {
    let mut flash = Flash::erased();
    let first = change(&mut flash, 11.0);
    let trial = write(&mut flash, 22.0, &first).unwrap();
    assert!(confirm(&mut flash, &trial).is_ok());
    let again = Err(StoreError::Image(ImageError::Absent));
    let stale = Trial {
        sequence: trial.sequence + 1,
        ..trial
    };
    assert_eq!(confirm(&mut flash, &stale), again);
    let again = Err(StoreError::Flash(NorFlashErrorKind::Other));
    assert_eq!(confirm(&mut flash, &trial), again);
    assert_eq!(mass(&boot(&mut flash, None)), 22.0);
}
