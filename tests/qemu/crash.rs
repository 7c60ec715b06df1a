//! What the firmware in QEMU tells at the start after a panic, a stack overflow or a fault.

use softdock_tests::peers::QemuBoard;

/// Crashes at the first start; what the second one says of it.
fn last_words(test: &str, crash: &str, chip: &str) -> String {
    let mut board = QemuBoard::start(test, "", &["--crash", crash, "--chip", chip]);
    board.process().wait_for("sensor Starting");
    let log = board.stop();
    let said: Vec<&str> = log
        .lines()
        .filter(|line| line.contains("started over after: "))
        .collect();
    assert_eq!(said.len(), 1, "{log}");
    assert!(said[0].contains(" error "), "{said:?}");
    said[0].to_owned()
}

#[test]
fn a_panic_leaves_its_text_and_place() {
    let said = last_words("qemu_panic", "panic", "an500");
    assert!(said.contains("a panic was asked for"), "{said}");
    assert!(said.contains("crash.rs:"), "{said}");
}

#[test]
fn a_stack_overflow_is_called_by_its_name() {
    for chip in ["an500", "an385"] {
        let said = last_words("qemu_overflow", "stack", chip);
        assert!(said.contains("stack overflow: stack pointer 0x"), "{said}");
    }
}

/// Usage fault, undefined instruction: bit 16 of the processor's CFSR.
#[test]
fn a_fault_leaves_the_registers_of_the_processor() {
    let said = last_words("qemu_fault", "fault", "an500");
    assert!(
        said.contains("fault at 0x") && said.contains("CFSR 0x00010000"),
        "{said}"
    );
}
