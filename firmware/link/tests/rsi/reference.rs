//! Telegrams read with quick-xml, as a reference for our parser.

use std::collections::HashMap;

use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};
use softdock_link::rsi::RobTelegram;

/// Text by path: `IPOC` for the text of an element, `RIst.X` for an attribute, `.Type` for one of the root. `Dat` does not
/// count as a level; deeper elements have longer paths and are not used.
pub(crate) fn content(text: &str) -> HashMap<String, String> {
    let mut reader = Reader::from_str(text);
    let mut path = Vec::new();
    let mut found = HashMap::new();
    loop {
        match reader.read_event().expect("well-formed XML") {
            Event::Start(tag) => {
                path.push(name(&tag));
                attributes(&tag, &path, &mut found);
            }
            Event::Empty(tag) => {
                path.push(name(&tag));
                attributes(&tag, &path, &mut found);
                path.pop();
            }
            Event::End(_) => {
                path.pop();
            }
            Event::Text(text) => {
                let text = text.trim().to_owned();
                if !text.is_empty() {
                    found.insert(key(&path), text);
                }
            }
            Event::Eof => return found,
            _ => {}
        }
    }
}

fn attributes(tag: &BytesStart<'_>, path: &[String], found: &mut HashMap<String, String>) {
    for attribute in tag.attributes() {
        let attribute = attribute.expect("well-formed attribute");
        let key = format!("{}.{}", key(path), attribute.key.as_ref());
        found.insert(key, attribute.value.into_owned());
    }
}

fn name(tag: &BytesStart<'_>) -> String {
    tag.name().as_ref().to_owned()
}

fn key(path: &[String]) -> String {
    let below_root = path.get(1..).unwrap_or_default();
    match below_root {
        [dat, rest @ ..] if dat == "Dat" => rest.join("/"),
        rest => rest.join("/"),
    }
}

/// The robot's telegram, with POSCORR's status in `PosStat`.
pub(crate) fn rob(text: &str) -> RobTelegram {
    let content = content(text);
    let pose = |element: &str| {
        let axes = ["X", "Y", "Z", "A", "B", "C"];
        let values = axes.map(|axis| {
            let value = content.get(&format!("{element}.{axis}"))?;
            value.parse().ok()
        });
        match values {
            [Some(x), Some(y), Some(z), Some(a), Some(b), Some(c)] => Some([x, y, z, a, b, c]),
            _ => None,
        }
    };
    let count = |key: &str| content.get(key).map(|text| text.parse().expect("a count"));
    RobTelegram {
        ipoc: content["IPOC"].parse().expect("a time stamp"),
        actual_pose: pose("RIst"),
        setpoint_pose: pose("RSol"),
        late_answers: count("Delay.D"),
        poscorr_stat: count("PosStat"),
    }
}
