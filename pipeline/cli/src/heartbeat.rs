//! Progress where no terminal shows bars: a line a minute.

use crate::clock::{iso, spoken};
use std::sync::{Arc, Condvar, Mutex, MutexGuard};
use std::thread::JoinHandle;
use std::time::{Duration, Instant, SystemTime};

/// From one line to the next.
const EVERY: Duration = Duration::from_secs(60);

/// A stage under way.
#[derive(Clone, Debug)]
struct Stage {
    name: String,
    total: u64,
    done: u64,
    begun: Instant,
}

#[derive(Default)]
struct Shared {
    stage: Mutex<(Option<Stage>, bool)>,
    over: Condvar,
}

impl Shared {
    /// No thread panics while it holds the lock.
    fn stage(&self) -> MutexGuard<'_, (Option<Stage>, bool)> {
        self.stage
            .lock()
            .unwrap_or_else(|poison| poison.into_inner())
    }
}

/// Prints a line a minute until it is dropped.
pub struct Heartbeat {
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
}

impl Heartbeat {
    /// From now on; `deadline` is when the whole work has to end.
    pub fn new(deadline: Option<Instant>) -> Heartbeat {
        let shared = Arc::new(Shared::default());
        let seen = Arc::clone(&shared);
        let thread = std::thread::Builder::new().spawn(move || beat(&seen, deadline));
        Heartbeat {
            shared,
            // without a thread nothing is said
            thread: thread.ok(),
        }
    }

    /// A stage begins.
    pub fn begin(&self, name: String, total: u64) {
        self.shared.stage().0 = Some(Stage {
            name,
            total,
            done: 0,
            begun: Instant::now(),
        });
    }

    /// More of it is done.
    pub fn advance(&self, steps: u64) {
        if let Some(stage) = &mut self.shared.stage().0 {
            stage.done += steps;
        }
    }

    /// It is over.
    pub fn end(&self) {
        self.shared.stage().0 = None;
    }
}

impl Drop for Heartbeat {
    fn drop(&mut self) {
        self.shared.stage().1 = true;
        self.shared.over.notify_all();
        if let Some(thread) = self.thread.take() {
            // it prints and ends
            let _ = thread.join();
        }
    }
}

fn beat(shared: &Shared, deadline: Option<Instant>) {
    let mut next = Instant::now() + EVERY;
    let mut held = shared.stage();
    while !held.1 {
        let wait = next.saturating_duration_since(Instant::now());
        if wait.is_zero() {
            next += EVERY;
            if let Some(stage) = &held.0 {
                let left = deadline.map(|end| end.saturating_duration_since(Instant::now()));
                let line = line(stage, stage.begun.elapsed().as_secs_f64(), left);
                eprintln!("{} {line}", iso(SystemTime::now()));
            }
            continue;
        }
        held = match shared.over.wait_timeout(held, wait) {
            Ok((held, _)) => held,
            Err(poison) => poison.into_inner().0,
        };
    }
}

/// What a stage has come to after so many seconds.
fn line(stage: &Stage, seconds: f64, left: Option<Duration>) -> String {
    let share = stage.done as f64 / stage.total.max(1) as f64;
    let mut line = format!("{}: {:.0} %", stage.name, 100.0 * share);
    if share > 0.0 {
        let stage_left = spoken(seconds * (1.0 / share - 1.0));
        line += &format!(", about {stage_left} left in this stage");
    }
    if let Some(left) = left {
        let left = spoken(left.as_secs_f64());
        line += &format!(", {left} at the most for the whole bake");
    }
    line
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_says_what_is_left() {
        let mut stage = Stage {
            name: "train 3".into(),
            total: 200,
            done: 0,
            begun: Instant::now(),
        };
        assert_eq!(line(&stage, 30.0, None), "train 3: 0 %");
        stage.done = 50;
        let left = Some(Duration::from_secs(7200));
        assert_eq!(
            line(&stage, 60.0, left),
            "train 3: 25 %, about 3 min left in this stage, 2 h 0 min at the most for the whole bake"
        );
    }

    #[test]
    fn it_ends_at_once() {
        let start = Instant::now();
        let heart = Heartbeat::new(None);
        heart.begin("extract 0".into(), 10);
        heart.advance(3);
        heart.end();
        drop(heart);
        assert!(start.elapsed() < EVERY / 2);
    }
}
