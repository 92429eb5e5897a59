//! Separable convolution of planes, edges repeated.

/// One channel of a picture, row-major.
#[derive(Clone, Debug)]
pub struct Plane {
    /// Pixels a row.
    pub width: usize,
    /// All pixels.
    pub values: Vec<f64>,
}

/// A one-dimensional filter of odd length, centred.
#[derive(Clone, Debug)]
pub struct Kernel {
    weights: Vec<f64>,
}

impl Kernel {
    /// `weight(x)` at x = −radius ... radius.
    pub fn new(radius: usize, weight: impl Fn(f64) -> f64) -> Kernel {
        let radius = radius as i64;
        Kernel {
            weights: (-radius..=radius).map(|x| weight(x as f64)).collect(),
        }
    }

    /// Sum of the weights.
    pub fn sum(&self) -> f64 {
        self.weights.iter().sum()
    }

    /// Scaled to a sum of 1.
    pub fn normalized(&self) -> Kernel {
        let sum = self.sum();
        Kernel {
            weights: self.weights.iter().map(|w| w / sum).collect(),
        }
    }

    /// Positive weights scaled to a sum of 1, negative ones to −1.
    pub fn normalized_by_sign(&self) -> Kernel {
        let sum = |sign: f64| -> f64 {
            let part = self.weights.iter().filter(|w| sign * **w > 0.0);
            part.sum::<f64>().abs()
        };
        let (positive, negative) = (sum(1.0), sum(-1.0));
        let scale = |&w: &f64| w / if w > 0.0 { positive } else { negative };
        Kernel {
            weights: self.weights.iter().map(scale).collect(),
        }
    }
}

/// `plane` filtered by `horizontal` along rows and `vertical` along columns.
/// out(x) = Σ_k weight(k) in(x + k): correlation; symmetric and odd filters differ at most in sign.
pub fn convolve(plane: &Plane, horizontal: &Kernel, vertical: &Kernel) -> Plane {
    // Each pass turns the picture, so that both run along rows; twice turned is upright.
    turned_pass(&turned_pass(plane, horizontal), vertical)
}

/// Filters along rows and transposes.
fn turned_pass(plane: &Plane, kernel: &Kernel) -> Plane {
    let (width, height) = (plane.width, plane.values.len() / plane.width.max(1));
    let radius = kernel.weights.len() / 2;
    let mut out = vec![0.0; plane.values.len()];
    let mut padded = vec![0.0; width + 2 * radius];
    for (y, row) in plane.values.chunks_exact(width.max(1)).enumerate() {
        padded[..radius].fill(row[0]);
        padded[radius..radius + width].copy_from_slice(row);
        padded[radius + width..].fill(row[width - 1]);
        for (x, window) in padded.windows(kernel.weights.len()).enumerate() {
            out[x * height + y] = window.iter().zip(&kernel.weights).map(|(a, w)| a * w).sum();
        }
    }
    Plane {
        width: height,
        values: out,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equals_the_double_sum() {
        let (width, height) = (7usize, 5usize);
        let value = |x: i64, y: i64| {
            let x = x.clamp(0, width as i64 - 1) as f64;
            let y = y.clamp(0, height as i64 - 1) as f64;
            (1.3 * x + 0.7 * y * y).sin()
        };
        let plane = Plane {
            width,
            values: (0..width * height)
                .map(|i| value((i % width) as i64, (i / width) as i64))
                .collect(),
        };
        let h = Kernel::new(3, |x| 1.0 + 0.3 * x);
        let v = Kernel::new(1, |x| 0.5 - x * x);
        let got = convolve(&plane, &h, &v);
        for y in 0..height as i64 {
            for x in 0..width as i64 {
                let mut sum = 0.0;
                for j in -1..=1i64 {
                    for i in -3..=3i64 {
                        sum +=
                            (1.0 + 0.3 * i as f64) * (0.5 - (j * j) as f64) * value(x + i, y + j);
                    }
                }
                let got = got.values[y as usize * width + x as usize];
                assert!((got - sum).abs() < 1e-12 * 40.0, "{got} {sum}");
            }
        }
    }
}
