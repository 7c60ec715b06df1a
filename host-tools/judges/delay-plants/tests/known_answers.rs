//! Plants against known answers, and the two formulations against each other.

use softdock_delay_plants::{
    Actuator, Contact, Dynamics, ForceLaw, Formulation, Measurement, Plant, PlantSettings, Wall,
};

const CYCLE_S: f64 = 0.004;

fn plant(actuator: Actuator) -> PlantSettings {
    PlantSettings {
        actuator,
        ..PlantSettings::default()
    }
}

fn along_x(v: f64) -> [f64; 6] {
    [v, 0.0, 0.0, 0.0, 0.0, 0.0]
}

/// Executed position and velocity of X at the end of each cycle.
fn executed(settings: &PlantSettings, commands: &[f64]) -> Vec<(f64, f64)> {
    let mut plant = Plant::new(settings);
    for v in commands {
        plant.step(along_x(*v));
    }
    let moments = &plant.log().moments;
    moments
        .iter()
        .map(|m| (m.position[0], m.velocity[0]))
        .collect()
}

fn pure(delay_s: f64, pause_s: f64) -> Actuator {
    Actuator {
        delay_s,
        pause_s,
        ..Actuator::ideal()
    }
}

#[test]
fn constant_command_is_late_by_the_delay() {
    for delay_s in [0.0, 0.004, 0.0315, 0.0417] {
        let motion = executed(&plant(pure(delay_s, 0.0)), &[0.01; 30]);
        let (x, v) = motion[29];
        assert!((x - 0.01 * (30.0 * CYCLE_S - delay_s)).abs() < 1e-15);
        assert_eq!(v, 0.01);
    }
}

#[test]
fn step_through_a_lag() {
    let actuator = Actuator {
        dynamics: Dynamics::Lag {
            time_constant_s: 0.016,
        },
        ..pure(0.016, 0.0)
    };
    for (n, (x, v)) in executed(&plant(actuator), &[0.01; 40]).iter().enumerate() {
        let t = ((n + 1) as f64 * CYCLE_S - 0.016).max(0.0);
        let gone = 1.0 - (-t / 0.016).exp();
        assert!((v - 0.01 * gone).abs() < 1e-14, "{n}");
        assert!((x - 0.01 * (t - 0.016 * gone)).abs() < 1e-14, "{n}");
    }
}

/// A pause loses its duration times the command, for any phase within a cycle.
#[test]
fn pause_loses_the_right_distance() {
    let mut commands = vec![0.01; 20];
    commands.extend([-0.01; 30]);
    for (delay_s, pause_s) in [(0.032, 0.016), (0.0333, 0.0071), (0.0, 0.004)] {
        let motion = executed(&plant(pure(delay_s, pause_s)), &commands);
        let lost = 0.01 * pause_s;
        let known = 0.01 * 80e-3 - 0.01 * (120e-3 - delay_s) + lost;
        assert!((motion[49].0 - known).abs() < 1e-15, "{}", motion[49].0);
    }
}

/// After a lag the axis crosses zero later than the command: the pause begins T ln 2 after the reversal arrives, and loses
/// what the lag would have moved meanwhile.
#[test]
fn pause_behind_a_lag() {
    let (lag, pause_s, delay_s) = (0.016, 0.012, 0.018);
    let actuator = Actuator {
        dynamics: Dynamics::Lag {
            time_constant_s: lag,
        },
        ..pure(delay_s, pause_s)
    };
    let mut commands = vec![0.01; 60];
    commands.extend([-0.01; 40]);
    let with = executed(&plant(actuator), &commands)[99].0;
    let pauseless = Actuator {
        pause_s: 0.0,
        ..actuator
    };
    let without = executed(&plant(pauseless), &commands)[99].0;
    // After the zero crossing y = -v (1 - e^(-t/T)).
    let lost = 0.01 * (pause_s - lag * (1.0 - (-pause_s / lag).exp()));
    assert!((with - without - lost).abs() < 1e-11, "{}", with - without);
}

/// A command beyond the limits is executed as far as they allow.
#[test]
fn limits_of_velocity_and_acceleration() {
    let actuator = Actuator {
        max_velocity: 0.02,
        max_acceleration: 1.0,
        ..pure(0.0, 0.0)
    };
    let motion = executed(&plant(actuator), &[0.1; 10]);
    for (n, (_, v)) in motion.iter().enumerate() {
        let known = (0.004 * (n + 1) as f64).min(0.02);
        assert!((v - known).abs() < 1e-15, "{n}: {v}, known {known}");
    }
}

/// Commands with frequent reversals, some of them within pauses.
fn rough() -> Vec<f64> {
    (0..400)
        .map(|n| {
            let t = f64::from(n);
            0.01 * (0.11 * t).sin() + 0.004 * (0.53 * t).cos() * f64::from(n % 3 - 1)
        })
        .collect()
}

/// The largest difference of the two formulations is small.
#[test]
fn two_formulations_agree() {
    let lag = Dynamics::Lag {
        time_constant_s: 0.032,
    };
    let servo = |hz| Dynamics::Servo { hz, damping: 0.7 };
    for (dynamics, delay_s, pause_s) in [
        // A pause that ends just as a command arrives differs between the formulations; 15 ms avoid that.
        (Dynamics::None, 0.032, 0.015),
        (lag, 0.016, 0.016),
        (servo(10.0), 0.016, 0.016),
        (servo(5.0), 0.0, 0.032),
    ] {
        let exact = plant(Actuator {
            dynamics,
            ..pure(delay_s, pause_s)
        });
        let stepped = PlantSettings {
            formulation: Formulation::FixedSteps,
            ..exact.clone()
        };
        let (a, b) = (executed(&exact, &rough()), executed(&stepped, &rough()));
        let apart = a.iter().zip(&b).map(|(a, b)| (a.0 - b.0).abs());
        let largest = apart.fold(0.0, f64::max);
        // A tolerance of 0.02 ms at 0.01 m/s for each of about thirty reversals.
        assert!(largest < 3e-6, "{dynamics:?}: {largest}");
    }
}

/// Contact time, peak and impulse of a prescribed motion onto an elastic wall.
#[test]
fn log_of_a_prescribed_contact() {
    let wall = Wall::elastic([0.001, 0.0, 0.0], [-1.0, 0.0, 0.0], 1e5);
    for formulation in [Formulation::Exact, Formulation::FixedSteps] {
        let mut plant = Plant::new(&PlantSettings {
            contact: Contact {
                probes: vec![[0.0; 3]],
                surfaces: vec![wall.into()],
            },
            formulation,
            ..plant(pure(0.0, 0.0))
        });
        for n in 0..120 {
            plant.step(along_x(if n < 60 { 0.01 } else { -0.01 }));
        }
        let contact = plant.log().contacts[0];
        assert_eq!(plant.log().contacts.len(), 1);
        assert!((contact.touch_s - 0.1).abs() < 1e-9, "{}", contact.touch_s);
        assert!((contact.duration_s().unwrap() - 0.28).abs() < 1e-9);
        assert!((contact.peak_force_n - 140.0).abs() < 1e-6);
        assert!((contact.impulse_n_s.x + 19.6).abs() < 1e-3);
    }
}

/// A rotated flange reports the same force in its own axes, and the torque of its lever.
#[test]
fn wrench_is_that_of_the_flange() {
    let quarter = std::f64::consts::FRAC_PI_2;
    let wall = Wall {
        point: [0.0; 3],
        normal: [-1.0, 0.0, 0.0],
        law: ForceLaw::linear(1000.0, 0.0),
    };
    let mut plant = Plant::new(&PlantSettings {
        start: [0.0, 0.0, 0.0, quarter, 0.0, 0.0],
        contact: Contact {
            probes: vec![[0.3, -0.01, 0.0]],
            surfaces: vec![wall.into()],
        },
        ..PlantSettings::default()
    });
    // Turned by 90° about z the probe stands at x = 0.01, y = 0.3 in the laboratory.
    let wrench = plant.first_sample().wrench;
    let known = [0.0, 10.0, 0.0, 0.0, 0.0, 3.0];
    for i in 0..6 {
        assert!((wrench[i] - known[i]).abs() < 1e-9, "{wrench:?}");
    }
}

#[test]
fn feedback_is_late_and_noisy_as_told() {
    let mut late = Plant::new(&PlantSettings {
        measurement: Measurement {
            pose_latency_cycles: 3,
            ..Measurement::default()
        },
        ..PlantSettings::default()
    });
    late.first_sample();
    let seen: Vec<f64> = (0..10)
        .map(|_| late.step(along_x(0.01)).position[0])
        .collect();
    assert_eq!(seen[1], 0.0);
    assert!((seen[9] - 0.01 * 7.0 * CYCLE_S).abs() < 1e-15);

    let mut noisy = Plant::new(&PlantSettings {
        measurement: Measurement {
            position_noise_m: 5e-6,
            force_noise_n: 0.5,
            ..Measurement::default()
        },
        ..PlantSettings::default()
    });
    let samples: Vec<_> = (0..4000).map(|_| noisy.step([0.0; 6])).collect();
    let rms =
        |values: Vec<f64>| (values.iter().map(|v| v * v).sum::<f64>() / values.len() as f64).sqrt();
    assert!((rms(samples.iter().map(|s| s.position[1]).collect()) / 5e-6 - 1.0).abs() < 0.05);
    assert!((rms(samples.iter().map(|s| s.wrench[2]).collect()) / 0.5 - 1.0).abs() < 0.05);
    assert_eq!(samples[7].position[4], 0.0);
}

/// Jitter moves the arrival by a cycle either way, in half of the cycles.
#[test]
fn jitter_is_one_cycle_either_way() {
    let settings = plant(Actuator {
        jitter: true,
        ..pure(0.032, 0.0)
    });
    let commands: Vec<f64> = (0..2000).map(|n| f64::from(n) * 1e-6).collect();
    let mut counts = [0; 3];
    for (n, (_, v)) in executed(&settings, &commands).iter().enumerate().skip(10) {
        let cycle = (v / 1e-6).round() as i64;
        let off = cycle - (n as i64 - 8);
        counts[usize::try_from(off + 1).expect("at most one cycle early")] += 1;
    }
    assert!(counts.iter().all(|c| *c > 300), "{counts:?}");
    assert!(counts[1] > 900, "{counts:?}");
}
