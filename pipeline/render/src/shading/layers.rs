//! The layers of a frame in the making, and the bands of them that threads fill.

use crate::frame::Frame;
use crate::options::RenderOptions;
use crate::tile::{self, Tile};
use crate::view::View;
use glam::Vec3;
use rayon::prelude::*;
use std::ops::Range;

/// A band of the frame's layers: [`tile::HEIGHT`] rows of pixels.
pub(crate) struct Band<'f> {
    full: &'f mut [Vec3],
    pub(crate) direct: &'f mut [Vec3],
    pub(crate) indirect: &'f mut [Vec3],
    pub(crate) cell: &'f mut [u32],
    pub(crate) trust: &'f mut [f32],
}

/// All layers of a frame in the making.
pub(crate) struct Layers {
    full: Vec<Vec3>,
    direct: Vec<Vec3>,
    indirect: Vec<Vec3>,
    cell: Vec<u32>,
    trust: Vec<f32>,
}

impl Layers {
    /// Takes a frame's memory for a picture of `view`.
    pub(crate) fn take_from(frame: &mut Frame, view: &View) -> Layers {
        let count = view.width as usize * view.height as usize;
        (frame.width, frame.height) = (view.width, view.height);
        fn sized<T: Copy + Default>(layer: Option<Vec<T>>, count: usize) -> Vec<T> {
            let mut layer = layer.unwrap_or_default();
            layer.resize(count, T::default());
            layer
        }
        Layers {
            full: sized(Some(std::mem::take(&mut frame.full)), count),
            direct: sized(frame.direct.take(), count),
            indirect: sized(frame.indirect.take(), count),
            cell: sized(frame.cell.take(), count),
            trust: sized(frame.trust.take(), count),
        }
    }

    pub(crate) fn bands(&mut self, width: u32) -> impl IndexedParallelIterator<Item = Band<'_>> {
        let size = (tile::HEIGHT * width) as usize;
        self.full
            .par_chunks_mut(size)
            .zip(self.direct.par_chunks_mut(size))
            .zip(self.indirect.par_chunks_mut(size))
            .zip(self.cell.par_chunks_mut(size))
            .zip(self.trust.par_chunks_mut(size))
            .map(|((((full, direct), indirect), cell), trust)| Band {
                full,
                direct,
                indirect,
                cell,
                trust,
            })
    }

    /// Gives the frame the layers that were asked for.
    pub(crate) fn give_to(self, frame: &mut Frame, options: &RenderOptions) {
        let indirect = options.part.has_indirect();
        frame.full = self.full;
        frame.direct = options.part.has_direct().then_some(self.direct);
        frame.indirect = indirect.then_some(self.indirect);
        frame.cell = indirect.then_some(self.cell);
        frame.trust = (indirect && options.trusted.is_some()).then_some(self.trust);
    }
}

impl<'f> Band<'f> {
    /// A band of points that are asked one by one: their indirect light, its cells and its trust.
    pub(crate) fn of_points(
        direct: &'f mut [Vec3],
        indirect: &'f mut [Vec3],
        cell: &'f mut [u32],
        trust: &'f mut [f32],
    ) -> Band<'f> {
        Band {
            full: &mut [],
            direct,
            indirect,
            cell,
            trust,
        }
    }

    /// Forgets what an earlier frame left at the pixels of a tile.
    pub(crate) fn clear(&mut self, tile: Tile, width: u32) {
        for pixels in rows(tile, width) {
            self.direct[pixels.clone()].fill(Vec3::ZERO);
            self.indirect[pixels.clone()].fill(Vec3::ZERO);
            self.cell[pixels.clone()].fill(u32::MAX);
            self.trust[pixels].fill(0.0);
        }
    }

    /// Adds up the parts of a tile.
    pub(crate) fn sum(&mut self, tile: Tile, width: u32) {
        for pixels in rows(tile, width) {
            let parts = self.direct[pixels.clone()].iter();
            let parts = parts.zip(&self.indirect[pixels.clone()]);
            for (full, (direct, indirect)) in self.full[pixels].iter_mut().zip(parts) {
                *full = *direct + *indirect;
            }
        }
    }
}

/// The pixels of a tile within its band, row by row.
fn rows(tile: Tile, width: u32) -> impl Iterator<Item = Range<usize>> {
    (0..tile.height).map(move |row| {
        let first = (row * width + tile.x) as usize;
        first..first + tile.width as usize
    })
}
