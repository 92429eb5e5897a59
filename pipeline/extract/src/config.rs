//! What an extraction is asked for, and why it is refused.

use crate::candidates::Rejection;
use crate::eyes::Eyes;
use crate::first_tree::Weights;
use crate::outlook::Lookout;
use glam::Vec3;
use rrf_field::columns;
use rrf_field::tree::Domain;
use rrf_scene::Bounds;
use serde::{Deserialize, Serialize};

/// An axis-aligned box of positions, of lights or of eyes, world frame.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Region {
    /// Corner of the smallest coordinates.
    pub minimum: [f32; 3],
    /// Corner of the largest coordinates.
    pub maximum: [f32; 3],
}

/// As it is typed: `x0,y0,z0,x1,y1,z1`.
impl std::fmt::Display for Region {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let ([x0, y0, z0], [x1, y1, z1]) = (self.minimum, self.maximum);
        write!(f, "{x0},{y0},{z0},{x1},{y1},{z1}")
    }
}

impl Region {
    /// The position at `u` in [0, 1)^3.
    pub fn at(&self, u: [f32; 3]) -> Vec3 {
        let (low, high) = (Vec3::from(self.minimum), Vec3::from(self.maximum));
        low + (high - low) * Vec3::from(u)
    }

    /// Whether a position lies in the box, borders included.
    pub fn contains(&self, p: Vec3) -> bool {
        (0..3).all(|i| self.minimum[i] <= p[i] && p[i] <= self.maximum[i])
    }

    /// The part of the box inside a cell's domain, or none.
    pub fn within(&self, domain: &Domain) -> Option<Region> {
        let minimum = std::array::from_fn(|i| self.minimum[i].max(domain.minimum[columns::L + i]));
        let maximum = std::array::from_fn(|i| self.maximum[i].min(domain.maximum[columns::L + i]));
        (0..3)
            .all(|i| minimum[i] <= maximum[i])
            .then_some(Region { minimum, maximum })
    }

    /// Checks the box of a `what` against the scene's bounds.
    fn validate(self, what: &'static str, bounds: &Bounds) -> Result<(), ExtractError> {
        let bad = |message: String| {
            Err(ExtractError::Box {
                what,
                bounds: self,
                message,
            })
        };
        let (low, high) = (self.minimum, self.maximum);
        if low.iter().chain(&high).any(|x| !x.is_finite()) {
            return bad("every coordinate has to be a finite number".into());
        }
        if (0..3).any(|i| low[i] > high[i]) {
            return bad("the first corner has to be the smaller one on every axis".into());
        }
        if (0..3).any(|i| high[i] < bounds.min[i] || low[i] > bounds.max[i]) {
            return bad(format!(
                "lies outside the scene, whose bounds are {:?} to {:?}: nothing there is in the scene",
                bounds.min, bounds.max
            ));
        }
        Ok(())
    }

    /// The places that eyes in the box look from.
    ///
    /// # Errors
    /// Where all of them lie inside solids.
    pub fn eyes(self, lookout: &Lookout) -> Result<Eyes, ExtractError> {
        Eyes::new(lookout, &self).ok_or(ExtractError::Box {
            what: "eye",
            bounds: self,
            message: "lies inside a solid: nothing is seen from there".into(),
        })
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
    /// What a unit of each column group weighs in the first tree.
    pub weights: Weights,
}

/// How many candidates were accepted, and how many left out for which reason.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Census {
    /// Rows accepted.
    pub accepted: u64,
    /// Candidates of a neighbouring cell.
    pub other_cell: u64,
    /// Light inside a solid.
    pub light_in_solid: u64,
    /// Point inside a solid or sealed under one.
    pub point_in_solid: u64,
    /// Points that no eye sees.
    #[serde(default)]
    pub unseen: u64,
    /// Points whose hemisphere is empty.
    pub sees_nothing: u64,
    /// Points on surfaces that reflect nothing.
    pub black: u64,
}

impl Census {
    pub(crate) fn count(&mut self, why: Rejection) {
        *match why {
            Rejection::OtherCell => &mut self.other_cell,
            Rejection::LightInSolid => &mut self.light_in_solid,
            Rejection::PointInSolid => &mut self.point_in_solid,
            Rejection::Unseen => &mut self.unseen,
            Rejection::SeesNothing => &mut self.sees_nothing,
            Rejection::Black => &mut self.black,
        } += 1;
    }
}

/// Why nothing could be extracted.
#[derive(Debug, thiserror::Error)]
pub enum ExtractError {
    /// The box of lights or of eyes is inside out or does not meet the scene.
    #[error("{what} box {bounds}: {message}")]
    Box {
        /// Of lights or of eyes.
        what: &'static str,
        /// The box.
        bounds: Region,
        /// What is wrong and what would be right.
        message: String,
    },
    /// The scene has no surface.
    #[error("the scene has no triangles: there is no surface to light")]
    NoTriangle,
    /// No surface point is fit to learn from.
    #[error(
        "no usable row among {drawn} candidates ({census:?}): check the light box and that the surfaces face the room"
    )]
    NoRow {
        /// Candidates drawn.
        drawn: u64,
        /// Why they were left out.
        census: Census,
    },
    /// The tracer refused the rows.
    #[error(transparent)]
    Trace(#[from] rrf_trace::TraceError),
    /// A setting out of its range.
    #[error("{name} = {value}: {message}")]
    Setting {
        /// The setting.
        name: &'static str,
        /// What was given.
        value: String,
        /// What would be right.
        message: &'static str,
    },
}

impl ExtractConfig {
    /// Checks the settings against each other and the scene's bounds.
    pub fn validate(&self, bounds: &Bounds) -> Result<(), ExtractError> {
        self.light_box.validate("light", bounds)?;
        if let Some(eye_box) = self.eye_box {
            eye_box.validate("eye", bounds)?;
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
