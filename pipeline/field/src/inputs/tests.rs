use super::*;
use crate::columns;

fn rows(light: f32) -> Columns {
    let mut rows = Columns::default();
    for r in 0..150 {
        let mut row = std::array::from_fn(|c| ((r * 31 + c * 17) as f32 * 0.37).sin());
        for l in &mut row[columns::L..columns::L + 3] {
            *l += light;
        }
        rows.push(row);
    }
    rows
}

/// A row of p, n, v, l.
fn derived(p: [f32; 3], n: [f32; 3], v: [f32; 3], l: [f32; 3]) -> [f32; COUNT - RAW] {
    let geometry: Vec<f32> = [p, n, v, l].concat();
    let all = evaluate_all(std::array::from_fn(|c| {
        geometry.get(c).copied().unwrap_or(0.5)
    }));
    std::array::from_fn(|k| all[RAW + k])
}

#[test]
fn derived_inputs_follow_their_definitions() {
    // p at the origin, n = z, v at 45 degrees towards x; the light straight in v's mirror
    // direction at distance 2: d = (-1, 0, 1)/sqrt(2), mirror cosine 1.
    let h = 0.5f32.sqrt();
    let (n, v, l) = ([0.0, 0.0, 1.0], [h, 0.0, h], [-2.0 * h, 0.0, 2.0 * h]);
    let want = [-h, 0.0, h, 0.5, 1.0, h, h];
    for (got, want) in derived([0.0; 3], n, v, l).iter().zip(want) {
        assert!((got - want).abs() < 4.0 * f32::EPSILON, "{got} {want}");
    }
}

#[test]
fn a_light_on_the_point_gives_finite_inputs() {
    let z = [0.0, 0.0, 1.0];
    let want = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0];
    assert_eq!(derived([1.0; 3], z, z, [1.0; 3]), want);
}

#[test]
fn light_dependence_is_what_the_values_do() {
    let (here, there) = (rows(0.0), rows(1.0));
    let (mut a, mut b) = (Vec::new(), Vec::new());
    for input in 0..COUNT as u8 {
        fill(input, &here, &mut a);
        fill(input, &there, &mut b);
        assert_eq!(a.len(), here.len());
        assert_eq!(
            a != b,
            depends_on_light(input),
            "{}",
            NAMES[usize::from(input)]
        );
    }
}

/// The inputs of one row, written out: the order of every sum and product is part of a run's bits.
fn written_out(row: [f32; RAW]) -> Vec<f32> {
    let dot = |a: &[f32], b: &[f32]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let (p, n, v, l) = (&row[0..3], &row[3..6], &row[6..9], &row[9..12]);
    let to = [l[0] - p[0], l[1] - p[1], l[2] - p[2]];
    let distance = dot(&to, &to).sqrt();
    let inverse = if distance > 0.0 { 1.0 / distance } else { 0.0 };
    let d = to.map(|x| x * inverse);
    let (n_d, n_v, v_d) = (dot(n, &d), dot(n, v), dot(v, &d));
    let derived = [inverse, 2.0 * n_v * n_d - v_d, n_d, n_v];
    [row.as_slice(), &d, &derived].concat()
}

#[test]
fn columns_and_single_rows_have_the_same_bits() {
    let rows = rows(0.3);
    let mut column = Vec::new();
    for input in 0..COUNT as u8 {
        fill(input, &rows, &mut column);
        for (r, got) in column.iter().enumerate() {
            let row = rows.row(r);
            let single = evaluate_all(row)[usize::from(input)];
            let wanted = written_out(row)[usize::from(input)];
            assert_eq!([got.to_bits(), single.to_bits()], [wanted.to_bits(); 2]);
        }
    }
}

#[test]
fn an_input_comes_after_what_it_reads() {
    let all: Vec<u8> = (0..COUNT as u8).collect();
    let order = derivation(&all);
    assert_eq!(order.len(), COUNT - RAW);
    for (k, &input) in order.iter().enumerate() {
        let mut read = reads(input)
            .iter()
            .filter(|&i| i >= RAW && i != usize::from(input));
        assert!(read.all(|i| order[..k].contains(&(i as u8))), "{input}");
    }
    let inv_distance = place("inv_distance").unwrap();
    assert_eq!(
        derivation(&[0, place("dx").unwrap()]),
        [inv_distance, place("dx").unwrap()]
    );
}

/// What Python reads is what is computed here; `RRF_WRITE=1` writes it.
#[test]
fn the_schema_is_as_here() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../schemas/inputs.toml");
    if std::env::var_os("RRF_WRITE").is_some() {
        std::fs::write(path, toml()).unwrap();
    }
    assert_eq!(std::fs::read_to_string(path).unwrap(), toml());
}
