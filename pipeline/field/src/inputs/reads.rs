//! What inputs are computed from, and in which order.

use super::number::Number;
use super::registry::{COUNT, NAMES, RAW, formula};
use crate::columns::L;
use std::ops::{Add, Mul, Range, Sub};
use std::sync::LazyLock;

/// A set of inputs, by their places. As [`Number`]s, sums are unions: a formula gives what it reads.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Reads(u64);

const _: () = assert!(COUNT <= 64, "a set has 64 places");

impl Reads {
    /// One place alone.
    fn only(place: usize) -> Reads {
        Reads(1 << place)
    }

    /// Whether a place is in the set.
    pub fn contains(self, place: usize) -> bool {
        self.0 >> place & 1 == 1
    }

    /// The places, ascending.
    pub fn iter(self) -> impl Iterator<Item = usize> {
        (0..COUNT).filter(move |&place| self.contains(place))
    }
}

impl Reads {
    /// The places in either set.
    #[inline(always)]
    fn union(self, other: Reads) -> Reads {
        Reads(self.0 | other.0)
    }
}

impl Add for Reads {
    type Output = Reads;

    fn add(self, other: Reads) -> Reads {
        self.union(other)
    }
}

impl Sub for Reads {
    type Output = Reads;

    fn sub(self, other: Reads) -> Reads {
        self.union(other)
    }
}

impl Mul for Reads {
    type Output = Reads;

    fn mul(self, other: Reads) -> Reads {
        self.union(other)
    }
}

impl Mul<f32> for Reads {
    type Output = Reads;

    fn mul(self, _: f32) -> Reads {
        self
    }
}

impl Number for Reads {
    fn sqrt(self) -> Reads {
        self
    }

    fn reciprocal(self) -> Reads {
        self
    }
}

/// What each input reads, itself and whatever the inputs that it reads do included.
static READS: LazyLock<[Reads; COUNT]> = LazyLock::new(|| {
    let own: [Reads; COUNT] = std::array::from_fn(Reads::only);
    std::array::from_fn(|input| {
        let (mut all, mut found) = (Reads::default(), own[input]);
        while all != found {
            all = found;
            found = all.iter().fold(all, |sum, i| sum + formula(i, &own));
        }
        all
    })
});

/// Place of the input of this name.
pub fn place(name: &str) -> Option<u8> {
    NAMES
        .iter()
        .position(|known| *known == name)
        .map(|i| i as u8)
}

/// Everything that an input is computed from, itself included; nothing for a place beyond the list.
pub fn reads(input: u8) -> Reads {
    READS.get(usize::from(input)).copied().unwrap_or_default()
}

/// Whether an input is one of the raw columns `raw` or computed from any of them.
pub fn depends_on(input: u8, mut raw: Range<usize>) -> bool {
    let reads = reads(input);
    raw.any(|column| reads.contains(column))
}

/// Whether an input changes when only the light moves.
pub fn depends_on_light(input: u8) -> bool {
    depends_on(input, L..L + 3)
}

/// The derived inputs among those that any of `inputs` reads, each after what it reads itself.
pub fn derivation(inputs: &[u8]) -> Vec<u8> {
    let all = inputs
        .iter()
        .fold(Reads::default(), |sum, &i| sum + reads(i));
    let mut derived: Vec<u8> = all.iter().filter(|&i| i >= RAW).map(|i| i as u8).collect();
    // what an input reads, reads less than it
    derived.sort_by_key(|&i| reads(i).iter().count());
    derived
}

/// Evaluates every input from the raw columns, whatever numbers are.
pub fn evaluate_all<T: Number>(raw: [T; RAW]) -> [T; COUNT] {
    let places: Vec<u8> = (0..COUNT as u8).collect();
    // any number will do where derived ones are still to come
    let mut all = std::array::from_fn(|i| raw.get(i).copied().unwrap_or(raw[0]));
    for input in derivation(&places).into_iter().map(usize::from) {
        all[input] = formula(input, &all);
    }
    all
}
