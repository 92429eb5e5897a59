//! Tasks side by side, as many as there are threads or as fit into memory.

use crate::error::BakeError;
use crate::task::Task;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

/// How many tasks may be in hand at once.
pub(crate) struct Crew {
    /// Tasks.
    pub size: usize,
    /// Bytes that each of them may need; none for no bound.
    pub share: Option<u64>,
}

/// The largest crew whose tasks fit into `memory` bytes together. A task that is larger than
/// all of it counts with the least that it can do with.
pub(crate) fn crew(todo: &[Task], memory: Option<u64>) -> Result<Crew, BakeError> {
    let threads = rayon::current_num_threads();
    let Some(memory) = memory else {
        return Ok(Crew {
            size: threads,
            share: None,
        });
    };
    let need = |task: &Task| match task.memory <= memory {
        true => task.memory,
        false => task.least_memory,
    };
    let largest = todo.iter().map(need).max().unwrap_or(0);
    match usize::try_from(memory / largest.max(1)) {
        Ok(0) => Err(BakeError::Memory {
            needed: largest,
            memory,
        }),
        fitting => {
            let size = fitting.unwrap_or(threads).min(threads);
            Ok(Crew {
                size,
                share: Some(memory / size.max(1) as u64),
            })
        }
    }
}

/// Does the tasks in their order, `crew` at a time; after an error no further one begins.
///
/// Plain threads, not rayon's: a worker that waits for a loop of its own task would there begin
/// another task meanwhile, and hold the memory of both.
pub(crate) fn work(
    crew: usize,
    todo: &[Task],
    perform: impl Fn(&Task) -> Result<(), BakeError> + Sync,
) -> Result<(), BakeError> {
    let next = AtomicUsize::new(0);
    let failed: Mutex<Option<BakeError>> = Mutex::new(None);
    let first_error = |error: Option<BakeError>| {
        // poisoned only by a panic, which the scope hands on
        let mut first = failed
            .lock()
            .unwrap_or_else(|poisoned| poisoned.into_inner());
        if first.is_none() {
            *first = error;
        }
        first.is_some()
    };
    std::thread::scope(|scope| {
        for _ in 0..crew.min(todo.len()) {
            scope.spawn(|| {
                while let Some(task) = todo.get(next.fetch_add(1, Ordering::Relaxed)) {
                    if first_error(None) {
                        return;
                    }
                    if let Err(error) = perform(task) {
                        first_error(Some(error));
                    }
                }
            });
        }
    });
    let first = failed
        .into_inner()
        .unwrap_or_else(|poisoned| poisoned.into_inner());
    first.map_or(Ok(()), Err)
}
