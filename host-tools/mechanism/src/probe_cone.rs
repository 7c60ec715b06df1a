//! Probe and drogue: a round head that slides along a cone into a socket.

use crate::contact::{Surface, Touch};
use crate::{Joint, Mechanism, Reaction, Relative, Socket};
use nalgebra::{ComplexField, Vector3};
use serde::{Deserialize, Serialize};
use softdock_control::range::{SettingsError, in_range};

/// A sphere about J and a cone that opens towards −x of P, in a flat flange. When the head sits in the cone, J and P
/// coincide.
///
/// ```text
///        | flange
///        |\      half angle α: the apex is at x = r/sin α
///  O-->  | >     r: radius of the head
///        |/
///        |
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ProbeCone {
    /// α, angle between axis and wall, rad.
    pub half_angle_rad: f64,
    /// Radius of the cone's mouth, m.
    pub mouth_radius_m: f64,
    /// r, radius of the head, m.
    pub head_radius_m: f64,
    /// Contact of the head with cone and flange.
    pub surface: Surface,
    /// Latches that catch the head; None for a mechanism without capture.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub socket: Option<Socket>,
    /// Deflection of the friction spring, m in P.
    #[serde(skip)]
    friction_m: Vector3<f64>,
}

impl ProbeCone {
    pub(crate) fn validate(&self) -> Result<(), SettingsError> {
        in_range("half_angle_rad", self.half_angle_rad, 0.05, 1.5)?;
        in_range("mouth_radius_m", self.mouth_radius_m, 1e-3, 10.0)?;
        in_range(
            "head_radius_m",
            self.head_radius_m,
            1e-4,
            self.mouth_radius_m,
        )?;
        self.surface.validate()?;
        self.socket.iter().try_for_each(Socket::validate)
    }

    /// Stiffness and damping along x of the head on one wall.
    pub(crate) fn first_contact(&self) -> Joint {
        let sin = ComplexField::sin(self.half_angle_rad);
        Joint {
            stiffness_n_per_m: self.surface.stiffness_n_per_m * sin * sin,
            damping_n_s_per_m: self.surface.damping_n_s_per_m * sin * sin,
        }
    }

    /// Touches of the head: on the side to which it is off the axis, and, if it is so deep that it fills the cone, on the
    /// opposite side too.
    fn touches(&self, at: &Relative) -> [Touch; 2] {
        let head = at.p_from_j.translation.vector;
        let off = Vector3::new(0.0, head.y, head.z);
        let radius = off.norm();
        let side = if radius > 0.0 {
            off / radius
        } else {
            Vector3::y()
        };
        [(side, radius), (-side, -radius)].map(|(side, radius)| {
            let (depth_m, [along, across]) = self.profile(head.x, radius);
            let normal = Vector3::x() * along + side * across;
            let point = head - normal * (self.head_radius_m - depth_m);
            Touch {
                point,
                normal,
                depth_m,
            }
        })
    }

    /// Depth of the head in the profile of cone and flange, for its centre at (x, radius), and the normal there: components
    /// along x and towards the side.
    fn profile(&self, x: f64, radius: f64) -> (f64, [f64; 2]) {
        let (sin, cos) = ComplexField::sin_cos(self.half_angle_rad);
        let apex_x = self.head_radius_m / sin;
        let length = self.mouth_radius_m / sin;
        // Position of the head's centre relative to the apex, against x and in radius.
        let (back, inwards) = (apex_x - x, radius);
        let along_wall = back * cos + inwards * sin;
        if along_wall <= length {
            let from_wall = back * sin - inwards * cos;
            return (self.head_radius_m - from_wall, [-sin, -cos]);
        }
        // Beyond the mouth the rim is the nearest part, and outside of the rim the flange.
        let rim_x = apex_x - length * cos;
        let (before, outside) = (rim_x - x, radius - self.mouth_radius_m);
        if outside >= 0.0 {
            return (self.head_radius_m - before, [-1.0, 0.0]);
        }
        let distance = ComplexField::hypot(before, outside).max(f64::MIN_POSITIVE);
        let normal = [-before / distance, outside / distance];
        (self.head_radius_m - distance, normal)
    }
}

impl Mechanism for ProbeCone {
    fn reaction(&self, at: &Relative) -> Reaction {
        let frictions = [self.friction_m, Vector3::zeros()];
        let mut sum = match &self.socket {
            Some(socket) => socket.reaction(at),
            None => Reaction::none(),
        };
        for (touch, friction) in self.touches(at).iter().zip(frictions) {
            let push = self
                .surface
                .push(touch, &at.velocity_at(&touch.point), &friction);
            sum = sum
                + Reaction {
                    wrench: at.push(&touch.point, &push.force),
                    stored_j: push.stored_j,
                    loss_w: push.loss_w,
                };
        }
        sum
    }

    fn advance(&mut self, at: &Relative, step_s: f64) -> f64 {
        let [touch, _] = self.touches(at);
        let velocity = at.velocity_at(&touch.point);
        let slid = self
            .surface
            .slide(&touch, &velocity, &self.friction_m, step_s);
        self.friction_m = slid.0;
        let socket = self
            .socket
            .as_mut()
            .map_or(0.0, |socket| socket.advance(at, step_s));
        slid.1 + socket
    }

    fn captured(&self) -> bool {
        self.socket.is_some_and(|socket| socket.captured())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{Body, Pair, collide};
    use std::f64::consts::PI;

    fn cone(friction_coefficient: f64) -> ProbeCone {
        ProbeCone {
            half_angle_rad: 0.8,
            mouth_radius_m: 0.3,
            head_radius_m: 0.05,
            surface: Surface {
                stiffness_n_per_m: 2e5,
                damping_n_s_per_m: 0.0,
                friction_coefficient,
            },
            socket: None,
            friction_m: Vector3::zeros(),
        }
    }

    /// A probe whose head is 1 m ahead of its centre of mass, `offset_m` off the cone's axis and not yet in contact.
    fn pair(head_x_m: f64, offset_m: f64, speed_m_s: f64) -> Pair {
        Pair {
            k: Body::new(
                500.0,
                [180.0, 220.0, 210.0],
                [head_x_m - 1.0, offset_m, 0.02],
                speed_m_s,
            ),
            q: Body::new(2000.0, [900.0, 1100.0, 1000.0], [1.2, 0.0, 0.0], 0.0),
            k_from_j: [1.0, 0.0, 0.0].into(),
            q_from_p: [-1.2, 0.0, 0.0].into(),
        }
    }

    /// Without friction the bounce is that of one mass, 1/m = n·M⁻¹n, and lasts π √(m/k).
    #[test]
    fn a_smooth_bounce_is_that_of_the_effective_mass() {
        // Slow, so that neither body turns noticeably during the contact.
        let mut pair = pair(-0.0617, 0.06, 1e-4);
        let collision = collide(&mut pair, cone(0.0), 1e-5, 10_000_000).unwrap();
        let (point, normal) = (collision.point, collision.normal);
        let inverse = pair.k.inverse_effective_mass(&point, &normal)
            + pair.q.inverse_effective_mass(&point, &normal);
        let expected_s = PI / (2e5 * inverse).sqrt();
        assert!(
            (collision.duration_s / expected_s - 1.0).abs() < 1e-3,
            "{} {expected_s}",
            collision.duration_s
        );
        assert!(
            (collision.parting_m_s / collision.closing_m_s + 1.0).abs() < 1e-3,
            "{collision:?}"
        );
    }

    /// Contact forces on both bodies are opposite, also with friction, off centre and for long.
    #[test]
    fn momentum_is_kept_and_the_energy_is_booked() {
        for friction in [0.0, 0.15, 0.4] {
            let mut pair = pair(-0.09, 0.08, 0.05);
            let (before, energy) = (pair.momentum(), pair.kinetic_j());
            let collision = collide(&mut pair, cone(friction), 2e-5, 1_000_000).unwrap();
            let after = pair.momentum();
            let (linear, angular) = (after.0 - before.0, after.1 - before.1);
            assert!(
                linear.norm() < 1e-10 && angular.norm() < 1e-10,
                "{linear} {angular}"
            );
            let gone = energy - pair.kinetic_j();
            assert!(
                collision.balance.imbalance_j().abs() < 1e-3 * energy,
                "{friction}: {collision:?}"
            );
            let kept = collision.balance.stored_j + collision.balance.dissipated_j;
            assert!(
                (kept - gone).abs() < 2e-3 * energy,
                "{friction}: {collision:?} lost {gone} of {energy}"
            );
            assert!((friction > 0.0) == (collision.balance.dissipated_j > 1e-3 * energy));
        }
    }

    /// A head that is pushed along the axis slides down a wall only if cot α > μ.
    #[test]
    fn the_head_wedges_within_the_angle_of_friction() {
        let slides = |friction: f64| {
            let mut cone = cone(friction);
            let radius = 0.1;
            // Position of a touch without depth: back sin α − radius cos α = r.
            let (sin, cos) = cone.half_angle_rad.sin_cos();
            let x = 0.05 / sin - (0.05 + radius * cos) / sin;
            let at = |pushed: f64| Relative {
                p_from_j: softdock_control::frames::Pose::translation(x + pushed, radius, 0.0),
                twist: Relative::along_x(0.0, 1e-3).twist,
            };
            let mut lost_j = 0.0;
            for step in 0..1000 {
                lost_j += cone.advance(&at(1e-6 * f64::from(step)), 1e-3);
            }
            lost_j > 1e-9
        };
        let limit = 1.0 / 0.8_f64.tan();
        assert!(slides(0.97 * limit) && !slides(1.03 * limit));
    }

    /// Friction is opposite to the sliding, and μ times the normal force.
    #[test]
    fn friction_points_against_the_sliding() {
        let mut cone = cone(0.2);
        let mut at = Relative::along_x(0.0, 0.0);
        at.p_from_j.translation.vector = Vector3::new(-0.02, 0.06, 0.0);
        at.twist.linear = Vector3::new(0.0, 0.0, 0.05);
        let frictionless = ProbeCone {
            surface: Surface {
                friction_coefficient: 0.0,
                ..cone.surface
            },
            ..cone
        };
        for _ in 0..1000 {
            cone.advance(&at, 1e-3);
        }
        let normal = frictionless.reaction(&at).wrench.force;
        let dry = cone.reaction(&at).wrench.force - normal;
        assert!(normal.norm() > 1.0 && (dry.norm() / normal.norm() - 0.2).abs() < 1e-9);
        assert!((dry.normalize() + Vector3::z()).norm() < 1e-9, "{dry}");
    }

    /// The head does not fall through flange and rim, and the force has no jumps there.
    #[test]
    fn the_surface_is_closed_around_the_mouth() {
        let cone = cone(0.0);
        let mut last: Option<Vector3<f64>> = None;
        for step in 0..4000 {
            let mut at = Relative::along_x(0.0, 0.0);
            // 1 mm inside the surface, from beside the mouth to the axis.
            let radius = 0.4 - 1e-4 * f64::from(step);
            let (mut low, mut high) = (-1.0, 0.1);
            for _ in 0..50 {
                let middle = 0.5 * (low + high);
                if cone.profile(middle, radius).0 < 1e-3 {
                    low = middle
                } else {
                    high = middle
                }
            }
            at.p_from_j.translation.vector = Vector3::new(low, radius, 0.0);
            let [touch, _] = cone.touches(&at);
            let force = cone
                .surface
                .push(&touch, &Vector3::zeros(), &Vector3::zeros())
                .force;
            assert!((force.norm() - 200.0).abs() < 1e-3, "{radius}: {force}");
            if let Some(last) = last {
                assert!(
                    (force - last).norm() < 1.0,
                    "{radius}: {force} after {last}"
                );
            }
            last = Some(force);
        }
    }
}
