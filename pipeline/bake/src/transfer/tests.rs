//! Models come back from their tables with every bit.

use super::bake::make;
use super::config::TransferBakeConfig;
use super::ensemble::{conditions, light_stream};
use super::observer::Observer;
use super::read::model as read;
use super::space::FreeSpace;
use super::summary::TransferFacts;
use super::tables::tables;
use crate::settings::Preset;
use rrf_scene::{LoadOptions, Scene, load};
use rrf_store::manifest::RunFacts;
use rrf_store::model::{read_transfer, write_transfer};
use rrf_trace::Tracer;
use rrf_transfer::{PartFit, TransferModel};

fn made(
    scene: &Scene,
    unlit: &Scene,
    config: &TransferBakeConfig,
) -> (TransferModel, TransferFacts) {
    let tracer = Tracer::new(unlit).unwrap();
    let space = FreeSpace::new(unlit, &tracer, (None, config.narrow), config.seed).unwrap();
    let stream = light_stream(config.seed);
    let lights = conditions(unlit, &tracer, &space, config, stream).unwrap();
    let (model, lights) = make(scene, &space, &lights, config, &Observer::new(&(), None)).unwrap();
    let facts = TransferFacts {
        lights,
        ..TransferFacts::default()
    };
    (model, facts)
}

/// A glossy scene, so that viewers count and patches have directions, with finer patches in places.
#[test]
fn models_come_back_to_the_bit() {
    let file = "/../../scenes/cornell-glossy/cornell-glossy.glb";
    let path = format!("{}{file}", env!("CARGO_MANIFEST_DIR"));
    let scene = load(path.as_ref(), &LoadOptions::default()).unwrap();
    let unlit = scene.unlit();
    let mut config = TransferBakeConfig::preset(Preset::Preview, 3);
    (config.patches, config.rows, config.paths) = (100, 300, 32);
    (config.points, config.suns, config.skies) = (30, 4, 2);
    let (mut model, facts_made) = made(&scene, &unlit, &config);
    let is_net = |part: &PartFit| matches!(part, PartFit::Net(_));
    assert!(model.cells.iter().flat_map(|c| &c.parts).any(is_net));
    // of a cell that no row judged
    model.cells[0].error = f32::INFINITY;
    let folder = tempfile::tempdir().unwrap();
    let facts = RunFacts {
        scene_hash: scene.hash_hex(),
        seed: 3,
    };
    let written = tables(&model, &facts_made);
    write_transfer(folder.path(), &written, &facts).unwrap();
    let tables_read = read_transfer(folder.path(), &facts).unwrap();
    assert_eq!(tables_read, written);
    let back = read(folder.path(), &unlit, tables_read, false).unwrap();
    assert_eq!(tables(&back, &facts_made), written);
    let parts = |model: TransferModel| {
        (
            (model.tree, model.cells, model.sketch, model.columns),
            (model.used, model.reflectances, model.sizes),
            (model.receiver_points, model.seed, model.trust.to_bits()),
            (
                model.patches.area,
                model.patches.centre,
                model.patches.normal,
            ),
        )
    };
    assert_eq!(parts(back), parts(model));
}

/// Well-formed tables that are no model are refused with their place.
#[test]
fn tables_that_form_no_model_are_refused() {
    let path = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../scenes/cornell-box/scene.pbrt"
    );
    let scene = load(path.as_ref(), &LoadOptions::default()).unwrap();
    let unlit = scene.unlit();
    let mut config = TransferBakeConfig::preset(Preset::Preview, 1);
    (config.patches, config.rows, config.paths) = (60, 150, 16);
    (config.points, config.suns, config.skies) = (20, 0, 0);
    let (model, facts_made) = made(&scene, &unlit, &config);
    let good = tables(&model, &facts_made);
    let run = std::path::Path::new("run");
    read(run, &unlit, good.clone(), false).unwrap();
    let last = good.nodes.len() as u32;
    let branch = good.nodes.iter().position(|n| n.axis >= 0).unwrap();
    let net = good.parts.iter().position(|p| p.kind == "net").unwrap();
    type Change = Box<dyn Fn(&mut rrf_store::model::TransferTables)>;
    let changes: Vec<(&str, Change)> = vec![
        ("size_cubes", Box::new(|t| t.whole.size_cubes.push(1))),
        ("other patches", Box::new(|t| t.whole.structure.push('0'))),
        (
            "columns_in_use",
            Box::new(|t| t.whole.columns_in_use.push(1)),
        ),
        ("column tree", Box::new(|t| t.cells[0].nodes[0] = u32::MAX)),
        ("weights has", Box::new(|t| t.cells[0].rank += 1)),
        ("cell_id", Box::new(|t| t.cells[1].cell_id = 7)),
        (
            "sketch_scales",
            Box::new(|t| t.cells[0].sketch_scales[0] = f32::NAN),
        ),
        ("branch", Box::new(move |t| t.nodes[branch].below = Some(0))),
        (
            "branch",
            Box::new(move |t| t.nodes[branch].above = Some(last)),
        ),
        ("surface", Box::new(|t| t.nodes[0].back = None)),
        (
            "kind",
            Box::new(move |t| t.parts[net].kind = "spline".into()),
        ),
        (
            "part \"top\"",
            Box::new(move |t| t.parts[net].part = "top".into()),
        ),
        ("hidden", Box::new(move |t| t.parts[net].hidden.truncate(1))),
        ("output", Box::new(move |t| t.parts[net].output.truncate(1))),
        (
            "input \"lx\"",
            Box::new(move |t| t.parts[net].inputs[0] = "lx".into()),
        ),
        (
            "cell 99999",
            Box::new(move |t| t.parts[net].cell_id = 99_999),
        ),
    ];
    for (expected, change) in changes {
        let mut tables = good.clone();
        change(&mut tables);
        let Err(error) = read(run, &unlit, tables, false) else {
            panic!("{expected}: it is taken");
        };
        let error = error.to_string();
        assert!(error.contains(expected), "{expected}: {error}");
    }
}
