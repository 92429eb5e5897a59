//! Files: OpenEXR frames, PNG pictures, camera paths.

pub mod camera_path;
pub mod exr;
mod exr_file;
pub mod png;
mod replace;
