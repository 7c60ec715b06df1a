//! Surfaces and the force law of a point that is pressed into one.

use nalgebra::Vector3;

/// Slip velocity at which the smoothed Coulomb friction reaches 0.7 of its full value, m/s. Smoothing is needed as friction
/// has no direction at rest; the value is a hundredth of the slowest approach.
const SLIP_M_S: f64 = 1e-5;

/// Normal force k depth^p + c (closing velocity), never pulling; Coulomb friction across.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ForceLaw {
    /// k, N/m^p.
    pub stiffness: f64,
    /// p: 1 linear, 1.5 two spheres (Hertz).
    pub exponent: f64,
    /// c, N·s/m.
    pub damping: f64,
    /// Coefficient of Coulomb friction.
    pub friction: f64,
}

/// A flat wall.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wall {
    /// A point of it, m.
    pub point: [f64; 3],
    /// Unit normal, out of the wall.
    pub normal: [f64; 3],
    /// Force law of the wall.
    pub law: ForceLaw,
}

/// The inside of a cone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cone {
    /// Tip, m.
    pub apex: [f64; 3],
    /// Unit vector from the tip along the axis into the opening.
    pub axis: [f64; 3],
    /// Angle between axis and wall, rad.
    pub half_angle: f64,
    /// Force law of the cone.
    pub law: ForceLaw,
}

/// Something that a probe can touch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Surface {
    /// A flat wall.
    Wall(Wall),
    /// The inside of a cone.
    Cone(Cone),
}

/// One probe on one surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Touch {
    /// Depth, m; negative outside.
    pub depth: f64,
    /// Normal force, N.
    pub normal_force: f64,
    /// Force on the probe, N.
    pub force: Vector3<f64>,
}

impl Wall {
    /// A wall without damping and friction; stiffness in N/m.
    pub fn elastic(point: [f64; 3], normal: [f64; 3], stiffness: f64) -> Self {
        Self {
            point,
            normal,
            law: ForceLaw::linear(stiffness, 0.0),
        }
    }
}

impl From<Wall> for Surface {
    fn from(wall: Wall) -> Self {
        Self::Wall(wall)
    }
}

impl From<Cone> for Surface {
    fn from(cone: Cone) -> Self {
        Self::Cone(cone)
    }
}

impl ForceLaw {
    /// k depth + c (closing velocity), no friction; N/m and N·s/m.
    pub const fn linear(stiffness: f64, damping: f64) -> Self {
        Self {
            stiffness,
            exponent: 1.0,
            damping,
            friction: 0.0,
        }
    }

    /// The force on a point at a depth and with a velocity; `normal` points out of the surface.
    pub fn touch(&self, depth: f64, normal: &Vector3<f64>, velocity: &Vector3<f64>) -> Touch {
        let mut touch = Touch {
            depth,
            normal_force: 0.0,
            force: Vector3::zeros(),
        };
        if depth <= 0.0 {
            return touch;
        }
        let outward = velocity.dot(normal);
        let spring = self.stiffness * depth.powf(self.exponent);
        touch.normal_force = (spring - self.damping * outward).max(0.0);
        let slip = velocity - normal * outward;
        let rate = slip.norm_squared().sqrt().hypot(SLIP_M_S);
        touch.force = (normal - slip * (self.friction / rate)) * touch.normal_force;
        touch
    }
}

impl Surface {
    /// The touch of a point with this position and velocity.
    pub fn touch(&self, place: &Vector3<f64>, velocity: &Vector3<f64>) -> Touch {
        match self {
            Self::Wall(wall) => {
                let normal = Vector3::from(wall.normal);
                let depth = (Vector3::from(wall.point) - place).dot(&normal);
                wall.law.touch(depth, &normal, velocity)
            }
            Self::Cone(cone) => cone.touch(place, velocity),
        }
    }
}

impl Cone {
    fn touch(&self, place: &Vector3<f64>, velocity: &Vector3<f64>) -> Touch {
        let axis = Vector3::from(self.axis);
        let from_apex = place - Vector3::from(self.apex);
        let along = from_apex.dot(&axis);
        let across = from_apex - axis * along;
        let (sin, cos) = self.half_angle.sin_cos();
        let depth = across.norm() * cos - along * sin;
        let outside = across.try_normalize(1e-12).unwrap_or_else(Vector3::zeros);
        let normal = axis * sin - outside * cos;
        self.law.touch(depth, &normal, velocity)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::FRAC_PI_4;

    /// The normal is the direction in which the depth falls fastest, for both surfaces.
    #[test]
    fn normal_is_the_gradient_of_the_depth() {
        let law = ForceLaw::linear(1000.0, 0.0);
        let cone = Cone {
            apex: [0.1, 0.0, 0.0],
            axis: [-1.0, 0.0, 0.0],
            half_angle: FRAC_PI_4,
            law,
        };
        let place = Vector3::new(0.05, 0.06, 0.02);
        let touch = |p: Vector3<f64>| Surface::from(cone).touch(&p, &Vector3::zeros());
        let here = touch(place);
        assert!(here.depth > 0.0);
        let h = 1e-7;
        for i in 0..3 {
            let mut moved = place;
            moved[i] += h;
            let slope = (touch(moved).depth - here.depth) / h;
            let normal = here.force[i] / here.normal_force;
            assert!((slope + normal).abs() < 1e-5, "{i}: {slope} {normal}");
        }
    }

    /// Friction is μ N against the slip; a damper does not pull on separation.
    #[test]
    fn friction_and_release() {
        let law = ForceLaw {
            friction: 0.2,
            ..ForceLaw::linear(1000.0, 50.0)
        };
        let normal = Vector3::new(-1.0, 0.0, 0.0);
        let touch = law.touch(0.01, &normal, &Vector3::new(0.0, 0.03, 0.0));
        assert!((touch.force.y + 2.0).abs() < 1e-5, "{:?}", touch.force);
        assert!((touch.force.x + 10.0).abs() < 1e-12);
        let leaving = law.touch(0.01, &normal, &Vector3::new(-1.0, 0.0, 0.0));
        assert_eq!(leaving.normal_force, 0.0);
    }
}
