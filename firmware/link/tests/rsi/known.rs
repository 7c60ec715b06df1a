//! Telegrams in the style of public drivers and simulators.

use softdock_link::rsi::{
    Field, Name, RobTelegram, RsiError, Tags, parse_rob, salvage_ipoc, write_rob,
};

/// Tags for a robot that sends POSCORR's status.
pub(crate) fn tags() -> Tags {
    Tags {
        poscorr_stat: Some(Name::new("PosStat").unwrap()),
        ..Tags::default()
    }
}

/// In the style of the RSIPI echo server: two decimals, `Type`.
pub(crate) const RSIPI: &str = concat!(
    r#"<Rob Type="KUKA"><RIst X="1.00" Y="0.00" Z="-0.25" A="0.00" B="90.00" C="-180.00" />"#,
    r#"<RSol X="0.00" Y="0.00" Z="0.00" A="0.00" B="90.00" C="-180.00" />"#,
    r#"<AIPos A1="0.00" A2="-90.00" A3="90.00" A4="0.00" A5="90.00" A6="0.00" />"#,
    r#"<Delay D="3" /><Tech C11="0.00" C12="0.00" /><DiL>0</DiL><Digout o1="0" o2="0" o3="0" />"#,
    r#"<PosStat>16</PosStat><IPOC>123645634563</IPOC></Rob>"#,
);

/// In the style of the simulator of kuka_experimental: `TYPE`, indentation, no setpoint.
const KUKA_EXPERIMENTAL: &str = "<Rob TYPE=\"KUKA\">\r\n\t<Out A='1' />\r\n\t<RIst C=\"6.0\" \
    B=\"5.0\" A=\"4.0\"\tZ=\"3.0\" Y=\"2.0\" X=\"1.0\"/>\r\n\t<AIPos A1=\"0.1\"/>\r\n\
    \t<IPOC> 4208163634 </IPOC>\r\n</Rob>\r\n";

/// In the style of RSI 2: content in a `Dat`.
const RSI_2: &str = concat!(
    r#"<?xml version="1.0"?><Rob Type="KUKA"><Dat TaskType="b"><ComStatus>continuous</ComStatus>"#,
    r#"<RIst X="1.0" Y="2.0" Z="3.0" A="4.0" B="5.0" C="6.0"/><IPOC>7</IPOC></Dat></Rob>"#,
);

#[test]
fn reads_telegrams_of_public_peers() {
    assert_eq!(
        parse_rob(RSIPI.as_bytes(), &tags()),
        Ok(RobTelegram {
            ipoc: 123_645_634_563,
            actual_pose: Some([1.0, 0.0, -0.25, 0.0, 90.0, -180.0]),
            setpoint_pose: Some([0.0, 0.0, 0.0, 0.0, 90.0, -180.0]),
            late_answers: Some(3),
            poscorr_stat: Some(16),
        })
    );
    let pose = Some([1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
    for (text, ipoc) in [(KUKA_EXPERIMENTAL, 4_208_163_634), (RSI_2, 7)] {
        let telegram = RobTelegram {
            ipoc,
            actual_pose: pose,
            ..RobTelegram::default()
        };
        assert_eq!(parse_rob(text.as_bytes(), &tags()), Ok(telegram));
    }
}

#[test]
fn the_short_first_telegram_is_complete() {
    let telegram = RobTelegram {
        ipoc: u64::MAX,
        ..RobTelegram::default()
    };
    let text = b"<Rob TYPE=\"KUKA\"><IPOC>18446744073709551615</IPOC></Rob>";
    assert_eq!(parse_rob(text, &tags()), Ok(telegram));
}

#[test]
fn names_that_are_not_configured_are_skipped() {
    let telegram = parse_rob(RSIPI.as_bytes(), &Tags::default()).unwrap();
    assert_eq!(telegram.poscorr_stat, None);
    let nested = b"<Rob><Other><IPOC>1</IPOC></Other><IPOC>2<x>3</x></IPOC></Rob>";
    assert_eq!(parse_rob(nested, &tags()).map(|rob| rob.ipoc), Ok(2));
}

#[test]
fn contradictions_and_gaps_are_errors() {
    let missing = |field| Err(RsiError::Missing { field });
    for (text, expected) in [
        ("<Rob></Rob>", missing(Field::Ipoc)),
        ("<Rob><IPOC> </IPOC></Rob>", missing(Field::Ipoc)),
        (
            "<Rob><RIst X='1'/><IPOC>1</IPOC></Rob>",
            missing(Field::ActualPose),
        ),
        (
            "<Rob><RSol/><IPOC>1</IPOC></Rob>",
            missing(Field::SetpointPose),
        ),
        (
            "<Sen><IPOC>1</IPOC></Sen>",
            Err(RsiError::WrongRoot { at: 0 }),
        ),
        (
            "<Rob><IPOC>1</IPOC><IPOC>1</IPOC></Rob>",
            Err(RsiError::Duplicate {
                field: Field::Ipoc,
                at: 25,
            }),
        ),
        (
            "<Rob><RIst X='1' X='1'/><IPOC>1</IPOC></Rob>",
            Err(RsiError::Duplicate {
                field: Field::ActualPose,
                at: 20,
            }),
        ),
        (
            "<Rob><RIst X='1e999'/><IPOC>1</IPOC></Rob>",
            Err(RsiError::BadValue {
                field: Field::ActualPose,
                at: 14,
            }),
        ),
        (
            "<Rob><Delay D='-1'/><IPOC>1</IPOC></Rob>",
            Err(RsiError::BadValue {
                field: Field::LateAnswers,
                at: 15,
            }),
        ),
        (
            "<Rob><PosStat>x</PosStat><IPOC>1</IPOC></Rob>",
            Err(RsiError::BadValue {
                field: Field::PoscorrStat,
                at: 14,
            }),
        ),
        (
            "<Rob><IPOC>18446744073709551616</IPOC></Rob>",
            Err(RsiError::BadValue {
                field: Field::Ipoc,
                at: 11,
            }),
        ),
    ] {
        assert_eq!(parse_rob(text.as_bytes(), &tags()), expected, "{text}");
    }
}

#[test]
fn a_time_stamp_is_salvaged_if_it_is_whole_and_unique() {
    for (text, expected) in [
        ("<Rob><RIst X='nan'/><IPOC>42</IPOC></Rob>", Some(42)),
        ("<IPOC> 42\r\n</IPOC>", Some(42)),
        ("<Rob><IPOC>42</IPOC", None),
        ("<Rob><IPOC>42", None),
        ("<IPOC>4<x/>2</IPOC>", None),
        ("<IPOC></IPOC>", None),
        ("<IPOC>18446744073709551616</IPOC>", None),
        ("<IPOC>1</IPOC><IPOC>2</IPOC>", None),
        (
            "<?xml v='<IPOC>1</IPOC>'?><Rob><IPOC\n>2</IPOC></Rob>",
            None,
        ),
        ("<IPOC >42</IPOC>", None),
        ("", None),
    ] {
        assert_eq!(salvage_ipoc(text.as_bytes()), expected, "{text}");
    }
}

#[test]
fn a_robot_that_cannot_be_written_is_an_error() {
    let telegram = RobTelegram {
        actual_pose: Some([0.0, f64::NAN, 0.0, 0.0, 0.0, 0.0]),
        ..RobTelegram::default()
    };
    let mut out = [0; 512];
    assert_eq!(
        write_rob(&telegram, 1, &tags(), &mut out),
        Err(RsiError::NotRepresentable {
            field: Field::ActualPose
        })
    );
    assert_eq!(
        write_rob(&RobTelegram::default(), 1, &tags(), &mut out[..10]),
        Err(RsiError::BufferTooSmall { available: 10 })
    );
}
