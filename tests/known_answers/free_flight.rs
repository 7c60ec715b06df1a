//! Free flight of an asymmetric body for an hour: Euler's equations conserve the kinetic energy
//! and the angular momentum in the inertial frame, exactly.

use nalgebra::Vector3;
use softdock_control::dynamics::{Body, BodyState};
use softdock_control::frames::{Wrench, components};
use softdock_control::scalar::Scalar;
use softdock_control::settings::BodySettings;
use softdock_tests::in_three_scalars;

const CYCLE_S: f64 = 0.004;
/// An hour of 4 ms cycles.
const CYCLES: u32 = 900_000;

/// Principal inertias near 80, 150 and 210 kg·m², with products. The rotation is about the
/// intermediate axis, which is unstable: the body tumbles again and again.
fn tumbling() -> BodySettings {
    BodySettings {
        inertia_kg_m2: [[80.0, 6.0, -4.0], [6.0, 150.0, 9.0], [-4.0, 9.0, 210.0]],
        velocity_m_s: [0.01, -0.02, 0.005],
        angular_velocity_rad_s: [0.02, 0.3, -0.01],
        ..BodySettings::default()
    }
}

struct Invariants {
    energy_j: f64,
    spin: Vector3<f64>,
}

fn invariants<S: Scalar>(body: &Body<S>, state: &BodyState<S>) -> Invariants {
    // Without the orbital part: the body flies away from the origin of C.
    let centred = BodyState {
        c_from_body: nalgebra::Isometry3::from_parts(
            Vector3::zeros().into(),
            state.c_from_body.rotation,
        ),
        ..*state
    };
    Invariants {
        energy_j: body.kinetic_energy(state).get(),
        spin: components(&body.momentum(&centred).1).into(),
    }
}

/// Tolerances: relative energy, and relative change of the momentum vector.
fn conserves<S: Scalar>((energy, momentum): (f64, f64)) {
    let settings = tumbling();
    let body = Body::<S>::new(&settings);
    let mut state = BodyState::initial(&settings);
    let before = invariants(&body, &state);
    let mut swing = (f64::MAX, f64::MIN);
    for _ in 0..CYCLES {
        state = body.step(&state, &Wrench::zero(), S::of(CYCLE_S));
        let about_intermediate = state.velocity.angular.y.get();
        swing = (
            swing.0.min(about_intermediate),
            swing.1.max(about_intermediate),
        );
    }
    let after = invariants(&body, &state);
    let energy_change = (after.energy_j - before.energy_j).abs() / before.energy_j;
    let momentum_change = (after.spin - before.spin).norm() / before.spin.norm();
    assert!(energy_change < energy, "energy {energy_change:e}");
    assert!(momentum_change < momentum, "momentum {momentum_change:e}");
    assert!(swing.0 < -0.25 && swing.1 > 0.25, "no tumbling: {swing:?}");
}

in_three_scalars! {
    /// f64: ω is a fourth-order Runge-Kutta step, so its energy is left at the rounding; the
    /// attitude turns by the mean of two ω and errs by (ω Ts)³/12 per cycle, back and forth.
    /// f32: 6e-8 per operation, 9e5 cycles as a random walk. Fixed: truncates to 2.3e-10 rad/s
    /// always downwards, which is 1e-4 rad/s, of 0.3, in 9e5 cycles.
    an_hour_of_tumbling: conserves => f64 (1e-12, 1e-7), f32 (1e-4, 2e-3), fixed (1e-3, 1e-3)
}
