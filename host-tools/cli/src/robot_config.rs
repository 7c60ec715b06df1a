//! The robot's side of the configuration, written from the board's settings so that the two
//! cannot disagree: the Ethernet configuration of RSI, and what to enter in the RSI objects.

use softdock_app::settings::{BoardSettings, BoardSettingsError};
use softdock_control::settings::CorrectionMode;
use softdock_link::rsi::Tags;
use std::fmt::Write;
use std::net::SocketAddr;

/// POSCORR limits relative to the board's own limits. The board must clamp first, because it reports it and POSCORR does not.
const POSCORR_MARGIN: f64 = 1.2;
/// POSCORRMON limits relative to those of POSCORR.
const POSCORRMON_MARGIN: f64 = 1.2;
/// ETHERNET object: decimals of what the robot sends. The default of 1 is 0.1 mm.
const PRECISION: u32 = 6;

/// The Ethernet configuration file (XML) for a board at `board`.
///
/// HOLDON follows the correction mode: a relative correction must not be repeated when an answer
/// is lost (0), an absolute one must be held (1).
pub fn ethernet_xml(
    settings: &BoardSettings,
    board: SocketAddr,
) -> Result<String, BoardSettingsError> {
    settings.validate()?;
    let tags = settings.rsi.tags()?;
    let (mode, hold_on) = match settings.control.robot.correction_mode {
        CorrectionMode::Relative => ("#RELATIVE", 0),
        CorrectionMode::Absolute => ("#ABSOLUTE", 1),
    };
    let (send, receive) = (sent_elements(&tags), received_elements(&tags, hold_on));
    let (ip, port, sentype) = (board.ip(), board.port(), tags.sentype);
    Ok(format!(
        "<ROOT>
  <!-- Written by softdock robot-config for RSI_ON({mode}): HOLDON of the correction is {hold_on}. -->
  <CONFIG>
    <IP_NUMBER>{ip}</IP_NUMBER>
    <PORT>{port}</PORT>
    <SENTYPE>{sentype}</SENTYPE>
    <ONLYSEND>FALSE</ONLYSEND>
  </CONFIG>
  <SEND>
    <ELEMENTS>
{send}    </ELEMENTS>
  </SEND>
  <RECEIVE>
    <ELEMENTS>
{receive}    </ELEMENTS>
  </RECEIVE>
</ROOT>
"
    ))
}

/// Elements that the robot sends.
fn sent_elements(tags: &Tags) -> String {
    let mut elements = String::new();
    // Writing to a String cannot fail.
    let mut element = |tag: &str, kind: &str, index: &str| {
        let _ = writeln!(
            elements,
            r#"      <ELEMENT TAG="{tag}" TYPE="{kind}" INDX="{index}"/>"#
        );
    };
    element("DEF_RIst", "DOUBLE", "INTERNAL");
    element("DEF_RSol", "DOUBLE", "INTERNAL");
    element("DEF_Delay", "LONG", "INTERNAL");
    if let Some(stat) = &tags.poscorr_stat {
        element(&stat.to_string(), "LONG", "1");
    }
    elements
}

/// Elements that the robot receives.
fn received_elements(tags: &Tags, hold_on: u8) -> String {
    let mut elements = String::new();
    let mut element = |tag: &str, kind: &str, index: u8, hold_on: u8| {
        let _ = writeln!(
            elements,
            r#"      <ELEMENT TAG="{tag}" TYPE="{kind}" INDX="{index}" HOLDON="{hold_on}"/>"#
        );
    };
    for (index, axis) in (1..).zip(["X", "Y", "Z", "A", "B", "C"]) {
        let name = &tags.correction;
        element(&format!("{name}.{axis}"), "DOUBLE", index, hold_on);
    }
    if let Some(stop) = &tags.stop {
        element(&stop.to_string(), "BOOL", 7, 1);
    }
    elements
}

/// What to enter in the robot program and in the RSI objects, as text.
pub fn notes(settings: &BoardSettings) -> String {
    let (robot, limits) = (&settings.control.robot, &settings.control.limits);
    let mode = match robot.correction_mode {
        CorrectionMode::Relative => "#RELATIVE",
        CorrectionMode::Absolute => "#ABSOLUTE",
    };
    let ipo = if robot.cycle_s > 0.008 {
        "#IPO"
    } else {
        "#IPO_FAST"
    };
    let mm = limits.box_m.map(|b| b * 1e3 * POSCORR_MARGIN);
    let degrees = limits.box_rad.to_degrees() * POSCORR_MARGIN;
    let diagonal = mm.iter().map(|b| b * b).sum::<f64>().sqrt() * POSCORRMON_MARGIN;
    let cycles = robot.lost_telegrams_fault;
    format!(
        "Robot program:  RSI_CREATE(\"softdock.rsi\"), RSI_ON({mode}, {ipo}), RSI_MOVECORR()
ETHERNET:       Precision {PRECISION} (the default of 1 sends 0.1 mm), Timeout 100 cycles (0.4 s);
                the board itself gives up after {cycles} lost telegrams ({:.0} ms)
POSCORR:        inputs 1-6 of ETHERNET; limits X ±{:.0} Y ±{:.0} Z ±{:.0} mm, MaxRotAngle {degrees:.1} deg
                (the default is ±5 mm, clamped silently); RefCorrSys 1 (Base); Stat to output 1
POSCORRMON:     MaxTrans {diagonal:.0} mm, MaxRotAngle {:.1} deg (the default is 6 mm, even if absent)
Tool frame:     origin of the active TOOL at the centre of mass of the spacecraft that the robot plays, its axes
                those of board settings `body_k.inertia_kg_m2`
Base frame:     z of the active BASE vertical, or its tilt in board settings `sensor.gravity_m_s2`
",
        f64::from(cycles) * robot.cycle_s * 1e3,
        mm[0],
        mm[1],
        mm[2],
        degrees * POSCORRMON_MARGIN,
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use quick_xml::events::Event;
    use quick_xml::reader::Reader;

    /// TAG and HOLDON of all elements that the robot receives.
    fn received(xml: &str) -> Vec<(String, String)> {
        let mut reader = Reader::from_str(xml);
        let mut found = Vec::new();
        loop {
            match reader.read_event().unwrap() {
                Event::Empty(element) if element.name().as_ref() == "ELEMENT" => {
                    let value = |key: &str| {
                        let attribute = element.try_get_attribute(key).unwrap();
                        attribute.map(|a| a.value.into_owned())
                    };
                    if let (Some(tag), Some(hold)) = (value("TAG"), value("HOLDON")) {
                        found.push((tag, hold));
                    }
                }
                Event::Eof => return found,
                _ => {}
            }
        }
    }

    #[test]
    fn hold_on_follows_the_correction_mode() {
        for (mode, hold) in [
            (CorrectionMode::Relative, "0"),
            (CorrectionMode::Absolute, "1"),
        ] {
            let mut settings = BoardSettings::default();
            settings.control.robot.correction_mode = mode;
            let xml = ethernet_xml(&settings, "192.168.1.20:49152".parse().unwrap()).unwrap();
            let corrections: Vec<_> = received(&xml)
                .into_iter()
                .filter(|(tag, _)| tag.starts_with("RKorr."))
                .collect();
            assert_eq!(corrections.len(), 6);
            assert!(
                corrections.iter().all(|(_, h)| h == hold),
                "{corrections:?}"
            );
            assert!(xml.contains("<IP_NUMBER>192.168.1.20</IP_NUMBER>"));
        }
    }
}
