//! The docking mechanism: probes on the flange that touch surfaces of the laboratory.
//!
//! The force follows from the true pose and velocity of the robot.

mod surface;

pub use surface::{Cone, ForceLaw, Surface, Touch, Wall};

use crate::pose::RobotPose;
use nalgebra::Vector3;

/// Probes and surfaces.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Contact {
    /// Points on the flange that can touch, m in M.
    pub probes: Vec<[f64; 3]>,
    /// Surfaces that the probes can touch.
    pub surfaces: Vec<Surface>,
}

/// Sum of all touches on the flange.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Load {
    /// Force on the flange, N, in the laboratory.
    pub(crate) force: Vector3<f64>,
    /// Torque on the flange about M, N·m, in the laboratory.
    pub(crate) torque: Vector3<f64>,
    /// Sum of the normal forces, N.
    pub(crate) normal_force: f64,
    /// Largest depth, m; if negative, its magnitude is the distance to the nearest surface.
    pub(crate) depth: f64,
}

impl Contact {
    /// Forces at a pose.
    pub(crate) fn load(&self, pose: &RobotPose) -> Load {
        let mut load = Load {
            depth: f64::NEG_INFINITY,
            ..Load::default()
        };
        for probe in &self.probes {
            let (place, velocity) = pose.point(&Vector3::from(*probe));
            for surface in &self.surfaces {
                let touch = surface.touch(&place, &velocity);
                load.depth = load.depth.max(touch.depth);
                if touch.depth > 0.0 {
                    load.force += touch.force;
                    load.torque += (place - pose.position).cross(&touch.force);
                    load.normal_force += touch.normal_force;
                }
            }
        }
        load
    }
}
