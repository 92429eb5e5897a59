//! Random numbers of one stage of one cell.

use crate::philox::{philox4x32, unit};
use crate::stage::Stage;

/// The random numbers of one stage of one cell under one seed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stream {
    key: [u32; 2],
    /// Flips bits of the counter's last two words, path and block.
    flip: [u32; 2],
}

impl Stream {
    /// Names a stream. Streams that differ in any of the three are independent: their Philox
    /// keys are 64 bits of a Philox output keyed by the seed.
    pub fn new(seed: u64, stage: Stage, cell: u32) -> Stream {
        let words = philox4x32([stage as u32, cell, 0, 0], words_of(seed));
        Stream {
            key: [words[0], words[1]],
            flip: [0; 2],
        }
    }

    /// Names a stream in the layout of training: the key is the seed, and the counter holds
    /// the cell in place of the path and the stage in the upper 8 bits of the block.
    pub fn in_counter(seed: u64, stage: Stage, cell: u32) -> Stream {
        Stream {
            key: words_of(seed),
            flip: [cell, (stage as u32) << 24],
        }
    }

    /// A stream of its own for one of several parts that share indices.
    pub fn part(&self, part: u32) -> Stream {
        let words = philox4x32([part, 0, 0, 1], self.key);
        Stream {
            key: [words[0], words[1]],
            ..*self
        }
    }

    /// Four independent words for a counter of index (low and high word), path and block.
    #[inline(always)]
    pub fn at(&self, [low, high, path, block]: [u32; 4]) -> [u32; 4] {
        let [path, block] = [path ^ self.flip[0], block ^ self.flip[1]];
        philox4x32([low, high, path, block], self.key)
    }

    /// Four independent words for a sample `index`, one of its paths, and one block of
    /// that path's dimensions.
    #[inline(always)]
    pub fn block(&self, index: u64, path: u32, block: u32) -> [u32; 4] {
        let [low, high] = words_of(index);
        self.at([low, high, path, block])
    }

    /// [`Stream::block`] as numbers in [0, 1).
    #[inline(always)]
    pub fn units(&self, index: u64, path: u32, block: u32) -> [f32; 4] {
        self.block(index, path, block).map(unit)
    }

    /// Dimension `dimension` of `index`, uniform in [0, 1) by 24 bits.
    #[inline]
    pub fn f32(&self, index: u64, dimension: u32) -> f32 {
        unit(self.block(index, 0, dimension / 4)[(dimension % 4) as usize])
    }

    /// Dimension `dimension` of `index`, uniform in [0, 1) by 53 bits. Takes two words: f64
    /// dimension d overlaps the f32 dimensions 2 d and 2 d + 1; a consumer uses the one kind or
    /// the other.
    #[inline]
    pub fn f64(&self, index: u64, dimension: u32) -> f64 {
        let words = self.block(index, 0, dimension / 2);
        let at = 2 * (dimension % 2) as usize;
        let bits = (u64::from(words[at]) << 32) | u64::from(words[at + 1]);
        (bits >> 11) as f64 * (1.0 / (1u64 << 53) as f64)
    }

    /// The dimensions of `index`, one after another.
    #[inline]
    pub fn dimensions(&self, index: u64) -> Dimensions {
        Dimensions {
            stream: *self,
            index,
            dimension: 0,
            words: [0; 4],
        }
    }
}

/// The dimensions of one index of a [`Stream`], one after another.
#[derive(Clone, Copy, Debug)]
pub struct Dimensions {
    stream: Stream,
    index: u64,
    dimension: u32,
    words: [u32; 4],
}

impl Dimensions {
    /// The next dimension as 32 random bits.
    #[inline]
    pub fn next_u32(&mut self) -> u32 {
        let lane = (self.dimension % 4) as usize;
        if lane == 0 {
            self.words = self.stream.block(self.index, 0, self.dimension / 4);
        }
        self.dimension += 1;
        self.words[lane]
    }

    /// The next dimension, uniform in [0, 1); equals [`Stream::f32`] of that dimension.
    #[inline]
    pub fn next_f32(&mut self) -> f32 {
        unit(self.next_u32())
    }
}

/// The low and the high word.
#[inline(always)]
fn words_of(x: u64) -> [u32; 2] {
    [x as u32, (x >> 32) as u32]
}

#[cfg(test)]
mod tests {
    use super::*;

    type Named = fn(u64, Stage, u32) -> Stream;
    const LAYOUTS: [Named; 2] = [Stream::new, Stream::in_counter];

    #[test]
    fn every_name_changes_the_values() {
        for stream in LAYOUTS {
            let a = stream(1, Stage::Test, 3).block(4, 5, 6);
            for other in [
                stream(2, Stage::Test, 3).block(4, 5, 6),
                stream(1 << 32, Stage::Test, 3).block(4, 5, 6),
                stream(1, Stage::Train, 3).block(4, 5, 6),
                stream(1, Stage::Test, 4).block(4, 5, 6),
                stream(1, Stage::Test, 3).block(4 + (1 << 32), 5, 6),
                stream(1, Stage::Test, 3).block(4, 6, 6),
                stream(1, Stage::Test, 3).block(4, 5, 7),
                stream(1, Stage::Test, 3).part(0).block(4, 5, 6),
                stream(1, Stage::Test, 3).part(1).block(4, 5, 6),
            ] {
                assert_ne!(a, other);
            }
        }
    }

    /// Chi-square over 64 bins, 65,536 draws; the 99.9999 % point for 63 degrees of freedom is
    /// 130.4.
    #[test]
    fn every_dimension_is_uniform() {
        let stream = Stream::new(9, Stage::Test, 3);
        for dimension in 0..6 {
            let chi2 = chi_square(
                |index| (f64::from(stream.f32(index, dimension)), 0.5),
                64,
                1,
            );
            assert!(chi2 < 130.4, "dimension {dimension}: chi-square {chi2}");
        }
    }

    /// Neighbouring dimensions, indices and cells: 8 x 8 bins, same bound.
    #[test]
    fn neighbours_are_independent() {
        for stream in LAYOUTS {
            let (a, b) = (stream(1, Stage::Test, 0), stream(1, Stage::Test, 1));
            type Pair<'a> = &'a dyn Fn(u64) -> (f64, f64);
            let pairs: [Pair; 3] = [
                &|i| (a.f64(i, 0), a.f64(i, 1)),
                &|i| (a.f64(2 * i, 0), a.f64(2 * i + 1, 0)),
                &|i| (a.f64(i, 0), b.f64(i, 0)),
            ];
            for (which, pair) in pairs.iter().enumerate() {
                let chi2 = chi_square(pair, 8, 8);
                assert!(chi2 < 130.4, "pair {which}: chi-square {chi2}");
            }
        }
    }

    fn chi_square(pair: impl Fn(u64) -> (f64, f64), columns: usize, rows: usize) -> f64 {
        let mut bins = [0u32; 64];
        for index in 0..65_536 {
            let (x, y) = pair(index);
            bins[(x * columns as f64) as usize * rows + (y * rows as f64) as usize] += 1;
        }
        let square = |&n: &u32| (f64::from(n) - 1024.0).powi(2) / 1024.0;
        bins.iter().map(square).sum()
    }

    #[test]
    fn walking_equals_indexing() {
        let stream = Stream::new(77, Stage::Train, 12);
        let mut dimensions = stream.dimensions(1 << 40);
        for dimension in 0..23 {
            assert_eq!(dimensions.next_f32(), stream.f32(1 << 40, dimension));
        }
    }
}
