//! Dual numbers: a value and its derivatives by up to [`N`] parameters, exact to rounding.

use std::ops::{Add, Div, Mul, Neg, Sub};

/// Most parameters.
pub const N: usize = 12;

#[derive(Clone, Copy, Debug)]
pub struct Dual {
    pub v: f64,
    pub d: [f64; N],
}

impl Dual {
    pub fn parameter(v: f64, place: usize) -> Dual {
        let mut d = [0.0; N];
        d[place] = 1.0;
        Dual { v, d }
    }

    /// f(self) with f's value and slope.
    fn chain(self, v: f64, slope: f64) -> Dual {
        Dual {
            v,
            d: self.d.map(|d| d * slope),
        }
    }

    pub fn exp(self) -> Dual {
        let e = self.v.exp();
        self.chain(e, e)
    }

    pub fn ln(self) -> Dual {
        self.chain(self.v.ln(), 1.0 / self.v)
    }

    pub fn sin(self) -> Dual {
        self.chain(self.v.sin(), self.v.cos())
    }

    pub fn cos(self) -> Dual {
        self.chain(self.v.cos(), -self.v.sin())
    }

    pub fn atan(self) -> Dual {
        self.chain(self.v.atan(), 1.0 / (1.0 + self.v * self.v))
    }

    pub fn sqrt(self) -> Dual {
        let s = self.v.sqrt();
        self.chain(s, 0.5 / s)
    }

    pub fn square(self) -> Dual {
        self.chain(self.v * self.v, 2.0 * self.v)
    }

    /// self to a power that is a parameter too.
    pub fn pow(self, power: Dual) -> Dual {
        (power * self.ln()).exp()
    }
}

impl From<f64> for Dual {
    fn from(v: f64) -> Dual {
        Dual { v, d: [0.0; N] }
    }
}

fn both(a: Dual, b: Dual, v: f64, wa: f64, wb: f64) -> Dual {
    Dual {
        v,
        d: std::array::from_fn(|i| wa * a.d[i] + wb * b.d[i]),
    }
}

impl Neg for Dual {
    type Output = Dual;
    fn neg(self) -> Dual {
        self.chain(-self.v, -1.0)
    }
}

macro_rules! operator {
    ($trait:ident, $name:ident, $a:ident, $b:ident, $v:expr, $wa:expr, $wb:expr) => {
        impl $trait for Dual {
            type Output = Dual;
            fn $name(self, other: Dual) -> Dual {
                let ($a, $b) = (self.v, other.v);
                both(self, other, $v, $wa, $wb)
            }
        }
        impl $trait<f64> for Dual {
            type Output = Dual;
            fn $name(self, other: f64) -> Dual {
                $trait::$name(self, Dual::from(other))
            }
        }
        impl $trait<Dual> for f64 {
            type Output = Dual;
            fn $name(self, other: Dual) -> Dual {
                $trait::$name(Dual::from(self), other)
            }
        }
    };
}

operator!(Add, add, a, b, a + b, 1.0, 1.0);
operator!(Sub, sub, a, b, a - b, 1.0, -1.0);
operator!(Mul, mul, a, b, a * b, b, a);
operator!(Div, div, a, b, a / b, 1.0 / b, -a / (b * b));
