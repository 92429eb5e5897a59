//! Sobol points with nested uniform (Owen) scrambling: evenly spread in every dimension and pair.
//!
//! Direction numbers: Joe and Kuo, *Constructing Sobol sequences with better two-dimensional
//! projections*, SIAM J. Sci. Comput. 2008. Scrambling by hashing: Laine and Karras, EGSR 2011,
//! constants of Burley, *Practical Hash-based Owen Scrambling*, JCGT 2020; a random digital shift
//! on top makes every point exactly uniform whatever the quality of the hash.

use crate::hash::split_mix_at;
use crate::philox::unit;
use crate::stream::Stream;

/// How many dimensions there are.
pub const DIMENSIONS: usize = 12;

/// Blocks of a [`Stream`] from here on scramble; those below belong to the bounces of paths.
const SCRAMBLE_BLOCKS: u32 = 1 << 31;

/// Degree, polynomial and first direction numbers of dimensions 2 to 12.
const JOE_KUO: [(usize, u32, [u32; 5]); DIMENSIONS - 1] = [
    (1, 0, [1, 0, 0, 0, 0]),
    (2, 1, [1, 3, 0, 0, 0]),
    (3, 1, [1, 3, 1, 0, 0]),
    (3, 2, [1, 1, 1, 0, 0]),
    (4, 1, [1, 1, 3, 3, 0]),
    (4, 4, [1, 3, 5, 13, 0]),
    (5, 2, [1, 1, 5, 5, 17]),
    (5, 4, [1, 1, 5, 5, 5]),
    (5, 7, [1, 1, 7, 11, 19]),
    (5, 11, [1, 1, 5, 1, 1]),
    (5, 13, [1, 1, 1, 3, 11]),
];

/// What scrambles one dimension: a seed of the hash and a digital shift, both random.
pub type Scramble = [u32; 2];

/// The direction numbers, bits reversed.
static DIRECTIONS: [[u32; 32]; DIMENSIONS] = directions();

/// Coordinate `dimension` of point `index` of the plain sequence, bits reversed: the first digit
/// lowest, as the scrambling wants it.
#[inline]
pub fn reversed(index: u32, dimension: usize) -> u32 {
    let (mut left, mut x) = (index, 0);
    for direction in DIRECTIONS.get(dimension).into_iter().flatten() {
        if left & 1 == 1 {
            x ^= direction;
        }
        left >>= 1;
    }
    x
}

/// A coordinate in [0, 1) from a reversed one: each digit is flipped by a hash of the digits
/// above it.
#[inline(always)]
pub fn scramble(reversed: u32, [seed, shift]: Scramble) -> f32 {
    unit(owen(reversed, seed) ^ shift)
}

/// The scrambles of one replicate of a sample: replicates are independent of each other.
pub fn scrambles(stream: Stream, index: u64, replicate: u32) -> [Scramble; DIMENSIONS] {
    let mut all = [[0; 2]; DIMENSIONS];
    for (block, pair) in (0..).zip(all.chunks_mut(2)) {
        let words = stream.block(index, replicate, SCRAMBLE_BLOCKS + block);
        for (scramble, word) in pair.iter_mut().zip(words.chunks(2)) {
            scramble.copy_from_slice(word);
        }
    }
    all
}

/// The first points of the plain sequence, bits reversed.
#[derive(Clone, Debug)]
pub struct Table {
    points: Vec<[u32; DIMENSIONS]>,
}

impl Table {
    /// The first `count` points.
    pub fn new(count: usize) -> Table {
        let point = |index: usize| std::array::from_fn(|d| reversed(index as u32, d));
        Table {
            points: (0..count).map(point).collect(),
        }
    }

    /// Point `index`, unscrambled and bits reversed; past the end it starts again.
    #[inline(always)]
    pub fn reversed(&self, index: usize) -> &[u32; DIMENSIONS] {
        const ZERO: [u32; DIMENSIONS] = [0; DIMENSIONS];
        self.points
            .get(index % self.points.len().max(1))
            .unwrap_or(&ZERO)
    }
}

/// A scrambled sequence of 2^32 points, in shuffled order; one seed, one sequence.
#[derive(Clone, Debug)]
pub struct Sequence {
    seeds: [u32; Sequence::DIMENSIONS],
    shuffle: u32,
}

impl Sequence {
    /// How many dimensions it has.
    pub const DIMENSIONS: usize = 8;

    /// The sequence of `seed`.
    pub fn new(seed: u64) -> Sequence {
        let word = |i: usize| split_mix_at(seed, i as u64) as u32;
        Sequence {
            seeds: std::array::from_fn(word),
            shuffle: word(Sequence::DIMENSIONS),
        }
    }

    /// Point `index`, each coordinate in [0, 1).
    pub fn point(&self, index: u32) -> [f32; Sequence::DIMENSIONS] {
        let index = owen(index.reverse_bits(), self.shuffle);
        std::array::from_fn(|d| scramble(reversed(index, d), [self.seeds[d], 0]))
    }
}

/// A binary fraction, nested uniformly scrambled, from one with its bits reversed.
#[inline(always)]
fn owen(reversed: u32, seed: u32) -> u32 {
    let mut x = reversed;
    x ^= x.wrapping_mul(0x3d20_adea);
    x = x.wrapping_add(seed);
    x = x.wrapping_mul((seed >> 16) | 1);
    x ^= x.wrapping_mul(0x0552_6c56);
    x ^= x.wrapping_mul(0x53a2_2864);
    x.reverse_bits()
}

const fn directions() -> [[u32; 32]; DIMENSIONS] {
    let mut all = [[0; 32]; DIMENSIONS];
    let (mut d, mut i) = (0, 0);
    while i < 32 {
        all[0][i] = 1 << i;
        i += 1;
    }
    while d + 1 < DIMENSIONS {
        let (degree, polynomial, first) = JOE_KUO[d];
        d += 1;
        i = 0;
        while i < 32 {
            all[d][i] = if i < degree {
                (first[i] << (31 - i)).reverse_bits()
            } else {
                next_direction(&all[d], i, degree, polynomial)
            };
            i += 1;
        }
    }
    all
}

/// Direction number `i` from the earlier ones, by the recurrence of the primitive polynomial.
const fn next_direction(v: &[u32; 32], i: usize, degree: usize, polynomial: u32) -> u32 {
    let mut x = v[i - degree] ^ (v[i - degree] << degree);
    let mut k = 1;
    while k < degree {
        if polynomial >> (degree - 1 - k) & 1 == 1 {
            x ^= v[i - k];
        }
        k += 1;
    }
    x
}

#[cfg(test)]
mod tests;
