use super::*;
use rrf_sampling::{Stage, Stream};

fn rows(n: usize) -> Columns {
    let stream = Stream::new(4, Stage::Test, 0);
    let mut rows = Columns::default();
    for r in 0..n as u64 {
        rows.push(std::array::from_fn(|c| stream.f64(r, c as u32) as f32));
    }
    rows
}

fn cut_by(rule: Rule, rows: &Columns, y: impl Fn(&[f32; columns::COUNT]) -> f32) -> Option<Cut> {
    let y: Vec<[f32; 3]> = (0..rows.len()).map(|r| [y(&rows.row(r)); 3]).collect();
    best_cut(rule, rows, [&y, &y], 1e-3, 100, true)
}

fn cut(rows: &Columns, y: impl Fn(&[f32; columns::COUNT]) -> f32) -> Option<Cut> {
    cut_by(Rule::Logarithm, rows, y)
}

/// A step in one column: cut there, and nothing is left over.
#[test]
fn cuts_at_a_step() {
    for axis in [0, 4, 7, 11] {
        let mut rows = rows(3000);
        // a gap about the step, as between two objects
        for x in &mut rows.columns[axis] {
            *x = if *x < 0.4 { *x } else { *x + 0.1 };
        }
        let cut = cut(&rows, |r| {
            // with ε = 1e-3 added, the logarithms are linear on both sides
            let log = if r[axis] < 0.45 { r[0] } else { 2.0 - r[1] };
            log.exp() - 1e-3
        })
        .unwrap();
        assert_eq!(cut.axis, axis);
        assert!((0.4..0.5).contains(&cut.threshold), "{cut:?}");
        // What the ridge leaves is 1e-8 times squared coefficients of size 1 or 2.
        assert!(
            cut.before > 1e-3 && cut.after < 1e-5 * cut.before,
            "{cut:?}"
        );
    }
}

/// A tenth of the rows beyond a gap, where no quantile is.
#[test]
fn cuts_at_the_widest_gap() {
    let mut rows = rows(3000);
    for x in &mut rows.columns[4] {
        *x = if *x < 0.1 { *x - 1.0 } else { *x };
    }
    let cut = cut(&rows, |r| if r[4] < 0.0 { 1e-3 } else { 1.0 }).unwrap();
    assert!(
        cut.axis == 4 && (-0.9..0.1).contains(&cut.threshold),
        "{cut:?}"
    );
    assert!(cut.after < 1e-5 * cut.before, "{cut:?}");
}

/// Residuals of the whole equal those of a fit by plain Gram-Schmidt on the terms.
#[test]
fn residual_equals_orthogonal_projection() {
    let mut rows = rows(500);
    rows.columns[2..columns::COUNT]
        .iter_mut()
        .for_each(|c| c.fill(0.5));
    let y = |x: f64, z: f64| 1.0 + (3.0 * x).sin() + z * z * x;
    let found = cut(&rows, |r| y(f64::from(r[0]), f64::from(r[1])) as f32).unwrap();
    let value = |r: usize| {
        let (x, z) = (f64::from(rows.columns[0][r]), f64::from(rows.columns[1][r]));
        (x, z, f64::from(y(x, z) as f32))
    };
    let mut basis: Vec<Vec<f64>> = Vec::new();
    let column = |f: fn(f64, f64, f64) -> f64| -> Vec<f64> {
        let one = |r| {
            let (x, z, y) = value(r);
            f(x, z, y)
        };
        (0..500).map(one).collect()
    };
    let terms: [fn(f64, f64, f64) -> f64; 4] = [
        |_, _, _| 1.0,
        |x, _, _| x,
        |_, z, _| z,
        |_, _, y| (y + 1e-3).ln(),
    ];
    let mut rest = Vec::new();
    for term in terms {
        let mut v = column(term);
        for _ in 0..2 {
            for b in &basis {
                let dot: f64 = b.iter().zip(&v).map(|(b, v)| b * v).sum();
                v.iter_mut().zip(b).for_each(|(v, b)| *v -= dot * b);
            }
        }
        let norm = v.iter().map(|v| v * v).sum::<f64>().sqrt();
        rest.clone_from(&v);
        basis.push(v.iter().map(|v| v / norm).collect());
    }
    let expected = rest.iter().map(|v| v * v).sum::<f64>() / 500.0;
    // the ridge adds at most its share of the coefficients' energy
    assert!(
        (found.before / expected - 1.0).abs() < 1e-2,
        "{} {expected}",
        found.before
    );
}

/// Quadratics see past what is smooth; what bends most decides for the logarithm.
#[test]
fn each_rule_finds_what_it_looks_for() {
    let mut rows = rows(3000);
    // a gap about the step: elsewhere a cut stands within a share of the rows of it
    for x in &mut rows.columns[7] {
        *x = if *x < 0.5 { *x } else { *x + 0.1 };
    }
    let bent = |r: &[f32; columns::COUNT]| 1.0 + r[0] * r[0] + if r[7] < 0.55 { 0.0 } else { r[1] };
    let found = cut_by(Rule::Relative, &rows, bent).unwrap();
    assert_eq!(found.axis, 7);
    assert!((0.5..0.6).contains(&found.threshold), "{found:?}");
    // a quadratic a side; f32 and the ridge leave something
    assert!(found.after < 1e-5 * found.before, "{found:?}");
    let steep = |r: &[f32; columns::COUNT]| (8.0 * r[3] * r[3]).exp();
    assert_eq!(cut_by(Rule::Logarithm, &rows, steep).unwrap().axis, 3);
}

#[test]
fn no_cut_of_equal_or_few_rows() {
    let mut same = Columns::default();
    (0..500).for_each(|_| same.push([0.3; columns::COUNT]));
    assert_eq!(cut(&same, |_| 1.0), None);
    assert_eq!(cut(&rows(150), |r| r[0]), None);
    assert_eq!(cut(&Columns::default(), |_| 1.0), None);
    let nan = |r: &[f32; columns::COUNT]| if r[0] > 0.1 { f32::NAN } else { 1.0 };
    assert_eq!(cut(&rows(600), nan), None);
}
