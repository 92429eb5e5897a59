//! Pictures from buffer views, data URIs and files.

use super::buffers::read_uri;
use super::document::Document;
use super::uv::TextureUse;
use crate::texture::{Encoding, TextureTable};
use crate::{INVALID, SceneError, Texture};
use ::gltf::json;
use ::gltf::json::Index;
use glam::Vec3;
use std::borrow::Cow;

/// The scene's textures, each image decoded once a use.
pub(super) struct Pictures<'a> {
    document: &'a Document<'a>,
    table: TextureTable<usize>,
}

impl<'a> Pictures<'a> {
    /// None yet.
    pub(super) fn new(document: &'a Document<'a>) -> Self {
        Self {
            document,
            table: TextureTable::new(),
        }
    }

    /// The textures, ids as positions.
    pub(super) fn into_textures(self) -> Vec<Texture> {
        self.table.into_textures()
    }

    /// Scene id of a material's texture, or [`INVALID`] for none.
    pub(super) fn texture(
        &mut self,
        used: Option<TextureUse>,
        encoding: Encoding,
        place: &str,
    ) -> Result<u32, SceneError> {
        let Some(used) = used else {
            return Ok(INVALID);
        };
        let image = self.image(used.texture, place)?;
        if let Some(id) = self.table.get(image.value(), encoding) {
            return Ok(id);
        }
        let bytes = self.bytes(image, place)?;
        let id = self.table.insert(image.value(), encoding, &bytes);
        id.map_err(|message| self.error(image, place, message))
    }

    /// Mean linear colour of an sRGB texture.
    pub(super) fn mean(
        &self,
        texture: Index<json::Texture>,
        place: &str,
    ) -> Result<Vec3, SceneError> {
        let image = self.image(texture, place)?;
        let bytes = self.bytes(image, place)?;
        let mean = self.table.mean(Encoding::Srgb, &bytes);
        mean.map_err(|message| self.error(image, place, message))
    }

    fn image(
        &self,
        texture: Index<json::Texture>,
        place: &str,
    ) -> Result<Index<json::Image>, SceneError> {
        let texture = self.document.root.get(texture);
        texture
            .map(|texture| texture.source)
            .ok_or_else(|| self.document.error(place, "no such texture"))
    }

    /// The bytes of a picture file.
    fn bytes(&self, index: Index<json::Image>, place: &str) -> Result<Cow<'a, [u8]>, SceneError> {
        let wrong = |message: &str| self.error(index, place, message);
        let image = self.document.root.get(index);
        let image = image.ok_or_else(|| wrong("no such image"))?;
        match (image.buffer_view, &image.uri) {
            (Some(view), _) => self
                .document
                .view_bytes(view)
                .map(Cow::Borrowed)
                .map_err(|message| wrong(&message)),
            (None, Some(uri)) => {
                let place = || format!("{place}, image {index}");
                Ok(read_uri(self.document.path, uri, place)?.into())
            }
            (None, None) => Err(wrong("neither uri nor bufferView")),
        }
    }

    fn error(
        &self,
        image: Index<json::Image>,
        place: &str,
        message: impl Into<String>,
    ) -> SceneError {
        let place = format!("{place}, image {image}");
        self.document.error(place, message)
    }
}
