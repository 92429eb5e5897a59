//! A scene's own lights and the suns of a page: what it lists, and what its questions switch on.

use crate::ask::{Ask, OwnAsk};
use glam::Vec3;
use rrf_lights::{DistantLight, LightSource, azimuth_elevation, sky_direction};
use rrf_render::{AreaLights, Lights};
use rrf_scene::{OwnLight, PointLight, Scene};
use rrf_trace::Tracer;
use serde_json::{Value, json};

/// The own lights of the scene that a page shows.
#[derive(Clone, Copy)]
pub struct OwnLights<'a> {
    /// The scene with its lights, which frames are traced in where lamps shine.
    pub tracer: &'a Tracer<'a>,
    /// Its lamps, ready for frames.
    pub lamps: &'a AreaLights,
    /// Whether they shine when a page starts.
    pub on: bool,
    /// Whether the model knows each light as it is. Otherwise it knows points, and lamps by points that
    /// stand for them.
    pub known: bool,
}

/// A light as a page's row begins with it.
#[derive(Clone, Copy)]
struct Row {
    /// Colour and strength, and their unit.
    strength: Vec3,
    unit: &'static str,
    position: Option<Vec3>,
    toward: Option<Vec3>,
}

impl<'a> OwnLights<'a> {
    /// The scene.
    pub fn scene(&self) -> &'a Scene {
        self.tracer.scene()
    }

    /// One row a name.
    pub fn rows(&self) -> Vec<Value> {
        let names = self.scene().own_light_names();
        names.into_iter().map(|name| self.row(name)).collect()
    }

    fn row(&self, name: &str) -> Value {
        let source = self.scene().lights.iter().find(|light| light.name == name);
        let (kind, row) = match source {
            Some(light) => (light.source.kind(), of_source(&light.source)),
            None => ("lamp", self.lamp(name)),
        };
        json!({
            "name": name,
            "kind": kind,
            "strength": row.strength.to_array(),
            "unit": row.unit,
            "position": row.position.map(|p| p.to_array()),
            "toward": row.toward.map(azimuth_elevation),
            "shows": self.shows(name, kind),
        })
    }

    fn lamp(&self, name: &str) -> Row {
        let lamps = self.scene().area_lights.iter();
        let mut of_name = lamps.zip(&self.scene().area_light_names);
        let found = of_name.find(|(_, of)| *of == name);
        Row {
            strength: found.map_or(Vec3::ZERO, |(light, _)| light.radiance),
            unit: "W/(sr m²)",
            // points that stand for a lamp are fitted to it where it is
            position: self
                .known
                .then(|| self.scene().middle_of_lamp(name))
                .flatten(),
            toward: None,
        }
    }

    /// Which part of a light's light frames have, in words.
    fn shows(&self, name: &str, kind: &str) -> String {
        if self.known || kind == "point" {
            return "direct and indirect light".into();
        }
        if kind != "lamp" {
            return "direct light only: these nets know points".into();
        }
        let lamps = self
            .scene()
            .area_light_names
            .iter()
            .zip(&self.lamps.proxies);
        let proxies = lamps.filter(|(of, _)| *of == name);
        let worst = proxies.map(|(_, proxy)| proxy.error).fold(0.0, f64::max);
        format!(
            "direct light; indirect by points that stand for it, {:.0} % off",
            100.0 * worst
        )
    }

    /// The lamps that a question moves, and where to.
    pub fn moved_lamps<'q>(&self, ask: &'q Ask) -> Vec<(&'q str, Vec3)> {
        let is_lamp = |own: &&OwnAsk| self.scene().area_light_names.contains(&own.name);
        let lamps = ask.own.iter().filter(is_lamp);
        let places = lamps.filter_map(|own| Some((own.name.as_str(), Vec3::from(own.position?))));
        places.collect()
    }

    /// The lights that a question switches on in the order of `rrf render`'s, its typed ones last; lamps
    /// stand where this scene has them.
    ///
    /// # Errors
    /// If a light has no such name or cannot be moved.
    pub fn lights(&self, ask: &Ask) -> Result<Lights, String> {
        let mut lights = Lights::default();
        let mut dims = vec![Vec3::ZERO; self.scene().area_lights.len()];
        for own in &ask.own {
            let (mut found, factor) = (false, Vec3::from(own.dim));
            for light in self.scene().lights.iter().filter(|l| l.name == own.name) {
                found = true;
                match changed(light, own)? {
                    LightSource::Point(point) => lights.points.push(point),
                    source => lights.sources.push(OwnLight {
                        name: own.name.clone(),
                        source,
                    }),
                }
            }
            let names = dims.iter_mut().zip(&self.scene().area_light_names);
            for (dim, _) in names.filter(|(_, name)| **name == own.name) {
                (found, *dim) = (true, factor);
            }
            if !found {
                let known = self.scene().own_lights_in_words();
                return Err(format!("there is no own light {:?}; {known}", own.name));
            }
        }
        lights.points.extend(ask.points());
        lights.sources.extend(ask.suns());
        lights.area = dims.iter().any(|dim| *dim != Vec3::ZERO);
        lights.dims = if lights.area { dims } else { Vec::new() };
        lights.check().map_err(|error| error.to_string())?;
        Ok(lights)
    }
}

/// An own light as a row has changed it.
fn changed(light: &OwnLight, own: &OwnAsk) -> Result<LightSource, String> {
    let mut source = light.source.dimmed(own.dim.into());
    if let Some(to) = own.position {
        let moved = source.moved(to.into());
        source = moved.ok_or_else(|| format!("the light {:?} has no position", own.name))?;
    }
    match (own.toward, &mut source) {
        (None, _) => {}
        (Some([azimuth, elevation]), LightSource::Distant(sun)) => {
            sun.toward = sky_direction(azimuth.into(), elevation.into());
        }
        (Some(_), _) => return Err(format!("the light {:?} has no direction", own.name)),
    }
    Ok(source)
}

fn of_source(source: &LightSource) -> Row {
    let at = |strength, unit| Row {
        strength,
        unit,
        position: source.position(),
        toward: None,
    };
    match source {
        LightSource::Point(PointLight { intensity, .. }) => at(*intensity, "W/sr"),
        LightSource::Spot(spot) => at(spot.intensity, "W/sr"),
        LightSource::Distant(sun) => Row {
            toward: Some(sun.toward),
            ..at(sun.irradiance, "W/m²")
        },
        LightSource::Environment(sky) => at(sky.radiance, "times its picture, or W/(sr m²)"),
        LightSource::Goniometric(_) => at(Vec3::ONE, "times its profile"),
    }
}

/// Azimuth, elevation \[degrees\] and irradiance of suns, as a page has them.
pub(crate) fn sun_rows(suns: &[DistantLight]) -> Vec<Vec<f64>> {
    let row = |sun: &DistantLight| {
        let angles = azimuth_elevation(sun.toward).into_iter();
        let irradiance = sun.irradiance.to_array().into_iter().map(f64::from);
        angles.chain(irradiance).collect()
    };
    suns.iter().map(row).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use rrf_lights::{Falloff, SpotLight};
    use rrf_scene::{LoadOptions, load};
    use std::path::Path;

    /// The Cornell box with its lamp, a point, a spot and a sun.
    fn scene() -> Scene {
        let path =
            Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/cornell-box/scene.pbrt");
        let mut scene = load(&path, &LoadOptions::default()).unwrap();
        let bulb = PointLight {
            position: Vec3::Y,
            intensity: Vec3::ONE,
        };
        let spot = SpotLight {
            position: Vec3::Y,
            axis: Vec3::NEG_Y,
            intensity: Vec3::splat(2.0),
            inner: 0.2,
            outer: 0.4,
            falloff: Falloff::Squared,
        };
        let sun = DistantLight::sun(Vec3::Y, Vec3::splat(3.0));
        let sources: [LightSource; 3] = [bulb.into(), spot.into(), sun.into()];
        for (name, source) in ["bulb", "spot", "far"].into_iter().zip(sources) {
            let name = name.to_string();
            scene.lights.push(OwnLight { name, source });
        }
        scene
    }

    fn ask(own: &str) -> Ask {
        let text = format!(
            r#"{{"fov":40,"size":[64,48],"lights":[[0,1,0,1,1,1]],"suns":[[90,0,1,2,3]],"own":{own}}}"#
        );
        let start = rrf_render::View::look_at(Vec3::ZERO, Vec3::NEG_Z, Vec3::Y, 40.0, [64, 48]);
        Ask::parse(&text, &start).unwrap()
    }

    #[test]
    fn rows_name_and_switch_every_light() {
        let (scene, lamps) = (scene(), AreaLights::default());
        let tracer = Tracer::new(&scene).unwrap();
        let own = OwnLights {
            tracer: &tracer,
            lamps: &lamps,
            on: true,
            known: false,
        };
        let rows = own.rows();
        let said = |key: &str| rows.iter().map(|r| r[key].clone()).collect::<Vec<_>>();
        assert_eq!(said("name"), ["bulb", "spot", "far", "light0"]);
        assert_eq!(said("kind"), ["point", "spot", "distant", "lamp"]);
        assert_eq!(rows[2]["toward"][1], 90.0);
        assert!(
            rows[1]["shows"]
                .as_str()
                .unwrap()
                .contains("direct light only")
        );

        let none = own.lights(&ask("[]")).unwrap();
        assert_eq!(
            (none.points.len(), none.sources.len(), none.area),
            (1, 1, false)
        );
        let all = r#"[{"name":"bulb","dim":[1,2,3],"position":[0,0.5,0]},
            {"name":"spot","dim":[1,1,1]},{"name":"far","dim":[1,1,1],"toward":[90,0]},
            {"name":"light0","dim":[0.5,0,1]}]"#;
        let all = own.lights(&ask(all)).unwrap();
        assert_eq!(all.points[0].position, Vec3::new(0.0, 0.5, 0.0));
        assert_eq!(all.points[0].intensity, Vec3::new(1.0, 2.0, 3.0));
        assert_eq!(all.sources.len(), 3);
        let LightSource::Distant(far) = all.sources[1].source else {
            panic!("not a sun")
        };
        assert!((far.toward - Vec3::X).length() < 1e-6);
        assert_eq!((all.area, all.dims), (true, vec![Vec3::new(0.5, 0.0, 1.0)]));
    }

    #[test]
    fn what_lights_cannot_do_is_refused() {
        let (scene, lamps) = (scene(), AreaLights::default());
        let tracer = Tracer::new(&scene).unwrap();
        let own = OwnLights {
            tracer: &tracer,
            lamps: &lamps,
            on: true,
            known: true,
        };
        for (bad, word) in [
            (
                r#"{"name":"bulbs","dim":[1,1,1]}"#,
                "bulb, spot, far, light0",
            ),
            (
                r#"{"name":"far","dim":[1,1,1],"position":[0,0,0]}"#,
                "position",
            ),
            (
                r#"{"name":"spot","dim":[1,1,1],"toward":[0,0]}"#,
                "direction",
            ),
            (r#"{"name":"spot","dim":[-1,1,1]}"#, "spot"),
        ] {
            let error = own.lights(&ask(&format!("[{bad}]"))).unwrap_err();
            assert!(error.contains(word), "{error}");
        }
    }
}
