//! The board answers ping: by Ethernet frames, because QEMU lets no ICMP in from outside.

use softdock_tests::peers::QemuBoard;
use softdock_tests::process::PATIENCE;
use std::net::{Ipv4Addr, SocketAddr, UdpSocket};

/// The board in QEMU's network, and somebody beside it.
const BOARD: [u8; 4] = [10, 0, 2, 15];
const BOARD_HARDWARE: [u8; 6] = [2, 0, 0, 0, 0, 1];
const NEIGHBOUR: [u8; 4] = [10, 0, 2, 77];
const NEIGHBOUR_HARDWARE: [u8; 6] = [2, 0, 0, 0, 0, 0x77];

/// An Ethernet frame of the neighbour.
fn frame(to: [u8; 6], kind: u16, payload: &[u8]) -> Vec<u8> {
    let mut frame = [&to[..], &NEIGHBOUR_HARDWARE, &kind.to_be_bytes(), payload].concat();
    frame.resize(frame.len().max(60), 0);
    frame
}

/// RFC 826: who has the board's address?
fn who_has() -> Vec<u8> {
    let ethernet_ip_request = [0, 1, 8, 0, 6, 4, 0, 1];
    let parts: [&[u8]; 5] = [
        &ethernet_ip_request,
        &NEIGHBOUR_HARDWARE,
        &NEIGHBOUR,
        &[0; 6],
        &BOARD,
    ];
    frame([0xff; 6], 0x0806, &parts.concat())
}

/// RFC 792: an echo request with this text.
fn echo_request(text: &[u8]) -> Vec<u8> {
    let mut icmp = [&[8, 0, 0, 0, 0x12, 0x34, 0, 1], text].concat();
    let sum = checksum(&icmp);
    icmp[2..4].copy_from_slice(&sum);
    let length = (20 + icmp.len() as u16).to_be_bytes();
    let mut ip = [0x45, 0, length[0], length[1], 0, 1, 0, 0, 64, 1, 0, 0].to_vec();
    ip.extend([NEIGHBOUR, BOARD].concat());
    let sum = checksum(&ip);
    ip[10..12].copy_from_slice(&sum);
    frame(BOARD_HARDWARE, 0x0800, &[ip, icmp].concat())
}

/// RFC 1071.
fn checksum(bytes: &[u8]) -> [u8; 2] {
    let words = bytes
        .chunks(2)
        .map(|pair| u32::from(pair[0]) << 8 | pair.get(1).map_or(0, |low| u32::from(*low)));
    let mut sum: u32 = words.sum();
    while sum > 0xffff {
        sum = (sum & 0xffff) + (sum >> 16);
    }
    (!(sum as u16)).to_be_bytes()
}

/// Sends until a frame of the board comes that is as wanted.
fn ask(socket: &UdpSocket, board: SocketAddr, frame: &[u8], wanted: impl Fn(&[u8]) -> bool) {
    socket.set_read_timeout(Some(PATIENCE / 100)).unwrap();
    for _ in 0..100 {
        socket.send_to(frame, board).unwrap();
        let mut buffer = [0; 2048];
        while let Ok((length, _)) = socket.recv_from(&mut buffer) {
            if wanted(&buffer[..length]) {
                return;
            }
        }
    }
    panic!("no answer");
}

#[test]
fn the_board_answers_ping() {
    let board = QemuBoard::start("qemu_ping", "", &["--ethercat", "127.0.0.1:0"]);
    let segment = board.ethercat.unwrap();
    let socket = UdpSocket::bind((Ipv4Addr::LOCALHOST, 0)).unwrap();
    let is_reply = |frame: &[u8]| frame.starts_with(&NEIGHBOUR_HARDWARE) && frame[20..22] == [0, 2];
    ask(&socket, segment, &who_has(), is_reply);
    let text = b"is somebody there?";
    let is_echo = |frame: &[u8]| {
        frame.starts_with(&NEIGHBOUR_HARDWARE)
            && frame.len() >= 42 + text.len()
            && frame[34] == 0
            && frame[42..].starts_with(text)
    };
    ask(&socket, segment, &echo_request(text), is_echo);
    board.stop();
}
