//! What a viewer draws: flange and sensor, both spacecraft with their docking surfaces, and the contact force.
//!
//! A recording does not contain the shape of bodies. They are drawn as spheres that reach from the centre of mass to the
//! docking surface.

use super::messages::{Transform, header, pose, vector};
use crate::recording::cdr::Encoder;
use crate::recording::field::EachNumber;
use nalgebra::Vector3;
use softdock_app::record::CycleRecord;
use softdock_control::io::Trace;
use softdock_control::settings::Settings;

// Values of `visualization_msgs/Marker`.
const ARROW: i32 = 0;
const SPHERE: i32 = 2;
const CYLINDER: i32 = 3;
const TEXT_VIEW_FACING: i32 = 9;
const ADD: i32 = 0;
const DELETE: i32 = 2;

/// Red, green, blue, opacity.
type Color = [f32; 4];
const GREY: Color = [0.55, 0.55, 0.6, 1.0];
const BLUE: Color = [0.2, 0.45, 0.9, 0.35];
const ORANGE: Color = [0.95, 0.6, 0.15, 0.35];
const RED: Color = [0.9, 0.1, 0.1, 1.0];

/// Diameter of flange and docking surfaces, m.
const DISC_M: f64 = 0.12;
/// Thickness of the docking surfaces, m.
const THICK_M: f64 = 0.01;
/// Radius of a body whose docking surface coincides with its centre of mass, m.
const BODY_M: f64 = 0.1;
/// Length of the arrow for the largest force of a recording, m.
const ARROW_M: f64 = 0.3;
/// Share of the largest force below which no arrow is drawn.
const NO_CONTACT: f64 = 1e-3;
/// Height of letters, m.
const TEXT_M: f64 = 0.03;

/// An object to draw, at a frame or between two points of it.
#[derive(Default)]
pub(super) struct Marker {
    frame: &'static str,
    /// Name among the markers of the topic.
    name: &'static str,
    kind: i32,
    action: i32,
    /// Place in the frame, m.
    position: [f64; 3],
    /// Size along x, y and z, m.
    scale: [f64; 3],
    color: Color,
    /// Ends of an arrow, m.
    points: Vec<[f64; 3]>,
    text: String,
}

/// Encodes a `visualization_msgs/MarkerArray`.
pub(super) fn write(message: &mut Encoder, time_ns: u64, markers: &[Marker]) {
    message.count(markers.len());
    for marker in markers {
        header(message, time_ns, marker.frame);
        message.text(marker.name);
        // Id within the namespace, kind, action.
        let numbers = [0, marker.kind, marker.action];
        numbers.iter().for_each(|number| message.number(*number));
        let [x, y, z] = marker.position;
        pose(message, [x, y, z, 1.0, 0.0, 0.0, 0.0]);
        vector(message, &marker.scale);
        marker.color.iter().for_each(|part| message.number(*part));
        // Lifetime 0: it stays until it is replaced. Locked to its frame.
        message.number(0_i32);
        message.number(0_u32);
        message.number(true);
        message.count(marker.points.len());
        vector(message, marker.points.as_flattened());
        // No colours of single points, no texture.
        message.count(0);
        message.text("");
        header(message, 0, "");
        message.text("");
        message.count(0);
        message.count(0);
        message.text(&marker.text);
        // No mesh, neither by name nor as a file.
        message.text("");
        message.text("");
        message.count(0);
        message.number(false);
    }
}

/// Markers at those of the frames that are known.
pub(super) fn scene(settings: Option<&Settings>, fixed: &[Transform]) -> Vec<Marker> {
    let reach = |of: fn(&Settings) -> [f64; 3]| {
        let surface = settings.map_or(0.0, |settings| Vector3::from(of(settings)).norm());
        if surface > 0.0 { surface } else { BODY_M }
    };
    let mut scene = vec![
        disc("M", "flange", GREY, 3.0 * THICK_M),
        label("M", "M, flange"),
    ];
    for Transform { child, .. } in fixed {
        match *child {
            "S" => scene.push(disc("S", "sensor", GREY, THICK_M)),
            "Q" => {
                let radius = reach(|settings| settings.frames.p_position_m);
                scene.extend([
                    body("Q", "spacecraft Q", BLUE, radius),
                    label("Q", "Q, spacecraft"),
                ]);
                let radius = reach(|settings| settings.frames.j_position_m);
                scene.extend([
                    body("K", "spacecraft K", ORANGE, radius),
                    label("K", "K, spacecraft as the model sees it"),
                ]);
            }
            "P" => scene.push(disc("P", "docking surface P", BLUE, THICK_M)),
            "J" => scene.push(disc("J", "docking surface J", ORANGE, THICK_M)),
            _ => {}
        }
    }
    scene
}

fn disc(frame: &'static str, name: &'static str, color: Color, thick: f64) -> Marker {
    Marker {
        frame,
        name,
        kind: CYLINDER,
        scale: [DISC_M, DISC_M, thick],
        color,
        ..Marker::default()
    }
}

fn body(frame: &'static str, name: &'static str, color: Color, radius: f64) -> Marker {
    Marker {
        frame,
        name,
        kind: SPHERE,
        scale: [2.0 * radius; 3],
        color,
        ..Marker::default()
    }
}

fn label(frame: &'static str, name: &'static str) -> Marker {
    Marker {
        frame,
        name,
        kind: TEXT_VIEW_FACING,
        position: [0.0, 0.0, DISC_M],
        scale: [0.0, 0.0, TEXT_M],
        color: GREY,
        text: name.to_owned(),
        ..Marker::default()
    }
}

/// The contact force at the docking surface of the flange.
pub(super) struct Contact {
    /// Position of the docking surface in M, taken from K: both frames coincide.
    surface_m: Vector3<f64>,
    largest_force_n: f64,
}

impl Contact {
    pub(super) fn new(settings: Option<&Settings>, cycles: &[CycleRecord]) -> Self {
        let surface = settings.map_or([0.0; 3], |settings| settings.frames.j_position_m);
        let forces = cycles.iter().map(|cycle| force(&cycle.trace).norm());
        Self {
            surface_m: Vector3::from(surface),
            largest_force_n: forces.fold(0.0, f64::max),
        }
    }

    /// An arrow and its force in words; both are deleted where there is no contact.
    pub(super) fn markers(&self, trace: &Trace) -> [Marker; 2] {
        let force = force(trace);
        let newton = force.norm();
        let tip = self.surface_m + force * (ARROW_M / self.largest_force_n);
        let touches = newton > NO_CONTACT * self.largest_force_n;
        let marker = |name, kind, scale| Marker {
            frame: "M",
            name,
            kind,
            action: if touches { ADD } else { DELETE },
            scale,
            color: RED,
            ..Marker::default()
        };
        // Diameter of the shaft, diameter of the head, length of the head.
        let mut arrow = marker("contact force", ARROW, [0.01, 0.02, 0.04]);
        let mut text = marker("contact force in N", TEXT_VIEW_FACING, [0.0, 0.0, TEXT_M]);
        if touches {
            arrow.points = vec![self.surface_m.into(), tip.into()];
            text.position = (tip + Vector3::z() * TEXT_M).into();
            text.text = format!("{newton:.1} N");
        }
        [arrow, text]
    }
}

/// Contact force at M in axes of M, N.
fn force(trace: &Trace) -> Vector3<f64> {
    let [x, y, z, ..] = trace.wrench_at_m;
    Vector3::new(x, y, z)
}
