//! Pictures of what a docking mechanism can be in place of the nominal one.

use super::excitation::{BOUNCE_S, Excitation, STEP_S, bounce, instants};
use super::picture::{Curve, Picture};
use super::size::Size;
use anyhow::{Context, Result};
use nalgebra::Vector3;
use softdock_mechanism::{Kind, Mechanism, Relative};

/// One mechanism of each kind. An effect is pictured on the first one that it changes.
const MECHANISMS: [&str; 3] = [
    r#"{"two_stage": {"preload_n": 20, "stiffness_n_per_m": 5e3, "second_stage_m": 0.05,
        "second_stiffness_n_per_m": 4e4, "brake_n": 5, "seat_stiffness_n_per_m": 1e6}}"#,
    r#"{"probe_cone": {"half_angle_rad": 0.9, "mouth_radius_m": 0.25, "head_radius_m": 0.04,
        "surface": {"stiffness_n_per_m": 2e4, "friction_coefficient": 0.1},
        "socket": {"capture_depth_m": 0.006, "capture_radius_m": 0.008, "latch_stiffness_n_per_m": 5e3}}}"#,
    r#"{"soft_capture": {"capture_gap_m": 0.02,
        "legs": {"base_radius_m": 0.7, "ring_radius_m": 0.65, "height_m": 0.5, "spread_rad": 0.15,
                 "stiffness_n_per_m": 2000, "damping_n_s_per_m": 80},
        "petals": {"angle_rad": 0.7, "length_m": 0.2, "clearance_m": 0.003, "edge_radius_m": 0.6},
        "surface": {"stiffness_n_per_m": 5e5}}}"#,
];
/// Lateral offset of J from the mechanism's axis, m.
const BESIDE_M: f64 = 0.002;

/// Force along the axis over time, while the surface moves in and out: with the nominal mechanism, and with the changed one.
pub(super) fn picture(size: &Size, change: impl Fn(&mut Kind)) -> Result<Picture> {
    let mechanisms = MECHANISMS.iter().map(|text| serde_json::from_str(text));
    let mechanisms: Vec<Kind> = mechanisms.collect::<Result<_, _>>()?;
    let pair = |nominal: Kind| {
        let mut changed = nominal;
        change(&mut changed);
        (changed != nominal).then_some([nominal, changed])
    };
    let pair = mechanisms.into_iter().find_map(pair);
    let pair = pair.context("the effect changes none of the pictured mechanisms")?;
    let labels = ["time [s]", "force along the axis [N]"];
    Ok(Picture::new(
        Excitation::Bounce,
        size,
        labels,
        pair.map(bounced),
    ))
}

fn bounced(mut kind: Kind) -> Curve {
    let at = |t: f64| {
        let motion = bounce(t);
        let mut at = Relative::along_x(motion.position, motion.velocity);
        at.p_from_j.translation.vector += Vector3::y() * BESIDE_M;
        kind.advance(&at, STEP_S);
        (t, -kind.reaction(&at).wrench.force.x)
    };
    instants(BOUNCE_S).map(at).collect()
}
