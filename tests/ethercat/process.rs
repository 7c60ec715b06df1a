//! `softdock board --ethercat`: frames in datagrams, in real time.

use softdock_link::ethercat::Product;
use softdock_rig::ethercat::wire::plug;
use softdock_rig::ethercat::{Description, Segment, SubDevice};
use softdock_tests::peers::{BUSY_COMPUTER, Served, serve};
use softdock_tests::process::PATIENCE;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant};

const ANY: &str = "127.0.0.1:0";

fn settings() -> String {
    BUSY_COMPUTER.replace("[ethercat]", "[ethercat]\nenabled = true")
}

fn until_says(served: &Served, state: &str) -> String {
    let give_up = Instant::now() + PATIENCE;
    loop {
        let says = served.done(&["status"]);
        if says.contains(state) {
            return says;
        }
        assert!(Instant::now() < give_up, "never `{state}`: {says}");
        thread::sleep(Duration::from_millis(50));
    }
}

/// No sensor, the wrong one, and the right one: the state says which.
#[test]
fn the_state_says_what_is_on_the_cable() {
    let served = serve("ethercat_state", &settings(), &["--ethercat", ANY]);
    until_says(&served, "Failed(NoAnswer)");
    let board = served.board.ethercat.expect("a port");
    let axia = Description::of(Product::Axia80);
    let other = Description {
        product: 7,
        ..axia.clone()
    };
    for (devices, state) in [
        (vec![other], "Failed(Product { received: 7 })"),
        (vec![axia.clone(); 2], "Failed(SubDevices { received: 2 })"),
        (vec![axia], "sensor    Running"),
    ] {
        let unplugged = AtomicBool::new(false);
        thread::scope(|scope| {
            let plugged = scope.spawn(|| {
                let devices = devices.into_iter().map(SubDevice::new).collect();
                let mut segment = Segment::new(devices);
                plug(board, &unplugged, &mut segment, |segment, _| {
                    for device in &mut segment.devices {
                        device.measure(Default::default());
                    }
                })
            });
            until_says(&served, state);
            unplugged.store(true, Ordering::Relaxed);
            plugged.join().unwrap().unwrap();
        });
    }
    served.board.stop();
}

/// Settings for a link that the board was not given: no sample, and the state says why.
#[test]
fn a_board_without_the_link_says_so() {
    let served = serve("ethercat_other_link", &settings(), &[]);
    until_says(&served, "Failed(OtherLink)");
    served.board.stop();
}
