//! The effect catalogue for people: what each effect looks like in a recording, and a page that
//! teaches it.
//!
//! A [`Picture`] shows a canned excitation without and with an effect. Its curves are computed by
//! the catalogue's own implementation of the effect, so a picture cannot disagree with what the
//! simulated rig and the fit do.
//!
//! ```
//! use softdock::catalogue::{lesson, picture};
//! use softdock_physics::effects::by_id;
//!
//! let effect = by_id("zero_cross_pause").unwrap();
//! let picture = picture(effect)?;
//! println!("{}", lesson(effect, &picture));
//! assert!(picture.to_plot(effect).to_svg()?.starts_with("<svg"));
//! # Ok::<(), anyhow::Error>(())
//! ```

mod actuator;
mod body;
mod docking;
mod excitation;
mod lesson;
mod mechanism;
mod overview;
mod picture;
mod sensor;
mod size;
mod terminal;

#[cfg(test)]
mod tests;

pub use excitation::Excitation;
pub use lesson::{lesson, page};
pub use overview::overview;
pub use picture::Picture;

use anyhow::Result;
use size::Size;
use softdock_physics::effects::{Effect, Group};

/// The picture of an effect.
///
/// # Errors
///
/// The effect has no picture, which no effect of the catalogue reports.
pub fn picture(effect: &Effect) -> Result<Picture> {
    let size = Size::of(effect);
    match effect.group {
        Group::Actuator => actuator::picture(effect, &size),
        Group::Mechanism => mechanism::picture(effect, &size),
        Group::Sensor => sensor::picture(effect, &size),
        Group::Body => body::picture(effect, &size),
    }
}
