//! Around decoders of other crates: limits on what a file may ask for, and their errors and
//! panics as one typed error. Decoders meet hostile bytes in fuzzing and damaged ones in life.

use crate::atomic::io_error;
use crate::error::StoreError;
use std::fs::File;
use std::io::Read;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

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
        let file = File::open(self.path).map_err(fail)?;
        let size = file.metadata().map_err(fail)?.len();
        let mut bytes = Vec::new();
        // A file can grow, and a device has no size.
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
        match catch_unwind(AssertUnwindSafe(decode)) {
            Ok(Ok(value)) => Ok(value),
            Ok(Err(error)) => Err(self.corrupt(error)),
            Err(_) => Err(self.corrupt("the decoder gave up")),
        }
    }
}
