//! Common parts of all MCAP files that are written here.

use super::{FORMAT, Header, METADATA};
use mcap::records::Metadata;
use std::collections::BTreeMap;

/// Nanoseconds in a second: the unit of time in MCAP.
pub(super) const NS_PER_S: f64 = 1e9;

/// Name of this program in the file's header.
pub(super) const LIBRARY: &str = concat!("softdock ", env!("CARGO_PKG_VERSION"));

/// Metadata key for the quality of service of a topic, which MCAP's profile for ROS 2 requires of each channel.
pub(super) const QOS: &str = "offered_qos_profiles";

/// Encoding of the messages, as MCAP's registry calls it.
pub(super) const MESSAGE_ENCODING: &str = "cdr";
/// Encoding of the schemas, as MCAP's registry calls it.
pub(super) const SCHEMA_ENCODING: &str = "ros2msg";

/// The header as a metadata record of MCAP.
pub(super) fn metadata(header: &Header, cut: Option<&str>) -> Metadata {
    let turns = (header.whole_turns != 0).then(|| header.whole_turns.to_string());
    let began = header
        .began
        .and_then(|began| serde_json::to_string(&began).ok());
    let entries = [
        ("format", Some(FORMAT)),
        ("identity", Some(header.identity.as_str())),
        ("settings", Some(header.settings_toml.as_str())),
        ("scenario", header.scenario_toml.as_deref()),
        ("whole_turns", turns.as_deref()),
        ("began", began.as_deref()),
        ("cut", cut),
    ];
    let entry = |(key, value): (&str, Option<&str>)| Some((key.to_owned(), value?.to_owned()));
    Metadata {
        name: METADATA.to_owned(),
        metadata: entries.into_iter().filter_map(entry).collect(),
    }
}

/// Metadata of a channel that was not recorded from a ROS 2 node: an empty quality of service.
pub(super) fn channel_metadata() -> BTreeMap<String, String> {
    BTreeMap::from([(QOS.to_owned(), String::new())])
}
