//! Tasks side by side, as many as there are threads or as fit into memory.

use crate::error::BakeError;
use crate::task::Task;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

/// How many tasks may be in hand at once.
pub(crate) fn size(todo: &[Task], memory: Option<u64>) -> Result<usize, BakeError> {
    let threads = rayon::current_num_threads();
    let largest = todo.iter().map(|task| task.memory).max().unwrap_or(0);
    let Some(memory) = memory else {
        return Ok(threads);
    };
    match usize::try_from(memory / largest.max(1)) {
        Ok(0) => Err(BakeError::Memory {
            needed: largest,
            memory,
        }),
        fitting => Ok(fitting.unwrap_or(threads).min(threads)),
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
