//! Damaged telegrams: an error, never a panic, never a wrong value.

use proptest::prelude::*;
use softdock_link::decimal::Decimal;
use softdock_link::rsi::{
    SEN_MAX_BYTES, SenTelegram, Tags, parse_rob, parse_sen, salvage_ipoc, write_sen,
};

use crate::known::{RSIPI, tags};
use crate::layout::telegram;

#[test]
fn a_telegram_that_is_cut_off_anywhere_is_an_error() {
    for len in 0..RSIPI.len() {
        let cut = &RSIPI.as_bytes()[..len];
        assert!(parse_rob(cut, &tags()).is_err(), "{len} bytes");
        let whole = len >= RSIPI.len() - "</Rob>".len();
        let expected = whole.then_some(123_645_634_563);
        assert_eq!(salvage_ipoc(cut), expected, "{len} bytes");
    }
    let telegram = SenTelegram {
        ipoc: 1,
        correction: [Decimal::zero(4); 6],
        stop: true,
    };
    let mut out = [0; SEN_MAX_BYTES];
    let len = write_sen(&telegram, &Tags::default(), &mut out).unwrap();
    for cut in 0..len {
        assert!(parse_sen(&out[..cut], &Tags::default()).is_err(), "{cut}");
    }
}

/// Bytes that look like XML, so that the scanner does not stop at once.
fn markup_soup() -> impl Strategy<Value = Vec<u8>> {
    let pieces = vec![
        "<", ">", "/>", "</", "=", "'", "\"", " ", "\t", "\0", "<!--", "-->", "<?", "?>", "&",
        "Rob", "Sen", "Dat", "RIst", "RKorr", "IPOC", "Delay", "Stop", "X", "D", "Type", "1", "-",
        ".", "e", "9", "<Rob>", "</Rob>", "<IPOC>", "</IPOC>", "\u{fffd}",
    ];
    prop::collection::vec(prop::sample::select(pieces), 0..60)
        .prop_map(|pieces| pieces.concat().into_bytes())
}

fn read_all(bytes: &[u8]) {
    let _ = parse_rob(bytes, &tags());
    let _ = parse_sen(bytes, &tags());
    let _ = salvage_ipoc(bytes);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(10_000))]

    #[test]
    fn byte_soup_never_panics(bytes in prop::collection::vec(any::<u8>(), 0..300)) {
        read_all(&bytes);
    }

    #[test]
    fn markup_soup_never_panics(bytes in markup_soup()) {
        read_all(&bytes);
    }
}

proptest! {
    #[test]
    fn any_layout_that_is_cut_off_is_an_error(text in telegram(), at: prop::sample::Index) {
        let text = text.trim_end();
        let len = at.index(text.len());
        prop_assert!(parse_rob(&text.as_bytes()[..len], &tags()).is_err());
    }

    #[test]
    fn a_changed_byte_never_panics_and_values_stay_finite(
        text in telegram(),
        at: prop::sample::Index,
        byte: u8,
    ) {
        let mut bytes = text.into_bytes();
        let at = at.index(bytes.len());
        bytes[at] = byte;
        if let Ok(rob) = parse_rob(&bytes, &tags()) {
            let values = [rob.actual_pose, rob.setpoint_pose].into_iter().flatten().flatten();
            prop_assert!(values.into_iter().all(f64::is_finite));
        }
    }
}
