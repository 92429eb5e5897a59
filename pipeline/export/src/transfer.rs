//! A transfer and some lights as one safetensors file.
//!
//! | tensor | type, shape | what |
//! |---|---|---|
//! | `light.irradiance` | f32 \[lights, columns, 3\] | irradiance of every column by each light of the list `lights` of the metadata \[W/m²\] |
//! | `light.residual` | f32 \[lights\] | share of the light that the cells leave out |
//! | `column.area` | f32 \[columns\] | area of its patch \[m²\] |
//! | `column.position`, `column.normal`, `column.direction` | f32 \[columns, 3\] | the patch's middle, the normal of its side, and the way that its light comes from where `column.directions` is above 1 |
//! | `column.directions` | u32 \[columns\] | columns of that side of the patch |
//! | `node.columns`, `node.range` | u32 \[columns\], \[nodes, 2\] | node n has the columns `node.columns[range[n, 0]:range[n, 1]]` |
//! | `albedo` | f32 \[materials, cosines, 2\] | base and constant directional albedo at cosines from 0 to 1 |
//! | `tree.surface` | u32 \[surfaces, 4\] | object, material, whether it is the back, first node |
//! | `tree.axis` | i32 \[nodes\] | 0 to 2 position, 3 to 5 geometric normal on the viewer's side; -1 at a leaf |
//! | `tree.threshold` | f32 \[nodes\] | smaller coordinates go below |
//! | `tree.children` | u32 \[nodes, 2\] | below and above; at a leaf its cell, and 0 |
//! | `cell.N.nodes`, `cell.N.read` | u32 \[n\], f32 \[n, K\] | coefficients c = sum over nodes of read times the node's flux |
//! | `cell.N.PART.inputs` | u8 \[inputs\] | places in the list `inputs` of the metadata; PART is base or constant |
//! | `cell.N.PART.mean`, `.scale`, `.low`, `.high` | f32 \[inputs\] | x = clip((input - mean) * scale, low, high) |
//! | `cell.N.PART.hidden` | f32 \[units, inputs + 1\] | the constant last; tanh |
//! | `cell.N.PART.output` | f32 \[1 + inputs + units, K, 3\] | of 1, the inputs and the units |
//! | `cell.N.PART.turns` | f32 \[2\] | of local fits in place of a net: metres that a turn of the normal and of the mirrored viewer are worth |
//! | `cell.N.PART.places`, `.normals` | f32 \[n, 9\], \[n, 3\] | position, shading normal and mirrored viewer of each; its geometric normal |
//! | `cell.N.PART.values` | f32 \[n, 3, K, 3\] | value and slopes along both tangents [1/m] |
//!
//! A node's flux is the sum of area times irradiance over its columns. Outputs and values are contracted with c, a channel each;
//! radiance is the base colour times base albedo times base part, plus constant albedo times constant part.
//! `docs/guide/relight.py` is that in numpy.

use crate::ExportError;
use crate::tensor_file::{Tensor, floats, ids, write_tensors};
use glam::Vec3;
use rrf_transfer::{COSINES, LEAF_AXIS, PackedNumber, PackedRows, PartFit, TransferModel};
use safetensors::tensor::Dtype;
use std::path::Path;

/// Names of the numbers that a net can see: position, shading normal, mirrored viewer.
const INPUTS: &str = "px py pz nx ny nz rx ry rz";

/// A light as an exported transfer knows it.
#[derive(Clone, Debug)]
pub struct TensorLight {
    /// Its name.
    pub name: String,
    /// Irradiance of every column [W/m²].
    pub irradiance: Vec<Vec3>,
    /// Share of its light that the cells leave out.
    pub residual: f32,
}

/// Writes a transfer with lights; `facts` go into the metadata beside the lists of names.
///
/// # Errors
/// [`ExportError::Write`].
pub fn write_transfer_tensors(
    path: &Path,
    model: &TransferModel,
    lights: &[TensorLight],
    facts: &[(&str, String)],
) -> Result<(), ExportError> {
    let mut tensors = light_tensors(lights, model.patches.columns());
    tensors.extend(column_tensors(model));
    tensors.extend(tree_tensors(model));
    for (id, cell) in model.cells.iter().enumerate() {
        let read = &cell.read;
        let shape = vec![read.nodes.len(), read.rank()];
        tensors.push(ids(
            &format!("cell.{id}.nodes"),
            vec![read.nodes.len()],
            &read.nodes,
        ));
        tensors.push(floats(
            &format!("cell.{id}.read"),
            shape,
            &unpacked(&read.weights),
        ));
        for (name, part) in ["base", "constant"].iter().zip(&cell.parts) {
            tensors.extend(part_tensors(
                &format!("cell.{id}.{name}"),
                part,
                read.rank(),
            ));
        }
    }
    let names: Vec<&str> = lights.iter().map(|light| light.name.as_str()).collect();
    let names = [
        ("format", "rrf-transfer-1".into()),
        ("inputs", INPUTS.into()),
        ("lights", serde_json::Value::from(names).to_string()),
    ];
    write_tensors(path, &tensors, facts.iter().cloned().chain(names))
}

fn light_tensors(lights: &[TensorLight], columns: usize) -> Vec<Tensor> {
    let irradiance = lights.iter().flat_map(|light| vectors(&light.irradiance));
    let irradiance: Vec<f32> = irradiance.collect();
    let residual: Vec<f32> = lights.iter().map(|light| light.residual).collect();
    vec![
        floats(
            "light.irradiance",
            vec![lights.len(), columns, 3],
            &irradiance,
        ),
        floats("light.residual", vec![lights.len()], &residual),
    ]
}

fn column_tensors(model: &TransferModel) -> Vec<Tensor> {
    let (patches, tree) = (&model.patches, &model.columns);
    let columns = patches.columns();
    let (mut normals, mut directions) = (vec![Vec3::ZERO; columns], vec![Vec3::ZERO; columns]);
    let (mut positions, mut counts) = (vec![Vec3::ZERO; columns], vec![0; columns]);
    for patch in 0..patches.len() as u32 {
        for back in [false, true] {
            let normal = patches.normal[patch as usize];
            let normal = if back { -normal } else { normal };
            let count = patches.directions(patch).pow(2);
            let first = patches.first_column(patch, back);
            for cell in 0..count {
                let column = (first + cell) as usize;
                positions[column] = patches.centre[patch as usize];
                normals[column] = normal;
                directions[column] = patches.middle_direction(patch, normal, cell);
                counts[column] = count;
            }
        }
    }
    let area: Vec<f32> = (0..columns as u32).map(|c| tree.area(c)).collect();
    // the first node has all of them, in the order in which each node's lie together
    let order = if tree.is_empty() {
        &[]
    } else {
        tree.columns_of(0)
    };
    let mut places = vec![0u32; columns];
    (0u32..)
        .zip(order)
        .for_each(|(place, &c)| places[c as usize] = place);
    let ranges = (0..tree.len() as u32).flat_map(|node| {
        let own = tree.columns_of(node);
        let first = own.first().map_or(0, |&c| places[c as usize]);
        [first, first + own.len() as u32]
    });
    let ranges: Vec<u32> = ranges.collect();
    let three = |name: &str, values: &[Vec3]| {
        let values: Vec<f32> = vectors(values).collect();
        floats(name, vec![columns, 3], &values)
    };
    vec![
        floats("column.area", vec![columns], &area),
        three("column.position", &positions),
        three("column.normal", &normals),
        three("column.direction", &directions),
        ids("column.directions", vec![columns], &counts),
        ids("node.columns", vec![columns], order),
        ids("node.range", vec![tree.len(), 2], &ranges),
    ]
}

fn tree_tensors(model: &TransferModel) -> Vec<Tensor> {
    let albedos = &model.reflectances.albedos;
    let albedo: Vec<f32> = albedos.iter().flatten().copied().collect();
    let (roots, nodes) = (&model.tree.roots, &model.tree.nodes);
    let surfaces = roots.iter().flat_map(|(key, root)| {
        let back = u32::from(key.back);
        [key.object, key.material, back, *root]
    });
    let surfaces: Vec<u32> = surfaces.collect();
    let axis = nodes.iter().flat_map(|node| {
        let axis = if node.axis == LEAF_AXIS {
            -1
        } else {
            i32::from(node.axis)
        };
        axis.to_le_bytes()
    });
    let threshold: Vec<f32> = nodes.iter().map(|node| node.at).collect();
    let children = nodes.iter().flat_map(|node| [node.below, node.above]);
    let children: Vec<u32> = children.collect();
    vec![
        floats("albedo", vec![albedos.len() / COSINES, COSINES, 2], &albedo),
        ids("tree.surface", vec![roots.len(), 4], &surfaces),
        (
            "tree.axis".into(),
            Dtype::I32,
            vec![nodes.len()],
            axis.collect(),
        ),
        floats("tree.threshold", vec![nodes.len()], &threshold),
        ids("tree.children", vec![nodes.len(), 2], &children),
    ]
}

fn part_tensors(name: &str, part: &PartFit, rank: usize) -> Vec<Tensor> {
    let of = |what: &str, shape: Vec<usize>, values: &[f32]| {
        floats(&format!("{name}.{what}"), shape, values)
    };
    match part {
        PartFit::Nothing => Vec::new(),
        PartFit::Net(net) => {
            let inputs = net.inputs.len();
            let places = (
                format!("{name}.inputs"),
                Dtype::U8,
                vec![inputs],
                net.inputs.clone(),
            );
            let output = vec![net.features(), rank, 3];
            vec![
                places,
                of("mean", vec![inputs], &net.mean),
                of("scale", vec![inputs], &net.scale),
                of("low", vec![inputs], &net.low),
                of("high", vec![inputs], &net.high),
                of("hidden", vec![net.units(), inputs + 1], &net.hidden),
                of("output", output, &unpacked(&net.output)),
            ]
        }
        PartFit::Nodes(nodes) => vec![
            of("turns", vec![2], &nodes.turns),
            of("places", vec![nodes.len(), 9], &nodes.places),
            of("normals", vec![nodes.len(), 3], &nodes.normals),
            of(
                "values",
                vec![nodes.len(), 3, rank, 3],
                &unpacked(&nodes.values),
            ),
        ],
    }
}

/// The numbers that rows stand for.
fn unpacked<T: PackedNumber>(rows: &PackedRows<T>) -> Vec<f32> {
    let own = rows
        .values
        .chunks_exact(rows.width.max(1))
        .zip(&rows.scales);
    own.flat_map(|(row, scale)| row.iter().map(move |&x| x.into() * scale))
        .collect()
}

fn vectors(values: &[Vec3]) -> impl Iterator<Item = f32> + '_ {
    values.iter().flat_map(|v| v.to_array())
}
