//! A robot that runs in a thread while the test does other work.

use super::Robot;
use std::net::SocketAddr;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, JoinHandle};
use std::time::Duration;

/// Pause between two cycles.
const PAUSE: Duration = Duration::from_millis(2);

/// The robot's thread.
#[derive(Debug)]
pub struct RunningRobot {
    stop: Arc<AtomicBool>,
    thread: JoinHandle<i64>,
}

impl RunningRobot {
    /// Starts sending telegrams. Those that a board misses while it restarts are sent again.
    pub fn start(board: SocketAddr) -> Self {
        let stop = Arc::new(AtomicBool::new(false));
        let raised = stop.clone();
        let thread = thread::spawn(move || {
            let mut robot = Robot::new(board);
            let mut farthest = 0;
            while !raised.load(Ordering::Relaxed) {
                robot.cycle_through_flood();
                farthest = farthest.max(robot.pose[0]);
                thread::sleep(PAUSE);
            }
            farthest
        });
        Self { stop, thread }
    }

    /// Stops the robot; returns its displacement along x, in units of a correction.
    ///
    /// # Panics
    /// If a telegram was never answered.
    pub fn stop(self) -> i64 {
        self.stop.store(true, Ordering::Relaxed);
        self.thread.join().expect("a robot that was answered")
    }
}
