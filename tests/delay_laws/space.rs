//! Oblique and off-centre contacts of two free spacecraft, against a fine integration of the ideal test.

use super::case::Case;
use nalgebra::Vector3;
use softdock_control::delay::LawName;
use softdock_delay_plants::truth::{Body, FreeTest, Twist};
use softdock_delay_plants::{Contact, Wall};

const SPEED_M_S: f64 = 0.01;
/// A rotation counts at this distance, m.
const LEVER_M: f64 = 0.3;

struct Flight {
    name: &'static str,
    normal: Vector3<f64>,
    probe: [f64; 3],
    free_q: bool,
}

fn flights() -> [Flight; 4] {
    let normal = |x: f64, y: f64, z: f64| Vector3::new(x, y, z).normalize();
    [
        Flight {
            name: "head-on",
            normal: normal(-1.0, 0.0, 0.0),
            probe: [0.0; 3],
            free_q: false,
        },
        Flight {
            name: "oblique 45°",
            normal: normal(-1.0, 1.0, 0.0),
            probe: [0.0; 3],
            free_q: false,
        },
        Flight {
            name: "off centre",
            normal: normal(-1.0, 0.0, 0.0),
            probe: [0.0, 0.2, 0.0],
            free_q: false,
        },
        Flight {
            name: "in space, two spacecraft",
            normal: normal(-1.0, 0.3, -0.2),
            probe: [0.25, 0.1, -0.15],
            free_q: true,
        },
    ]
}

/// Difference of the relative velocity after the contact from the ideal test's, by the speed.
fn error(law: LawName, flight: &Flight) -> f64 {
    let mut case = Case::scenario_s(law);
    let settings = &mut case.settings;
    settings.body_k.inertia_kg_m2 = [[100.0, 0.0, 0.0], [0.0, 120.0, 0.0], [0.0, 0.0, 90.0]];
    settings.body_k.velocity_m_s = [SPEED_M_S, 0.0, 0.0];
    settings.body_q.fixed = !flight.free_q;
    settings.body_q.mass_kg = 2000.0;
    settings.body_q.inertia_kg_m2 = [[900.0, 0.0, 0.0], [0.0, 1100.0, 0.0], [0.0, 0.0, 1000.0]];
    settings.body_q.position_m = [1.5, 0.0, 0.0];
    settings.limits.box_rad = 1.0;
    let (k, _) = case.contact();
    let [px, py, pz] = flight.probe;
    let probe = Vector3::new(px, py, pz);
    let point = probe + Vector3::x() * (SPEED_M_S * 0.402);
    let wall = Wall::elastic(point.into(), flight.normal.into(), k);
    let contact = Contact {
        probes: vec![flight.probe],
        surfaces: vec![wall.into()],
    };
    let ideal = ideal(flight, &contact);
    case.plant.contact = contact;
    let mut rig = case.start::<f64>();
    for _ in 0..400 {
        rig.step();
        let over = rig.plant.log().contacts.first();
        if over.is_some_and(|c| c.release_s.is_some())
            && rig.driver.cycle.cycle().bodies().1.k.velocity.linear.x < SPEED_M_S
        {
            break;
        }
    }
    let mut last = rig.step();
    (0..15).for_each(|_| last = rig.step());
    let of = |v: [f64; 6]| {
        let [x, y, z, a, b, c] = v;
        (Vector3::new(x, y, z), Vector3::new(a, b, c) * LEVER_M)
    };
    let (linear, angular) = of(last.trace.body_k.velocity);
    let off =
        (linear - ideal.linear).norm_squared() + (angular - ideal.angular * LEVER_M).norm_squared();
    off.sqrt() / SPEED_M_S
}

fn ideal(flight: &Flight, contact: &Contact) -> Twist {
    let at_rest = Twist::default();
    let test = FreeTest {
        k: Body {
            mass_kg: 500.0,
            inertia_kg_m2: [100.0, 120.0, 90.0],
            position_m: [0.0; 3],
            velocity: Twist {
                linear: Vector3::x() * SPEED_M_S,
                ..at_rest
            },
        },
        q: Body {
            mass_kg: if flight.free_q { 2000.0 } else { f64::INFINITY },
            inertia_kg_m2: [900.0, 1100.0, 1000.0],
            position_m: [1.5, 0.0, 0.0],
            velocity: at_rest,
        },
        contact: contact.clone(),
    };
    test.run(5.0, 1).k
}

/// Known for the lead: .007 to .031 in other flights. On an oblique wall no axis reverses, so that
/// no pause makes up for what the lead brakes too much; without a pause its restitution is .93.
#[test]
fn contacts_in_space() {
    let bounds = [
        (LawName::Lead, 0.06),
        (LawName::Polynomial, 0.3),
        (LawName::Ats, 0.06),
        (LawName::Smith, 0.02),
        (LawName::Passivity, 0.05),
    ];
    for flight in flights() {
        for (law, bound) in bounds {
            let error = error(law, &flight);
            println!("{:20} {law:?}: {error:.4}", flight.name);
            assert!(error < bound, "{} {law:?}: {error}", flight.name);
        }
    }
}
