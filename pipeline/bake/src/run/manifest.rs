//! The manifest of a run, and how two of them differ.

use crate::error::BakeError;
use crate::run::json::corrupt;
use crate::settings::BakeConfig;
use rrf_scene::Scene;
use rrf_store::manifest::{FORMAT, Kernels, RunManifest};
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::Path;

/// The kernels of this process.
pub fn kernels() -> Kernels {
    Kernels {
        linear_algebra: rrf_train::linear_algebra(),
        vectors: vectors().into(),
    }
}

#[cfg(target_arch = "x86_64")]
fn vectors() -> &'static str {
    if is_x86_feature_detected!("avx512f") {
        "AVX-512"
    } else if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") {
        "AVX2 and FMA"
    } else {
        "SSE2"
    }
}

#[cfg(not(target_arch = "x86_64"))]
fn vectors() -> &'static str {
    "what the compiler's baseline has"
}

/// The manifest of a bake.
pub(crate) fn manifest(scene: &Scene, config: &BakeConfig) -> Result<RunManifest, BakeError> {
    let light_box = config.extract.light_box;
    let (low, high) = (light_box.minimum, light_box.maximum);
    let light_box = [low[0], low[1], low[2], high[0], high[1], high[2]];
    Ok(asked_manifest(
        scene,
        config.extract.seed,
        light_box,
        to_value(config)?,
    ))
}

/// The manifest of a bake with this configuration.
pub(crate) fn asked_manifest(
    scene: &Scene,
    seed: u64,
    light_box: [f32; 6],
    config: Value,
) -> RunManifest {
    let source = std::path::absolute(&scene.source).unwrap_or_else(|_| scene.source.clone());
    RunManifest {
        format: FORMAT,
        created_by: format!("rrf {}", env!("CARGO_PKG_VERSION")),
        scene: source,
        scene_hash: scene.hash_hex(),
        seed,
        light_box,
        config,
        kernels: Some(kernels()),
    }
}

/// Checks that a scene is the one that a run was baked of.
///
/// # Errors
/// [`BakeError::OtherRun`].
pub(crate) fn expect_scene(
    folder: &Path,
    manifest: &RunManifest,
    scene: &Scene,
) -> Result<(), BakeError> {
    let asked = scene.hash_hex();
    if asked == manifest.scene_hash {
        return Ok(());
    }
    Err(BakeError::OtherRun {
        path: folder.into(),
        what: "scene: the file has changed since the bake",
        found: manifest.scene_hash.clone(),
        asked,
    })
}

/// A configuration as it stands in a manifest.
pub(crate) fn to_value(config: &BakeConfig) -> Result<Value, BakeError> {
    Ok(serde_json::to_value(config).map_err(|error| corrupt(Path::new("run.json"), error))?)
}

/// Checks that the run in a folder was started with the scene and settings of another manifest; `config`
/// are its settings as parsed, so that those that are younger than the run have their defaults.
///
/// # Errors
/// [`BakeError::OtherRun`] naming the first difference.
pub(crate) fn expect_same(
    folder: &Path,
    (found, config): (&RunManifest, &Value),
    asked: &RunManifest,
) -> Result<(), BakeError> {
    // another program has other task hashes, and may draw other rows
    let pairs = [
        (
            "program",
            found.created_by.clone(),
            asked.created_by.clone(),
        ),
        ("scene", found.scene_hash.clone(), asked.scene_hash.clone()),
        ("seed", found.seed.to_string(), asked.seed.to_string()),
        (
            "configuration",
            differing(config, &asked.config),
            differing(&asked.config, config),
        ),
    ];
    match pairs.into_iter().find(|(_, found, asked)| found != asked) {
        Some((what, found, asked)) => Err(BakeError::OtherRun {
            path: folder.into(),
            what,
            found,
            asked,
        }),
        None => Ok(()),
    }
}

/// The settings of one configuration that differ from another's: `extract.rows 2000, extract.paths 4`.
fn differing(config: &Value, other: &Value) -> String {
    let other = flatten(other, "");
    let settings = flatten(config, "").into_iter();
    let differing = settings.filter(|(name, value)| other.get(name) != Some(value));
    let named: Vec<String> = differing
        .map(|(name, value)| format!("{name} {value}"))
        .collect();
    named.join(", ")
}

/// Every setting by its dotted name; a list is one setting.
fn flatten(value: &Value, name: &str) -> BTreeMap<String, String> {
    let Value::Object(fields) = value else {
        return BTreeMap::from([(name.into(), value.to_string())]);
    };
    let dot = if name.is_empty() { "" } else { "." };
    let inner = |(field, value)| flatten(value, &format!("{name}{dot}{field}"));
    fields.iter().flat_map(inner).collect()
}
