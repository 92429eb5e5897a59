//! The graphics state that directives change and shapes take.

use super::fault::Place;
use super::params::Params;
use glam::{DMat4, DVec3, Vec3};

/// Which version's rules hold where the two differ.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Version {
    V3,
    V4,
}

/// The surface of a shape.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Surface {
    /// pbrt's default material, made when a shape first needs it.
    Default,
    /// A material id.
    Material(u32),
    /// No surface: only a boundary of media.
    Interface,
}

/// A named medium.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Medium {
    /// Light is absorbed there [1/m] and not scattered.
    Absorbs(Vec3),
    /// Left out, with a warning where it was made.
    LeftOut,
}

/// The state that `AttributeBegin` saves.
#[derive(Clone, Copy, Debug)]
pub(super) struct State {
    /// World from object space (camera from world before `WorldBegin`).
    pub ctm: DMat4,
    /// `ReverseOrientation` is in force.
    pub reverse: bool,
    /// Material of the next shapes.
    pub surface: Surface,
    /// Absorption [1/m] of the medium within the next shapes; black for none.
    pub filled_with: Vec3,
    /// Emission of the next shapes, an index into the reader's emissions.
    pub emission: Option<usize>,
    /// Defaults set by `Attribute`, an index into the reader's list.
    pub defaults: Option<usize>,
    /// Transforms now change only the end of the shutter time.
    pub at_end_time: bool,
}

impl State {
    pub fn new() -> Self {
        Self {
            ctm: DMat4::IDENTITY,
            reverse: false,
            surface: Surface::Default,
            filled_with: Vec3::ZERO,
            emission: None,
            defaults: None,
            at_end_time: false,
        }
    }
}

/// The directive that opened a block, and so must close it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Block {
    Attribute,
    Transform,
    Object,
}

impl Block {
    /// The directive's stem.
    pub fn name(self) -> &'static str {
        match self {
            Block::Attribute => "Attribute",
            Block::Transform => "Transform",
            Block::Object => "Object",
        }
    }
}

/// A saved state with the block and place that saved it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Saved {
    pub block: Block,
    pub place: Place,
    pub state: State,
}

/// One `Attribute` directive; a chain through `before`.
#[derive(Clone, Debug)]
pub(super) struct Defaults {
    pub before: Option<usize>,
    pub depth: usize,
    pub target: String,
    pub params: Params,
}

/// An `AreaLightSource` in force.
#[derive(Clone, Debug)]
pub(super) struct Emission {
    /// Emitted radiance, linear sRGB; with `power` set, only its colour.
    pub radiance: DVec3,
    /// Texture that multiplies the radiance, or `INVALID`.
    pub texture: u32,
    /// Emits from both sides.
    pub two_sided: bool,
    /// Power of each shape in place of a radiance, version 4.
    pub power: Option<f64>,
    /// The scene's area light, once a shape without `power` has needed it.
    pub light: Option<u32>,
    /// Name of the own light, once a shape has needed it.
    pub name: Option<String>,
}

/// The picture's size.
#[derive(Clone, Copy, Debug)]
pub(super) struct Film {
    pub width: u32,
    pub height: u32,
}
