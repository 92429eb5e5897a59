//! The sky, and points of light whose brightness depends on the direction by a picture.

use super::colour::place_of;
use super::fault::{Place, Read, fault};
use super::light::positive;
use super::params::Params;
use super::reader::Reader;
use super::spectrum::luminance;
use super::state::Version;
use super::transform::orthogonal;
use crate::texture::linear_picture;
use glam::{DMat3, DVec3, Vec3};
use rrf_lights::{
    Environment, EnvironmentMap, GoniometricLight, IesProfile, LightKind, Mapping, PointLight,
    Portal, Profile,
};
use std::f64::consts::PI;
use std::path::{Path, PathBuf};

/// Directions as version 3 maps them, polar axis z and azimuth from x towards y, to those of
/// [`Mapping::LatLong`], polar axis y and azimuth from -z towards x. It mirrors.
const LATLONG_OF_Z_UP: DMat3 = DMat3::from_cols(DVec3::NEG_Z, DVec3::X, DVec3::Y);

/// y and z change places: a goniometric picture's pole is the light's +y.
const SWAP_YZ: DMat3 = DMat3::from_cols(DVec3::X, DVec3::Z, DVec3::Y);

/// The frame of an IES profile in the light's: aimed along -y, as pbrt's goniometric lights have y
/// for their axis; horizontal angles from +x, counter-clockwise seen from above.
const IES_FRAME: DMat3 = DMat3::from_cols(DVec3::X, DVec3::NEG_Z, DVec3::NEG_Y);

impl Reader {
    /// Radiance `L * scale` [W/(sr m²)], or a picture's times that. Version 4's `illuminance` is
    /// the irradiance of a plane that faces the light's own +z.
    ///
    /// (pbrt itself makes a picture with `illuminance` twice as bright: its sum over the upper
    /// half of the texels has half of their solid angle.)
    pub fn infinite_light(&mut self, params: &Params) -> Read<()> {
        let given = self.emitted(params, "L")?;
        let scale = self.light_scale(params)?;
        let portals = self.portals(params)?;
        let illuminance = positive(params, "illuminance")?;
        let mut radiance = given.unwrap_or(DVec3::ONE) * scale;
        let file = self.picture_of(params)?;
        let mut map = None;
        if let Some((path, place)) = file {
            if given.is_some() && self.version() == Version::V4 {
                return fault(place, "a light has \"L\" or a picture, not both");
            }
            map = self.sky_map(&path, place)?;
            if map.is_none() && self.replaces_sky {
                return self.check_unused(params);
            }
        }
        if let Some(wanted) = illuminance {
            let found = match &map {
                Some(map) => self.facing_z(map),
                None => PI,
            };
            if found <= 0.0 {
                return fault(
                    params.place,
                    "the picture is black: no illuminance makes it shine",
                );
            }
            radiance *= wanted / found;
        }
        let light = Environment {
            radiance: radiance.as_vec3(),
            map,
            portals,
        };
        self.add_light(params, light.into())
    }

    /// Irradiance (its luminance) that a plane gets from a map above its light's +z.
    fn facing_z(&self, map: &EnvironmentMap) -> f64 {
        let up = self.state.ctm.transform_vector3(DVec3::Z);
        let up = up.normalize_or_zero().as_vec3();
        let sum = map.integral(|d| f64::from(d.dot(up).max(0.0)));
        luminance(sum.as_dvec3())
    }

    /// Version 4's `portal`: four corners in the world's frame, whatever the current transform.
    fn portals(&mut self, params: &Params) -> Read<Vec<Portal>> {
        let Some(corners) = params.triples("portal")? else {
            return Ok(Vec::new());
        };
        let place = place_of(params, "portal");
        let corners: Result<[DVec3; 4], _> = corners.try_into();
        let portal = corners.map(|c| Portal::new(c.map(|p| p.as_vec3())));
        match portal {
            Ok(Ok(portal)) => {
                self.warn(
                    place,
                    "the portal guides samples and hides nothing; in pbrt the sky shines through \
                     it alone",
                );
                Ok(vec![portal])
            }
            Ok(Err(error)) => fault(place, error.to_string()),
            Err(found) => fault(place, format!("{} corners: a portal has four", found.len())),
        }
    }

    /// The file that a light names, `filename` in version 4 and `mapname` in version 3.
    fn picture_of(&mut self, params: &Params) -> Read<Option<(PathBuf, Place)>> {
        for (name, version) in [("mapname", Version::V3), ("filename", Version::V4)] {
            if let Some(file) = params.string(name)?.filter(|file| !file.is_empty()) {
                self.sees(version);
                let place = place_of(params, name);
                return Ok(Some((self.beside(file, place), place)));
            }
        }
        Ok(None)
    }

    /// The sky of a picture: equal-area in version 4, lat-long in version 3. One that is not there
    /// leaves a sky without a picture, as in version 3, with a warning.
    fn sky_map(&mut self, path: &Path, place: Place) -> Read<Option<EnvironmentMap>> {
        if !path.exists() {
            let file = path.display();
            let message = match self.replaces_sky {
                true => format!("{file} is not there: --sky takes its place"),
                false => format!(
                    "{file} is not there: the sky is constant in its place; put the file there, \
                     or give --sky"
                ),
            };
            self.warn(place, message);
            return Ok(None);
        }
        self.directions(path, place, DMat3::IDENTITY).map(Some)
    }

    /// A picture over the directions of the light's frame, after `turned`.
    fn directions(&mut self, path: &Path, place: Place, turned: DMat3) -> Read<EnvironmentMap> {
        let refuse = |message: String| fault(place, format!("{}: {message}", path.display()));
        let picture = match linear_picture(path) {
            Ok(picture) => picture,
            Err(message) => return refuse(message),
        };
        let to_light = self.light_frame(place)?;
        let (mapping, to_map) = match self.version() {
            Version::V3 => (Mapping::LatLong, LATLONG_OF_Z_UP * turned * to_light),
            Version::V4 => (Mapping::Octahedral, turned * to_light),
        };
        let size = (picture.width, picture.height);
        let mut texels = picture.texels;
        if turned != DMat3::IDENTITY && self.version() == Version::V4 {
            // a goniometric picture has one channel in version 4, the mean
            let mean = |t: &mut Vec3| *t = Vec3::splat(t.element_sum() / 3.0);
            texels.iter_mut().for_each(mean);
        }
        EnvironmentMap::new(size, texels, mapping, to_map.as_mat3())
            .or_else(|error| refuse(error.to_string()))
    }

    /// World directions to the light's frame.
    fn light_frame(&mut self, place: Place) -> Read<DMat3> {
        self.note_stretch(place, "its picture is turned only");
        match orthogonal(&self.state.ctm) {
            Some((rotation, _)) => Ok(rotation.transpose()),
            None => fault(place, "the transform flattens this light's directions"),
        }
    }

    /// Radiant intensity `I * scale` [W/sr] times a picture, or times the candela of an IES
    /// profile (`.ies`, which pbrt itself does not read); version 4's `power` in all.
    pub fn goniometric_light(&mut self, params: &Params) -> Read<()> {
        let mut intensity = self.light_colour(params, "I")?;
        let position = self.state.ctm.transform_point3(DVec3::ZERO).as_vec3();
        let power = positive(params, "power")?;
        let Some((path, place)) = self.picture_of(params)? else {
            self.warn(
                params.place,
                "a goniometric light without a picture is a point",
            );
            intensity *= power.map_or(1.0, |power| power / (4.0 * PI));
            let intensity = intensity.as_vec3();
            let light = PointLight {
                position,
                intensity,
            };
            return self.add_light(params, light.into());
        };
        let profile = match path.extension() {
            Some(ending) if ending.eq_ignore_ascii_case("ies") => self.ies(&path, place)?,
            _ => Profile::Picture(self.directions(&path, place, SWAP_YZ)?),
        };
        let mut light = GoniometricLight {
            position,
            intensity: Vec3::ONE,
            profile,
        };
        if let Some(power) = power {
            let all = light.power(0.0).as_dvec3().element_sum() / 3.0;
            if all <= 0.0 {
                return fault(place, "the profile is black: no power makes it shine");
            }
            intensity *= power / all;
        }
        light.intensity = intensity.as_vec3();
        self.add_light(params, light.into())
    }

    fn ies(&mut self, path: &Path, place: Place) -> Read<Profile> {
        let read = self.bytes(path).map_err(|error| error.to_string());
        let table = read
            .and_then(|bytes| IesProfile::from_bytes(&bytes).map_err(|error| error.to_string()));
        let to_table = IES_FRAME.transpose() * self.light_frame(place)?;
        match table {
            Ok(table) => Ok(Profile::Ies(table, to_table.as_mat3())),
            Err(message) => fault(place, format!("{}: {message}", path.display())),
        }
    }
}
