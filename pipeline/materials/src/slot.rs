//! Parameters of a kind of material.

/// One parameter of a kind.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slot {
    /// Its name in summaries and messages.
    pub name: &'static str,
    /// Its name in Mitsuba's plugin; empty where that has no such parameter.
    pub mitsuba: &'static str,
    /// Where its numbers stand.
    pub storage: Storage,
}

/// Where a parameter's numbers stand. The first four are the columns that nets know a surface by,
/// which every kind fills.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Storage {
    /// [`crate::Bsdf::base_color`].
    BaseColor,
    /// [`crate::Bsdf::roughness`].
    Roughness,
    /// [`crate::Bsdf::metallic`].
    Metallic,
    /// [`crate::Bsdf::specular`].
    Specular,
    /// `width` numbers of [`crate::Bsdf::own`] from `first` on: 1 for a number, 3 for a colour.
    Own {
        /// The first.
        first: usize,
        /// How many.
        width: usize,
    },
}

impl Slot {
    pub(crate) const fn new(name: &'static str, mitsuba: &'static str, storage: Storage) -> Slot {
        Slot {
            name,
            mitsuba,
            storage,
        }
    }
}

/// How many of the numbers in [`crate::Bsdf::own`] some slots use.
pub(crate) const fn own_numbers(slots: &[Slot]) -> usize {
    let (mut most, mut slot) = (0, 0);
    while slot < slots.len() {
        if let Storage::Own { first, width } = slots[slot].storage
            && first + width > most
        {
            most = first + width;
        }
        slot += 1;
    }
    most
}
