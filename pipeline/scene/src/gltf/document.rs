//! From bytes to a checked JSON document.

use crate::SceneError;
use crate::warn::Warnings;
use ::gltf::Glb;
use ::gltf::json::mesh::Semantic;
use ::gltf::json::validation::{Checked, Error as Fault, Validate};
use ::gltf::json::{Node, Path as JsonPath, Root};
use std::borrow::Cow;
use std::path::Path;

/// Extensions that are read here.
pub(super) const EXTENSIONS: [&str; 11] = [
    "EXT_lights_ies",
    "EXT_texture_webp",
    "KHR_lights_punctual",
    "KHR_materials_clearcoat",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_volume",
    "KHR_mesh_quantization",
    "KHR_texture_transform",
];

/// Faults listed in one error message; the rest are counted.
const LISTED_FAULTS: usize = 5;

/// A checked document with its binary data.
pub(super) struct Document<'a> {
    /// The file.
    pub(super) path: &'a Path,
    /// The JSON part; every reference in it is in range.
    pub(super) root: &'a Root,
    /// Bytes of each buffer, exactly as long as declared.
    pub(super) buffers: Vec<Cow<'a, [u8]>>,
}

impl Document<'_> {
    /// An error at `place` of this file.
    pub(super) fn error(&self, place: impl Into<String>, message: impl Into<String>) -> SceneError {
        content(self.path, place, message)
    }

    /// `node 3 "Lamp"`.
    pub(super) fn node_place(&self, index: usize) -> String {
        let node = self.root.nodes.get(index);
        place("node", index, node.and_then(|node| node.name.as_deref()))
    }
}

/// An error at `place` of file `path`.
pub(super) fn content(
    path: &Path,
    place: impl Into<String>,
    message: impl Into<String>,
) -> SceneError {
    SceneError::Content {
        path: path.to_path_buf(),
        place: place.into(),
        message: message.into(),
    }
}

/// `kind index "name"`.
pub(super) fn place(kind: &str, index: usize, name: Option<&str>) -> String {
    match name {
        Some(name) => format!("{kind} {index} {name:?}"),
        None => format!("{kind} {index}"),
    }
}

/// A `.glb`'s chunk of binary data.
pub(super) type Chunk<'a> = Option<Cow<'a, [u8]>>;

/// The JSON part, checked, and the binary chunk.
pub(super) fn parse<'a>(path: &Path, bytes: &'a [u8]) -> Result<(Root, Chunk<'a>), SceneError> {
    let (json, chunk) = split(path, bytes)?;
    let json = crate::file::text(&json);
    let root = Root::from_str(&json).map_err(|error| SceneError::Syntax {
        path: path.to_path_buf(),
        line: error.line() as u32,
        // 0 at the end of an empty text.
        column: (error.column() as u32).max(1),
        message: format!("glTF's JSON: {error}"),
    })?;
    check_version(path, &root)?;
    check_extensions(path, &root)?;
    check_references(path, &root)?;
    Ok((root, chunk))
}

/// Splits a `.glb` container (glTF 2.0, section 4.4); other bytes are JSON text.
fn split<'a>(path: &Path, bytes: &'a [u8]) -> Result<(Cow<'a, [u8]>, Chunk<'a>), SceneError> {
    if !bytes.starts_with(b"glTF") {
        return Ok((Cow::Borrowed(bytes), None));
    }
    let place = "GLB container";
    // `Glb::from_slice` subtracts the header's 12 bytes from the declared length unchecked.
    let declared = bytes
        .get(8..12)
        .and_then(|length| length.try_into().ok())
        .map_or(0, u32::from_le_bytes);
    if declared < 12 || declared as usize > bytes.len() {
        let message = format!(
            "the header says {declared} bytes, the file has {}: truncated or not a .glb",
            bytes.len()
        );
        return Err(content(path, place, message));
    }
    let body = bytes.get(..declared as usize).unwrap_or(bytes);
    let glb = Glb::from_slice(body).map_err(|error| content(path, place, error.to_string()))?;
    Ok((glb.json, glb.bin))
}

fn check_version(path: &Path, root: &Root) -> Result<(), SceneError> {
    let asset = &root.asset;
    let needed = asset.min_version.as_ref().unwrap_or(&asset.version);
    if needed == "2.0" || (asset.min_version.is_none() && needed.starts_with("2.")) {
        return Ok(());
    }
    let message = format!("glTF version {needed}: only 2.0 is read here");
    Err(content(path, "asset", message))
}

/// Extensions that compress what a reader needs, with what they do and the remedy. They
/// are refused even where a file lists them as used only: without them, nothing is there.
const COMPRESSIONS: [(&str, &str); 3] = [
    (
        "KHR_draco_mesh_compression",
        "Draco's compression of meshes is not read here; export without it, or unpack the file \
         with `gltf-transform copy IN.glb OUT.glb`",
    ),
    (
        "EXT_meshopt_compression",
        "meshopt's compression is not read here; export without it, or unpack the file with \
         `gltf-transform copy IN.glb OUT.glb`",
    ),
    (
        "KHR_texture_basisu",
        "KTX2 pictures are not read here; export with PNG, JPEG or WebP pictures, or unpack \
         them with `gltf-transform ktxdecompress IN.glb OUT.glb`",
    ),
];

fn check_extensions(path: &Path, root: &Root) -> Result<(), SceneError> {
    let is_needed = |name: &str| {
        let all = root.extensions_used.iter().chain(&root.extensions_required);
        all.into_iter().any(|used| used == name) && !has_fallback(root, name)
    };
    if let Some((name, remedy)) = COMPRESSIONS.iter().find(|(name, _)| is_needed(name)) {
        return Err(content(path, *name, *remedy));
    }
    let unknown: Vec<&str> = root
        .extensions_required
        .iter()
        .map(String::as_str)
        .filter(|name| !EXTENSIONS.contains(name))
        .collect();
    if unknown.is_empty() {
        return Ok(());
    }
    let message = format!(
        "{} not read here (read: {}); export without",
        unknown.join(", "),
        EXTENSIONS.join(", ")
    );
    Err(content(path, "extensionsRequired", message))
}

/// Whether a file that only uses a compression has its content without it too.
fn has_fallback(root: &Root, name: &str) -> bool {
    if root
        .extensions_required
        .iter()
        .any(|required| required == name)
    {
        return false;
    }
    match name {
        "KHR_draco_mesh_compression" => root
            .accessors
            .iter()
            .all(|accessor| accessor.buffer_view.is_some() || accessor.sparse.is_some()),
        "EXT_meshopt_compression" => root
            .buffers
            .iter()
            .enumerate()
            .all(|(index, buffer)| buffer.uri.is_some() || index == 0),
        _ => (root.textures.iter()).all(|texture| texture.source.value() < root.images.len()),
    }
}

/// The crate's validation, without what it asks for and no reader needs.
fn check_references(path: &Path, root: &Root) -> Result<(), SceneError> {
    check_position_accessors(path, root)?;
    let mut faults = Vec::new();
    root.validate(root, JsonPath::new, &mut |place, fault| {
        let place = place().to_string();
        // Bounds of positions are computed from the positions, never from the file's word,
        // and required extensions have been checked above.
        let is_bound =
            place.ends_with("[\"POSITION\"].min") || place.ends_with("[\"POSITION\"].max");
        if !is_bound && fault != Fault::Unsupported {
            faults.push(format!("{place}: {fault}"));
        }
    });
    if faults.is_empty() {
        return Ok(());
    }
    let more = faults.len().saturating_sub(LISTED_FAULTS);
    faults.truncate(LISTED_FAULTS);
    let mut message = faults.join("; ");
    if more > 0 {
        message += &format!("; and {more} more");
    }
    Err(content(path, "document", message))
}

/// The crate's validation indexes the accessor of POSITION without a check.
fn check_position_accessors(path: &Path, root: &Root) -> Result<(), SceneError> {
    for (m, mesh) in root.meshes.iter().enumerate() {
        for (p, primitive) in mesh.primitives.iter().enumerate() {
            let key = Checked::Valid(Semantic::Positions);
            let accessor = primitive.attributes.get(&key).map(|index| index.value());
            if let Some(accessor) = accessor.filter(|&index| index >= root.accessors.len()) {
                let place = place("mesh", m, mesh.name.as_deref());
                return Err(content(
                    path,
                    format!("{place}, primitive {p}"),
                    format!(
                        "POSITION is accessor {accessor}, the file has {}",
                        root.accessors.len()
                    ),
                ));
            }
        }
    }
    Ok(())
}

/// Warns of whole chapters of the document that are not read.
pub(super) fn note_left_out(root: &Root, warnings: &mut Warnings) {
    for name in &root.extensions_used {
        if !EXTENSIONS.contains(&name.as_str()) {
            let message = "extension not read here: as if the file did not use it";
            warnings.add(name.clone(), message);
        }
    }
    if !root.animations.is_empty() {
        let place = format!("{} animations", root.animations.len());
        warnings.add(place, "left out: the scene is read as its nodes stand");
    }
    let is_deformed = |node: &Node| node.skin.is_some() && node.mesh.is_some();
    if root.nodes.iter().any(is_deformed) {
        let message = "skins left out: meshes are read unskinned, at their nodes";
        warnings.add("skins", message);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refused(bytes: &[u8]) -> String {
        parse(Path::new("x.glb"), bytes).unwrap_err().to_string()
    }

    #[test]
    fn broken_containers_and_json_say_where() {
        assert!(refused(b"").contains("x.glb:1:1"), "{}", refused(b""));
        assert!(refused(b"{\n 1}").contains("x.glb:2:"));
        assert!(refused(b"glTF").contains("GLB container"));
        assert!(refused(b"glTF\x02\0\0\0\x05\0\0\0").contains("GLB container"));
        assert!(refused(b"glTF\x02\0\0\0\xff\xff\0\0").contains("truncated"));
        assert!(refused(b"glTF\x01\0\0\0\x0c\0\0\0").contains("version"));
    }

    #[test]
    fn versions_and_extensions_are_refused_by_name() {
        assert!(refused(br#"{"asset":{"version":"1.0"}}"#).contains("1.0"));
        let json =
            br#"{"asset":{"version":"2.0"},"extensionsRequired":["KHR_draco_mesh_compression"]}"#;
        assert!(refused(json).contains("KHR_draco_mesh_compression"));
        let json = br#"{"asset":{"version":"2.0"},"extensionsRequired":["KHR_materials_specular","KHR_mesh_quantization"]}"#;
        assert!(parse(Path::new("x.gltf"), json).is_ok());
    }

    #[test]
    fn references_out_of_range_are_named() {
        let json = br#"{"asset":{"version":"2.0"},"meshes":[{"name":"M","primitives":[{"attributes":{"POSITION":7}}]}]}"#;
        assert!(refused(json).contains(r#"mesh 0 "M", primitive 0: POSITION is accessor 7"#));
        let json = br#"{"asset":{"version":"2.0"},"nodes":[{"mesh":3}]}"#;
        assert!(refused(json).contains("nodes[0].mesh"), "{}", refused(json));
    }
}
