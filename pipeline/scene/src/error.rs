//! Why a scene file was refused.

use std::path::PathBuf;

/// A scene file that cannot be understood, with the place and the reason.
#[derive(Debug, thiserror::Error)]
pub enum SceneError {
    /// The file, or one that it names, cannot be read.
    #[error("{path}: cannot be read: {source}", path = path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// The system's reason.
        source: std::io::Error,
    },
    /// Text that does not follow its format.
    #[error("{path}:{line}:{column}: {message}", path = path.display())]
    Syntax {
        /// The file.
        path: PathBuf,
        /// Line, from 1.
        line: u32,
        /// Column in characters, from 1.
        column: u32,
        /// The fault, and what would be right.
        message: String,
    },
    /// The file is well-formed but its content cannot be a scene.
    #[error("{path}: {place}: {message}", path = path.display())]
    Content {
        /// The file.
        path: PathBuf,
        /// Mesh, node, material or accessor.
        place: String,
        /// The fault, and what would be right.
        message: String,
    },
    /// The ending names no format that is read here.
    #[error("{path}: unknown scene format (read here: .pbrt, .gltf, .glb, .obj)", path = path.display())]
    UnknownFormat {
        /// The file.
        path: PathBuf,
    },
}
