//! Where a long fit stands, kept now and then so that it can go on after a kill.
//!
//! A fit is a sequence of legs ([`crate::descent::Descent::run`]) that follows from its
//! arguments alone. What is kept is the outcome of every leg that has ended and the state inside
//! the one at hand. A fit that begins again takes the outcomes as its own, leg after leg, and
//! goes on where the last left off: every number is the one that an undisturbed fit has, so that
//! the result has the same bits, whenever and however often it was cut off.

use crate::lm::Stop;
use std::cell::RefCell;

/// Keeps the state of one fit.
pub trait Keeper {
    /// What was kept last for the same arguments, if anything.
    fn load(&self) -> Option<Vec<u8>>;
    /// Whether it is time to keep the state: it does not change the result.
    fn is_due(&self) -> bool;
    /// Keeps the state in place of what was kept before.
    fn save(&self, state: &[u8]);
}

/// Numbers in a row, by their bits.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Words(Vec<u64>);

impl Words {
    pub fn push(&mut self, word: u64) {
        self.0.push(word);
    }

    pub fn float(&mut self, x: f64) {
        self.push(x.to_bits());
    }

    /// A list and its length.
    pub fn floats(&mut self, list: &[f64]) {
        self.push(list.len() as u64);
        self.0.extend(list.iter().map(|x| x.to_bits()));
    }

    fn words(&mut self, list: &[u64]) {
        self.push(list.len() as u64);
        self.0.extend_from_slice(list);
    }

    pub fn reader(&self) -> Reader<'_> {
        Reader(&self.0)
    }
}

/// Takes them out again; none where they end.
pub(crate) struct Reader<'a>(&'a [u64]);

impl Reader<'_> {
    pub fn take(&mut self) -> Option<u64> {
        let (first, rest) = self.0.split_first()?;
        self.0 = rest;
        Some(*first)
    }

    pub fn float(&mut self) -> Option<f64> {
        self.take().map(f64::from_bits)
    }

    fn words(&mut self) -> Option<Vec<u64>> {
        let count = usize::try_from(self.take()?).ok()?;
        let (list, rest) = self.0.split_at_checked(count)?;
        self.0 = rest;
        Some(list.to_vec())
    }

    /// A list of any length.
    pub fn list(&mut self) -> Option<Vec<f64>> {
        let words = self.words()?;
        Some(words.into_iter().map(f64::from_bits).collect())
    }

    /// A list that must be of this length.
    pub fn floats(&mut self, length: usize) -> Option<Vec<f64>> {
        self.list().filter(|list| list.len() == length)
    }
}

/// The legs of a fit.
#[derive(Default)]
pub(crate) struct Journal<'a> {
    keeper: Option<&'a dyn Keeper>,
    legs: RefCell<Legs>,
}

#[derive(Default)]
struct Legs {
    /// Outcomes of all legs so far, those of a fit that was cut off included.
    ended: Vec<Words>,
    /// How many of them this fit has gone through.
    gone: usize,
    /// The state inside the leg after the last outcome.
    begun: Option<Words>,
}

impl<'a> Journal<'a> {
    /// Goes on from what the keeper has.
    pub fn new(keeper: Option<&'a dyn Keeper>) -> Journal<'a> {
        let kept = keeper.and_then(Keeper::load);
        let legs = kept.and_then(|bytes| Legs::parse(&bytes));
        Journal {
            keeper,
            legs: RefCell::new(legs.unwrap_or_default()),
        }
    }

    /// The outcome of the next leg, where it is known.
    pub fn outcome(&self) -> Option<Words> {
        let mut legs = self.legs.borrow_mut();
        let outcome = legs.ended.get(legs.gone).cloned()?;
        legs.gone += 1;
        Some(outcome)
    }

    /// The last outcome is not one of this fit: nothing that was kept is used.
    pub fn forget(&self) {
        let mut legs = self.legs.borrow_mut();
        legs.gone = legs.gone.saturating_sub(1);
        let gone = legs.gone;
        legs.ended.truncate(gone);
        legs.begun = None;
    }

    /// The state to go on from inside the next leg, where one was kept.
    pub fn begun(&self) -> Option<Words> {
        self.legs.borrow_mut().begun.take()
    }

    /// Whether nobody keeps anything.
    pub fn is_idle(&self) -> bool {
        self.keeper.is_none()
    }

    /// The leg at hand has ended.
    pub fn ended(&self, outcome: Words) {
        let mut legs = self.legs.borrow_mut();
        legs.ended.push(outcome);
        legs.gone = legs.ended.len();
    }

    /// Keeps the state inside the leg at hand if it is time to.
    pub fn inside(&self, state: impl FnOnce() -> Words) {
        if let Some(keeper) = self.keeper.filter(|keeper| keeper.is_due()) {
            keeper.save(&self.legs.borrow().bytes(&state()));
        }
    }
}

impl Legs {
    fn bytes(&self, begun: &Words) -> Vec<u8> {
        let mut all = Words::default();
        all.push(self.ended.len() as u64);
        for outcome in &self.ended {
            all.words(&outcome.0);
        }
        all.words(&begun.0);
        all.0.iter().flat_map(|word| word.to_le_bytes()).collect()
    }

    fn parse(bytes: &[u8]) -> Option<Legs> {
        let (words, []) = bytes.as_chunks::<8>() else {
            return None;
        };
        let words = Words(words.iter().map(|word| u64::from_le_bytes(*word)).collect());
        let mut reader = words.reader();
        let count = reader.take()?;
        let ended = (0..count)
            .map(|_| reader.words().map(Words))
            .collect::<Option<Vec<Words>>>()?;
        Some(Legs {
            ended,
            gone: 0,
            begun: Some(Words(reader.words()?)),
        })
    }
}

/// All reasons to stop, by number.
const STOPS: [Stop; 11] = [
    Stop::NoRows,
    Stop::Constant,
    Stop::Gradient,
    Stop::Step,
    Stop::Cost,
    Stop::Validation,
    Stop::Target,
    Stop::Iterations,
    Stop::Damping,
    Stop::NotFinite,
    Stop::Solved,
];

pub(crate) fn stop_number(stop: Stop) -> u64 {
    STOPS.iter().position(|s| *s == stop).unwrap_or(0) as u64
}

pub(crate) fn stop_of(number: u64) -> Option<Stop> {
    STOPS.get(usize::try_from(number).ok()?).copied()
}
