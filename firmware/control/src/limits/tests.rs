use super::*;
use crate::scalar::Fixed;
use proptest::prelude::*;

fn check<S: Scalar>(wanted: &[f64; 6], last: &[f64; 6], tolerance: f64) {
    let settings = LimitSettings::default();
    let limits = Limits::<S>::new(&settings, 0.004);
    let zero = Vector3::zeros();
    let last_sent = Limits::apply(
        &limits,
        &Twist::of(last),
        &Twist::zero(),
        &zero,
        &UnitQuaternion::identity(),
    )
    .0;
    let (sent, _) = limits.apply(
        &Twist::of(wanted),
        &last_sent,
        &zero,
        &UnitQuaternion::identity(),
    );
    let change = sent - last_sent;
    assert!(sent.linear.norm().get() <= 0.3 * (1.0 + tolerance) + 0.04);
    assert!(change.linear.norm().get() <= 10.0 * 0.004 * (1.0 + tolerance));
    assert!(change.angular.norm().get() <= 20.0 * 0.004 * (1.0 + tolerance));
}

proptest! {
    #[test]
    fn never_beyond_its_limits(
        wanted in prop::array::uniform6(-1e6..1e6f64),
        last in prop::array::uniform6(-1e6..1e6f64),
    ) {
        check::<f64>(&wanted, &last, 1e-12);
        check::<f32>(&wanted, &last, 1e-4);
        check::<Fixed>(&wanted, &last, 1e-5);
    }

    /// Too fast to brake before the edge: the edge takes precedence over the limit of the acceleration.
    #[test]
    fn the_edge_is_never_passed_at_any_speed(
        left in prop::array::uniform3(-1e-3..1e-3f64),
        v in prop::array::uniform3(-0.3..0.3f64),
        spin in -0.5..0.5f64,
    ) {
        let settings = LimitSettings::default();
        let limits = Limits::<f64>::new(&settings, 0.004);
        let at = Vector3::from_fn(|i, _| settings.box_m[i] - left[i]);
        let turn = UnitQuaternion::from_scaled_axis(Vector3::x() * (settings.box_rad - left[0]));
        let last = Twist::of(&[v[0], v[1], v[2], spin, 0.0, 0.0]);
        let (sent, flags) = limits.apply(&last, &last, &at, &turn);
        let next = at + sent.linear * 0.004;
        for i in 0..3 {
            prop_assert!(next[i] <= settings.box_m[i].max(at[i]) + 1e-12, "{i}: {next:?}");
        }
        let angle = turn.angle() + sent.angular.x * 0.004;
        prop_assert!(angle <= settings.box_rad.max(turn.angle()) + 1e-9, "{angle}");
        prop_assert!(sent == last || flags != LimitFlags::default());
    }

    /// Neither the box nor the acceleration is exceeded on the way to the edge.
    #[test]
    fn a_box_is_never_left_and_never_jerked_at(
        v in prop::array::uniform3(-1.0..1.0f64),
        w in prop::array::uniform3(-1.0..1.0f64),
    ) {
        let settings = LimitSettings::default();
        let limits = Limits::<f64>::new(&settings, 0.004);
        let (mut at, mut turn) = (Vector3::zeros(), UnitQuaternion::identity());
        let mut last = Twist::zero();
        for _ in 0..1000 {
            let wanted = Twist::of(&[v[0], v[1], v[2], w[0], w[1], w[2]]);
            let sent = limits.apply(&wanted, &last, &at, &turn).0;
            let change = sent - last;
            prop_assert!(change.linear.norm() <= settings.acceleration_m_s2 * 0.004 * 1.0001);
            prop_assert!(change.angular.norm() <= settings.acceleration_rad_s2 * 0.004 * 1.0001);
            last = sent;
            at += last.linear * 0.004;
            turn *= UnitQuaternion::from_scaled_axis(last.angular * 0.004);
            prop_assert!(at.amax() <= settings.box_m[0] + 1e-12);
            prop_assert!(turn.angle() <= settings.box_rad + 1e-9);
        }
    }
}

#[test]
fn every_setting_has_its_range() {
    type Spoil = fn(&mut LimitSettings, f64);
    let fields: [(&str, Spoil); 11] = [
        ("limits.step_m", |s, v| s.step_m = v),
        ("limits.step_rad", |s, v| s.step_rad = v),
        ("limits.speed_m_s", |s, v| s.speed_m_s = v),
        ("limits.speed_rad_s", |s, v| s.speed_rad_s = v),
        ("limits.acceleration_m_s2", |s, v| s.acceleration_m_s2 = v),
        ("limits.acceleration_rad_s2", |s, v| {
            s.acceleration_rad_s2 = v
        }),
        ("limits.box_m", |s, v| s.box_m[2] = v),
        ("limits.box_rad", |s, v| s.box_rad = v),
        ("limits.force_n", |s, v| s.force_n = v),
        ("limits.torque_n_m", |s, v| s.torque_n_m = v),
        ("limits.clamp_fault_cycles", |s, v| {
            s.clamp_fault_cycles = v as u32
        }),
    ];
    assert_eq!(LimitSettings::default().check_ranges(), Ok(()));
    for (name, spoil) in fields {
        let mut settings = LimitSettings::default();
        spoil(&mut settings, 0.0);
        let error = settings.check_ranges().unwrap_err();
        assert_eq!((error.field, error.received), (name, 0.0));
    }
}

/// Recordings contain these bits: each flag has its own bit, and can be set, found and removed.
#[test]
fn each_flag_is_a_bit_of_its_own() {
    let flags = [
        LimitFlags::SPEED,
        LimitFlags::ACCELERATION,
        LimitFlags::BOX,
        LimitFlags::ROBOT_CLAMP,
        LimitFlags::SENSOR_STALE,
        LimitFlags::MODEL,
        LimitFlags::MEASURED,
    ];
    let all = LimitFlags(0x7f);
    for (bit, flag) in flags.into_iter().enumerate() {
        assert_eq!(flag.0, 1 << bit);
        assert!(all.has(flag) && !all.without(flag).has(flag));
        assert_eq!(all.without(flag).0, 0x7f - flag.0);
        assert!(!LimitFlags::default().has(flag));
        let mut twice = flag;
        twice.set(flag);
        assert_eq!(twice, flag);
    }
}

/// An overload is beyond the limit, not at it; it is that of the length, not of a component; the torque is reported if the force
/// is not beyond.
#[test]
fn an_overload_is_told_with_its_numbers() {
    let load = |force: [f64; 3], torque: [f64; 3]| {
        let [x, y, z] = force;
        let [a, b, c] = torque;
        load_beyond(&Wrench::of(&[x, y, z, a, b, c]), 50.0, 5.0)
    };
    assert_eq!(load([0.0; 3], [0.0; 3]), None);
    assert_eq!(load([30.0, 0.0, -40.0], [0.0, -3.0, 4.0]), None);
    assert_eq!(load([60.0, 0.0, -80.0], [0.0; 3]), Some((50.0, 100.0)));
    assert_eq!(load([1.0, 0.0, 0.0], [0.0, -6.0, 8.0]), Some((5.0, 10.0)));
    assert_eq!(load([51.0, 0.0, 0.0], [9.0, 0.0, 0.0]), Some((50.0, 51.0)));
    let limits = Limits::<f64>::new(&LimitSettings::default(), 0.004);
    assert_eq!(
        limits.overload(&Wrench::of(&[3000.0, 0.0, 0.0, 500.0, 0.0, 0.0])),
        None
    );
    let heavy = Wrench::of(&[0.0, 3001.0, 0.0, 0.0, 0.0, 0.0]);
    assert_eq!(limits.overload(&heavy), Some((3000.0, 3001.0)));
}

/// With 10 m/s², a quarter of which brakes: √(2 · 2.5 · d), and half of the distance per cycle near the edge.
#[test]
fn the_speed_before_an_edge_is_the_one_that_can_be_braked() {
    let limits = Limits::<f64>::new(&LimitSettings::default(), 0.004);
    let speed = |distance| limits.stopping_speed(2.5, distance);
    assert_eq!(speed(0.2), 1.0);
    assert_eq!(speed(0.05), 0.5);
    // √(5 · 40e-6) is 14 mm/s, and 40 µm are left in two cycles at 5 mm/s.
    assert!((speed(40e-6) - 5e-3).abs() < 1e-15);
    assert_eq!((speed(0.0), speed(-0.1)), (0.0, 0.0));
}

/// One cycle from rest near an edge: the velocity that is sent, and whether the box is flagged.
fn near_the_edge(axis: usize, left_m: f64, velocity: f64) -> (f64, bool) {
    let settings = LimitSettings {
        acceleration_m_s2: 1000.0,
        ..LimitSettings::default()
    };
    let limits = Limits::<f64>::new(&settings, 0.004);
    let mut at = Vector3::zeros();
    at[axis] = (settings.box_m[axis] - left_m) * velocity.signum();
    let mut wanted = [0.0; 6];
    wanted[axis] = velocity;
    let turn = UnitQuaternion::identity();
    let (sent, flags) = limits.apply(&Twist::of(&wanted), &Twist::zero(), &at, &turn);
    (sent.linear[axis], flags.has(LimitFlags::BOX))
}

/// Both edges of each axis: far away nothing is limited, near the edge half of the distance is left per cycle, and at or beyond
/// it nothing is sent.
#[test]
fn a_box_brakes_towards_its_edges_only() {
    for axis in 0..3 {
        for sign in [1.0, -1.0] {
            assert_eq!(near_the_edge(axis, 0.1, sign * 0.1), (sign * 0.1, false));
            let (sent, told) = near_the_edge(axis, 80e-6, sign * 0.1);
            assert!((sent - sign * 0.01).abs() < 1e-12 && told, "{sent}");
            assert_eq!(near_the_edge(axis, 0.0, sign * 0.1), (0.0, true));
            assert_eq!(near_the_edge(axis, -1e-3, sign * 0.1), (0.0, true));
            // 80 µm from the other edge.
            let (back, told) = near_the_edge(axis, 0.5 - 80e-6, sign * 0.1);
            assert_eq!((back, told), (sign * 0.1, false));
        }
    }
}

/// One cycle of a rotation that continues from this angle: the velocity that is sent, and whether the box is flagged.
fn turning(from_rad: f64, velocity_rad_s: f64) -> (f64, bool) {
    let settings = LimitSettings {
        acceleration_rad_s2: 1000.0,
        ..LimitSettings::default()
    };
    let limits = Limits::<f64>::new(&settings, 0.004);
    let turn = UnitQuaternion::from_scaled_axis(Vector3::y() * from_rad);
    let wanted = Twist::of(&[0.0, 0.0, 0.0, 0.0, velocity_rad_s, 0.0]);
    let (sent, flags) = limits.apply(&wanted, &Twist::zero(), &Vector3::zeros(), &turn);
    (sent.angular.y, flags.has(LimitFlags::BOX))
}

/// The same for the angle, for either of its two quaternions; the way back is not limited.
#[test]
fn a_turn_is_braked_on_its_way_out_only() {
    for sign in [1.0, -1.0] {
        assert_eq!(turning(sign * 0.1, sign * 0.2), (sign * 0.2, false));
        let (sent, told) = turning(sign * 0.3496, sign * 0.2);
        assert!((sent - sign * 0.05).abs() < 1e-9 && told, "{sent}");
        assert_eq!(turning(sign * 0.36, sign * 0.2), (0.0, true));
        assert_eq!(turning(sign * 0.36, sign * -0.2), (sign * -0.2, false));
        assert_eq!(turning(sign * 0.3496, sign * -0.2), (sign * -0.2, false));
    }
}

/// At the edge at rest nothing is flagged; and a rotation about another axis is not outward.
#[test]
fn what_leads_nowhere_is_not_braked() {
    let settings = LimitSettings::default();
    let limits = Limits::<f64>::new(&settings, 0.004);
    let edge = vector(&settings.box_m);
    let rest = Twist::zero();
    let (sent, flags) = limits.apply(&rest, &rest, &edge, &UnitQuaternion::identity());
    assert_eq!((sent, flags), (rest, LimitFlags::default()));
    let turn = UnitQuaternion::from_scaled_axis(Vector3::y() * 0.3496);
    let across = Twist::of(&[0.0, 0.0, 0.0, 0.0, 0.0, 0.07]);
    let (sent, flags) = limits.apply(&across, &rest, &Vector3::zeros(), &turn);
    assert_eq!((sent, flags), (across, LimitFlags::default()));
}

/// The final limit alone, with a cycle of half a second and a box of a quarter metre: the velocity that is left, and whether it
/// is flagged.
fn kept(now: [f64; 2], velocity: [f64; 2]) -> ([f64; 2], bool) {
    let limits = Limits::<f64>::new(&LimitSettings::default(), 0.5);
    let mut flags = LimitFlags::default();
    let mut sent = Twist::of(&[0.0, velocity[0], 0.0, velocity[1], 0.0, 0.0]);
    let turn = UnitQuaternion::from_scaled_axis(Vector3::x() * now[1]);
    limits.keep_in_box(&mut sent, &(Vector3::y() * now[0]), &turn, &mut flags);
    ([sent.linear.y, sent.angular.x], flags.has(LimitFlags::BOX))
}

#[test]
fn the_last_resort_ends_at_the_edge() {
    for sign in [1.0, -1.0] {
        let moved = |now, velocity| kept([sign * now, 0.0], [sign * velocity, 0.0]);
        let left = |velocity: f64| [sign * velocity, 0.0];
        assert_eq!(moved(0.125, 0.125), (left(0.125), false));
        assert_eq!(moved(0.125, 0.25), (left(0.25), false), "to the edge");
        assert_eq!(moved(0.125, 1.0), (left(0.25), true), "to the edge");
        assert_eq!(moved(0.25, 1.0), (left(0.0), true));
        assert_eq!(moved(0.5, 1.0), (left(0.0), true), "from beyond");
        assert_eq!(moved(0.5, 0.0), (left(0.0), false));
        assert_eq!(moved(0.5, -0.25), (left(-0.25), false), "back");
    }
    let turned = |now, velocity| kept([0.0, now], [0.0, velocity]);
    assert_eq!(turned(0.34, 0.01), ([0.0, 0.01], false));
    assert_eq!(turned(0.34, 0.5), ([0.0, 0.0], true));
    assert_eq!(turned(0.36, 0.0), ([0.0, 0.0], false));
    assert_eq!(turned(0.36, -0.01), ([0.0, -0.01], false), "back");
}
