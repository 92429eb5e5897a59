//! Textures: constants and pictures, and what is made of them.

use super::colour::COLOUR;
use super::fault::{Place, Read, fault};
use super::param::Type;
use super::params::Params;
use super::reader::Reader;
use super::state::Version;
use super::token::Tokens;
use super::value::{Mapping, Value};
use crate::texture::{Encoding, format_of};
use glam::{DVec2, DVec3, Vec3};

impl Reader {
    /// `Texture "name" "type" "class" parameters`.
    pub fn texture_directive(
        &mut self,
        name: String,
        tokens: &mut Tokens<'_>,
        place: Place,
    ) -> Read<()> {
        let (value_type, at) = tokens.string("float or spectrum")?;
        let (class, class_at) = tokens.string("a texture's class")?;
        let mut params = Params::read(tokens, place, format!("Texture \"{class}\""))?;
        self.add_defaults("Texture", &mut params);
        let is_colour = value_type != "float";
        let value = self.texture_value(&class, class_at, &params, is_colour)?;
        match value_type.as_str() {
            "float" => self.float_textures.insert(name, value),
            "spectrum" | "color" => self.spectrum_textures.insert(name, value),
            _ => {
                return fault(
                    at,
                    format!("a texture is of float or spectrum, not \"{value_type}\""),
                );
            }
        };
        Ok(())
    }

    fn texture_value(
        &mut self,
        class: &str,
        at: Place,
        params: &Params,
        is_colour: bool,
    ) -> Read<Value> {
        let value = match class {
            "constant" => self.value_or(params, "value", 1.0)?,
            "imagemap" => self.imagemap(params, is_colour)?,
            "scale" => {
                let old = params.has("tex1") || params.has("tex2");
                let (a, b) = if old {
                    ("tex1", "tex2")
                } else {
                    ("tex", "scale")
                };
                let (a, b) = (
                    self.value_or(params, a, 1.0)?,
                    self.value_or(params, b, 1.0)?,
                );
                self.product(a, b, params.place)
            }
            "mix" => {
                let (a, b) = (
                    self.value_or(params, "tex1", 0.0)?,
                    self.value_or(params, "tex2", 1.0)?,
                );
                let amount = self.value_or(params, "amount", 0.5)?;
                self.mixed(a, b, amount, params.place)
            }
            "checkerboard" => {
                let (a, b) = (
                    self.value_or(params, "tex1", 1.0)?,
                    self.value_or(params, "tex2", 0.0)?,
                );
                let mean = (self.mean(a) + self.mean(b)) / 2.0;
                params.ignore(&[
                    "dimension",
                    "aamode",
                    "mapping",
                    "uscale",
                    "vscale",
                    "udelta",
                    "vdelta",
                    "v1",
                    "v2",
                ]);
                self.approximated(params, "the mean of its two colours");
                Value::Constant(mean)
            }
            "dots" => {
                let outside = self.value_or(params, "outside", 0.0)?;
                self.approximated(params, "its outside");
                return Ok(Value::Constant(self.mean(outside)));
            }
            "bilerp" | "directionmix" | "fbm" | "marble" | "ptex" | "uv" | "windy" | "wrinkled" => {
                self.approximated(params, "a constant 0.5");
                return Ok(Value::grey(0.5));
            }
            _ => return fault(at, format!("unknown texture class \"{class}\"")),
        };
        self.check_unused(params)?;
        Ok(value)
    }

    fn approximated(&mut self, params: &Params, by: &str) {
        self.warn(
            params.place,
            format!("{} is approximated by {by}", params.owner),
        );
    }

    fn imagemap(&mut self, params: &Params, is_colour: bool) -> Read<Value> {
        params.ignore(&["filter", "maxanisotropy", "trilinear"]);
        let Some(name) = params.string("filename")? else {
            return fault(
                params.place,
                format!("{} needs a \"filename\"", params.owner),
            );
        };
        let encoding = self.encoding(params)?;
        let invert = params.bool("invert")?.unwrap_or(false);
        let at = super::colour::place_of(params, "filename");
        let id = self.picture(name, at, encoding, invert)?;
        let scale = DVec3::splat(params.float("scale")?.unwrap_or(1.0));
        match params.string("wrap")? {
            None | Some("repeat") => {}
            Some(wrap) => {
                let wrap = wrap.to_owned();
                self.warn(
                    params.place,
                    format!("wrap \"{wrap}\" is read as \"repeat\""),
                );
            }
        }
        let value = |name: &str, default: f64| Ok(params.float(name)?.unwrap_or(default));
        let map = Mapping {
            scale: DVec2::new(value("uscale", 1.0)?, value("vscale", 1.0)?),
            offset: DVec2::new(value("udelta", 0.0)?, value("vdelta", 0.0)?),
        };
        let mapping = params.string("mapping")?;
        let Some(id) = id else {
            params.ignore(&["v1", "v2"]);
            // A number is a part of something, as opacity and roughness are: all of it.
            let lost = if is_colour { self.lost_albedo } else { 1.0 };
            return Ok(Value::Constant(scale * f64::from(lost)));
        };
        let picture = Value::Picture { id, scale, map };
        match mapping {
            None | Some("uv") => Ok(picture),
            Some(mapping) => {
                params.ignore(&["v1", "v2"]);
                let message = format!(
                    "a picture with mapping \"{mapping}\" is approximated by its mean colour"
                );
                self.warn(params.place, message);
                Ok(Value::Constant(self.mean(picture)))
            }
        }
    }

    /// Version 4's `encoding`, version 3's `gamma`, or the file format's own.
    fn encoding(&mut self, params: &Params) -> Read<Encoding> {
        if let Some(gamma) = params.bool("gamma")? {
            self.sees(Version::V3);
            return Ok(if gamma {
                Encoding::Srgb
            } else {
                Encoding::Linear
            });
        }
        let Some(name) = params.string("encoding")? else {
            return Ok(Encoding::Natural);
        };
        let gamma = name
            .strip_prefix("gamma ")
            .and_then(|g| g.trim().parse::<f64>().ok());
        match (name, gamma) {
            ("sRGB", _) => Ok(Encoding::Srgb),
            ("linear", _) => Ok(Encoding::Linear),
            (_, Some(gamma)) if gamma > 0.0 && gamma.is_finite() => {
                Ok(Encoding::Gamma((gamma as f32).to_bits()))
            }
            _ => fault(params.place, format!("unknown encoding \"{name}\"")),
        }
    }

    /// A picture that a material uses for something else than colour, linear; `None` if it is
    /// lost.
    pub fn linear_picture(&mut self, name: &str, place: Place) -> Read<Option<u32>> {
        self.picture(name, place, Encoding::Linear, false)
    }

    /// The texture of a picture that shines, at most 1, and the factor that it lost; `None` if it
    /// is lost.
    pub fn shining_picture(&mut self, name: &str, place: Place) -> Read<Option<(u32, f32)>> {
        if self.lost.has(name) {
            return Ok(None);
        }
        let path = self.beside(name, place);
        let bytes = match crate::file::read(&path) {
            Ok(bytes) => bytes,
            Err(reason) => {
                self.lost.add(name, reason);
                return Ok(None);
            }
        };
        let (key, format) = ((path.clone(), false), format_of(&path));
        let added = self
            .pictures
            .insert_light(key, Encoding::Natural, &bytes, format);
        added.map(Some).or_else(|reason| {
            fault(
                place,
                format!("{} cannot be read: {reason}", path.display()),
            )
        })
    }

    /// The texture of a picture file, or `None` if there is none; the same file read the same
    /// way is read once.
    fn picture(
        &mut self,
        name: &str,
        place: Place,
        encoding: Encoding,
        invert: bool,
    ) -> Read<Option<u32>> {
        if self.lost.has(name) {
            return Ok(None);
        }
        let path = self.beside(name, place);
        if let Some(id) = self.pictures.get((path.clone(), invert), encoding) {
            return Ok(Some(id));
        }
        let map = |texel| if invert { Vec3::ONE - texel } else { texel };
        let key = (path.clone(), invert);
        let bytes = match crate::file::read(&path) {
            Ok(bytes) => bytes,
            Err(reason) => {
                self.lost.add(name, reason);
                return Ok(None);
            }
        };
        let format = format_of(&path);
        let added = self.pictures.insert(key, encoding, &bytes, format, map);
        added.map(Some).or_else(|reason| {
            fault(
                place,
                format!("{} cannot be read: {reason}", path.display()),
            )
        })
    }

    /// A colour, number or texture, or a grey default.
    pub fn value_or(&mut self, params: &Params, name: &str, default: f64) -> Read<Value> {
        Ok(self.value(params, name)?.unwrap_or(Value::grey(default)))
    }

    /// A colour, number or texture.
    pub fn value(&mut self, params: &Params, name: &str) -> Read<Option<Value>> {
        let mut kinds = vec![Type::Texture, Type::Float];
        kinds.extend(COLOUR);
        let Some(param) = params.find(name, &kinds)? else {
            return Ok(None);
        };
        match param.kind {
            Type::Float => Ok(params.float(name)?.map(Value::grey)),
            Type::Texture => {
                let texture = param.string()?;
                let known = self
                    .spectrum_textures
                    .get(texture)
                    .or_else(|| self.float_textures.get(texture));
                match known {
                    Some(&value) => Ok(Some(value)),
                    None => fault(param.place, format!("no texture \"{texture}\" is known")),
                }
            }
            _ => Ok(self.reflectance(params, name)?.map(Value::Constant)),
        }
    }

    /// A number or float texture; of a picture, the mean with a warning.
    pub fn float_texture(&mut self, params: &Params, name: &str) -> Read<Option<f64>> {
        let Some(param) = params.find(name, &[Type::Float, Type::Texture])? else {
            return Ok(None);
        };
        if param.kind == Type::Float {
            return params.float(name);
        }
        let texture = param.string()?;
        let Some(&value) = self.float_textures.get(texture) else {
            return fault(
                param.place,
                format!("no float texture \"{texture}\" is known"),
            );
        };
        if let Value::Picture { .. } = value {
            self.warn(
                param.place,
                format!("the picture for \"{name}\" is approximated by its mean"),
            );
        }
        let mean = self.mean(value);
        Ok(Some((mean.x + mean.y + mean.z) / 3.0))
    }

    /// The mean over the texture.
    pub fn mean(&self, value: Value) -> DVec3 {
        match value {
            Value::Constant(colour) => colour,
            Value::Picture { id, scale, .. } => self.pictures.mean_of(id) * scale,
        }
    }

    fn product(&mut self, a: Value, b: Value, place: Place) -> Value {
        match (a, b) {
            (Value::Constant(a), Value::Constant(b)) => Value::Constant(a * b),
            (Value::Picture { id, scale, map }, Value::Constant(c))
            | (Value::Constant(c), Value::Picture { id, scale, map }) => Value::Picture {
                id,
                scale: scale * c,
                map,
            },
            (Value::Picture { id, scale, map }, _) => {
                self.warn(place, "a product of two pictures is approximated by the first times the mean of the second");
                let scale = scale * self.mean(b);
                Value::Picture { id, scale, map }
            }
        }
    }

    fn mixed(&mut self, a: Value, b: Value, amount: Value, place: Place) -> Value {
        if a == b {
            return a;
        }
        if !matches!(
            (a, b, amount),
            (Value::Constant(_), Value::Constant(_), Value::Constant(_))
        ) {
            self.warn(
                place,
                "a mix of pictures is approximated by its mean colour",
            );
        }
        let t = self.mean(amount);
        Value::Constant(self.mean(a) * (DVec3::ONE - t) + self.mean(b) * t)
    }
}
