//! Docking-rig logs with a hidden physical effect: an independent test for tools that look for the missing effect between a
//! model and a measurement.
//!
//! # Cases
//! A [`Case`] is a user's nominal model (`meta.json`), two logs of a rig (`train.csv`,
//! `test.csv`, format docking-rig-log/1) and the [`Truth`]: which effect the plant contains that
//! the model does not know, how large it is, and how small the error could be ([the oracle][o]).
//!
//! ```
//! let case = softdock_hidden_effects::suite(1)[0].generate();
//! assert!(case.train_csv.starts_with("t,mode,fx,fy,fz"));
//! ```
//!
//! # The rig
//! Order inside a tick: measure, model, command. The first 1000 rows are an operator jog
//! (a multi-sine velocity per axis); then a spacecraft model, fed with the measured wrench minus
//! gravity and bias, commands its own velocity. The robot executes the held command after a
//! transport delay and a first-order lag; the tip meets two walls along world x and a spring
//! guide across. There is no delay compensation, so contacts gain energy as on a real rig.
//!
//! # Modules
//! | Module | Content |
//! |---|---|
//! | `meta` | the nominal model, and as a second value the true plant |
//! | `rig`, `jog`, `size`, `limit`, `small` | drawing a rig, the operator's motion, an effect of a given size |
//! | `actuator`, `load`, `sensor`, `body` | the parts of the loop, with the effects inside them |
//! | `simulate`, `log` | the closed loop; rows and text |
//! | `residual` | residuals and their normalised size z, written from the format's definitions |
//! | `suite`, `harder`, `case` | lists of cases; one case |
//! | `truth`, [`score`] | the answer and its JSON; the scores |
//!
//! # Independence
//! The crate uses no softdock crate. Its equations are a second implementation, and its effects
//! differ on purpose in details that a catalogue cannot know: smoothing of friction, trigger and
//! reset of a pause, limits before or after the lag, shape of a drift, entries of a cross-talk.
//!
//! [o]: Truth::z_oracle_test

mod actuator;
mod body;
mod case;
mod effect;
mod harder;
mod jog;
mod limit;
mod load;
mod log;
mod meta;
mod noise;
mod residual;
mod rig;
pub mod score;
mod sensor;
mod simulate;
mod size;
mod small;
mod suite;
mod truth;

pub use case::{Case, CaseSpec};
pub use effect::{IDS, OUTSIDE_IDS};
pub use log::HEADER;
pub use noise::NoiseRange;
pub use residual::normalised;
pub use suite::{nothing_hidden, size_sweep, suite};
pub use truth::{Level, Truth, Verdict, parse_truth, truth_json};
