//! Materials and their textures as Mitsuba 3's `diffuse` and `principled`.

use crate::ExportError;
use exr::prelude::{Image, SpecificChannels, WritableImage, write_rgb_file};
use glam::Vec3;
use rrf_scene::{Material, MaterialKind, Scene, Texture};
use std::fmt::Write as _;
use std::path::Path;

/// The `<bsdf>` of material `id`, its textures written beside; linear sRGB throughout.
pub(crate) fn bsdf(folder: &Path, scene: &Scene, id: usize) -> Result<String, ExportError> {
    let Some(material) = scene.materials.get(id) else {
        return Ok(String::new());
    };
    let base = base_color(folder, scene, id, material)?;
    let inner = match material.kind {
        MaterialKind::Lambert => format!(
            "<bsdf type=\"diffuse\">\n{}</bsdf>\n",
            base.named("reflectance")
        ),
        MaterialKind::Principled => format!(
            "<bsdf type=\"principled\">\n{}{}{}<float name=\"specular\" value=\"{}\"/>\n</bsdf>\n",
            base.named("base_color"),
            scalar(folder, scene, id, material, Scalar::Roughness)?,
            scalar(folder, scene, id, material, Scalar::Metallic)?,
            material.specular
        ),
    };
    let bent = match texture(scene, material.normal_texture) {
        Some(normals) => {
            let file = format!("textures/m{id}-normal.exr");
            write_rgb(&folder.join(&file), normals, Vec3::ONE)?;
            // normals are numbers, not colours: raw
            format!(
                "<bsdf type=\"normalmap\">\n<texture name=\"normalmap\" type=\"bitmap\">\n\
                 <string name=\"filename\" value=\"{file}\"/>\n\
                 <boolean name=\"raw\" value=\"true\"/>\n</texture>\n{inner}</bsdf>\n"
            )
        }
        None => inner,
    };
    let mut out = String::new();
    // names of the file stand in comments, where "--" may not
    let name: String = (material.name.chars())
        .map(|c| if c.is_alphanumeric() { c } else { '_' })
        .collect();
    let _ = write!(
        out,
        "<!-- {name} -->\n<bsdf type=\"twosided\" id=\"m{id}\">\n{bent}</bsdf>\n"
    );
    Ok(out)
}

enum Colour {
    Constant(Vec3),
    File(String),
}

impl Colour {
    fn named(&self, name: &str) -> String {
        match self {
            Colour::Constant(c) => rgb(name, *c),
            Colour::File(file) => bitmap(name, file, false),
        }
    }
}

/// The constant times the texture, as one picture.
fn base_color(
    folder: &Path,
    scene: &Scene,
    id: usize,
    material: &Material,
) -> Result<Colour, ExportError> {
    let Some(picture) = texture(scene, material.base_texture) else {
        return Ok(Colour::Constant(material.base_color));
    };
    let file = format!("textures/m{id}-base.exr");
    write_rgb(&folder.join(&file), picture, material.base_color)?;
    Ok(Colour::File(file))
}

enum Scalar {
    Roughness,
    Metallic,
}

fn scalar(
    folder: &Path,
    scene: &Scene,
    id: usize,
    material: &Material,
    which: Scalar,
) -> Result<String, ExportError> {
    let (name, constant, channel) = match which {
        Scalar::Roughness => ("roughness", material.roughness, 1),
        Scalar::Metallic => ("metallic", material.metallic, 2),
    };
    let Some(picture) = texture(scene, material.roughness_metallic_texture) else {
        return Ok(format!("<float name=\"{name}\" value=\"{constant}\"/>\n"));
    };
    let file = format!("textures/m{id}-{name}.exr");
    write_one(&folder.join(&file), picture, channel, constant)?;
    Ok(bitmap(name, &file, true))
}

/// `<rgb>` with values as they are.
pub(crate) fn rgb(name: &str, c: Vec3) -> String {
    format!(
        "<rgb name=\"{name}\" value=\"{}, {}, {}\"/>\n",
        c.x, c.y, c.z
    )
}

fn bitmap(name: &str, file: &str, raw: bool) -> String {
    format!(
        "<texture name=\"{name}\" type=\"bitmap\">\n<string name=\"filename\" value=\"{file}\"/>\n\
         <boolean name=\"raw\" value=\"{raw}\"/>\n</texture>\n"
    )
}

fn texture(scene: &Scene, id: u32) -> Option<&Texture> {
    scene.textures.get(id as usize)
}

fn write_rgb(path: &Path, picture: &Texture, factor: Vec3) -> Result<(), ExportError> {
    let (width, height) = (picture.width as usize, picture.height as usize);
    let texel = |x: usize, y: usize| {
        let texel = picture.texels.get(y * width + x).copied();
        let c = texel.unwrap_or_default() * factor;
        (c.x, c.y, c.z)
    };
    write_rgb_file(path, width, height, texel).map_err(|e| ExportError::write(path, e))
}

fn write_one(
    path: &Path,
    picture: &Texture,
    channel: usize,
    factor: f32,
) -> Result<(), ExportError> {
    let (width, height) = (picture.width as usize, picture.height as usize);
    let texel = |at: exr::prelude::Vec2<usize>| {
        let texel = picture.texels.get(at.y() * width + at.x()).copied();
        (texel.unwrap_or_default()[channel] * factor,)
    };
    let channels = SpecificChannels::build()
        .with_channel("Y")
        .with_pixel_fn(texel);
    Image::from_channels((width, height), channels)
        .write()
        .to_file(path)
        .map_err(|e| ExportError::write(path, e))
}
