//! Everything between the moving spacecraft and the laboratory: the spring rod and other docking
//! mechanisms, side by side.
//!
//! The robot is stiff: contact does not move it. The forces therefore depend on pose and twist, and on
//! what a mechanism remembers of the way, which moves on with each integration step.

use super::drive::Axes;
use super::hidden::{self, Hidden};
use super::settings::MechanismSettings;
use super::spring_rod::{MAX_WALLS, SpringRod};
use anyhow::{Context, Result, ensure};
use nalgebra::Vector3;
use softdock_control::frames::{Pose, Twist, Wrench};
use softdock_mechanism::{Docking, DockingSettings, EnergyBalance, EnergyTracked, Loads, Relative};
use softdock_physics::effects::{Group, Law};

/// Mechanisms beside the spring rod that a rig can have.
const MAX_DOCKINGS: usize = 4;

/// All contacts at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Contact {
    /// Of walls and docking mechanisms, at M, in M axes.
    pub(super) wrench: Wrench<f64>,
    /// Of the guide and the cables, likewise.
    pub(super) guide: Wrench<f64>,
    /// Penetration of each wall, m; negative is the distance, unused walls are 0.
    pub(super) penetration_m: [f64; MAX_WALLS],
}

/// The spring rod and the docking mechanisms.
#[derive(Clone, Debug)]
pub(super) struct Mechanism {
    rod: EnergyTracked<SpringRod>,
    dockings: Vec<Docking>,
}

/// A docking mechanism as hidden effects make it.
fn with_hidden(docking: &DockingSettings, hidden: &[Hidden]) -> DockingSettings {
    let mut docking = *docking;
    for (effect, values) in hidden::in_order(hidden, Group::Mechanism) {
        if let Law::Docking(law) = effect.law {
            law(&values, &mut docking.kind);
        }
    }
    docking
}

impl Mechanism {
    /// The mechanism with M at `start`.
    pub(super) fn new(
        settings: &MechanismSettings,
        hidden: &[Hidden],
        start: &Axes,
        sensor: Vector3<f64>,
    ) -> Result<Self> {
        let count = settings.docking.len();
        ensure!(
            count <= MAX_DOCKINGS,
            "rig.mechanism.docking: {count} mechanisms, allowed are 0 to {MAX_DOCKINGS}"
        );
        let dockings = settings.docking.iter().enumerate().map(|(i, docking)| {
            Docking::new(&with_hidden(docking, hidden))
                .with_context(|| format!("in [[rig.mechanism.docking]] number {}", i + 1))
        });
        Ok(Self {
            rod: EnergyTracked::new(SpringRod::new(settings, hidden, start, sensor)?),
            dockings: dockings.collect::<Result<_>>()?,
        })
    }

    /// Advances mechanisms with a memory by an integration step that ends at a pose C_from_M, with the mean twist of M, and books
    /// the energy.
    pub(super) fn advance(&mut self, c_from_m: &Pose<f64>, twist: &Twist<f64>, step_s: f64) {
        let at = Relative {
            p_from_j: *c_from_m,
            twist: *twist,
        };
        self.rod.advance(&at, step_s);
        for docking in &mut self.dockings {
            docking.advance(c_from_m, twist, step_s);
        }
    }

    /// Forces for a pose C_from_M and the twist of M.
    pub(super) fn evaluate(&self, c_from_m: &Pose<f64>, twist: &Twist<f64>) -> Contact {
        let rod = &self.rod.mechanism;
        let walls = rod.walls(c_from_m, twist);
        let dockings = self
            .dockings
            .iter()
            .map(|docking| docking.wrench(c_from_m, twist));
        Contact {
            wrench: dockings.fold(walls.wrench, |sum, wrench| sum + wrench),
            guide: rod.guide(c_from_m, twist),
            penetration_m: walls.penetration_m,
        }
    }

    /// Whether latches hold the spacecraft.
    pub(super) fn captured(&self) -> bool {
        self.dockings.iter().any(Docking::captured)
    }

    /// The largest loads of each docking mechanism.
    pub(super) fn loads(&self) -> impl Iterator<Item = Loads> {
        self.dockings.iter().map(Docking::loads)
    }

    /// The energy balance.
    pub(super) fn balance(&self) -> EnergyBalance {
        let dockings = self.dockings.iter().map(Docking::balance);
        dockings.fold(self.rod.balance(), |sum, balance| sum + balance)
    }
}
