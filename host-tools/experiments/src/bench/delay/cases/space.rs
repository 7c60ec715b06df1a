//! Contacts in space: oblique, off the centre, with friction, between two free spacecraft, in a cone.

use super::super::case::Case;
use super::super::scene::{End, INERTIA_KG_M2, MASS_KG, Scene, Shape};

pub(super) fn cases() -> Vec<Case> {
    let mut cases = off_centre();
    cases.extend(oblique());
    cases.extend(free_spacecraft());
    cases.extend(cones());
    for case in &mut cases {
        case.touches = 4;
    }
    cases
}

fn entry(sweep: &'static str, name: impl Into<String>, change: impl FnOnce(&mut Scene)) -> Case {
    let mut case = Case::new(sweep, name);
    change(&mut case.scene);
    case
}

/// Contacts off the centre; a is the lever divided by the radius of gyration about z.
fn off_centre() -> Vec<Case> {
    let gyration = (INERTIA_KG_M2[2] / MASS_KG).sqrt();
    [0.5, 1.0, 2.0]
        .map(|a| {
            let mut case = entry("off_centre", format!("off_centre_{a}"), |scene| {
                scene.probe = [0.0, a * gyration, 0.0];
            });
            case.quick = a == 1.0;
            case
        })
        .into()
}

/// A wall that is turned by an angle about z, or about an axis across.
fn tilted(angle_deg: f64) -> Shape {
    let (sin, cos) = angle_deg.to_radians().sin_cos();
    Shape::Wall([-cos, sin, 0.0])
}

fn tilted_in_space(angle_deg: f64) -> Shape {
    let (sin, cos) = angle_deg.to_radians().sin_cos();
    Shape::Wall([-cos, 0.8 * sin, 0.6 * sin])
}

/// Probe, spin and wall of the general contact.
fn general(scene: &mut Scene) {
    scene.probe = [0.2, 0.15, -0.1];
    scene.spin = [0.5, -0.4, 0.8];
    scene.shape = tilted_in_space(25.0);
    scene.law.friction = 0.2;
}

fn oblique() -> Vec<Case> {
    let slip = |scene: &mut Scene| {
        scene.shape = tilted(45.0);
        scene.direction = [0.8, 0.6, 0.0];
        scene.law.friction = 0.2;
    };
    vec![
        entry("oblique", "oblique_22.5_deg", |s| s.shape = tilted(22.5)),
        entry("oblique", "oblique_45_deg", |s| s.shape = tilted(45.0)).quick(),
        entry("oblique", "oblique_30_deg_friction_0.2", |s| {
            s.shape = tilted(30.0);
            s.law.friction = 0.2;
        }),
        entry("oblique", "oblique_45_deg_slip_friction_0.2", slip),
        entry("oblique", "offset_300_mm_friction_0.2", |s| {
            s.probe = [0.0, 0.3, 0.0];
            s.law.friction = 0.2;
        }),
        entry("oblique", "oblique_offset_spin_friction_0.2", general).quick(),
        entry("oblique", "oblique_offset_spin_damping_0.2", |s| {
            general(s);
            *s = s.clone().damped(0.2);
        }),
    ]
}

fn free_spacecraft() -> Vec<Case> {
    let other = |mass_kg: f64| move |scene: &mut Scene| scene.other_mass_kg = mass_kg;
    vec![
        entry("free_craft", "free_500_kg", other(500.0)),
        entry("free_craft", "free_2000_kg", other(2000.0)).quick(),
        entry("free_craft", "free_2000_kg_offset_150_mm", |s| {
            s.other_mass_kg = 2000.0;
            s.probe = [0.0, 0.15, 0.0];
        }),
        entry("free_craft", "free_2000_kg_oblique_offset_spin", |s| {
            general(s);
            s.other_mass_kg = 2000.0;
        }),
    ]
}

/// The probe comes in beside the cone's axis and hits one side after the other.
fn cones() -> Vec<Case> {
    let cone = |degrees: f64| {
        move |scene: &mut Scene| {
            scene.shape = Shape::Cone {
                half_angle: f64::to_radians(degrees),
                beside_s: 0.15,
            };
            scene.law.friction = 0.2;
            scene.end = End::After(2.0);
        }
    };
    vec![
        entry("cone", "cone_45_deg", cone(45.0)).quick(),
        entry("cone", "cone_60_deg_probe_300_mm", |s| {
            cone(60.0)(s);
            s.probe = [0.3, 0.0, 0.0];
        }),
        entry("cone", "cone_60_deg_free_2000_kg", |s| {
            cone(60.0)(s);
            s.other_mass_kg = 2000.0;
        }),
        entry("cone", "cone_30_deg", cone(30.0)),
    ]
}
