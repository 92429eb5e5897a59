//! Colours and spectra of parameters as linear sRGB.

use super::fault::{Place, Read, fault};
use super::metal::{Index, glass, named};
use super::param::{Param, Type, Values};
use super::params::Params;
use super::reader::Reader;
use super::spectrum::{
    Spectrum, blackbody, emission, emission_of_unit_luminance, illuminant, reflectance, xyz_to_rgb,
};
use super::state::Version;
use glam::DVec3;

/// The types that a colour may have.
pub(super) const COLOUR: [Type; 4] = [Type::Rgb, Type::Xyz, Type::Spectrum, Type::Blackbody];

impl Reader {
    /// A reflectance, as linear sRGB. A spectrum is seen under D65, so that a constant one
    /// stays grey (pbrt version 3 shows it slightly red).
    pub fn reflectance(&mut self, params: &Params, name: &str) -> Read<Option<DVec3>> {
        let Some(param) = params.find(name, &COLOUR)? else {
            return Ok(None);
        };
        Ok(Some(match param.kind {
            Type::Spectrum => match self.spectrum(param)? {
                Index::Sampled(spectrum) => reflectance(|lambda| spectrum.at(lambda)),
                Index::Rgb(rgb) => rgb,
            },
            Type::Blackbody => {
                return fault(
                    param.place,
                    format!("\"{name}\" is a reflectance, which no black body gives"),
                );
            }
            _ => triple(param)?,
        }))
    }

    /// An emission, as linear sRGB. Version 3: as the spectrum says. Version 4: a spectrum's
    /// colour at Y = 1, since `scale` and `power` say there how bright it is; `rgb` as it is.
    pub fn emitted(&mut self, params: &Params, name: &str) -> Read<Option<DVec3>> {
        let Some(param) = params.find(name, &COLOUR)? else {
            return Ok(None);
        };
        let rgb = match param.kind {
            Type::Blackbody => self.emitted_by_blackbody(param)?,
            Type::Spectrum => self.emitted_spectrum(param)?,
            _ => triple(param)?,
        };
        if rgb.min_element() < 0.0 {
            self.warn(
                param.place,
                format!("\"{name}\" lies outside sRGB: negative channels are set to 0"),
            );
        }
        Ok(Some(rgb.max(DVec3::ZERO)))
    }

    /// `[T]` has Y = 1 (version 4); `[T scale]` has the scale as its peak (version 3).
    fn emitted_by_blackbody(&mut self, param: &Param) -> Read<DVec3> {
        let (temperature, scale) = match *param.numbers()? {
            [temperature] => (temperature, None),
            [temperature, scale] => (temperature, Some(scale)),
            _ => {
                return fault(
                    param.place,
                    format!("\"{}\" needs a temperature in kelvin", param.name),
                );
            }
        };
        if !(500.0..=1e6).contains(&temperature) {
            return fault(
                param.place,
                format!("{temperature} K is no temperature of a lamp (500 to 1000000)"),
            );
        }
        let planck = blackbody(temperature);
        match scale {
            Some(scale) => {
                self.sees(Version::V3);
                Ok(emission(planck) * scale)
            }
            None => Ok(emission_of_unit_luminance(planck).unwrap_or(DVec3::ONE)),
        }
    }

    fn emitted_spectrum(&mut self, param: &Param) -> Read<DVec3> {
        if let Values::Strings(_) = param.values
            && let Some(rgb) = illuminant(param.string()?)
        {
            return Ok(rgb);
        }
        let spectrum = match self.spectrum(param)? {
            Index::Sampled(spectrum) => spectrum,
            Index::Rgb(_) => {
                return fault(
                    param.place,
                    format!("\"{}\" names no light source", param.name),
                );
            }
        };
        if self.version() == Version::V3 {
            return Ok(emission(|lambda| spectrum.at(lambda)));
        }
        match emission_of_unit_luminance(|lambda| spectrum.at(lambda)) {
            Some(rgb) => Ok(rgb),
            None => fault(
                param.place,
                format!("\"{}\" has no visible light", param.name),
            ),
        }
    }

    /// A spectrum given by pairs, by the name of a metal's index, or by a file.
    fn spectrum(&mut self, param: &Param) -> Read<Index> {
        let found = match &param.values {
            Values::Numbers(pairs) => Spectrum::from_pairs(pairs),
            _ => {
                let name = param.string()?;
                if let Some(index) = named(name) {
                    return Ok(index);
                }
                let path = self.beside(name, param.place);
                match self.text_file(&path) {
                    Ok(text) => {
                        Spectrum::from_text(&text).map_err(|e| format!("{}: {e}", path.display()))
                    }
                    Err(error) => Err(format!(
                        "\"{name}\" is no spectrum known here and no file: {}: {error}",
                        path.display()
                    )),
                }
            }
        };
        match found {
            Ok(spectrum) => Ok(Index::Sampled(spectrum)),
            Err(message) => fault(param.place, message),
        }
    }

    /// A part of a metal's index of refraction, in any form.
    pub fn index(&mut self, params: &Params, name: &str) -> Read<Option<Index>> {
        match params.find(name, &[Type::Rgb, Type::Xyz, Type::Spectrum, Type::Float])? {
            None => Ok(None),
            Some(param) if param.kind == Type::Spectrum => self.spectrum(param).map(Some),
            Some(param) if param.kind == Type::Float => match *param.numbers()? {
                [value] => Ok(Some(Index::Rgb(DVec3::splat(value)))),
                _ => fault(param.place, format!("\"{name}\" needs one number")),
            },
            Some(param) => Ok(Some(Index::Rgb(triple(param)?))),
        }
    }

    /// A dielectric's index of refraction: a number, a named glass, or a spectrum, of which
    /// the value at 587.6 nm counts.
    pub fn dielectric_index(&mut self, params: &Params, name: &str) -> Read<Option<f64>> {
        let kinds = [Type::Float, Type::Spectrum, Type::Texture];
        let Some(param) = params.find(name, &kinds)? else {
            return Ok(None);
        };
        let eta = match (&param.values, param.kind) {
            (_, Type::Texture) => return self.float_texture(params, name),
            (Values::Strings(_), _) if glass(param.string()?).is_some() => glass(param.string()?),
            (_, Type::Spectrum) => match self.spectrum(param)? {
                Index::Sampled(spectrum) => Some(spectrum.at(587.6)),
                Index::Rgb(rgb) => Some(rgb.y),
            },
            _ => params.float(name)?,
        };
        match eta {
            Some(eta) if (0.25..=4.0).contains(&eta) => Ok(Some(eta)),
            Some(eta) => fault(
                param.place,
                format!("an index of refraction of {eta} is outside what is read here (0.25 to 4)"),
            ),
            None => Ok(None),
        }
    }
}

/// Three numbers as linear sRGB.
fn triple(param: &Param) -> Read<DVec3> {
    let [a, b, c] = *param.numbers()? else {
        return fault(
            param.place,
            format!("\"{}\" needs three numbers", param.name),
        );
    };
    let value = DVec3::new(a, b, c);
    Ok(if param.kind == Type::Xyz {
        xyz_to_rgb(value)
    } else {
        value
    })
}

/// The place of a parameter, or of its directive.
pub(super) fn place_of(params: &Params, name: &str) -> Place {
    params.place_of(name).unwrap_or(params.place)
}
