//! Progress where no terminal shows bars: a line a minute.

use crate::clock::{iso, spoken};
use crate::forecast::Forecast;
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

/// The bake and its stage, as a line tells them.
#[derive(Debug, Default)]
struct State {
    stage: Option<Stage>,
    /// Of the bake at work.
    forecast: Option<Forecast>,
    is_over: bool,
}

#[derive(Default)]
struct Shared {
    state: Mutex<State>,
    over: Condvar,
}

impl Shared {
    /// No thread panics while it holds the lock.
    fn state(&self) -> MutexGuard<'_, State> {
        self.state
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

    /// A bake begins that ends at a relative error of `target`.
    pub fn begin_bake(&self, target: f64) {
        self.shared.state().forecast = Some(Forecast::new(target));
    }

    /// A round of it has ended with a relative error.
    pub fn evaluated(&self, error: f64) {
        if let Some(forecast) = &mut self.shared.state().forecast {
            forecast.add(error);
        }
    }

    /// A stage begins.
    pub fn begin(&self, name: String, total: u64) {
        self.shared.state().stage = Some(Stage {
            name,
            total,
            done: 0,
            begun: Instant::now(),
        });
    }

    /// More of it is done.
    pub fn advance(&self, steps: u64) {
        if let Some(stage) = &mut self.shared.state().stage {
            stage.done += steps;
        }
    }

    /// It is over.
    pub fn end(&self) {
        self.shared.state().stage = None;
    }
}

impl Drop for Heartbeat {
    fn drop(&mut self) {
        self.shared.state().is_over = true;
        self.shared.over.notify_all();
        if let Some(thread) = self.thread.take() {
            // it prints and ends
            let _ = thread.join();
        }
    }
}

fn beat(shared: &Shared, deadline: Option<Instant>) {
    let mut next = Instant::now() + EVERY;
    let mut held = shared.state();
    while !held.is_over {
        let wait = next.saturating_duration_since(Instant::now());
        if wait.is_zero() {
            next += EVERY;
            if let Some(stage) = &held.stage {
                let left = deadline.map(|end| end.saturating_duration_since(Instant::now()));
                let whole = [held.forecast.as_ref().and_then(Forecast::left), left];
                let line = line(stage, stage.begun.elapsed().as_secs_f64(), whole);
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

/// The line of a stage after so many seconds: its share done, the time left for the whole bake as
/// forecast and as its limit allows.
fn line(stage: &Stage, seconds: f64, [forecast, limit]: [Option<Duration>; 2]) -> String {
    let share = stage.done as f64 / stage.total.max(1) as f64;
    let mut line = format!("{}: {:.0} %", stage.name, 100.0 * share);
    if share > 0.0 {
        let stage_left = spoken(seconds * (1.0 / share - 1.0));
        line += &format!(", about {stage_left} left in this stage");
    }
    let whole = match (forecast, limit) {
        (Some(forecast), limit) if limit.is_none_or(|limit| forecast < limit) => {
            ("about ", forecast)
        }
        (_, Some(limit)) => ("at most ", limit),
        _ => return line,
    };
    let (about, left) = (whole.0, spoken(whole.1.as_secs_f64()));
    line += &format!(", {about}{left} left for the whole bake");
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
        assert_eq!(line(&stage, 30.0, [None; 2]), "train 3: 0 %");
        stage.done = 50;
        let begins = "train 3: 25 %, about 3 min left in this stage";
        let [short, long] = [600, 7200].map(|seconds| Some(Duration::from_secs(seconds)));
        for (whole, told) in [
            ([None, long], ", at most 2 h 0 min left for the whole bake"),
            ([short, None], ", about 10 min left for the whole bake"),
            ([short, long], ", about 10 min left for the whole bake"),
            ([long, short], ", at most 10 min left for the whole bake"),
        ] {
            assert_eq!(line(&stage, 60.0, whole), format!("{begins}{told}"));
        }
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
