//! Random numbers of a tile's paths.

use multiversion::multiversion;
use rrf_materials::{Lane, TILE};
use rrf_sampling::sobol::{self, DIMENSIONS, Scramble};
use rrf_sampling::{Stream, unit};

/// Bounces whose directions come from the Sobol sequence, three dimensions each.
pub(crate) const STRATIFIED: usize = 2;
/// First of the three dimensions that place a point light's vertex or the first lamp point.
pub(crate) const LIGHT: usize = 3 * STRATIFIED;
/// First of the three dimensions of the first point on a mirror.
pub(crate) const SPECULAR: usize = LIGHT + 3;
/// Blocks of the choice of a point on a mirror, one a bounce.
pub(crate) const SPECULAR_BLOCKS: u32 = 1 << 29;
/// First of the three dimensions of the first light from afar.
pub(crate) const FAR: usize = SPECULAR;
/// Blocks of the choice whether rays pass a surface, [`PASSES`] a bounce; those of light subpaths
/// come first, those of connections 2^25 later.
pub(crate) const PASS_BLOCKS: u32 = 1 << 26;
/// Surfaces that one ray may pass.
pub(crate) const PASSES: u32 = 256;
/// Block of the choice of a path's point of light.
pub(crate) const POINT_BLOCK: u32 = 1 << 27;
/// Blocks of the choice of light from afar, one a bounce.
pub(crate) const FAR_BLOCKS: u32 = 1 << 28;
/// Blocks of the choice of a lamp's point, one a bounce.
pub(crate) const LAMP_BLOCKS: u32 = 1 << 30;

/// Which numbers a lane draws.
pub(crate) struct Draws {
    index: [[u32; TILE]; 2],
    path: [u32; TILE],
    reversed: [[u32; TILE]; 3],
    scrambles: [[[u32; TILE]; 2]; 3],
    /// Numbers in [0, 1): three for the direction, one for Russian roulette.
    pub(crate) units: [Lane; 4],
}

impl Draws {
    pub(crate) const ZERO: Draws = Draws {
        index: [[0; TILE]; 2],
        path: [0; TILE],
        reversed: [[0; TILE]; 3],
        scrambles: [[[0; TILE]; 2]; 3],
        units: [[0.0; TILE]; 4],
    };

    /// Lane `i` is path `path` of sample `index`.
    #[inline(always)]
    pub(crate) fn name(&mut self, i: usize, index: u64, path: u32) {
        self.index[0][i] = index as u32;
        self.index[1][i] = (index >> 32) as u32;
        self.path[i] = path;
    }

    /// Lane `i` takes dimensions `first..first + 3` of a scrambled Sobol point.
    #[inline(always)]
    pub(crate) fn stratify(
        &mut self,
        i: usize,
        point: &[u32; DIMENSIONS],
        scrambles: &[Scramble; DIMENSIONS],
        first: usize,
    ) {
        for d in 0..3 {
            let from = (first + d).min(DIMENSIONS - 1);
            self.reversed[d][i] = point[from];
            self.scrambles[d][0][i] = scrambles[from][0];
            self.scrambles[d][1][i] = scrambles[from][1];
        }
    }
}

/// Fills all four units with independent numbers of a path's bounce.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512bw+avx512dq", "x86_64+avx2"))]
pub(crate) fn independent(draws: &mut Draws, stream: Stream, bounce: u32) {
    for i in 0..TILE {
        let counter = [draws.index[0][i], draws.index[1][i], draws.path[i], bounce];
        for (lane, word) in draws.units.iter_mut().zip(stream.at(counter)) {
            lane[i] = unit(word);
        }
    }
}

/// Fills the first three units with the scrambled Sobol coordinates that the lanes took.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512bw+avx512dq", "x86_64+avx2"))]
pub(crate) fn stratified(draws: &mut Draws) {
    for d in 0..3 {
        for i in 0..TILE {
            let by = [draws.scrambles[d][0][i], draws.scrambles[d][1][i]];
            draws.units[d][i] = sobol::scramble(draws.reversed[d][i], by);
        }
    }
}
