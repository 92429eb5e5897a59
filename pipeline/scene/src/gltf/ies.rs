//! EXT_lights_ies: points of light with a lamp maker's profile.
//!
//! The profile's direction of both angles 0 is the node's -z; horizontal angles of type C go from
//! +x towards +y, those of types A and B towards +x from -z. Values in candela are read with
//! 683 lm/W, as KHR_lights_punctual's are by default.

use super::buffers::read_uri;
use super::document::{Document, place};
use super::light::LUMENS_PER_WATT;
use super::nodes::Placed;
use super::output::Output;
use crate::SceneError;
use ::gltf::json::Index;
use glam::{DMat3, DVec3};
use rrf_lights::{GoniometricLight, IesProfile, Profile};
use serde_json::Value;
use std::borrow::Cow;

/// The extension's name.
const NAME: &str = "EXT_lights_ies";

/// Adds a node's light.
pub(super) fn add(
    document: &Document,
    placed: &Placed,
    output: &mut Output,
) -> Result<(), SceneError> {
    let extensions = placed.node.extensions.as_ref();
    let Some(instance) = extensions.and_then(|extensions| extensions.others.get(NAME)) else {
        return Ok(());
    };
    let node = document.node_place(placed.index);
    let wrong = |message: &str| document.error(format!("{node}, {NAME}"), message);
    let index = instance.get("light").and_then(Value::as_u64);
    let index = index.ok_or_else(|| wrong("its \"light\" is no index"))? as usize;
    let profile = read(document, index)?;
    let rotation = rotation(placed).ok_or_else(|| wrong("its node's transform is flat"))?;
    let numbers = numbers(instance).ok_or_else(|| {
        wrong("\"multiplier\" is a number and \"color\" three of them, none negative")
    })?;
    let source = GoniometricLight {
        position: placed.world.translation.as_vec3(),
        intensity: (numbers / LUMENS_PER_WATT).as_vec3(),
        profile: Profile::Ies(profile, rotation.as_mat3()),
    };
    let wanted = placed.node.name.as_ref();
    let wanted = wanted.map_or_else(|| format!("light {index}"), String::clone);
    output.add_light(document, &node, &wanted, source.into())
}

/// The profile of this index.
fn read(document: &Document, index: usize) -> Result<IesProfile, SceneError> {
    let extensions = document.root.extensions.as_ref();
    let profiles = extensions.and_then(|extensions| extensions.others.get(NAME)?.get("lights"));
    let profile = profiles.and_then(|profiles| profiles.get(index));
    let name = profile.and_then(|profile| profile.get("name")?.as_str());
    let place = place("IES profile", index, name);
    let wrong = |message: String| document.error(&place, message);
    let profile = profile.ok_or_else(|| wrong("no such profile".into()))?;
    let view = profile.get("bufferView").and_then(Value::as_u64);
    let uri = profile.get("uri").and_then(Value::as_str);
    let bytes: Cow<[u8]> = match (view, uri) {
        (Some(view), _) => {
            let view = u32::try_from(view).map_err(|_| wrong("no such buffer view".into()))?;
            Cow::Borrowed(document.view_bytes(Index::new(view)).map_err(wrong)?)
        }
        (None, Some(uri)) => read_uri(document.path, uri, || place.clone())?.into(),
        (None, None) => return Err(wrong("neither uri nor bufferView".into())),
    };
    IesProfile::from_bytes(&bytes).map_err(|error| wrong(error.to_string()))
}

/// World directions to the profile's frame, which a node's mirror mirrors too.
fn rotation(placed: &Placed) -> Option<DMat3> {
    let world = placed.world.matrix3;
    let z = world.z_axis.try_normalize()?;
    let y = world.y_axis.reject_from_normalized(z).try_normalize()?;
    let x = y.cross(z) * world.determinant().signum();
    Some(DMat3::from_cols(x, y, -z).transpose())
}

/// `color` times `multiplier`.
fn numbers(instance: &Value) -> Option<DVec3> {
    let multiplier = match instance.get("multiplier") {
        Some(value) => value.as_f64()?,
        None => 1.0,
    };
    let color = match instance.get("color") {
        Some(Value::Array(values)) if values.len() == 3 => {
            let values: Option<Vec<f64>> = values.iter().map(Value::as_f64).collect();
            DVec3::from_slice(&values?)
        }
        Some(_) => return None,
        None => DVec3::ONE,
    };
    (multiplier >= 0.0 && color.min_element() >= 0.0).then_some(color * multiplier)
}
