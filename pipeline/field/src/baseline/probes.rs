//! A grid of irradiance probes, one set for each of a grid of light positions: spherical harmonics of
//! the normal up to the second order (Ramamoorthi, Hanrahan 2001), trilinear in place and light
//! (Greger et al. 1998).

/// Inputs: place, normal, light position.
pub const INPUTS: usize = 9;
/// Harmonics up to the second order.
pub const HARMONICS: usize = 9;
/// Probes times lights that a row lies between.
pub const AROUND: usize = 64;

/// Probes and light positions an axis, at least two.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Grid {
    /// Probes an axis.
    pub places: usize,
    /// Light positions an axis.
    pub lights: usize,
}

impl Grid {
    /// How many coefficients a channel has; none where too many to be counted, or a grid is too small.
    pub fn coefficients(self) -> Option<usize> {
        let cube = |n: usize| n.checked_mul(n)?.checked_mul(n);
        let all = cube(self.places)?.checked_mul(cube(self.lights)?)?;
        let large = self.places.min(self.lights) >= 2;
        all.checked_mul(HARMONICS).filter(|_| large)
    }

    /// What a row takes from where: `x` is place (in steps of the grid), normal, light position (in
    /// steps of its grid). Places beyond a grid count as on its border.
    pub fn basis(self, x: [f64; INPUTS]) -> Basis {
        let [px, py, pz, nx, ny, nz, lx, ly, lz] = x;
        let (places, shares) = corners([px, py, pz], self.places);
        let (lights, light_shares) = corners([lx, ly, lz], self.lights);
        let each = self.lights.pow(3);
        Basis {
            first: std::array::from_fn(|k| (places[k / 8] * each + lights[k % 8]) * HARMONICS),
            share: std::array::from_fn(|k| shares[k / 8] * light_shares[k % 8]),
            harmonics: harmonics([nx, ny, nz]),
        }
    }
}

/// The coefficients of a row: at `first[k] + h` with weight `share[k] * harmonics[h]`.
#[derive(Clone, Copy, Debug)]
pub struct Basis {
    /// First coefficient of each probe and light.
    pub first: [usize; AROUND],
    /// Trilinear shares, of sum 1.
    pub share: [f64; AROUND],
    /// Harmonics of the normal.
    pub harmonics: [f64; HARMONICS],
}

/// The eight grid points around a place, x slowest, and their trilinear shares.
pub fn corners(x: [f64; 3], count: usize) -> ([usize; 8], [f64; 8]) {
    let last = count - 1;
    let at = x.map(|x| x.clamp(0.0, last as f64));
    let low = at.map(|x| (x as usize).min(last - 1));
    let share: [f64; 3] = std::array::from_fn(|axis| at[axis] - low[axis] as f64);
    let side = |k: usize, axis: usize| (k >> (2 - axis)) & 1;
    let id = |k: usize| (0..3).fold(0, |id, axis| id * count + low[axis] + side(k, axis));
    let weight = |k: usize| -> f64 {
        let of = |axis: usize| match side(k, axis) {
            0 => 1.0 - share[axis],
            _ => share[axis],
        };
        of(0) * of(1) * of(2)
    };
    (std::array::from_fn(id), std::array::from_fn(weight))
}

/// Real spherical harmonics of a unit vector, orthonormal over the sphere: 1; y, z, x; xy, yz,
/// 3z² − 1, xz, x² − y², each times its constant.
pub fn harmonics([x, y, z]: [f64; 3]) -> [f64; HARMONICS] {
    let pi = std::f64::consts::PI;
    let (zero, one) = ((0.25 / pi).sqrt(), (0.75 / pi).sqrt());
    let two = (3.75 / pi).sqrt();
    [
        zero,
        one * y,
        one * z,
        one * x,
        two * x * y,
        two * y * z,
        two / 12f64.sqrt() * (3.0 * z * z - 1.0),
        two * x * z,
        0.5 * two * (x * x - y * y),
    ]
}

/// Probes with their coefficients.
#[derive(Clone, Debug)]
pub struct Probes {
    grid: Grid,
    /// Red, green, blue of each coefficient; probes, lights (of both x slowest), harmonics.
    weights: Vec<[f32; 3]>,
}

impl Probes {
    /// Of a grid and its coefficients, three channels side by side.
    pub fn new(grid: Grid, weights: &[f32]) -> Probes {
        let weights = weights.as_chunks().0.to_vec();
        Probes { grid, weights }
    }

    /// The probes' answer at `x`, as [`Grid::basis`] takes it.
    pub fn answer(&self, x: &[f32]) -> [f64; 3] {
        let at = |i: usize| f64::from(x.get(i).copied().unwrap_or_default());
        let basis = self.grid.basis(std::array::from_fn(at));
        let mut sum = [0.0; 3];
        for (&first, share) in basis.first.iter().zip(basis.share) {
            let weights = &self.weights[first..][..HARMONICS];
            for (weights, harmonic) in weights.iter().zip(basis.harmonics) {
                for (sum, weight) in sum.iter_mut().zip(weights) {
                    *sum += share * harmonic * f64::from(*weight);
                }
            }
        }
        sum
    }
}
