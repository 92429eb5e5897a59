//! `model/tree.arrow`.

use crate::error::StoreError;
use crate::table::Source;
use crate::table_row;
use rrf_field::columns::{COUNT, Columns, NAMES};
use rrf_field::tree::{Domain, LEAF, Tree};

table_row! {
    /// A node of the tree, as in `schemas/tree.toml`.
    #[derive(Clone, Debug)]
    pub(super) struct Node of Tree {
        node_id: u32,
        axis: i8,
        axis_name: Option<String>,
        threshold: Option<f32>,
        left: Option<u32>,
        right: Option<u32>,
        cell_id: Option<u32>,
        domain_min: Option<Vec<f32>>,
        domain_max: Option<Vec<f32>>,
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

    pub(super) fn to_rows(&self, source: Source) -> Result<Vec<Node>, StoreError> {
        self.validate(source)?;
        let tree = &self.tree;
        let bound = |domain: &Option<Domain>, of: fn(&Domain) -> &[f32; COUNT]| {
            domain.as_ref().map(|domain| of(domain).to_vec())
        };
        let node = |(id, domain): (usize, &Option<Domain>)| {
            let (axis, leaf) = (tree.axis[id], tree.axis[id] == LEAF);
            let name = NAMES.get(axis as usize).filter(|_| !leaf);
            Node {
                node_id: id as u32,
                axis,
                axis_name: name.map(|name| name.to_string()),
                threshold: (!leaf).then_some(tree.threshold[id]),
                left: (!leaf).then_some(tree.left[id]),
                right: (!leaf).then_some(tree.left[id].wrapping_add(1)),
                cell_id: leaf.then_some(tree.cell[id]),
                domain_min: bound(domain, |domain| &domain.minimum),
                domain_max: bound(domain, |domain| &domain.maximum),
            }
        };
        Ok(self.domains.iter().enumerate().map(node).collect())
    }

    pub(super) fn from_rows(nodes: Vec<Node>, source: Source) -> Result<Self, StoreError> {
        let mut all = ModelTree::default();
        for (id, node) in nodes.into_iter().enumerate() {
            let fail = |reason: String| source.model(format!("node {id}"), reason);
            if node.node_id as usize != id {
                return Err(fail(format!("its node_id is {}", node.node_id)));
            }
            let after = node.left.and_then(|left| left.checked_add(1));
            if node.axis != LEAF && (node.right.is_none() || node.right != after) {
                return Err(fail("right is not left + 1".into()));
            }
            all.tree.axis.push(node.axis);
            all.tree.threshold.push(node.threshold.unwrap_or(0.0));
            all.tree.left.push(node.left.unwrap_or(0));
            all.tree.cell.push(node.cell_id.unwrap_or(u32::MAX));
            all.domains.push(match (node.domain_min, node.domain_max) {
                (Some(min), Some(max)) => Some(domain(min, max).map_err(fail)?),
                (None, None) => None,
                _ => return Err(fail("half of a domain".into())),
            });
        }
        all.validate(source)?;
        Ok(all)
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
            let Some(Domain { minimum, maximum }) = domain else {
                continue;
            };
            let ordered = minimum.iter().zip(maximum).all(|(a, b)| a <= b);
            let finite = minimum.iter().chain(maximum).all(|x| x.is_finite());
            if axis != LEAF || !ordered || !finite {
                let reason = "a domain that is not finite, upside down, or not at a leaf";
                return Err(source.model(format!("node {node}"), reason));
            }
        }
        Ok(())
    }
}

fn domain(min: Vec<f32>, max: Vec<f32>) -> Result<Domain, String> {
    let wrong = |bound: Vec<f32>| format!("a domain has {} numbers, not {COUNT}", bound.len());
    Ok(Domain {
        minimum: min.try_into().map_err(wrong)?,
        maximum: max.try_into().map_err(wrong)?,
    })
}
