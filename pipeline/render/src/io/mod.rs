//! Files: OpenEXR frames, PNG pictures, camera paths.

pub mod camera_path;
pub mod exr;
pub mod png;
mod replace;
