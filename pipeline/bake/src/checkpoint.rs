//! The state of a long fit in `RUN/staging/`, for who goes on with it after a kill.

use crate::run::Run;
use crate::task::Task;
use rrf_store::atomic::{atomic_write_from, create_folder};
use rrf_store::layout::staging_folder;
use rrf_train::checkpoint::Keeper;
use std::cell::Cell;
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// From one checkpoint to the next; shorter fits have none.
const EVERY: Duration = Duration::from_secs(30);
/// Seconds in its place.
const VARIABLE: &str = "RRF_CHECKPOINT_SECONDS";

/// One file: blake3 of the rest, the task's hash, the state.
pub(crate) struct Checkpoint {
    folder: PathBuf,
    name: String,
    task: String,
    every: Duration,
    last: Cell<Instant>,
}

impl Checkpoint {
    /// Of a fit.
    pub fn of(run: &Run, task: &Task) -> Checkpoint {
        let asked = std::env::var(VARIABLE).ok();
        let seconds = asked.and_then(|text| text.parse().ok());
        let every = seconds.and_then(|s| Duration::try_from_secs_f64(s).ok());
        Checkpoint {
            folder: staging_folder(&run.folder),
            name: format!("checkpoint-cell={:06}", task.cell),
            task: task.hash.clone(),
            every: every.unwrap_or(EVERY),
            last: Cell::new(Instant::now()),
        }
    }

    fn path(&self) -> PathBuf {
        // the ending of what is unfinished: the end of a round removes what was forgotten
        self.folder.join(format!("{}.tmp", self.name))
    }

    /// The fit is there: its state is of no more use.
    pub fn remove(&self) {
        let _ = std::fs::remove_file(self.path());
    }
}

impl Keeper for Checkpoint {
    /// A file that is damaged or of other inputs counts as none: the fit begins anew.
    fn load(&self) -> Option<Vec<u8>> {
        let bytes = std::fs::read(self.path()).ok()?;
        let (hash, rest) = bytes.split_at_checked(blake3::OUT_LEN)?;
        let (task, state) = rest.split_at_checked(self.task.len())?;
        let whole = blake3::hash(rest).as_bytes() == hash;
        (whole && task == self.task.as_bytes()).then(|| state.to_vec())
    }

    fn is_due(&self) -> bool {
        self.last.get().elapsed() >= self.every
    }

    /// One that cannot be written costs time after a kill and nothing else; that the disk is full
    /// is said where the fit itself is written.
    fn save(&self, state: &[u8]) {
        let rest = [self.task.as_bytes(), state].concat();
        let bytes = [blake3::hash(&rest).as_bytes(), rest.as_slice()].concat();
        let _ = create_folder(&self.folder)
            .and_then(|()| atomic_write_from(&self.folder, &self.name, &self.path(), &bytes));
        self.last.set(Instant::now());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn checkpoint(folder: &std::path::Path, hash: &str) -> Checkpoint {
        Checkpoint {
            folder: folder.into(),
            name: "checkpoint-cell=000003".into(),
            task: hash.into(),
            every: EVERY,
            last: Cell::new(Instant::now()),
        }
    }

    #[test]
    fn a_checkpoint_is_of_its_task_and_whole() {
        let folder = tempfile::tempdir().unwrap();
        let kept = checkpoint(folder.path(), "abc");
        assert_eq!(kept.load(), None);
        kept.save(b"state");
        assert_eq!(kept.load().unwrap(), b"state");
        assert_eq!(checkpoint(folder.path(), "abd").load(), None);
        let mut bytes = std::fs::read(kept.path()).unwrap();
        for at in 0..bytes.len() {
            bytes[at] ^= 1;
            std::fs::write(kept.path(), &bytes).unwrap();
            assert_eq!(kept.load(), None, "byte {at}");
            bytes[at] ^= 1;
        }
        std::fs::write(kept.path(), &bytes[..20]).unwrap();
        assert_eq!(kept.load(), None);
        kept.remove();
        assert!(!kept.path().exists());
    }
}
