//! The settings of the predictor, and the table of all its fixed numbers.
//!
//! Each entry gives the unit (none: a ratio), the reason for the value, and the effect of a larger (↑) or a smaller (↓) one.
//! Numbers without a measurement beside them are engineering choices, checked by the tests `delay_predictor`. Two numbers that
//! are equal by chance are two entries, as their reasons differ.

crate::described! {
/// Settings that the predictor cannot identify, or should not.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields, default))]
pub struct PredictorSettings: "delay.predictor" {
    /// Stiffness that is expected of the contact, N/m; it need not be better than a factor of
    /// three. 0: derived from the masses and the robot's delay, as the stiffness at which the
    /// contact lasts five delays.
    pub contact_stiffness_n_per_m: f64 = 0.0 => 0.0..=1e8,
    /// Noise of a force, standard deviation, N: the least that is assumed. The approach to the first
    /// contact shows whether it is more.
    pub force_noise_n: f64 = 0.002 => 1e-4..=100.0,
    /// The rebound is held to the identified contact, or to a passive one, where it departs from
    /// it; each such action is reported.
    pub guard: bool = true,
    /// A robot that does not move as `delay.actuator` says latches a fault before the first contact.
    pub interlock: bool = true,
}
}

// Sizes.

/// Prediction horizon, cycles: a dead time of 8 and the longer part of a contact of 37 (scenario S). ↑ costs
/// time in proportion; ↓ 40 saves a sixth and costs accuracy in damped contacts.
pub(super) const PREDICTION_HORIZON: usize = 48;
/// Control horizon: free moves of the dynamic matrix control. ↑ brings nothing; ↓ tracks less closely.
pub(super) const CONTROL_HORIZON: usize = 12;
/// Number of latencies of the reported pose that are distinguished, 0 to 4 cycles. ↑ costs one identification each per cycle.
pub(super) const LATENCIES: usize = 5;
/// Commands that are kept, cycles: longest dead time of the settings (50 cycles of 4 ms), the range in which
/// it is tracked (10), the latency of the settings (8), the eight of [`LONGEST_DEAD_TIME`].
pub(super) const COMMAND_HISTORY: usize = 76;
/// Longest dead time that can be followed, cycles: the models of all latencies must find their commands.
pub(super) const LONGEST_DEAD_TIME: usize = COMMAND_HISTORY - 8;
/// Contacts that are remembered: the two ends of a run between two stops.
pub(super) const REMEMBERED_CONTACTS: usize = 2;

// Robot axes and robot model.

/// Metres per radian: the lever of a docking mechanism, so that errors of all six axes have similar size. ↑ weighs rotations more
/// against translations.
pub(super) const ANGLE_LEVER_M: f64 = 0.3;
/// Terms of the matrix exponential's series: with a norm of at most ½ the next one is below 1e-17.
pub(super) const EXPONENTIAL_TERMS: u32 = 13;
/// Below this a velocity counts as zero, m/s: rounding must not look like a reversal, which costs a pause. ↑ hides a real
/// reversal of a slow axis.
pub(super) const ZERO_VELOCITY: f64 = 1e-9;
/// Times closer than this are equal, cycles: rounding.
pub(super) const SAME_INSTANT: f64 = 1e-9;

// Observer.

/// Gain of the position observer per cycle, without noise. ↑ follows the measurement, ↓ the model.
pub(super) const OBSERVER_GAIN: f64 = 0.3;
/// How noise lowers it: gain / (1 + this · σ / (v τ)), which compares noise with the displacement in a delay. ↑ trusts the model
/// more. Found with 5 and 20 µm of noise.
pub(super) const OBSERVER_NOISE_WEIGHT: f64 = 112.0;
/// A measured position within so many standard deviations of the robot model counts as that of the model. Beyond, the contact
/// estimator gets the measured position, shrunk by its noise. ↑ a pause of another length looks like a damping; ↓ noise does.
pub(super) const INNOVATION_SIGNIFICANCE: f64 = 4.0;
/// A load this many standard deviations from zero is significant. ↑ a contact is noticed later; ↓ noise opens
/// contacts.
pub(super) const LOAD_SIGNIFICANCE: f64 = 4.5;
/// Samples before the measured noise of the load counts: its variance is then known to 35 %.
pub(super) const NOISE_SAMPLES: f64 = 16.0;

// Identification of the approach.

/// Window, cycles: start ramp, dead time and a straight part. ↑ needs a longer approach; ↓ knows the delay
/// less well.
pub(super) const APPROACH_WINDOW: usize = 88;
/// First fit and cycles between fits, the last at the end of the window: six. ↑ saves time; ↓ corrects the
/// delay sooner.
pub(super) const APPROACH_FIRST_FIT: usize = 48;
pub(super) const APPROACH_FIT_PERIOD: usize = 8;
/// Range in which the delay is followed around the configured one, cycles: 8 to 72 ms around 32. ↑ explains
/// other structures by a delay.
pub(super) const DELAY_RANGE: [f64; 2] = [-6.0, 10.0];
/// Least change of the delay, cycles. Standard deviations within which a delay is shrunk to that of the settings, as after a
/// contact. Largest standard deviation that is taken for an error of structure, cycles. ↑ leaves a known error; ↓ moves the model
/// by noise.
pub(super) const APPROACH_DELAY_STEP: f64 = 0.002;
pub(super) const APPROACH_SIGNIFICANCE: f64 = 2.0;
pub(super) const APPROACH_DEVIATION_LIMIT: f64 = 0.3;
/// Slowest approach that tells anything, m/s: 0.04 µm in a cycle.
pub(super) const SLOWEST_APPROACH: f64 = 1e-5;
/// Interlock: largest misfit beyond noise, relative to the displacement in a delay. A right structure leaves 0.0000, a wrong one
/// 0.0046 (a servo of 10 Hz for a dead time) to 0.26. ↑ lets wrong models into contacts; ↓ refuses right ones.
pub(super) const INTERLOCK_MISFIT: f64 = 0.0035;
/// Start-up: time after which robot and model move with the same velocity, in mean delays, plus cycles. ↓ begins to track before
/// the robot has its speed.
pub(super) const START_UP_DELAYS: f64 = 3.0;
pub(super) const START_UP_CYCLES: f64 = 8.0;

// Tracking of the delay after the approach.

/// Forgetting factor of an axis's offset x₀, per cycle: 64 cycles. ↑ a displacement that was lost counts
/// longer.
pub(super) const OFFSET_FORGETTING: f64 = 1.0 - 1.0 / 64.0;
/// Forgetting factor of the products, per contact. ↑ less noise; ↓ a change is found in fewer contacts.
pub(super) const CONTACT_FORGETTING: f64 = 0.6;
/// Forgetting factor of an axis's peak velocity, per cycle: 50 cycles.
pub(super) const PEAK_FORGETTING: f64 = 0.98;
/// Below this part of its peak velocity an axis is near a reversal, where the robot may stand while the model
/// does not. ↑ leaves out too much of the braking, which is the information; ↓ takes a pause for a delay.
pub(super) const REVERSAL_BAND: f64 = 0.4;
/// Smallest and largest change after a contact, cycles. A larger largest one follows an outlier.
pub(super) const TRACKED_DELAY_STEP: f64 = 0.05;
pub(super) const TRACKED_DELAY_LIMIT: f64 = 2.0;
/// Cycles, in addition to a mean delay, after a contact until the motion is straight.
pub(super) const TRACKING_SETTLES: f64 = 12.0;
/// A change within so many standard deviations of zero is shrunk to zero. ↑ slower under noise.
pub(super) const TRACKED_DELAY_SIGNIFICANCE: f64 = 2.0;

// Contact estimator.

/// Expected ω τ where no stiffness is set: the geometric mean of the range that can be compensated, 0.2 to 1.8.
pub(super) const PRIOR_PHASE: f64 = 0.6;
/// Prior standard deviation of the stiffness relative to the expected one, along the force: so wide that a factor of three does
/// not matter. Across it: ↑ the direction wanders (restitution off by up to 1.8); ↓ a direction that friction turns away from the
/// force is not found.
pub(super) const PRIOR_SPREAD_ALONG: f64 = 2.0;
pub(super) const PRIOR_SPREAD_ACROSS: f64 = 0.1;
/// Prior standard deviation of the damping ratio: any.
pub(super) const PRIOR_DAMPING_RATIO: f64 = 1.0;
/// Least force part of a load's direction: a load that is a torque alone has a direction as well.
pub(super) const LEAST_FORCE_PART: f64 = 0.1;
/// Fraction of the bounded stiffness that κ must have along the force for the gradient to be taken from it: loads that do not
/// grow into the contact say nothing about its direction.
pub(super) const GRADIENT_TRUST: f64 = 0.5;
/// Information on the offset without an onset, in units of a load's: it only keeps the equations regular.
pub(super) const OFFSET_REGULARISATION: f64 = 1e-9;
/// Bounds of the stiffness by the expected one.
pub(super) const STIFFNESS_RANGE: [f64; 2] = [0.02, 50.0];
/// Largest damping by √(k m): beyond 2 nothing bounces.
pub(super) const DAMPING_LIMIT: f64 = 1.9;
/// Damping within so many standard deviations of zero is shrunk to zero: it cannot be distinguished from an error of the onset. ↑
/// hides real damping; ↓ at ω τ above 1.1 an error of the onset passes for damping.
pub(super) const DAMPING_SIGNIFICANCE: f64 = 1.5;
/// Forgetting factor of what is remembered of a contact, per contact. ↑ slower on a contact that changes.
pub(super) const MEMORY_FORGETTING: f64 = 0.5;
/// Forgetting factor of the load's direction, per cycle: ten cycles. ↑ smoother; ↓ follows friction that
/// turns.
pub(super) const DIRECTION_FORGETTING: f64 = 0.9;
/// Error of a load besides its noise, relative to the expected peak: no contact is exactly a spring. ↓ the fit believes that the
/// first loads are exact.
pub(super) const MODEL_ERROR: f64 = 0.003;
/// Divisor of the displacement in a cycle for the standard deviation of the depth at an onset anywhere within the cycle: √12.
pub(super) const ONSET_SPREAD: f64 = 3.5;
/// Earliest onset before the first significant load, cycles. ↓ misses what a threshold far above noise hides.
pub(super) const EARLIEST_ONSET: f64 = 8.0;

// Stiffening.

/// Loads before a parabola counts: a dead time of 8. ↓ it is extrapolated far beyond the depths at which it was measured.
pub(super) const STIFFENING_LOADS: f64 = 8.0;
/// Least rms residual of the spring, relative to the expected error of a load, and largest fraction of its squared residuals that
/// a parabola may leave. ↑, ↓ a wrong delay or friction passes for stiffening.
pub(super) const STIFFENING_SEEN: f64 = 3.0;
pub(super) const STIFFENING_LEAVES: f64 = 0.25;
/// Misfit of the spring above which the contact is too far from one to be described by a parabola.
pub(super) const STIFFENING_MISFIT: f64 = 0.1;

// Multiple-model latency estimator.

/// Loads before it may decide. ↓ decides by noise.
pub(super) const LATENCY_LOADS: u32 = 3;
/// A rival must be better by this factor of the squared error. ↑ decides later; ↓ changes to and fro.
pub(super) const LATENCY_EVIDENCE: f64 = 2.0;
/// A hypothesis that is better than all others by this factor is settled for this contact. ↓ settles on chance.
pub(super) const LATENCY_SETTLED: f64 = 100.0;
/// Error of a load that decides nothing, relative to its noise, and to the expected peak. ↑ decides later.
pub(super) const LATENCY_FLOOR_NOISE: f64 = 1.5;
pub(super) const LATENCY_FLOOR_PEAK: f64 = 0.0002;

// Course of a contact and contact memory.

/// Cycles without a significant load after which a contact may be over, and after which, beyond the execution
/// delay, it is over wherever the reference is. ↓ a pause of the load ends the contact.
pub(super) const QUIET_CYCLES: u32 = 4;
pub(super) const QUIET_CYCLES_LATE: f64 = 6.0;
/// Longest contact: in durations of the identified one, plus the execution delay, plus this time, s.
pub(super) const DURATION_LIMIT: f64 = 2.2;
pub(super) const DURATION_MARGIN_S: f64 = 0.05;
/// Cosine between loads above which they come from the same contact: 18°.
pub(super) const SAME_CONTACT: f64 = 0.95;
/// Cycles beyond its position after which a remembered contact that is not felt is forgotten.
pub(super) const MISSED_CONTACT: f64 = 6.0;
/// Closing velocity over the velocity below which a remembered contact is not on the path.
pub(super) const LEAST_CLOSING: f64 = 1e-3;

// Reference.

/// Largest damping ratio: a critically damped contact does not end.
pub(super) const DAMPING_RATIO_LIMIT: f64 = 0.95;

// Dynamic matrix control.

/// Move suppression ρ, cycles²: what a command costs against an error of position. 1 is near deadbeat for a
/// pure dead time; ↑ slower, ↓ amplifies noise and jitter. 3 is best with jitter.
pub(super) const MOVE_SUPPRESSION: f64 = 3.0;
/// Additional move suppression in a damped contact, where velocity is force: factor of (c/k Ts)². ↑ too slow at ζ = 0.5; ↓ spikes
/// of force from ζ = 0.3 on.
pub(super) const DAMPED_MOVE_SUPPRESSION: f64 = 0.3;
/// Fastest command, in closing velocities, and the least velocity that this counts from, m/s: 0.2 mm/s.
/// Needed at ω τ > 1 or ζ > 0.4 only. ↓ cannot retreat in time.
pub(super) const SPEED_LIMIT: f64 = 4.0;
pub(super) const SPEED_LIMIT_BASE: f64 = 2e-4;

// Impulse matching.

/// Ratio of successive moves of a preload: 1, ½, ¼. ↑ 0.7: contact time 0.60 to 0.67 % off instead of 0.53 to 0.60 %; ↓ one
/// single move: the same as ½.
pub(super) const PRELOAD_DECAY: f64 = 0.5;
/// Cycles after the end of the contact until which a preload is taken back. ↑ 8: contact time 0.3 % off instead of
/// 0.2 %; ↓ 0: 0.02 %, and the rebound of damped contacts and of a robot with jitter a quarter worse.
pub(super) const TAKEN_BACK_LATER: f64 = 5.0;
/// Cycles of a preload that are remembered: the longest mean delay of a robot that answers at once (servo of 5 Hz).
pub(super) const PRELOAD_HISTORY: usize = 24;
/// Least displacement of a one-cycle command of 1 within the rest of the contact, cycles: below it there is
/// no authority left.
pub(super) const LEAST_AUTHORITY: f64 = 1.0;
/// Evaluations of the predicted impulse per cycle, and how many of them are reserved for the root search. ↑ costs time, brings
/// nothing.
pub(super) const EVALUATIONS: usize = 9;
pub(super) const ROOT_EVALUATIONS: usize = 4;
/// First step relative to the excess, largest growth of a step while the sign change is sought, and the margin of a step beyond a
/// linear extrapolation.
pub(super) const FIRST_STEP: f64 = 0.5;
pub(super) const STEP_GROWTH: f64 = 2.5;
pub(super) const STEP_MARGIN: f64 = 1.05;
/// A velocity error that counts as zero, relative to the velocities before and after. ↓ costs time.
pub(super) const MATCHED: f64 = 1e-7;
/// Cost of a preload relative to that of a velocity error of its size: of two equally good ones the smaller is taken.
pub(super) const PRELOAD_COST: f64 = 0.002;

// One reversal per axis and contact.

/// Slowest command on either side of the reversal: relative to the velocity of the axis, and in m/s, which is the last digit of a
/// correction in 4 ms. A command that is rounded away reverses the robot a cycle later than its model. ↑ moves the robot; ↓
/// pauses under noise.
pub(super) const REVERSAL_SPEED: f64 = 0.005;
pub(super) const REVERSAL_SPEED_M_S: f64 = 2.5e-5;
/// A clear retreat, relative to the velocity of the axis; cycles after the onset, and fraction of the contact, before it is
/// believed. ↓ reverses by the first estimate of a contact.
pub(super) const RETREAT_SPEED: f64 = 0.15;
pub(super) const RETREAT_CYCLES: f64 = 2.0;
pub(super) const RETREAT_PART: f64 = 0.25;
/// Latencies beyond the believed one for which a reversal waits as long as they are not refuted, cycles. ↑ serves poses four
/// cycles late, and stiff contacts reverse too late where the belief was right.
pub(super) const DOUBTED_LATENCY_CYCLES: usize = 2;
/// Fraction of the rebound that a contact may have given back while the robot waits: the other half is left to steer with. ↑
/// waits in stiff contacts as well.
pub(super) const LARGEST_REBOUND_WHILE_WAITING: f64 = 0.5;
/// Damping ratio from which on a contact needs an early retreat, and axes may turn freely. ↑ a damped rebound
/// is too fast; ↓ estimates that waver cost a pause.
pub(super) const FREE_REVERSAL_DAMPING: f64 = 0.25;
/// An axis that keeps more than this fraction of its velocity in a damped contact does not reverse in it.
pub(super) const ONWARD_PART: f64 = 0.1;
/// An axis with less than this part of the motion has no direction of its own.
pub(super) const AXIS_SHARE: f64 = 0.02;

// Restitution: what noise hides, and the guard.

/// Prior odds of no damping against one of the size that is found. ↑ hides small damping; ↓ noise passes for it.
pub(super) const UNDAMPED_ODDS: f64 = 1000.0;
/// Standard deviations at which a damping is as likely as none: √(2 ln odds).
pub(super) const DAMPING_SEEN: f64 = 3.717;
/// Degrees of freedom that a fit takes from the residuals.
pub(super) const FITTED_UNKNOWNS: f64 = 3.0;
/// Standard deviations of a sum of squares that still count as noise.
pub(super) const RESIDUAL_SIGNIFICANCE: f64 = 3.0;
/// Largest departure of the rebound that noise explains, standard deviations.
pub(super) const NOISE_EXPLAINS: f64 = 4.0;
/// Misfit of a contact up to which its identification is believed, and multiple of the misfit of noise that is added. ↑ believes
/// contacts that are no spring; ↓ drops to the fallback law for nothing.
pub(super) const GUARD_MISFIT: f64 = 0.06;
pub(super) const GUARD_MISFIT_NOISE: f64 = 1.5;
/// Rms of a contact's load relative to its peak: the noise over it is the misfit that noise makes.
pub(super) const MEAN_LOAD: f64 = 0.7;
/// Gain of speed that the guard leaves alone: no contact gives any.
pub(super) const GUARD_GAIN: f64 = 0.008;
/// Departure of the restitution that the guard leaves alone: with an exact fit, per misfit, and at most. ↑ leaves errors; ↓ acts
/// where nothing is wrong.
pub(super) const GUARD_TOLERANCE: f64 = 0.01;
pub(super) const GUARD_TOLERANCE_OF_MISFIT: f64 = 2.0;
pub(super) const GUARD_TOLERANCE_LIMIT: f64 = 0.03;
/// Standard deviations of noise that both leave alone.
pub(super) const GUARD_SIGNIFICANCE: f64 = 3.0;

// Fallback.

/// Cycles over which the command changes to the fallback and back. ↓ a jump of the command.
pub(super) const BLEND_CYCLES: f64 = 10.0;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn settings_beyond_their_range_are_refused() {
        let settings = |contact_stiffness_n_per_m, force_noise_n| PredictorSettings {
            contact_stiffness_n_per_m,
            force_noise_n,
            ..PredictorSettings::default()
        };
        assert!(PredictorSettings::default().check_ranges().is_ok());
        for (settings, field) in [
            (settings(-1.0, 0.1), "contact_stiffness_n_per_m"),
            (settings(2e8, 0.1), "contact_stiffness_n_per_m"),
            (settings(0.0, 0.0), "force_noise_n"),
            (settings(0.0, 101.0), "force_noise_n"),
        ] {
            let error = settings.check_ranges().unwrap_err();
            assert_eq!(error.field, format!("delay.predictor.{field}"));
        }
    }
}
