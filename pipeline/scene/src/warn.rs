//! Warnings gathered while a file is read.

use crate::Warning;
use std::collections::{HashMap, HashSet};

/// Places named in one warning; the rest are counted.
const NAMED_PLACES: usize = 3;

/// One warning a message, its places joined, in the order of first appearance.
#[derive(Default)]
pub(crate) struct Warnings {
    entry_of: HashMap<String, usize>,
    entries: Vec<Entry>,
}

struct Entry {
    message: String,
    named: Vec<String>,
    places: HashSet<String>,
}

impl Warnings {
    /// Notes that `message` holds at `place`.
    pub(crate) fn add(&mut self, place: impl Into<String>, message: impl Into<String>) {
        let (place, message) = (place.into(), message.into());
        let next = self.entries.len();
        let index = *self.entry_of.entry(message.clone()).or_insert(next);
        if index == next {
            self.entries.push(Entry {
                message,
                named: Vec::new(),
                places: HashSet::new(),
            });
        }
        if let Some(entry) = self.entries.get_mut(index) {
            let is_new = entry.places.insert(place.clone());
            if is_new && entry.named.len() < NAMED_PLACES {
                entry.named.push(place);
            }
        }
    }

    /// The warnings.
    pub(crate) fn finish(self) -> Vec<Warning> {
        self.entries.into_iter().map(Entry::into_warning).collect()
    }
}

impl Entry {
    fn into_warning(self) -> Warning {
        let mut place = self.named.join(", ");
        let more = self.places.len() - self.named.len();
        if more > 0 {
            place += &format!(" and {more} more");
        }
        Warning {
            place,
            message: self.message,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_of_one_message_are_joined() {
        let mut warnings = Warnings::default();
        for place in ["a", "b", "a", "c", "d", "e", "d"] {
            warnings.add(place, "same");
        }
        warnings.add("f", "other");
        let warnings = warnings.finish();
        assert_eq!(warnings[0].place, "a, b, c and 2 more");
        assert_eq!(warnings[1].place, "f");
        assert_eq!(warnings.len(), 2);
    }
}
