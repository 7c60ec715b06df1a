//! Recognises a file that was given in place of another kind.

use toml_edit::TableLike;

/// First bytes of an MCAP file.
const MCAP: &[u8] = b"\x89MCAP";

/// Top-level keys that only one kind of file has, and the hint if another kind was expected.
const KINDS: [(&[&str], &str); 5] = [
    (
        &["board", "start_position_m", "duration_s"],
        "This looks like a scenario, as `softdock run` and `softdock rig` take it: was another file meant, or were two swapped?",
    ),
    (
        &["control", "can", "rsi", "network", "ethercat"],
        "This looks like the settings of a board: was another file meant, or were two swapped?",
    ),
    (
        &["noise", "tool", "bodies", "effect", "hypothesis", "history"],
        "This looks like a model, as `softdock compare` takes it: was another file meant, or were two swapped?",
    ),
    (
        &[
            "approach_speed_m_s",
            "effective_mass_kg",
            "feedback_latency_cycles",
        ],
        "This looks like a rig as `softdock check` takes it: was another file meant, or were two swapped?",
    ),
    (
        &["sent_velocity", "executed_velocity", "table", "files"],
        "This looks like a mapping for `softdock import`: was another file meant, or were two swapped?",
    ),
];

/// The hint on which kind of file a table is; None if that kind was expected (its keys are among `known`) or is unknown.
pub(super) fn other_kind(table: &dyn TableLike, known: &[&str]) -> Option<&'static str> {
    let has = |keys: &&[&str]| keys.iter().any(|key| table.contains_key(key));
    let (keys, hint) = KINDS.iter().find(|(keys, _)| has(keys))?;
    let expected = keys.iter().any(|key| known.contains(key));
    (!expected).then_some(*hint)
}

/// Error message for bytes that are not text.
pub(super) fn of_bytes(bytes: &[u8]) -> &'static str {
    if bytes.starts_with(MCAP) {
        "this is a recording (MCAP), expected is a TOML file: were two files swapped?"
    } else {
        "not a text file (expected TOML in UTF-8)"
    }
}
