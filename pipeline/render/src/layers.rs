//! The layers of a frame in the making, and the bands of them that threads fill.

use crate::frame::Frame;
use crate::render::{Negative, Part, RenderOptions};
use crate::tile::{self, Tile};
use crate::view::View;
use glam::Vec3;
use rayon::prelude::*;

/// A band of the frame's layers.
pub(crate) struct Band<'f> {
    pub(crate) full: &'f mut [Vec3],
    pub(crate) direct: &'f mut [Vec3],
    pub(crate) indirect: &'f mut [Vec3],
    pub(crate) cell: &'f mut [u32],
    pub(crate) trust: &'f mut [f32],
}

/// All layers of a frame in the making.
pub(crate) struct Layers {
    pub(crate) full: Vec<Vec3>,
    pub(crate) direct: Vec<Vec3>,
    pub(crate) indirect: Vec<Vec3>,
    pub(crate) cell: Vec<u32>,
    pub(crate) trust: Vec<f32>,
}

impl Layers {
    /// Takes a frame's memory for a picture of `view`.
    pub(crate) fn of(frame: &mut Frame, view: &View) -> Layers {
        let count = view.width as usize * view.height as usize;
        (frame.width, frame.height) = (view.width, view.height);
        fn sized<T: Copy>(mut layer: Vec<T>, count: usize, value: T) -> Vec<T> {
            layer.resize(count, value);
            layer
        }
        Layers {
            full: sized(std::mem::take(&mut frame.full), count, Vec3::ZERO),
            direct: sized(frame.direct.take().unwrap_or_default(), count, Vec3::ZERO),
            indirect: sized(frame.indirect.take().unwrap_or_default(), count, Vec3::ZERO),
            cell: sized(frame.cell.take().unwrap_or_default(), count, u32::MAX),
            trust: sized(frame.trust.take().unwrap_or_default(), count, 0.0),
        }
    }

    /// Bands of [`tile::HEIGHT`] rows of pixels.
    pub(crate) fn bands(&mut self, width: u32) -> impl IndexedParallelIterator<Item = Band<'_>> {
        let size = (tile::HEIGHT * width) as usize;
        let parts = self.direct.par_chunks_mut(size);
        let parts = parts.zip(self.indirect.par_chunks_mut(size));
        let facts = self.cell.par_chunks_mut(size);
        let facts = facts.zip(self.trust.par_chunks_mut(size));
        let full = self.full.par_chunks_mut(size);
        full.zip(parts.zip(facts))
            .map(|(full, ((direct, indirect), (cell, trust)))| Band {
                full,
                direct,
                indirect,
                cell,
                trust,
            })
    }

    /// Gives the frame the layers that were asked for.
    pub(crate) fn into_frame(self, frame: &mut Frame, options: &RenderOptions) {
        let (with_direct, with_indirect) = parts(options.part);
        frame.full = self.full;
        frame.direct = with_direct.then_some(self.direct);
        frame.indirect = with_indirect.then_some(self.indirect);
        frame.cell = with_indirect.then_some(self.cell);
        frame.trust = (with_indirect && options.trusted.is_some()).then_some(self.trust);
    }
}

pub(crate) fn parts(part: Part) -> (bool, bool) {
    (part != Part::Indirect, part != Part::Direct)
}

impl Band<'_> {
    /// Forgets what an earlier frame left at the pixels of a tile.
    pub(crate) fn clear(&mut self, tile: Tile, width: u32) {
        for row in 0..tile.height {
            let first = (row * width + tile.x) as usize;
            let pixels = first..first + tile.width as usize;
            self.direct[pixels.clone()].fill(Vec3::ZERO);
            self.indirect[pixels.clone()].fill(Vec3::ZERO);
            self.cell[pixels.clone()].fill(u32::MAX);
            self.trust[pixels].fill(0.0);
        }
    }

    /// Adds up the parts of a tile.
    pub(crate) fn sum(&mut self, tile: Tile, width: u32, negative: Negative) {
        for row in 0..tile.height {
            let first = (row * width + tile.x) as usize;
            let pixels = first..first + tile.width as usize;
            let parts = self.direct[pixels.clone()].iter();
            let parts = parts.zip(&mut self.indirect[pixels.clone()]);
            for (full, (direct, indirect)) in self.full[pixels].iter_mut().zip(parts) {
                if negative == Negative::Zero {
                    *indirect = indirect.max(Vec3::ZERO);
                }
                *full = *direct + *indirect;
            }
        }
    }
}
