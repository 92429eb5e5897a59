//! Materials and their textures as Mitsuba 3's plugins.

use crate::ExportError;
use crate::error::write_file;
use exr::prelude::{Image, SpecificChannels, WritableImage};
use glam::Vec3;
use rrf_lights::Panorama;
use rrf_materials::{SlotValue, Texture};
use rrf_scene::Scene;
use std::fmt::Write as _;
use std::io::Cursor;
use std::path::Path;

/// The `<bsdf>` of material `id`, its textures written beside; linear sRGB throughout.
pub(crate) fn bsdf(folder: &Path, scene: &Scene, id: usize) -> Result<String, ExportError> {
    let Some(material) = scene.materials.get(id) else {
        return Ok(String::new());
    };
    let mut inner = format!("<bsdf type=\"{}\">\n", material.kind.mitsuba);
    for parameter in material.parameters() {
        inner += &slot(folder, scene, id, &parameter)?;
    }
    inner += "</bsdf>\n";
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
    // what light passes has two sides already; a mask of opacity 1 only gives it its name
    let outer = if material.kind.transmits {
        "mask"
    } else {
        "twosided"
    };
    let _ = write!(
        out,
        "<!-- {name} -->\n<bsdf type=\"{outer}\" id=\"m{id}\">\n{}{bent}</bsdf>\n",
        match outer {
            "mask" => "<float name=\"opacity\" value=\"1\"/>\n",
            _ => "",
        }
    );
    Ok(out)
}

/// One parameter: its constant, or constant times texture as one picture.
fn slot(
    folder: &Path,
    scene: &Scene,
    id: usize,
    parameter: &SlotValue,
) -> Result<String, ExportError> {
    let (name, value) = (parameter.slot.mitsuba, parameter.value);
    let is_colour = parameter.width == 3;
    match name {
        // Mitsuba has no such parameter
        "" => return Ok(String::new()),
        // our roughness is the square root of GGX's alpha; a texture of it counts by its factor
        "alpha" => {
            let alpha = (value.x * value.x).max(0.001);
            return Ok(format!(
                "<string name=\"distribution\" value=\"ggx\"/>\n<float name=\"alpha\" value=\"{alpha}\"/>\n"
            ));
        }
        "int_ior" => {
            let ior = value.x;
            return Ok(format!(
                "<float name=\"int_ior\" value=\"{ior}\"/>\n<float name=\"ext_ior\" value=\"1\"/>\n"
            ));
        }
        "nonlinear" => {
            let is_so = value.x > 0.5;
            return Ok(format!("<boolean name=\"nonlinear\" value=\"{is_so}\"/>\n"));
        }
        _ => {}
    }
    let Some(picture) = texture(scene, parameter.texture) else {
        return Ok(if is_colour {
            rgb(name, value)
        } else {
            format!("<float name=\"{name}\" value=\"{}\"/>\n", value.x)
        });
    };
    let file = format!("textures/m{id}-{name}.exr");
    let path = folder.join(&file);
    if is_colour {
        write_rgb(&path, picture, value)?;
    } else {
        write_one(&path, picture, parameter.channel, value.x)?;
    }
    Ok(bitmap(name, &file, !is_colour))
}

/// `<rgb>` with values as they are.
pub(crate) fn rgb(name: &str, c: Vec3) -> String {
    format!(
        "<rgb name=\"{name}\" value=\"{}, {}, {}\"/>\n",
        c.x, c.y, c.z
    )
}

pub(crate) fn bitmap(name: &str, file: &str, raw: bool) -> String {
    format!(
        "<texture name=\"{name}\" type=\"bitmap\">\n<string name=\"filename\" value=\"{file}\"/>\n\
         <boolean name=\"raw\" value=\"{raw}\"/>\n</texture>\n"
    )
}

fn texture(scene: &Scene, id: u32) -> Option<&Texture> {
    scene.textures.get(id as usize)
}

/// Writes a panorama as it is.
pub(crate) fn write_texels(path: &Path, picture: &Panorama) -> Result<(), ExportError> {
    let size = (picture.width as usize, picture.height as usize);
    write_colours(path, size, &picture.texels, Vec3::ONE)
}

pub(crate) fn write_rgb(path: &Path, picture: &Texture, factor: Vec3) -> Result<(), ExportError> {
    let size = (picture.width as usize, picture.height as usize);
    write_colours(path, size, &picture.texels, factor)
}

fn write_colours(
    path: &Path,
    size: (usize, usize),
    texels: &[Vec3],
    factor: Vec3,
) -> Result<(), ExportError> {
    let texel = |at: exr::prelude::Vec2<usize>| {
        let texel = texels.get(at.y() * size.0 + at.x()).copied();
        let c = texel.unwrap_or_default() * factor;
        (c.x, c.y, c.z)
    };
    let image = Image::from_channels(size, SpecificChannels::rgb(texel));
    let mut bytes = Cursor::new(Vec::new());
    let written = image.write().to_buffered(&mut bytes);
    written.map_err(|e| ExportError::encode(path, e))?;
    write_file(path, &bytes.into_inner())
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
    let image = Image::from_channels((width, height), channels);
    let mut bytes = Cursor::new(Vec::new());
    let written = image.write().to_buffered(&mut bytes);
    written.map_err(|e| ExportError::encode(path, e))?;
    write_file(path, &bytes.into_inner())
}
