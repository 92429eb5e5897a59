//! Runs in object stores: `s3://`, `gs://`, `az://` (and `file://`).
//!
//! The stages work on a folder of this machine; this crate keeps that folder and the store the
//! same. A file of a run is written once and named by what it is, so that it is put *if absent*:
//! of two writers of one part, one wins and the other finds that it was done. Only the model's
//! tables change from round to round and are replaced.
//!
//! Credentials and endpoints come from the environment, as the stores' own tools take them
//! (`AWS_ACCESS_KEY_ID`, `AWS_ENDPOINT`, `GOOGLE_SERVICE_ACCOUNT`, `AZURE_STORAGE_ACCOUNT_NAME`, ...).

#![cfg_attr(test, allow(clippy::unwrap_used, clippy::expect_used, clippy::panic))]

mod error;
mod mirror;
mod remote;

pub use error::RemoteError;
pub use mirror::Mirror;
pub use remote::{Put, Remote, is_url};
