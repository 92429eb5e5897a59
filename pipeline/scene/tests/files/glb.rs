//! Small glTF files built in memory, for the tests.

use rrf_scene::{LoadOptions, Scene, SceneError, load};
use serde_json::{Value, json};

/// A `.glb` in the making: JSON and one buffer.
pub struct Glb {
    pub json: Value,
    pub bin: Vec<u8>,
}

impl Glb {
    /// An empty document with one empty scene.
    pub fn new() -> Self {
        Self {
            json: json!({
                "asset": { "version": "2.0" },
                "scene": 0,
                "scenes": [{ "nodes": [] }],
            }),
            bin: Vec::new(),
        }
    }

    /// Appends to one of the document's arrays; its index.
    pub fn push(&mut self, array: &str, value: Value) -> usize {
        let list = &mut self.json[array];
        if list.is_null() {
            *list = json!([]);
        }
        let list = list.as_array_mut().unwrap();
        list.push(value);
        list.len() - 1
    }

    /// A buffer view of `bytes`.
    pub fn view(&mut self, bytes: &[u8]) -> usize {
        self.bin.resize(self.bin.len().next_multiple_of(4), 0);
        let offset = self.bin.len();
        self.bin.extend_from_slice(bytes);
        let view = json!({ "buffer": 0, "byteOffset": offset, "byteLength": bytes.len() });
        self.push("bufferViews", view)
    }

    /// An accessor of f32 vectors.
    pub fn floats<const N: usize>(&mut self, values: &[[f32; N]]) -> usize {
        let bytes: Vec<u8> = values
            .iter()
            .flatten()
            .flat_map(|v| v.to_le_bytes())
            .collect();
        let view = self.view(&bytes);
        let shape = ["", "SCALAR", "VEC2", "VEC3", "VEC4"][N];
        self.push(
            "accessors",
            json!({
                "bufferView": view, "componentType": 5126, "count": values.len(), "type": shape,
            }),
        )
    }

    /// An accessor of unsigned integers: 5121 (u8), 5123 (u16) or 5125 (u32).
    pub fn integers(&mut self, values: &[u32], component: u32) -> usize {
        let size = match component {
            5121 => 1,
            5123 => 2,
            _ => 4,
        };
        let bytes: Vec<u8> = values
            .iter()
            .flat_map(|v| v.to_le_bytes().into_iter().take(size))
            .collect();
        let view = self.view(&bytes);
        self.push(
            "accessors",
            json!({
                "bufferView": view, "componentType": component, "count": values.len(),
                "type": "SCALAR",
            }),
        )
    }

    /// A texture with its picture embedded as PNG, rows from the top.
    pub fn texture(&mut self, width: u32, height: u32, texels: &[[u8; 3]]) -> usize {
        let view = self.view(&png(width, height, texels));
        let image = self.push(
            "images",
            json!({ "bufferView": view, "mimeType": "image/png" }),
        );
        self.push("textures", json!({ "source": image }))
    }

    /// A mesh of one primitive under a node of the scene; the node's index.
    pub fn place(&mut self, primitive: Value, mut node: Value) -> usize {
        let mesh = self.push("meshes", json!({ "primitives": [primitive] }));
        node["mesh"] = json!(mesh);
        self.root(node)
    }

    /// A node of the scene.
    pub fn root(&mut self, node: Value) -> usize {
        let node = self.push("nodes", node);
        let roots = self.json["scenes"][0]["nodes"].as_array_mut().unwrap();
        roots.push(json!(node));
        node
    }

    /// The file's bytes.
    pub fn bytes(&self) -> Vec<u8> {
        let mut json = self.json.clone();
        if !self.bin.is_empty() && json["buffers"].is_null() {
            json["buffers"] = json!([{ "byteLength": self.bin.len() }]);
        }
        let mut json = json.to_string().into_bytes();
        json.resize(json.len().next_multiple_of(4), b' ');
        let mut bin = self.bin.clone();
        bin.resize(bin.len().next_multiple_of(4), 0);
        let mut chunks = chunk(b"JSON", &json);
        if !bin.is_empty() {
            chunks.extend(chunk(b"BIN\0", &bin));
        }
        let mut bytes = b"glTF\x02\0\0\0".to_vec();
        bytes.extend((chunks.len() as u32 + 12).to_le_bytes());
        bytes.extend(chunks);
        bytes
    }

    /// Loads it.
    pub fn load(&self) -> Result<Scene, SceneError> {
        self.load_with(&LoadOptions::default())
    }

    /// Loads it with options.
    pub fn load_with(&self, options: &LoadOptions) -> Result<Scene, SceneError> {
        load_bytes("scene.glb", &self.bytes(), options)
    }

    /// The message with which it is refused; it names the file.
    pub fn refused(&self) -> String {
        let message = self.load().unwrap_err().to_string();
        assert!(message.contains("scene.glb:"), "{message}");
        message
    }
}

fn chunk(kind: &[u8; 4], bytes: &[u8]) -> Vec<u8> {
    let mut chunk = (bytes.len() as u32).to_le_bytes().to_vec();
    chunk.extend(kind);
    chunk.extend(bytes);
    chunk
}

/// A PNG file.
pub fn png(width: u32, height: u32, texels: &[[u8; 3]]) -> Vec<u8> {
    let mut bytes = std::io::Cursor::new(Vec::new());
    let raw = texels.iter().flatten().copied().collect();
    image::RgbImage::from_raw(width, height, raw)
        .unwrap()
        .write_to(&mut bytes, image::ImageFormat::Png)
        .unwrap();
    bytes.into_inner()
}

/// Loads a file of a temporary folder.
pub fn load_bytes(name: &str, bytes: &[u8], options: &LoadOptions) -> Result<Scene, SceneError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).unwrap();
    load(&path, options)
}
