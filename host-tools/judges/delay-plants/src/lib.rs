//! Plants for the assessment of laws against a robot's delay: a late robot, a docking contact, a noisy sensor, and the ideal
//! test for comparison.
//!
//! A controller sends the velocity of each axis once per cycle. The plant returns what the board would measure. It knows
//! nothing of the controller's model of the spacecraft: a robot is position-controlled, so the contact force influences
//! nothing but the measurement.
//!
//! ```
//! use softdock_delay_plants::{Actuator, Contact, Measurement, Plant, PlantSettings, Wall};
//!
//! let wall = Wall::elastic([0.02, 0.0, 0.0], [-1.0, 0.0, 0.0], 220_500.0);
//! let mut plant = Plant::new(&PlantSettings {
//!     actuator: Actuator { delay_s: 0.032, pause_s: 0.016, ..Actuator::ideal() },
//!     contact: Contact { probes: vec![[0.0; 3]], surfaces: vec![wall.into()] },
//!     measurement: Measurement::default(),
//!     ..PlantSettings::default()
//! });
//! for _ in 0..2000 {
//!     let sample = plant.step([0.005, 0.0, 0.0, 0.0, 0.0, 0.0]);
//!     assert!(sample.wrench[0] <= 0.0);
//! }
//! assert!(plant.log().contacts[0].peak_force_n > 0.0);
//! ```
//!
//! # Axes
//! The robot's axes are X Y Z in m and A B C in rad, as KUKA's RSI moves them: A B C turn about z,
//! then the new y, then the new x. Wrenches stand at M, the origin of the flange, in its axes.
//!
//! # Modules
//! | Module | Content |
//! |---|---|
//! | [`Actuator`] | delay, lag or servo, pause, limits, jitter; closed forms between events |
//! | `actuator::fixed_steps` | the same robot in fixed small steps: a second formulation |
//! | [`Contact`] | walls and cones, elastic, damped or power law, Coulomb friction, lever arms |
//! | [`Plant`] | one cycle; what is measured; what really happened |
//! | [`truth`] | the ideal test: the bounce in closed form, and two free bodies |
//!
//! # Independence
//! The crate uses no softdock crate. The pause has the same definition as on the board, because it is a property of the
//! robot; its equations are implemented a second and a third time here.

mod actuator;
mod contact;
mod log;
mod measurement;
mod noise;
mod plant;
mod pose;
pub mod truth;

pub use actuator::{Actuator, DelayChange, Dynamics, Formulation};
pub use contact::{Cone, Contact, ForceLaw, Surface, Touch, Wall};
pub use log::{ContactRecord, Log, Moment};
pub use measurement::Measurement;
pub use plant::{Plant, PlantSettings, Sample};
pub use pose::RobotPose;

/// Robot axes X Y Z A B C: m and rad, m/s and rad/s.
pub type Axes = [f64; 6];
