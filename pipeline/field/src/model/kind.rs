//! What a cell's weights are of.

use crate::baseline::{probes, quadratic};
use serde::{Deserialize, Serialize};

/// A net, or a baseline that nets are compared with. All but nets stand where a net stands: scaled
/// inputs in, three outputs out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Kind {
    /// A net, see [`crate::net`].
    #[default]
    Net,
    /// Polynomials of the second degree. Layers `[inputs, 3]`; weights: channel after channel the
    /// coefficients of the terms, in the order of [`quadratic::terms`].
    Quadratic,
    /// The nearest of the rows trained on. Layers `[inputs, rows, 3]`; weights: the rows' scaled
    /// inputs, row after row, then their outputs. The answer is the mean of the eight nearest rows'
    /// outputs weighted by inverse squared distance; of rows at distance 0 their mean.
    Nearest,
    /// A grid of irradiance probes, see [`probes::Grid`]. Layers `[9, probes an axis, light positions an
    /// axis, 3]`; weights: the three channels of each coefficient side by side; probes, light
    /// positions (of both x slowest), harmonics.
    Probes,
}

/// Every kind.
pub const MODEL_KINDS: [Kind; 4] = [Kind::Net, Kind::Quadratic, Kind::Nearest, Kind::Probes];

impl Kind {
    /// As the weights table writes it.
    pub fn name(self) -> &'static str {
        match self {
            Kind::Net => "net",
            Kind::Quadratic => "quadratic",
            Kind::Nearest => "nearest",
            Kind::Probes => "probes",
        }
    }

    /// The kind of this name.
    pub fn of_name(name: &str) -> Option<Kind> {
        MODEL_KINDS.into_iter().find(|kind| kind.name() == name)
    }

    /// Whether it is a net.
    pub fn is_net(&self) -> bool {
        *self == Kind::Net
    }

    /// How many weights belong to these layers; none where they are not such a model's or too large
    /// to be counted.
    pub fn weights(self, layers: &[usize]) -> Option<usize> {
        match (self, layers) {
            (Kind::Net, [_, .., 3]) if !layers[1..].contains(&0) => {
                layers.windows(2).try_fold(0usize, |sum, pair| {
                    sum.checked_add(pair[0].checked_add(1)?.checked_mul(pair[1])?)
                })
            }
            (Kind::Quadratic, [inputs, 3]) => quadratic::count(*inputs)?.checked_mul(3),
            (Kind::Nearest, [inputs, rows, 3]) if (1..u32::MAX as usize).contains(rows) => {
                inputs.checked_add(3)?.checked_mul(*rows)
            }
            (Kind::Probes, &[probes::INPUTS, places, lights, 3]) => probes::Grid { places, lights }
                .coefficients()?
                .checked_mul(3),
            _ => None,
        }
    }
}
