use super::*;
use rrf_field::columns;
use rrf_field::model::CellModel;
use rrf_field::net::Shape;
use rrf_field::tree::Tree;

const PX: usize = columns::P;
const NX: usize = columns::N;
const LX: usize = columns::L;
const EPSILON: f64 = 0.25;
/// Rounding to f32 of a few numbers of one size.
const ROUNDING: f64 = 1e-6;

/// A net that returns bias + slope · column in every channel, in f32 exact but for one rounding.
fn linear(cell: u32, bias: [f32; 3], column: usize, slope: f32) -> CellModel {
    CellModel {
        cell,
        kind: rrf_field::model::Kind::Net,
        inputs: vec![column as u8],
        input_offset: vec![0.0],
        input_scale: vec![1.0],
        shape: Shape { sizes: vec![1, 3] },
        weights: bias.iter().flat_map(|&b| [b, slope]).collect(),
        output_scale: [1.0; 3],
        output_offset: [0.0; 3],
        divide_base: false,
        exponential: false,
    }
}

fn constant(cell: u32, value: [f32; 3]) -> CellModel {
    linear(cell, value, PX, 0.0)
}

/// Every column from 0 to 1 but for those given.
fn span(but: &[(usize, f32, f32)]) -> Option<Domain> {
    let mut span = Domain {
        minimum: [0.0; COUNT],
        maximum: [1.0; COUNT],
    };
    for &(axis, min, max) in but {
        (span.minimum[axis], span.maximum[axis]) = (min, max);
    }
    Some(span)
}

/// Rows in the middle of everything but for px and lx.
fn rows(at: &[[f32; 2]]) -> Columns {
    let mut rows = Columns::default();
    for &[px, lx] in at {
        let mut row = [0.5; COUNT];
        (row[PX], row[LX]) = (px, lx);
        rows.push(row);
    }
    rows
}

/// Two cells, cut at `at` along `axis`: cell 0 below, cell 1 above.
fn two(axis: usize, at: f32, models: [CellModel; 2]) -> Field {
    let mut tree = Tree::single();
    tree.split(0, axis, at, 1);
    Field::new(tree, models.into()).unwrap()
}

fn at_faces(field: &Field, spans: &[Option<Domain>], cell: usize, rows: &Columns) -> Seams {
    let boundaries = Boundaries::new(field, spans, EPSILON);
    boundaries.discontinuity(cell, rows).unwrap()
}

fn close(found: Option<Spread>, rms: f64, median: f64) {
    let found = found.unwrap();
    for (found, wanted) in [(found.rms, rms), (found.median, median)] {
        assert!(
            (found - wanted).abs() <= ROUNDING * (1.0 + wanted),
            "{found}, not {wanted}"
        );
    }
}

/// Constants a and b jump by (a − b) / mean(a, b) from either side and change by nothing; where
/// both are dark, ε divides.
#[test]
fn constants_jump_by_their_difference() {
    let halves = [span(&[(LX, 0.0, 0.5)]), span(&[(LX, 0.5, 1.0)])];
    let near = rows(&[[0.2, 0.46], [0.7, 0.49], [0.1, 0.475]]);
    let above = rows(&[[0.2, 0.5], [0.7, 0.54]]);
    for (a, b, divisor) in [
        ([1.0, 2.0, 3.0], [2.0, 2.5, 3.5], 14.0 / 6.0),
        ([0.0, 0.125, 0.25], [0.0, 0.25, 0.25], EPSILON),
    ] {
        let field = two(LX, 0.5, [constant(0, a), constant(1, b)]);
        let squares = (0..3).map(|c| (f64::from(a[c] - b[c]) / divisor).powi(2));
        let jump = (squares.sum::<f64>() / 3.0).sqrt();
        for (cell, rows) in [(0, &near), (1, &above)] {
            let found = at_faces(&field, &halves, cell, rows);
            assert_eq!(found.rows as usize, rows.len());
            close(found.jump, jump, jump);
            close(found.change, 0.0, 0.0);
        }
    }
}

/// A net that is linear along the face's axis changes by slope · a tenth of the cell; one that is
/// linear along another column jumps by another amount at every row.
#[test]
fn linear_nets_change_by_their_slope() {
    let (slope, along) = (3.0, 2.0);
    let field = two(
        LX,
        0.5,
        [
            linear(0, [1.0; 3], LX, slope),
            linear(1, [2.0; 3], PX, along),
        ],
    );
    // cell 0 spans three quarters of its box: sizes are the rows', not the box's
    let spans = [span(&[(LX, 0.125, 0.5)]), span(&[(LX, 0.5, 1.0)])];
    let px = [0.75, 0.0, 0.125, 0.25];
    let near = rows(&px.map(|px| [px, 0.4875]));
    let found = at_faces(&field, &spans, 0, &near);
    assert_eq!(found.rows, 4);
    // at the face: 1 + 3 / 2 here, 2 + 2 px beyond; d is their mean
    let own = 1.0 + f64::from(slope) / 2.0;
    let beyond = px.map(|px| 2.0 + f64::from(along * px));
    let jumps = beyond.map(|b| (own - b).abs() / (0.5 * (own + b)));
    let changes = beyond.map(|b| f64::from(slope) * 0.1 * 0.375 / (0.5 * (own + b)));
    for (found, mut wanted) in [(found.jump, jumps), (found.change, changes)] {
        let rms = (wanted.iter().map(|x| x * x).sum::<f64>() / 4.0).sqrt();
        wanted.sort_by(f64::total_cmp);
        close(found, rms, 0.5 * (wanted[1] + wanted[2]));
    }
    // of an odd number the middle one
    let found = at_faces(
        &field,
        &spans,
        0,
        &rows(&[[0.75, 0.4875], [0.0, 0.4875], [0.125, 0.4875]]),
    );
    let mut three = [jumps[0], jumps[1], jumps[2]];
    three.sort_by(f64::total_cmp);
    assert!((found.jump.unwrap().median - three[1]).abs() < ROUNDING);
}

/// Rows count up to a tenth of the cell's size, at the nearest of the faces, on axes of p, v and l.
#[test]
fn only_rows_near_a_face_count() {
    let nets = || [constant(0, [1.0; 3]), constant(1, [2.0; 3])];
    let all = [span(&[]); 2];
    let field = two(LX, 0.5, nets());
    // spans of size 1: near is 0.4 to 0.6
    let some = rows(&[[0.5, 0.39], [0.5, 0.41], [0.5, 0.0], [0.5, 0.499]]);
    assert_eq!(at_faces(&field, &all, 0, &some).rows, 2);
    // a cut between normals has no face
    let field = two(NX, 0.55, nets());
    assert_eq!(at_faces(&field, &all, 0, &some).rows, 0);

    // a corner: each row meets the neighbour of its nearest face
    let mut tree = Tree::single();
    let [below, _] = tree.split(0, LX, 0.5, 1);
    tree.split(below, PX, 0.5, 2);
    let models = [[1.0; 3], [2.0; 3], [3.0; 3]];
    let models = (0u32..)
        .zip(models)
        .map(|(cell, value)| constant(cell, value));
    let field = Field::new(tree, models.collect()).unwrap();
    let all = [span(&[]); 3];
    let along_l = at_faces(&field, &all, 0, &rows(&[[0.45, 0.48]]));
    close(along_l.jump, 2.0 / 3.0, 2.0 / 3.0);
    let along_p = at_faces(&field, &all, 0, &rows(&[[0.48, 0.45]]));
    close(along_p.jump, 1.0, 1.0);
}

/// A face counts if the cell beyond was fitted to such rows.
#[test]
fn a_neighbour_without_such_rows_is_none() {
    let field = two(LX, 0.5, [constant(0, [1.0; 3]), constant(1, [2.0; 3])]);
    let near = rows(&[[0.5, 0.49], [0.9, 0.49]]);
    let counted = |beyond| at_faces(&field, &[span(&[]), beyond], 0, &near);
    assert_eq!(counted(span(&[])).rows, 2);
    // the slack is a twentieth of the neighbour's size and little more: 1.0501 · 0.857 < 0.9
    assert_eq!(counted(span(&[(PX, 0.0, 0.857)])).rows, 1);
    assert_eq!(counted(span(&[(PX, 0.0, 0.8572)])).rows, 2);
    // it has rows elsewhere, of another normal, or none
    for beyond in [span(&[(PX, 2.0, 3.0)]), span(&[(NX, -1.0, -0.9)]), None] {
        assert_eq!(counted(beyond), Seams::default());
    }
}

/// A cell alone, one without rows and one of a single point have no discontinuity.
#[test]
fn a_cell_alone_has_none() {
    let near = rows(&[[0.5, 0.49]]);
    let field = Field::new(Tree::single(), vec![constant(0, [1.0; 3])]).unwrap();
    assert_eq!(at_faces(&field, &[span(&[])], 0, &near), Seams::default());
    let field = two(LX, 0.5, [constant(0, [1.0; 3]), constant(1, [2.0; 3])]);
    let both = [span(&[]); 2];
    assert_eq!(
        at_faces(&field, &both, 0, &Columns::default()),
        Seams::default()
    );
    assert_eq!(at_faces(&field, &[None; 2], 0, &near), Seams::default());
    let point = [span(&[(LX, 0.49, 0.49)]), span(&[])];
    assert_eq!(at_faces(&field, &point, 0, &near), Seams::default());
}

/// Of a cut anywhere between floats, both sides stay within their cells.
#[test]
fn both_sides_of_a_face_are_in_their_cells() {
    for at in [0.0f32, -0.0, 1e-30, 0.1, -3.75, 1e6] {
        let mut tree = Tree::single();
        tree.split(0, LX, at, 1);
        let boxes = tree.domains();
        for (cell, off) in [(0usize, -1.0f32), (1, 1.0)] {
            let size = at.abs().max(1e-3);
            let span = span(&[(LX, at - size, at + size)]).unwrap();
            let mut row = [0.5; COUNT];
            row[LX] = at + off * 0.05 * size;
            let [own, beyond, within] = moved(&row, &boxes[cell], &span).unwrap();
            assert_eq!(tree.find(&own) as usize, cell, "{at}");
            assert_eq!(tree.find(&within) as usize, cell, "{at}");
            assert_ne!(tree.find(&beyond) as usize, cell, "{at}");
            assert_eq!(own[LX].max(beyond[LX]), at);
        }
    }
}
