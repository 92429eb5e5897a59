//! A bake that Python can watch and stop.

use crate::error::raised;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use rrf_cli::embedded::{BakeEvent, Listener, bake_scene};
use std::ffi::OsString;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::time::Duration;

/// Time between two looks at Python's signals.
const LOOK: Duration = Duration::from_millis(50);

/// Bakes by the words of `rrf bake`; the result as JSON. `progress` is called with a dictionary a
/// step, on the calling thread. Ctrl-C stops the bake.
#[pyfunction]
#[pyo3(signature = (words, progress=None))]
pub fn bake(
    py: Python<'_>,
    words: Vec<OsString>,
    progress: Option<Bound<'_, PyAny>>,
) -> PyResult<String> {
    let (send, mut receive) = mpsc::channel();
    let interrupted = Arc::new(AtomicBool::new(false));
    let flag = interrupted.clone();
    // the work has a thread of its own: signals and callbacks belong to this one
    let work = std::thread::spawn(move || {
        let listener: Listener = Arc::new(move |event| {
            // nobody listens any more once the bake is being stopped
            let _ = send.send(event);
        });
        bake_scene(&words, &listener, &flag)
    });
    let mut stage = (String::new(), 0u64, 0u64);
    let mut raised_here = None;
    loop {
        let listen = &mut receive;
        let event = py.detach(move || listen.recv_timeout(LOOK));
        let told = match event {
            Ok(event) => match &progress {
                Some(progress) if raised_here.is_none() => tell(progress, &mut stage, event),
                _ => Ok(()),
            },
            Err(RecvTimeoutError::Timeout) => Ok(()),
            Err(RecvTimeoutError::Disconnected) => break,
        };
        if let Err(error) = told.and_then(|()| py.check_signals()) {
            interrupted.store(true, Ordering::Relaxed);
            raised_here.get_or_insert(error);
        }
    }
    let done = py.detach(|| work.join());
    if let Some(error) = raised_here {
        return Err(error);
    }
    match done {
        Ok(result) => result.map_err(raised),
        Err(_) => Err(pyo3::exceptions::PyRuntimeError::new_err(
            "the bake's thread ended by a panic, which is a fault of rrf",
        )),
    }
}

/// Calls `progress` with what happened: the stage's name, steps done and total, or a round's error.
fn tell(
    progress: &Bound<'_, PyAny>,
    stage: &mut (String, u64, u64),
    event: BakeEvent,
) -> PyResult<()> {
    let told = PyDict::new(progress.py());
    match event {
        BakeEvent::Stage { name, total } => *stage = (name, 0, total),
        BakeEvent::Advance(steps) => stage.1 += steps,
        BakeEvent::Round {
            round,
            cells,
            error,
            error_se,
        } => {
            told.set_item("round", round)?;
            told.set_item("cells", cells)?;
            told.set_item("relative_error", error)?;
            told.set_item("relative_error_se", error_se)?;
        }
    }
    told.set_item("stage", &stage.0)?;
    told.set_item("done", stage.1)?;
    told.set_item("total", stage.2)?;
    progress.call1((told,)).map(drop)
}
