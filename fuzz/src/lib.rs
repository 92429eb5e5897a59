//! What the fuzz targets share: each writes the bytes where a reader looks for them and reads.
//!
//! A reader may refuse whatever it likes; it may not panic, hang, or ask for much memory.
//! Panics inside the decoders of arrow and parquet that `rrf_store` turns into errors are not
//! findings, so the hook that libFuzzer's crate aborts from is taken out; a panic that leaves a
//! reader still ends the process.

#[cfg(not(feature = "no-tables"))]
mod tables;

use rrf_scene::LoadOptions;
use std::path::{Path, PathBuf};
use std::sync::{Once, OnceLock};
#[cfg(not(feature = "no-tables"))]
pub use tables::{arrow, parquet, small};

/// A pbrt scene.
pub fn pbrt(bytes: &[u8]) {
    scene("scene.pbrt", bytes);
}

/// A glTF scene, text or binary.
pub fn gltf(bytes: &[u8]) {
    match bytes.starts_with(b"glTF") {
        true => scene("scene.glb", bytes),
        false => scene("scene.gltf", bytes),
    }
}

/// An OBJ scene and, after the first zero byte, its material library.
pub fn obj(bytes: &[u8]) {
    let mut parts = bytes.splitn(2, |&byte| byte == 0);
    let obj = parts.next().unwrap_or_default();
    write(
        &folder().join("scene/a.mtl"),
        parts.next().unwrap_or_default(),
    );
    scene("a.obj", obj);
}

/// A picture in OpenEXR, as one of some parts and as a frame of this program.
pub fn exr(bytes: &[u8]) {
    let path = write(&folder().join("a.exr"), bytes);
    let _ = rrf_render::exr::read_exr(&path);
    let _ = rrf_render::exr::read_exr_layer(&path, "indirect");
    let _ = rrf_render::exr::read_exr_frame(&path);
}

fn scene(name: &str, bytes: &[u8]) {
    let path = write(&folder().join("scene").join(name), bytes);
    let _ = rrf_scene::load(&path, &LoadOptions::default());
}

fn write(path: &Path, bytes: &[u8]) -> PathBuf {
    std::fs::write(path, bytes).expect("the scratch folder can be written");
    path.into()
}

/// A scratch folder, in memory where there is one.
fn folder() -> &'static Path {
    static FOLDER: OnceLock<PathBuf> = OnceLock::new();
    static HOOK: Once = Once::new();
    HOOK.call_once(|| std::panic::set_hook(Box::new(|_| ())));
    FOLDER.get_or_init(|| {
        let memory = Path::new("/dev/shm");
        let base = match memory.is_dir() {
            true => memory.into(),
            false => std::env::temp_dir(),
        };
        let folder = base.join(format!("rrf-fuzz-{}", std::process::id()));
        std::fs::create_dir_all(folder.join("scene")).expect("a scratch folder");
        #[cfg(not(feature = "no-tables"))]
        tables::make_folders(&folder);
        folder
    })
}

/// Removes the scratch folder.
pub fn clean() {
    let _ = std::fs::remove_dir_all(folder());
}
