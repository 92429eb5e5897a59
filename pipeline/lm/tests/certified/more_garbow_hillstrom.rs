//! Problems of Moré, Garbow, Hillstrom, *Testing unconstrained optimization software*,
//! ACM TOMS 7(1), 1981: starts, and sums of squares at the minimum, as the paper states them.

use crate::dual::Dual;
use rrf_lm::{Dense, LmConfig, Residuals, Scaling, minimise};

type Function = fn(&[Dual]) -> Vec<Dual>;

struct Case {
    name: &'static str,
    function: Function,
    start: &'static [f64],
    /// Sums of squares at the minima and along the valleys to infinity that the paper names;
    /// 0 stands for an exact zero.
    minima: &'static [f64],
}

const CASES: [Case; 14] = [
    case("Rosenbrock", rosenbrock, &[-1.2, 1.0], &[0.0]),
    case(
        "Freudenstein-Roth",
        freudenstein_roth,
        &[0.5, -2.0],
        &[0.0, 48.984_253_679],
    ),
    // The second sum is approached where x1 grows without end and x1 (1 - x2) = a stays:
    // residuals 1.5 - a, 2.25 - 2a, 2.625 - 3a, least at 14.203125 - 13.875^2 / 14.
    case("Beale", beale, &[1.0, 1.0], &[0.0, 0.452_008_929]),
    case("helical valley", helical_valley, &[-1.0, 0.0, 0.0], &[0.0]),
    case(
        "Bard",
        bard,
        &[1.0, 1.0, 1.0],
        &[8.214_877_306e-3, 17.428_693_333],
    ),
    case("Meyer", meyer, &[0.02, 4000.0, 250.0], &[87.945_855_171]),
    case(
        "Powell singular",
        powell_singular,
        &[3.0, -1.0, 0.0, 1.0],
        &[0.0],
    ),
    case(
        "Kowalik-Osborne",
        kowalik_osborne,
        &[0.25, 0.39, 0.415, 0.39],
        &[3.075_056_038e-4, 1.027_34e-3],
    ),
    case("Watson 6", watson, &[0.0; 6], &[2.287_670_053e-3]),
    case("Watson 9", watson, &[0.0; 9], &[1.399_760_138e-6]),
    case("Watson 12", watson, &[0.0; 12], &[4.722_381_1e-10]),
    case("linear, full rank", linear_full_rank, &[1.0; 5], &[5.0]),
    case("linear, rank 1", linear_rank_1, &[1.0; 5], &[2.142_857_143]),
    case(
        "linear, rank 1, zero columns and rows",
        linear_zero_columns,
        &[1.0; 5],
        &[3.647_058_824],
    ),
];

const fn case(
    name: &'static str,
    function: Function,
    start: &'static [f64],
    minima: &'static [f64],
) -> Case {
    Case {
        name,
        function,
        start,
        minima,
    }
}

fn rosenbrock(x: &[Dual]) -> Vec<Dual> {
    vec![10.0 * (x[1] - x[0].square()), 1.0 - x[0]]
}

fn freudenstein_roth(x: &[Dual]) -> Vec<Dual> {
    let (a, b) = (x[0], x[1]);
    vec![
        a - 13.0 + ((5.0 - b) * b - 2.0) * b,
        a - 29.0 + ((b + 1.0) * b - 14.0) * b,
    ]
}

fn beale(x: &[Dual]) -> Vec<Dual> {
    let y = [1.5, 2.25, 2.625];
    let mut power = Dual::from(1.0);
    y.map(|y| {
        power = power * x[1];
        y - x[0] * (1.0 - power)
    })
    .to_vec()
}

fn helical_valley(x: &[Dual]) -> Vec<Dual> {
    let turn = (x[1] / x[0]).atan() / std::f64::consts::TAU;
    let theta = if x[0].v > 0.0 { turn } else { turn + 0.5 };
    vec![
        10.0 * (x[2] - 10.0 * theta),
        10.0 * ((x[0].square() + x[1].square()).sqrt() - 1.0),
        x[2],
    ]
}

fn bard(x: &[Dual]) -> Vec<Dual> {
    let y = [
        0.14, 0.18, 0.22, 0.25, 0.29, 0.32, 0.35, 0.39, 0.37, 0.58, 0.73, 0.96, 1.34, 2.10, 4.39,
    ];
    (0..15)
        .map(|i| {
            let (u, v) = (i as f64 + 1.0, 15.0 - i as f64);
            y[i] - (x[0] + u / (v * x[1] + u.min(v) * x[2]))
        })
        .collect()
}

fn meyer(x: &[Dual]) -> Vec<Dual> {
    let y = [
        34_780.0, 28_610.0, 23_650.0, 19_630.0, 16_370.0, 13_720.0, 11_540.0, 9_744.0, 8_261.0,
        7_030.0, 6_005.0, 5_147.0, 4_427.0, 3_820.0, 3_307.0, 2_872.0,
    ];
    (0..16)
        .map(|i| {
            let t = 45.0 + 5.0 * (i as f64 + 1.0);
            x[0] * (x[1] / (t + x[2])).exp() - y[i]
        })
        .collect()
}

fn powell_singular(x: &[Dual]) -> Vec<Dual> {
    vec![
        x[0] + 10.0 * x[1],
        5f64.sqrt() * (x[2] - x[3]),
        (x[1] - 2.0 * x[2]).square(),
        10f64.sqrt() * (x[0] - x[3]).square(),
    ]
}

fn kowalik_osborne(x: &[Dual]) -> Vec<Dual> {
    let y = [
        0.1957, 0.1947, 0.1735, 0.1600, 0.0844, 0.0627, 0.0456, 0.0342, 0.0323, 0.0235, 0.0246,
    ];
    let u = [
        4.0, 2.0, 1.0, 0.5, 0.25, 0.167, 0.125, 0.1, 0.0833, 0.0714, 0.0625,
    ];
    (y.iter().zip(u))
        .map(|(y, u)| *y - x[0] * (u * u + u * x[1]) / (u * u + u * x[2] + x[3]))
        .collect()
}

fn watson(x: &[Dual]) -> Vec<Dual> {
    let zero = Dual::from(0.0);
    let mut r: Vec<Dual> = (1..=29)
        .map(|i| {
            let t = f64::from(i) / 29.0;
            let (mut slope, mut value) = (zero, zero);
            for (j, x) in x.iter().enumerate() {
                if j > 0 {
                    slope = slope + j as f64 * t.powi(j as i32 - 1) * *x;
                }
                value = value + t.powi(j as i32) * *x;
            }
            slope - value.square() - 1.0
        })
        .collect();
    r.extend([x[0], x[1] - x[0].square() - 1.0]);
    r
}

/// m = 10 residuals for n = 5 parameters.
const LINEAR: usize = 10;

fn linear_full_rank(x: &[Dual]) -> Vec<Dual> {
    let sum = x.iter().fold(Dual::from(0.0), |s, x| s + *x);
    (0..LINEAR)
        .map(|i| {
            let rest = -2.0 / LINEAR as f64 * sum - 1.0;
            x.get(i).map_or(rest, |x| rest + *x)
        })
        .collect()
}

fn linear_rank_1(x: &[Dual]) -> Vec<Dual> {
    let sum = (x.iter().enumerate()).fold(Dual::from(0.0), |s, (j, x)| s + (j + 1) as f64 * *x);
    (1..=LINEAR).map(|i| i as f64 * sum - 1.0).collect()
}

fn linear_zero_columns(x: &[Dual]) -> Vec<Dual> {
    let inner = 1..x.len() - 1;
    let sum = inner.fold(Dual::from(0.0), |s, j| s + (j + 1) as f64 * x[j]);
    let first_and_last = Dual::from(-1.0);
    (0..LINEAR)
        .map(|i| match i {
            0 => first_and_last,
            i if i == LINEAR - 1 => first_and_last,
            i => i as f64 * sum - 1.0,
        })
        .collect()
}

impl Residuals for &Case {
    fn parameters(&self) -> usize {
        self.start.len()
    }

    fn residuals(&self) -> usize {
        self.at(self.start).len()
    }

    fn evaluate(&self, w: &[f64], r: &mut [f64]) {
        for (r, value) in r.iter_mut().zip(self.at(w)) {
            *r = value.v;
        }
    }

    fn jacobian(&self, w: &[f64], j: &mut [f64]) {
        for (row, value) in j.chunks_exact_mut(w.len()).zip(self.at(w)) {
            row.copy_from_slice(&value.d[..w.len()]);
        }
    }
}

impl Case {
    fn at(&self, w: &[f64]) -> Vec<Dual> {
        let x: Vec<Dual> = (w.iter().enumerate())
            .map(|(i, v)| Dual::parameter(*v, i))
            .collect();
        (self.function)(&x)
    }
}

/// Every problem ends at a minimum that the paper names, from the standard start and from ten
/// times it, under every scaling. The stated sums have 6 to 10 digits: 1e-5 relative.
#[test]
fn sums_of_squares() {
    let mut failed = Vec::new();
    let scalings = [
        Scaling::More,
        Scaling::Clamped { floor: 1e-12 },
        Scaling::Identity,
    ];
    for case in &CASES {
        for (times, scaling) in [1.0, 10.0]
            .into_iter()
            .flat_map(|t| scalings.map(|s| (t, s)))
        {
            let config = LmConfig {
                scaling,
                ..LmConfig::exact()
            };
            let mut w: Vec<f64> = case.start.iter().map(|x| times * x).collect();
            let outcome = minimise(&mut Dense::new(case), &mut w, 0.0, config, 2_000);
            let fits = |minimum: &f64| {
                let tolerance = if *minimum == 0.0 {
                    1e-20
                } else {
                    1e-5 * minimum
                };
                (outcome.cost - minimum).abs() <= tolerance
            };
            let found = case.minima.iter().any(fits);
            println!(
                "{:38} x{times:2} {:22} {:.9e} {:5} steps {:?}{}",
                case.name,
                format!("{scaling:?}"),
                outcome.cost,
                outcome.iterations,
                outcome.termination,
                if found { "" } else { "  NOT A MINIMUM" }
            );
            if !found {
                failed.push((case.name, times, scaling));
            }
        }
    }
    assert!(failed.is_empty(), "{failed:?}");
}
