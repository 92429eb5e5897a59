//! A pool of workers, as many as there are threads or as fit into memory.

use crate::error::BakeError;
use crate::plan::task::Task;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Number of tasks in work at a time, and the memory of each.
pub(crate) struct WorkerPool {
    /// Number of workers.
    pub workers: usize,
    /// Memory for each task [bytes]; none for no limit.
    pub memory: Option<u64>,
}

impl WorkerPool {
    /// The largest pool whose tasks fit into `memory` bytes together. A task that needs more than all
    /// of it counts with its minimum.
    pub fn for_tasks(todo: &[Task], memory: Option<u64>) -> Result<WorkerPool, BakeError> {
        let threads = rayon::current_num_threads();
        let Some(memory) = memory else {
            return Ok(WorkerPool {
                workers: threads,
                memory: None,
            });
        };
        let need = |task: &Task| match task.memory <= memory {
            true => task.memory,
            false => task.least_memory,
        };
        let needed = todo.iter().map(need).max().unwrap_or(0);
        let workers = usize::try_from(memory / needed.max(1)).unwrap_or(threads);
        let workers = workers.min(threads);
        match workers {
            0 => Err(BakeError::Memory { needed, memory }),
            _ => Ok(WorkerPool {
                workers,
                memory: Some(memory / workers as u64),
            }),
        }
    }

    /// Performs the tasks in their order; after an error no further one begins.
    ///
    /// Plain threads, not rayon's: a worker that waits for a loop of its own task would begin another
    /// task there meanwhile, and hold the memory of both.
    pub fn run(
        &self,
        todo: &[Task],
        perform: impl Fn(&Task) -> Result<(), BakeError> + Sync,
    ) -> Result<(), BakeError> {
        let next = AtomicUsize::new(0);
        let failed: Mutex<Option<BakeError>> = Mutex::new(None);
        let first_error = |error: Option<BakeError>| {
            // poisoned only by a panic, which the scope passes on
            let mut first = failed
                .lock()
                .unwrap_or_else(|poisoned| poisoned.into_inner());
            if first.is_none() {
                *first = error;
            }
            first.is_some()
        };
        std::thread::scope(|scope| {
            for _ in 0..self.workers.min(todo.len()) {
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
}
