//! docs/faults.md has a row for each fault.

use softdock_commissioning::parameters::words;
use softdock_control::modes::FaultCode;

const PAGE: &str = include_str!("../../docs/faults.md");
/// Holds each code with its word in a recording: a code without a word does not compile there.
const RECORDED: &str = include_str!("../../host-tools/io/src/recording/words.rs");

/// Each row begins with the word in a recording and the text that the program prints.
#[test]
fn each_fault_has_a_row_of_the_page() {
    let lines = RECORDED.lines().map(|line| line.trim_end_matches(','));
    let codes: Vec<(&str, &str)> = lines
        .filter_map(|line| line.split_once(" FaultCode::"))
        .collect();
    assert!(codes.len() > 10, "{codes:?}");
    for (word, code) in &codes {
        let word = word.split('"').nth(1).unwrap();
        let text = words::<FaultCode>(code);
        assert_ne!(text, *code, "no code has this name");
        let row = format!("| `{word}` | {text} | ");
        let rows = PAGE.lines().filter(|line| line.starts_with(&row)).count();
        assert_eq!(rows, 1, "{row}");
    }
    let rows = PAGE.lines().filter(|line| line.starts_with("| `"));
    assert_eq!(rows.count(), codes.len(), "a row of no fault");
}
