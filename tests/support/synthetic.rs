//! Synthetic diagnoses of a synthetic log, one for each verdict, as test cases for the report.

mod log;

use log::{CONTACT_S, FIRST_TOUCH_S, FORCE_SIGMA, PERIOD_S, VELOCITY_SIGMA, force, predict};
use softdock::pages::diagnosis::Identity;
use softdock_analysis::diagnose::{
    Diagnosis, Estimate, Experiment, NoiseFloor, Parameters, Ranked, Region, Remainder, RunnerUp,
    StrongestEvidence, Verdict,
};
use softdock_analysis::levels::{BeforeAfter, ChannelLevels, Step};
use softdock_physics::model::prediction::Prediction;
use softdock_physics::model::{Axis, Channel, Model};
use std::collections::BTreeMap;

/// The first of the named effects.
const DELAY: &str = "transport_delay";
/// The second of the named effects.
const PAUSE: &str = "reversal_pause";

/// A diagnosis with all data for its report.
#[derive(Clone, Debug)]
pub struct SyntheticDiagnosis {
    /// The diagnosis itself.
    pub diagnosis: Diagnosis,
    /// Prediction with the model as given.
    pub before: Prediction,
    /// Prediction with the named effects.
    pub after: Prediction,
    /// Model and data.
    pub identity: Identity,
}

fn levels(executed_velocity: f64, wrench: f64) -> ChannelLevels {
    ChannelLevels {
        executed_velocity,
        wrench,
        model_velocity: 0.0,
        pose: 1.003,
    }
}

fn noise_floors() -> Vec<NoiseFloor> {
    let floor = |channel, axis, measured, data_sheet| NoiseFloor {
        channel,
        axis,
        measured,
        data_sheet,
    };
    vec![
        floor(Channel::ExecutedVelocity, Axis::X, 5.03e-5, VELOCITY_SIGMA),
        floor(Channel::ExecutedVelocity, Axis::Y, 4.97e-5, VELOCITY_SIGMA),
        floor(Channel::Wrench, Axis::X, 0.151, FORCE_SIGMA),
        floor(Channel::Wrench, Axis::Ry, 0.0274, 0.1 * FORCE_SIGMA),
    ]
}

fn identity() -> Identity {
    Identity {
        model_path: "rig 2/model.toml".to_owned(),
        model_toml: Model::default_toml().to_owned(),
        train: "rig 2/train.mcap".to_owned(),
        test: Some("rig 2/test.mcap".to_owned()),
        firmware: "softdock 0.1.0 (4aa91bc) on nucleo-h743zi".to_owned(),
        settings_toml: "[control.robot]\ncycle_s = 0.004\n".to_owned(),
    }
}

/// A diagnosis with nothing but the verdict.
fn empty(verdict: Verdict, sentence: &str) -> Diagnosis {
    Diagnosis {
        sentence: sentence.to_owned(),
        verdict,
        effects: Vec::new(),
        probability: BTreeMap::new(),
        parameters: Parameters::new(),
        nominal: BTreeMap::new(),
        remainder: Remainder::default(),
        disagreeing: Vec::new(),
        equivalent: None,
        residual_rms_sigma: BeforeAfter::default(),
        steps: Vec::new(),
        runner_up: None,
        further_ties: Vec::new(),
        experiment: None,
        regions: Vec::new(),
        looks_like: Vec::new(),
        ranked: Vec::new(),
        strongest_evidence: StrongestEvidence::default(),
        noise: noise_floors(),
        notes: Vec::new(),
        of_all_logs: None,
        unseen: true,
        in_sample: false,
        seconds: 3.42,
    }
}

fn ranked(effects: &[&str], channel: Channel, gains: (f64, f64), parameters: usize) -> Ranked {
    Ranked {
        effects: effects.iter().map(ToString::to_string).collect(),
        beside: Vec::new(),
        channel,
        gain_train: gains.0,
        gain_test: gains.1,
        parameters,
        as_good_as: None,
        refused: None,
    }
}

fn refused(mut hypothesis: Ranked, reason: &str) -> Ranked {
    hypothesis.refused = Some(reason.to_owned());
    hypothesis
}

fn estimate(value: f64, unit: &str, low: f64, high: f64) -> Estimate {
    Estimate {
        value,
        unit: unit.to_owned(),
        low,
        high,
    }
}

/// A window of 90 ms at the turning point of each contact, and one of each whole contact.
fn regions(channel: Channel, axis: Axis, regime: &str, whole_contact: bool) -> Vec<Region> {
    let touches = (0..6).map(|n| FIRST_TOUCH_S + f64::from(n) * PERIOD_S);
    let window = |touch: f64| match whole_contact {
        true => (touch, touch + CONTACT_S),
        false => (touch + 0.19, touch + 0.28),
    };
    let region = |touch| Region {
        channel,
        axis,
        from_s: window(touch).0,
        to_s: window(touch).1,
        regime: regime.to_owned(),
    };
    touches.map(region).collect()
}

fn step(effect: &str, train_error: f64, test_error: f64) -> Step {
    Step {
        effect: effect.to_owned(),
        train_error,
        test_error: Some(test_error),
    }
}

/// Delay and pause are named, with everything that a diagnosis may contain.
pub fn named() -> SyntheticDiagnosis {
    let mut diagnosis = empty(
        Verdict::Named,
        "The robot is 32.1 ms late (95 %: 31.9 to 32.3 ms) instead of 20 ms, and rests for 11.2 ms where its velocity \
         changes sign; with both in the model the error of the executed velocity falls from 9.77 to 1.01 σ on data that \
         the fit has not seen.",
    );
    diagnosis.effects = vec![DELAY.to_owned(), PAUSE.to_owned()];
    diagnosis.parameters = parameters();
    diagnosis.residual_rms_sigma = BeforeAfter {
        before: levels(9.77, 1.304),
        after: levels(1.012, 1.304),
        ..BeforeAfter::default()
    };
    diagnosis.steps = vec![
        step("nominal", 9.91, 9.88),
        step(DELAY, 3.12, 3.21),
        step(PAUSE, 1.92, 1.93),
    ];
    diagnosis.ranked = hypotheses();
    diagnosis.runner_up = Some(RunnerUp {
        effect: "first_order_lag".to_owned(),
        of: DELAY.to_owned(),
        behind: 4123.0,
        told_apart: true,
        evidence: 4123.0,
        ties: Vec::new(),
    });
    diagnosis.experiment = Some(Experiment {
        sentence: "Repeat the test with 2 mm/s instead of 10 mm/s: a pause stays as long, a dead band grows longer."
            .to_owned(),
        separation_now: 61.0,
        separation_then: Some(734.0),
        command: "softdock run host-tools/scenarios/spring-rod.toml -o slow.mcap --speed-mm-s 2".to_owned(),
    });
    let executed = Channel::ExecutedVelocity;
    diagnosis.regions = regions(executed, Axis::X, "velocity changes sign", false);
    diagnosis.looks_like =
        vec!["The rest before the pause was added resembles a dead band of 0.3 mm/s.".to_owned()];
    diagnosis.notes = vec![
        "The first 12 cycles are not predicted: the velocities sent before are not in the recording.".to_owned(),
        "Noise of the torque about y is 1.8 times that of the data sheet.".to_owned(),
    ];
    SyntheticDiagnosis {
        diagnosis,
        before: predict(0.020, 0.0, |_| 0.0),
        after: predict(0.0321, 0.0112, |_| 0.0),
        identity: identity(),
    }
}

/// Parameters of delay and pause.
fn parameters() -> Parameters {
    let delay = [(
        "delay_s".to_owned(),
        estimate(0.032_11, "s", 0.0319, 0.0323),
    )];
    let pause = [
        ("pause_s".to_owned(), estimate(0.0112, "s", 0.0097, 0.0129)),
        (
            "velocity_below_m_s".to_owned(),
            estimate(2.1e-4, "m/s", 1.2e-4, 3.3e-4),
        ),
    ];
    [
        (DELAY.to_owned(), delay.into()),
        (PAUSE.to_owned(), pause.into()),
    ]
    .into()
}

/// Hypotheses that were tried before delay and pause were named.
fn hypotheses() -> Vec<Ranked> {
    let executed = Channel::ExecutedVelocity;
    vec![
        ranked(&[DELAY, PAUSE], executed, (95_120.0, 94_871.0), 3),
        refused(
            ranked(
                &["first_order_lag", PAUSE],
                executed,
                (90_997.0, 90_020.0),
                3,
            ),
            "the lag of the best fit is negative (-3.1 ms), which no robot has",
        ),
        ranked(&[DELAY], executed, (84_310.0, 83_870.0), 1),
        ranked(&["velocity_dead_band"], executed, (12_030.0, 11_640.0), 1),
        ranked(&["velocity_gain"], executed, (310.0, -45.0), 1),
        ranked(&["guide_friction"], Channel::Wrench, (4.1, -3.8), 2),
    ]
}

/// A model without missing effects, judged on the end of its only, foreign log.
pub fn nothing_missing() -> SyntheticDiagnosis {
    let mut diagnosis = empty(
        Verdict::NothingMissing,
        "Nothing is missing: every error is at the noise of the data sheet, the largest in wrench ry with 1.02 σ.",
    );
    diagnosis.unseen = false;
    diagnosis.residual_rms_sigma = BeforeAfter {
        before: levels(1.003, 1.01),
        after: levels(1.003, 1.01),
        ..BeforeAfter::default()
    };
    diagnosis.steps = vec![Step {
        effect: "nominal".to_owned(),
        train_error: 1.74,
        test_error: None,
    }];
    let right = predict(0.0321, 0.0112, |_| 0.0);
    SyntheticDiagnosis {
        diagnosis,
        before: right.clone(),
        after: right,
        identity: Identity {
            test: None,
            firmware: String::new(),
            settings_toml: String::new(),
            ..identity()
        },
    }
}

/// A torque that grows with the force and has hysteresis, which no effect of the catalogue has.
pub fn unexplained() -> SyntheticDiagnosis {
    let mut diagnosis = empty(
        Verdict::Unexplained,
        "Something is missing that has no name here: the torque about y is off by up to 0.22 N·m in each contact, \
         and returns along another path than it came.",
    );
    diagnosis.residual_rms_sigma = BeforeAfter {
        before: levels(1.004, 4.31),
        after: levels(1.004, 4.31),
        ..BeforeAfter::default()
    };
    diagnosis.regions = regions(Channel::Wrench, Axis::Ry, "contact", true);
    diagnosis.ranked = vec![
        refused(
            ranked(&["guide_friction"], Channel::Wrench, (2120.0, -310.0), 2),
            "it makes unseen data worse",
        ),
        refused(
            ranked(&["sensor_crosstalk"], Channel::Wrench, (9870.0, 9512.0), 6),
            "52 % of the error beyond the noise is left",
        ),
        ranked(&["wall_damping"], Channel::Wrench, (12.0, -3.0), 1),
    ];
    diagnosis.looks_like = vec![
        "48 % of it follows the force along x (0.0051 N·m per N), as a lever arm would.".to_owned(),
        "The rest depends on the direction of the motion, as friction or hysteresis would."
            .to_owned(),
    ];
    let hysteresis = |t: f64| 0.0045 * force(t) + 0.0025 * force(t - 0.06);
    SyntheticDiagnosis {
        diagnosis,
        before: predict(0.0321, 0.0112, hysteresis),
        after: predict(0.0321, 0.0112, hysteresis),
        identity: identity(),
    }
}
