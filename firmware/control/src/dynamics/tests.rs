use super::*;

const TS: f64 = 0.004;

fn moving(linear: [f64; 3], angular: [f64; 3]) -> BodyState<f64> {
    BodyState {
        c_from_body: Pose::identity(),
        velocity: Twist {
            linear: vector(&linear),
            angular: vector(&angular),
        },
    }
}

/// 10 kg at 3 m/s, and 1, 2 and 3 kg·m² at 1, 2 and −1 rad/s with products: ½ ωᵀ I ω.
#[test]
fn the_kinetic_energy_is_that_of_translation_and_rotation() {
    let body = Body::<f64>::new(&BodySettings {
        mass_kg: 10.0,
        inertia_kg_m2: [[1.0, 0.1, 0.0], [0.1, 2.0, -0.2], [0.0, -0.2, 3.0]],
        ..BodySettings::default()
    });
    let state = moving([1.0, 2.0, -2.0], [1.0, 2.0, -1.0]);
    // Rotation: ½ (1 + 8 + 3 + 2 · 0.1 · 2 + 2 · −0.2 · −2).
    let expected = 0.5 * 10.0 * 9.0 + 0.5 * 13.2;
    assert!((body.kinetic_energy(&state) - expected).abs() < 1e-12);
}

/// Change of velocity by the space manipulator in one cycle: acceleration, spring and damper, each alone and all together.
#[test]
fn the_space_manipulator_pulls_back_to_where_it_began_and_brakes() {
    let (mass, away, speed) = (8.0, 0.25, -0.5);
    for (stiffness, damping) in [(0.0, 0.0), (40.0, 0.0), (0.0, 24.0), (40.0, 24.0)] {
        let settings = BodySettings {
            mass_kg: mass,
            position_m: [1.0, 2.0, 3.0],
            arm_acceleration_m_s2: [0.125, 0.0, 0.0],
            arm_stiffness_n_per_m: stiffness,
            arm_damping_n_s_per_m: damping,
            ..BodySettings::default()
        };
        let body = Body::<f64>::new(&settings);
        let mut state = BodyState::initial(&settings);
        state.c_from_body.translation.vector.x += away;
        state.velocity.linear.x = speed;
        let change = body.step(&state, &Wrench::zero(), TS).velocity.linear - state.velocity.linear;
        let acceleration = 0.125 - (stiffness * away + damping * speed) / mass;
        let expected = Vector3::new(acceleration * TS, 0.0, 0.0);
        assert!((change - expected).norm() < 1e-15, "{change} {expected}");
    }
}

#[test]
fn the_space_manipulator_turns_as_it_is_told() {
    let arm_angular_acceleration_rad_s2 = [0.5, -0.25, 0.125];
    let settings = BodySettings {
        arm_angular_acceleration_rad_s2,
        ..BodySettings::default()
    };
    let body = Body::<f64>::new(&settings);
    let turned = body.step(&BodyState::initial(&settings), &Wrench::zero(), TS);
    let expected = Vector3::from(arm_angular_acceleration_rad_s2) * TS;
    assert_eq!(turned.velocity.angular, expected);
}

/// Both spacecraft far away side by side are within the ranges; each quantity at its limit is reported for either of them.
#[test]
fn a_model_at_the_edge_of_its_range_says_so() {
    let rest = moving([0.0; 3], [0.0; 3]);
    let at = |x: f64| BodyState {
        c_from_body: Pose::translation(0.0, 0.0, x),
        ..rest
    };
    let fast = |share: f64| moving([0.0, -FASTEST_M_S * share, 0.0], [0.0; 3]);
    let spinning = |share: f64| moving([0.0; 3], [0.0, 0.0, FASTEST_RAD_S * share]);
    let ends = |share: f64| {
        let (far, apart) = (at(FARTHEST_M * share), at(LONGEST_LEVER_M * share));
        let beside = at(FARTHEST_M * share - 1.0);
        [
            (fast(share), rest),
            (spinning(share), rest),
            (far, beside),
            (apart, rest),
        ]
    };
    let at_limits = |k, q| TwoBodyState { k, q }.at_its_limits();
    for (share, expected) in [(1.0, true), (0.99, false)] {
        for (n, (one, other)) in ends(share).into_iter().enumerate() {
            assert_eq!(at_limits(one, other), expected, "{n}");
            assert_eq!(at_limits(other, one), expected, "{n}");
        }
    }
}
