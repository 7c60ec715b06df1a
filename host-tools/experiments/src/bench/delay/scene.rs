//! The docking of a case: two spacecraft and the mechanism between them, for any speed.

use softdock_control::settings::BodySettings;
use softdock_delay_plants::truth::{Body, FreeTest, Twist};
use softdock_delay_plants::{Cone, Contact, ForceLaw, Surface, Wall};
use std::f64::consts::PI;

/// Mass of the moved spacecraft unless a case says otherwise, kg.
pub const MASS_KG: f64 = 500.0;
/// Its moments of inertia, kg·m².
pub const INERTIA_KG_M2: [f64; 3] = [180.0, 220.0, 210.0];
/// ω = √(k/m) of the contact unless a case says otherwise, rad/s.
pub const OMEGA_RAD_S: f64 = 21.0;
/// Distance from the spacecraft K to the spacecraft Q along x, m.
pub(super) const APART_M: f64 = 1.0;

/// Shape of what is touched.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape {
    /// A wall with this unit normal, out of the wall.
    Wall([f64; 3]),
    /// Two walls that face each other along x.
    TwoWalls,
    /// The inside of a cone along x. The probe comes in beside its axis.
    Cone {
        /// Angle between axis and wall, rad.
        half_angle: f64,
        /// Offset of the probe from the axis, divided by the speed of approach, s.
        beside_s: f64,
    },
}

/// When a test is over.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum End {
    /// After this many impacts.
    Impacts(usize),
    /// This long after the first touch, s.
    After(f64),
}

/// Two spacecraft and the mechanism between them.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    /// Mass of K, kg.
    pub mass_kg: f64,
    /// Mass of Q, kg; infinite: fixed.
    pub other_mass_kg: f64,
    /// Position of the probe on K, m.
    pub probe: [f64; 3],
    /// Direction of the approach, a unit vector.
    pub direction: [f64; 3],
    /// Angular velocity of K divided by its speed, rad/m.
    pub spin: [f64; 3],
    /// Shape of the surface that is touched.
    pub shape: Shape,
    /// Force law of the contact.
    pub law: ForceLaw,
    /// When the test is over.
    pub end: End,
}

impl Scene {
    /// Straight onto a fixed wall with ω = 21 rad/s: the canonical test.
    pub fn head_on() -> Self {
        Self {
            mass_kg: MASS_KG,
            other_mass_kg: f64::INFINITY,
            probe: [0.0; 3],
            direction: [1.0, 0.0, 0.0],
            spin: [0.0; 3],
            shape: Shape::Wall([-1.0, 0.0, 0.0]),
            law: ForceLaw::linear(MASS_KG * OMEGA_RAD_S * OMEGA_RAD_S, 0.0),
            end: End::Impacts(1),
        }
    }

    /// The scene with the damping ratio `zeta` of the head-on contact.
    pub fn damped(mut self, zeta: f64) -> Self {
        self.law.damping = 2.0 * zeta * (self.law.stiffness * self.mass_kg).sqrt();
        self
    }

    /// Whether the bounce has a closed form: one mass, one linear wall, straight on.
    pub fn is_straight(&self) -> bool {
        let straight = [-1.0, 0.0, 0.0];
        self.law.exponent == 1.0
            && self.law.friction == 0.0
            && self.probe == [0.0; 3]
            && self.spin == [0.0; 3]
            && self.direction == [1.0, 0.0, 0.0]
            && self.other_mass_kg.is_infinite()
            && (self.shape == Shape::Wall(straight) || self.shape == Shape::TwoWalls)
    }

    /// ω = √(k/m), rad/s, of the head-on contact.
    pub fn omega(&self) -> f64 {
        (self.law.stiffness / self.mass_kg).sqrt()
    }

    /// ζ of the head-on contact.
    pub fn zeta(&self) -> f64 {
        self.law.damping / (2.0 * (self.law.stiffness * self.mass_kg).sqrt())
    }

    /// Unit normal of the first contact; None where it changes during the test.
    pub fn normal(&self) -> Option<[f64; 3]> {
        match self.shape {
            Shape::Wall(normal) => Some(normal),
            Shape::TwoWalls => Some([-1.0, 0.0, 0.0]),
            Shape::Cone { .. } => None,
        }
    }

    /// The mechanism, placed such that the probe touches after a flight of `flight_s` at this speed.
    pub fn contact(&self, speed_m_s: f64, flight_s: f64) -> Contact {
        let law = self.law;
        let wall =
            |point: [f64; 3], normal: [f64; 3]| -> Surface { Wall { point, normal, law }.into() };
        let flown = speed_m_s * flight_s;
        // The spin is slow: the probe moves along the tangent.
        let turned = cross(self.spin, self.probe);
        let touch: [f64; 3] =
            std::array::from_fn(|i| self.probe[i] + flown * (self.direction[i] + turned[i]));
        let surfaces = match self.shape {
            Shape::Wall(normal) => vec![wall(touch, normal)],
            Shape::TwoWalls => {
                let behind = [self.probe[0] - flown, 0.0, 0.0];
                vec![wall(touch, [-1.0, 0.0, 0.0]), wall(behind, [1.0, 0.0, 0.0])]
            }
            Shape::Cone {
                half_angle,
                beside_s,
            } => {
                let beside = speed_m_s * beside_s;
                let apex = [
                    touch[0] + beside / half_angle.tan(),
                    touch[1] - beside,
                    touch[2],
                ];
                let cone = Cone {
                    apex,
                    axis: [-1.0, 0.0, 0.0],
                    half_angle,
                    law,
                };
                vec![cone.into()]
            }
        };
        Contact {
            probes: vec![self.probe],
            surfaces,
        }
    }

    /// The simulation of the ideal test.
    pub fn free_test(&self, speed_m_s: f64, flight_s: f64) -> FreeTest {
        let body = |mass_kg, inertia_kg_m2, x, velocity| Body {
            mass_kg,
            inertia_kg_m2,
            position_m: [x, 0.0, 0.0],
            velocity,
        };
        let moving = Twist {
            linear: self.direction.map(|d| d * speed_m_s).into(),
            angular: self.spin.map(|s| s * speed_m_s).into(),
        };
        FreeTest {
            k: body(self.mass_kg, self.inertia(), 0.0, moving),
            q: body(
                self.other_mass_kg,
                self.other_inertia(),
                APART_M,
                Twist::default(),
            ),
            contact: self.contact(speed_m_s, flight_s),
        }
    }

    /// Settings of the two spacecraft for the board.
    pub fn spacecraft(&self, speed_m_s: f64) -> [BodySettings; 2] {
        let diagonal = |[x, y, z]: [f64; 3]| [[x, 0.0, 0.0], [0.0, y, 0.0], [0.0, 0.0, z]];
        let k = BodySettings {
            mass_kg: self.mass_kg,
            inertia_kg_m2: diagonal(self.inertia()),
            velocity_m_s: self.direction.map(|d| d * speed_m_s),
            angular_velocity_rad_s: self.spin.map(|s| s * speed_m_s),
            ..BodySettings::default()
        };
        let fixed = self.other_mass_kg.is_infinite();
        let mut q = BodySettings {
            fixed,
            inertia_kg_m2: diagonal(self.other_inertia()),
            position_m: [APART_M, 0.0, 0.0],
            ..BodySettings::default()
        };
        if !fixed {
            q.mass_kg = self.other_mass_kg;
        }
        [k, q]
    }

    /// A rough length of the contact, s: half a period of the head-on contact.
    pub fn contact_s(&self) -> f64 {
        PI / OMEGA_RAD_S.min(self.omega().max(5.0))
    }

    /// Moments of inertia of K, kg·m²: those of the canonical spacecraft, scaled by the mass.
    pub(super) fn inertia(&self) -> [f64; 3] {
        INERTIA_KG_M2.map(|i| i * self.mass_kg / MASS_KG)
    }

    /// Moments of inertia of Q, kg·m².
    pub(super) fn other_inertia(&self) -> [f64; 3] {
        let mass = if self.other_mass_kg.is_finite() {
            self.other_mass_kg
        } else {
            MASS_KG
        };
        INERTIA_KG_M2.map(|i| i * mass / MASS_KG)
    }
}

fn cross([a, b, c]: [f64; 3], [x, y, z]: [f64; 3]) -> [f64; 3] {
    [b * z - c * y, c * x - a * z, a * y - b * x]
}
