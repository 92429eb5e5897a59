//! `model/tree.arrow`.

use super::lists;
use crate::columns::Source;
use crate::error::StoreError;
use crate::schema::{self, Table};
use arrow::array::{Array, ArrayRef, Int8Array, StringArray, UInt32Array};
use arrow::array::{ArrowPrimitiveType, PrimitiveArray, RecordBatch};
use arrow::datatypes::{Float32Type, Int8Type, UInt32Type};
use rrf_field::columns::{COUNT, Columns, N, NAMES, V};
use rrf_field::tree::{LEAF, Tree};
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

const NODE_ID: &str = "node_id";
const AXIS: &str = "axis";
const AXIS_NAME: &str = "axis_name";
const THRESHOLD: &str = "threshold";
const LEFT: &str = "left";
const RIGHT: &str = "right";
const CELL_ID: &str = "cell_id";
const DOMAIN: [&str; 2] = ["domain_min", "domain_max"];

/// The box that a cell's training rows span, by raw column, in each column's unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Domain {
    /// Least values.
    pub min: [f32; COUNT],
    /// Greatest values.
    pub max: [f32; COUNT],
}

impl Domain {
    /// Whether a row lies in the box, widened by a hundredth of its extent: the outermost
    /// training rows stand a little inside the cell's border.
    pub fn holds(&self, row: &[f32; COUNT]) -> bool {
        (0..COUNT).filter(|c| !(N..V).contains(c)).all(|c| {
            let margin = 0.01 * (self.max[c] - self.min[c]) + 1e-5 * self.max[c].abs().max(1e-3);
            self.min[c] - margin <= row[c] && row[c] <= self.max[c] + margin
        })
    }
}

/// The kd-tree and what its cells have seen.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ModelTree {
    /// The tree.
    pub tree: Tree,
    /// A node's domain, as long as the tree; `None` at inner nodes and where unknown.
    pub domains: Vec<Option<Domain>>,
}

impl ModelTree {
    /// A tree whose domains are unknown.
    pub fn new(tree: Tree) -> ModelTree {
        let domains = vec![None; tree.axis.len()];
        ModelTree { tree, domains }
    }

    /// Node and cell of each leaf, by ascending node.
    pub fn leaves(&self) -> impl Iterator<Item = (usize, u32)> {
        let nodes = self.tree.axis.iter().zip(&self.tree.cell).enumerate();
        nodes.filter_map(|(node, (&axis, &cell))| (axis == LEAF).then_some((node, cell)))
    }

    /// Whether each row lies in the box that its cell's training rows span (point, viewer,
    /// light and material; a normal only turns within a cell, so its box says nothing).
    pub fn trusted(&self, rows: &Columns) -> Vec<bool> {
        let leaves = self.tree.leaves();
        let inside = |row: usize, cell: u32| {
            let domain = leaves
                .get(cell as usize)
                .and_then(|&leaf| self.domains.get(leaf)?.as_ref());
            domain.is_some_and(|d| d.holds(&rows.row(row)))
        };
        let cells = self.tree.find_all(rows);
        cells
            .into_iter()
            .enumerate()
            .map(|(row, cell)| inside(row, cell))
            .collect()
    }

    pub(super) fn to_batch(&self, path: &Path) -> Result<RecordBatch, StoreError> {
        self.validate(super::source(path, Table::Tree))?;
        let tree = &self.tree;
        let leaf: Vec<bool> = tree.axis.iter().map(|&axis| axis == LEAF).collect();
        let inner: Vec<bool> = leaf.iter().map(|leaf| !leaf).collect();
        let right: Vec<u32> = tree.left.iter().map(|left| left.wrapping_add(1)).collect();
        let names = tree.axis.iter().map(|&axis| name(axis)).collect::<Vec<_>>();
        let nodes = 0..u32::try_from(tree.axis.len()).unwrap_or(u32::MAX);
        let arrays: BTreeMap<&str, ArrayRef> = BTreeMap::from([
            (NODE_ID, Arc::new(UInt32Array::from_iter_values(nodes)) as _),
            (AXIS, Arc::new(Int8Array::from(tree.axis.clone())) as _),
            (AXIS_NAME, Arc::new(StringArray::from(names)) as _),
            (
                THRESHOLD,
                Arc::new(masked::<Float32Type>(&tree.threshold, &inner)) as _,
            ),
            (
                LEFT,
                Arc::new(masked::<UInt32Type>(&tree.left, &inner)) as _,
            ),
            (RIGHT, Arc::new(masked::<UInt32Type>(&right, &inner)) as _),
            (
                CELL_ID,
                Arc::new(masked::<UInt32Type>(&tree.cell, &leaf)) as _,
            ),
            (DOMAIN[0], self.bounds(|domain| &domain.min)),
            (DOMAIN[1], self.bounds(|domain| &domain.max)),
        ]);
        schema::table(Table::Tree)?.batch(arrays)
    }

    fn bounds(&self, bound: impl Fn(&Domain) -> &[f32; COUNT]) -> ArrayRef {
        let rows = self.domains.iter();
        lists::numbers::<Float32Type>(rows.map(|d| d.as_ref().map(|d| bound(d).as_slice())))
    }

    pub(super) fn from_batch(batch: &RecordBatch, source: Source) -> Result<Self, StoreError> {
        let ids = source.values::<UInt32Type>(batch, NODE_ID)?;
        let right = source.nullable::<UInt32Type>(batch, RIGHT)?;
        let tree = Tree {
            axis: source.values::<Int8Type>(batch, AXIS)?.to_vec(),
            threshold: filled(source.nullable::<Float32Type>(batch, THRESHOLD)?, 0.0),
            left: filled(source.nullable::<UInt32Type>(batch, LEFT)?, 0),
            cell: filled(source.nullable::<UInt32Type>(batch, CELL_ID)?, u32::MAX),
        };
        for (node, &id) in ids.iter().enumerate() {
            let place = || format!("node {node}");
            if id as usize != node {
                return Err(source.model(place(), format!("its node_id is {id}")));
            }
            let (leaf, left) = (tree.axis.get(node) == Some(&LEAF), tree.left.get(node));
            let after = left.and_then(|left| left.checked_add(1));
            if !leaf && (right.is_null(node) || Some(right.value(node)) != after) {
                return Err(source.model(place(), "right is not left + 1"));
            }
        }
        let domains = read_domains(batch, &source)?;
        let tree = ModelTree { tree, domains };
        tree.validate(source)?;
        Ok(tree)
    }

    /// A tree that any query leaves at exactly one leaf, and a domain for leaves only.
    fn validate(&self, source: Source) -> Result<(), StoreError> {
        let check = self.tree.check();
        check.map_err(|reason| source.model("tree".into(), reason))?;
        if self.domains.len() != self.tree.axis.len() {
            return Err(source.model("tree".into(), "not as many domains as nodes"));
        }
        self.validate_domains(source)
    }

    fn validate_domains(&self, source: Source) -> Result<(), StoreError> {
        for (node, (domain, &axis)) in self.domains.iter().zip(&self.tree.axis).enumerate() {
            let Some(Domain { min, max }) = domain else {
                continue;
            };
            let ordered = min.iter().zip(max).all(|(a, b)| a <= b);
            let finite = min.iter().chain(max).all(|x| x.is_finite());
            if axis != LEAF || !ordered || !finite {
                let reason = "a domain that is not finite, upside down, or not at a leaf";
                return Err(source.model(format!("node {node}"), reason));
            }
        }
        Ok(())
    }
}

fn name(axis: i8) -> Option<&'static str> {
    NAMES.get(usize::try_from(axis).ok()?).copied()
}

fn masked<T: ArrowPrimitiveType>(values: &[T::Native], there: &[bool]) -> PrimitiveArray<T> {
    let rows = values.iter().zip(there);
    rows.map(|(&value, &there)| there.then_some(value))
        .collect()
}

fn filled<T: ArrowPrimitiveType>(array: &PrimitiveArray<T>, absent: T::Native) -> Vec<T::Native> {
    array.iter().map(|value| value.unwrap_or(absent)).collect()
}

fn read_domains(batch: &RecordBatch, source: &Source) -> Result<Vec<Option<Domain>>, StoreError> {
    let [min, max] = DOMAIN.map(|name| lists::column(source, batch, name));
    let (min, max) = (min?, max?);
    (0..batch.num_rows())
        .map(|node| {
            let bounds = [(min, DOMAIN[0]), (max, DOMAIN[1])].map(|(lists, name)| {
                let row = lists::row::<Float32Type>(source, lists, name, node)?;
                row.map(|row| <[f32; COUNT]>::try_from(row).map_err(|row| row.len()))
                    .transpose()
                    .map_err(|n| {
                        let reason = format!("{name} has {n} numbers, not {COUNT}");
                        source.model(format!("node {node}"), reason)
                    })
            });
            let [min, max] = bounds;
            match (min?, max?) {
                (Some(min), Some(max)) => Ok(Some(Domain { min, max })),
                (None, None) => Ok(None),
                _ => Err(source.model(format!("node {node}"), "half of a domain")),
            }
        })
        .collect()
}
