//! All kinds of faults that are injected into a contact, in one table.

use super::line::{Cycle, Line};
use softdock_control::modes::Command;

/// A cycle during which a fault is active.
#[derive(Clone, Copy, Debug)]
pub(super) struct Moment {
    /// Cycles since the fault began.
    pub(super) since: usize,
    /// A random number, different in each cycle.
    pub(super) any: u64,
}

/// Effect of a fault on a cycle.
pub(super) type Spoil = fn(&mut Cycle, &mut Line, Moment);

/// Name and effect of each fault. Faults that need a bus, a flash or a watchdog are in `faults`, `ethercat` and `qemu` of the
/// integration tests.
pub(super) const FAULTS: [(&str, Spoil); 37] = [
    // The sensor.
    ("no sample in every second cycle", |c, _, m| {
        c.drop_sample(m.since % 2 == 0)
    }),
    ("no sample for two of three cycles", |c, _, m| {
        c.drop_sample(m.since % 3 != 0)
    }),
    ("no sample any more", |c, _, _| c.drop_sample(true)),
    ("frozen", |c, l, _| c.sample = Some(l.last_reading)),
    ("frozen, a sample in every third cycle", |c, l, m| {
        c.sample = (m.since % 3 == 0).then_some(l.last_reading);
    }),
    ("frozen, flickering by a count", |c, l, m| {
        let mut reading = l.last_reading;
        reading.counts[5] ^= m.since as i32 & 1;
        c.sample = Some(reading);
    }),
    ("a force of 3 cycles ago", |c, l, _| {
        c.sample = Some(l.earlier(3))
    }),
    ("a force of 12 cycles ago", |c, l, _| {
        c.sample = Some(l.earlier(12))
    }),
    ("a force of any cycle of the last 20", |c, l, m| {
        c.sample = Some(l.earlier((m.any % 20) as usize));
    }),
    ("one force stands still", |c, l, _| {
        let stuck = l.last_reading.wrench[0];
        c.change(|sample| sample.wrench[0] = stuck);
    }),
    ("all forces are zero", |c, _, _| {
        c.change(|sample| sample.wrench = [0.0; 6])
    }),
    ("forces with the wrong sign", |c, _, _| {
        c.change(|sample| sample.wrench = sample.wrench.map(|part| -part));
    }),
    ("an offset of 10 N", |c, _, _| {
        c.change(|sample| sample.wrench[0] -= 10.0)
    }),
    ("noise of 50 N", |c, _, m| {
        c.change(|sample| {
            sample.wrench[(m.any % 3) as usize] += (m.any % 1000) as f64 / 10.0 - 50.0
        });
    }),
    ("a spike of 2900 N", |c, _, m| {
        c.change(|sample| sample.wrench[0] -= if m.since % 7 == 0 { 2900.0 } else { 0.0 });
    }),
    ("an overload", |c, _, _| {
        c.change(|sample| sample.wrench[1] = 5000.0)
    }),
    ("a force that is no number", |c, _, _| {
        c.change(|sample| sample.wrench[2] = f64::NAN)
    }),
    ("an infinite torque", |c, _, _| {
        c.change(|sample| sample.wrench[3] = f64::INFINITY)
    }),
    ("a huge force", |c, _, _| {
        c.change(|sample| sample.wrench[4] = 1e300)
    }),
    ("a status bit", |c, _, m| {
        c.change(|sample| sample.status = 1 << (m.any % 32))
    }),
    ("a gauge at its range", |c, _, _| {
        c.change(|sample| sample.saturated = true)
    }),
    // The robot.
    ("every second telegram is lost", |c, _, m| {
        c.lost = m.since % 2 == 0
    }),
    ("all telegrams are lost", |c, _, _| c.lost = true),
    ("telegrams come twice", |c, _, _| c.twice = true),
    ("the counter goes backwards", |_, l, m| {
        l.jump(if m.since == 0 { -40 } else { 0 })
    }),
    ("the counter jumps ahead", |_, l, m| {
        l.jump(if m.since == 0 { 5000 } else { 0 })
    }),
    ("half a telegram, with its counter", |c, _, _| {
        c.text = Some("<Rob><RIst X=\"1\"/><IPOC>{}</IPOC>")
    }),
    ("a telegram that is none", |c, _, _| {
        c.text = Some("<Rob TYPE=")
    }),
    ("a pose that is no number", |c, _, _| {
        c.text = Some(
            "<Rob><RIst X=\"nan\" Y=\"0\" Z=\"0\" A=\"0\" B=\"0\" C=\"0\"/><IPOC>{}</IPOC></Rob>",
        );
    }),
    ("no pose", |c, _, _| c.pose = None),
    ("a pose 10 km away", |c, _, _| c.pose = Some([1e7; 6])),
    ("late answers", |c, _, m| {
        c.late_answers = 10 * m.since as u32
    }),
    ("the robot clamps", |c, _, _| c.clamps = true),
    ("the robot is gone, another port speaks", |c, _, _| {
        c.sender = 1
    }),
    // Other senders.
    ("strangers send telegrams of the robot's", |c, _, m| {
        c.strangers = 1 + (m.any % 4) as usize
    }),
    ("garbage from everywhere", |c, _, m| {
        c.garbage = 1 + (m.any % 4) as usize
    }),
    ("commands without end", |c, _, m| {
        c.command = Some(Command::WORDS[(m.any % 18) as usize].1);
    }),
];
