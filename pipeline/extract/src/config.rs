//! Settings of plan and extraction.

use crate::error::ExtractError;
use crate::first_tree::Weights;
use crate::region::Region;
use rrf_scene::{Bounds, Material, Scene};
use serde::{Deserialize, Serialize};

/// Treatment of the light that a surface's narrow part sends: mirrors, glass, and lobes of a
/// roughness below `rrf_materials::BROAD_ROUGHNESS`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum NarrowLight {
    /// It is part of the targets, as in runs before version 0.8.
    #[default]
    Learned,
    /// Targets leave it out; frames and queries trace it.
    Traced,
}

impl NarrowLight {
    /// Returns the treatment in a new run of a scene: traced where it has narrow parts at all.
    pub fn of(scene: &Scene) -> NarrowLight {
        match scene.materials.iter().any(Material::may_be_narrow) {
            true => NarrowLight::Traced,
            false => NarrowLight::Learned,
        }
    }

    /// Whether targets hold it.
    pub fn is_learned(&self) -> bool {
        *self == NarrowLight::Learned
    }
}

/// Settings of plan and extraction, recorded in the run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ExtractConfig {
    /// Where lights may stand.
    pub light_box: Region,
    /// Where eyes may be: rows are of surface that is seen from there; all surface without it.
    #[serde(default)]
    pub eye_box: Option<Region>,
    /// Seed of every random number.
    pub seed: u64,
    /// Candidates that the first tree is grown over.
    pub candidates: u32,
    /// Cells of the first tree at the most.
    pub cells: u32,
    /// Rows of all cells together.
    pub rows: u32,
    /// Rows that a cell gets at the least.
    pub fewest_rows: u32,
    /// Paths a row, even: half go to each half estimate.
    pub paths: u32,
    /// Treatment of narrow parts' light. Scenes without narrow parts say nothing of it.
    #[serde(default, skip_serializing_if = "NarrowLight::is_learned")]
    pub narrow: NarrowLight,
    /// Weights of a unit of each column group in the first tree.
    pub weights: Weights,
}

impl ExtractConfig {
    /// Checks the settings against each other and the scene's bounds.
    pub fn validate(&self, bounds: &Bounds) -> Result<(), ExtractError> {
        check_box(self.light_box, "light", bounds)?;
        if let Some(eye_box) = self.eye_box {
            check_box(eye_box, "eye", bounds)?;
        }
        if self.paths < 2 || !self.paths.is_multiple_of(2) {
            return Err(ExtractError::Setting {
                name: "paths",
                value: self.paths.to_string(),
                message: "needs an even number from 2 on, half for each half estimate",
            });
        }
        if self.cells == 0 || self.rows == 0 || self.candidates == 0 {
            return Err(ExtractError::Setting {
                name: "cells, rows, candidates",
                value: format!("{}, {}, {}", self.cells, self.rows, self.candidates),
                message: "need at least 1 each",
            });
        }
        Ok(())
    }
}

/// Checks the box of a `what` against the scene's bounds.
///
/// # Errors
/// [`ExtractError::Box`] for a box without a place in it, or without one in the scene.
pub fn check_box(region: Region, what: &'static str, bounds: &Bounds) -> Result<(), ExtractError> {
    let bad = |message: String| {
        Err(ExtractError::Box {
            what,
            bounds: region,
            message,
        })
    };
    let (low, high) = (region.minimum, region.maximum);
    if low.iter().chain(&high).any(|x| !x.is_finite()) {
        return bad("every coordinate has to be a finite number".into());
    }
    if (0..3).any(|i| low[i] > high[i]) {
        return bad("the first corner has to be the smaller one on every axis".into());
    }
    if (0..3).any(|i| high[i] < bounds.min[i] || low[i] > bounds.max[i]) {
        return bad(format!(
            "lies outside the scene, whose bounds are {}: nothing there is in the scene",
            Region {
                minimum: bounds.min,
                maximum: bounds.max
            }
        ));
    }
    Ok(())
}
