//! A window to look through: a page on this machine that shows a baked field as a live picture.
//!
//! [`Server`] listens on the loopback address alone. A request's journey: `http` reads its head
//! and lets it in only with the token of the URL and from this very page (`Host`, `Origin`);
//! `/` is answered with the page, one file without any outside resource; `/frames` and `/trace`
//! become WebSockets. On `/frames` each question ([`ask`]) brings one frame: the page asks again
//! when it has shown the last, so frames skip rather than queue, and a page that is closed asks
//! no more. On `/trace` each question brings another pass of paths, added to those before, and
//! how far the nets' picture is from their mean.
//!
//! Every connection has a thread and a camera of its own; frames share the processor.

#![cfg_attr(test, allow(clippy::unwrap_used, clippy::expect_used, clippy::panic))]

pub mod ask;
mod connections;
mod error;
mod frames;
mod http;
mod lamps;
mod own;
mod page;
mod pixels;
mod server;
mod show;
mod socket;
mod traced;

pub use error::ViewError;
pub use own::OwnLights;
pub use server::{Server, Stopper};
pub use show::{Show, ShownModel};
