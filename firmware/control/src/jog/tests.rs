use super::*;
use crate::settings::Settings;

const CYCLE_S: f64 = 0.004;

const PAIRS: [(Jog, Jog); 6] = [
    (Jog::X, Jog::MinusX),
    (Jog::Y, Jog::MinusY),
    (Jog::Z, Jog::MinusZ),
    (Jog::A, Jog::MinusA),
    (Jog::B, Jog::MinusB),
    (Jog::C, Jog::MinusC),
];

#[test]
fn each_axis_has_a_jog_in_both_directions() {
    for (forward, back) in PAIRS {
        let (axis, sign) = forward.component();
        assert_eq!((sign, back.component()), (1.0, (axis, -1.0)));
    }
    let axes = PAIRS.map(|(jog, _)| jog.component().0);
    assert_eq!(axes, [0, 1, 2, 5, 4, 3], "A, B and C turn about z, y and x");
}

/// Whether the default jog is accepted with these limits.
fn passes(change: impl FnOnce(&mut LimitSettings)) -> bool {
    let mut limits = LimitSettings::default();
    change(&mut limits);
    JogSettings::default().validate(&limits, CYCLE_S).is_ok()
}

/// Each limit at the value that the jog needs is enough, and slightly less is not.
#[test]
fn a_jog_that_the_limits_would_cut_is_refused() {
    let jog = JogSettings::default();
    assert!(passes(|_| {}));
    for (share, is_enough) in [(1.001, true), (0.999, false)] {
        let (speed, turn) = (jog.speed_m_s * share, jog.speed_rad_s * share);
        let (jump, jerk) = (LARGEST_JUMP * speed, LARGEST_JUMP * turn);
        let outcomes = [
            passes(|l| l.speed_m_s = FASTEST * speed),
            passes(|l| l.step_m = FASTEST * speed * CYCLE_S),
            passes(|l| l.acceleration_m_s2 = jump / CYCLE_S),
            passes(|l| l.box_m[1] = jog.reach_m * share),
            passes(|l| l.speed_rad_s = FASTEST * turn),
            passes(|l| l.step_rad = FASTEST * turn * CYCLE_S),
            passes(|l| l.acceleration_rad_s2 = jerk / CYCLE_S),
            passes(|l| l.box_rad = jog.reach_rad * share),
        ];
        assert_eq!(outcomes, [is_enough; 8], "{share} of what it takes");
    }
}

/// A box in which the shortest useful jog just fits.
#[test]
fn a_slow_jog_fits_into_a_small_box() {
    let shortest = Excitation::reach(0.02, FORWARD[0], CYCLE_S);
    for (share, fits) in [(1.001, true), (0.999, false)] {
        let reach_m = shortest * share;
        let jog = JogSettings {
            reach_m,
            ..JogSettings::default()
        };
        let limits = LimitSettings {
            box_m: [reach_m; 3],
            ..LimitSettings::default()
        };
        assert_eq!(jog.validate(&limits, CYCLE_S).is_ok(), fits, "{share}");
    }
}

/// Whether there is room for a jog from a place relative to the centre of the box: X, Y, Z in m, then an angle about z in rad.
fn has_room_at(jog: Jog, from_center: [f64; 4]) -> bool {
    let center = Pose::from_parts(
        frames::vector::<f64>(&[1.0, -2.0, 0.5]).into(),
        frames::orientation_from_abc(&[0.3, 0.0, 0.0]),
    );
    let [x, y, z, a] = from_center;
    let pose = Pose::from_parts(
        (center.translation.vector + frames::vector(&[x, y, z])).into(),
        center.rotation * frames::orientation_from_abc(&[a, 0.0, 0.0]),
    );
    has_room(
        (&JogSettings::default(), &LimitSettings::default()),
        None,
        jog,
        &pose,
        &center,
    )
}

#[test]
fn a_jog_along_an_axis_keeps_within_the_box() {
    let settings = Settings::default();
    let room = settings.limits.box_m[0] - settings.jog.reach_m;
    for (axis, (forward, back)) in PAIRS[..3].iter().enumerate() {
        let at = |away: f64| {
            let mut place = [0.0; 4];
            place[axis] = away;
            place
        };
        assert!(has_room_at(*forward, at(room - 1e-6)));
        assert!(!has_room_at(*forward, at(room + 1e-6)));
        assert!(has_room_at(*back, at(room + 1e-6)), "it leads back");
        assert!(has_room_at(*back, at(1e-6 - room)));
        assert!(!has_room_at(*back, at(-room - 1e-6)));
        let outside = settings.limits.box_m[0] + 1e-6;
        assert!(!has_room_at(*back, at(outside)));
    }
}

#[test]
fn a_jog_about_an_axis_keeps_within_the_largest_turn() {
    let settings = Settings::default();
    let room = settings.limits.box_rad - settings.jog.reach_rad;
    for turned in [room, -room] {
        assert!(has_room_at(Jog::A, [0.0, 0.0, 0.0, turned * 0.999]));
        assert!(!has_room_at(Jog::A, [0.0, 0.0, 0.0, turned * 1.001]));
    }
}
