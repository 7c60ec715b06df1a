//! The robot's telegram in every layout that XML allows.

use proptest::prelude::*;
use softdock_link::rsi::{RobTelegram, parse_rob, write_rob};

use crate::known::tags;
use crate::reference;

/// A number as text, in one of the forms that a `DOUBLE` may have.
fn number() -> impl Strategy<Value = String> {
    (-9_999.0..9_999.0_f64, 0..=9_usize, 0..4).prop_map(|(value, decimals, form)| match form {
        0 => format!("{value:.decimals$e}"),
        1 => format!("{value:+.decimals$}"),
        _ => format!("{value:.decimals$}"),
    })
}

pub(crate) fn white_space() -> impl Strategy<Value = String> {
    "[ \t\r\n]{0,3}"
}

/// Attributes in any order, with any white space and either quote.
fn attributes(names: Vec<&'static str>) -> impl Strategy<Value = String> {
    let attribute = (
        white_space(),
        white_space(),
        white_space(),
        any::<bool>(),
        number(),
    );
    let count = names.len();
    (
        Just(names).prop_shuffle(),
        prop::collection::vec(attribute, count),
    )
        .prop_map(|(names, details)| {
            let mut text = String::new();
            for (name, (before, left, right, single, value)) in names.iter().zip(details) {
                let quote = if single { '\'' } else { '"' };
                text += &format!(" {before}{name}{left}={right}{quote}{value}{quote}");
            }
            text
        })
}

/// An element with attributes only, as an empty element or with an end tag.
fn element(name: &'static str, names: Vec<&'static str>) -> impl Strategy<Value = String> {
    (attributes(names), white_space(), any::<bool>()).prop_map(move |(attributes, space, empty)| {
        if empty {
            format!("<{name}{attributes}{space}/>")
        } else {
            format!("<{name}{attributes}{space}></{name}{space}>")
        }
    })
}

fn text_element(
    name: &'static str,
    content: impl Strategy<Value = String>,
) -> impl Strategy<Value = String> {
    (white_space(), content, white_space())
        .prop_map(move |(left, content, right)| format!("<{name}>{left}{content}{right}</{name}>"))
}

/// A complete telegram: elements that may be absent, in any order, between others that the board ignores.
pub(crate) fn telegram() -> impl Strategy<Value = String> {
    let axes = || vec!["X", "Y", "Z", "A", "B", "C"];
    let optional = prop::sample::subsequence(vec![0, 1, 2, 3, 4, 5, 6], 0..=7);
    let parts = (
        element("RIst", axes()),
        element("RSol", axes()),
        text_element("PosStat", (0..256_u32).prop_map(|stat| stat.to_string())),
        any::<u32>().prop_map(|late| format!("<Delay D=\"{late}\"/>")),
        element("AIPos", vec!["A1", "A2", "A3"]),
        Just("<!-- <IPOC>1</IPOC> -->".to_owned()),
        Just("<Tech><IPOC>x</IPOC></Tech><EStr>a &amp; b</EStr>".to_owned()),
    );
    let ipoc = text_element("IPOC", any::<u64>().prop_map(|ipoc| ipoc.to_string()));
    let kind = prop::sample::select(vec!["", " Type=\"KUKA\"", " TYPE='KUKA'"]);
    (parts, optional, ipoc, kind, white_space(), any::<bool>())
        .prop_flat_map(|(parts, optional, ipoc, kind, space, old)| {
            let parts = [
                parts.0, parts.1, parts.2, parts.3, parts.4, parts.5, parts.6,
            ];
            let mut elements = vec![ipoc];
            elements.extend(optional.into_iter().map(|part| parts[part].clone()));
            (Just(elements).prop_shuffle(), Just((kind, space, old)))
        })
        .prop_map(|(elements, (kind, space, old))| {
            let content = elements.join(&space);
            if old {
                format!(
                    "<?xml version=\"1.0\"?><Rob{kind}><Dat TaskType=\"b\">{content}</Dat></Rob>"
                )
            } else {
                format!("<Rob{kind}{space}>{space}{content}</Rob>{space}")
            }
        })
}

proptest! {
    #[test]
    fn an_independent_reader_finds_the_same(text in telegram()) {
        let ours = parse_rob(text.as_bytes(), &tags());
        prop_assert_eq!(ours, Ok(reference::rob(&text)), "{}", text);
    }

    #[test]
    fn what_the_robot_writes_is_read(
        ipoc: u64,
        pose in prop::option::of(prop::array::uniform6(-9_999.0..9_999.0_f64)),
        setpoint in prop::option::of(prop::array::uniform6(-9_999.0..9_999.0_f64)),
        late_answers: Option<u32>,
        poscorr_stat: Option<u32>,
        decimals in 0..=9_u8,
    ) {
        let telegram = RobTelegram {
            ipoc,
            actual_pose: pose,
            setpoint_pose: setpoint,
            late_answers,
            poscorr_stat,
        };
        let mut out = [0; 1024];
        let len = write_rob(&telegram, decimals, &tags(), &mut out).unwrap();
        let read = parse_rob(&out[..len], &tags()).unwrap();
        prop_assert_eq!(reference::rob(std::str::from_utf8(&out[..len]).unwrap()), read);
        let half_digit = 0.5 * 10_f64.powi(-i32::from(decimals)) + 1e-9;
        for (read, meant) in [(read.actual_pose, pose), (read.setpoint_pose, setpoint)] {
            prop_assert_eq!(read.is_some(), meant.is_some());
            for (read, meant) in read.iter().flatten().zip(meant.iter().flatten()) {
                prop_assert!((read - meant).abs() <= half_digit);
            }
        }
        let poses_aside = |telegram| RobTelegram {
            actual_pose: None,
            setpoint_pose: None,
            ..telegram
        };
        prop_assert_eq!(poses_aside(read), poses_aside(telegram));
    }
}
