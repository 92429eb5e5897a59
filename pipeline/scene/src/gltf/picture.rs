//! Pictures from buffer views, data URIs and files.

use super::buffers::read_uri;
use super::document::Document;
use super::uv::TextureUse;
use crate::lost::LostPictures;
use crate::texture::{Encoding, TextureTable, format_of};
use crate::{INVALID, SceneError, Texture};
use ::gltf::json;
use ::gltf::json::Index;
use std::borrow::Cow;
use std::path::Path;

/// The scene's textures, each image decoded once a use.
pub(super) struct Pictures<'a> {
    document: &'a Document<'a>,
    table: TextureTable<usize>,
    /// Pictures that are not there.
    pub(super) lost: LostPictures,
}

impl<'a> Pictures<'a> {
    /// None yet.
    pub(super) fn new(document: &'a Document<'a>) -> Self {
        Self {
            document,
            table: TextureTable::new(),
            lost: LostPictures::default(),
        }
    }

    /// The textures, ids as positions.
    pub(super) fn into_textures(self) -> Vec<Texture> {
        self.table.into_textures()
    }

    /// Scene id of a material's texture, or [`INVALID`] for none and for a lost one.
    pub(super) fn texture(
        &mut self,
        used: Option<TextureUse>,
        encoding: Encoding,
        place: &str,
    ) -> Result<u32, SceneError> {
        let Some(used) = used else {
            return Ok(INVALID);
        };
        let Some(image) = self.image(used.texture, place)? else {
            return Ok(INVALID);
        };
        if let Some(id) = self.table.get(image.value(), encoding) {
            return Ok(id);
        }
        let Some(bytes) = self.bytes(image, place)? else {
            return Ok(INVALID);
        };
        let format = self.format(image);
        let id = self
            .table
            .insert(image.value(), encoding, &bytes, format, |texel| texel);
        id.map_err(|message| self.error(image, place, message))
    }

    /// Scene id of a texture that shines, or [`INVALID`] for none and for a lost one, and the
    /// factor that it lost.
    pub(super) fn light(
        &mut self,
        used: Option<TextureUse>,
        place: &str,
    ) -> Result<(u32, f32), SceneError> {
        let Some(used) = used else {
            return Ok((INVALID, 1.0));
        };
        let Some(image) = self.image(used.texture, place)? else {
            return Ok((INVALID, 1.0));
        };
        let Some(bytes) = self.bytes(image, place)? else {
            return Ok((INVALID, 1.0));
        };
        let format = self.format(image);
        let light = self
            .table
            .insert_light(image.value(), Encoding::Srgb, &bytes, format);
        light.map_err(|message| self.error(image, place, message))
    }

    /// The image of a texture; one without a source that is read here is lost.
    fn image(
        &mut self,
        index: Index<json::Texture>,
        place: &str,
    ) -> Result<Option<Index<json::Image>>, SceneError> {
        let root = self.document.root;
        let texture = root.get(index);
        let texture = texture.ok_or_else(|| self.document.error(place, "no such texture"))?;
        let extensions = texture.extensions.as_ref();
        let webp = extensions
            .and_then(|extensions| extensions.others.get("EXT_texture_webp"))
            .and_then(|webp| webp.get("source")?.as_u64())
            .and_then(|source| u32::try_from(source).ok())
            .map(Index::new);
        let found = [Some(texture.source), webp]
            .into_iter()
            .flatten()
            .find(|source| root.get(*source).is_some());
        if found.is_none() {
            self.lost
                .add(&format!("texture {index}"), "it names no source");
        }
        Ok(found)
    }

    /// The format that a file's name tells.
    fn format(&self, image: Index<json::Image>) -> Option<image::ImageFormat> {
        let image = self.document.root.get(image)?;
        format_of(Path::new(image.uri.as_ref()?))
    }

    /// The bytes of a picture file; one that cannot be read is lost.
    fn bytes(
        &mut self,
        index: Index<json::Image>,
        place: &str,
    ) -> Result<Option<Cow<'a, [u8]>>, SceneError> {
        let wrong = |message: &str| self.error(index, place, message);
        let image = self.document.root.get(index);
        let image = image.ok_or_else(|| wrong("no such image"))?;
        match (image.buffer_view, &image.uri) {
            (Some(view), _) => self
                .document
                .view_bytes(view)
                .map(|bytes| Some(Cow::Borrowed(bytes)))
                .map_err(|message| wrong(&message)),
            (None, Some(uri)) => {
                let place = || format!("{place}, image {index}");
                match read_uri(self.document.path, uri, place) {
                    Ok(bytes) => Ok(Some(bytes.into())),
                    Err(SceneError::Io { source, .. }) => {
                        self.lost.add(uri, source);
                        Ok(None)
                    }
                    Err(error) => Err(error),
                }
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
