//! One run: the board's own cycle in a closed loop with a plant.

use super::case::Case;
use super::scene::{End, MASS_KG, OMEGA_RAD_S};
use anyhow::{Result, anyhow};
use nalgebra::Vector3;
use softdock_control::delay::{LawName, ModelVelocity};
use softdock_control::modes::{Command, Fault, Mode};
use softdock_control::settings::Settings;
use softdock_delay_plants::{Axes, Log, Measurement, Plant, PlantSettings, RobotPose, Sample};
use softdock_rig::board::cycle_driver::CycleDriver;

/// Cycles in which the robot stands still before the start, as with an operator; long enough for laws that observe the
/// resting robot.
const REST_CYCLES: usize = 40;
/// Flight at full speed before the touch, in cycles.
const FLIGHT_CYCLES: f64 = 150.0;
/// Time after the first contact of a single impact, s.
const AFTER_S: f64 = 0.5;
/// Allowed time for repeated impacts, relative to that of ideal ones.
const SLOWER: f64 = 1.4;
/// Threshold of a contact in standard deviations of the sensor's noise, as an engineer would set it.
const BEYOND_NOISE: f64 = 5.0;

/// One run of a case.
#[derive(Clone, Copy, Debug)]
pub struct Setup<'a> {
    /// The case.
    pub case: &'a Case,
    /// The law.
    pub law: LawName,
    /// Speed of the approach, m/s.
    pub speed_m_s: f64,
    /// Instant of the touch within a cycle, 0 to 1.
    pub touch_instant: f64,
    /// Seed of all noise.
    pub seed: u64,
}

/// State of the board in one cycle.
#[derive(Clone, Copy, Debug)]
pub struct Moment {
    /// Time at which pose and wrench were measured, s.
    pub time_s: f64,
    /// Velocity of K: linear in C, m/s; angular in body axes, rad/s.
    pub k: [Vector3<f64>; 2],
    /// Velocity of Q.
    pub q: [Vector3<f64>; 2],
    /// Measured force, N, in C.
    pub force: Vector3<f64>,
    /// Velocity that was sent, m/s.
    pub sent: Vector3<f64>,
}

/// What happened in a run.
#[derive(Clone, Debug)]
pub struct Trial {
    /// Every cycle since the start.
    pub moments: Vec<Moment>,
    /// True motion and contacts of the plant.
    pub log: Log,
    /// Distance from the start to the touch along the approach, m.
    pub distance_m: f64,
    /// The fault that ended the run, if any.
    pub fault: Option<Fault>,
}

/// Settings of the board for a case.
pub fn settings(case: &Case, law: LawName, speed_m_s: f64) -> Settings {
    let mut settings = Settings::default();
    [settings.body_k, settings.body_q] = case.scene.spacecraft(speed_m_s);
    settings.delay.law = law;
    // `None` and `Seed` as in the paper and in `reproduce`; the other laws use the velocity at the end of a cycle, which is
    // not late.
    let printed = matches!(law, LawName::None | LawName::Seed);
    settings.delay.model_velocity = if printed {
        ModelVelocity::Mean
    } else {
        ModelVelocity::End
    };
    settings.delay.actuator = case.believed.clone();
    settings.delay.predictor.interlock = case.interlock;
    let quiet_n = BEYOND_NOISE * case.measurement.force_noise_n;
    // This law needs a stiffness: that of the canonical contact.
    settings.delay.desired_restitution.stiffness_n_per_m = MASS_KG * OMEGA_RAD_S * OMEGA_RAD_S;
    for threshold_n in [
        &mut settings.delay.smith.threshold_n,
        &mut settings.delay.smith_dead_zone.dead_zone_n,
        &mut settings.delay.passivity.threshold_n,
        &mut settings.delay.desired_restitution.threshold_n,
        &mut settings.delay.switching_gain.threshold_n,
    ] {
        *threshold_n = threshold_n.max(quiet_n);
    }
    if case.measurement == Measurement::default() {
        // This sensor has no noise: equal readings are no fault.
        settings.sensor.frozen_after_cycles = 0;
    }
    settings
}

/// Time from the start of the motion to the touch, for a robot without delay and for the ideal test, s.
pub fn flight_s(touch_instant: f64, cycle_s: f64) -> f64 {
    (FLIGHT_CYCLES + touch_instant) * cycle_s
}

/// Runs the trial.
///
/// # Errors
/// The board refuses its settings or the start.
pub fn run(setup: &Setup<'_>) -> Result<Trial> {
    let Setup { case, .. } = *setup;
    let settings = settings(case, setup.law, setup.speed_m_s);
    let cycle_s = settings.robot.cycle_s;
    let mut board = CycleDriver::new(&settings)?;
    let flight_s = flight_s(setup.touch_instant, cycle_s);
    let mut plant = Plant::new(&PlantSettings {
        cycle_s,
        actuator: case.robot.actuator,
        formulation: case.formulation,
        contact: case.scene.contact(setup.speed_m_s, flight_s),
        measurement: case.measurement,
        seed: setup.seed,
        ..PlantSettings::default()
    });
    let mut sample = plant.first_sample();
    let mut moments = Vec::new();
    for n in 0..cycles(case, &settings, flight_s) {
        let (velocity, moment) = cycle(&mut board, n, &sample)?;
        if n > REST_CYCLES {
            moments.push(moment);
        }
        if board.cycle.fault().is_some() {
            break;
        }
        sample = plant.step(velocity);
    }
    Ok(Trial {
        moments,
        distance_m: setup.speed_m_s * flight_s,
        fault: board.cycle.fault(),
        log: plant.log().clone(),
    })
}

/// Length of a run in cycles.
fn cycles(case: &Case, settings: &Settings, flight_s: f64) -> usize {
    let contact_s = case.scene.contact_s();
    let test_s = match case.scene.end {
        End::After(s) => s,
        // From wall to wall takes twice the flight of the first approach, and longer with a law that takes energy away.
        End::Impacts(n) => {
            let to_and_fro_s = (n - 1) as f64 * (2.0 * flight_s + contact_s);
            contact_s + SLOWER * to_and_fro_s + AFTER_S
        }
    };
    let start = settings.start.zero_cycles + settings.start.ramp_cycles;
    let flown = ((flight_s + test_s) / settings.robot.cycle_s).ceil() as usize;
    REST_CYCLES + start as usize + flown
}

/// One cycle of the board. Returns the velocity of X Y Z A B C that is sent to the robot, and the state of the board.
fn cycle(board: &mut CycleDriver<f64>, n: usize, sample: &Sample) -> Result<(Axes, Moment)> {
    let command = match n {
        0 => Some(Command::Hold),
        1 => Some(Command::Arm),
        REST_CYCLES => Some(Command::Start),
        _ => None,
    };
    let record = board.step_with(|inputs| {
        inputs.robot.pose = Some(sample.position);
        inputs.sensor.wrench = sample.wrench;
        inputs.command = command;
    });
    if let Some(refusal) = record.trace.refusal {
        return Err(anyhow!("the board refuses {command:?}: {refusal:?}"));
    }
    if n == REST_CYCLES && record.trace.mode != Mode::Running {
        return Err(anyhow!(
            "the board does not start: {:?}",
            record.trace.fault
        ));
    }
    let velocity = board.velocity(&record.output.correction);
    let halves = |v: [f64; 6]| {
        [
            Vector3::from_column_slice(&v[..3]),
            Vector3::from_column_slice(&v[3..]),
        ]
    };
    let moment = Moment {
        time_s: n as f64 * board.cycle_s(),
        k: halves(record.trace.body_k.velocity),
        q: halves(record.trace.body_q.velocity),
        force: RobotPose::new(&sample.position, &[0.0; 6]).rotation * halves(sample.wrench)[0],
        sent: halves(velocity)[0],
    };
    Ok((velocity, moment))
}
