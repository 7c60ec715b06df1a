//! A jog of the simulated rig, recorded like one of a real rig.
//!
//! The jog is that of the board, with the distance and speed of its settings in the scenario. The mechanism is removed: an
//! identification needs free space.

use crate::scenario::Scenario;
use anyhow::{Result, bail, ensure};
use softdock_app::record::CycleRecord;
use softdock_control::frames::{orientation_from_abc, pose_components};
use softdock_control::io::Sequence;
use softdock_control::jog::Jog;
use softdock_control::modes::Mode;
use softdock_io::identity;
use softdock_io::recording::{Header, Recording};
use softdock_physics::model::Axis;
use softdock_rig::rig::settings::{CorrectionMode, MechanismSettings};
use softdock_rig::rig::{Rig, RigSettings};

/// Cycles of rest after a jog.
const AFTER: u32 = 50;
/// First time stamp of the robot, ms.
const FIRST_IPOC: u64 = 1_000_000;

/// Jogs one axis of the rig of a scenario and records every cycle.
///
/// # Errors
///
/// The scenario is not valid, the robot's correction limits are narrower than the jog, or the robot stops.
pub fn jog(scenario: &Scenario, axis: Axis, seed: u64) -> Result<Recording> {
    scenario.validate()?;
    let mut settings = scenario.rig.clone();
    settings.mechanism = MechanismSettings::default();
    ensure!(
        settings.robot.correction == CorrectionMode::Relative,
        "the rehearsal jogs with relative corrections; set `rig.robot.correction` to \"relative\""
    );
    let cycle_s = settings.cycle_s();
    let along = match axis {
        Axis::X => Jog::X,
        Axis::Y => Jog::Y,
        Axis::Z => Jog::Z,
        other => bail!("the rehearsal jogs along x, y or z, not {other}"),
    };
    let jog = &scenario.board.control.jog;
    room(&settings, axis, jog.reach_m)?;
    let mut rig = Rig::new(&settings, scenario.start_pose(), seed)?;
    let mut excitation = jog.seeded(along, cycle_s, seed as u32);
    let mut recorder = Recorder::new(scenario)?;
    let mut late: u32 = 0;
    loop {
        let Some(report) = rig.begin_cycle() else {
            bail!(
                "the simulated robot stopped in the jog: {:?}",
                rig.stopped()
            );
        };
        // Record some cycles more than the jog, until its end is executed.
        let sent = match excitation.next_velocity() {
            Some(velocity) => velocity,
            None if late >= AFTER => break,
            None => {
                late += 1;
                0.0
            }
        };
        let mut velocity = [0.0; 6];
        velocity[axis.index()] = sent;
        rig.answer(velocity.map(|v| v * cycle_s), false);
        recorder.push(
            report.actual_pose,
            velocity,
            wrench(&settings, rig.gauges().counts),
        );
    }
    Ok(recorder.recording)
}

/// An error unless the jog fits into the robot's own limits, which clamp silently.
fn room(settings: &RigSettings, axis: Axis, reach: f64) -> Result<()> {
    let robot = &settings.robot;
    let Some(clamp) = robot.correction_limit.upper_m.get(axis.index()) else {
        bail!("the rehearsal jogs along x, y or z, not {axis}");
    };
    let room = clamp.min(robot.correction_monitor.max_translation_m);
    ensure!(
        room > reach,
        "the jog may go {reach:.3} m along {axis}, and `rig.robot.correction_limit.upper_m` with \
         `rig.robot.correction_monitor.max_translation_m` leaves {room:.3} m: widen them, as \
         POSCORR and POSCORRMON of the real robot"
    );
    Ok(())
}

/// The wrench that these gauge counts stand for (N, N·m).
fn wrench(settings: &RigSettings, counts: [i16; 6]) -> [f64; 6] {
    let sensor = &settings.sensor;
    std::array::from_fn(|i| {
        let row = sensor.calibration[i].iter().zip(counts);
        let calibrated: f64 = row.map(|(m, count)| m * f64::from(count)).sum();
        calibrated
            / if i < 3 {
                sensor.counts_per_newton
            } else {
                sensor.counts_per_newton_metre
            }
    })
}

/// Records cycles as a board does.
struct Recorder {
    recording: Recording,
    cycle_s: f64,
    last: Option<[f64; 6]>,
}

impl Recorder {
    fn new(scenario: &Scenario) -> Result<Self> {
        let header = Header {
            identity: identity::text(),
            settings_toml: toml_edit::ser::to_string_pretty(&scenario.actual_board()?)?,
            scenario_toml: Some(scenario.to_toml()?),
            ..Header::default()
        };
        Ok(Self {
            recording: Recording {
                header,
                ..Recording::default()
            },
            cycle_s: scenario.board.control.robot.cycle_s,
            last: None,
        })
    }

    fn push(&mut self, pose: [f64; 6], sent: [f64; 6], wrench: [f64; 6]) {
        let n = self.recording.cycles.len() as u64;
        let mut cycle = CycleRecord::default();
        cycle.inputs.robot.counter = FIRST_IPOC + 4 * n;
        cycle.inputs.robot.sequence = if n == 0 {
            Sequence::NewRun
        } else {
            Sequence::Next
        };
        cycle.inputs.robot.pose = Some(pose);
        cycle.inputs.sensor.counter = n as u32 + 1;
        cycle.inputs.sensor.wrench = wrench;
        let trace = &mut cycle.trace;
        trace.cycle = n;
        trace.time_s = n as f64 * self.cycle_s;
        trace.mode = Mode::Hold;
        let [x, y, z, a, b, c] = pose;
        let rotation = orientation_from_abc(&[a, b, c]);
        let now = nalgebra::Isometry3::from_parts(nalgebra::Vector3::new(x, y, z).into(), rotation);
        trace.pose = pose_components(&now);
        trace.sent_velocity = sent;
        if let Some([lx, ly, lz, la, lb, lc]) = self.last.replace(pose) {
            let before = orientation_from_abc::<f64>(&[la, lb, lc]);
            let turn = (before.inverse() * rotation).scaled_axis() / self.cycle_s;
            let velocity = [x - lx, y - ly, z - lz].map(|d| d / self.cycle_s);
            trace.executed_velocity = [
                velocity[0],
                velocity[1],
                velocity[2],
                turn.x,
                turn.y,
                turn.z,
            ];
        }
        self.recording.cycles.push(cycle);
    }
}
