//! The rig and its clock, shared by the robot's thread and the sensor's.

use super::tally::Tally;
use super::telegrams::Telegrams;
use super::{Peer, STOP_PERIOD};
use crate::rig::settings::MechanismSettings;
use crate::rig::{Rig, RigSettings, SensorSampleSim};
use anyhow::{Context, Result};
use std::f64::consts::{PI, TAU};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// How far into a cycle a patient rig goes on without its answer, µs: a reading that is asked for later is of this
/// instant.
const UNANSWERED_US: u64 = 1000;
/// How long a patient rig waits for the board to ask for a reading, if it asked for one in the cycle before.
const READING: Duration = Duration::from_millis(50);
/// How fast the robot's own program turns each of A, B, C, rad/s.
const TURN_RAD_S: f64 = 0.8;

/// The rig with its clock and its telegrams.
pub(super) struct Plant {
    state: Mutex<State>,
    /// An answer has come, or a reading was taken.
    answered: Condvar,
}

struct State {
    settings: RigSettings,
    start_pose: [f64; 6],
    seed: u64,
    patience: Duration,
    cycle: Duration,
    rig: Rig,
    /// The instant of the rig's time 0, and the number of its next telegram.
    zero: Instant,
    number: u32,
    telegrams: Telegrams,
    sent: Instant,
    answered: bool,
    /// A reading was taken in this cycle, and in the one before.
    sensed: (bool, bool),
    touches: bool,
    /// Orientation to which the robot's own program goes, rad.
    goal: Option<[f64; 3]>,
    tally: Tally,
}

/// What the robot does next.
pub(super) enum Next {
    /// It sends this; whether the spacecraft touch.
    Telegram(Vec<u8>, bool),
    /// It has stopped, for this reason.
    Stopped(String),
}

impl Plant {
    pub(super) fn new(peer: &Peer) -> Result<Self> {
        let rig = Rig::new(&peer.rig, peer.start_pose, peer.seed).context("[rig]")?;
        let tags = peer.board.rsi.tags().context("[board.rsi]")?;
        let now = Instant::now();
        Ok(Self {
            state: Mutex::new(State {
                settings: peer.rig.clone(),
                start_pose: peer.start_pose,
                seed: peer.seed,
                patience: peer.patience,
                cycle: Duration::from_micros(peer.rig.cycle_us.into()),
                rig,
                zero: now,
                number: 0,
                telegrams: Telegrams::new(tags, peer.rig.cycle_us.into()),
                sent: now,
                answered: false,
                sensed: (false, false),
                touches: false,
                goal: None,
                tally: Tally::default(),
            }),
            answered: Condvar::new(),
        })
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(super) fn tally(&self) -> Tally {
        self.lock().tally.clone()
    }

    /// Reading at the present instant.
    pub(super) fn sense(&self) -> SensorSampleSim {
        let mut state = self.lock();
        let now_us = state.now_us();
        state.rig.advance_to(now_us);
        state.tally.readings += 1;
        state.sensed.0 = true;
        self.answered.notify_all();
        state.rig.gauges()
    }

    /// Begins RSI: returns its first telegram, which is repeated until it is answered.
    pub(super) fn begin_run(&self) -> Result<Vec<u8>> {
        let mut state = self.lock();
        let rig = Rig::new(&state.settings, state.start_pose, state.seed)?;
        (state.rig, state.zero, state.number) = (rig, Instant::now(), 0);
        state.telegrams.begin_run();
        state.begin_cycle()
    }

    /// Waits for the answer to the first telegram; its instant becomes that of the first cycle. False if none came.
    pub(super) fn first_answer(&self, patience: Duration) -> bool {
        let state = self.lock();
        let waited = self
            .answered
            .wait_timeout_while(state, patience, |state| !state.answered);
        let (mut state, _) = waited.unwrap_or_else(PoisonError::into_inner);
        if state.answered {
            state.zero = Instant::now();
            state.number = 1;
            state.tally.runs += 1;
            state.tally.cycles += 1;
        }
        state.answered
    }

    /// When the next telegram leaves.
    pub(super) fn deadline(&self) -> Instant {
        self.lock().deadline()
    }

    /// Waits, if the rig is patient, for a late answer and for the reading that the board requests in each cycle; meanwhile the
    /// rig's clock stands still. An error if the patience is exhausted.
    pub(super) fn wait_for_answer(&self, over: &AtomicBool) -> Result<(), String> {
        let mut state = self.lock();
        if state.patience.is_zero() {
            return Ok(());
        }
        let deadline = state.deadline();
        while state.waits(deadline.elapsed()) {
            if over.load(Ordering::Relaxed) {
                return Ok(());
            }
            let waited = self.answered.wait_timeout(state, STOP_PERIOD);
            (state, _) = waited.unwrap_or_else(PoisonError::into_inner);
        }
        if !state.answered {
            state.tally.unanswered += 1;
            return Err(format!("no answer for {} s", state.patience.as_secs_f64()));
        }
        state.zero += deadline.elapsed();
        Ok(())
    }

    /// The telegram of the next cycle. From now on the robot goes to `goal`, if there is one.
    pub(super) fn next(&self, goal: Option<[f64; 3]>) -> Result<Next> {
        let mut state = self.lock();
        let behind = state.deadline().elapsed();
        if behind >= state.cycle {
            state.tally.stalls += 1;
            state.zero += behind;
        }
        if !state.answered {
            state.tally.unanswered += 1;
        }
        if goal.is_some() {
            state.goal = goal;
            // The robot's program takes the spacecraft away from the mechanism before it turns.
            state.settings.mechanism = MechanismSettings::default();
        }
        state.turn()?;
        state.telegrams.advance();
        state.number += 1;
        match state.begin_cycle() {
            Ok(telegram) => {
                state.tally.cycles += 1;
                state.look_for_contact();
                Ok(Next::Telegram(telegram, state.touches))
            }
            Err(reason) => {
                let reason = reason.to_string();
                state.tally.robot_stopped = Some(reason.clone());
                Ok(Next::Stopped(reason))
            }
        }
    }

    /// Takes a datagram of the board.
    pub(super) fn take(&self, datagram: &[u8]) {
        let mut state = self.lock();
        let current = state.telegrams.ipoc();
        match state.telegrams.read(datagram) {
            Ok(answer) if answer.ipoc == current && !state.answered => {
                let after = state.sent.elapsed();
                let waited = !state.patience.is_zero() && state.number > 0 && after >= state.cycle;
                state.tally.answered(after.as_secs_f64(), waited);
                state.answered = true;
                state.rig.answer(answer.correction, answer.stop);
                self.answered.notify_all();
            }
            // A repeated answer, or one of a run that is over.
            Ok(answer) if answer.ipoc >= current => {}
            Ok(_) => state.tally.late += 1,
            Err(_) => state.tally.malformed += 1,
        }
    }
}

impl State {
    /// When the next telegram leaves.
    fn deadline(&self) -> Instant {
        self.zero + self.cycle * self.number
    }

    /// Whether a patient rig that is late by so much waits on.
    fn waits(&self, late: Duration) -> bool {
        let reading_is_due = self.sensed == (false, true) && late < READING;
        (!self.answered && late < self.patience) || reading_is_due
    }

    /// The rig's time.
    fn now_us(&self) -> u64 {
        let micros = |duration: Duration| u64::try_from(duration.as_micros()).unwrap_or(u64::MAX);
        let elapsed_us = micros(self.zero.elapsed());
        if self.patience.is_zero() || self.answered {
            return elapsed_us;
        }
        let began_us = micros(self.cycle * self.number.saturating_sub(1));
        elapsed_us.min(began_us + UNANSWERED_US)
    }

    /// The telegram of the cycle that begins now; the robot may have stopped.
    fn begin_cycle(&mut self) -> Result<Vec<u8>> {
        let report = self.rig.begin_cycle();
        let Some(report) = report else {
            let why = self.rig.stopped();
            anyhow::bail!(why.map_or_else(|| "unknown".to_owned(), |why| why.to_string()));
        };
        (self.answered, self.sent) = (false, Instant::now());
        self.sensed = (false, self.sensed.0);
        Ok(self.telegrams.write(&report)?)
    }

    /// A step of the robot's own program towards its goal; RSI goes on.
    fn turn(&mut self) -> Result<()> {
        let Some(goal) = self.goal else {
            return Ok(());
        };
        let most = TURN_RAD_S * self.cycle.as_secs_f64();
        let mut arrived = true;
        for (angle, goal) in self.start_pose[3..].iter_mut().zip(goal) {
            let left = (goal - *angle + PI).rem_euclid(TAU) - PI;
            *angle += left.clamp(-most, most);
            arrived &= left.abs() <= most;
        }
        if arrived {
            self.goal = None;
        }
        // With the same noise different poses would look alike.
        self.seed = self.seed.wrapping_add(1);
        self.rig = Rig::new(&self.settings, self.start_pose, self.seed)?;
        self.zero += self.cycle * self.number;
        self.number = 0;
        Ok(())
    }

    fn look_for_contact(&mut self) {
        let truth = self.rig.truth();
        let force_n = truth.contact.force.norm();
        let touches = force_n > 0.0 || truth.penetration_m.iter().any(|depth| *depth > 0.0);
        self.tally.contacts += u64::from(touches && !self.touches);
        self.touches = touches;
        self.tally.captured_s = self.rig.captured_s();
        self.tally.asks_to_stop = self.rig.asks_to_stop();
        self.tally.greatest_force_n = self.tally.greatest_force_n.max(force_n);
    }
}
