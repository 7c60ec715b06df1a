//! Settings of the two simulated spacecraft.

crate::described! {
/// One simulated spacecraft: mass properties, space-manipulator terms and initial conditions.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields, default))]
pub struct BodySettings {
    /// Does not move, whatever acts on it (a spacecraft of unlimited mass).
    pub fixed: bool = false,
    /// Mass, kg.
    pub mass_kg: f64 = 500.0,
    /// Inertia tensor about the centre of mass, body axes, kg·m².
    pub inertia_kg_m2: [[f64; 3]; 3] = [[100.0, 0.0, 0.0], [0.0, 100.0, 0.0], [0.0, 0.0, 100.0]],
    /// a_ARM: acceleration by the space manipulator, m/s² in C. It stands for −F_arm/m and is
    /// entered once, here (A12).
    pub arm_acceleration_m_s2: [f64; 3] = [0.0; 3],
    /// α_ARM: angular acceleration by the space manipulator, rad/s² in body axes.
    pub arm_angular_acceleration_rad_s2: [f64; 3] = [0.0; 3],
    /// Stiffness of the space manipulator, N/m: it pulls the spacecraft back to its initial position.
    pub arm_stiffness_n_per_m: f64 = 0.0,
    /// Damping of the space manipulator, N·s/m: it brakes the spacecraft.
    pub arm_damping_n_s_per_m: f64 = 0.0,
    /// Initial position of the centre of mass in C, m.
    pub position_m: [f64; 3] = [0.0; 3],
    /// Initial orientation in C, quaternion w x y z.
    pub orientation_wxyz: [f64; 4] = [1.0, 0.0, 0.0, 0.0],
    /// Initial velocity in C, m/s.
    pub velocity_m_s: [f64; 3] = [0.0; 3],
    /// Initial angular velocity in body axes, rad/s.
    pub angular_velocity_rad_s: [f64; 3] = [0.0; 3],
}
}

impl BodySettings {
    /// Stiffness (1/s²) and damping (1/s) of the space manipulator, over the mass of the spacecraft.
    pub fn arm_resistance_per_kg(&self) -> (f64, f64) {
        (
            self.arm_stiffness_n_per_m / self.mass_kg,
            self.arm_damping_n_s_per_m / self.mass_kg,
        )
    }
}

crate::described! {
/// Observation frames: docking surfaces on the two spacecraft.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields, default))]
pub struct FrameSettings {
    /// Origin of J (= N) in K, m.
    pub j_position_m: [f64; 3] = [0.0; 3],
    /// Orientation of J in K, quaternion w x y z.
    pub j_orientation_wxyz: [f64; 4] = [1.0, 0.0, 0.0, 0.0],
    /// Origin of P in Q, m.
    pub p_position_m: [f64; 3] = [0.0; 3],
    /// Orientation of P in Q, quaternion w x y z.
    pub p_orientation_wxyz: [f64; 4] = [1.0, 0.0, 0.0, 0.0],
}
}
