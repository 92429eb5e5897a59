//! The files of a run folder: manifest, plans, task shards, evaluations, samples and timings.

pub(crate) mod folder;
pub(crate) mod json;
pub(crate) mod manifest;
pub(crate) mod method;
pub(crate) mod renew;
pub(crate) mod rounds;
pub(crate) mod samples;
pub(crate) mod shards;
pub(crate) mod timings;
