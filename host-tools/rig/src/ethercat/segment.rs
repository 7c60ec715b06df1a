//! SubDevices on a cable, and what happens to frames.

use super::datagram;
use super::sensor::Measurement;
use super::subdevice::SubDevice;

/// Shortest Ethernet frame without its checksum.
const SHORTEST: usize = 60;
/// Time between two of the shortest frames at 100 Mbit/s, in whole µs.
const LINE_RATE_US: usize = 7;
/// The first SubDevice sets it in the sender's address (ETG.1000.4, 5.3).
const PROCESSED: u8 = 0x02;

/// What the cable does to a frame that comes back.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Cable {
    /// Nothing.
    #[default]
    Good,
    /// It is not plugged in.
    Out,
    /// Frames are lost.
    Loses,
    /// Frames come twice.
    Repeats,
    /// Frames take this much longer, µs.
    Delays(u64),
    /// A frame of somebody else comes before each.
    Foreign,
    /// Frames of another sender come around each frame, at line rate for a millisecond.
    Floods,
    /// Frames come back cut off.
    Cuts,
    /// Frames come back with the sender's address unchanged: no SubDevice has seen them.
    Echoes,
    /// Frames come back with the sender's address changed and nothing else: working counter 0.
    Passes,
    /// SubDevices answer nonsense now and then: one byte in one of eight datagrams, working counters included.
    Garbles,
}

/// SubDevices in the order in which frames reach them.
#[derive(Clone, Debug)]
pub struct Segment {
    /// The SubDevices.
    pub devices: Vec<SubDevice>,
    /// The cable to the first of them.
    pub cable: Cable,
    /// State of the random numbers of [`Cable::Garbles`]; not 0.
    pub noise: u64,
}

impl Segment {
    /// The SubDevices on a good cable.
    pub fn new(devices: Vec<SubDevice>) -> Self {
        Self {
            devices,
            cable: Cable::Good,
            noise: 1,
        }
    }

    /// Every sensor measures this wrench (N, N·m) with this status.
    pub fn measure(&mut self, wrench: [f64; 6], status: u16) {
        for device in &mut self.devices {
            let per_unit = device.counts_per_unit();
            device.measure(Measurement::of(wrench, per_unit, status.into()));
        }
    }

    /// The frames that come back for one that was sent, each with a delay beyond the normal one, µs.
    pub fn pass(&mut self, frame: &[u8]) -> Vec<(u64, Vec<u8>)> {
        let mut back = frame.to_vec();
        match self.cable {
            Cable::Out | Cable::Loses => return Vec::new(),
            Cable::Echoes => return vec![(0, back)],
            Cable::Passes => {}
            _ => {
                let last = self.devices.len().saturating_sub(1);
                for (place, device) in self.devices.iter_mut().enumerate() {
                    device.set_links(place < last);
                }
                if !self.process(&mut back) {
                    return Vec::new();
                }
            }
        }
        if let Some(sender) = back.get_mut(6) {
            *sender |= PROCESSED;
        }
        back.resize(back.len().max(SHORTEST), 0);
        match self.cable {
            Cable::Repeats => vec![(0, back.clone()), (1, back)],
            Cable::Delays(by_us) => vec![(by_us, back)],
            Cable::Foreign => vec![(0, vec![0xA5; 90]), (0, of_others(&back)), (0, back)],
            Cable::Floods => {
                let flood = (0..1000).step_by(LINE_RATE_US);
                let flood = flood.map(|late_us| (late_us, of_others(&back)));
                let mut frames: Vec<_> = flood.collect();
                frames.push((500, back));
                frames
            }
            Cable::Cuts => vec![(0, back[..40].to_vec())],
            _ => vec![(0, back)],
        }
    }

    fn process(&mut self, frame: &mut [u8]) -> bool {
        datagram::for_each(frame, |datagram| {
            for device in &mut self.devices {
                device.process(datagram);
            }
            if self.cable == Cable::Garbles {
                self.noise = xorshift(self.noise);
                datagram.garble(self.noise);
            }
        })
    }
}

/// A frame of another stack: the same but for the index.
fn of_others(frame: &[u8]) -> Vec<u8> {
    let mut foreign = frame.to_vec();
    foreign[17] ^= 0x80;
    foreign
}

/// The next of a sequence of random numbers (Marsaglia 2003, xorshift64).
fn xorshift(mut state: u64) -> u64 {
    state ^= state << 13;
    state ^= state >> 7;
    state ^ state << 17
}
