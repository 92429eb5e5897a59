//! Random numbers as a function of indices: Philox4x32-10 (Salmon, Moraes, Dror, Shaw,
//! *Parallel random numbers: as easy as 1, 2, 3*, SC 2011).
//!
//! A number depends on (seed, stage, cell, index, dimension) and on nothing else, so any
//! part of a run can be made again alone, in any order, on any number of threads.
//! The key is the seed; the counter holds index (64 bits), cell (32), stage (8) and the
//! block of dimensions (24). No two streams share a counter.

/// Which stage draws; part of every counter, so that stages never share numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Stage {
    /// First weights and restarts of the nets.
    Train = 4,
    /// Tests and made-up data.
    Test = 6,
}

/// All random numbers of one (seed, stage, cell).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stream {
    key: [u32; 2],
    cell: u32,
    stage: u32,
}

impl Stream {
    /// The stream of (seed, stage, cell).
    pub fn new(seed: u64, stage: Stage, cell: u32) -> Stream {
        Stream {
            key: [seed as u32, (seed >> 32) as u32],
            cell,
            stage: stage as u32,
        }
    }

    /// Four words: dimensions `4 * block .. 4 * block + 4` of `index`. Blocks count to 2^24.
    #[inline]
    pub fn block(&self, index: u64, block: u32) -> [u32; 4] {
        let counter = [
            index as u32,
            (index >> 32) as u32,
            self.cell,
            (self.stage << 24) | (block & 0x00ff_ffff),
        ];
        philox(counter, self.key)
    }

    /// Uniform in [0, 1), 24 bits: dimension `dimension` of `index`.
    #[inline]
    pub fn f32(&self, index: u64, dimension: u32) -> f32 {
        unit_f32(self.block(index, dimension / 4)[(dimension % 4) as usize])
    }

    /// Uniform in [0, 1), 53 bits. Takes two words: f64 dimension d overlaps the f32
    /// dimensions 2 d and 2 d + 1; a consumer uses the one kind or the other.
    #[inline]
    pub fn f64(&self, index: u64, dimension: u32) -> f64 {
        let words = self.block(index, dimension / 2);
        let at = 2 * (dimension % 2) as usize;
        let bits = (u64::from(words[at]) << 32) | u64::from(words[at + 1]);
        (bits >> 11) as f64 * (1.0 / (1u64 << 53) as f64)
    }

    /// Walks through the dimensions of one index.
    #[inline]
    pub fn walk(&self, index: u64) -> Walk {
        Walk {
            stream: *self,
            index,
            dimension: 0,
            words: [0; 4],
        }
    }
}

/// The dimensions of one index, one after another.
#[derive(Clone, Copy, Debug)]
pub struct Walk {
    stream: Stream,
    index: u64,
    dimension: u32,
    words: [u32; 4],
}

impl Walk {
    /// The next dimension as 32 random bits.
    #[inline]
    pub fn next_u32(&mut self) -> u32 {
        let lane = (self.dimension % 4) as usize;
        if lane == 0 {
            self.words = self.stream.block(self.index, self.dimension / 4);
        }
        self.dimension += 1;
        self.words[lane]
    }

    /// The next dimension, uniform in [0, 1); equals [`Stream::f32`] of that dimension.
    #[inline]
    pub fn next_f32(&mut self) -> f32 {
        unit_f32(self.next_u32())
    }
}

/// The upper 24 bits as a number in [0, 1).
#[inline]
pub fn unit_f32(word: u32) -> f32 {
    (word >> 8) as f32 * (1.0 / (1u32 << 24) as f32)
}

/// Philox4x32 with 10 rounds.
#[inline]
pub fn philox(mut counter: [u32; 4], mut key: [u32; 2]) -> [u32; 4] {
    for round in 0..10 {
        if round > 0 {
            key = [
                key[0].wrapping_add(0x9E37_79B9),
                key[1].wrapping_add(0xBB67_AE85),
            ];
        }
        let p0 = u64::from(counter[0]) * 0xD251_1F53;
        let p1 = u64::from(counter[2]) * 0xCD9E_8D57;
        counter = [
            (p1 >> 32) as u32 ^ counter[1] ^ key[0],
            p1 as u32,
            (p0 >> 32) as u32 ^ counter[3] ^ key[1],
            p0 as u32,
        ];
    }
    counter
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The known answers that the authors publish with Random123.
    #[test]
    fn philox_known_answers() {
        let cases = [
            (
                [0; 4],
                [0; 2],
                [0x6627_e8d5, 0xe169_c58d, 0xbc57_ac4c, 0x9b00_dbd8],
            ),
            (
                [u32::MAX; 4],
                [u32::MAX; 2],
                [0x408f_276d, 0x41c8_3b0e, 0xa20b_c7c6, 0x6d54_51fd],
            ),
            (
                [0x243f_6a88, 0x85a3_08d3, 0x1319_8a2e, 0x0370_7344],
                [0xa409_3822, 0x299f_31d0],
                [0xd16c_fe09, 0x94fd_cceb, 0x5001_e420, 0x2412_6ea1],
            ),
        ];
        for (counter, key, answer) in cases {
            assert_eq!(philox(counter, key), answer);
        }
    }

    /// Chi-square over 64 bins, 65,536 draws; 99.9999 % point of chi-square(63) is 130.4.
    #[test]
    fn every_dimension_is_uniform() {
        let stream = Stream::new(9, Stage::Test, 3);
        for dimension in 0..6 {
            let mut bins = [0u32; 64];
            for index in 0..65_536u64 {
                bins[(stream.f32(index, dimension) * 64.0) as usize] += 1;
            }
            let chi2: f64 = bins
                .iter()
                .map(|&n| (f64::from(n) - 1024.0).powi(2) / 1024.0)
                .sum();
            assert!(chi2 < 130.4, "dimension {dimension}: chi-square {chi2}");
        }
    }

    /// Neighbouring dimensions, indices and cells: 8 x 8 bins, same bound.
    #[test]
    fn neighbours_are_independent() {
        let (a, b) = (
            Stream::new(1, Stage::Test, 0),
            Stream::new(1, Stage::Test, 1),
        );
        type Pair<'a> = &'a dyn Fn(u64) -> (f64, f64);
        let pairs: [Pair; 3] = [
            &|i| (a.f64(i, 0), a.f64(i, 1)),
            &|i| (a.f64(2 * i, 0), a.f64(2 * i + 1, 0)),
            &|i| (a.f64(i, 0), b.f64(i, 0)),
        ];
        for (which, pair) in pairs.iter().enumerate() {
            let mut bins = [0u32; 64];
            for index in 0..65_536 {
                let (x, y) = pair(index);
                bins[(x * 8.0) as usize * 8 + (y * 8.0) as usize] += 1;
            }
            let chi2: f64 = bins
                .iter()
                .map(|&n| (f64::from(n) - 1024.0).powi(2) / 1024.0)
                .sum();
            assert!(chi2 < 130.4, "pair {which}: chi-square {chi2}");
        }
    }

    #[test]
    fn walking_equals_indexing() {
        let stream = Stream::new(77, Stage::Train, 12);
        let mut walk = stream.walk(1 << 40);
        for dimension in 0..23 {
            assert_eq!(walk.next_f32(), stream.f32(1 << 40, dimension));
        }
    }

    #[test]
    fn stage_cell_and_seed_change_the_numbers() {
        let base = Stream::new(1, Stage::Test, 0).block(0, 0);
        assert_ne!(base, Stream::new(1, Stage::Train, 0).block(0, 0));
        assert_ne!(base, Stream::new(1, Stage::Test, 1).block(0, 0));
        assert_ne!(base, Stream::new(1 << 32, Stage::Test, 0).block(0, 0));
    }
}
