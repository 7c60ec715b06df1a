//! A docking rig of a few lines, run by the real controller: one rigid flange that executes each
//! correction a fixed number of cycles later, between elastic walls.

use nalgebra::Vector3;
use softdock_app::record::{Inputs, RobotReport};
use softdock_app::robot_cycle::RobotCycle;
use softdock_app::settings::BoardSettings;
use softdock_control::io::{SensorSample, Sequence};
use softdock_control::modes::Command;
use softdock_control::settings::Settings;
use softdock_io::recording::{Header, Recording};
use softdock_physics::model::{
    ActuatorModel, ContactModel, Model, NoiseModel, SensorModel, ToolModel, WallModel,
};
use softdock_statistics::RandomStream;
use std::collections::VecDeque;

/// Cycle time, s.
pub(super) const TS: f64 = 0.004;
/// Metres of one count of a correction: 4 decimals of a millimetre.
const COUNT_M: f64 = 1e-7;

/// What the rig is like.
#[derive(Clone, Debug)]
pub(super) struct Rig {
    /// Cycles by which corrections are executed late.
    pub(super) late_cycles: usize,
    /// Cycles for which the robot stands still when its velocity changes sign.
    pub(super) pause_cycles: usize,
    pub(super) stiffness_n_per_m: f64,
    /// Distance to each wall along its inward direction.
    pub(super) walls: Vec<(Vector3<f64>, f64)>,
    pub(super) velocity_m_s: [f64; 3],
    pub(super) seconds: f64,
    pub(super) seed: u64,
}

impl Default for Rig {
    fn default() -> Self {
        Self {
            late_cycles: 0,
            pause_cycles: 0,
            // 21 rad/s with the 500 kg of the default settings: a contact takes 150 ms.
            stiffness_n_per_m: 220_500.0,
            walls: vec![(Vector3::x(), 0.03)],
            velocity_m_s: [0.02, 0.0, 0.0],
            seconds: 3.6,
            seed: 1,
        }
    }
}

/// Noise of the synthetic measurements, which the models of the tests know.
pub(super) fn noise() -> NoiseModel {
    NoiseModel {
        force_n: 0.5,
        torque_n_m: 0.03,
        position_m: 2e-6,
        angle_rad: 4e-6,
        ..NoiseModel::default()
    }
}

const TOOL_KG: f64 = 10.0;
const BIAS: [f64; 6] = [3.0, -2.0, 5.0, 0.1, -0.2, 0.3];

impl Rig {
    pub(super) fn settings(&self) -> Settings {
        let mut settings = Settings::default();
        settings.body_k.velocity_m_s = self.velocity_m_s;
        settings.body_q.fixed = true;
        settings.delay.law = softdock_control::delay::LawName::None;
        settings.sensor.tool_mass_kg = TOOL_KG;
        settings.sensor.bias = BIAS;
        // A slow start: a late robot is wrong while it gathers speed, too.
        settings.start.ramp_cycles = 250;
        settings
    }

    /// The model with all properties of this rig.
    pub(super) fn model(&self) -> Model {
        let wall = |(inward, distance): &(Vector3<f64>, f64)| WallModel {
            point_m: (inward * *distance).into(),
            normal: (-inward).into(),
            stiffness_n_per_m: self.stiffness_n_per_m,
            damping_n_s_per_m: 0.0,
            damping_depth_m: 0.0,
            tip_m: [0.0; 3],
        };
        Model {
            actuator: ActuatorModel {
                transport_delay_s: self.late_cycles as f64 * TS,
                lag_s: 0.0,
            },
            contact: ContactModel {
                walls: self.walls.iter().map(wall).collect(),
                ..ContactModel::default()
            },
            tool: ToolModel {
                mass_kg: TOOL_KG,
                ..ToolModel::default()
            },
            sensor: SensorModel {
                bias: BIAS,
                ..SensorModel::default()
            },
            noise: noise(),
            ..Model::default()
        }
    }

    fn force(&self, position: &Vector3<f64>) -> Vector3<f64> {
        self.walls
            .iter()
            .map(|(inward, distance)| {
                let depth = (position.dot(inward) - distance).max(0.0);
                inward * (-self.stiffness_n_per_m * depth)
            })
            .sum()
    }

    /// Runs the controller on this rig and records every cycle.
    pub(super) fn record(&self) -> Recording {
        let settings = self.settings();
        let mut controller = RobotCycle::<f64>::new(&settings).unwrap();
        let mut random = RandomStream::new(self.seed, 0);
        let mut robot = Robot::new(self);
        let cycles = (self.seconds / TS) as u64;
        let records = (0..cycles)
            .map(|n| {
                let inputs = self.inputs(n, &robot.position, &mut random);
                let record = controller.step(&inputs);
                robot.execute(&record.output.correction);
                record
            })
            .collect();
        Recording {
            header: Header {
                identity: "softdock test".to_owned(),
                settings_toml: board_settings_toml(&settings),
                ..Header::default()
            },
            cycles: records,
            ..Recording::default()
        }
    }

    fn inputs(&self, n: u64, position: &Vector3<f64>, random: &mut RandomStream) -> Inputs {
        let noise = noise();
        let force = self.force(position) - Vector3::z() * (9.81 * TOOL_KG);
        let mut wrench = BIAS;
        for i in 0..3 {
            wrench[i] += force[i] + noise.force_n * random.normal();
            wrench[i + 3] += noise.torque_n_m * random.normal();
        }
        let mut pose = [0.0; 6];
        for i in 0..3 {
            pose[i] = position[i] + noise.position_m * random.normal();
            pose[i + 3] = noise.angle_rad * random.normal();
        }
        Inputs {
            robot: RobotReport {
                counter: 1000 + 4 * n,
                sequence: if n == 0 {
                    Sequence::NewRun
                } else {
                    Sequence::Next
                },
                pose: Some(pose),
                ..RobotReport::default()
            },
            sensor: SensorSample {
                counter: n as u32 + 1,
                wrench,
                counts: [n as i32; 6],
                ..SensorSample::default()
            },
            command: match n {
                5 => Some(Command::Hold),
                6 => Some(Command::Arm),
                7 => Some(Command::Start),
                _ => None,
            },
        }
    }
}

/// The robot: a queue of corrections, a position, and its pauses at reversals.
struct Robot {
    position: Vector3<f64>,
    queue: VecDeque<Vector3<f64>>,
    last: Vector3<f64>,
    pause_cycles: usize,
    paused: [usize; 3],
}

impl Robot {
    fn new(rig: &Rig) -> Self {
        Self {
            position: Vector3::zeros(),
            queue: vec![Vector3::zeros(); rig.late_cycles].into(),
            last: Vector3::zeros(),
            pause_cycles: rig.pause_cycles,
            paused: [0; 3],
        }
    }

    fn execute(&mut self, counts: &[i64; 6]) {
        let correction = Vector3::new(counts[0], counts[1], counts[2]).map(|c| c as f64 * COUNT_M);
        self.queue.push_back(correction);
        let step = self.queue.pop_front().unwrap();
        for i in 0..3 {
            if self.last[i] * step[i] < 0.0 {
                self.paused[i] = self.pause_cycles;
            }
            if step[i] != 0.0 {
                self.last[i] = step[i];
            }
            if self.paused[i] > 0 {
                self.paused[i] -= 1;
            } else {
                self.position[i] += step[i];
            }
        }
    }
}

/// The settings of a board whose control cycle has `control`.
pub(super) fn board_settings_toml(control: &Settings) -> String {
    let board = BoardSettings {
        control: control.clone(),
        ..BoardSettings::default()
    };
    toml_edit::ser::to_string(&board).unwrap()
}
