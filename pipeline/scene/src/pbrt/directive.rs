//! One directive after another.

use super::fault::{Place, Read, fault};
use super::params::Params;
use super::reader::{Phase, Reader};
use super::state::{Block, Surface, Version};
use super::token::{Kind, Tokens};
use super::transform::{is_affine, look_at, rotate};
use glam::{DMat4, DVec3};

/// When a directive may stand.
fn phase_of(directive: &str) -> Option<Phase> {
    Some(match directive {
        "Camera" | "Film" | "Sampler" | "Integrator" | "PixelFilter" | "Accelerator"
        | "TransformTimes" | "Option" => Phase::Options,
        "AttributeBegin" | "AttributeEnd" | "AreaLightSource" | "LightSource" | "Material"
        | "MakeNamedMaterial" | "NamedMaterial" | "ObjectBegin" | "ObjectEnd"
        | "ObjectInstance" | "Shape" | "Texture" | "ReverseOrientation" | "WorldEnd" => {
            Phase::World
        }
        _ => return None,
    })
}

impl Reader {
    /// Follows the next directive; false at the end of the text.
    pub fn directive(&mut self, tokens: &mut Tokens<'_>) -> Read<bool> {
        let Some(token) = tokens.next()? else {
            return Ok(false);
        };
        let place = token.place;
        let Kind::Word(word) = token.kind else {
            return fault(place, format!("expected a directive, found {}", token.kind));
        };
        if self.phase == Phase::Ended {
            self.warn(place, "what follows WorldEnd (another frame) is left out");
            return Ok(false);
        }
        if let Some(needed) = phase_of(word).filter(|&needed| needed != self.phase) {
            let side = if needed == Phase::World {
                "after"
            } else {
                "before"
            };
            return fault(place, format!("{word} must stand {side} WorldBegin"));
        }
        match word {
            "Include" => {
                let (name, _) = tokens.string("a file name")?;
                self.include(&name, place)?;
            }
            "Import" => {
                // Version 4: what the file does to the graphics state ends with it.
                self.sees(Version::V4);
                let (name, _) = tokens.string("a file name")?;
                let before = self.state;
                self.include(&name, place)?;
                self.state = before;
            }
            "WorldBegin" => self.world_begin(place)?,
            "WorldEnd" => {
                self.sees(Version::V3);
                if let Some(open) = self.saved.last() {
                    let name = open.block.name();
                    return fault(open.place, format!("{name}Begin is still open at WorldEnd"));
                }
                self.phase = Phase::Ended;
            }
            _ if self.transform_directive(word, tokens, place)? => {}
            _ if self.block_directive(word, tokens, place)? => {}
            _ => self.declaration(word, tokens, place)?,
        }
        Ok(true)
    }

    fn world_begin(&mut self, place: Place) -> Read<()> {
        if self.phase == Phase::World {
            return fault(place, "WorldBegin stands twice");
        }
        self.phase = Phase::World;
        self.state.ctm = DMat4::IDENTITY;
        self.state.at_end_time = false;
        self.systems.insert("world".to_owned(), DMat4::IDENTITY);
        Ok(())
    }

    /// Directives that change the current transform; false if `word` is none of them.
    fn transform_directive(
        &mut self,
        word: &str,
        tokens: &mut Tokens<'_>,
        place: Place,
    ) -> Read<bool> {
        let ctm = self.state.ctm;
        let changed = match word {
            "Identity" => DMat4::IDENTITY,
            "Translate" => ctm * DMat4::from_translation(DVec3::from_array(tokens.numbers(word)?)),
            "Scale" => ctm * DMat4::from_scale(DVec3::from_array(tokens.numbers(word)?)),
            "Rotate" => {
                let [angle, x, y, z] = tokens.numbers(word)?;
                match rotate(angle, DVec3::new(x, y, z)) {
                    Some(rotation) => ctm * rotation,
                    None => return fault(place, "Rotate has an axis of no length"),
                }
            }
            "LookAt" => {
                let v: [f64; 9] = tokens.numbers(word)?;
                let [eye, target, up] = [0, 3, 6].map(|i| DVec3::new(v[i], v[i + 1], v[i + 2]));
                match look_at(eye, target, up) {
                    Some(view) => ctm * view,
                    None => return fault(place, "LookAt's eye, target and up span no view"),
                }
            }
            "Transform" => DMat4::from_cols_array(&tokens.numbers(word)?),
            "ConcatTransform" => ctm * DMat4::from_cols_array(&tokens.numbers(word)?),
            "CoordinateSystem" => {
                let (name, _) = tokens.string("a name")?;
                self.systems.insert(name, ctm);
                return Ok(true);
            }
            "CoordSysTransform" => {
                let (name, at) = tokens.string("a name")?;
                match self.systems.get(&name) {
                    Some(saved) => *saved,
                    None => return fault(at, format!("no coordinate system \"{name}\" is known")),
                }
            }
            "ActiveTransform" => {
                self.active_transform(tokens)?;
                return Ok(true);
            }
            "TransformTimes" => {
                tokens.numbers::<2>(word)?;
                return Ok(true);
            }
            _ => return Ok(false),
        };
        if !changed.is_finite() {
            return fault(place, "the transform overflows");
        }
        if !is_affine(&changed) {
            return fault(
                place,
                format!("{word} gives a transform with perspective; its last row must be 0 0 0 1"),
            );
        }
        if !self.state.at_end_time {
            self.state.ctm = changed;
        }
        Ok(true)
    }

    fn active_transform(&mut self, tokens: &mut Tokens<'_>) -> Read<()> {
        let token = tokens.require("All, StartTime or EndTime")?;
        self.state.at_end_time = match token.kind {
            Kind::Word("All" | "StartTime") => false,
            Kind::Word("EndTime") => {
                self.warn(
                    token.place,
                    "motion is left out: everything stands where it is at the start time",
                );
                true
            }
            other => {
                return fault(
                    token.place,
                    format!("expected All, StartTime or EndTime, found {other}"),
                );
            }
        };
        Ok(())
    }

    /// Directives that open and close blocks or stand alone; false if `word` is none of them.
    fn block_directive(&mut self, word: &str, tokens: &mut Tokens<'_>, place: Place) -> Read<bool> {
        match word {
            "AttributeBegin" => self.push(Block::Attribute, place)?,
            "AttributeEnd" => self.pop(Block::Attribute, place)?,
            "TransformBegin" => self.push(Block::Transform, place)?,
            "TransformEnd" => self.pop(Block::Transform, place)?,
            "ReverseOrientation" => self.state.reverse = !self.state.reverse,
            "ObjectBegin" => {
                let (name, _) = tokens.string("an object's name")?;
                self.object_begin(name, place)?;
            }
            "ObjectEnd" => self.object_end(place)?,
            "ObjectInstance" => {
                let (name, at) = tokens.string("an object's name")?;
                self.object_instance(&name, at)?;
            }
            "NamedMaterial" => {
                let (name, at) = tokens.string("a material's name")?;
                match self.materials.get(&name) {
                    Some(&surface) => self.state.surface = surface,
                    None => {
                        let message = format!(
                            "no material \"{name}\" is known: the default serves (matte, 0.5), \
                             as in pbrt"
                        );
                        self.warn(at, message);
                        self.state.surface = Surface::Default;
                    }
                }
            }
            "MediumInterface" => self.medium_interface(tokens)?,
            "ColorSpace" => {
                self.sees(Version::V4);
                let (name, at) = tokens.string("a colour space's name")?;
                match name.as_str() {
                    "srgb" => {}
                    "aces2065-1" | "rec2020" | "dci-p3" => {
                        self.warn(at, format!("colours of \"{name}\" are read as linear sRGB"))
                    }
                    _ => return fault(at, format!("unknown colour space \"{name}\"")),
                }
            }
            "Option" => self.option(tokens)?,
            _ => return Ok(false),
        }
        Ok(true)
    }

    /// `Option "type name" value`: settings of pbrt's renderer, none of which changes the light.
    fn option(&mut self, tokens: &mut Tokens<'_>) -> Read<()> {
        self.sees(Version::V4);
        tokens.string("an option's name")?;
        let value = tokens.require("an option's value")?;
        if value.kind == Kind::Open {
            while tokens.require("`]`")?.kind != Kind::Close {}
        }
        Ok(())
    }

    /// Directives of the form `Directive "type" parameters`.
    fn declaration(&mut self, word: &str, tokens: &mut Tokens<'_>, place: Place) -> Read<()> {
        const KNOWN: [&str; 14] = [
            "Camera",
            "Film",
            "Sampler",
            "Integrator",
            "PixelFilter",
            "Accelerator",
            "Material",
            "MakeNamedMaterial",
            "MakeNamedMedium",
            "Texture",
            "Shape",
            "LightSource",
            "AreaLightSource",
            "Attribute",
        ];
        if !KNOWN.contains(&word) {
            return fault(
                place,
                format!("unknown directive `{}`", super::token::shortened(word)),
            );
        }
        let (name, at) = tokens.string(&format!("what {word} is of"))?;
        if word == "Texture" {
            return self.texture_directive(name, tokens, place);
        }
        let owner = format!("{word} \"{}\"", super::token::shortened(&name));
        let mut params = Params::read(tokens, place, owner)?;
        self.add_defaults(word, &mut params);
        match word {
            "Camera" => self.camera(&name, at, &params),
            "Film" => self.film(&name, &params),
            "Integrator" => self.integrator(&name, &params),
            "Sampler" | "PixelFilter" | "Accelerator" => Ok(()),
            "Material" => self.material_directive(&name, at, &params),
            "MakeNamedMaterial" => self.make_named_material(name, at, &params),
            "MakeNamedMedium" => self.make_named_medium(name, &params),
            "Shape" => self.shape(&name, at, &params),
            "LightSource" => self.light_source(&name, at, &params),
            "AreaLightSource" => self.area_light_source(&name, at, &params),
            _ => self.attribute(name, at, params),
        }
    }

    /// pbrt's integrators bound the number of bounces; light here has no bound.
    fn integrator(&mut self, name: &str, params: &Params) -> Read<()> {
        if let Some(depth) = params.integer("maxdepth")? {
            self.warn(
                params.place,
                format!("Integrator \"{name}\" maxdepth {depth} is not followed: light bounces without a limit"),
            );
        }
        Ok(())
    }
}
