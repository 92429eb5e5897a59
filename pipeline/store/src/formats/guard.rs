//! Around decoders of other crates: limits on what a file may ask for, and their errors and
//! panics as one typed error. Decoders meet hostile bytes in fuzzing and damaged ones in life.

use crate::atomic::io_error;
use crate::error::StoreError;
use std::cell::Cell;
use std::fs::File;
use std::io::Read;
use std::panic::{AssertUnwindSafe, catch_unwind, set_hook, take_hook};
use std::path::Path;
use std::sync::Once;

/// How much memory a file may ask for.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// Bytes of all values decoded.
    pub decoded_bytes: u64,
    /// Rows a batch.
    pub batch_rows: usize,
}

impl Default for Limits {
    /// 4 GiB, 65,536 rows a batch.
    fn default() -> Limits {
        Limits {
            decoded_bytes: 4 << 30,
            batch_rows: 65_536,
        }
    }
}

/// Words by which the decoders say that a file is sound but beyond them.
const UNSUPPORTED: [&str; 3] = [
    "Disabled feature at compile time",
    "NYI: ",
    "Not yet implemented",
];

thread_local! {
    static IS_DECODING: Cell<bool> = const { Cell::new(false) };
}

/// Runs a decoder whose panics become errors, without the trace that a panic prints.
fn quietly<T>(decode: impl FnOnce() -> T) -> std::thread::Result<T> {
    static HOOK: Once = Once::new();
    HOOK.call_once(|| {
        let before = take_hook();
        set_hook(Box::new(move |panic| {
            if !IS_DECODING.get() {
                before(panic);
            }
        }));
    });
    let before = IS_DECODING.replace(true);
    let result = catch_unwind(AssertUnwindSafe(decode));
    IS_DECODING.set(before);
    result
}

/// What is being read, for messages.
pub(crate) struct Guard<'a> {
    pub path: &'a Path,
    pub format: &'static str,
    pub remedy: &'static str,
}

impl Guard<'_> {
    pub(crate) fn corrupt(&self, reason: impl ToString) -> StoreError {
        StoreError::Corrupt {
            path: self.path.into(),
            format: self.format,
            reason: reason.to_string(),
            remedy: self.remedy,
        }
    }

    pub(crate) fn unsupported(&self, what: String, remedy: &'static str) -> StoreError {
        StoreError::Unsupported {
            path: self.path.into(),
            what,
            remedy,
        }
    }

    pub(crate) fn too_large(&self, what: &'static str, found: u64, limit: u64) -> StoreError {
        StoreError::TooLarge {
            path: self.path.into(),
            what,
            found,
            limit,
        }
    }

    /// The whole file, which must not be larger than what may be decoded from it.
    pub(crate) fn read(&self, limits: Limits) -> Result<Vec<u8>, StoreError> {
        let fail = |e| io_error(self.path, "read", e);
        let found = self.path.metadata().map_err(fail)?;
        if !found.is_file() && !found.is_dir() {
            // a device or pipe may never end, or never begin
            let what = "it is no regular file".to_owned();
            return Err(self.unsupported(what, "Copy it into a file first"));
        }
        let file = File::open(self.path).map_err(fail)?;
        let size = file.metadata().map_err(fail)?.len();
        let mut bytes = Vec::new();
        // A file can grow.
        if size <= limits.decoded_bytes {
            let mut rest = file.take(limits.decoded_bytes.saturating_add(1));
            rest.read_to_end(&mut bytes).map_err(fail)?;
        }
        let size = size.max(bytes.len() as u64);
        if size > limits.decoded_bytes {
            return Err(self.too_large("its size in bytes", size, limits.decoded_bytes));
        }
        Ok(bytes)
    }

    /// Runs a decoder.
    pub(crate) fn run<T, E: std::fmt::Display>(
        &self,
        decode: impl FnOnce() -> Result<T, E>,
    ) -> Result<T, StoreError> {
        match quietly(decode) {
            Ok(Ok(value)) => Ok(value),
            Ok(Err(error)) => {
                let reason = error.to_string();
                if UNSUPPORTED.iter().any(|words| reason.contains(words)) {
                    let what = format!("it uses what is not read here: {reason}");
                    return Err(self.unsupported(what, "Write it with another compression"));
                }
                Err(self.corrupt(reason))
            }
            Err(_) => Err(self.corrupt("the decoder gave up")),
        }
    }
}
