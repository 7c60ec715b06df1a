//! What MCAP's profile for ROS 2 wants of a file.

use std::collections::BTreeMap;

/// Quality of service with which a topic was offered: wanted of each channel.
pub(super) const QOS: &str = "offered_qos_profiles";

/// Metadata of a channel that no node has offered.
pub(super) fn channel_metadata() -> BTreeMap<String, String> {
    BTreeMap::from([(QOS.to_owned(), String::new())])
}
