//! A cell's read of a light, by clusters of columns.

use super::directions::relative_weights;
use super::lighting::Lighting;
use crate::columns::ColumnTree;
use crate::model::{LightRead, PackedRows};
use crate::tracing::Stream;
use glam::Vec3;
use multiversion::multiversion;

/// Random combinations of the directions that clusters are judged by.
const COMBINATIONS: usize = 4;

/// No column of the node is read.
const UNREAD: u32 = u32::MAX;

/// A dense read: what 1 W/m^2 on a column adds to each direction.
pub(crate) struct DenseRead {
    pub(crate) rank: usize,
    /// Shape [columns, rank], row-major.
    pub(crate) weights: Vec<f32>,
}

impl DenseRead {
    /// Some of its directions.
    pub(crate) fn only(&self, kept: &[usize]) -> DenseRead {
        let rows = self.weights.chunks_exact(self.rank.max(1));
        let of_row = |row: &[f32]| -> Vec<f32> { kept.iter().map(|&k| row[k]).collect() };
        DenseRead {
            rank: kept.len(),
            weights: rows.flat_map(of_row).collect(),
        }
    }

    /// What it makes of each light that judges.
    pub(crate) fn judging(&self, lighting: &Lighting) -> Vec<Vec<Vec3>> {
        let width = 3 * lighting.judges.len();
        let mut sums = vec![0.0f32; self.rank * width];
        let rows = self.weights.chunks_exact(self.rank.max(1)).enumerate();
        for (column, row) in rows.filter(|(_, row)| row.iter().any(|&w| w != 0.0)) {
            add_products(row, lighting.judges_on(column), &mut sums);
        }
        let of = |judge: usize, k: usize| Vec3::from_slice(&sums[k * width + 3 * judge..]);
        (0..lighting.judges.len())
            .map(|judge| (0..self.rank).map(|k| of(judge, k)).collect())
            .collect()
    }
}

/// Adds the products of two vectors to a matrix.
#[multiversion(targets("x86_64+avx+avx2+fma+avx512f+avx512vl", "x86_64+avx+avx2+fma"))]
fn add_products(left: &[f32], right: &[f32], sums: &mut [f32]) {
    for (w, sums) in left.iter().zip(sums.chunks_exact_mut(right.len().max(1))) {
        sums.iter_mut().zip(right).for_each(|(s, x)| *s += w * x);
    }
}

/// An open node: what it gets wrong of some lights, and the sum of its squares.
struct Open {
    wrong: Vec<f32>,
    error: f64,
    node: u32,
}

/// Clusters of columns that leave out at most `target` of what a dense read makes of the
/// ensemble's lights, relative to what it makes of each: the worst cluster is opened until that holds, or `most` are open.
///
/// Neighbouring clusters err alike, so that their errors add up: both the sum of their squares and
/// the square of their sum have to be small.
pub(crate) fn clustered(
    read: &DenseRead,
    tree: &ColumnTree,
    lighting: &Lighting,
    target: f64,
    most: usize,
    stream: Stream,
) -> LightRead {
    let judge = Judge::new(read, tree, lighting, stream);
    let whole = judge.energy();
    if tree.is_empty() || whole <= 0.0 {
        return LightRead {
            nodes: Vec::new(),
            weights: PackedRows::pack(&[], read.rank),
        };
    }
    let mut closed = Vec::new();
    let mut open = vec![judge.open(0)];
    let mut wrong = open[0].wrong.clone();
    let mut error = open[0].error;
    let allowed = target * target * whole;
    while (error > allowed || judge.squares(&wrong) > allowed) && open.len() + closed.len() < most {
        let Some(worst) = take_worst(&mut open) else {
            break;
        };
        let Some(children) = tree.children(worst.node) else {
            closed.push(worst.node);
            continue;
        };
        error -= worst.error;
        add(&mut wrong, &worst.wrong, -1.0);
        for node in children.into_iter().filter(|&node| judge.is_read(node)) {
            let own = judge.open(node);
            error += own.error;
            add(&mut wrong, &own.wrong, 1.0);
            open.push(own);
        }
    }
    closed.extend(open.iter().map(|open| open.node));
    closed.sort_unstable();
    let weights = closed.iter().flat_map(|&node| judge.weights(node));
    let weights: Vec<f32> = weights.collect();
    LightRead {
        weights: PackedRows::pack(&weights, read.rank),
        nodes: closed,
    }
}

/// The open node with the largest error; the first of equals.
fn take_worst(open: &mut Vec<Open>) -> Option<Open> {
    let worst = (0..open.len()).fold(None, |best: Option<usize>, i| match best {
        Some(b) if open[b].error >= open[i].error => Some(b),
        _ => Some(i),
    })?;
    (open[worst].error > 0.0).then(|| open.remove(worst))
}

fn add(sum: &mut [f32], of: &[f32], by: f32) {
    sum.iter_mut().zip(of).for_each(|(s, x)| *s += by * x);
}

struct Judge<'a> {
    read: &'a DenseRead,
    tree: &'a ColumnTree,
    lighting: &'a Lighting,
    /// Combinations of each column's weights, shape [columns, combinations].
    combined: Vec<f32>,
    /// Place of each node that is read in `made`; [`UNREAD`] of others.
    places: Vec<u32>,
    /// Answers of those nodes' columns to some lights, shape [nodes, combinations, some].
    made: Vec<f32>,
    /// Weights of some lights' errors.
    weights: Vec<f64>,
}

impl<'a> Judge<'a> {
    fn new(
        read: &'a DenseRead,
        tree: &'a ColumnTree,
        lighting: &'a Lighting,
        stream: Stream,
    ) -> Judge<'a> {
        let sign = |k: usize, c: usize| {
            let word = stream.block(k as u64, c as u32, 0)[0];
            if word & 1 == 0 { 1.0f32 } else { -1.0 }
        };
        let signs: Vec<f32> = (0..read.rank * COMBINATIONS)
            .map(|i| sign(i / COMBINATIONS, i % COMBINATIONS))
            .collect();
        let mut combined = vec![0.0f32; tree.columns() * COMBINATIONS];
        let rows = read.weights.chunks_exact(read.rank.max(1));
        for (out, row) in combined.chunks_exact_mut(COMBINATIONS).zip(rows) {
            if row.iter().all(|&w| w == 0.0) {
                continue;
            }
            for (w, signs) in row.iter().zip(signs.chunks_exact(COMBINATIONS)) {
                out.iter_mut().zip(signs).for_each(|(o, s)| *o += w * s);
            }
        }
        let mut judge = Judge {
            read,
            tree,
            lighting,
            combined,
            places: vec![UNREAD; tree.len()],
            made: Vec::new(),
            weights: vec![1.0; lighting.some.len()],
        };
        judge.answer();
        let whole = judge.made(0);
        let lights = 0..lighting.some.len();
        let gives: Vec<f64> = lights.map(|l| judge.square(&whole, l)).collect();
        judge.weights = relative_weights(&gives);
        judge
    }

    /// Answers of all nodes that are read, children before their parents.
    fn answer(&mut self) {
        let some = self.lighting.some.len();
        let width = COMBINATIONS * some;
        for node in (0..self.tree.len() as u32).rev() {
            let place = self.made.len();
            match self.tree.children(node) {
                Some(children) => {
                    let of = children.map(|child| self.places[child as usize]);
                    let read = of.iter().filter(|&&place| place != UNREAD);
                    for (count, &child) in read.enumerate() {
                        let first = child as usize * width;
                        if count == 0 {
                            self.made.extend_from_within(first..first + width);
                        } else {
                            let (before, own) = self.made.split_at_mut(place);
                            add(own, &before[first..first + width], 1.0);
                        }
                    }
                }
                None => {
                    let Some(&column) = self.tree.columns_of(node).first() else {
                        continue;
                    };
                    let first = column as usize * COMBINATIONS;
                    let own = &self.combined[first..first + COMBINATIONS];
                    if own.iter().any(|&w| w != 0.0) {
                        let e = self.lighting.some_on(column);
                        let made = own.iter().flat_map(|w| e.iter().map(move |e| w * e));
                        self.made.extend(made);
                    }
                }
            }
            if self.made.len() > place {
                self.places[node as usize] = (place / width.max(1)) as u32;
            }
        }
    }

    fn is_read(&self, node: u32) -> bool {
        self.places[node as usize] != UNREAD
    }

    /// Answers of a node's columns to some lights, for each combination: shape [combinations, some].
    fn made(&self, node: u32) -> Vec<f32> {
        let width = COMBINATIONS * self.lighting.some.len();
        match self.places[node as usize] {
            UNREAD => vec![0.0; width],
            place => self.made[place as usize * width..(place as usize + 1) * width].to_vec(),
        }
    }

    /// The weighted sum of squares that all columns make, a combination.
    fn energy(&self) -> f64 {
        self.squares(&self.made(0))
    }

    /// The square of one light's answers, shape [combinations, some], a combination.
    fn square(&self, answers: &[f32], light: usize) -> f64 {
        let own = answers.iter().skip(light).step_by(self.weights.len());
        own.map(|x| f64::from(*x).powi(2)).sum::<f64>() / COMBINATIONS as f64
    }

    /// The weighted sum of the squares of all lights' answers, a combination.
    fn squares(&self, answers: &[f32]) -> f64 {
        let weighted = |(x, w): (&f32, &f64)| w * f64::from(*x).powi(2);
        let rows = answers.chunks_exact(self.weights.len().max(1));
        let sum: f64 = rows
            .flat_map(|row| row.iter().zip(&self.weights).map(weighted))
            .sum();
        sum / COMBINATIONS as f64
    }

    /// A node's answer to the mean light, per watt of it, for each column of a matrix of shape
    /// [columns, width].
    fn per_watt(&self, node: u32, matrix: &[f32], width: usize) -> Vec<f64> {
        let (mut lit, mut even) = (vec![0.0f64; width], vec![0.0f64; width]);
        let (mut flux, mut area) = (0.0f64, 0.0f64);
        for &column in self.tree.columns_of(node) {
            let e = f64::from(self.lighting.mean[column as usize].x);
            let a = f64::from(self.tree.area(column));
            flux += a * e;
            area += a;
            let row = &matrix[column as usize * width..(column as usize + 1) * width];
            for ((lit, even), &w) in lit.iter_mut().zip(&mut even).zip(row) {
                *lit += f64::from(w) * e;
                *even += f64::from(w);
            }
        }
        // a cluster that no light of the ensemble reaches answers an even light
        let (sums, under) = if flux > 0.0 {
            (lit, flux)
        } else {
            (even, area)
        };
        let ratio = |sum: f64| if under > 0.0 { sum / under } else { 0.0 };
        sums.into_iter().map(ratio).collect()
    }

    /// A node with what its one weight gets wrong.
    fn open(&self, node: u32) -> Open {
        let mut wrong = self.made(node);
        let ratios = self.per_watt(node, &self.combined, COMBINATIONS);
        let some = self.lighting.some.len();
        let first = node as usize * some;
        let fluxes = &self.lighting.on_nodes[first..first + some];
        for (wrong, ratio) in wrong.chunks_exact_mut(some.max(1)).zip(ratios) {
            add(wrong, fluxes, -ratio as f32);
        }
        Open {
            error: self.squares(&wrong),
            wrong,
            node,
        }
    }

    /// A node's weight in each direction [1/W].
    fn weights(&self, node: u32) -> Vec<f32> {
        let weights = self.per_watt(node, &self.read.weights, self.read.rank);
        weights.into_iter().map(|w| w as f32).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bake::lighting::tests::even_lighting;
    use crate::patches::{PatchConfig, Patches};
    use glam::Vec3;
    use rrf_sampling::Stage;
    use rrf_scene::{LoadOptions, load};

    /// Clusters make of the ensemble's lights what the columns make of them, within the error asked
    /// for: by one direction, whose random combinations are all exact. They are fewer where more
    /// error is allowed, and all columns where none is.
    #[test]
    fn clusters_leave_out_what_they_may() {
        let file = "/../../scenes/cornell-box/scene.pbrt";
        let path = format!("{}{file}", env!("CARGO_MANIFEST_DIR"));
        let scene = load(path.as_ref(), &LoadOptions::default()).unwrap();
        let patches = Patches::new(&scene, &PatchConfig::default(), &|_| 1.0).unwrap();
        let tree = ColumnTree::new(&patches);
        let lighting = even_lighting(&patches, &tree);
        // a read that falls with the distance from a corner
        let corner = Vec3::new(-0.9, 0.1, -0.9);
        let weights = (0..patches.len() as u32).flat_map(|p| {
            let at = patches.centre[p as usize];
            let near = patches.area[p as usize] / (0.1 + at.distance_squared(corner));
            [near, 0.0]
        });
        let read = DenseRead {
            rank: 1,
            weights: weights.collect(),
        };
        let stream = Stream::new(3, Stage::Test, 0);
        let nodes = [0.1, 0.01, 0.0].map(|target| {
            let found = clustered(&read, &tree, &lighting, target, usize::MAX, stream);
            let mut answers = Vec::new();
            for &l in &lighting.some {
                let rows = lighting
                    .ensemble
                    .irradiance
                    .chunks(lighting.ensemble.lights);
                let light: Vec<Vec3> = rows.map(|row| Vec3::splat(row[l])).collect();
                let columns = read.weights.iter().zip(&light);
                let dense: f64 = columns.map(|(w, e)| f64::from(w * e.x)).sum();
                let made = f64::from(found.coefficients(&tree.fluxes(&light))[0].x);
                answers.push((made - dense, dense));
            }
            let squares: Vec<f64> = answers.iter().map(|a| a.1.powi(2)).collect();
            let weights = relative_weights(&squares);
            let sum = |of: &dyn Fn(&(f64, f64)) -> f64| -> f64 {
                let weighted = weights.iter().zip(&answers);
                weighted.map(|(w, a)| w * of(a).powi(2)).sum()
            };
            let (off, whole) = (sum(&|a| a.0), sum(&|a| a.1));
            // weights are off by half a 127th: a 280th of each answer, of a few that matter
            let limit = target.hypot(0.004);
            assert!((off / whole).sqrt() < limit, "{target}: {off} of {whole}");
            found.nodes.len()
        });
        assert!(
            nodes[0] < 60 && nodes[0] < nodes[1] && nodes[1] < nodes[2],
            "{nodes:?}"
        );
        // backs of patches are not read
        assert!(nodes[2] <= patches.len());
    }
}
