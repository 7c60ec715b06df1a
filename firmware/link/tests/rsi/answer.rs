//! The board's answer: written, read back, and read by an independent parser.

use proptest::prelude::*;
use softdock_link::decimal::Decimal;
use softdock_link::rsi::{
    Field, Name, RsiError, SEN_MAX_BYTES, SenTelegram, Tags, parse_sen, write_sen,
    write_sen_with_message,
};

use crate::reference;

fn written(telegram: &SenTelegram, tags: &Tags) -> String {
    let mut out = [0; SEN_MAX_BYTES];
    let len = write_sen(telegram, tags, &mut out).unwrap();
    String::from_utf8(out[..len].to_vec()).unwrap()
}

#[test]
fn is_written_as_the_robot_expects_it() {
    let mut telegram = SenTelegram {
        ipoc: 123_645_634_563,
        correction: [Decimal::zero(4); 6],
        stop: false,
    };
    telegram.correction[0].counts = -123;
    telegram.correction[5].counts = 50_000;
    assert_eq!(
        written(&telegram, &Tags::default()),
        concat!(
            r#"<Sen Type="ImFree"><RKorr X="-0.0123" Y="0.0000" Z="0.0000" A="0.0000" B="0.0000" "#,
            r#"C="5.0000"/><Stop>0</Stop><IPOC>123645634563</IPOC></Sen>"#,
        )
    );
    let no_stop = Tags {
        stop: None,
        ..Tags::default()
    };
    assert!(!written(&telegram, &no_stop).contains("Stop"));
}

#[test]
fn a_message_is_escaped_and_cut_off() {
    let telegram = SenTelegram::default();
    let mut out = [0; SEN_MAX_BYTES];
    let message = "Error: <F> > \"5\" & 'x'\n\u{b0}";
    let tags = Tags::default();
    let len = write_sen_with_message(&telegram, message, &tags, &mut out).unwrap();
    let text = std::str::from_utf8(&out[..len]).unwrap();
    assert!(
        text.contains("<EStr>Error: &lt;F&gt; &gt; &quot;5&quot; &amp; &apos;x&apos;??</EStr>")
    );
    assert_eq!(parse_sen(&out[..len], &tags), Ok(telegram));

    let len = write_sen_with_message(&telegram, &"q".repeat(500), &tags, &mut out).unwrap();
    let text = std::str::from_utf8(&out[..len]).unwrap();
    assert_eq!(text.matches('q').count(), 48);
}

#[test]
fn the_longest_answer_fills_its_buffer_exactly() {
    let longest = Name::new(&"n".repeat(Name::MAX_BYTES)).unwrap();
    let tags = Tags {
        sentype: longest,
        correction: longest,
        stop: Some(longest),
        poscorr_stat: None,
    };
    let number = Decimal {
        counts: i64::MIN,
        decimals: Decimal::MAX_DECIMALS,
    };
    let telegram = SenTelegram {
        ipoc: u64::MAX,
        correction: [number; 6],
        stop: true,
    };
    let message = "\"".repeat(100);
    let mut out = [0; SEN_MAX_BYTES];
    assert_eq!(
        write_sen_with_message(&telegram, &message, &tags, &mut out),
        Ok(SEN_MAX_BYTES)
    );
    let available = SEN_MAX_BYTES - 1;
    assert_eq!(
        write_sen_with_message(&telegram, &message, &tags, &mut out[..available]),
        Err(RsiError::BufferTooSmall { available })
    );
}

#[test]
fn what_the_robot_would_reject_is_an_error() {
    let korr = "<RKorr X='0' Y='0' Z='0' A='0' B='0' C='0'/>";
    let parse = |text: &str| parse_sen(text.as_bytes(), &Tags::default());
    let missing = |field| Err(RsiError::Missing { field });
    let bad = |field, at| Err(RsiError::BadValue { field, at });
    assert!(parse(&format!("<Sen TYPE='ImFree'>{korr}<IPOC>1</IPOC></Sen>")).is_ok());
    for (text, expected) in [
        (
            format!("<Sen>{korr}<IPOC>1</IPOC></Sen>"),
            missing(Field::SenType),
        ),
        (
            format!("<Sen Type='Other'>{korr}<IPOC>1</IPOC></Sen>"),
            bad(Field::SenType, 11),
        ),
        (
            format!("<Sen Type='ImFree'>{korr}</Sen>"),
            missing(Field::Ipoc),
        ),
        (
            "<Sen Type='ImFree'><IPOC>1</IPOC></Sen>".to_owned(),
            missing(Field::Correction),
        ),
        (
            "<Sen Type='ImFree'><RKorr X='1'/><IPOC>1</IPOC></Sen>".to_owned(),
            missing(Field::Correction),
        ),
        (
            "<Sen Type='ImFree'><RKorr X='1e2'/><IPOC>1</IPOC></Sen>".to_owned(),
            bad(Field::Correction, 29),
        ),
        (
            format!("<Sen Type='ImFree'>{korr}<Stop>2</Stop><IPOC>1</IPOC></Sen>"),
            bad(Field::Stop, 69),
        ),
        (
            "<Rob Type='KUKA'><IPOC>1</IPOC></Rob>".to_owned(),
            Err(RsiError::WrongRoot { at: 0 }),
        ),
    ] {
        assert_eq!(parse(&text), expected, "{text}");
    }
}

prop_compose! {
    fn decimal()(counts: i64, decimals in 0..=Decimal::MAX_DECIMALS) -> Decimal {
        Decimal { counts, decimals }
    }
}

prop_compose! {
    fn name()(text in "[A-Za-z_][A-Za-z0-9_-]{0,23}") -> Name {
        Name::new(&text).unwrap()
    }
}

prop_compose! {
    fn tags()(sentype in name(), correction in name(), stop in prop::option::of(name())) -> Tags {
        Tags { sentype, correction, stop, poscorr_stat: None }
    }
}

proptest! {
    #[test]
    fn is_read_back_by_us_and_by_an_independent_reader(
        ipoc: u64,
        correction in prop::array::uniform6(decimal()),
        stop: bool,
        tags in tags().prop_filter("clashing names", |tags| tags.validate().is_ok()),
    ) {
        let telegram = SenTelegram { ipoc, correction, stop };
        let text = written(&telegram, &tags);
        let expected = SenTelegram { stop: stop && tags.stop.is_some(), ..telegram };
        prop_assert_eq!(parse_sen(text.as_bytes(), &tags), Ok(expected));

        let content = reference::content(&text);
        prop_assert_eq!(&content[".Type"], tags.sentype.as_str());
        prop_assert_eq!(&content["IPOC"], &ipoc.to_string());
        for (axis, number) in ["X", "Y", "Z", "A", "B", "C"].iter().zip(correction) {
            let key = format!("{}.{axis}", tags.correction);
            prop_assert_eq!(content[&key].parse(), Ok(number));
        }
        let stop = tags.stop.map(|_| u8::from(stop).to_string());
        let found = tags.stop.map(|name| content[name.as_str()].clone());
        prop_assert_eq!(found, stop);
        let elements = 1 + 6 + 1 + usize::from(tags.stop.is_some());
        prop_assert_eq!(content.len(), elements, "something that is not configured");
    }
}
