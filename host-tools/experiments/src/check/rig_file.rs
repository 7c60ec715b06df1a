//! The rig that a board is checked against: from a short file, or from a scenario.

use crate::one_contact::Contact;
use crate::scenario::Scenario;
use anyhow::{Context, Result, anyhow, bail};
use nalgebra::Vector3;
use serde::Deserialize;
use serde::de::IgnoredAny;
use softdock_app::settings::BoardSettings;
use softdock_control::dynamics::{BodyState, TwoBodyState, relative_velocity};
use softdock_control::frames::orientation_from_abc;
use softdock_control::range::in_range;
use softdock_control::settings::Settings;
use softdock_io::input;
use softdock_mechanism::{DockingSettings, Joint};
use softdock_rig::rig::settings::{ActuatorSettings, RigSettings, RobotSettings, WallSettings};
use std::path::Path;

/// A rig as the check sees it.
#[derive(Clone, Debug, PartialEq)]
pub struct Rig {
    /// The robot.
    pub actuator: ActuatorSettings,
    /// Cycles by which the reported pose is older than the force.
    pub feedback_latency_cycles: u8,
    /// The contact along its normal.
    pub contact: Contact,
    /// Speed towards the wall, m/s.
    pub approach_speed_m_s: f64,
    /// Standard deviation of the white noise of the force, N, if it is known.
    pub noise_force_n: Option<f64>,
}

/// Content of the file.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
struct RigFile {
    /// Speed towards the wall, m/s; by default the relative speed of the settings' spacecraft.
    approach_speed_m_s: Option<f64>,
    /// Mass that the contact feels, kg; by default the reduced mass of the settings' spacecraft, centre to centre.
    effective_mass_kg: Option<f64>,
    /// Cycles by which the reported pose is older than the force.
    feedback_latency_cycles: u8,
    /// Standard deviation of the white noise of the force, N; without it nothing is said about damping in noise.
    noise_force_n: Option<f64>,
    actuator: ActuatorSettings,
    contact: Option<ContactFile>,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct ContactFile {
    stiffness_n_per_m: f64,
    #[serde(default)]
    damping_n_s_per_m: f64,
}

/// Determines whether a file is a scenario; all other keys are checked later.
#[derive(Deserialize)]
struct Kind {
    board: Option<IgnoredAny>,
    rig: Option<IgnoredAny>,
}

fn is_scenario(path: &Path) -> Result<bool> {
    let kind: Kind = input::load(path)?;
    Ok(kind.board.is_some() || kind.rig.is_some())
}

/// The board's settings, from a settings file or from a scenario.
///
/// # Errors
/// The file cannot be read, or a key is unknown.
pub fn load_board(path: &Path) -> Result<BoardSettings> {
    if is_scenario(path)? {
        return Ok(input::load::<Scenario>(path)?.board);
    }
    input::load(path)
}

impl Rig {
    /// Reads a rig for a board.
    ///
    /// # Errors
    /// The file cannot be read, a value is out of its range, or the spacecraft do not approach the wall.
    pub fn load(path: &Path, board: &BoardSettings) -> Result<Self> {
        let rig = if is_scenario(path)? {
            let mut scenario: Scenario = input::load(path)?;
            scenario.board = board.clone();
            Self::of_scenario(&scenario)
        } else {
            Self::of_file(&input::load(path)?, board)
        };
        let in_file = || format!("in {}", path.display());
        let rig = rig.with_context(in_file)?;
        rig.validate().with_context(in_file)?;
        Ok(rig)
    }

    /// The rig of a scenario: its robot without hidden effects, and the wall that is met first.
    ///
    /// # Errors
    /// A value of the rig is out of its range, or no wall is approached.
    pub fn of_scenario(scenario: &Scenario) -> Result<Self> {
        scenario.rig.validate().context("[rig]")?;
        let Some(FirstContact {
            speed_m_s,
            wall,
            nonlinear,
            ..
        }) = first_contact(scenario)
        else {
            bail!(
                "neither a wall of `rig.mechanism.walls` nor a docking mechanism is approached; give the spacecraft a velocity towards one \
                 (`control.body_k.velocity_m_s` of the settings)"
            );
        };
        if let Some(place) = nonlinear {
            bail!(
                "`rig.mechanism.docking[{place}]` is met first, at {speed_m_s} m/s, and its force is not that of a spring and a damper, which is what \
                 this check computes with. Give a rig file in the scenario's place with the [contact] that lasts as long and gives back as \
                 much at that speed (host-tools/scenarios/rig.toml is one), or look at the runs themselves: `softdock run` with each `--law`"
            );
        }
        let rig = Self {
            actuator: scenario.rig.robot.actuator.clone(),
            feedback_latency_cycles: scenario.rig.robot.feedback_latency_cycles,
            contact: Contact::new(scenario, &wall),
            approach_speed_m_s: speed_m_s,
            noise_force_n: Some(scenario.rig.sensor.noise_force_n),
        };
        let mechanism = &scenario.rig.mechanism;
        if mechanism.runs_on_after_capture {
            let dockings = mechanism.docking.iter();
            for (docking, joint) in dockings.filter_map(|d| Some((d, d.kind.latched()?))) {
                let mass_kg = Contact::new(scenario, &as_wall(docking, joint)).mass_kg;
                rig.bears(&joint, mass_kg)?;
            }
        }
        Ok(rig)
    }

    /// Refuses a latched joint if the delay makes the closed loop on it oscillate: unlike a contact it never ends.
    fn bears(&self, joint: &Joint, mass_kg: f64) -> Result<()> {
        let latched = Contact {
            mass_kg,
            stiffness_n_per_m: joint.stiffness_n_per_m,
            damping_n_s_per_m: joint.damping_n_s_per_m,
        };
        let (bears_s, delay_s) = (latched.critical_delay_s(), self.mean_delay_s());
        if delay_s <= bears_s {
            return Ok(());
        }
        bail!(
            "a closed loop on the latched joint swings up: {:.0} N/m and {:.0} N·s/m on {mass_kg:.0} kg bear a \
             delay of {:.1} ms, and the robot is {:.1} ms late. Leave `runs_on_after_capture` out, so that the \
             board stops at capture, or soften and damp the latches",
            joint.stiffness_n_per_m,
            joint.damping_n_s_per_m,
            bears_s * 1e3,
            delay_s * 1e3
        )
    }

    fn of_file(file: &RigFile, board: &BoardSettings) -> Result<Self> {
        let Some(contact) = &file.contact else {
            bail!(
                "section [contact] is missing; it holds `stiffness_n_per_m`, in N/m, and \
                 `damping_n_s_per_m`"
            );
        };
        let settings = &board.control;
        let mass_kg = match file.effective_mass_kg {
            Some(mass_kg) => mass_kg,
            None => reduced_mass_kg(settings)?,
        };
        let approach_speed_m_s = match file.approach_speed_m_s {
            Some(speed_m_s) => speed_m_s,
            None => relative_m_s(settings).norm(),
        };
        if approach_speed_m_s == 0.0 {
            bail!(
                "the spacecraft of the settings do not move towards each other; give `approach_speed_m_s`"
            );
        }
        Ok(Self {
            actuator: file.actuator.clone(),
            feedback_latency_cycles: file.feedback_latency_cycles,
            contact: Contact {
                mass_kg,
                stiffness_n_per_m: contact.stiffness_n_per_m,
                damping_n_s_per_m: contact.damping_n_s_per_m,
            },
            approach_speed_m_s,
            noise_force_n: file.noise_force_n,
        })
    }

    fn validate(&self) -> Result<()> {
        let Contact {
            mass_kg,
            stiffness_n_per_m,
            damping_n_s_per_m,
        } = self.contact;
        let speed = self.approach_speed_m_s;
        in_range("effective_mass_kg", mass_kg, 0.1, 1e6)?;
        in_range("contact.stiffness_n_per_m", stiffness_n_per_m, 1.0, 1e9)?;
        in_range("contact.damping_n_s_per_m", damping_n_s_per_m, 0.0, 1e7)?;
        in_range("approach_speed_m_s", speed, 1e-5, 1.0)?;
        in_range("noise_force_n", self.noise_force_n.unwrap_or(0.0), 0.0, 1e3)?;
        self.settings().validate().map_err(|error| {
            // The names of keys in this file, not in a scenario.
            anyhow!(format!("{error:#}").replace("`rig.robot.", "`"))
        })
    }

    /// The robot as settings of a simulated rig.
    pub(super) fn settings(&self) -> RigSettings {
        RigSettings {
            robot: RobotSettings {
                actuator: self.actuator.clone(),
                feedback_latency_cycles: self.feedback_latency_cycles,
                ..RobotSettings::default()
            },
            ..RigSettings::default()
        }
    }

    /// Damping of the contact that noise may hide, N·s/m; `cycle_s` is the board's cycle. None if the noise is not known.
    pub fn damping_in_noise(&self, cycle_s: f64) -> Option<f64> {
        let (contact, speed_m_s) = (&self.contact, self.approach_speed_m_s);
        let noise_n = self.noise_force_n?;
        Some(contact.damping_in_noise(noise_n, speed_m_s, cycle_s))
    }

    /// Mean delay of a slow motion, s: delay, lag, and 2ζ/ω of a servo.
    pub fn mean_delay_s(&self) -> f64 {
        let servo = self.actuator.servo.as_ref().map_or(0.0, |servo| {
            2.0 * servo.damping_ratio / (std::f64::consts::TAU * servo.frequency_hz)
        });
        self.actuator.delay_s + self.actuator.lag_s + servo
    }
}

/// Initial state of the spacecraft of the settings.
fn state(settings: &Settings) -> TwoBodyState<f64> {
    TwoBodyState {
        k: BodyState::initial(&settings.body_k),
        q: BodyState::initial(&settings.body_q),
    }
}

/// Velocity of K relative to Q, m/s.
fn relative_m_s(settings: &Settings) -> Vector3<f64> {
    let state = state(settings);
    relative_velocity(&state.k, &state.q).linear
}

/// 1/m = 1/m_K + 1/m_Q.
fn reduced_mass_kg(settings: &Settings) -> Result<f64> {
    let inverse = [&settings.body_k, &settings.body_q]
        .into_iter()
        .filter(|body| !body.fixed)
        .map(|body| 1.0 / body.mass_kg)
        .sum::<f64>();
    if inverse == 0.0 {
        bail!("both spacecraft of the settings are fixed; give `effective_mass_kg`");
    }
    Ok(1.0 / inverse)
}

/// The wall that stands for a joint of a docking mechanism, normal to its closing direction.
fn as_wall(docking: &DockingSettings, joint: Joint) -> WallSettings {
    let closing = orientation_from_abc::<f64>(&docking.orientation_abc_rad) * Vector3::x();
    WallSettings {
        point_m: docking.position_m,
        normal: (-closing).into(),
        tip_m: docking.tip_m,
        stiffness_n_per_m: joint.stiffness_n_per_m,
        damping_n_s_per_m: joint.damping_n_s_per_m,
        damping_onset_m: 0.0,
        gap_m: 0.0,
        friction_coefficient: 0.0,
        smoothing_speed_m_s: 1e-3,
    }
}

/// A wall that is approached.
struct FirstContact {
    /// Time until it is met, s.
    time_s: f64,
    /// Speed towards it, m/s.
    speed_m_s: f64,
    wall: WallSettings,
    /// Index of the docking mechanism, if the wall stands for one that is not linear.
    nonlinear: Option<usize>,
}

/// The wall or docking mechanism that is met first; None if none is approached.
fn first_contact(scenario: &Scenario) -> Option<FirstContact> {
    let mechanism = &scenario.rig.mechanism;
    // A mechanism that is not linear takes part without stiffness, as it may be the first that is met.
    let none = Joint {
        stiffness_n_per_m: 0.0,
        damping_n_s_per_m: 0.0,
    };
    let dockings = mechanism.docking.iter().enumerate();
    let dockings = dockings.map(|(place, docking)| {
        let joint = docking.kind.first_contact();
        let wall = as_wall(docking, joint.unwrap_or(none));
        (wall, joint.is_none().then_some(place))
    });
    let walls = mechanism.walls.iter().cloned().map(|wall| (wall, None));
    let approached = walls.chain(dockings).filter_map(|(wall, nonlinear)| {
        let (distance_m, speed_m_s) = approach(scenario, &wall);
        (speed_m_s > 0.0).then(|| FirstContact {
            time_s: distance_m.max(0.0) / speed_m_s,
            speed_m_s,
            wall,
            nonlinear,
        })
    });
    approached.min_by(|a, b| a.time_s.total_cmp(&b.time_s))
}

/// Distance of a wall from its tip at the start (m), and the speed towards it (m/s).
fn approach(scenario: &Scenario, wall: &WallSettings) -> (f64, f64) {
    let start = orientation_from_abc::<f64>(&scenario.start_abc_rad);
    let normal = Vector3::from(wall.normal).normalize();
    let lever = Vector3::from(wall.tip_m);
    let tip = Vector3::from(scenario.start_position_m) + start * lever;
    let state = state(&scenario.board.control);
    let relative = relative_velocity(&state.k, &state.q);
    // At the start K has in the laboratory the orientation of M.
    let c_from_q = start * state.q_from_k().rotation.inverse();
    let velocity = c_from_q * relative.linear + start * relative.angular.cross(&lever);
    let distance_m = (tip - Vector3::from(wall.point_m)).dot(&normal) + wall.gap_m;
    (distance_m, -velocity.dot(&normal))
}

#[cfg(test)]
mod tests {
    use super::*;
    use softdock_mechanism::{EddyCurrent, HuntCrossley, Kind};

    /// The spring rod with a mechanism in front of its wall, by `ahead_m`.
    fn before_the_wall(kind: Kind, ahead_m: f64) -> Result<Rig> {
        let mut scenario = Scenario::spring_rod().unwrap();
        let wall = &scenario.rig.mechanism.walls[0];
        let [x, y, z] = wall.point_m;
        scenario.rig.mechanism.docking = vec![DockingSettings {
            position_m: [x - ahead_m, y, z],
            orientation_abc_rad: [0.0; 3],
            tip_m: wall.tip_m,
            tip_abc_rad: [0.0; 3],
            limits: None,
            kind,
        }];
        Rig::of_scenario(&scenario)
    }

    #[test]
    fn a_mechanism_that_is_no_spring_is_named_if_it_is_met_first() {
        let hertz = Kind::HuntCrossley(HuntCrossley {
            stiffness_n_per_m15: 3e6,
            loss_s_per_m: 0.0,
        });
        let brake = Kind::EddyCurrent(EddyCurrent {
            largest_force_n: 50.0,
            critical_speed_m_s: 0.1,
        });
        for kind in [hertz, brake] {
            let error = before_the_wall(kind, 1e-3).unwrap_err().to_string();
            assert!(
                error.starts_with("`rig.mechanism.docking[0]` is met first, at 0.005 m/s"),
                "{error}"
            );
            assert!(!error.contains("velocity towards"), "{error}");
            let behind = before_the_wall(kind, -1e-3).unwrap();
            assert_eq!(behind.contact.stiffness_n_per_m, 220_500.0);
        }
    }
}
