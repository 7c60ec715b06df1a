//! Load of the sensor: contact, weight and inertia of the tool, with their true values, which may differ from those of the model.

use super::checks::{check, check_all};
use super::hidden;
use super::settings::{RigSettings, SensorSettings};
use anyhow::Result;
use nalgebra::{Matrix3, Vector3};
use softdock_control::frames::{Pose, Twist, Wrench, matrix, orientation_from_abc, vector};
use softdock_physics::effects::sensor::tool::{LoadMotion, Tool, ToolState};
use softdock_physics::effects::{Group, Law};

/// What the load does at one instant.
#[derive(Clone, Copy, Debug)]
pub(super) struct Load {
    pub(super) c_from_m: Pose<f64>,
    /// Of walls, guide and cables at M, in M axes.
    pub(super) contact: Wrench<f64>,
    pub(super) twist: Twist<f64>,
    /// Linear in C, angular in M; per second.
    pub(super) acceleration: Twist<f64>,
}

/// A hidden wrench of the tool with its values.
type Acting = (fn(&[f64], &ToolState) -> Wrench<f64>, Vec<f64>);

/// The tool on the sensor.
#[derive(Clone, Debug)]
pub(super) struct ToolLoad {
    m_from_s: Pose<f64>,
    tool: Tool,
    at_rest: ToolState,
    acting: Vec<Acting>,
}

impl ToolLoad {
    pub(super) fn new(settings: &RigSettings) -> Result<Self> {
        let s = &settings.sensor;
        check_all("rig.gravity_m_s2", &settings.gravity_m_s2, -100.0, 100.0)?;
        check_tool(s)?;
        let rotation = orientation_from_abc(&s.orientation_abc_rad);
        let tool = Tool {
            mass_kg: s.tool_mass_kg,
            com: vector(&s.tool_com_m),
            inertia: matrix(&s.tool_inertia_kg_m2),
        };
        let laws = hidden::in_order(&settings.hidden, Group::Sensor);
        Ok(Self {
            m_from_s: Pose::from_parts(vector::<f64>(&s.position_m).into(), rotation),
            tool,
            at_rest: ToolState {
                mass_kg: tool.mass_kg,
                hanging_kg: tool.mass_kg,
                com: tool.com,
                inertia: tool.inertia,
                gravity: vector(&settings.gravity_m_s2),
                s_from_c: Matrix3::identity(),
                motion: LoadMotion::uniform(),
                inertial: s.inertial_load,
            },
            acting: laws
                .filter_map(|(effect, values)| match effect.law {
                    Law::Tool(law) => Some((law, values)),
                    _ => None,
                })
                .collect(),
        })
    }

    /// Whether acceleration loads the sensor.
    pub(super) fn has_inertia(&self) -> bool {
        let mut pushed = self.at_rest;
        pushed.motion.acceleration = Vector3::repeat(1.0);
        let moves = |(law, p): &Acting| law(p, &pushed) != law(p, &self.at_rest);
        self.at_rest.inertial || self.acting.iter().any(moves)
    }

    /// Contact, weight and inertia at S: the load's reaction.
    pub(super) fn wrench(&self, load: &Load) -> Wrench<f64> {
        let s_from_m = self.m_from_s.rotation.inverse();
        let state = ToolState {
            s_from_c: (s_from_m * load.c_from_m.rotation.inverse())
                .to_rotation_matrix()
                .into_inner(),
            motion: LoadMotion::of_sensor(
                &self.m_from_s,
                &load.c_from_m.rotation,
                &load.twist,
                &load.acceleration,
            ),
            ..self.at_rest
        };
        let nominal = load.contact.transferred(&self.m_from_s.inverse()) + self.tool.wrench(&state);
        let hidden = self.acting.iter().map(|(law, p)| law(p, &state));
        hidden.fold(nominal, |sum, wrench| sum + wrench)
    }
}

fn check_tool(s: &SensorSettings) -> Result<()> {
    check("rig.sensor.tool_mass_kg", s.tool_mass_kg, 0.0, 1000.0)?;
    check_all("rig.sensor.tool_com_m", &s.tool_com_m, -10.0, 10.0)?;
    let inertia = s.tool_inertia_kg_m2;
    let moments = [inertia[0][0], inertia[1][1], inertia[2][2]];
    check_all("rig.sensor.tool_inertia_kg_m2", &moments, 0.0, 1000.0)?;
    let all = inertia.as_flattened();
    check_all("rig.sensor.tool_inertia_kg_m2", all, -1000.0, 1000.0)
}
