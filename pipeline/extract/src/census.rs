//! Why candidates were left out, and how many.

use serde::{Deserialize, Serialize};

/// Why a candidate was left out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rejection {
    /// It lies in another cell.
    OtherCell,
    /// The light is inside a solid.
    LightInSolid,
    /// The point is inside a solid, or sealed under one.
    PointInSolid,
    /// No eye sees the point: no frame will show it.
    Unseen,
    /// No ray of the point's hemisphere hits anything: no indirect light can arrive.
    SeesNothing,
    /// The surface reflects nothing that is learned.
    Black,
}

/// How many candidates were accepted, and how many left out for which reason.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Census {
    /// Rows accepted.
    pub accepted: u64,
    /// Candidates of a neighbouring cell.
    pub other_cell: u64,
    /// Light inside a solid.
    pub light_in_solid: u64,
    /// Point inside a solid or sealed under one.
    pub point_in_solid: u64,
    /// Points that no eye sees.
    #[serde(default)]
    pub unseen: u64,
    /// Points whose hemisphere is empty.
    pub sees_nothing: u64,
    /// Points on surfaces that reflect nothing that is learned.
    pub black: u64,
}

/// The reasons that there are: `12 on black surfaces, 3 that see nothing`.
impl std::fmt::Display for Census {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let reasons = [
            (self.light_in_solid, "lights inside solids"),
            (self.point_in_solid, "points inside solids"),
            (self.unseen, "not visible from the eye box"),
            (self.sees_nothing, "points that see nothing"),
            (self.black, "on black surfaces"),
            (self.other_cell, "outside the cell"),
        ];
        let there = reasons.iter().filter(|(count, _)| *count > 0);
        let named: Vec<String> = there.map(|(count, why)| format!("{count} {why}")).collect();
        f.write_str(&named.join(", "))
    }
}

impl Census {
    pub(crate) fn count(&mut self, why: Rejection) {
        *match why {
            Rejection::OtherCell => &mut self.other_cell,
            Rejection::LightInSolid => &mut self.light_in_solid,
            Rejection::PointInSolid => &mut self.point_in_solid,
            Rejection::Unseen => &mut self.unseen,
            Rejection::SeesNothing => &mut self.sees_nothing,
            Rejection::Black => &mut self.black,
        } += 1;
    }
}
